#ifndef HFH_DEVICE_LIMIT_CYCLE_FILTER_HPP
#define HFH_DEVICE_LIMIT_CYCLE_FILTER_HPP

#include <hfh/geometry/scalar.hpp>

#include <algorithm>
#include <cmath>

// Based on: Abbott, Okamura, Effects of position quantization and sampling rate on virtual-wall passivity, 2005: a wall
// of stiffness K, felt through encoders with steps of q and dry friction f, comes to rest wherever it is pressed only if
// K·q ≤ 2·f. Above that, a push between the forces of two neighbouring steps, by more than f from either, makes the motors
// drive the device from one step to the other and back, without end: a limit cycle.

namespace hfh {

/// Holds a position still that trembles between two neighbouring steps of the encoders. Each axis for itself:
///
///     a, b, a, b, a   with |a − b| ≤ 1.5·step     gives (a + b)/2, from the last a until a position is neither a nor b
///
/// and every other position is passed on to the bit. So a motion that gets anywhere is not changed, and the result is at
/// most half a step from the position told (three quarters of `step`, where that was given too small). At the middle the
/// force is within K·q/2 of the push, which doubles the bound: there is rest up to K·q ≤ 4·f. A dead band or a backlash of
/// the same width does that too, but makes every motion lag, which feeds energy to a light grip.
///
/// A swing over more than two neighbouring steps is passed on as it is. It has another cause: more stiffness than the
/// damping bears, K > (b + d)/(T/2 + delay·T + τ). Less stiffness helps there, or the damper of `VirtualCoupling`. The
/// filter needs encoders along x, y and z. With encoders in the joints a step of one joint is no step of a coordinate, and
/// while two joints tremble no coordinate comes back to a value that it had; then every position is passed on.
///
/// Positions have to come back to the bit, as those computed from counts do. The filter is the first link behind the device;
/// a passivity controller needs the position as the device tells it. A position that is no number is passed on, and what
/// was before it is forgotten. Does not throw, does not allocate.
class LimitCycleFilter {
public:
    /// The length of a step of the encoders in metres, the largest in the workspace. Not above 0 or not finite: every
    /// position is passed on.
    constexpr explicit LimitCycleFilter(double step) noexcept : step_{is_at_least_zero(step) ? step : 0.0} {}

    [[nodiscard]] glm::dvec3 operator()(const glm::dvec3& position) noexcept {
        glm::dvec3 steady;
        for (glm::length_t k = 0; k < 3; ++k) steady[k] = axes_[k].next(position[k], 1.5 * step_);
        return steady;
    }

    /// Forgets the positions before.
    constexpr void reset() noexcept { *this = LimitCycleFilter{step_}; }

private:
    /// Changes back to the value before, in a row, that make a tremor. A swing over more steps never has so many. After one
    /// change a swing could not be told from a tremor, and holding the position still would keep the swing going.
    static constexpr int enough = 3;

    struct Axis {
        double last = 0, before = 0; ///< the latest value, and the one before the last change
        int values = 0;              ///< how many of these two are known
        int turns = 0;               ///< changes back to the value before, in a row

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
