#ifndef HFH_BENCH_ACCURACY_ORACLE_CHECK_HPP
#define HFH_BENCH_ACCURACY_ORACLE_CHECK_HPP

#include "oracle.hpp"

#include <random.hpp>

#include <cstdio>
#include <initializer_list>

// The oracle against answers that are known without it.

namespace accuracy {
namespace detail {

using hfh::test::Random;

/// A query and the foot it was made from.
struct Known {
    SeenPatch patch;
    Wide u, v, distance;
};

[[nodiscard]] inline Wide between(Random& random, double low, double high) {
    return static_cast<Wide>(random.between(low, high));
}

/// Heights within a relief of 0.01 to 1000 cells, evenly over its powers of ten, and a cell up to four times as long
/// as wide; the query is at the cell's corner.
inline SeenPatch any_patch(Random& random) {
    const double relief = std::pow(10.0, random.between(-2, 3));
    const auto height = [&] { return Wide(relief * random.unit()); };
    const Wide dy = std::pow(2.0L, between(random, -1, 1));
    return {0, 0, 1, dy, height(), height(), height(), height()};
}

/// The same patch seen from `query`, given where the patch was seen from before.
inline SeenPatch seen_from(const SeenPatch& p, const Point& query) {
    return {p.x - query.x,   p.y - query.y,   p.dx,           p.dy, p.z00 - query.z,
            p.z10 - query.z, p.z01 - query.z, p.z11 - query.z};
}

/// Along the normal of a point inside, as far as it is sure to stay the closest: |σ_z twist| ≤ dx dy.
inline Known above_inside(Random& random) {
    const SeenPatch p = any_patch(random);
    const Wide u = between(random, 0, 1), v = between(random, 0, 1);
    const Point n = p.normal(u, v);
    const Wide bend = std::abs(p.z11 - p.z10 - p.z01 + p.z00) * n.z / (p.dx * p.dy);
    const Wide distance = std::min(Wide(20), Wide(0.99L) / bend) * between(random, -1, 1);
    return {seen_from(p, p.at(u, v) + distance * n), u, v, std::abs(distance)};
}

/// Off an edge (u = 1) or a corner (1, 1) of a plane patch, within the cone of directions that lead away from it.
inline Known off_plane(Random& random, bool corner) {
    SeenPatch p = any_patch(random);
    p.z11 = p.z10 + p.z01 - p.z00;
    const Point su{p.dx, 0, p.z10 - p.z00}, sv{0, p.dy, p.z01 - p.z00}, n = p.normal(0, 0);
    const Point out_u = cross(sv, n), out_v = cross(n, su); // S_u × S_v points up
    const Wide v = corner ? Wide(1) : between(random, 0, 1);
    const Wide a = between(random, 0, 3), b = corner ? between(random, 0, 3) : Wide(0);
    const Point away = (a / length(out_u)) * out_u + (b / length(out_v)) * out_v + between(random, -3, 3) * n;
    return {seen_from(p, p.at(1, v) + away), 1, v, length(away)};
}

inline bool finds(const Known& known) {
    const LocalFoot foot = closest_points(known.patch).front();
    const Wide size = size_of_problem(known.patch, known.distance);
    const Wide off = length(known.patch.at(foot.u, foot.v) - known.patch.at(known.u, known.v));
    return std::abs(foot.distance - known.distance) <= 1e-16L * size && off <= 1e-8L * size;
}

/// z = m x y with the query c over the saddle: from c = 1/m on there are two feet, at x = y = ±√(c m − 1)/m.
inline bool finds_both_on_axis(Wide m, Wide c) {
    const SeenPatch p{-0.5L, -0.5L, 1, 1, m / 4 - c, -m / 4 - c, -m / 4 - c, m / 4 - c};
    const Wide t = c * m > 1 ? std::sqrt(c * m - 1) / m : Wide(0);
    const Wide distance = std::sqrt(2 * t * t + (m * t * t - c) * (m * t * t - c));
    const Wide slack = 1e-17L * size_of_problem(p, distance);
    bool lower = false, upper = false;
    for (const LocalFoot& foot : closest_points(p)) {
        if (foot.distance < distance - slack) return false;
        if (foot.distance > distance + slack) continue;
        lower = lower || std::hypot(foot.u - 0.5L + t, foot.v - 0.5L + t) < 1e-8L;
        upper = upper || std::hypot(foot.u - 0.5L - t, foot.v - 0.5L - t) < 1e-8L;
    }
    return lower && upper;
}

/// No point of a grid of them is nearer, wherever the query is.
inline bool beats_a_grid(Random& random) {
    SeenPatch p = any_patch(random);
    const Wide x = between(random, -20, 20), y = between(random, -20, 20);
    p = seen_from(p, {x, y, p.height(0.5L, 0.5L) + between(random, -1, 1) * (20 + p.relief())});
    const Wide nearest = closest_points(p).front().distance;
    for (int j = 0; j <= 100; ++j) {
        for (int i = 0; i <= 100; ++i) {
            if (length(p.at(Wide(i) / 100, Wide(j) / 100)) < nearest * (1 - 1e-17L)) return false;
        }
    }
    return true;
}

} // namespace detail

/// Whether the oracle finds what is known. Says on stderr what it did not find.
[[nodiscard]] inline bool oracle_is_right() {
    hfh::test::Random random{1};
    int inside = 0, edges = 0, corners = 0, axes = 0, grids = 0;
    for (int k = 0; k < 2000; ++k) {
        inside += !detail::finds(detail::above_inside(random));
        edges += !detail::finds(detail::off_plane(random, false));
        corners += !detail::finds(detail::off_plane(random, true));
    }
    for (const Wide m : {0.5L, 1.0L, 3.0L, 30.0L}) {
        for (const Wide of_curvature : {0.5L, 1.01L, 1.05L, 1.06L})
            axes += !detail::finds_both_on_axis(m, of_curvature / m);
    }
    for (int k = 0; k < 500; ++k) grids += !detail::beats_a_grid(random);
    const int missed = inside + edges + corners + axes + grids;
    if (missed != 0) {
        std::fprintf(
            stderr,
            "The oracle is wrong: %d inside, %d off edges, %d off corners, %d on the axis of a saddle, "
            "%d beaten by a grid.\n",
            inside, edges, corners, axes, grids);
    }
    return missed == 0;
}

} // namespace accuracy

#endif // HFH_BENCH_ACCURACY_ORACLE_CHECK_HPP
