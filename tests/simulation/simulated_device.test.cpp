#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/random.hpp"

#include <hfh/simulation/driven_axis.hpp>
#include <hfh/simulation/end_stops.hpp>
#include <hfh/simulation/simulated_device.hpp>

#include <glm/geometric.hpp>

#include <cmath>
#include <cstring>
#include <vector>

using namespace hfh;
using namespace hfh::test;

namespace {

struct Still {
    glm::dvec3 operator()(double) const noexcept { return at; }
    glm::dvec3 at{0.0};
};
struct Circle {
    glm::dvec3 operator()(double t) const noexcept {
        return {0.02 * std::cos(9 * t), 0.02 * std::sin(9 * t), 0.01 * std::sin(5 * t)};
    }
};
static_assert(Device<SimulatedDevice<Still>>);
static_assert(Device<SimulatedDevice<Circle>>);
using Walled = EndStops<DrivenAxis>;
static_assert(Device<SimulatedDevice<Circle, OwnAxes<Walled>, JointEncoders>>);

// A plain device has no room for what it is not made of.
static_assert(sizeof(SimulatedDevice<Circle>) ==
              sizeof(DeviceCapabilities) + sizeof(StickSlipMass) + sizeof(AxisEncoders) +
                  2 * sizeof(double) + // the path, padded, and the seconds
                  (2 + 2 + SimulatedDevice<Circle>::max_delay) * sizeof(glm::dvec3) +
                  sizeof(unsigned long long));

DeviceModel plain(double rate = 1000) { return {.mass = 0.1, .capabilities = {.rate = rate}}; }
constexpr HandGrip no_hand{0, 0};

} // namespace

TEST_CASE("SimulatedDevice: holds each force for one update, whatever the rate", "[simulated_device][law]") {
    for (const double rate : {1000.0, 4000.0}) {
        SimulatedDevice device{plain(rate), no_hand, Still{}, 1};
        const double period = 1 / rate;
        double x = 0, v = 0; // 0.1 kg, pushed by 1 N, 2 N, …
        for (int k = 1; k <= 10; ++k) {
            const auto sample = device.step({0, 0, k});
            x += v * period + 5 * k * period * period;
            v += 10 * k * period;
            CHECK(sample.time == Approx(k * period));
            CHECK(sample.position.z == Approx(x).epsilon(1e-13));
            CHECK(device.velocity().z == Approx(v).epsilon(1e-13));
            CHECK(sample.position.x == 0);
            CHECK_FALSE(sample.has_velocity);
        }
    }
}

TEST_CASE("SimulatedDevice: a force comes late by the delay, no more and no less", "[simulated_device]") {
    for (int delay = 0; delay <= 8; ++delay) {
        DeviceModel model = plain();
        model.capabilities.delay = delay;
        SimulatedDevice device{model, no_hand, Still{}, 1};
        REQUIRE(device.valid());
        for (int k = 0; k < 30; ++k) {
            device.step({k + 1.0, -k, 0});
            const double then = k - delay;
            CHECK(device.held() == (then < 0 ? glm::dvec3{0.0} : glm::dvec3{then + 1, -then, 0}));
        }
    }
}

TEST_CASE("SimulatedDevice: tells the force that it took, shortened, when it took it, whatever the delay",
          "[simulated_device]") {
    for (int delay = 0; delay <= 8; ++delay) {
        DeviceModel model = plain();
        model.capabilities.delay = delay;
        model.capabilities.max_force = 10;
        SimulatedDevice device{model, no_hand, Still{}, 1};
        CHECK_FALSE(device.sample().has_sent);
        for (int k = 0; k < 30; ++k) {
            const auto sample = device.step({k + 1.0, 0, 0});
            CHECK(sample.has_sent);
            CHECK(sample.sent == glm::dvec3{std::min(10.0, k + 1.0), 0, 0});
            CHECK(sample.sent_at == k / 1000.0);
        }
    }
}

TEST_CASE("SimulatedDevice: encoders round, motors shorten", "[simulated_device]") {
    DeviceModel model = plain();
    model.capabilities.resolution = 1e-4;
    model.capabilities.max_force = 2;
    Random random{71};
    SimulatedDevice device{model, {200, 3}, Circle{}, 1};
    double largest = 0, between = 0;
    for (int k = 0; k < 500; ++k) {
        const glm::dvec3 wanted{random.between(-3, 3), random.between(-3, 3), random.between(-3, 3)};
        const auto sample = device.step(wanted);
        for (int axis = 0; axis < 3; ++axis) {
            const double off = sample.position[axis] - device.position()[axis];
            CHECK(std::abs(off) <= 0.5e-4 * (1 + 1e-9));
            CHECK(std::abs(sample.position[axis] / 1e-4 - std::round(sample.position[axis] / 1e-4)) < 1e-9);
            between = std::max(between, std::abs(off));
        }
        const double length = glm::length(wanted);
        CHECK(glm::length(device.held()) == Approx(std::min(2.0, length)));
        CHECK(glm::length(glm::cross(device.held(), wanted)) < 1e-12); // the direction stays
        largest = std::max(largest, length);
    }
    CHECK(between > 0.4e-4);
    CHECK(largest > 3);
}

