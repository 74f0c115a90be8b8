#include "../catch.hpp"

#include "polled_device.hpp"

#include <hfh/device/force_guard.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

using namespace hfh;

// ---- Stand-ins, of our own, for the calls that examples/polled/README.md makes.

namespace {

/// A device that samples at a rate of its own; every call takes time. The hand goes down through a floor and up again.
struct World {
    double time = 0, rate = 1000, call = 60e-6, late = 0;
    glm::dvec3 newtons{0.0};
    std::vector<double> sent{}; ///< in the order of the calls
    int calls = 0, fails_at = -1, code = 0;

    /// Of the last sample that the device took.
    [[nodiscard]] double height() const {
        const double sampled = std::floor((time - late) * rate) / rate;
        return 0.004 - 0.014 * std::abs(std::sin(8 * sampled)); // up to 0.11 m/s
    }
    bool pass() {
        time += call;
        return ++calls != fails_at;
    }
    void send(double x, double y, double z) {
        newtons = {x, y, z};
        sent.push_back(z);
    }
};
World world;

int dhdGetPosition(double* x, double* y, double* z) {
    *x = 0.02, *y = 0.03, *z = world.height();
    return world.pass() ? world.code : -1;
}
int dhdGetLinearVelocity(double* x, double* y, double* z) {
    *x = 0.2, *y = 0.3, *z = 0;
    return world.pass() ? world.code : -1;
}
int dhdGetButton(int) { return 1; }
int dhdSetForce(double x, double y, double z) {
    if (!world.pass()) return -1;
    world.send(x, y, z);
    return world.code;
}
struct Inverse3 {
    void SendEndEffectorForce(float* f) { world.send(double(f[0]), double(f[1]), double(f[2])); }
    int ReceiveEndEffectorState(float* p, float* v) {
        p[0] = 0.1F, p[1] = 0.2F, p[2] = static_cast<float>(0.3 + world.height());
        v[0] = v[1] = v[2] = 0;
        return world.pass() ? 0 : -1;
    }
};

// The page's code, to the letter (see CMakeLists.txt).

/// Force Dimension, DHD. Metres and newtons; x towards the user, y to the right, z up.
struct ForceDimension {
    // Return values below 0 are errors. DHD_TIMEGUARD (1: asked again too soon, the last value) and DHD_MOTOR_SATURATED
    // (2: the motors give less than asked) are not.
    bool read(polled::Reading& reading) {
        double x = 0, y = 0, z = 0, vx = 0, vy = 0, vz = 0;
        if (dhdGetPosition(&x, &y, &z) < 0 || dhdGetLinearVelocity(&vx, &vy, &vz) < 0) return false;
        reading = {.position = {y, -x, z}, .velocity = {vy, -vx, vz}, .has_velocity = true};
        reading.buttons = dhdGetButton(0) > 0 ? 1u : 0u;
        return true;
    }
    bool send(const glm::dvec3& newtons) { return dhdSetForce(-newtons.y, newtons.x, newtons.z) >= 0; }
};

/// Haply Inverse3, HardwareAPI. Metres and newtons, z up; the origin is at the base, so `middle` is taken off.
struct Haply {
    Inverse3* device;
    glm::dvec3 middle;

    static glm::dvec3 vector(const float (&f)[3]) { return {double(f[0]), double(f[1]), double(f[2])}; }

    bool exchange(const glm::dvec3& newtons, polled::Reading& reading) {
        float force[3]{float(newtons.x), float(newtons.y), float(newtons.z)}, p[3]{}, v[3]{};
        device->SendEndEffectorForce(force);
        if (device->ReceiveEndEffectorState(p, v) < 0) return false;
        reading = {.position = vector(p) - middle, .velocity = vector(v), .has_velocity = true};
        return true;
    }
};

struct WorldClock {
    [[nodiscard]] double now() const noexcept { return world.time; }
};
using Polled = polled::PolledDevice<ForceDimension, WorldClock>;
using Exchange = polled::ExchangeDevice<Haply, WorldClock>;
static_assert(Device<Polled> && Device<Exchange>);

Polled make_polled(const DeviceCapabilities& able) { return Polled{able}; }
Exchange make_exchange(const DeviceCapabilities& able) {
    static Inverse3 inverse3;
    return Exchange{able, Haply{&inverse3, {double(0.1F), double(0.2F), 0.3}}};
}

/// A floor at height 0, felt through the guard that the page recommends, for some seconds.
struct Floor {
    ForceGuard guard;
    double seconds, stiffness;
    std::vector<DeviceSample> samples{};
    std::vector<double> given{};

