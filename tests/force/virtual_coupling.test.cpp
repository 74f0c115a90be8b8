#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/presses.hpp"
#include "support/random.hpp"

#include <hfh/device/force_guard.hpp>
#include <hfh/force/virtual_coupling.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace hfh;
using namespace hfh::test;

namespace {

constexpr double stiffness = 500; // N/m

struct Free {
    glm::dvec3 operator()(const glm::dvec3&, const glm::dvec3& newtons) const { return newtons; }
};

/// The force of a coupling alone.
struct Coupled {
    VirtualCoupling coupling{{.stiffness = stiffness}};
    glm::dvec3 operator()(const glm::dvec3& position, const glm::dvec3& newtons) {
        return coupling(position, newtons).newtons;
    }
};

} // namespace

TEST_CASE("VirtualCoupling: the ground is felt as the spring has it, and gives no energy away",
          "[virtual_coupling][law]") {
    for (const HandGrip grip : {HandGrip{100, 0.5}, HandGrip{300, 4}, HandGrip{1000, 10}}) {
        for (const double speed : {0.005, 0.02, 0.1, 0.2, 0.5}) {
            CAPTURE(grip.stiffness, speed);
            const Presses hand{.depth = 0.01, .speed = speed};
            const auto plain = press_wall(simulated_touch, grip, hand, 5, stiffness, Free{});
            const auto coupled = press_wall(simulated_touch, grip, hand, 5, stiffness, Coupled{});
            CHECK(coupled.empty <=
                  5); // the last update of a way out, where the damper is as strong as the spring
            CHECK(coupled.lowest >= -1e-4);
            // A light grip swings under the plain spring; where it comes to rest, it does so at the same depth.
            if (grip.stiffness >= 300 || speed <= 0.1)
                CHECK(coupled.depth == Approx(plain.depth).epsilon(0.1));
            // K·v·T is the spring's own step: 0.05 N at 0.1 m/s.
            if (speed <= 0.1) CHECK(coupled.rise <= 0.11);
            if (speed <= 0.2) CHECK(coupled.beyond <= 0.1);
            if (speed >= 0.1) CHECK(plain.lowest < -1e-4);
        }
    }
}

TEST_CASE("VirtualCoupling: before the guard, which then holds its slew at the motors, both promises hold",
          "[virtual_coupling][force_guard]") {
    for (const double speed : {0.02, 0.1, 0.5}) {
        VirtualCoupling coupling{{.stiffness = stiffness}};
        // Its ramp is over before the ground is met: a force that grows while it is leant on gives that energy away.
        ForceGuard guard{{.max_force = 3.3, .max_slew = 0.5, .ramp = 0.002, .stiffness = stiffness}};
        int updates = 0;
        const Presses hand{.depth = 0.01, .speed = speed};
        const auto felt = press_wall(simulated_touch, {}, hand, 5, stiffness,
                                     [&](const glm::dvec3& at, const glm::dvec3& asked) {
                                         const DeviceSample sample{.time = updates++ * 1e-3, .position = at};
                                         return guard.update(sample, coupling(at, asked).newtons).newtons;
                                     });
        CAPTURE(speed, felt.lowest, felt.rise);
        CHECK(felt.lowest >= -1e-4);
        CHECK(felt.rise <= 0.5);
        CHECK(felt.most > 1.5);
        CHECK(guard.counts().slewed == 0);
    }
}

TEST_CASE(
    "VirtualCoupling: before the guard as README sets them up, with and without delay, gives nothing away",
    "[virtual_coupling][force_guard][regression]") {
    // The damper makes the force rise by more than stiffness × way for an update, and fall again: the guard took that for
    // force that the hand had not made, and held it back until the loop gave energy.
    for (const int delay : {0, 1, 2}) {
        DeviceModel touch = simulated_touch;
        touch.capabilities.delay = delay;
        for (const double speed : {0.02, 0.05, 0.1}) {
            VirtualCoupling coupling{{.stiffness = 400, .lag = 0.5 + delay}};
            ForceGuard guard{guard_limits(touch.capabilities)};
            const Presses hand{.depth = 0.01, .speed = speed};
            // Its ramp is over before the ground is met.
            int updates = 0;
            for (; updates < 600; ++updates)
                (void)guard.update({.time = updates * 1e-3, .position = hand(0.0)}, {0, 0, 0});
            const auto felt =
                press_wall(touch, {}, hand, 5, 400, [&](const glm::dvec3& at, const glm::dvec3& asked) {
                    const DeviceSample sample{.time = updates++ * 1e-3, .position = at};
                    return guard.update(sample, coupling(at, asked).newtons).newtons;
                });
            CAPTURE(delay, speed, felt.lowest, guard.counts().held_back);
            CHECK(felt.lowest >= -1e-4);
            CHECK(guard.counts().held_back == 0);
            CHECK(felt.most > 1);
        }
    }
}

