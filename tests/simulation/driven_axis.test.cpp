#include "catch.hpp"
#include "support/random.hpp"

#include <hfh/simulation/driven_axis.hpp>
#include <hfh/simulation/simulated_device.hpp>
#include <hfh/simulation/stick_slip_mass.hpp>

#include <cmath>

using namespace hfh;
using namespace hfh::test;

namespace {

using State = DrivenAxis::State;
using Wide = long double;

/// The same equations by many small steps of Runge-Kutta of fourth order in long double, dry friction by Karnopp's
/// switch at every step. Shares nothing with the header but the numbers that describe the axis.
class FineSteps {
public:
    Wide y[5]; // motors: place and speed; tip: place and speed; motor force

    FineSteps(const DrivenAxis& axis, const State& s)
        : y{Wide(s.x), Wide(s.v), Wide(s.tip), Wide(s.tip_v), Wide(s.newtons)}, a_{axis} {}

    void advance(double seconds, double command, double from, double to, long steps) {
        const Wide h = Wide(seconds) / Wide(steps), rate = (Wide(to) - Wide(from)) / Wide(seconds);
        for (long n = 0; n < steps; ++n) {
            const Wide p = Wide(from) + rate * h * Wide(n);
            // At rest with friction enough: stays for this step. Else slides one way.
            int way = y[1] > 0 ? 1 : y[1] < 0 ? -1 : 0;
            bool stuck = false;
            if (a_.dry > 0 && way == 0) {
                Wide rates[5];
                derive(y, command, p, rate, 0, false, rates);
                const Wide net = rates[1] * Wide(a_.mass);
                stuck = std::abs(net) <= Wide(a_.dry);
                way = net > 0 ? 1 : -1;
            }
            Wide k1[5], k2[5], k3[5], k4[5], z[5];
            derive(y, command, p, rate, way, stuck, k1);
            for (int i = 0; i < 5; ++i) z[i] = y[i] + h / 2 * k1[i];
            derive(z, command, p + rate * h / 2, rate, way, stuck, k2);
            for (int i = 0; i < 5; ++i) z[i] = y[i] + h / 2 * k2[i];
            derive(z, command, p + rate * h / 2, rate, way, stuck, k3);
            for (int i = 0; i < 5; ++i) z[i] = y[i] + h * k3[i];
            derive(z, command, p + rate * h, rate, way, stuck, k4);
            for (int i = 0; i < 5; ++i) y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
            if (a_.dry > 0 && y[1] * way < 0) y[1] = 0; // stood still within the step
        }
    }
    [[nodiscard]] double x_off(double other) const {
        return std::abs(static_cast<double>(y[0] - Wide(other)));
    }
    [[nodiscard]] double v_off(double other) const {
        return std::abs(static_cast<double>(y[1] - Wide(other)));
    }
    [[nodiscard]] double tip_off(double other) const {
        return std::abs(static_cast<double>(y[2] - Wide(other)));
    }

private:
    void derive(const Wide (&s)[5], double command, Wide p, Wide p_rate, int way, bool stuck,
                Wide (&out)[5]) const {
        const bool two = a_.tip_mass > 0;
        const Wide motor_force = a_.lag > 0 ? s[4] : Wide(command);
        const Wide grip_place = two ? s[2] : s[0], grip_speed = two ? s[3] : s[1];
        const Wide hand = Wide(a_.spring) * (p - grip_place) + Wide(a_.damper) * (p_rate - grip_speed);
        const Wide link =
            two ? Wide(a_.structure) * (s[2] - s[0]) + Wide(a_.structure_damper) * (s[3] - s[1]) : Wide(0);
        const Wide on_motors =
            motor_force - Wide(a_.viscous) * s[1] + (two ? link : hand) - way * Wide(a_.dry);
        out[0] = stuck ? Wide(0) : s[1];
        out[1] = stuck ? Wide(0) : on_motors / Wide(a_.mass) + Wide(a_.gravity);
        out[2] = two ? s[3] : Wide(0);
        out[3] = two ? (hand - link) / Wide(a_.tip_mass) + Wide(a_.gravity) : Wide(0);
        out[4] = a_.lag > 0 ? (Wide(command) - s[4]) / Wide(a_.lag) : Wide(0);
    }
    DrivenAxis a_;
};

/// Any axis; `dry`: with dry friction.
DrivenAxis any_axis(Random& random, bool dry) {
    DrivenAxis axis{.mass = random.between(0.03, 0.2),
                    .viscous = random.between(0, 0.2),
                    .dry = dry ? random.between(0.02, 0.4) : 0,
                    .spring = random.between(50, 1000),
                    .damper = random.between(0, 6),
                    .lag = random.one_in(3) ? 0 : random.between(0.1e-3, 2e-3),
                    .gravity = random.one_in(2) ? 0 : random.between(-9.81, 9.81)};
    if (!random.one_in(3)) {
        axis.tip_mass = random.between(0.01, 0.1);
        axis.structure = random.between(500, 20000);
        axis.structure_damper = random.between(0, 2);
    }
    return axis;
}

double energy(const DrivenAxis& a, const State& s, double p) {
    const double held = a.tip_mass > 0 ? s.tip : s.x;
    const double motors = 0.5 * a.mass * s.v * s.v - a.mass * a.gravity * s.x;
    const double hand = 0.5 * a.spring * (held - p) * (held - p);
    if (!(a.tip_mass > 0)) return motors + hand;
    return motors + hand + 0.5 * a.tip_mass * s.tip_v * s.tip_v - a.tip_mass * a.gravity * s.tip +
           0.5 * a.structure * (s.tip - s.x) * (s.tip - s.x);
}

struct Still {
    glm::dvec3 operator()(double) const noexcept { return glm::dvec3{0.0}; }
};

/// By what factor a swing on a wall of `stiffness`, leant on with 0.5 N, grows from the first second to the last of 5.
double growth(const DrivenAxis& axis, int delay, double stiffness) {
    SimulatedDevice device{DeviceCapabilities{.rate = 1000, .delay = delay}, SameAxes<DrivenAxis>{axis},
                           AxisEncoders{}, Still{}, 5};
    const double rest = -0.5 / stiffness;
    device.place({0, 0, rest}, {0, 0, 1e-4});
    double first = 0, last = 0;
    for (int k = 0; k < 5000; ++k) {
        const double z = device.sample().position.z;
        if (k < 1000) first = std::max(first, std::abs(z - rest));
        if (k >= 4000) last = std::max(last, std::abs(z - rest));
        device.step({0, 0, -stiffness * z - 0.5});
    }
    return last / first;
}

} // namespace

