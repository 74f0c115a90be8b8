#ifndef HFH_FORCE_FORCE_EVALUATOR_HPP
#define HFH_FORCE_FORCE_EVALUATOR_HPP

#include <hfh/contact/contact.hpp>

#include <limits>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.4: "force is applied in the direction of the
// penetration vector, with strength proportional to the penetration magnitude".

namespace hfh {

/// A force on the stylus, and whether the device's limit cut it.
template <Real T>
struct Force {
    vec3<T> newtons{T(0)};
    bool clamped = false;
};

/// Contact → force: F = stiffness · (proxy − stylus), shortened to max_force.
///
/// Zero when the contact does not touch, when the stiffness is below 0 or not finite, and when max_force is below 0 or NaN.
/// So it never pulls into the surface and is never longer than max_force. Has no state, does not throw.
template <Real T>
struct ForceEvaluator {
    T stiffness = T(500); ///< N/m, ≥ 0
    /// N, ≥ 0: what the device can give (Touch: 3.3); ∞ for no limit.
    T max_force = std::numeric_limits<T>::max();

    [[nodiscard]] constexpr Force<T> operator()(const Contact<T>& contact) const noexcept {
        const bool usable =
            is_at_least_zero(stiffness) && is_upper_limit(max_force) && is_finite(contact.depth);
        if (!contact.touching() || !usable) return {};
        const bool clamped = stiffness * contact.depth > max_force;
        const vec3<T> newtons = contact.penetration * (clamped ? max_force / contact.depth : stiffness);
        return is_finite(newtons) ? Force<T>{newtons, clamped} : Force<T>{};
    }
};

} // namespace hfh

#endif // HFH_FORCE_FORCE_EVALUATOR_HPP
