#ifndef HFH_FORCE_PASSIVITY_OBSERVER_HPP
#define HFH_FORCE_PASSIVITY_OBSERVER_HPP

#include <hfh/geometry/scalar.hpp>

#include <algorithm>

// Based on: Hannaford, Ryu, Time-domain passivity control of haptic interfaces, 2002: the passivity observer.

namespace hfh {

/// Counts the energy between motors and hand: what forces took from the hand less what they gave,
///
///     balance = −Σ F_{k−1}·(x_k − x_{k−1})
///
/// which is exact for a force that is held from one update to the next, friction of the device left out. Below 0 the
/// hand got more than it gave, and that much is owed.
///
/// Encoders tell a position in steps of q. Counted by these, a spring seems to give away ½K·q² with every step, however
/// slowly it is pressed. So each axis counts with the place where the device was when the step was told: in slow motion
/// that is the border between the two steps, q/2 short of the told position; with only n updates since the step before
/// it is q/2·(1 − 1/n) short.
///
/// The force has to be the one that acts: what has left the guard, delayed as the device delays it. Positions that do not
/// come in steps along x, y and z (encoders in the joints) are counted as told, with q = 0. A position or force that is
/// no number is not counted. Does not throw, does not allocate.
class PassivityObserver {
public:
    /// q: the length of a step of the encoders in metres, along each axis. 0, or no number: as told.
    GLM_CONSTEXPR explicit PassivityObserver(double resolution = 0) noexcept
        : resolution_{is_finite(resolution) && resolution > 0 ? resolution : 0} {}

    /// One update: the device is at `position`, in metres; `newtons` acts from now until the next one.
    void update(const glm::dvec3& position, const glm::dvec3& newtons) noexcept {
        if (!is_finite(position) || !is_finite(newtons)) {
            known_ = false;
            return;
        }
        for (glm::length_t k = 0; k < 3; ++k) {
            Axis& axis = axes_[k];
            if (!known_) {
                axis = {position[k], position[k], 1};
            } else if (position[k] == axis.told) {
                ++axis.updates;
            } else {
                const double short_of = 0.5 * resolution_ * (1 - 1 / axis.updates);
                const double at = position[k] + (position[k] > axis.told ? -short_of : short_of);
                balance_ -= newtons_[k] * (at - axis.at);
                axis = {position[k], at, 1};
            }
        }
        known_ = true;
        newtons_ = newtons;
    }

    /// Joules taken from the hand and not given back; below 0 after more was given.
    [[nodiscard]] constexpr double balance() const noexcept { return balance_; }
    /// Joules that the hand got and did not give.
    [[nodiscard]] constexpr double owed() const noexcept { return std::max(0.0, -balance_); }

    /// Counts from nothing again.
    GLM_CONSTEXPR void reset() noexcept { *this = PassivityObserver{resolution_}; }

private:
    struct Axis {
        double told = 0;    ///< metres, as the encoder has it
        double at = 0;      ///< metres, where it was taken to be at the last step
        double updates = 1; ///< since the last step; a double, so that it can neither overflow nor wrap
    };

    double resolution_;
    double balance_ = 0;
    glm::dvec3 newtons_{0.0};
    Axis axes_[3];
    bool known_ = false;
};

} // namespace hfh

#endif // HFH_FORCE_PASSIVITY_OBSERVER_HPP