TEST_CASE("VirtualCoupling: takes back in each update what the update before gave away",
          "[virtual_coupling][law]") {
    // A rigid hand at one speed: the spring gives K·T·v·D, the damper takes 1.5 times that.
    for (const int delay : {0, 1, 2}) {
        const double step = 1e-4, depth = 5e-3;
        VirtualCoupling coupling{{.stiffness = stiffness, .lag = 0.5 + delay}};
        double plain = 0, coupled = 0;
        double plain_waits[3]{}, coupled_waits[3]{}; // forces on their way to the motors
        const int updates = 2 * static_cast<int>(depth / step + 3);
        double before = 3 * step;
        for (int k = 0; k <= updates + 4; ++k) {
            const double z = -depth + std::abs(k - updates / 2) * step;
            plain -= plain_waits[delay] * (z - before);
            coupled -= coupled_waits[delay] * (z - before);
            before = z;
            for (int late = 2; late > 0; --late) {
                plain_waits[late] = plain_waits[late - 1];
                coupled_waits[late] = coupled_waits[late - 1];
            }
            plain_waits[0] = z < 0 ? -stiffness * z : 0;
            coupled_waits[0] = coupling({0, 0, z}, {0, 0, plain_waits[0]}).newtons.z;
        }
        const double given = 2 * (0.5 + delay) * stiffness * step * depth;
        CHECK(plain == Approx(-given).epsilon(0.05));
        CHECK(coupled == Approx(0.5 * given).epsilon(0.3));
    }
}

TEST_CASE("VirtualCoupling: where a valley holds the proxy the ground is a spring along both its sides",
          "[virtual_coupling]") {
    // A hand that stirs around the proxy: always across the force, never along it.
    VirtualCoupling coupling{{.stiffness = stiffness}};
    const double radius = 3e-3, turn = 0.05; // m, radians an update
    double plain = 0, coupled = 0;
    glm::dvec3 at{0.0}, plain_force{0.0}, coupled_force{0.0};
    for (int k = 0; k < 2000; ++k) {
        const glm::dvec3 to{radius * std::cos(turn * k), 0, radius * std::sin(turn * k)};
        plain -= glm::dot(plain_force, to - at);
        coupled -= glm::dot(coupled_force, to - at);
        at = to;
        plain_force = -stiffness * at;
        coupled_force = coupling(at, plain_force).newtons;
    }
    const double given = 0.5 * stiffness * radius * radius * turn * turn * 2000;
    CHECK(plain == Approx(-given).epsilon(0.05));
    CHECK(coupled == Approx(0.5 * given).epsilon(0.05));
}

TEST_CASE("VirtualCoupling: on a wall it is a damper of ¾·K·T, from nothing at the surface on",
          "[virtual_coupling][law]") {
    Random random{93};
    VirtualCoupling coupling{{.stiffness = stiffness}};
    double z = -5e-3, before = z;
    (void)coupling({0, 0, z}, {0, 0, -stiffness * z});
    for (int k = 0; k < 20000; ++k) {
        z = std::clamp(z + random.between(-4e-4, 4e-4), -6e-3, 1e-3);
        const double wanted = z < 0 ? -stiffness * z : 0;
        const double got = coupling({random.unit(), 0, z}, {0, 0, wanted}).newtons.z;
        if (before < 0 && z < 0) {
            const double damper = 0.75 * stiffness * (before - z);
            CHECK(got == Approx(wanted + std::clamp(damper, -wanted, wanted)).margin(1e-12));
        }
        if (!(z < 0)) CHECK(got == 0);
        before = z;
    }
}

TEST_CASE("VirtualCoupling: never turns a force back, never more than doubles it, never drives the hand on, "
          "and tells "
          "what it held back",
          "[virtual_coupling][law]") {
    Random random{91};
    VirtualCoupling coupling{{.stiffness = 800, .lag = 1.5}};
    glm::dvec3 at{0.0};
    int damped = 0;
    for (int k = 0; k < 20000; ++k) {
        const glm::dvec3 step{random.between(-1e-3, 1e-3), random.between(-1e-3, 1e-3),
                              random.between(-1e-3, 1e-3)};
        // Forces that no ground has: they leap as they like.
        const glm::dvec3 wanted{random.between(-2, 2), random.between(-2, 2), random.between(-2, 2)};
        at += step;
        const auto got = coupling(at, wanted);
        const glm::dvec3 damper = got.newtons - wanted;
        const double length = glm::length(wanted);
        CHECK(glm::dot(got.newtons, wanted) >= -1e-12);
        CHECK(glm::length(got.newtons) <= 2 * length * (1 + 1e-12));
        CHECK(glm::length(damper) <= 2.25 * 800 * glm::length(step) * (1 + 1e-9));
        CHECK(glm::dot(damper, step) <= 1e-15);
        CHECK(got.held_back == Approx(length - glm::length(got.newtons)).margin(1e-14));
        damped += damper != glm::dvec3{0.0};
    }
    CHECK(damped > 5000);
}