TEST_CASE("DrivenAxis: lag, linkage and weight alone: the textbook's formulae", "[driven_axis][law]") {
    const double t = 0.0123;
    SECTION("a free mass behind an amplifier that lags") {
        const double lag = 0.7e-3, u = 2;
        const DrivenAxis axis{.mass = 0.25, .lag = lag};
        const auto s = axis.advance({}, t, u, 0, 0);
        const double passed = lag * (1 - std::exp(-t / lag));
        CHECK(s.newtons == Approx(u * (1 - std::exp(-t / lag))).epsilon(1e-14));
        CHECK(s.v == Approx(u / 0.25 * (t - passed)).epsilon(1e-13));
        CHECK(s.x == Approx(u / 0.25 * (t * t / 2 - lag * (t - passed))).epsilon(1e-12));
    }
    SECTION("two masses on a spring swing against each other") {
        const DrivenAxis axis{.mass = 0.05, .tip_mass = 0.03, .structure = 3500};
        const double w = std::sqrt(3500 / 0.05 + 3500 / 0.03), apart = 1e-3;
        const auto s = axis.advance({.x = 0, .v = 0, .tip = apart, .tip_v = 0}, t, 0, 0, 0);
        CHECK(s.tip - s.x == Approx(apart * std::cos(w * t)).epsilon(1e-11));
        CHECK(0.05 * s.x + 0.03 * s.tip == Approx(0.03 * apart).epsilon(1e-13)); // the centre stays
        CHECK(0.05 * s.v + 0.03 * s.tip_v == Approx(0).margin(1e-16));
    }
    SECTION("weight") {
        const DrivenAxis falls{.mass = 0.05, .gravity = -9.81, .tip_mass = 0.03, .structure = 3500};
        const auto s = falls.advance(DrivenAxis::at(0, 0), t, 0, 0, 0);
        CHECK(s.x == Approx(-9.81 / 2 * t * t).epsilon(1e-13));
        CHECK(s.tip == Approx(s.x).epsilon(1e-13));
        // Dry friction carries it up to the weight of the motors, not more.
        const DrivenAxis held{.mass = 0.05, .dry = 0.5, .gravity = -9.81};
        CHECK(held.advance(DrivenAxis::at(1, 0), t, 0, 0, 0).x == 1);
        const DrivenAxis slips{.mass = 0.05, .dry = 0.48, .gravity = -9.81};
        CHECK(slips.advance(DrivenAxis::at(1, 0), t, 0, 0, 0).v ==
              Approx((0.48 / 0.05 - 9.81) * t).epsilon(1e-12));
    }
}

