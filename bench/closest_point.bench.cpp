#include "../tests/support/random.hpp"
#include "run.hpp"

#include <hfh/geometry/closest_point.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace hfh::bench {
namespace {

/// Queries over one patch of unit spacing, each near the one before.
template <Real T>
struct Stroke {
    BilinearPatch<T> patch;
    std::vector<CellPoint<T>> queries;
};

/// Patches with corners up to `relief` cells apart, queries `depth` cells below them, moving by 0.05 cells.
template <Real T>
std::vector<Stroke<T>> strokes(double depth, double relief) {
    test::Random random{11};
    std::vector<Stroke<T>> made(32);
    for (auto& stroke : made) {
        const auto corner = [&] { return static_cast<T>(random.between(0, relief)); };
        stroke.patch = {corner(), corner(), corner(), corner()};
        double u = random.unit(), v = random.unit();
        while (stroke.queries.size() < 128) {
            u = std::clamp(u + random.between(-0.05, 0.05), 0.0, 1.0);
            v = std::clamp(v + random.between(-0.05, 0.05), 0.0, 1.0);
            const auto at_u = static_cast<T>(u), at_v = static_cast<T>(v);
            stroke.queries.push_back({at_u, at_v, stroke.patch.height(at_u, at_v) - static_cast<T>(depth)});
        }
    }
    return made;
}

/// Squared distance of a surface point to a query, in double.
template <Real T>
double square(const BilinearPatch<T>& p, const CellPoint<T>& q, double u, double v) {
    const double z = static_cast<double>(p.p00) * (1 - u) * (1 - v) +
                     static_cast<double>(p.p10) * u * (1 - v) + static_cast<double>(p.p01) * (1 - u) * v +
                     static_cast<double>(p.p11) * u * v;
    const double x = u - static_cast<double>(q.u), y = v - static_cast<double>(q.v),
                 gap = z - static_cast<double>(q.z);
    return x * x + y * y + gap * gap;
}

/// Runs over all queries from foot to foot, as a tracker does.
template <Real T, class Visitor>
void follow(const std::vector<Stroke<T>>& all, Visitor&& visit) {
    for (const auto& stroke : all) {
        vec2<T> at{T(0.5), T(0.5)};
        for (const auto& query : stroke.queries) {
            const auto foot = newton_closest_point(stroke.patch, query, at);
            visit(stroke.patch, query, at, foot);
            at = {foot.u, foot.v};
        }
    }
}

template <Real T>
void coherent(benchmark::State& state, double depth, double relief) {
    const auto all = strokes<T>(depth, relief);
    double iterations = 0, count = 0;
    bool right = true;
    follow(all, [&](const BilinearPatch<T>& patch, const CellPoint<T>& query, const vec2<T>& start,
                    const NewtonResult<T>& foot) {
        iterations += foot.iterations;
        count += 1;
        const double u = static_cast<double>(foot.u), v = static_cast<double>(foot.v);
        const double here = square(patch, query, u, v);
        const double noise = 64 * static_cast<double>(epsilon<T>) * (here + relief * relief);
        right = right && foot.status == NewtonStatus::converged && u >= 0 && u <= 1 && v >= 0 && v <= 1;
        right =
            right &&
            here <= square(patch, query, static_cast<double>(start.x), static_cast<double>(start.y)) + noise;
        // A local minimum: nothing is nearer a little way off, in any direction that stays on the patch.
        for (int k = 0; k < 8; ++k) {
            const double a = 0.785398163397448 * k;
            const double to_u = std::clamp(u + 0.01 * std::cos(a), 0.0, 1.0),
                         to_v = std::clamp(v + 0.01 * std::sin(a), 0.0, 1.0);
            right = right && square(patch, query, to_u, to_v) >= here - noise;
        }
    });
    if (!right) return fail(state, "not a local closest point");
    while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(count))) {
        follow(all, [](const auto&, const auto&, const auto&, const auto& foot) {
            benchmark::DoNotOptimize(foot);
        });
    }
    state.counters["iterations_a_query"] = iterations / count;
}

template <Real T>
void register_all() {
    struct Set {
        const char* name;
        double depth, relief;
    };
    for (const Set& set : {Set{"depth_0.1_relief_0.3", 0.1, 0.3}, Set{"depth_0.5_relief_0.3", 0.5, 0.3},
                           Set{"depth_3_relief_0.3", 3, 0.3}, Set{"depth_0.1_relief_3", 0.1, 3},
                           Set{"depth_0.5_relief_3", 0.5, 3}, Set{"depth_3_relief_3", 3, 3}}) {
        add(std::string{"closest_point/"} + set.name + "/" + scalar_name<T>,
            [=](benchmark::State& state) { coherent<T>(state, set.depth, set.relief); });
    }
}

} // namespace

void register_benchmarks() {
    register_all<double>();
    register_all<float>();
}

} // namespace hfh::bench