    DeviceCommand operator()(const DeviceSample& sample) {
        samples.push_back(sample);
        given.push_back(
            guard.update(sample, {0, 0, stiffness * std::max(0.0, -sample.position.z)}).newtons.z);
        return {{0, 0, given.back()}, sample.time < seconds};
    }
};

void must_have_no_trip(const Floor& floor) {
    for (int k = 1; k < guard_trip_count; ++k) {
        CAPTURE(to_string(static_cast<GuardTrip>(k)));
        CHECK(floor.guard.counts().trips[k] == 0);
    }
}

} // namespace

TEST_CASE("polled: a floor is felt at every rate of device and loop, without a trip", "[polled]") {
    world = World{};
    world.rate = GENERATE(4000.0, 1000.0, 200.0, 100.0);
    world.call = 1.0 / 3 / GENERATE(1000.0, 4000.0, 8000.0); // three calls an update
    const DeviceCapabilities able{.max_force = 12, .max_stiffness = 500, .rate = world.rate};
    auto device = make_polled(able);
    Floor floor{ForceGuard{guard_limits(able)}, 3, 400};
    CHECK(device.run(floor) == DeviceEnd::stopped);
    CAPTURE(world.rate, world.call);
    must_have_no_trip(floor);
    CHECK(*std::max_element(floor.given.begin(), floor.given.end()) == Approx(4.0).epsilon(0.01));
    CHECK(world.sent == [&] {
        auto all = floor.given;
        all.back() = 0; // the last thing that a device is told
        return all;
    }());
}

TEST_CASE("polled: a device that exchanges feels the floor one exchange later, without a trip", "[polled]") {
    world = World{};
    world.call = 0.001;
    const DeviceCapabilities able{.max_force = 8, .max_stiffness = 500, .rate = 1000};
    auto device = make_exchange(able);
    CHECK(device.capabilities().delay == 1);
    CHECK(make_exchange({.delay = unknown_delay}).capabilities().delay == unknown_delay);
    Floor floor{ForceGuard{guard_limits(able)}, 3, 400};
    CHECK(device.run(floor) == DeviceEnd::stopped);
    must_have_no_trip(floor);
    REQUIRE(world.sent.size() == floor.given.size() + 1);
    CHECK(world.sent.front() == 0);
    CHECK(world.sent.back() == 0);
    for (std::size_t n = 0; n + 1 < floor.given.size(); ++n)
        if (world.sent[n + 1] != Approx(floor.given[n])) CHECK(world.sent[n + 1] == Approx(floor.given[n]));
    CHECK(*std::max_element(floor.given.begin(), floor.given.end()) == Approx(4.0).epsilon(0.01));
}

TEST_CASE("polled: what a sample tells, and axes", "[polled]") {
    world = World{};
    world.code = GENERATE(0, 1, 2); // of which 1 and 2 are no errors
    auto device = make_polled({.rate = 1000});
    std::vector<DeviceSample> samples;
    CHECK(device.run([&](const DeviceSample& sample) -> DeviceCommand {
        samples.push_back(sample);
        return {{1, 2, 3}, samples.size() < 3};
    }) == DeviceEnd::stopped);
    REQUIRE(samples.size() == 3);
    CHECK(samples[1].position.x == 0.03);
    CHECK(samples[1].position.y == -0.02);
    CHECK(samples[1].has_velocity);
    CHECK(samples[1].velocity.x == 0.3);
    CHECK(samples[1].velocity.y == -0.2);
    CHECK(samples[1].buttons == 1);
    CHECK_FALSE(samples[0].has_sent);
    CHECK(samples[1].has_sent);
    CHECK(samples[1].sent == glm::dvec3{1, 2, 3});
    CHECK(samples[1].sent_at == samples[0].time);
    CHECK(world.sent == std::vector<double>{3, 3, 0});
    world.send(0, 0, 0);
    (void)ForceDimension{}.send({1, 2, 3});
    CHECK(world.newtons == glm::dvec3{-2, 1, 3}); // (x, y) of the device is (−y, x) of ours
}