TEST_CASE("SimulatedDevice: a hand draws it along, and lags by no more than friction and mass make it",
          "[simulated_device]") {
    SimulatedDevice device{simulated_touch, {.stiffness = 300, .damping = 4}, Circle{}, 5};
    double farthest = 0;
    for (int k = 0; k < 5000; ++k) {
        device.step({});
        if (k >= 1000) farthest = std::max(farthest, glm::length(device.position() - device.hand()));
    }
    // Dry friction on each axis: 0.26 N / 300 N/m = 0.87 mm, √3 of it in all; the mass on its circle adds 0.24 mm.
    CHECK(farthest > 0.5e-3);
    CHECK(farthest < 1.8e-3);
}

TEST_CASE("SimulatedDevice: run calls once an update, in order, and ends as it is told",
          "[simulated_device]") {
    SimulatedDevice device{simulated_touch, {}, Circle{}, 0.25};
    int calls = 0;
    CHECK(device.run([&](const DeviceSample& sample) -> DeviceCommand {
        CHECK(sample.time == Approx(calls++ / 1000.0).margin(1e-15));
        return {.newtons = {0.1, 0, 0}};
    }) == DeviceEnd::stopped);
    CHECK(calls == 250);
    CHECK(device.held() == glm::dvec3{0.0});

    SimulatedDevice second{simulated_touch, {}, Circle{}, 1};
    calls = 0;
    CHECK(second.run([&](const DeviceSample&) -> DeviceCommand {
        return {.newtons = {0.1, 0, 0}, .go_on = ++calls < 7};
    }) == DeviceEnd::stopped);
    CHECK(calls == 7);

    SimulatedDevice third{simulated_touch, {}, Circle{}, 1};
    calls = 0;
    CHECK(third.run([&](const DeviceSample&) -> DeviceCommand {
        return {.newtons = {0, 0, ++calls < 3 ? 0.0 : std::nan("")}};
    }) == DeviceEnd::force_fault);
    CHECK(calls == 3);
    CHECK(is_finite(third.position()));
    CHECK(third.held() == glm::dvec3{0.0});
}

TEST_CASE("SimulatedDevice: each axis in its own way: inertia, weight, and the walls of the workspace",
          "[simulated_device]") {
    const DrivenAxis heavy{.mass = 0.2}, light{.mass = 0.05}, hangs{.mass = 0.1, .gravity = -9.81};
    SimulatedDevice device{
        DeviceCapabilities{.rate = 1000, .workspace = {0.1, 0.1, 0.1}},
        OwnAxes<Walled>{{{heavy, -0.05, 0.05}, {light, -0.05, 0.05}, {hangs, -0.05, 0.05}}}, AxisEncoders{},
        Still{}, 1};
    REQUIRE(device.valid());
    for (int k = 1; k <= 100; ++k) {
        device.step({1, 1, 0});
        const double half_t2 = 0.5 * k * k * 1e-6;
        CHECK(device.position().x == Approx(std::min(5 * half_t2, 0.05)).epsilon(1e-9));
        CHECK(device.position().y == Approx(std::min(20 * half_t2, 0.05)).epsilon(1e-9));
        CHECK(device.position().z == Approx(std::max(-9.81 * half_t2, -0.05)).epsilon(1e-9));
    }
    CHECK(device.position().y == 0.05); // there since 71 ms
    CHECK(device.velocity().y == 0);
    CHECK(device.velocity().x == Approx(0.5));
    for (int k = 0; k < 100; ++k) device.step({0, -1, 0});
    CHECK(device.position().y < 0.05);
}

TEST_CASE("SimulatedDevice: with encoders in its joints it tells counts, and moves as it does",
          "[simulated_device]") {
    const JointEncoders arm{.shoulder = {0, 0.2, 0}, .step = 2e-4};
    const SameAxes<StickSlipMass> axes{{.mass = 0.045, .dry = 0.26, .spring = 300, .damper = 4}};
    SimulatedDevice device{simulated_touch.capabilities, axes, arm, Circle{}, 1};
    SimulatedDevice plain{simulated_touch, {}, Circle{}, 1};
    double off = 0;
    for (int k = 0; k < 500; ++k) {
        const auto sample = device.step({});
        plain.step({});
        CHECK(sample.position == arm(device.position()));
        off = std::max(off, glm::length(sample.position - device.position()));
        CHECK(glm::length(device.position() - plain.position()) < 2e-4); // but for its viscous friction
    }
    CHECK(off > 10e-6);
    CHECK(off < 40e-6);
}

