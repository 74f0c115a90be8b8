#ifndef HFH_BENCH_CLOSED_LOOP_GROUNDS_HPP
#define HFH_BENCH_CLOSED_LOOP_GROUNDS_HPP

#include "real_terrains.hpp"

#include <string>
#include <vector>

// What is touched: simple shapes and every real terrain at hand, all made so small that a cell measures the same in the
// hand.

namespace closed_loop {

using hfh::Index;
using hfh::Real;

template <Real T>
struct Ground {
    std::string name;
    hfh::test::Terrain<T> terrain;
    bool real = false;
};

/// The same ground with `cell` metres from sample to sample (the geometric mean of the two spacings).
template <Real T>
[[nodiscard]] hfh::test::Terrain<T> resized(hfh::test::Terrain<T> terrain, double cell) {
    const double scale = cell / std::sqrt(terrain.frame.spacing.x * terrain.frame.spacing.y);
    terrain.frame.spacing *= scale;
    for (T& height : terrain.heights) height = static_cast<T>(scale * static_cast<double>(height));
    return terrain;
}

inline constexpr std::size_t shapes = 4; ///< before the real ones

/// Shapes of 400 × 400 samples: slopes of 27° at the ridge and in the valley, from none in the middle of the saddle to
/// 70° in its corners. Then the real terrains, those with holes last, if they are there.
template <Real T>
[[nodiscard]] std::vector<Ground<T>> grounds(double cell) {
    using namespace hfh::test;
    constexpr Index size = 400;
    std::vector<Ground<T>> all;
    all.push_back({"plane", plane<T>(size, size)});
    all.push_back({"saddle", saddle<T>(size, size, 0.01)});
    all.push_back({"ridge", ridge<T>(size, size, 0.5)});
    all.push_back({"valley", valley<T>(size, size, 0.5)});
    for (const auto& names : {real_terrains_without_holes, real_terrains_with_holes}) {
        for (const auto& name : names) {
            if (auto terrain = real_terrain<T>(name)) all.push_back({name, *std::move(terrain), true});
        }
    }
    for (auto& ground : all) ground.terrain = resized(std::move(ground.terrain), cell);
    return all;
}

} // namespace closed_loop

#endif // HFH_BENCH_CLOSED_LOOP_GROUNDS_HPP
