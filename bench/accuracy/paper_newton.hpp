#ifndef HFH_BENCH_ACCURACY_PAPER_NEWTON_HPP
#define HFH_BENCH_ACCURACY_PAPER_NEWTON_HPP

#include "query_sets.hpp"

#include <algorithm>
#include <cmath>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.2, as it stands there: Newton's method on Eq. (10)
// with the Jacobian of Eq. (11) and no safeguard, then the edges if it ends outside. The reference to measure against.

namespace accuracy {

/// The bounded closest point of §4.3.2: the nearest of the nearest points of the four edges, corners included.
template <Real T>
[[nodiscard]] SurfaceFoot<T> bounded_closest_point(const Query<T>& query) {
    const auto& p = query.patch;
    const T dx = p.spacing.x, dy = p.spacing.y, z = query.at.z;
    SurfaceFoot<T> nearest;
    T least = std::numeric_limits<T>::max();
    const auto offer = [&](T u, T v, T height) {
        const T x = dx * (u - query.at.u), y = dy * (v - query.at.v), gap = height - z;
        const T square = x * x + y * y + gap * gap;
        if (square < least) least = square, nearest = {u, v};
    };
    // The foot on the line from height a to height b, `length` metres apart, for a query at parameter q.
    const auto along = [z](T q, T a, T b, T length) {
        const T rise = b - a;
        return std::clamp((length * length * q + (z - a) * rise) / (length * length + rise * rise), T(0),
                          T(1));
    };
    const T u0 = along(query.at.u, p.p00, p.p10, dx), u1 = along(query.at.u, p.p01, p.p11, dx);
    const T v0 = along(query.at.v, p.p00, p.p01, dy), v1 = along(query.at.v, p.p10, p.p11, dy);
    offer(u0, T(0), p.p00 + u0 * (p.p10 - p.p00));
    offer(u1, T(1), p.p01 + u1 * (p.p11 - p.p01));
    offer(T(0), v0, p.p00 + v0 * (p.p01 - p.p00));
    offer(T(1), v1, p.p10 + v1 * (p.p11 - p.p10));
    return nearest;
}

/// `iterations` steps of Newton's method from `start`, fewer if a step is shorter than `still` cells; u and v are not
/// kept in the cell on the way.
template <Real T>
[[nodiscard]] SurfaceFoot<T> paper_closest_point(const Query<T>& query, int iterations, T still) {
    const auto& p = query.patch;
    const T a = p.p11 - p.p10 - p.p01 + p.p00, b = p.p10 - p.p00, c = p.p01 - p.p00, d = p.p00 - query.at.z;
    const T dx2 = p.spacing.x * p.spacing.x, dy2 = p.spacing.y * p.spacing.y;
    T u = start(query).x, v = start(query).y;
    for (int step = 0; step < iterations; ++step) {
        const T z = u * v * a + u * b + v * c + d, zu = v * a + b, zv = u * a + c;
        const T fu = dx2 * (u - query.at.u) + z * zu, fv = dy2 * (v - query.at.v) + z * zv; // Eq. (10)
        const T fuu = dx2 + zu * zu, fvv = dy2 + zv * zv, fuv = z * a + zu * zv;            // Eq. (11)
        const T scale = T(1) / (fuu * fvv - fuv * fuv);
        const T du = (fuv * fv - fvv * fu) * scale, dv = (fuv * fu - fuu * fv) * scale;
        u += du;
        v += dv;
        if (std::max(std::abs(du), std::abs(dv)) < still) break;
    }
    // Also where a singular Jacobian has left no numbers.
    return u >= 0 && u <= 1 && v >= 0 && v <= 1 ? SurfaceFoot<T>{u, v} : bounded_closest_point(query);
}

} // namespace accuracy

#endif // HFH_BENCH_ACCURACY_PAPER_NEWTON_HPP