TEST_CASE("SimulatedDevice: a model that makes no sense does not start", "[simulated_device]") {
    const auto starts = [](const DeviceModel& model, HandGrip grip = {}) {
        SimulatedDevice device{model, grip, Still{}, 0.01};
        bool called = false;
        const auto end = device.run([&](const DeviceSample&) -> DeviceCommand {
            called = true;
            return {};
        });
        CHECK(called == device.valid());
        CHECK((end == DeviceEnd::not_available) == !called);
        return called;
    };
    CHECK(starts(simulated_touch));
    CHECK(starts(simulated_premium));
    DeviceModel model = plain();
    CHECK(starts(model));
    for (const int delay : {-1, 9}) {
        model.capabilities.delay = delay;
        CHECK_FALSE(starts(model));
    }
    const double nan = std::nan(""), inf = HUGE_VAL;
    for (const double rate : {0.0, -1.0, nan, inf}) CHECK_FALSE(starts(plain(rate)));
    model = plain();
    for (const double bad : {-1.0, nan, -inf}) {
        model.capabilities.max_force = bad;
        CHECK_FALSE(starts(model));
    }
    model.capabilities.max_force = inf;
    CHECK(starts(model));
    for (const double bad : {-1e-5, nan, inf}) {
        model.capabilities.resolution = bad;
        CHECK_FALSE(starts(model));
    }
    for (const double bad : {-0.1, nan, inf, 1e-310}) { // the last has no inverse
        CHECK_FALSE(starts({.mass = bad, .capabilities = {.rate = 1000}}));
    }
    for (const double bad : {-0.1, nan, inf}) {
        CHECK_FALSE(starts({.viscous = bad, .capabilities = {.rate = 1000}}));
        CHECK_FALSE(starts({.dry = bad, .capabilities = {.rate = 1000}}));
        CHECK_FALSE(starts(plain(), {bad, 0}));
        CHECK_FALSE(starts(plain(), {300, bad}));
    }
    CHECK_FALSE(starts({.mass = 0, .capabilities = {.rate = 1000}}));
    CHECK_FALSE(starts(plain(), {-1, 0}));
}

TEST_CASE("SimulatedDevice: with encoders that make no sense it does not start",
          "[simulated_device][regression]") {
    const auto starts = [](const auto& encoders) {
        SimulatedDevice device{DeviceCapabilities{.rate = 1000}, SameAxes<StickSlipMass>{{.mass = 0.1}},
                               encoders, Still{}, 0.01};
        const auto end = device.run([](const DeviceSample&) -> DeviceCommand { return {}; });
        CHECK((end == DeviceEnd::stopped) == device.valid());
        return device.valid();
    };
    CHECK(starts(AxisEncoders{}));
    CHECK(starts(AxisEncoders{1e-4}));
    CHECK(starts(JointEncoders{}));
    CHECK(starts(JointEncoders{.shoulder = {0, 0.2, 0}, .step = 2e-4}));
    const double nan = std::nan(""), inf = HUGE_VAL;
    for (const double bad : {-1e-5, nan, inf, -inf}) {
        CAPTURE(bad);
        CHECK_FALSE(starts(AxisEncoders{bad}));
        CHECK_FALSE(starts(JointEncoders{.step = bad}));
        CHECK_FALSE(starts(JointEncoders{.upper = bad, .step = 1e-4}));
        CHECK_FALSE(starts(JointEncoders{.lower = bad, .step = 1e-4}));
    }
    for (const double bad : {nan, inf})
        CHECK_FALSE(starts(JointEncoders{.shoulder = {0, bad, 0}, .step = 1e-4}));
    CHECK_FALSE(starts(JointEncoders{.upper = 0, .step = 1e-4}));
    CHECK_FALSE(starts(JointEncoders{.lower = 0, .step = 1e-4}));
}

TEST_CASE("SimulatedDevice: the same run gives the same bits, and allocates nothing", "[simulated_device]") {
    const auto run = [](std::vector<double>& seen) {
        SimulatedDevice device{simulated_premium, {}, Circle{}, 1};
        const auto before = allocations();
        const auto end = device.run([&](const DeviceSample& sample) -> DeviceCommand {
            seen.push_back(sample.position.z);
            return {.newtons = {0, 0, sample.position.z < 0 ? -800 * sample.position.z : 0}};
        });
        CHECK(allocations() == before);
        CHECK(end == DeviceEnd::stopped);
    };
    std::vector<double> first, second;
    first.reserve(1000);
    second.reserve(1000);
    run(first);
    run(second);
    REQUIRE(first.size() == 1000);
    REQUIRE(second.size() == 1000);
    CHECK(std::memcmp(first.data(), second.data(), first.size() * sizeof(double)) == 0);
}
