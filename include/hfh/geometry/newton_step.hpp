#ifndef HFH_GEOMETRY_NEWTON_STEP_HPP
#define HFH_GEOMETRY_NEWTON_STEP_HPP

#include <hfh/geometry/distance_function.hpp>

// One step of Newton's method on Eq. (10) [P], kept in the patch and checked before it is taken.
//
// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.2, Eq. (10)-(11); the active set is that of projected
// Newton methods, Bertsekas, Projected Newton Methods for Optimization Problems with Simple Constraints (1982).

namespace hfh::detail {

/// Which parameters F can still be lowered by at a point, and which of the bounds 0 ≤ u, v ≤ 1 are in the way.
struct ActiveSet {
    bool descends_u, descends_v; ///< F_u, F_v is more than rounding
    bool active_u, active_v;     ///< on a border, out of which F falls along u, along v

    // Asks first where the point is and then for the sign of a slope: a branch on that sign would be mispredicted half of
    // the time.
    template <Real T>
    [[HFH_ALWAYS_INLINED]] ActiveSet(const DistanceFunction<T>& distance,
                                     const typename DistanceFunction<T>::Value& f, const vec2<T>& at) noexcept
        : descends_u{std::abs(f.fu) > distance.gradient_error_u}, descends_v{std::abs(f.fv) >
                                                                             distance.gradient_error_v},
          active_u{at.x <= 0 ? f.fu > 0 : at.x >= 1 && f.fu <= 0}, active_v{at.y <= 0
                                                                                ? f.fv > 0
                                                                                : at.y >= 1 && f.fv <= 0} {}

