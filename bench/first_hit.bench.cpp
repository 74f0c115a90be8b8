#include "run.hpp"
#include "segments.hpp"

#include <hfh/traversal/first_hit.hpp>

namespace hfh::bench {
namespace {

/// Whether `hit` is the first crossing, by looking at the segment in steps of 1/64 of a cell.
template <Real T>
bool is_first_crossing(const Terrain& terrain, const Segment& s, double length, const FirstHit<T>& hit) {
    const auto height_over = [&](double t) {
        const glm::dvec3 at = s.a + t * (s.b - s.a);
        return at.z - terrain.surface(at.x, at.y);
    };
    // Float heights are rounded samples; t is double whatever the scalar.
    const double tolerance = 64 * static_cast<double>(epsilon<T>) * terrain.kind.highest;
    const bool found = hit.status == HitStatus::hit;
    if (found && !(std::abs(height_over(hit.t)) <= tolerance)) return false;
    if (!found && !(height_over(1) >= -tolerance)) return false;
    const double searched = found ? hit.t : 1;
    const int steps = 8 + static_cast<int>(64 * length);
    for (int k = 0; k < steps; ++k) {
        if (height_over(searched * static_cast<double>(k) / steps) < -tolerance) return false;
    }
    return true;
}

template <Real T>
void cast(benchmark::State& state, const Terrain& terrain, double length) {
    const auto queries = segments(terrain, 1024, length);
    const auto grid = terrain.template grid<T>();
    double cells = 0, hits = 0;
    for (std::size_t k = 0; k < queries.size(); ++k) {
        const auto& q = queries[k];
        const auto hit = first_hit(grid, q.a, q.b);
        cells += static_cast<double>(hit.cells);
        hits += hit.status == HitStatus::hit ? 1 : 0;
        const bool must_hit = terrain.surface(q.b.x, q.b.y) > q.b.z;
        if ((must_hit && hit.status != HitStatus::hit) || !is_first_crossing(terrain, q, length, hit)) {
            return fail(state, "not the first crossing");
        }
    }
    while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(queries.size()))) {
        for (const auto& q : queries) benchmark::DoNotOptimize(first_hit(grid, q.a, q.b));
    }
    state.counters["cells"] = cells / static_cast<double>(queries.size());
    state.counters["hit_share"] = hits / static_cast<double>(queries.size());
    state.SetLabel(terrain.label());
}

} // namespace

void register_benchmarks() {
    for (const TerrainKind& kind : all_terrains()) {
        for (std::size_t l = 0; l < std::size(segment_lengths); ++l) {
            const double length = segment_lengths[l];
            const std::string name =
                "first_hit/cells_" + std::string{segment_names[l]} + "/" + kind.name + "/";
            add(name + "double",
                [=](benchmark::State& state) { cast<double>(state, terrain(kind), length); });
            add(name + "float", [=](benchmark::State& state) { cast<float>(state, terrain(kind), length); });
        }
    }
}

} // namespace hfh::bench
