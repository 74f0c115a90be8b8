#ifndef HFH_SIMULATION_DRIVEN_AXIS_HPP
#define HFH_SIMULATION_DRIVEN_AXIS_HPP

#include <hfh/geometry/scalar.hpp>

#include <algorithm>
#include <cmath>

// Based on: Karnopp, Computer simulation of stick-slip friction in mechanical dynamic systems, 1985, as in
// stick_slip_mass.hpp; Díaz, Gil, Influence of vibration modes and human operator on the stability of haptic rendering, 2010:
// a device as two masses, that of the motors and that of the body, on a spring and a damper.

namespace hfh {

/// One axis of a device in a hand, with what lies between a command and the hand: an amplifier that lags, a linkage that
/// gives, and weight. In place of a `StickSlipMass`, which has none of them.
///
///     τ·f′ = u − f                                                  the motor's force f follows the command u
///     m·x″ = f − b·x′ − c·sign(x′) + m·g + S·(y − x) + D·(y′ − x′)   the motors, where the encoders are
///     n·y″ = S·(x − y) + D·(x′ − y′) + n·g + k·(p − y) + d·(p′ − y′) the tip, which the hand holds and moves by p
///
/// Without a tip mass y is x, and the hand holds the motors; without a lag f is u. Dry friction is the motors', the same
/// at rest as in motion.
///
/// Between two instants of rest this is linear, u is constant and p linear in time: solved by its Taylor series, to
/// rounding, whatever the step. The instants at which the motors come to rest or break away are found to the rounding of
/// the time; what is missed is a rest or a breaking away that begins and ends within an eighth of 1/(fastest rate).
struct DrivenAxis {
    double mass = 1;             ///< m, kg, > 0, reflected to the end effector
    double viscous = 0;          ///< b, N·s/m
    double dry = 0;              ///< c, N
    double spring = 0;           ///< k, N/m, of the hand
    double damper = 0;           ///< d, N·s/m, of the hand
    double lag = 0;              ///< τ, s
    double gravity = 0;          ///< g, m/s² along this axis: −9.81 for z, unless the weight is balanced
    double tip_mass = 0;         ///< n, kg; 0: the linkage is rigid
    double structure = 0;        ///< S, N/m; > 0 where there is a tip mass
    double structure_damper = 0; ///< D, N·s/m

    struct State {
        double x = 0, v = 0;       ///< m, m/s: of the motors
        double tip = 0, tip_v = 0; ///< m, m/s: of the tip; without a tip mass not used
        double newtons = 0;        ///< f
    };
    /// At `x`, moving as a whole, without a force.
    [[nodiscard]] static constexpr State at(double x, double v) noexcept { return {x, v, x, v, 0}; }

    /// Whether all members are in range for times up to `seconds`: numbers, none below 0 but gravity, a mass > 0, a spring to
    /// the tip mass if there is one, and no rate above 500/`seconds`.
    [[nodiscard]] bool valid(double seconds) const noexcept {
        const double numbers[]{mass, viscous,  dry,       spring,           damper,
                               lag,  tip_mass, structure, structure_damper, seconds};
        for (const double number : numbers) {
            if (!is_finite(number) || number < 0) return false;
        }
        return is_finite(gravity) && mass > 0 && (tip_mass == 0 || structure > 0) && seconds > 0 &&
               fastest() * seconds <= 500;
    }

    /// The state after `seconds`, in which `newtons` is commanded and p goes from `from` to `to`, metres, at constant speed.
    /// Precondition: valid(seconds).
    [[nodiscard]] State advance(State state, double seconds, double newtons, double from,
                                double to) const noexcept {
        if (!(lag > 0)) state.newtons = newtons;
        const int parts = std::max(1, static_cast<int>(std::ceil(2 * fastest() * seconds)));
        const double part = seconds / parts, speed = (to - from) / seconds;
        for (int n = 0; n < parts; ++n) {
            state = advance_part(state, part, {newtons, from + (n * part) * speed, speed, 1});
        }
        return state;
    }

private:
    /// What acts from outside: the command u (N), the hand at p (m) with its speed (m/s), and 1 where constant forces act,
    /// which are sliding friction and weight, or 0 in the derivatives of the equation.
    struct Input {
        double u, p, speed, constant;
    };
    /// How the motors move: held by dry friction, or sliding in a direction (0: friction is not counted).
    struct Motion {
        bool held = false;
        double sign = 0;
    };

    /// 1/s: an upper bound of the rates of the equation.
    [[nodiscard]] double fastest() const noexcept {
        const double follows = lag > 0 ? 1 / lag : 0;
        if (!(tip_mass > 0)) return follows + (viscous + damper) / mass + std::sqrt(spring / mass);
        return follows + (viscous + structure_damper) / mass + (damper + structure_damper) / tip_mass +
               std::sqrt(structure / mass + (structure + spring) / tip_mass);
    }

    /// The force on the motors without dry friction, N.
    [[nodiscard]] double push(const State& s, const Input& in) const noexcept {
        const double load = tip_mass > 0 ? structure * (s.tip - s.x) + structure_damper * (s.tip_v - s.v)
                                         : spring * (in.p - s.x) + damper * (in.speed - s.v);
        return s.newtons - viscous * s.v + load + in.constant * mass * gravity;
    }

