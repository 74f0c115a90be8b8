#ifndef HFH_SIMULATION_STICK_SLIP_MASS_HPP
#define HFH_SIMULATION_STICK_SLIP_MASS_HPP

#include <hfh/geometry/scalar.hpp>

#include <algorithm>
#include <cmath>

// Based on: Karnopp, Computer simulation of stick-slip friction in mechanical dynamic systems, 1985: dry friction by its
// two states, at rest and sliding, and the instants between them.

namespace hfh {

/// One axis of a device in a hand: a mass with viscous and dry friction on a spring and a damper whose other end, p, is
/// moved.
///
///     m·x″ = f − b·x′ − c·sign(x′) + k·(p − x) + d·(p′ − x′)        at rest, x′ = 0, while |f + k·(p − x) + d·p′| ≤ c
///
/// With f constant and p linear in time this is linear between two instants of rest, and
///
///     x(t) = x₀ + x′₀·G₁(t) + (f₀·G₂(t) + f₁·G₃(t))/m,   x′(t) = x′₀·G₀(t) + (f₀·G₁(t) + f₁·G₂(t))/m
///
/// with f₀ + f₁·t the force on a mass held at x₀, Gₙ₊₁′ = Gₙ and G₀ = 1 − (b+d)/m·t + …, the homogeneous solution. There
/// is no step size: `advance` is exact but for rounding, and finds the instants of rest to the rounding of the time.
struct StickSlipMass {
    double mass = 1;    ///< m, kg, > 0
    double viscous = 0; ///< b, N·s/m
    double dry = 0;     ///< c, N: the same at rest as in motion
    double spring = 0;  ///< k, N/m
    double damper = 0;  ///< d, N·s/m

    struct State {
        double x = 0; ///< metres
        double v = 0; ///< metres per second
    };
    [[nodiscard]] static constexpr State at(double x, double v) noexcept { return {x, v}; }

    /// Whether all members are in range for times up to `seconds`: numbers ≥ 0, a mass > 0, and no rate above 500/`seconds`.
    [[nodiscard]] bool valid(double seconds) const noexcept {
        for (const double number : {mass, viscous, dry, spring, damper, seconds}) {
            if (!is_at_least_zero(number)) return false;
        }
        return mass > 0 && is_finite(1 / mass) && seconds > 0 && fastest() * seconds <= 500;
    }

    /// The state after `seconds`, in which `newtons` acts and p goes from `from` to `to`, metres, at constant speed.
    /// Precondition: valid(seconds).
    [[nodiscard]] State advance(State state, double seconds, double newtons, double from,
                                double to) const noexcept {
        const int parts = std::max(1, static_cast<int>(std::ceil(2 * fastest() * seconds)));
        const double part = seconds / parts, speed = (to - from) / seconds;
        for (int n = 0; n < parts; ++n) {
            state = advance_part(state, part, newtons, from + (n * part) * speed, speed);
        }
        return state;
    }

private:
    /// G₀ to G₃ at one time.
    struct Response {
        double g0, g1, g2, g3;
    };
    /// What drives the mass from an instant on: f₀ + f₁·t, friction included.
    struct Drive {
        double f0, f1;
    };

    [[nodiscard]] double rate() const noexcept { return (viscous + damper) / mass; }
    [[nodiscard]] double squared_frequency() const noexcept { return spring / mass; }
    [[nodiscard]] double fastest() const noexcept { return std::max(rate(), std::sqrt(squared_frequency())); }

    /// G₀ to G₃ by their Taylor series, whose n-th term is less than (1.62·fastest·t)ⁿ/n!. `advance` divides the time so
    /// that fastest·t ≤ ½, where 18 terms leave 4·10⁻¹⁸.
    [[nodiscard]] Response response(double t) const noexcept {
        const double b = rate(), w = squared_frequency();
        double u = 1, next = -b;
        double power = 1; // tⁿ/n!
        Response r{0, 0, 0, 0};
        for (int n = 0; n < 18; ++n) {
            const double p1 = power * t / (n + 1), p2 = p1 * t / (n + 2), p3 = p2 * t / (n + 3);
            r.g0 += u * power;
            r.g1 += u * p1;
            r.g2 += u * p2;
            r.g3 += u * p3;
            const double after = -b * next - w * u;
            u = next;
            next = after;
            power = p1;
        }
        return r;
    }

