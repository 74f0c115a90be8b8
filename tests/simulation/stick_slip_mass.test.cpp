#include "catch.hpp"
#include "support/random.hpp"

#include <hfh/simulation/stick_slip_mass.hpp>

#include <cmath>
#include <vector>

using namespace hfh;
using namespace hfh::test;

namespace {

using State = StickSlipMass::State;

/// The same equation by brute force: Runge-Kutta of fourth order in long double, many steps; dry friction by Karnopp's
/// switch at every step. Shares nothing with the header but the numbers that describe the mass.
class BruteForce {
    using Wide = long double;
    static constexpr Wide wide(double number) { return static_cast<Wide>(number); }

public:
    Wide x, v;

    BruteForce(const StickSlipMass& m, const State& s)
        : x{wide(s.x)}, v{wide(s.v)}, mass{wide(m.mass)}, viscous{wide(m.viscous)}, dry{wide(m.dry)},
          spring{wide(m.spring)}, damper{wide(m.damper)} {}

    void advance(double duration, double force, double start, double end, long steps) {
        const Wide seconds = wide(duration), newtons = wide(force), from = wide(start), to = wide(end);
        const Wide h = seconds / static_cast<Wide>(steps), speed = (to - from) / seconds;
        for (long n = 0; n < steps; ++n) {
            const Wide p = from + speed * h * static_cast<Wide>(n);
            Wide sign = v > 0 ? 1 : v < 0 ? -1 : 0;
            if (v == 0) {
                const Wide f = push(newtons, p, speed, x, 0);
                if (std::abs(f) <= dry) continue;
                sign = f > 0 ? 1 : -1;
            }
            const auto a = [&](Wide t, Wide at, Wide fast) {
                return (push(newtons, p + speed * t, speed, at, fast) - sign * dry) / mass;
            };
            const Wide x1 = v, v1 = a(0, x, v);
            const Wide x2 = v + h / 2 * v1, v2 = a(h / 2, x + h / 2 * x1, x2);
            const Wide x3 = v + h / 2 * v2, v3 = a(h / 2, x + h / 2 * x2, x3);
            const Wide x4 = v + h * v3, v4 = a(h, x + h * x3, x4);
            x += h / 6 * (x1 + 2 * x2 + 2 * x3 + x4);
            v += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
            if (dry > 0 && v * sign < 0) v = 0; // stood still within the step
        }
    }
    [[nodiscard]] double x_off(double other) const { return std::abs(static_cast<double>(x - wide(other))); }
    [[nodiscard]] double v_off(double other) const { return std::abs(static_cast<double>(v - wide(other))); }

private:
    [[nodiscard]] Wide push(Wide newtons, Wide p, Wide speed, Wide at, Wide fast) const {
        return newtons + spring * (p - at) + damper * (speed - fast) - viscous * fast;
    }
    Wide mass, viscous, dry, spring, damper;
};

double energy(const StickSlipMass& m, const State& s, double p) {
    return 0.5 * m.mass * s.v * s.v + 0.5 * m.spring * (s.x - p) * (s.x - p);
}

} // namespace