    /// The derivative in time.
    [[nodiscard]] State slope(const State& s, const Input& in, Motion motion) const noexcept {
        State d;
        d.newtons = lag > 0 ? (in.u - s.newtons) / lag : 0;
        if (!motion.held) {
            d.x = s.v;
            d.v = (push(s, in) - in.constant * motion.sign * dry) / mass;
        }
        if (tip_mass > 0) {
            d.tip = s.tip_v;
            d.tip_v = (structure * (s.x - s.tip) + structure_damper * (s.v - s.tip_v) +
                       spring * (in.p - s.tip) + damper * (in.speed - s.tip_v)) /
                          tip_mass +
                      in.constant * gravity;
        }
        return d;
    }

    /// A motion as a power series in time: 22 terms leave less than 10⁻²⁰ for fastest·t ≤ ½, as no derivative grows
    /// by more than 2·fastest.
    struct Series {
        static constexpr int terms = 22;
        State c[terms]; ///< of tⁿ

        [[nodiscard]] State operator()(double t) const noexcept {
            State s = c[terms - 1];
            for (int n = terms - 2; n >= 0; --n) {
                s = {s.x * t + c[n].x, s.v * t + c[n].v, s.tip * t + c[n].tip, s.tip_v * t + c[n].tip_v,
                     s.newtons * t + c[n].newtons};
            }
            return s;
        }
        /// Of the motors, m/s and m/s².
        [[nodiscard]] double velocity(double t) const noexcept {
            double v = 0;
            for (int n = terms - 1; n >= 0; --n) v = v * t + c[n].v;
            return v;
        }
        [[nodiscard]] double acceleration(double t) const noexcept {
            double a = 0;
            for (int n = terms - 1; n > 0; --n) a = a * t + n * c[n].v;
            return a;
        }
    };
    /// The motion from state s on.
    [[nodiscard]] Series series(const State& s, const Input& in, Motion motion) const noexcept {
        Series out;
        out.c[0] = s;
        Input rate = in;
        for (int n = 1; n < Series::terms; ++n) {
            const State d = slope(out.c[n - 1], rate, motion);
            out.c[n] = {d.x / n, d.v / n, d.tip / n, d.tip_v / n, d.newtons / n};
            // Of the n-th coefficient the input is the n-th derivative, over n!: of p that is the speed, once.
            rate = {0, n == 1 ? in.speed : 0, 0, 0};
        }
        return out;
    }

    /// The time between `low`, where `good` holds, and `high`, where it does not, at which it stops to hold, rounded up. Ends
    /// when no number is left between the two bounds.
    template <class Good>
    [[nodiscard]] static double ending(Good&& good, double low, double high) noexcept {
        for (double middle = low + (high - low) / 2; low < middle && middle < high;
             middle = low + (high - low) / 2) {
            (good(middle) ? low : high) = middle;
        }
        return high;
    }

    /// When the motors stop sliding or break away, in seconds; more than `end` if not until then.
    [[nodiscard]] double event(const Series& path, const Input& in, Motion motion,
                               double end) const noexcept {
        const auto goes_on = [&](double t) {
            if (!motion.held) return motion.sign * path.velocity(t) > 0;
            return std::abs(push(path(t), {in.u, in.p + in.speed * t, in.speed, 1})) <= dry;
        };
        for (int quarter = 1; quarter <= 4; ++quarter) {
            const double low = end * (quarter - 1) / 4, high = end * quarter / 4;
            if (!goes_on(high)) return ending(goes_on, low, high);
            if (motion.held) continue;
            // The motors may stop and turn in between: where they are slowest, they either still slide or have stopped.
            const auto slows = [&](double t) { return motion.sign * path.acceleration(t) < 0; };
            if (!slows(low) || slows(high)) continue;
            const double slowest = ending(slows, low, high);
            if (!goes_on(slowest)) return ending(goes_on, low, slowest);
        }
        return 2 * end;
    }

    /// The state after a time with fastest·seconds ≤ ½: rest and sliding in turns. Under forces this smooth there are only a
    /// few turns. The loop ends after 32, and the motors would then stay where they are.
    [[nodiscard]] State advance_part(State s, double seconds, Input in) const noexcept {
        if (!(dry > 0)) return series(s, in, {})(seconds);
        double left = seconds;
        // After the motors broke away they slide, even where the force, but for rounding, would hold them.
        bool broke_away = false;
        for (int turn = 0; turn < 32; ++turn) {
            Motion motion{false, s.v > 0 ? 1.0 : s.v < 0 ? -1.0 : 0.0};
            if (motion.sign == 0) {
                const double pushed = push(s, in);
                motion.held = !broke_away && std::abs(pushed) <= dry;
                motion.sign = std::copysign(1.0, pushed);
            }
            const Series path = series(s, in, motion);
            const double until = event(path, in, motion, left);
            if (until > left) return path(left);
            s = path(until);
            s.v = 0;
            broke_away = motion.held;
            left -= until;
            in.p += in.speed * until;
        }
        return s;
    }
};

} // namespace hfh

#endif // HFH_SIMULATION_DRIVEN_AXIS_HPP