TEST_CASE("polled: a call that fails ends the run, and a stop does", "[polled]") {
    world = World{};
    const auto three = [](const DeviceSample&) -> DeviceCommand { return {{0, 0, 3}}; };
    SECTION("reading") {
        world.fails_at = 31; // the 11th update's
        auto device = make_polled({.rate = 1000});
        CHECK(device.run(three) == DeviceEnd::lost);
        CHECK(world.sent.size() == 11);
        CHECK(world.sent.back() == 0);
    }
    SECTION("sending") {
        world.fails_at = 33;
        auto device = make_polled({.rate = 1000});
        CHECK(device.run(three) == DeviceEnd::lost);
        CHECK(world.sent.size() == 10);
    }
    SECTION("exchanging") {
        world.fails_at = 11;
        auto device = make_exchange({.rate = 1000});
        CHECK(device.run(three) == DeviceEnd::lost);
        CHECK(world.sent.size() == 11);
    }
    SECTION("a stop, before and within a run") {
        auto a = make_polled({.rate = 1000});
        auto b = make_exchange({.rate = 1000});
        const auto stops = [&](auto& device) {
            device.stop();
            CHECK(device.run(three) == DeviceEnd::stopped);
            CHECK((world.sent.empty() || world.sent.back() == 0));
            int n = 0;
            CHECK(device.run([&](const DeviceSample&) -> DeviceCommand {
                if (++n == 20) device.stop();
                return {{0, 0, 3}};
            }) == DeviceEnd::stopped);
            CHECK(n == 20);
            CHECK(world.sent.back() == 0);
        };
        stops(a);
        stops(b);
    }
    SECTION("a force that is no number is not sent") {
        auto device = make_polled({.rate = 1000});
        int n = 0;
        (void)device.run([&](const DeviceSample&) -> DeviceCommand {
            return {{0, 0, std::nan("")}, ++n < 5};
        });
        CHECK(world.sent == std::vector<double>(5, 0.0));
    }
}

TEST_CASE("polled: stopped while a force is being sent, none is left on the motors", "[polled][regression]") {
    std::vector<double> sent;
    std::function<void()> stop;
    struct Api {
        std::vector<double>* sent;
        std::function<void()>* stop;
        bool read(polled::Reading& reading) {
            reading = {};
            return true;
        }
        bool send(const glm::dvec3& newtons) {
            sent->push_back(newtons.z);
            if (sent->size() == 10) (*stop)(); // as a signal or another thread would
            return true;
        }
    };
    polled::PolledDevice<Api, WorldClock> device{{.rate = 1000}, Api{&sent, &stop}};
    stop = [&] { device.stop(); };
    CHECK(device.run([](const DeviceSample&) -> DeviceCommand { return {{0, 0, 2}}; }) == DeviceEnd::stopped);
    CHECK(sent.size() == 11);
    CHECK(sent.back() == 0);
}

TEST_CASE("polled: the limits in the page's table", "[polled]") {
    const auto limits = [](double rate) { return guard_limits({.rate = rate}); };
    CHECK(limits(4000).max_gap == Approx(0.0105));
    CHECK(limits(4000).max_repeats == 84);
    CHECK(limits(1000).max_gap == Approx(0.012));
    CHECK(limits(1000).max_repeats == 96);
    CHECK(limits(200).max_gap == Approx(0.02));
    CHECK(limits(200).max_repeats == 160);
    CHECK(limits(100).max_gap == Approx(0.03));
    CHECK(limits(100).max_repeats == 240);
    CHECK(limits(100).max_slew == 1);
}