    [[nodiscard]] double velocity(const State& s, Drive f, double t) const noexcept {
        const Response r = response(t);
        return s.v * r.g0 + (f.f0 * r.g1 + f.f1 * r.g2) / mass;
    }
    [[nodiscard]] double acceleration(const State& s, Drive f, double t) const noexcept {
        const Response r = response(t);
        return s.v * (-rate() * r.g0 - squared_frequency() * r.g1) + (f.f0 * r.g0 + f.f1 * r.g1) / mass;
    }
    [[nodiscard]] State slid(const State& s, Drive f, double t) const noexcept {
        const Response r = response(t);
        return {s.x + s.v * r.g1 + (f.f0 * r.g2 + f.f1 * r.g3) / mass,
                s.v * r.g0 + (f.f0 * r.g1 + f.f1 * r.g2) / mass};
    }

    /// The time in 0 < t ≤ `end` at which a function that is true at first and false at `end` becomes false. Ends when no
    /// number is left between the two bounds.
    template <class Function>
    [[nodiscard]] static double crossing(Function&& positive, double end) noexcept {
        double low = 0, high = end;
        for (double middle = end / 2; low < middle && middle < high; middle = low + (high - low) / 2) {
            (positive(middle) ? low : high) = middle;
        }
        return high;
    }

    /// When a mass that slides in direction `sign` first stands still, in seconds; more than `end` if not until then. The
    /// acceleration is a homogeneous solution, so within fastest·t ≤ ½ it has at most one zero.
    [[nodiscard]] double rest_after(const State& s, Drive f, double sign, double end) const noexcept {
        double stop = end;
        if (sign * velocity(s, f, end) > 0) {
            const bool dips = sign * acceleration(s, f, 0) < 0 && sign * acceleration(s, f, end) > 0;
            if (!dips) return 2 * end;
            stop = crossing([&](double t) { return sign * acceleration(s, f, t) < 0; }, end);
            if (sign * velocity(s, f, stop) > 0) return 2 * end;
        }
        return crossing([&](double t) { return sign * velocity(s, f, t) > 0; }, stop);
    }

    /// The state after a time with fastest·seconds ≤ ½: rest and sliding in turns. Under a force that is linear in time there
    /// are only a few turns. The loop ends after 16, and the mass would then stay where it is.
    [[nodiscard]] State advance_part(State s, double seconds, double newtons, double p,
                                     double speed) const noexcept {
        double left = seconds;
        const double f1 = spring * speed;
        for (int turn = 0; turn < 16 && left > 0; ++turn) {
            double f0 = newtons + spring * (p - s.x) + damper * speed;
            double sign = s.v > 0 ? 1 : s.v < 0 ? -1 : 0;
            if (sign == 0 && std::abs(f0) > dry) {
                sign = std::copysign(1.0, f0);
            } else if (sign == 0) {
                const double until = f1 != 0 ? (std::copysign(dry, f1) - f0) / f1 : left;
                if (!(until < left)) return s;
                left -= until;
                p += speed * until;
                f0 += f1 * until;
                sign = std::copysign(1.0, f1);
            }
            const Drive drive{f0 - sign * dry, f1};
            const double rest = dry > 0 ? rest_after(s, drive, sign, left) : 2 * left;
            if (rest > left) return slid(s, drive, left);
            s = {slid(s, drive, rest).x, 0};
            left -= rest;
            p += speed * rest;
        }
        return s;
    }
};

} // namespace hfh

#endif // HFH_SIMULATION_STICK_SLIP_MASS_HPP
