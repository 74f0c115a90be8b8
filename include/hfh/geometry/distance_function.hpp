#ifndef HFH_GEOMETRY_DISTANCE_FUNCTION_HPP
#define HFH_GEOMETRY_DISTANCE_FUNCTION_HPP

#include <hfh/geometry/bilinear_patch.hpp>
#include <hfh/geometry/lattice.hpp>

#include <glm/common.hpp>

#include <cmath>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.2, Eq. (8)-(11).

namespace hfh {

/// The distance from a query to a patch as a function of (u, v), and its derivatives.
///
///     F(u, v) = ½ |σ|²,  σ = S(u, v) − query                                         Eq. (8)-(9) [P], halved
///     F_u = σ·S_u,  F_v = σ·S_v                                                      Eq. (10)
///     F_uu = S_u·S_u,  F_vv = S_v·S_v,  F_uv = S_u·S_v + σ·S_uv                      Eq. (11)
///
/// Where a processor fuses products with sums the derivatives are the same wherever they are computed (`multiply_add`): a point is
/// a minimum by them, and has to be one for the next update as well.
///
/// F is in m², and a derivative by u or v is per cell: u and v go from 0 to 1 across the patch. The query is given in the
/// patch's parameters, its height in metres.
template <Real T>
struct DistanceFunction {
    T gap00;          ///< σ_z over corner 00
    T rise_u, rise_v; ///< slopes along u and v at that corner, metres per cell
    T far_u, far_v;   ///< slope along u at v = 1, along v at u = 1
    T twist;          ///< Eq. (2)
    T dx2, dy2;       ///< dx², dy²
    T query_u, query_v;
    T gradient_error_u,
        gradient_error_v; ///< bounds of the rounding of F_u and F_v: a smaller one counts as zero

    [[HFH_ALWAYS_INLINED]] DistanceFunction(const BilinearPatch<T>& patch, const CellPoint<T>& query) noexcept
        : gap00{patch.p00 - query.z}, rise_u{patch.p10 - patch.p00}, rise_v{patch.p01 - patch.p00},
          far_u{patch.p11 - patch.p01}, far_v{patch.p11 - patch.p10}, twist{patch.twist()},
          dx2{patch.spacing.x * patch.spacing.x}, dy2{patch.spacing.y * patch.spacing.y}, query_u{query.u},
          query_v{query.v} {
        // F_u = dx²(u − u_q) + σ_z·z_u. The product is good to a few roundings of the largest σ_z times the larger of
        // the two edge slopes; and u itself has steps of an ulp, each of which changes F_u by F_uu ulps. Where the patch is level along u
        // there is neither: u = u_q is met to the bit.
        const T steepest_u = glm::max(std::abs(rise_u), std::abs(far_u));
        const T steepest_v = glm::max(std::abs(rise_v), std::abs(far_v));
        const T reach = std::abs(gap00) + steepest_u + steepest_v;
        gradient_error_u = steepest_u > 0 ? 4 * epsilon<T> * multiply_add(steepest_u, reach, dx2) : T(0);
        gradient_error_v = steepest_v > 0 ? 4 * epsilon<T> * multiply_add(steepest_v, reach, dy2) : T(0);
    }

    /// z of S_u and of S_v, metres per cell.
    [[nodiscard]] T slope_u(T v) const noexcept { return multiply_add(v, far_u, (T(1) - v) * rise_u); }
    [[nodiscard]] T slope_v(T u) const noexcept { return multiply_add(u, far_v, (T(1) - u) * rise_v); }
    /// σ_z, metres.
    [[nodiscard]] T gap(T u, T v) const noexcept { return gap00 + u * rise_u + v * slope_v(u); }

    /// The derivatives at one (u, v), and what they are made of.
    struct Value {
        T z;             ///< σ_z
        T zu, zv;        ///< slopes, metres per cell
        T fu, fv;        ///< Eq. (10)
        T fuu, fvv, fuv; ///< Eq. (11)
        /// Determinant of Eq. (11) without σ·S_uv: dx²dy² + dx²z_v² + dy²z_u², always > 0.
        T gauss_newton;
        /// Determinant of Eq. (11), from the one above so that it does not cancel on steep ground.
        T determinant;
    };
    [[nodiscard, HFH_ALWAYS_INLINED]] Value operator()(T u, T v) const noexcept {
        const T zu = slope_u(v), zv = slope_v(u), z = multiply_add(v, zv, multiply_add(u, rise_u, gap00));
        const T slopes = zu * zv, twisted = z * twist, fuu = dx2 + zu * zu, fvv = dy2 + zv * zv;
        const T gauss_newton = dx2 * fvv + dy2 * zu * zu;
        return {.z = z,
                .zu = zu,
                .zv = zv,
                .fu = multiply_add(z, zu, dx2 * (u - query_u)),
                .fv = multiply_add(z, zv, dy2 * (v - query_v)),
                .fuu = fuu,
                .fvv = fvv,
                .fuv = slopes + twisted,
                .gauss_newton = gauss_newton,
                .determinant = gauss_newton - twisted * (2 * slopes + twisted)};
    }