TEST_CASE("DrivenAxis: with nothing between command and hand it is a StickSlipMass", "[driven_axis][law]") {
    Random random{101};
    for (int n = 0; n < 200; ++n) {
        const StickSlipMass plain{.mass = random.between(0.03, 0.3),
                                  .viscous = random.between(0, 0.1),
                                  .dry = random.one_in(3) ? 0 : random.between(0.02, 0.5),
                                  .spring = random.between(0, 1000),
                                  .damper = random.between(0, 5)};
        const DrivenAxis axis{.mass = plain.mass,
                              .viscous = plain.viscous,
                              .dry = plain.dry,
                              .spring = plain.spring,
                              .damper = plain.damper};
        StickSlipMass::State m{0, random.between(-0.05, 0.05)};
        State s = DrivenAxis::at(m.x, m.v);
        double p = 0;
        for (int tick = 0; tick < 100; ++tick) {
            const double f = random.between(-1, 1), to = p + random.between(-2e-4, 2e-4);
            m = plain.advance(m, 1e-3, f, p, to);
            s = axis.advance(s, 1e-3, f, p, to);
            p = to;
            CHECK(std::abs(s.x - m.x) < 1e-15);
            CHECK(std::abs(s.v - m.v) < 2e-12);
        }
    }
}

TEST_CASE("DrivenAxis: agrees with a thousand Runge-Kutta steps a tick in long double", "[driven_axis]") {
    Random random{102};
    for (int n = 0; n < 60; ++n) {
        const DrivenAxis axis = any_axis(random, false);
        State s = DrivenAxis::at(random.between(-0.01, 0.01), random.between(-0.3, 0.3));
        FineSteps fine{axis, s};
        double p = s.x;
        for (int tick = 0; tick < 20; ++tick) {
            const double f = random.between(-5, 5), to = p + random.between(-2e-4, 2e-4);
            s = axis.advance(s, 1e-3, f, p, to);
            fine.advance(1e-3, f, p, to, 1000);
            p = to;
        }
        // Runge-Kutta's own error: (rate·h)⁴ with rates up to 10⁴/s and h = 1 µs, on 0.1 m/s.
        CHECK(fine.x_off(s.x) < 1e-12);
        CHECK(fine.v_off(s.v) < 1e-9);
        if (axis.tip_mass > 0) CHECK(fine.tip_off(s.tip) < 1e-12);
    }
}

TEST_CASE("DrivenAxis: dry friction, by the same fine steps", "[driven_axis]") {
    Random random{103};
    int still = 0;
    for (int n = 0; n < 60; ++n) {
        const DrivenAxis axis = any_axis(random, true);
        State s = DrivenAxis::at(0, random.one_in(2) ? 0 : random.between(-0.05, 0.05));
        FineSteps fine{axis, s};
        double p = 0;
        for (int tick = 0; tick < 20; ++tick) {
            const double f = random.between(-1, 1), to = p + random.between(-2e-4, 2e-4);
            s = axis.advance(s, 1e-3, f, p, to);
            fine.advance(1e-3, f, p, to, 4000);
            p = to;
            still += s.v == 0;
            // A stop is found to a step of 0.25 µs, as for StickSlipMass.
            CHECK(fine.v_off(s.v) < 5e-5);
            CHECK(fine.x_off(s.x) < 5e-8);
        }
    }
    CHECK(still > 50); // of 1200: both states were there
    CHECK(still < 1100);
}

