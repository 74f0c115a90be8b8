#include "race.hpp"
#include "strokes.hpp"
#include "text.hpp"

#include <hfh/terrain/blended_field.hpp>

// An update on a blended level against one on a grid of the same lattice.

namespace hfh::bench {
namespace {

constexpr std::size_t updates_a_stroke = 20'000, updates_a_slice = 1'000;
constexpr int rounds = 40;

constexpr Stroke strokes[] = {
    {"sliding 0.1", Way::sliding, 0.1, 0.5}, {"sliding 0.5", Way::sliding, 0.5, 0.5},
    {"sliding 2", Way::sliding, 2, 0.5},     {"free 0.1", Way::flying, 0.1, 0},
    {"free 0.5", Way::flying, 0.5, 0},       {"free 5", Way::flying, 5, 0},
};

using Heights = HeightView<std::int16_t>;
template <Real T>
using Blended = BlendedField<T, StridedLevels<Heights>>;

/// A terrain at level k blended with the next, worked out sample by sample: what the paths and the checks go by.
struct LevelGround {
    const Terrain& terrain;
    int k;
    double alpha;
    TerrainKind kind = [this] {
        TerrainKind level = terrain.kind;
        level.columns = ((level.columns - 1) >> k) + 1;
        level.rows = ((level.rows - 1) >> k) + 1;
        level.spacing *= static_cast<double>(1 << k);
        return level;
    }();
    double steepest = terrain.steepest;

    [[nodiscard]] double cell() const noexcept { return std::sqrt(kind.spacing.x * kind.spacing.y); }
    [[nodiscard]] double sample(Index i, Index j) const noexcept {
        const auto fine = [&](Index a, Index b) { return terrain.sample(a << k, b << k); };
        const Index i1 = i + (i & 1), i0 = i - (i & 1), j1 = j + (j & 1), j0 = j - (j & 1);
        if (i1 >= kind.columns || j1 >= kind.rows) return fine(i, j);
        const double mean = (fine(i0, j0) + fine(i1, j0) + fine(i0, j1) + fine(i1, j1)) / 4;
        return (1 - alpha) * fine(i, j) + alpha * mean;
    }
    [[nodiscard]] double surface(double x, double y) const noexcept { return bilinear_height(*this, x, y); }

    template <Real T>
    using Grid = Blended<T>;
    template <Real T>
    [[nodiscard]] Blended<T> grid() const noexcept {
        Blended<T> field{StridedLevels<Heights>{terrain.grid<T>().heights()},
                         {.spacing = terrain.kind.spacing}};
        field.blend(k, alpha);
        return field;
    }
};

/// The same without blending: a grid over every 2ᵏ-th sample.
struct PlainGround : LevelGround {
    PlainGround(const Terrain& of, int level) : LevelGround{of, level, 0} {}

    template <Real T>
    using Grid = BilinearGrid<T, Heights>;
    template <Real T>
    [[nodiscard]] Grid<T> grid() const noexcept {
        return {subsampled(terrain.grid<T>().heights(), k), {.spacing = kind.spacing}};
    }
};

template <Real T>
void measure(const char* scalar, int k, Findings& found) {
    const Terrain& ground = terrain(large_hills);
    const PlainGround plain{ground, k};
    const LevelGround blended{ground, k, 0.375};
    std::vector<Trace<T>> traces;
    for (const auto& stroke : strokes) {
        traces.push_back(stroke_trace<T>(plain, stroke, updates_a_stroke, updates_a_slice));
        traces.push_back(stroke_trace<T>(blended, stroke, updates_a_stroke, updates_a_slice));
        const std::string what = std::string{stroke.name} + " on level " + std::to_string(k);
        (void)check_trace(plain, traces[traces.size() - 2], what);
        (void)check_trace(blended, traces.back(), what + ", blended");
    }
    std::vector<Runner> runners;
    for (std::size_t s = 0; s < std::size(strokes); ++s) {
        runners.push_back(updates(plain, traces[2 * s]));
        runners.push_back(updates(blended, traces[2 * s + 1]));
    }
    const auto paces = race(runners, rounds);
    for (std::size_t s = 0; s < std::size(strokes); ++s) {
        const double one = paces[2 * s].fastest, ours = paces[2 * s + 1].fastest;
        found.numbers.push_back({"blending",
                                 std::string{strokes[s].name} + ", level " + std::to_string(k) + scalar,
                                 ours / one,
                                 {one, ours}});
    }
}

} // namespace

Findings blended_levels(const Settings&) {
    Findings found;
    for (const int k : {0, 2}) {
        measure<double>("", k, found);
        measure<float>(", float", k, found);
    }
    return found;
}

} // namespace hfh::bench
