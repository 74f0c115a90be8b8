#ifndef HFH_TESTS_SUPPORT_HARD_PATCHES_HPP
#define HFH_TESTS_SUPPORT_HARD_PATCHES_HPP

#include "random.hpp"
#include "reference.hpp"

#include <hfh/geometry/lattice.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

// Patches and queries over everything that issue "closest point on one patch" names, and the distance by a search that
// shares no code with the library.

namespace hfh::test {

template <Real T>
struct PatchCase {
    BilinearPatch<T> patch;
    CellPoint<T> query;
};

[[nodiscard]] inline double power(Random& random, double low, double high) {
    return std::pow(10.0, random.between(low, high));
}

/// Relief 0.001-1000 cells, depth 1e-6-1000 cells, aspect 1e-3-1e3; equal corners, twist zero and nearly zero, queries
/// on the medial axis, over a corner, over an edge, far beside the cell; heights of 1e±30 and denormal ones; cells of
/// index up to 10⁶ at heights near 10⁴.
template <Real T>
[[nodiscard]] PatchCase<T> hard_patch_case(Random& random) {
    const bool tame = random.one_in(3);
    const double dx = 1, dy = tame ? power(random, -0.5, 0.5) : power(random, -3, 3);
    const double relief = tame ? power(random, -1, 1.3) : power(random, -3, 3);
    const double depth = tame ? power(random, -1, 1) : power(random, -6, 3);
    const auto height = [&] { return relief * random.between(-1, 1); };
    double p00 = height(), p10 = height(), p01 = height(), p11 = height();
    switch (random.whole(0, 9)) {
    case 0: p11 = p10 + p01 - p00; break;
    case 1: p11 = p10 + p01 - p00 + 1e-9 * height(); break;
    case 2: p10 = p01 = p11 = p00; break;
    case 3: p11 = p00, p01 = p10; break; // a saddle as symmetrical as can be: its axis is over the middle
    case 4: p01 = p00, p11 = p10; break;
    default: break;
    }
    double u = random.between(-1, 2), v = random.between(-1, 2);
    switch (random.whole(0, 7)) {
    case 0: u = v = 0.5; break;
    case 1: u = std::floor(u + 0.5); break;
    case 2: u = std::floor(u + 0.5), v = std::floor(v + 0.5); break;
    case 3: u *= 100; break;
    default: break;
    }
    const double a = std::clamp(u, 0.0, 1.0), b = std::clamp(v, 0.0, 1.0);
    double z = (1 - b) * ((1 - a) * p00 + a * p10) + b * ((1 - a) * p01 + a * p11);
    if (random.one_in(2)) { // along the normal
        const double zu = ((1 - b) * (p10 - p00) + b * (p11 - p01)) / dx,
                     zv = ((1 - a) * (p01 - p00) + a * (p11 - p10)) / dy,
                     l = std::sqrt(1 + zu * zu + zv * zv);
        const double sign = random.one_in(2) ? 1 : -1;
        u -= sign * depth * zu / l / dx, v -= sign * depth * zv / l / dy, z += sign * depth / l;
    } else {
        z += random.one_in(2) ? depth : -depth;
    }
    double lift = 0, scale = 1, size = 1;
    switch (random.whole(0, 11)) {
    case 0: lift = 1e4; break;
    case 1: size = 1e30; break; // cells and heights
    case 2: size = 1e-30; break;
    case 3: scale = 1e30 / relief; break; // heights alone
    case 4: scale = 1e-30 / relief; break;
    case 5: scale = static_cast<double>(std::numeric_limits<T>::denorm_min()) * 16 / relief; break;
    default: break;
    }
    const auto metres = [&](double h) { return static_cast<T>(size * (lift + scale * h)); };
    PatchCase<T> made{{metres(p00),
                       metres(p10),
                       metres(p01),
                       metres(p11),
                       {static_cast<T>(size * dx), static_cast<T>(size * dy)}},
                      {static_cast<T>(u), static_cast<T>(v), metres(z)}};
    if (size == 1 && random.one_in(8)) { // as a grid far out makes it
        const Lattice lattice{
            {0.0, 0.0},
            {static_cast<double>(made.patch.spacing.x), static_cast<double>(made.patch.spacing.y)}};
        const Cell cell{static_cast<Index>(random.whole(0, 1000000)),
                        static_cast<Index>(random.whole(0, 1000000))};
        const vec3<T> world{static_cast<T>((static_cast<double>(cell.i) + u) * lattice.spacing().x),
                            static_cast<T>((static_cast<double>(cell.j) + v) * lattice.spacing().y),
                            made.query.z};
        made.query = lattice.locate(world, cell);
    }
    return made;
}

/// The patch seen from the query: heights over it, so that nothing is lost where both are high up.
struct SeenPatch {
    WidePatch patch;
    Point query;

