#ifndef HFH_FORCE_VIRTUAL_COUPLING_HPP
#define HFH_FORCE_VIRTUAL_COUPLING_HPP

#include <hfh/geometry/scalar.hpp>

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

/// A coupled force, and what the damper did to its length.
struct CoupledForce {
    glm::dvec3 newtons{0.0};
    /// N by which it is shorter than the spring's, on the way out; below 0 where it is longer, on the way in.
    double held_back = 0;
};

/// Adds to a spring's force the damper that makes it passive: the damper of a virtual coupling.
///
/// A force that acts `lag` updates late is too small on the way in and too large on the way out. With s the step of the
/// position in the last update and ΔF the change of the force in it, the hand gets −lag·ΔF·s an update over and above
/// what it gave: on flat ground K·T·v·D over a press to depth D and back at speed v, with lag = ½. So
///
///     newtons = F + 1.5·lag·ΔF        where ΔF·s < 0; |ΔF| counted up to K·|s|, the damper up to |F|
///
/// takes it back in the update in which it was given, half as much again for what a changing speed leaves. Where the
/// ground is a spring, ΔF = −K·s: this is a damper of 1.5·lag·K·T, ¾·K·T without delay, in every direction in which it
/// is one: along the normal of a face, along both where a valley holds the proxy, along a friction that sticks. A force
/// that jumps, as from face to face or when the scene changes, is carried no farther than K·|s|; none is ever turned
/// back. At rest nothing is added, so that depths and forces are the spring's.
///
/// There is no account of energy here and so no bound that holds for every motion (`EnergyTank` has one, and takes light
/// contacts away for it). bench/results/closed_loop.md has what a hand gets on the simulated Touch; `PassivityObserver`
/// counts it for any device. The damper sees encoder steps: one step q more or less is a force of (1 + 1.5·lag)·K·q for one
/// update. Where that is more than 2·(dry friction), the device keeps trembling between two steps (`LimitCycleFilter`).
///
/// Two limits of it. Where a loop is slow and late the damper's own force comes too late: it then lowers the stiffness
/// that the loop bears. A wall at 200 Hz with a delay of 2 updates, the mass of the Touch in a hand of 300 N/m and
/// 4 N·s/m, measured as in bench/closed_loop: a swing fades up to 422 N/m without the coupling, up to 267 N/m with it.
/// (At 1 kHz with the same delay: 1671 N/m without, 4003 N/m with it.) And it sees the spring's force before the guard
/// changes it: a guard that brings the force up by its ramp while the hand is pressed in stiffens the spring under it,
/// and gives up to the work of that spring, ½·K·depth², 5 mJ at 400 N/m and 5 mm, which no damper before it takes back.
///
/// Stands before the guard, which holds its limits at the motors; `GuardLimits::stiffness` is (1 + 1.5·lag)·K then. A force
/// or position that is no number is passed on; the one after it counts as the first. Does not throw, does not allocate.
class VirtualCoupling {
public:
    GLM_CONSTEXPR explicit VirtualCoupling(const VirtualCouplingOptions& options) noexcept
        : stiffness_{options.stiffness}, share_{1.5 * options.lag} {}

    /// One update: the device is at `position`, in metres, and the spring asks for `newtons`, both at the hand.
    [[nodiscard]] CoupledForce operator()(const glm::dvec3& position, const glm::dvec3& newtons) noexcept {
        const glm::dvec3 step = position - position_, change = newtons - newtons_;
        const bool first = !known_;
        known_ = true; // what is no number makes neither a step nor a change, to it or from it
        position_ = position;
        newtons_ = newtons;
        const double length = glm::length(newtons), changed = glm::length(change);
        const double explained = stiffness_ * glm::length(step);
        const bool damps = share_ > 0 && explained > 0 && glm::dot(change, step) < 0;
        if (first || !damps || !is_finite(length) || !is_finite(changed)) return {newtons, 0};
        const double damper = std::min(share_ * std::min(changed, explained), length);
        const glm::dvec3 coupled = newtons + change * (damper / changed);
        return {coupled, length - glm::length(coupled)};
    }

    /// Forgets the position before.
    constexpr void reset() noexcept { known_ = false; }

private:
    double stiffness_; ///< N/m
    double share_;     ///< of a change of the force
    glm::dvec3 position_{0.0}, newtons_{0.0};
    bool known_ = false;
};

} // namespace hfh

#endif // HFH_FORCE_VIRTUAL_COUPLING_HPP
