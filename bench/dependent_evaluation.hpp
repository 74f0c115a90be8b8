#ifndef HFH_BENCH_DEPENDENT_EVALUATION_HPP
#define HFH_BENCH_DEPENDENT_EVALUATION_HPP

#include "run.hpp"
#include "terrain.hpp"

#include <cmath>
#include <cstdint>

// The yardstick of the other times: height and normal of one patch, where each patch is chosen by the last answer, so
// that nothing overlaps. A machine that is twice as fast is so for an update as well; the ratio of the two stays.

namespace hfh::bench {

/// A benchmark of that chain, on `size` × `size` cells in the middle of a terrain; 0: on all of it. All cells are
/// visited at random.
template <Real T>
void dependent_evaluation(benchmark::State& state, const Terrain& terrain, Index size) {
    const auto grid = terrain.template grid<T>();
    const Index columns = size > 0 ? size : terrain.kind.columns - 1;
    const Index rows = size > 0 ? size : terrain.kind.rows - 1;
    const Cell first{(terrain.kind.columns - 1 - columns) / 2, (terrain.kind.rows - 1 - rows) / 2};
    const auto cell_of = [&](std::uint64_t key) { // both counts are below 2¹⁶
        return Cell{first.i + static_cast<Index>((key >> 48) * static_cast<std::uint64_t>(columns) >> 16),
                    first.j +
                        static_cast<Index>((key >> 32 & 0xffffu) * static_cast<std::uint64_t>(rows) >> 16)};
    };
    const auto bits = [](T answer) { return std::bit_cast<std::uint64_t>(static_cast<double>(answer)); };

    std::uint64_t key = 0x9e37'79b9'7f4a'7c15u;
    T u = 0;
    for (auto _ : state) {
        const auto patch = grid.patch(cell_of(key));
        if (!patch) return fail(state, "there is no patch");
        const T height = patch->height(u, T(1) - u);
        const vec3<T> normal = patch->normal(u, T(1) - u);
        key =
            (key ^ bits(height) ^ bits(normal.x) ^ bits(normal.y) ^ bits(normal.z)) * 0xbf58'476d'1ce4'e5b9u;
        u = u < T(1) ? u + T(1) / 64 : T(0); // not of the last answer
    }
    benchmark::DoNotOptimize(key);
    state.SetLabel(terrain.label());

    // The same evaluation, against the samples.
    const Cell cell = cell_of(key);
    const auto patch = grid.patch(cell);
    const double x = (static_cast<double>(cell.i) + 0.25) * terrain.kind.spacing.x,
                 y = (static_cast<double>(cell.j) + 0.75) * terrain.kind.spacing.y;
    const double off = static_cast<double>(patch->height(T(0.25), T(0.75))) - terrain.surface(x, y);
    if (!(std::abs(off) <= 8 * static_cast<double>(epsilon<T>) * terrain.kind.highest)) {
        fail(state, "the height is wrong");
    }
}

} // namespace hfh::bench

#endif // HFH_BENCH_DEPENDENT_EVALUATION_HPP
