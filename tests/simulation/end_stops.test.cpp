#include "catch.hpp"
#include "support/random.hpp"

#include <hfh/simulation/driven_axis.hpp>
#include <hfh/simulation/end_stops.hpp>
#include <hfh/simulation/simulated_device.hpp>
#include <hfh/simulation/stick_slip_mass.hpp>

#include <cmath>

using namespace hfh;
using namespace hfh::test;

TEST_CASE("EndStops: between the stops it is the axis without them, to the bit", "[end_stops][law]") {
    Random random{111};
    const StickSlipMass mass{.mass = 0.05, .viscous = 0.01, .dry = 0.1, .spring = 300, .damper = 4};
    const EndStops<StickSlipMass> stops{mass, -0.08, 0.08};
    auto free = mass.at(0, 0.1), stopped = free;
    double p = 0;
    for (int k = 0; k < 5000; ++k) {
        const double f = random.between(-1, 1), to = 0.05 * std::sin(k * 5e-3);
        free = mass.advance(free, 1e-3, f, p, to);
        stopped = stops.advance(stopped, 1e-3, f, p, to);
        p = to;
        CHECK(free.x == stopped.x);
        CHECK(free.v == stopped.v);
    }
}

TEST_CASE("EndStops: a blow ends the motion at the stop, at the instant of the blow", "[end_stops]") {
    // 0.1 kg at 1 m/s, 0.3 mm before the stop, pushed back by 20 N: −200 m/s².
    const EndStops<StickSlipMass> stops{{.mass = 0.1}, -1, 0.3e-3};
    const auto s = stops.advance({0, 1}, 1e-3, -20, 0, 0);
    const double hit = (1 - std::sqrt(1 - 2 * 200 * 0.3e-3)) / 200; // s
    CHECK(s.x == Approx(0.3e-3 - 100 * (1e-3 - hit) * (1e-3 - hit)).epsilon(1e-9));
    CHECK(s.v == Approx(-200 * (1e-3 - hit)).epsilon(1e-9));
    // Pushed on, it stays, to the bit; drawn away, it goes.
    auto held = stops.advance({0, 1}, 1e-3, 5, 0, 0);
    CHECK(held.x == 0.3e-3);
    CHECK(held.v == 0);
    held = stops.advance(held, 1e-3, 5, 0, 0);
    CHECK(held.x == 0.3e-3);
    CHECK(held.v == 0);
    const auto left = stops.advance(held, 1e-3, -5, 0, 0);
    CHECK(left.v == Approx(-0.05));
}

TEST_CASE("EndStops: never beyond, and never more energy than before", "[end_stops][law]") {
    Random random{112};
    int hits = 0;
    for (int n = 0; n < 200; ++n) {
        const StickSlipMass mass{.mass = random.between(0.03, 0.3),
                                 .dry = random.one_in(2) ? 0 : random.between(0.01, 0.3),
                                 .spring = random.between(10, 1000)};
        const EndStops<StickSlipMass> stops{mass, -2e-3, 3e-3};
        auto s = mass.at(0, random.between(-1, 1));
        const auto energy = [&] { return 0.5 * mass.mass * s.v * s.v + 0.5 * mass.spring * s.x * s.x; };
        double before = energy();
        for (int k = 0; k < 300; ++k) {
            s = stops.advance(s, 1e-3, 0, 0, 0);
            CHECK(s.x >= -2e-3);
            CHECK(s.x <= 3e-3);
            hits += s.x == -2e-3 || s.x == 3e-3;
            CHECK(energy() <= before * (1 + 1e-13));
            before = energy();
        }
    }
    CHECK(hits > 100);
}

TEST_CASE("EndStops: one call with a blow in it is many short ones, drawn along by a hand",
          "[end_stops][law]") {
    Random random{113};
    int blows = 0;
    for (int n = 0; n < 200; ++n) {
        const StickSlipMass mass{
            .mass = random.between(0.03, 0.2), .spring = random.between(100, 500), .damper = 2};
        const EndStops<StickSlipMass> stops{mass, -1, 0.3e-3};
        const StickSlipMass::State start{0, random.between(0.4, 1)};
        const double force = random.between(-8, -3), from = random.between(-1e-3, 1e-3),
                     to = from + random.between(-2e-3, 0);
        const auto whole = stops.advance(start, 1e-3, force, from, to);
        auto fine = start;
        for (int k = 0; k < 1000; ++k) {
            fine = stops.advance(fine, 1e-6, force, from + (to - from) * k / 1000,
                                 from + (to - from) * (k + 1) / 1000);
        }
        blows += whole.x < 0.3e-3 && whole.x != mass.advance(start, 1e-3, force, from, to).x;
        CHECK(std::abs(whole.x - fine.x) < 1e-9);
    }
    CHECK(blows > 20); // and then left the stop within the call
}

TEST_CASE("EndStops: the motors of an axis that gives stop, its tip and its amplifier go on", "[end_stops]") {
    const DrivenAxis axis{
        .mass = 0.03, .lag = 0.5e-3, .tip_mass = 0.02, .structure = 3500, .structure_damper = 1};
    const EndStops<DrivenAxis> stops{axis, -1, 0.01};
    auto s = DrivenAxis::at(0.0095, 0.8);
    double farthest = 0;
    for (int k = 0; k < 200; ++k) {
        s = stops.advance(s, 1e-3, 2, 0, 0);
        CHECK(s.x <= 0.01);
        farthest = std::max(farthest, s.tip);
    }
    CHECK(s.x == 0.01);
    CHECK(s.newtons == Approx(2));
    CHECK(farthest > 0.0105); // the linkage bends by the blow
    CHECK(s.tip == Approx(0.01).epsilon(1e-3));
    CHECK(stops.valid(1e-3));
    CHECK_FALSE(EndStops<DrivenAxis>{axis, 1, -1}.valid(1e-3));
    CHECK_FALSE(EndStops<StickSlipMass>{{.mass = 0}, -1, 1}.valid(1e-3));
}
