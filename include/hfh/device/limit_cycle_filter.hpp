#ifndef HFH_DEVICE_LIMIT_CYCLE_FILTER_HPP
#define HFH_DEVICE_LIMIT_CYCLE_FILTER_HPP

#include <hfh/geometry/scalar.hpp>

#include <algorithm>
#include <cmath>

// Based on: Abbott, Okamura, Effects of position quantization and sampling rate on virtual-wall passivity, 2005: a wall
// of stiffness K, felt through encoders with steps of q and dry friction f, is at rest wherever it is pressed only if
// K·q ≤ 2·f. Above, where the push falls between the forces of two neighbouring steps by more than f, the motors
// throw the device from one to the other and back, without end.

namespace hfh {

/// Keeps a position steady that trembles between two neighbouring steps of the encoders. Each axis for itself:
///
///     a, b, a, b, a   with |a − b| ≤ 1.5·step     gives (a + b)/2, from the last a on until it is neither a nor b
///
/// and everything else is passed on to the bit. So no motion is touched that gets anywhere, and the answer is never more
/// than half a step (three quarters, of a step that was given too small) from what was told. Halfway the force is within
/// K·q/2 of the push, which doubles the bound: at rest up to K·q ≤ 4·f. A dead band or a backlash of the same width does
/// that too, but lags on every way and so feeds a light grip with energy.
///
/// That tremor is all it cures. A swing over more steps is passed on whole: a light grip of 100 N/m and 0.5 N·s/m on the
/// simulated Premium at 3500 N/m swings by up to 9.9 mm with it as without. There the stiffness is more than the damping bears,
/// K > (b + d)/(T/2 + delay·T + τ), and what helps is less of it, or the damper of `VirtualCoupling`. And it needs encoders
/// along x, y and z: with encoders in the joints a step is a step along none of these, and while two joints tremble no
/// coordinate comes back to where it was; then nothing is steadied.
///
/// For where positions come back to the bit, as counts do. The first link behind the device; a passivity controller has
/// to go by the position as told. What is no number is passed on, and what was before it is forgotten. Does not throw,
/// does not allocate.
class LimitCycleFilter {
public:
    /// The length of a step of the encoders in metres, where it is largest. Not above 0 or not finite: passes everything
    /// on.
    constexpr explicit LimitCycleFilter(double step) noexcept : step_{is_at_least_zero(step) ? step : 0.0} {}

    [[nodiscard]] glm::dvec3 operator()(const glm::dvec3& position) noexcept {
        glm::dvec3 steady;
        for (int k = 0; k < 3; ++k) steady[k] = axes_[k].next(position[k], 1.5 * step_);
        return steady;
    }

    /// Forgets the positions before.
    constexpr void reset() noexcept { *this = LimitCycleFilter{step_}; }

private:
    /// A swing over three steps or more never comes back so often. Held after its first turn it would be kept going.
    static constexpr int enough = 3;

    struct Axis {
        double last = 0, before = 0; ///< the value of now, and the one before the last change
        int values = 0;              ///< how many of these two there have been
        int turns = 0;               ///< changes back to the value before, one after the other

        [[nodiscard]] double next(double x, double widest) noexcept {
            if (!is_finite(x)) {
                *this = {};
                return x;
            }
            if (values == 0 || x != last) {
                const bool back = values == 2 && x == before && std::abs(before - last) <= widest;
                turns = back ? std::min(turns + 1, enough) : 0;
                before = last;
                last = x;
                values = std::min(values + 1, 2);
            }
            return turns == enough ? 0.5 * before + 0.5 * last : x;
        }
    };

    double step_;
    Axis axes_[3];
};

} // namespace hfh

#endif // HFH_DEVICE_LIMIT_CYCLE_FILTER_HPP