TEST_CASE("DrivenAxis: slides to rest and stands there, to the bit, sees a stop between two ends that move",
          "[driven_axis]") {
    const DrivenAxis slides{.mass = 0.5, .dry = 2, .lag = 1e-3}; // 4 m/s²: stops after v/4, having gone v²/8
    auto s = slides.advance(DrivenAxis::at(0, 0.02), 0.013, 0, 0, 0);
    CHECK(s.v == 0);
    CHECK(s.x == Approx(0.02 * 0.02 / 8).epsilon(1e-12));
    const double stopped = s.x;
    for (int k = 0; k < 10; ++k) {
        s = slides.advance(s, 1e-3, 1.9, 0, 0);
        CHECK(s.v == 0);
        CHECK(s.x == stopped);
    }
    // Without the stop: 1 mm/s at both ends and −1 mm/s half way, as for StickSlipMass.
    const DrivenAxis dips{.mass = 0.1, .dry = 0.5, .spring = 5000};
    const auto end = dips.advance(DrivenAxis::at(0, 1e-3), 1e-3, -0.3, 0, 0.32e-3);
    FineSteps fine{dips, DrivenAxis::at(0, 1e-3)};
    fine.advance(1e-3, -0.3, 0, 0.32e-3, 100000);
    CHECK(static_cast<double>(fine.y[1]) == Approx(2e-3).epsilon(0.1)); // from rest at ½ ms on
    CHECK(end.v == Approx(static_cast<double>(fine.y[1])).epsilon(1e-4));
    CHECK(end.x == Approx(static_cast<double>(fine.y[0])).epsilon(1e-4));
}

TEST_CASE("DrivenAxis: misses no stop that StickSlipMass sees, however short", "[driven_axis]") {
    // The speed dips to nothing and a little beyond between two of the instants that are looked at.
    const StickSlipMass plain{.mass = 0.1, .dry = 0.5, .spring = 5000};
    const DrivenAxis axis{.mass = 0.1, .dry = 0.5, .spring = 5000};
    int stopped = 0;
    for (int n = 0; n < 400; ++n) {
        const double newtons = -0.02 + n * 1e-4;
        const auto m = plain.advance({0, 1e-3}, 1e-3, newtons, 0, 0.25e-3);
        const auto s = axis.advance(DrivenAxis::at(0, 1e-3), 1e-3, newtons, 0, 0.25e-3);
        const auto free = DrivenAxis{.mass = 0.1, .spring = 5000}.advance(DrivenAxis::at(0, 1e-3), 1e-3,
                                                                          newtons - 0.5, 0, 0.25e-3);
        stopped += std::abs(m.v - free.v) > 1e-12;
        CHECK(std::abs(s.v - m.v) < 1e-10);
        CHECK(std::abs(s.x - m.x) < 1e-13);
    }
    CHECK(stopped > 50);
    CHECK(stopped < 350);
}

TEST_CASE("DrivenAxis: two seconds in a loop with a wall, within 5·10⁻⁸ m of steps of a microsecond",
          "[driven_axis][law]") {
    // A Touch with all that this header adds, pressed against 500 N/m by a hand that trembles.
    const DrivenAxis axis{.mass = 0.025,
                          .viscous = 0.005,
                          .dry = 0.26,
                          .spring = 300,
                          .damper = 4,
                          .lag = 0.5e-3,
                          .gravity = -1,
                          .tip_mass = 0.02,
                          .structure = 3500,
                          .structure_damper = 0.3};
    const auto hand = [](double t) { return 1e-3 - 6e-3 * std::min(1.0, t / 0.4) + 2e-4 * std::sin(60 * t); };
    State s = DrivenAxis::at(hand(0), 0);
    FineSteps fine{axis, s};
    double worst = 0, deepest = 0, felt = 0;
    for (int k = 0; k < 2000; ++k) {
        const double from = hand(k * 1e-3), to = hand((k + 1) * 1e-3);
        // Each goes by its own positions.
        const auto wall = [](double z) { return z < 0 ? -500 * z : 0.0; };
        fine.advance(1e-3, wall(static_cast<double>(fine.y[0])), from, to, 1000);
        s = axis.advance(s, 1e-3, wall(s.x), from, to);
        worst = std::max({worst, fine.x_off(s.x), fine.tip_off(s.tip)});
        deepest = std::min(deepest, s.x);
        felt = std::max(felt, s.newtons);
    }
    CHECK(worst < 5e-8);
    CHECK(deepest < -1e-3);
    CHECK(felt > 0.5);
}

