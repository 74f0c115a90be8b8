#ifndef HFH_BENCH_ACCURACY_ORACLE_HPP
#define HFH_BENCH_ACCURACY_ORACLE_HPP

#include <algorithm>
#include <cmath>
#include <vector>

// The closest point of a patch by search, in long double. Shares no code with the library and knows nothing of it.

namespace accuracy {

using Wide = long double;

struct Point {
    Wide x = 0, y = 0, z = 0;
};
[[nodiscard]] inline Point operator+(const Point& a, const Point& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[nodiscard]] inline Point operator-(const Point& a, const Point& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[nodiscard]] inline Point operator*(Wide k, const Point& a) { return {k * a.x, k * a.y, k * a.z}; }
[[nodiscard]] inline Wide dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
[[nodiscard]] inline Point cross(const Point& a, const Point& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
[[nodiscard]] inline Wide length(const Point& a) { return std::sqrt(dot(a, a)); }

/// A patch seen from the query: the query is the origin, the cell's corner is at (x, y), the four heights are z − z_q.
struct SeenPatch {
    Wide x, y, dx, dy, z00, z10, z01, z11;

    [[nodiscard]] Wide height(Wide u, Wide v) const {
        return (1 - u) * (1 - v) * z00 + u * (1 - v) * z10 + (1 - u) * v * z01 + u * v * z11;
    }
    [[nodiscard]] Wide slope_u(Wide v) const { return (1 - v) * (z10 - z00) + v * (z11 - z01); }
    [[nodiscard]] Wide slope_v(Wide u) const { return (1 - u) * (z01 - z00) + u * (z11 - z10); }
    [[nodiscard]] Point at(Wide u, Wide v) const { return {x + u * dx, y + v * dy, height(u, v)}; }
    [[nodiscard]] Point normal(Wide u, Wide v) const { return normal_of(slope_u(v), slope_v(u)); }
    /// Of a surface with these slopes, metres per cell.
    [[nodiscard]] Point normal_of(Wide su, Wide sv) const {
        const Point n{-su / dx, -sv / dy, 1};
        return (1 / length(n)) * n;
    }
    [[nodiscard]] Wide relief() const {
        return std::max(std::max(z00, z10), std::max(z01, z11)) -
               std::min(std::min(z00, z10), std::min(z01, z11));
    }
    /// The side of a square as large as the cell: what errors are relative to.
    [[nodiscard]] Wide cell() const { return std::sqrt(dx * dy); }
    /// The patch with x and y exchanged.
    [[nodiscard]] SeenPatch mirrored() const { return {y, x, dy, dx, z00, z01, z10, z11}; }

    /// The u that is nearest for this v: along u the patch is a straight line.
    [[nodiscard]] Wide nearest_u(Wide v) const {
        const Wide s = slope_u(v);
        return std::clamp(-(dx * x + s * height(0, v)) / (dx * dx + s * s), Wide(0), Wide(1));
    }
    /// The slope along v of ½ distance² with u at its nearest: the envelope theorem leaves the partial derivative.
    [[nodiscard]] Wide fall_along_v(Wide v) const {
        const Wide u = nearest_u(v);
        return dy * (y + v * dy) + height(u, v) * slope_v(u);
    }
};

struct LocalFoot {
    Wide u = 0, v = 0, distance = 0;
};

/// The local minima found, nearest first: the first is the closest point.
using Feet = std::vector<LocalFoot>;

/// Adds the local minima that a fine sampling along v sees, each bisected to the last bit. Samples are spread evenly,
/// and closely where the lines along u are level: there the nearest u moves fastest.
inline void sweep(const SeenPatch& p, bool mirrored, Feet& feet) {
    constexpr int even = 128, close = 192;
    Wide samples[even + close + 2];
    int count = 0;
    for (int k = 0; k <= even; ++k) samples[count++] = Wide(k) / even;
    const Wide turn = p.slope_u(1) - p.slope_u(0);
    if (turn != 0) {
        const Wide level = -p.slope_u(0) / turn, width = p.dx / std::abs(turn);
        const Wide from = std::asinh(-level / width), to = std::asinh((1 - level) / width);
        for (int k = 0; k <= close; ++k) {
            const Wide v = level + width * std::sinh(from + (to - from) * (Wide(k) / close));
            if (v > 0 && v < 1) samples[count++] = v;
        }
    }
    std::sort(samples, samples + count);

    const auto add = [&](Wide v) {
        const Wide u = p.nearest_u(v), distance = length(p.at(u, v));
        feet.push_back(mirrored ? LocalFoot{v, u, distance} : LocalFoot{u, v, distance});
    };
    Wide before = p.fall_along_v(0);
    if (before >= 0) add(0);
    for (int k = 1; k < count; ++k) {
        const Wide here = p.fall_along_v(samples[k]);
        if (before < 0 && here >= 0) {
            Wide low = samples[k - 1], high = samples[k];
            for (Wide middle = (low + high) / 2; middle > low && middle < high; middle = (low + high) / 2) {
                (p.fall_along_v(middle) < 0 ? low : high) = middle;
            }
            add(high);
        }
        before = here;
    }
    if (before < 0) add(1);
}

/// All the local minima that matter: swept along v and, in case two fell between two samples, along u.
[[nodiscard]] inline Feet closest_points(const SeenPatch& patch) {
    Feet feet;
    sweep(patch, false, feet);
    sweep(patch.mirrored(), true, feet);
    std::sort(feet.begin(), feet.end(),
              [](const LocalFoot& a, const LocalFoot& b) { return a.distance < b.distance; });
    return feet;
}

/// What a distance error is small against: the largest of cell diagonal, relief and distance.
[[nodiscard]] inline Wide size_of_problem(const SeenPatch& patch, Wide distance) {
    return std::max(std::max(std::hypot(patch.dx, patch.dy), patch.relief()), distance);
}

} // namespace accuracy

#endif // HFH_BENCH_ACCURACY_ORACLE_HPP
