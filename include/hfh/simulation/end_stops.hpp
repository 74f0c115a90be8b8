#ifndef HFH_SIMULATION_END_STOPS_HPP
#define HFH_SIMULATION_END_STOPS_HPP

#include <hfh/geometry/scalar.hpp>

#include <limits>

// The walls of a device's workspace.

namespace hfh {

/// An axis between two hard stops. Between them it moves as it does without; at a stop it stands, without a bounce, until a
/// force moves it away. `Axis` is a `StickSlipMass` or a `DrivenAxis`, whose motors then meet the stop.
///
/// The instant of impact is found to the rounding of the time. A stop that is passed and left again within one call of
/// `advance` is missed. An axis leaves a stop at the instant of impact or at the beginning of a later call, not in between.
template <class Axis>
struct EndStops {
    Axis axis;
    double low = -std::numeric_limits<double>::infinity(); ///< metres
    double high = std::numeric_limits<double>::infinity(); ///< metres, ≥ low

    using State = typename Axis::State;
    [[nodiscard]] static constexpr State at(double x, double v) noexcept { return Axis::at(x, v); }
    [[nodiscard]] bool valid(double seconds) const noexcept { return axis.valid(seconds) && low <= high; }

    /// As `Axis::advance`.
    [[nodiscard]] State advance(const State& state, double seconds, double newtons, double from,
                                double to) const noexcept {
        const State end = axis.advance(state, seconds, newtons, from, to);
        if (low <= end.x && end.x <= high) return end;
        const double stop = end.x < low ? low : high, beyond = end.x < low ? -1 : 1;
        const double speed = (to - from) / seconds;

        // The last time before the stop, by bisection until no number is left between the two bounds.
        State hit = state;
        double before = 0, after = seconds;
        for (double middle = seconds / 2; before < middle && middle < after;
             middle = before + (after - before) / 2) {
            const State there = axis.advance(state, middle, newtons, from, from + speed * middle);
            if (beyond * (there.x - stop) > 0) {
                after = middle;
            } else {
                before = middle;
                hit = there;
            }
        }
        hit.x = stop;
        hit.v = 0;
        const double left = seconds - before, hand = from + speed * before;
        if (!(left > 0)) return hit;
        const State free = axis.advance(hit, left, newtons, hand, to);
        if (beyond * (free.x - stop) <= 0) return free;
        Axis held = axis; // held at the stop, by friction that no force overcomes
        held.dry = std::numeric_limits<double>::max();
        return held.advance(hit, left, newtons, hand, to);
    }
};

} // namespace hfh

#endif // HFH_SIMULATION_END_STOPS_HPP