TEST_CASE(
    "VirtualCoupling: to a guard told (1 + 1.5·lag)·K no rise of its force is sudden, to one told K some are",
    "[virtual_coupling][force_guard][law]") {
    for (const double lag : {0.5, 1.5, 2.5}) {
        CAPTURE(lag);
        VirtualCoupling coupling{{.stiffness = stiffness, .lag = lag}};
        const GuardLimits limits{.max_force = 1e3, .max_slew = 1e3, .ramp = 0.01, .max_sudden = 1e-9};
        GuardLimits behind = limits, plain = limits;
        behind.stiffness = (1 + 1.5 * lag) * stiffness;
        plain.stiffness = stiffness;
        ForceGuard told{behind}, not_told{plain};
        Random random{7};
        glm::dvec3 at{0, 0, 5e-3};
        for (int n = 1; n <= 20000; ++n) {
            // Sets out, turns, stops, and comes out now and then, at one speed.
            at.z = std::clamp(at.z + 4e-4 * std::round(random.between(-1.5, 1.5)), -5e-3, 3e-3);
            const glm::dvec3 newtons = coupling(at, {0, 0, std::max(0.0, -stiffness * at.z)}).newtons;
            const DeviceSample sample{.time = n * 1e-3, .position = at};
            (void)told.update(sample, newtons);
            (void)not_told.update(sample, newtons);
        }
        CHECK(told.counts().held_back == 0);
        CHECK(not_told.counts().held_back > 1000);
    }
}

TEST_CASE("VirtualCoupling: a scene that changes under a still hand comes as it is", "[virtual_coupling]") {
    VirtualCoupling coupling{{.stiffness = stiffness}};
    (void)coupling({0, 0, -1e-3}, {0, 0, 0.5});
    CHECK(coupling({0, 0, -1e-3}, {0, 0, 3.0}).newtons.z == 3.0);
    // One that moves by a step: as far as the step explains.
    CHECK(coupling({0, 0, -1.1e-3}, {0.5, 0, 1.0}).newtons == glm::dvec3{0.5, 0, 1.0}); // would drive it on
    const auto leapt = coupling({0, 0, -1.2e-3}, {0.5, 0, 3.0});
    CHECK(leapt.newtons.z == Approx(3.0 + 0.75 * stiffness * 1e-4));
}

TEST_CASE("VirtualCoupling: at rest, along the surface and in the air it changes nothing, to the bit",
          "[virtual_coupling]") {
    VirtualCoupling coupling{{.stiffness = stiffness}};
    const glm::dvec3 wanted{0, 0, 1.3};
    CHECK(coupling({0, 0, -1e-3}, wanted).newtons == wanted); // the first position
    CHECK(coupling({0, 0, -1e-3}, wanted).newtons == wanted);
    CHECK(coupling({1e-3, 0, -1e-3}, wanted).newtons == wanted);
    CHECK(coupling({1e-3, 2e-3, -1e-3}, wanted).held_back == 0);
    CHECK(coupling({1e-3, 0, 4e-3}, glm::dvec3{0.0}).newtons == glm::dvec3{0.0});
    VirtualCoupling none{{.stiffness = 0}};
    (void)none({0, 0, 0}, wanted);
    CHECK(none({0, 0, -1}, 2.0 * wanted).newtons == 2.0 * wanted);
}

TEST_CASE("VirtualCoupling: passes on what is no number, starts anew behind it, and allocates nothing",
          "[virtual_coupling]") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const glm::dvec3 wanted{0, 0, 1}, more{0, 0, 1.05};
    const auto before = allocations();
    VirtualCoupling coupling{{.stiffness = stiffness}};
    (void)coupling({0, 0, 0}, wanted);
    const auto lost = coupling({0, 0, nan}, more);
    const auto after_lost = coupling({0, 0, -1e-4}, wanted);
    const auto next = coupling({0, 0, -2e-4}, more);
    const auto bad = coupling({0, 0, -3e-4}, {0, nan, 1});
    const auto after_bad = coupling({0, 0, -4e-4}, wanted);
    coupling.reset();
    const auto anew = coupling({0, 0, -5e-4}, more);
    VirtualCoupling odd{{.stiffness = nan}}, odd_lag{{.stiffness = stiffness, .lag = nan}};
    (void)odd({0, 0, 0}, wanted);
    (void)odd_lag({0, 0, 0}, wanted);
    const auto passed = odd({0, 0, -1e-4}, more), passed_too = odd_lag({0, 0, -1e-4}, more);
    const auto after = allocations();
    CHECK(after == before);
    CHECK(lost.newtons == more);
    CHECK(after_lost.newtons == wanted);
    CHECK(next.held_back == Approx(-0.75 * 0.05));
    CHECK(std::isnan(bad.newtons.y));
    CHECK(after_bad.newtons == wanted);
    CHECK(anew.newtons == more);
    CHECK(passed.newtons == more);
    CHECK(passed_too.newtons == more);
}