TEST_CASE("StickSlipMass: free, driven, damped, on a spring: the textbook's formulae",
          "[stick_slip_mass][law]") {
    const double t = 0.013;
    SECTION("a free mass under a constant force") {
        const StickSlipMass m{.mass = 0.25};
        const auto s = m.advance({1, -2}, t, 3, 0, 0);
        CHECK(s.x == Approx(1 - 2 * t + 0.5 * 12 * t * t).epsilon(1e-15));
        CHECK(s.v == Approx(-2 + 12 * t).epsilon(1e-15));
    }
    SECTION("coasting against viscous friction") {
        const StickSlipMass m{.mass = 0.1, .viscous = 2};
        const auto s = m.advance({0, 1}, t, 0, 0, 0);
        CHECK(s.v == Approx(std::exp(-20 * t)).epsilon(1e-14));
        CHECK(s.x == Approx((1 - std::exp(-20 * t)) / 20).epsilon(1e-14));
    }
    SECTION("a spring without friction, thirty periods in one call") {
        const StickSlipMass m{.mass = 0.1, .spring = 1000};
        const double w = 100, long_time = 30 * 2 * 3.14159265358979323846 / w + 0.004;
        const auto s = m.advance({0.01, 0}, long_time, 0, 0, 0);
        CHECK(s.x == Approx(0.01 * std::cos(w * 0.004)).epsilon(1e-11));
        CHECK(s.v == Approx(-1.0 * std::sin(w * 0.004)).epsilon(1e-11));
    }
    SECTION("sliding to rest under dry friction alone") {
        const StickSlipMass m{.mass = 0.5, .dry = 2}; // 4 m/s²: stops after v/4, having gone v²/8
        const auto s = m.advance({0, 0.02}, t, 0, 0, 0);
        CHECK(s.v == 0);
        CHECK(s.x == Approx(0.02 * 0.02 / 8).epsilon(1e-13));
    }
    SECTION("at rest, dry friction bears what it can and no more") {
        const StickSlipMass m{.mass = 0.5, .dry = 2};
        CHECK(m.advance({3, 0}, t, 2, 0, 0).x == 3); // to the bit
        CHECK(m.advance({3, 0}, t, -2, 0, 0).x == 3);
        CHECK(m.advance({3, 0}, t, 2.5, 0, 0).x == Approx(3 + 0.5 * 1.0 * t * t).epsilon(1e-15));
        CHECK(m.advance({3, 0}, t, -2.5, 0, 0).v == Approx(-1.0 * t).epsilon(1e-14));
    }
    SECTION("dragged by a spring, it starts when the spring has the better of dry friction") {
        const StickSlipMass m{.mass = 0.5, .dry = 2, .spring = 1000};
        // p goes 4 mm in 13 ms: 2 N are reached after half of that, and from there on x″ = ω²(speed·τ − x).
        const double speed = 0.004 / t, w = std::sqrt(2000.0), tau = t / 2;
        const auto s = m.advance({0, 0}, t, 0, 0, 0.004);
        CHECK(s.x == Approx(speed * (tau - std::sin(w * tau) / w)).epsilon(1e-11));
        CHECK(s.v == Approx(speed * (1 - std::cos(w * tau))).epsilon(1e-11));
    }
}

TEST_CASE("StickSlipMass: agrees with a thousand Runge-Kutta steps a tick in long double",
          "[stick_slip_mass]") {
    Random random{61};
    for (int n = 0; n < 150; ++n) {
        const auto log_between = [&](double low, double high) {
            return std::exp(random.between(std::log(low), std::log(high)));
        };
        StickSlipMass m{.mass = log_between(0.01, 1),
                        .viscous = random.one_in(3) ? 0 : log_between(1e-3, 10),
                        .dry = 0,
                        .spring = random.one_in(3) ? 0 : log_between(1, 5000),
                        .damper = random.one_in(3) ? 0 : log_between(0.01, 20)};
        State s{random.between(-0.01, 0.01), random.between(-0.3, 0.3)};
        BruteForce b{m, s};
        double p = s.x;
        for (int tick = 0; tick < 20; ++tick) {
            const double f = random.between(-5, 5), to = p + random.between(-2e-4, 2e-4);
            s = m.advance(s, 1e-3, f, p, to);
            b.advance(1e-3, f, p, to, 1000);
            p = to;
        }
        // Runge-Kutta's own error: (fastest·h)⁴ with fastest ≤ 2000/s, h = 1 µs; ours: rounding of 20 ticks.
        CHECK(b.x_off(s.x) < 1e-14);
        CHECK(b.v_off(s.v) < 1e-12);
    }
}

TEST_CASE("StickSlipMass: dry friction, by the same brute force", "[stick_slip_mass]") {
    Random random{62};
    double still = 0;
    for (int n = 0; n < 150; ++n) {
        StickSlipMass m{.mass = random.between(0.03, 0.3),
                        .viscous = random.between(0, 0.1),
                        .dry = random.between(0.02, 0.5),
                        .spring = random.between(50, 1000),
                        .damper = random.between(0, 5)};
        State s{0, random.one_in(2) ? 0 : random.between(-0.05, 0.05)};
        BruteForce b{m, s};
        double p = 0;
        for (int tick = 0; tick < 20; ++tick) {
            const double f = random.between(-1, 1), to = p + random.between(-2e-4, 2e-4);
            s = m.advance(s, 1e-3, f, p, to);
            b.advance(1e-3, f, p, to, 4000);
            p = to;
            still += s.v == 0;
            // A stop is found to a step of 0.25 µs: at up to 60 m/s² that is 15 µm/s, and it does not grow.
            CHECK(b.v_off(s.v) < 3e-5);
            CHECK(b.x_off(s.x) < 3e-8);
        }
    }
    CHECK(still > 150); // of 3000: both states were there
    CHECK(still < 2700);
}

