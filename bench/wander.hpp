#ifndef HFH_BENCH_WANDER_HPP
#define HFH_BENCH_WANDER_HPP

#include "../tests/support/random.hpp"
#include "terrain.hpp"

#include <numbers>

namespace hfh::bench {

using test::Random;

/// A path over the ground as a hand might take it, `count` points `step` cells apart (in plan; a cell is dx along x and
/// dy along y). It turns as it goes, into a new direction every 20 cells or so, and stays 16 cells off the border. It
/// begins in the middle, or anywhere but in the outer share `from` of each side.
template <class Ground>
[[nodiscard]] std::vector<glm::dvec2> wander(const Ground& terrain, std::size_t count, double step,
                                             std::uint64_t seed = 1, double from = 0.3) {
    constexpr double margin = 16;
    const double width = static_cast<double>(terrain.kind.columns - 1),
                 depth = static_cast<double>(terrain.kind.rows - 1);
    Random random{seed};
    double u = width * random.between(from, 1 - from), v = depth * random.between(from, 1 - from);
    u = std::clamp(u, margin, width - margin);
    v = std::clamp(v, margin, depth - margin);
    double heading = random.between(0, 2 * std::numbers::pi);
    std::vector<glm::dvec2> path;
    path.reserve(count);
    while (path.size() < count) {
        path.push_back({u * terrain.kind.spacing.x, v * terrain.kind.spacing.y});
        heading += random.between(-1, 1) * 0.4 * std::sqrt(step);
        const double to_u = u + step * std::cos(heading), to_v = v + step * std::sin(heading);
        if (to_u < margin || to_u > width - margin) heading = std::numbers::pi - heading;
        if (to_v < margin || to_v > depth - margin) heading = -heading;
        u += step * std::cos(heading);
        v += step * std::sin(heading);
    }
    return path;
}

} // namespace hfh::bench

#endif // HFH_BENCH_WANDER_HPP
