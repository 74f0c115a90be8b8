#ifndef HFH_BENCH_DEPENDENT_EVALUATION_HPP
#define HFH_BENCH_DEPENDENT_EVALUATION_HPP

#include "run.hpp"
#include "terrain.hpp"

#include <cmath>
#include <cstdint>

// The yardstick of the other times: height and normal of one patch, where each patch is chosen by the last answer, so
// that nothing overlaps. A machine that is twice as fast is so for an update as well; the ratio of the two stays.

namespace hfh::bench {

/// That chain, on `size` × `size` cells in the middle of a terrain; 0: on all of it. All cells are visited at random.
template <Real T>
class DependentEvaluation {
public:
    DependentEvaluation(const Terrain& terrain, Index size)
        : terrain_{&terrain}, grid_{terrain.template grid<T>()}, columns_{size > 0
                                                                              ? size
                                                                              : terrain.kind.columns - 1},
          rows_{size > 0 ? size : terrain.kind.rows - 1}, first_{(terrain.kind.columns - 1 - columns_) / 2,
                                                                 (terrain.kind.rows - 1 - rows_) / 2} {}

    /// One evaluation. False if there is no patch.
    [[nodiscard]] bool step() noexcept {
        const auto patch = grid_.patch(cell());
        if (!patch) return false;
        const T height = patch->height(u_, T(1) - u_);
        const vec3<T> normal = patch->normal(u_, T(1) - u_);
        key_ =
            (key_ ^ bits(height) ^ bits(normal.x) ^ bits(normal.y) ^ bits(normal.z)) * 0xbf58'476d'1ce4'e5b9u;
        u_ = u_ < T(1) ? u_ + T(1) / 64 : T(0); // not of the last answer
        return true;
    }
    /// What the chain has come to.
    [[nodiscard]] std::uint64_t key() const noexcept { return key_; }

    /// Whether the same evaluation, where the chain is now, agrees with the samples.
    [[nodiscard]] bool right() const noexcept {
        const Cell at = cell();
        const auto patch = grid_.patch(at);
        const double x = (static_cast<double>(at.i) + 0.25) * terrain_->kind.spacing.x,
                     y = (static_cast<double>(at.j) + 0.75) * terrain_->kind.spacing.y;
        const double off = static_cast<double>(patch->height(T(0.25), T(0.75))) - terrain_->surface(x, y);
        return std::abs(off) <= 8 * static_cast<double>(epsilon<T>) * terrain_->kind.highest;
    }

private:
    [[nodiscard]] Cell cell() const noexcept { // both counts are below 2¹⁶
        const auto part = [](std::uint64_t share, Index of) {
            return static_cast<Index>(share * static_cast<std::uint64_t>(of) >> 16);
        };
        return {first_.i + part(key_ >> 48, columns_), first_.j + part(key_ >> 32 & 0xffffu, rows_)};
    }
    [[nodiscard]] static std::uint64_t bits(T answer) noexcept {
        return std::bit_cast<std::uint64_t>(static_cast<double>(answer));
    }

    const Terrain* terrain_;
    Terrain::Grid<T> grid_;
    Index columns_, rows_;
    Cell first_;
    std::uint64_t key_ = 0x9e37'79b9'7f4a'7c15u;
    T u_ = 0;
};

/// A benchmark of it.
template <Real T>
void dependent_evaluation(benchmark::State& state, const Terrain& terrain, Index size) {
    DependentEvaluation<T> made{terrain, size};
    benchmark::DoNotOptimize(made); // a frame that is not known while compiling, as a tracker sees it
    auto chain = made;              // a copy that nothing else can see stays in registers
    for (auto _ : state) {
        if (!chain.step()) return fail(state, "there is no patch");
    }
    benchmark::DoNotOptimize(chain.key());
    state.SetLabel(terrain.label());
    if (!chain.right()) fail(state, "the height is wrong");
}

} // namespace hfh::bench

#endif // HFH_BENCH_DEPENDENT_EVALUATION_HPP
