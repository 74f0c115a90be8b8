#ifndef HFH_TRAVERSAL_CELL_CROSSING_HPP
#define HFH_TRAVERSAL_CELL_CROSSING_HPP

#include <hfh/geometry/bilinear_patch.hpp>
#include <hfh/geometry/surface_point.hpp>
#include <hfh/traversal/candidate_walker.hpp>

#include <glm/common.hpp>

#include <cmath>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.1: the surface over one cell, Eq. (1)-(5).
//
// Along a segment u and v are linear in time, so the height of the segment over one patch is one quadratic:
//
//     f(s) = z_segment − z_surface = f₀ + (f₁ − f₀ − a) s + a s²,   a = −A Δu Δv,   0 ≤ s ≤ 1
//
// with A the twist of Eq. (2). f₀ and f₁ are heights at the cell's border, and border heights agree between neighbours
// to the bit.

namespace hfh::detail {

/// Smallest s in [0, 1] after which f(s) = f0 + (f1 − f0 − a) s + a s² is negative, given f0 ≥ 0; > 1 if none.
/// A tangent that only touches is no crossing. Roots in the forms that do not cancel.
template <Real F>
[[nodiscard]] inline F first_descent(F f0, F f1, F a) noexcept {
    constexpr F none = 2;
    const F b = f1 - f0 - a;
    const F discriminant = b * b - 4 * a * f0;
    if (f1 >= 0 && !(a > 0 && b < 0 && -b < 2 * a && discriminant > 0)) return none;
    const F root = std::sqrt(glm::max(discriminant, F(0)));
    const F s = b < 0 ? 2 * f0 / (root - b) : (b + root) / (-2 * a);
    return glm::clamp(s, F(0), F(1));
}

/// +1 above, −1 below: the sign of f on that side.
template <Real F>
[[nodiscard]] inline F sign_of(Side side) noexcept {
    return side == Side::above ? F(1) : F(-1);
}

/// The part of a segment over one patch, or what is left of it behind a crossing.
template <Real F>
struct SegmentOverPatch {
    BilinearPatch<F> patch;
    F t_in, t_out;   ///< along the segment
    vec2<F> in, out; ///< (u, v) there
    F f_in, f_out;   ///< heights above the surface there, in metres: f₀ and f₁

    /// The part over the cell, where the segment's height goes from z_in to z_out.
    SegmentOverPatch(const BilinearPatch<F>& over, const BasicCellSpan<F>& span, F z_in, F z_out) noexcept
        : patch{over}, t_in{span.t_in}, t_out{span.t_out}, in{span.in}, out{span.out},
          f_in{z_in - over.height(in.x, in.y)}, f_out{z_out - over.height(out.x, out.y)} {}

    /// The coefficient a of s².
    [[nodiscard]] F quadratic() const noexcept {
        const vec2<F> step = out - in;
        return -patch.twist() * step.x * step.y;
    }

    /// The side on which the segment begins, by its height alone.
    [[nodiscard]] Side side_of_solid() const noexcept { return f_in >= 0 ? Side::above : Side::below; }
    /// The same for a sheet: on the surface the side to which the segment goes from there, or `none` if it stays on it or
    /// is over this cell at one point only.
    [[nodiscard]] Side side_of_sheet() const noexcept {
        if (f_in != 0) return side_of_solid();
        const F a = quadratic();
        const F way = f_out != a ? f_out - a : a; // f'(0), or f″(0)/2 where that is 0
        if (way == 0) return Side::none;
        return way >= 0 ? Side::above : Side::below;
    }

    /// Goes to the first point after which the segment is no longer on `side`; false if it stays there to the end.
    [[nodiscard]] bool go_to_crossing(Side side) noexcept {
        const F sign = sign_of<F>(side);
        const F s = first_descent(glm::max(sign * f_in, F(0)), sign * f_out, sign * quadratic());
        if (s > 1) return false;
        in += s * (out - in);
        t_in += s * (t_out - t_in);
        f_in = 0;
        return true;
    }
};

} // namespace hfh::detail

#endif // HFH_TRAVERSAL_CELL_CROSSING_HPP