    template <Real T>
    explicit SeenPatch(const PatchCase<T>& c)
        : patch{over(c.patch.p00, c.query.z),         over(c.patch.p10, c.query.z),
                over(c.patch.p01, c.query.z),         over(c.patch.p11, c.query.z),
                static_cast<Wide>(c.patch.spacing.x), static_cast<Wide>(c.patch.spacing.y)},
          query{static_cast<Wide>(c.query.u) * patch.dx, static_cast<Wide>(c.query.v) * patch.dy, 0} {}

    [[nodiscard]] Wide distance(Wide u, Wide v) const { return length(patch.position(u, v) - query); }
    /// The largest of cell diagonal, relief and distance: what errors are measured by.
    [[nodiscard]] Wide size(Wide distance) const {
        return std::max({std::hypot(patch.dx, patch.dy), patch.highest() - patch.lowest(), distance});
    }

private:
    template <Real T>
    [[nodiscard]] static Wide over(T height, T z) {
        return static_cast<Wide>(height) - static_cast<Wide>(z);
    }
};

/// The distance from the query to the closed patch: for each v the nearest u is a foot on a straight line, and the same the
/// other way round; both are scanned, finer towards the ends, where cliffs have their narrow dips, and every dip of the
/// scan is narrowed by golden section.
[[nodiscard]] inline Wide scanned_distance(const SeenPatch& seen) {
    const WidePatch& p = seen.patch;
    const Point& q = seen.query;
    const auto along_u = [&](Wide v) {
        const Wide z0 = (1 - v) * p.p00 + v * p.p01 - q.z, slope = p.along_u(v);
        const Wide u =
            std::clamp((p.dx * q.x - z0 * slope) / (p.dx * p.dx + slope * slope), Wide(0), Wide(1));
        const Point d{u * p.dx - q.x, v * p.dy - q.y, z0 + u * slope};
        return length(d);
    };
    const auto along_v = [&](Wide u) {
        const Wide z0 = (1 - u) * p.p00 + u * p.p10 - q.z, slope = p.along_v(u);
        const Wide v =
            std::clamp((p.dy * q.y - z0 * slope) / (p.dy * p.dy + slope * slope), Wide(0), Wide(1));
        const Point d{u * p.dx - q.x, v * p.dy - q.y, z0 + v * slope};
        return length(d);
    };
    Wide best = std::min(along_u(0), along_u(1));
    const auto scan = [&](auto&& distance) {
        constexpr int even = 48, finer = 20, last = even + 2 * finer;
        Wide where[last + 1], at[last + 1];
        for (int k = 0; k <= last; ++k) {
            const int from_end = std::min(k, last - k);
            const Wide off = from_end == 0       ? Wide(0)
                             : from_end <= finer ? std::pow(Wide(3), Wide(from_end - finer - 1)) / even
                                                 : Wide(from_end - finer) / even;
            where[k] = k <= last / 2 ? off : 1 - off;
            at[k] = distance(where[k]);
        }
        for (int k = 0; k <= last; ++k) {
            if ((k > 0 && at[k - 1] < at[k]) || (k < last && at[k + 1] < at[k])) continue;
            Wide low = where[std::max(k - 1, 0)], high = where[std::min(k + 1, last)];
            constexpr Wide golden = 0.618033988749894848204586834L;
            Wide x = high - golden * (high - low), y = low + golden * (high - low), fx = distance(x),
                 fy = distance(y);
            for (int step = 0; step < 70; ++step) {
                if (fx < fy) {
                    high = y, y = x, fy = fx, x = high - golden * (high - low), fx = distance(x);
                } else {
                    low = x, x = y, fx = fy, y = low + golden * (high - low), fy = distance(y);
                }
            }
            best = std::min(best, std::min(fx, fy));
        }
    };
    scan(along_u);
    scan(along_v);
    return best;
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_HARD_PATCHES_HPP