TEST_CASE("DrivenAxis: two halves of a tick make the whole", "[driven_axis][law]") {
    Random random{104};
    for (int n = 0; n < 500; ++n) {
        const DrivenAxis axis = any_axis(random, random.one_in(2));
        State s = DrivenAxis::at(random.between(-1e-3, 1e-3), random.between(-0.1, 0.1));
        s.newtons = random.between(-1, 1);
        const double f = random.between(-2, 2), to = random.between(-1e-3, 1e-3), t = 1e-3;
        const auto whole = axis.advance(s, t, f, 0, to);
        const double share = random.between(0.1, 0.9);
        const auto half = axis.advance(s, share * t, f, 0, share * to);
        const auto both = axis.advance(half, (1 - share) * t, f, share * to, to);
        CHECK(std::abs(both.x - whole.x) < 1e-15);
        CHECK(std::abs(both.v - whole.v) < 1e-12);
        CHECK(std::abs(both.newtons - whole.newtons) < 1e-14);
    }
}

TEST_CASE("DrivenAxis: left alone it keeps its energy without friction, and never gains any with it",
          "[driven_axis][law]") {
    Random random{105};
    for (int n = 0; n < 200; ++n) {
        DrivenAxis axis = any_axis(random, n % 2 == 0);
        axis.lag = 0;
        if (n % 2 == 1) axis.viscous = axis.damper = axis.structure_damper = 0;
        State s = DrivenAxis::at(random.between(-1e-2, 1e-2), random.between(-0.3, 0.3));
        s.tip += axis.tip_mass > 0 ? random.between(-1e-3, 1e-3) : 0;
        const double start = energy(axis, s, 0), scale = std::abs(start) + 1e-3;
        double before = start;
        for (int tick = 0; tick < 300; ++tick) {
            s = axis.advance(s, 1e-3, 0, 0, 0);
            const double now = energy(axis, s, 0);
            if (n % 2 == 1) CHECK(std::abs(now - start) <= 1e-12 * scale);
            CHECK(now <= before + 1e-13 * scale);
            before = now;
        }
    }
}

TEST_CASE("DrivenAxis: the critical stiffness of a wall behind a lagging amplifier is b/(T/2 + delay·T + τ)",
          "[driven_axis][law]") {
    for (const double viscous : {0.05, 0.2, 0.5}) {
        for (const double lag : {0.0, 0.25e-3, 0.5e-3, 1e-3}) {
            for (const int delay : {0, 1}) {
                const DrivenAxis axis{.mass = 0.045, .viscous = viscous, .lag = lag};
                const double critical = viscous / (0.5e-3 + delay * 1e-3 + lag);
                CAPTURE(viscous, lag, delay, critical);
                CHECK(growth(axis, delay, 0.95 * critical) < 1);
                CHECK(growth(axis, delay, 1.05 * critical) > 1);
            }
        }
    }
}

TEST_CASE("DrivenAxis: knows what it cannot solve", "[driven_axis]") {
    CHECK(DrivenAxis{}.valid(1e-3));
    CHECK(DrivenAxis{.lag = 1e-4, .gravity = -9.81, .tip_mass = 0.02, .structure = 3500}.valid(1e-3));
    CHECK_FALSE(DrivenAxis{.mass = 0}.valid(1e-3));
    CHECK_FALSE(DrivenAxis{.viscous = -1}.valid(1e-3));
    CHECK_FALSE(DrivenAxis{.lag = std::nan("")}.valid(1e-3));
    CHECK_FALSE(DrivenAxis{.lag = 1e-7}.valid(1e-3)); // 10⁷/s
    CHECK_FALSE(DrivenAxis{.gravity = HUGE_VAL}.valid(1e-3));
    CHECK_FALSE(DrivenAxis{.tip_mass = 0.02}.valid(1e-3));
    CHECK_FALSE(DrivenAxis{}.valid(0));
}