    /// The u in [0, 1] that minimises F at this v, and the v at this u: F is a parabola along u and along v.
    [[nodiscard]] T best_u(T v) const noexcept {
        const T zu = slope_u(v);
        return glm::clamp((dx2 * query_u - gap(T(0), v) * zu) / (dx2 + zu * zu), T(0), T(1));
    }
    [[nodiscard]] T best_v(T u) const noexcept {
        const T zv = slope_v(u);
        return glm::clamp((dy2 * query_v - gap(u, T(0)) * zv) / (dy2 + zv * zv), T(0), T(1));
    }

    /// Where the patch is level along u or v, puts that parameter right over the query, which is as low as F gets along
    /// it. Steps alone may come nearer to that by one rounding at a time.
    void snap_flat_axis(vec2<T>& at) const noexcept {
        if (rise_u == 0 && far_u == 0) at.x = glm::clamp(query_u, T(0), T(1));
        if (rise_v == 0 && far_v == 0) at.y = glm::clamp(query_v, T(0), T(1));
    }

    /// |σ|² = 2 F at (u, v), where σ_z is z.
    [[nodiscard]] T squared(T u, T v, T z) const noexcept {
        const T x = u - query_u, y = v - query_v;
        return dx2 * x * x + dy2 * y * y + z * z;
    }

    /// F(u + du, v + dv) − F(u, v): a quartic along the step, written so that nothing cancels.
    [[nodiscard]] T change(const Value& at, T du, T dv) const noexcept {
        const T z1 = at.zu * du + at.zv * dv, z2 = twist * du * dv, dz = z1 + z2;
        return at.fu * du + at.fv * dv + at.z * z2 + (dx2 * du * du + dy2 * dv * dv + dz * dz) / 2;
    }
};

/// F along a straight step (du, dv) from a point, 0 ≤ s ≤ 1: the height is a parabola in s, and so
///
///     F(s) − F(0) = slope·s + square·s² + cube·s³ + fourth·s⁴
///     slope = F_u du + F_v dv,  square = σ_z q + (dx² du² + dy² dv² + c²)/2,  cube = c q,  fourth = q²/2
///
/// with the linear part of the climb, c = z_u du + z_v dv, and its quadratic part, q = A du dv. All in m².
template <Real T>
struct StepProfile {
    T slope, square, cube, fourth;

    StepProfile(const DistanceFunction<T>& distance, const typename DistanceFunction<T>::Value& at, T du,
                T dv) noexcept {
        const T linear = at.zu * du + at.zv * dv, quadratic = distance.twist * du * dv;
        slope = at.fu * du + at.fv * dv;
        square = at.z * quadratic + (distance.dx2 * du * du + distance.dy2 * dv * dv + linear * linear) / 2;
        cube = linear * quadratic;
        fourth = quadratic * quadratic / 2;
    }

    /// F(s) − F(0).
    [[nodiscard]] T change(T s) const noexcept {
        return s * (slope + s * (square + s * (cube + s * fourth)));
    }
    /// F'(s).
    [[nodiscard]] T derivative(T s) const noexcept {
        return slope + s * (2 * square + s * (3 * cube + 4 * s * fourth));
    }

    /// The first minimum of F on the step: 1 if F falls all along. May stop before it, where F' is down to a 64th of F'(0);
    /// never behind it. 0 if F does not fall at once.
    [[nodiscard, gnu::noinline]] T first_minimum() const noexcept {
        if (!(slope < 0)) return T(0);
        // F' may rise to a highest value, then falls to a lowest one and rises again, since fourth ≥ 0. So it is zero at
        // most once before the highest value, and if it is not there, at most once before the end.
        T high = 1;
        if (cube < 0 && square > 0) {
            const T root = 9 * cube * cube - 24 * fourth * square;
            const T highest = root >= 0 ? 2 * square / (std::sqrt(root) - 3 * cube) : T(1);
            if (highest < 1 && derivative(highest) > 0) high = highest;
        }
        T at_high = derivative(high);
        if (!(at_high > 0)) return T(1);
        // Regula falsi in the form of Illinois: the weight of an end that stays twice is halved.
        T low = 0, at_low = slope;
        int stayed = 0;
        for (int secant = 0; secant < 32; ++secant) {
            const T middle = low + (high - low) * (at_low / (at_low - at_high));
            if (!(middle > low && middle < high)) break;
            const T here = derivative(middle);
            if (here > 0) {
                high = middle, at_high = here;
                if (stayed > 0) at_low /= 2;
                stayed = 1;
            } else {
                low = middle, at_low = here;
                if (64 * here > slope) break;
                if (stayed < 0) at_high /= 2;
                stayed = -1;
            }
        }
        return low;
    }
};

} // namespace hfh

#endif // HFH_GEOMETRY_DISTANCE_FUNCTION_HPP