TEST_CASE("StickSlipMass: sees a stop in the middle of a tick that ends as fast as it began",
          "[stick_slip_mass]") {
    // Without the stop: 1 mm/s at both ends and −1 mm/s half way.
    const StickSlipMass m{.mass = 0.1, .dry = 0.5, .spring = 5000};
    const double newtons = -0.3, to = 0.32e-3;
    const auto s = m.advance({0, 1e-3}, 1e-3, newtons, 0, to);
    BruteForce b{m, {0, 1e-3}};
    b.advance(1e-3, newtons, 0, to, 100000);
    CHECK(static_cast<double>(b.v) == Approx(2e-3).epsilon(0.1)); // from rest at ½ ms on
    CHECK(s.v == Approx(static_cast<double>(b.v)).epsilon(1e-4));
    CHECK(s.x == Approx(static_cast<double>(b.x)).epsilon(1e-4));
}

TEST_CASE("StickSlipMass: two halves of a tick make the whole", "[stick_slip_mass][law]") {
    Random random{63};
    for (int n = 0; n < 1000; ++n) {
        const StickSlipMass m{.mass = random.between(0.03, 0.3),
                              .viscous = random.between(0, 0.1),
                              .dry = random.one_in(2) ? 0 : random.between(0.02, 0.5),
                              .spring = random.between(0, 1000),
                              .damper = random.between(0, 5)};
        const State s{random.between(-1e-3, 1e-3), random.between(-0.1, 0.1)};
        const double f = random.between(-2, 2), to = random.between(-1e-3, 1e-3), t = 1e-3;
        const auto whole = m.advance(s, t, f, 0, to);
        const double share = random.between(0.1, 0.9);
        const auto half = m.advance(s, share * t, f, 0, share * to);
        const auto both = m.advance(half, (1 - share) * t, f, share * to, to);
        CHECK(std::abs(both.x - whole.x) < 1e-16);
        CHECK(std::abs(both.v - whole.v) < 1e-13);
    }
}

TEST_CASE("StickSlipMass: left alone, its energy never grows, whatever the friction",
          "[stick_slip_mass][law]") {
    Random random{64};
    for (int n = 0; n < 300; ++n) {
        const StickSlipMass m{.mass = random.between(0.03, 0.3),
                              .viscous = random.between(0, 0.1),
                              .dry = random.one_in(2) ? 0 : random.between(1e-4, 0.5),
                              .spring = random.between(0, 5000),
                              .damper = random.between(0, 5)};
        State s{random.between(-1e-2, 1e-2), random.between(-0.3, 0.3)};
        double before = energy(m, s, 0);
        for (int tick = 0; tick < 200; ++tick) {
            s = m.advance(s, 1e-3, 0, 0, 0);
            const double now = energy(m, s, 0);
            CHECK(now <= before * (1 + 1e-14));
            before = now;
        }
    }
}

TEST_CASE("StickSlipMass: knows what it cannot solve", "[stick_slip_mass]") {
    CHECK(StickSlipMass{}.valid(1e-3));
    CHECK_FALSE(StickSlipMass{.mass = 0}.valid(1e-3));
    CHECK_FALSE(StickSlipMass{.mass = -1}.valid(1e-3));
    CHECK_FALSE(StickSlipMass{.viscous = -1}.valid(1e-3));
    CHECK_FALSE(StickSlipMass{.spring = std::nan("")}.valid(1e-3));
    CHECK_FALSE(StickSlipMass{.damper = HUGE_VAL}.valid(1e-3));
    CHECK_FALSE(StickSlipMass{}.valid(0));
    CHECK_FALSE(StickSlipMass{.mass = 1e-6, .damper = 10}.valid(1e-3)); // 10⁷/s
}