    /// No bound is in the way.
    [[nodiscard]] bool is_empty() const noexcept { return !active_u && !active_v; }
    [[nodiscard]] bool may_move_u() const noexcept { return descends_u && !active_u; }
    [[nodiscard]] bool may_move_v() const noexcept { return descends_v && !active_v; }
    /// F falls nowhere in the patch: the point is a minimum of it.
    [[nodiscard]] bool is_stationary() const noexcept { return !may_move_u() && !may_move_v(); }
    /// F falls beyond the border.
    [[nodiscard]] bool leads_out() const noexcept {
        return (descends_u && active_u) || (descends_v && active_v);
    }
};

/// How a Newton step ended.
enum class NewtonStep : unsigned char {
    refused,   ///< not taken: Eq. (11) is not safely positive definite, or the step lowers F by too little
    inside,    ///< taken, or as much of it as ends at the first minimum of F along it
    to_border, ///< taken up to the border that it meets first
    barely_to_border ///< the same, and it lowers F by enough only if the surface goes on behind that border
};

/// Newton's step from `at`, as much of it as stays in the patch. Moves `at`, unless the step is refused.
///
/// A step is taken if it lowers F by a quarter of F_u²/F_uu + F_v²/F_vv or more, which is at least half of what minimising
/// along u or v alone can give. One that ends at a border may also lower F by a quarter of what its slope promises. F falls
/// all along a step, or it could lead through a ridge (a tracker's proxy slides and must not).
template <Real T>
[[nodiscard, HFH_ALWAYS_INLINED]] inline NewtonStep newton_step(const DistanceFunction<T>& distance,
                                                                const typename DistanceFunction<T>::Value& f,
                                                                vec2<T>& at) noexcept;

/// A step from a point of the patch, cut off where it would leave the patch.
template <Real T>
struct ClippedStep {
    vec2<T> to;
    T du, dv;
    T taken = 1; ///< as a part of the step that was asked for
    bool whole;  ///< it was not cut off
};

/// −(F'')⁻¹ F', the step to where Eq. (10) is zero if it were linear.
template <Real T>
[[nodiscard, HFH_ALWAYS_INLINED]] inline ClippedStep<T>
clipped_newton_step(const typename DistanceFunction<T>::Value& f, const vec2<T>& at) noexcept {
    // The step times the determinant: where this meets a border is known without waiting for the quotient.
    const T way_u = f.fuv * f.fv - f.fvv * f.fu, way_v = f.fuv * f.fu - f.fuu * f.fv;
    const T scale = T(1) / f.determinant;
    ClippedStep<T> step;
    step.du = way_u * scale, step.dv = way_v * scale;
    step.to = {at.x + step.du, at.y + step.dv};
    step.whole = step.to.x >= 0 && step.to.x <= 1 && step.to.y >= 0 && step.to.y <= 1;
    if (step.whole) return step;
    const T border_u = way_u > 0 ? T(1) : T(0), border_v = way_v > 0 ? T(1) : T(0);
    const T never = std::numeric_limits<T>::max();
    const T part_u = way_u != 0 ? (border_u - at.x) / way_u : never;
    const T part_v = way_v != 0 ? (border_v - at.y) / way_v : never;
    // The parameter that meets its border first is on it, not a rounding away.
    step.to = part_u < part_v ? vec2<T>{border_u, glm::clamp(at.y + part_u * way_v, T(0), T(1))}
                              : vec2<T>{glm::clamp(at.x + part_v * way_u, T(0), T(1)), border_v};
    step.du = step.to.x - at.x, step.dv = step.to.y - at.y;
    step.taken = glm::min(part_u, part_v) * f.determinant;
    return step;
}

/// Whether F falls by enough: `change` < 0 is a quarter or more of the descent rate F_u²/F_uu + F_v²/F_vv, of which
/// `scaled_rate` is F_uu F_vv times as much.
template <Real T>
[[nodiscard, HFH_ALWAYS_INLINED]] inline bool is_enough(const typename DistanceFunction<T>::Value& f,
                                                        T change, T scaled_rate) noexcept {
    return 4 * change * f.fuu * f.fvv < -scaled_rate;
}

/// How much of a Newton step to take so that F falls all along: 1, all of it, or up to the first minimum of F. 0 if F
/// rises too soon. `slope` is F' at its begin; `linear` and `quadratic` are the parts of the climb
/// (`StepProfile`).
template <Real T>
[[nodiscard, HFH_ALWAYS_INLINED]] inline T
falling_part(const DistanceFunction<T>& distance, const typename DistanceFunction<T>::Value& f,
             const ClippedStep<T>& step, T slope, T linear, T quadratic, T scaled_rate) noexcept {
    // Along Newton's step, as far as it is taken, `StepProfile::square` is −taken·slope/2. So this is F' at the end, and
    // F is convex all along if half of F″ at the start is more than the climb's quadratic part can take from it.
    const T cube = linear * quadratic,
            at_end = slope * (1 - step.taken) + (3 * cube + 2 * quadratic * quadratic);
    const bool convex = 6 * cube >= step.taken * slope;
    if (!(at_end > 0) && convex) return T(1);
    // Mostly F' is convex, too, and the step a little too long: the chord of F' ends before the minimum.
    if (cube >= 0 && 0 < at_end && at_end < -slope) return slope / (slope - at_end);
    const StepProfile<T> profile{distance, f, step.du, step.dv};
    const T part = profile.first_minimum();
    // A small part of it is no way along a bent valley.
    if (part < T(0.25)) return T(0);
    if (part < 1 && !is_enough(f, profile.change(part), scaled_rate)) return T(0);
    return part;
}

template <Real T>
[[nodiscard, HFH_ALWAYS_INLINED]] inline NewtonStep newton_step(const DistanceFunction<T>& distance,
                                                                const typename DistanceFunction<T>::Value& f,
                                                                vec2<T>& at) noexcept {
    if (!(f.determinant > f.gauss_newton / 2)) return NewtonStep::refused;
    const ClippedStep<T> step = clipped_newton_step<T>(f, at);
    const T du = step.du, dv = step.dv;
    const T slope = f.fu * du + f.fv * dv, quadratic = distance.twist * du * dv;
    const T linear = f.zu * du + f.zv * dv, climb = linear + quadratic;
    const T change =
        slope + f.z * quadratic + (distance.dx2 * du * du + distance.dy2 * dv * dv + climb * climb) / 2;
    const T scaled_rate = f.fu * f.fu * f.fvv + f.fv * f.fv * f.fuu;
    const bool enough = is_enough(f, change, scaled_rate);
    if (!enough && (step.whole || !(slope < 0 && 4 * change <= slope))) return NewtonStep::refused;
    const T part = falling_part(distance, f, step, slope, linear, quadratic, scaled_rate);
    if (part < 1) {
        if (!(part > 0)) return NewtonStep::refused;
        at = {at.x + part * du, at.y + part * dv};
        return NewtonStep::inside;
    }
    at = step.to;
    if (step.whole) return NewtonStep::inside;
    return enough ? NewtonStep::to_border : NewtonStep::barely_to_border;
}

} // namespace hfh::detail

#endif // HFH_GEOMETRY_NEWTON_STEP_HPP
