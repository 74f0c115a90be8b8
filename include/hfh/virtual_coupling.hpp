#ifndef HFH_VIRTUAL_COUPLING_HPP
#define HFH_VIRTUAL_COUPLING_HPP

#include <hfh/scalar.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

// Based on: Colgate, Stanley, Brown, Issues in the haptic display of tool use, 1995: a spring and a damper between the
// device and the proxy, the virtual coupling; Colgate, Schenkel, Passivity of a class of sampled-data systems, 1997: a
// sampled spring of stiffness K gives away what a damper of K·T/2 takes.

namespace hfh {

/// What a device and its loop make of a spring.
struct VirtualCouplingOptions {
    double stiffness = 0; ///< K, N/m, at the hand: of the spring whose forces are coupled. 0: none
    /// Updates by which a force comes later than the position it belongs to, in the mean: ½ for a force that is held
    /// until the next update, + `DeviceCapabilities::delay`, + amplifier lag · rate.
    double lag = 0.5;
};

/// A coupled force, and what the damper did to it.
struct CoupledForce {
    glm::dvec3 newtons{0.0};
    double held_back =
        0; ///< N by which it is shorter than the spring's, on the way out; longer (below 0) on the way in
};

/// Adds to a spring's force the damper that makes it passive: the damper of a virtual coupling.
///
/// A force that acts `lag` updates late is too small on the way in and too large on the way out. With s the step of
/// the position in the last update and n = F/|F|, a spring gives the hand, over and above what it took, K·lag·(s·n)² an
/// update: K·T·v·D over a press to depth D and back at speed v, with lag = ½. So
///
///     newtons = F − 1.5·lag·K·(s·n)·n        the damper no greater than the spring: between 0 and 2F
///
/// takes it back in the update in which it was given, half as much again for what a changing speed leaves: a damper of
/// 1.5·lag·K·T, which is ¾·K·T without delay. At rest it does nothing, so that depths and forces are the spring's.
///
/// What holds, and what does not: there is no account here and so no bound for any motion whatever (`EnergyTank` has
/// one, and erases light contacts by it). What is measured with the simulated Touch is in
/// bench/results/closed_loop.md; `PassivityObserver` counts what a hand in fact got. The damper sees encoder steps: one
/// step q more or less is a force of (1 + 1.5·lag)·K·q for one update, 0.05 N with the Touch.
///
/// Stands before the guard, which holds its limits at the motors. A force or position that is no number is passed on;
/// the position after it counts as the first. Does not throw, does not allocate.
class VirtualCoupling {
public:
    constexpr explicit VirtualCoupling(const VirtualCouplingOptions& options) noexcept
        : damper_{1.5 * options.lag * options.stiffness} {}

    /// One update: the device is at `position`, in metres, and the spring asks for `newtons`, both at the hand.
    [[nodiscard]] CoupledForce operator()(const glm::dvec3& position, const glm::dvec3& newtons) noexcept {
        const glm::dvec3 step = known_ ? position - position_ : glm::dvec3{0.0};
        known_ = is_finite(position);
        position_ = position;
        const double length = glm::length(newtons);
        const double out = glm::dot(step, newtons);
        if (!is_finite(out) || !is_finite(length) || !(length > 0) || !(damper_ > 0)) return {newtons, 0};
        const double held_back = std::clamp(damper_ * (out / length), -length, length);
        return {newtons * (1 - held_back / length), held_back};
    }

    /// Forgets the position before.
    constexpr void reset() noexcept { known_ = false; }

private:
    double damper_; ///< N per metre of a step
    glm::dvec3 position_{0.0};
    bool known_ = false;
};

} // namespace hfh

#endif // HFH_VIRTUAL_COUPLING_HPP
