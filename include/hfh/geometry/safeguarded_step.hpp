#ifndef HFH_GEOMETRY_SAFEGUARDED_STEP_HPP
#define HFH_GEOMETRY_SAFEGUARDED_STEP_HPP

#include <hfh/geometry/newton_step.hpp>

// The step from where Newton's will not do: F is not convex there, or has a bent valley.
//
// Where F is far stiffer along one parameter than along the other it has a valley, and the valley bends with the twist
// of the patch. Straight steps crawl along it; a step from one point of its floor to another does not.

namespace hfh::detail {

/// Where to go from `at` instead of a Newton step: along the floor of the valley, or to the minimum along u or v alone,
/// whichever lowers F by more. F falls on the way. Where F can be lowered in the patch some step is always possible.
template <Real T>
[[nodiscard, gnu::noinline]] vec2<T> safeguarded_step(const DistanceFunction<T>& distance,
                                                      vec2<T> at) noexcept;

/// The floor of a bent valley: the curve on which the stiffer parameter is at its best for each value of the other. Along
/// it F is a function of the other parameter alone, with curvature det/F_uu (or det/F_vv).
template <Real T>
struct ValleyFloor {
    const DistanceFunction<T>& distance;
    bool along_v; ///< the other parameter is v

    /// The floor where the other parameter has this value.
    [[nodiscard]] vec2<T> at(T along) const noexcept {
        return along_v ? vec2<T>{distance.best_u(along), along} : vec2<T>{along, distance.best_v(along)};
    }
    /// Whether F falls all the way from one value of the other parameter to another. Told from F and its derivative at nine
    /// places, so false where the slope across the valley doubles or halves on the way: the floor may bend too sharply
    /// there to be told so.
    [[nodiscard]] bool descends(T from, T to) const noexcept {
        const T across = slope_across(from), across_there = slope_across(to);
        if (!(across * across_there > 0) || std::abs(across) > 2 * std::abs(across_there) ||
            std::abs(across_there) > 2 * std::abs(across)) {
            return false;
        }
        T last = std::numeric_limits<T>::max();
        for (int eighth = 0; eighth <= 8; ++eighth) {
            const vec2<T> here = at(from + static_cast<T>(eighth) / 8 * (to - from));
            const auto f = distance(here.x, here.y);
            const T squared = distance.squared(here.x, here.y, f.z);
            if ((along_v ? f.fv : f.fu) * (to - from) > 0 || squared > last) return false;
            last = squared;
        }
        return true;
    }

private:
    [[nodiscard]] T slope_across(T along) const noexcept {
        return along_v ? distance.slope_u(along) : distance.slope_v(along);
    }
};

/// A step to a point of the valley's floor: straight, as far as F falls all along, or, where the straight way leads up the
/// valley's side, down to the floor and along it. Leaves `at` alone and returns false if no such step changes F by less
/// than `gain` (< 0).
template <Real T>
[[nodiscard]] bool valley_step(const DistanceFunction<T>& distance,
                               const typename DistanceFunction<T>::Value& f, T gain, vec2<T>& at) noexcept {
    const bool along_v = f.fuu >= f.fvv;
    const ValleyFloor<T> valley{distance, along_v};
    const T from = along_v ? at.y : at.x, stiff = along_v ? f.fuu : f.fvv;
    const T slope = along_v ? f.fuu * f.fv - f.fuv * f.fu : f.fvv * f.fu - f.fuv * f.fv;
    const T curvature = glm::max(std::abs(f.determinant), epsilon<T> * stiff * stiff);
    T step = glm::clamp(from - slope / curvature, T(0), T(1)) - from;
    T last = std::numeric_limits<T>::max();
    for (int halving = 0; halving < 16; ++halving, step /= 2) {
        const T to = glm::clamp(from + step, T(0), T(1));
        const vec2<T> floor = valley.at(to);
        const StepProfile<T> profile{distance, f, floor.x - at.x, floor.y - at.y};
        const T part = profile.first_minimum(), straight = profile.change(part), whole = profile.change(T(1));
        if (straight < gain && part >= T(0.25)) {
            at = part < 1 ? at + part * (floor - at) : floor;
            return true;
        }
        if (whole < gain && valley.descends(from, to)) {
            at = floor;
            return true;
        }
        if (whole < 0 && !(whole < last)) return false; // the best step of all was longer
        last = whole;
    }
    return false;
}

template <Real T>
[[nodiscard, gnu::noinline]] vec2<T> safeguarded_step(const DistanceFunction<T>& distance,
                                                      vec2<T> at) noexcept {
    // The caller has these as well, but to hand them over it would have to keep them in memory.
    const auto f = distance(at.x, at.y);
    const ActiveSet active{distance, f, at};
    const bool moves_u = active.may_move_u(), moves_v = active.may_move_v();
    const T u = moves_u ? glm::clamp(at.x - f.fu / f.fuu, T(0), T(1)) : at.x;
    const T v = moves_v ? glm::clamp(at.y - f.fv / f.fvv, T(0), T(1)) : at.y;
    // So near a border that no other step can be compared with the one there: what it gains is less than the rounding of any.
    constexpr T hair = epsilon<T>;
    if (moves_u && u == 0 && at.x < hair) return {u, at.y};
    if (moves_v && v == 0 && at.y < hair) return {at.x, v};
    const T gain_u = distance.change(f, u - at.x, T(0)), gain_v = distance.change(f, T(0), v - at.y);
    const T gain = glm::min(gain_u, gain_v);
    // Far from the query both minima lie on borders of the patch, and the corner where these meet is lower than either.
    // It makes the search for a floor, which is costly, needless.
    const bool to_corner = u != at.x && v != at.y && (u == 0 || u == 1) && (v == 0 || v == 1);
    if (to_corner) {
        const StepProfile<T> profile{distance, f, u - at.x, v - at.y};
        if (profile.first_minimum() == 1 && profile.change(T(1)) < gain) return {u, v};
    }
    if (active.is_empty() && valley_step(distance, f, gain, at)) return at;
    return moves_u && (!moves_v || gain_u <= gain_v) ? vec2<T>{u, at.y} : vec2<T>{at.x, v};
}

} // namespace hfh::detail

#endif // HFH_GEOMETRY_SAFEGUARDED_STEP_HPP
