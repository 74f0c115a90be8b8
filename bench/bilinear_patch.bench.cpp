#include "dependent_evaluation.hpp"
#include "wander.hpp"

namespace hfh::bench {
namespace {

/// Evaluations that do not wait for each other, along a path.
template <Real T>
void independent_evaluation(benchmark::State& state, const Terrain& terrain) {
    struct Query {
        Cell cell;
        T u, v;
        double height;
    };
    std::vector<Query> queries;
    for (const auto& at : wander(terrain, 4096, 0.5)) {
        const double a = at.x / terrain.kind.spacing.x, b = at.y / terrain.kind.spacing.y;
        const Cell cell{static_cast<Index>(a), static_cast<Index>(b)};
        queries.push_back({cell, static_cast<T>(a - static_cast<double>(cell.i)),
                           static_cast<T>(b - static_cast<double>(cell.j)), terrain.surface(at.x, at.y)});
    }
    const auto grid = terrain.template grid<T>();
    const double tolerance = 8 * static_cast<double>(epsilon<T>) * terrain.kind.highest;
    for (const auto& q : queries) {
        const auto patch = grid.patch(q.cell);
        const double height = patch ? static_cast<double>(patch->height(q.u, q.v)) : 0.0;
        const auto n = patch ? patch->normal(q.u, q.v) : vec3<T>{0};
        const double length = static_cast<double>(n.x * n.x + n.y * n.y + n.z * n.z);
        if (!(std::abs(height - q.height) <= tolerance) ||
            !(std::abs(length - 1) <= 8 * static_cast<double>(epsilon<T>))) {
            return fail(state, "height or normal is wrong");
        }
    }
    while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(queries.size()))) {
        for (const auto& q : queries) {
            const auto patch = grid.patch(q.cell);
            if (!patch) continue;
            benchmark::DoNotOptimize(patch->height(q.u, q.v));
            benchmark::DoNotOptimize(patch->normal(q.u, q.v));
        }
    }
    state.SetLabel(terrain.label());
}

template <Real T>
void register_all() {
    const std::string scalar = scalar_name<T>;
    // 64 × 64 cells are 8 KiB of samples: they stay in the first-level cache.
    add("bilinear_patch/dependent_evaluation/hills_64x64/" + scalar,
        [](benchmark::State& state) { dependent_evaluation<T>(state, terrain(large_hills), 64); });
    add("bilinear_patch/dependent_evaluation/hills_1.56M/" + scalar,
        [](benchmark::State& state) { dependent_evaluation<T>(state, terrain(large_hills), 0); });
    add("bilinear_patch/independent_evaluation/hills_1.56M/" + scalar,
        [](benchmark::State& state) { independent_evaluation<T>(state, terrain(large_hills)); });
}

} // namespace

void register_benchmarks() {
    register_all<double>();
    register_all<float>();
}

} // namespace hfh::bench
