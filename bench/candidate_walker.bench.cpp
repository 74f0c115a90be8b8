#include "run.hpp"
#include "segments.hpp"

#include <hfh/traversal/candidate_walker.hpp>

namespace hfh::bench {
namespace {

/// How many cells lie under a segment that goes through no vertex and along no line: one, and one more for every grid
/// line between its ends.
Index cells_under(const Terrain& terrain, const Segment& s) {
    const auto lines = [](double a, double b, double spacing) {
        return std::abs(static_cast<Index>(std::floor(b / spacing)) -
                        static_cast<Index>(std::floor(a / spacing)));
    };
    return 1 + lines(s.a.x, s.b.x, terrain.kind.spacing.x) + lines(s.a.y, s.b.y, terrain.kind.spacing.y);
}

/// Every cell under the segment.
void walk(benchmark::State& state, const Terrain& terrain, double length) {
    const auto queries = segments(terrain, 1024, length);
    const auto grid = terrain.grid<double>();
    const Lattice lattice = grid.lattice();
    const CellRange cells = grid.cells();
    Index visited = 0;
    for (const auto& q : queries) {
        Index here = 0;
        Cell last{};
        bool joined = true;
        walk_cells(lattice, cells, {q.a.x, q.a.y}, {q.b.x, q.b.y}, [&](const CellSpan& span) {
            joined =
                joined && (here == 0 || std::abs(span.cell.i - last.i) + std::abs(span.cell.j - last.j) == 1);
            last = span.cell;
            ++here;
            return true;
        });
        if (!joined || here != cells_under(terrain, q)) {
            return fail(state, "cells were missed or visited twice");
        }
        visited += here;
    }
    while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(queries.size()))) {
        for (const auto& q : queries) {
            walk_cells(lattice, cells, {q.a.x, q.a.y}, {q.b.x, q.b.y}, [](const CellSpan& span) {
                benchmark::DoNotOptimize(span);
                return true;
            });
        }
    }
    state.counters["cells"] = static_cast<double>(visited) / static_cast<double>(queries.size());
    state.SetLabel(terrain.label());
}

/// The candidates alone: the patches that the segment may touch by their height.
template <Real T>
void candidates(benchmark::State& state, const Terrain& terrain, double length) {
    const auto queries = segments(terrain, 1024, length);
    const auto grid = terrain.template grid<T>();
    Index found = 0;
    for (const auto& q : queries) {
        Cell last{-1, -1};
        const vec3<T> a{q.a}, b{q.b};
        walk_candidates(grid, a, b, [&](const CellSpan& span, const BilinearPatch<T>&) {
            last = span.cell;
            ++found;
            return true;
        });
        const Cell end{static_cast<Index>(std::floor(q.b.x / terrain.kind.spacing.x)),
                       static_cast<Index>(std::floor(q.b.y / terrain.kind.spacing.y))};
        // A segment that ends below the surface has a candidate there. (In float the end may round across a line.)
        const bool ends_below = terrain.surface(q.b.x, q.b.y) > q.b.z;
        if (std::is_same_v<T, double> && ends_below && last != end) {
            return fail(state, "a candidate was missed");
        }
    }
    while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(queries.size()))) {
        for (const auto& q : queries) {
            walk_candidates(grid, vec3<T>{q.a}, vec3<T>{q.b},
                            [](const CellSpan& span, const BilinearPatch<T>& patch) {
                                benchmark::DoNotOptimize(span);
                                benchmark::DoNotOptimize(patch);
                                return true;
                            });
        }
    }
    state.counters["candidates"] = static_cast<double>(found) / static_cast<double>(queries.size());
    state.SetLabel(terrain.label());
}

} // namespace

void register_benchmarks() {
    for (const TerrainKind& kind : {small_hills, large_hills}) {
        const std::string ground = kind.name;
        for (std::size_t l = 0; l < std::size(segment_lengths); ++l) {
            const double length = segment_lengths[l];
            const std::string of = std::string{segment_names[l]} + "/" + ground;
            add("candidate_walker/cells_" + of,
                [=](benchmark::State& state) { walk(state, terrain(kind), length); });
            add("candidate_walker/candidates_" + of + "/double",
                [=](benchmark::State& state) { candidates<double>(state, terrain(kind), length); });
            add("candidate_walker/candidates_" + of + "/float",
                [=](benchmark::State& state) { candidates<float>(state, terrain(kind), length); });
        }
    }
}

} // namespace hfh::bench
