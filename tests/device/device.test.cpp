#include "catch.hpp"

#include <hfh/device/device.hpp>
#include <hfh/device/force_guard.hpp>

#include <algorithm>
#include <type_traits>
#include <vector>

using namespace hfh;

// Three made-up drivers, one for each way in which real ones call: the concept must fit them all, and one and the same
// tick must work with each. A mass on a frictionless rail, upright, stands in for the hand: it shows which force was
// felt when.

namespace {

constexpr double period = 0.001;

/// Moves under the last force, one period at a time. 1 kg, so that newtons are metres per second squared.
struct Rail {
    double z = 0.01, speed = 0;
    std::vector<double> felt{};

    void move(double newtons) {
        felt.push_back(newtons);
        speed += newtons * period;
        z += speed * period;
    }
};

// ---- Calls back, from its own loop, in millimetres and y up, until the callback says so (as HDAPI does).
struct CallbackDriver {
    Rail& rail;
    bool (*callback)(void*) = nullptr; ///< whether to go on
    void* user = nullptr;
    double force[3]{};
    int update = 0;

    void position(double (&mm)[3]) const { mm[0] = 0, mm[1] = 1000 * rail.z, mm[2] = 0; }
    void run() {
        for (bool go_on = true; go_on; ++update) {
            go_on = callback(user);
            rail.move(force[1]);
        }
    }
};

class CallbackDevice {
public:
    [[nodiscard]] DeviceCapabilities capabilities() const noexcept {
        return {.max_force = 3.3, .rate = 1000};
    }

    template <DeviceTick Tick>
    DeviceEnd run(Tick&& tick) {
        CallbackDriver driver{rail};
        struct Call {
            CallbackDriver& driver;
            std::remove_reference_t<Tick>& tick;
            int lost_after;
            DeviceEnd end = DeviceEnd::stopped;
        } call{driver, tick, lost_after};
        driver.user = &call;
        driver.callback = [](void* user) {
            auto& [it, inner, last, end] = *static_cast<Call*>(user);
            std::fill(std::begin(it.force), std::end(it.force), 0.0);
            if (it.update == last) {
                end = DeviceEnd::lost;
                return false;
            }
            double mm[3];
            it.position(mm);
            const DeviceCommand command = inner(DeviceSample{
                .time = it.update * period, .position = {mm[0] / 1000, -mm[2] / 1000, mm[1] / 1000}});
            if (!command.go_on) return false;
            const auto& f = command.newtons;
            it.force[0] = f.x, it.force[1] = f.z, it.force[2] = -f.y;
            return true;
        };
        driver.run();
        return call.end;
    }

    Rail rail{};
    int lost_after = -1;
};

// ---- Is polled: read, compute, write, in the program's own time; below 0 is an error, above 0 is not (as Force
// Dimension's).
class PolledDevice {
public:
    [[nodiscard]] DeviceCapabilities capabilities() const noexcept { return {.max_force = 12, .rate = 4000}; }

    template <DeviceTick Tick>
    DeviceEnd run(Tick&& tick) {
        for (;;) {
            DeviceSample sample;
            if (get_position(sample.position.z) < 0) return DeviceEnd::lost;
            sample.time = update_ * period;
            const DeviceCommand command = tick(sample);
            if (set_force(command.go_on ? command.newtons.z : 0) < 0) return DeviceEnd::lost;
            if (!command.go_on) return DeviceEnd::stopped;
        }
    }

    Rail rail{};
    int lost_after = -1;

private:
    int get_position(double& z) {
        if (++update_ == lost_after) return -1;
        z = rail.z;
        return update_ % 3; // 1 and 2: news that are no errors
    }
    int set_force(double newtons) {
        rail.move(newtons);
        return update_ % 3;
    }
    int update_ = -1;
};

// ---- Exchanges: a position comes back only for a force sent, so the first force is a zero for nothing, and the force
// for a position acts one period late (as Haply's).
class ExchangeDevice {
public:
    [[nodiscard]] DeviceCapabilities capabilities() const noexcept {
        return {.max_force = 8, .rate = 1000, .delay = 1};
    }

    template <DeviceTick Tick>
    DeviceEnd run(Tick&& tick) {
        double newtons = 0;
        for (int n = 0;; ++n) {
            const DeviceSample sample{.time = n * period, .position = {0, 0, exchange(newtons)}};
            const DeviceCommand command = tick(sample);
            if (!command.go_on) {
                (void)exchange(0);
                return DeviceEnd::stopped;
            }
            newtons = command.newtons.z;
        }
    }

    Rail rail{};

private:
    double exchange(double newtons) {
        const double seen = rail.z;
        rail.move(newtons);
        return seen;
    }
};

static_assert(Device<CallbackDevice> && Device<PolledDevice> && Device<ExchangeDevice>);

struct NoRun {
    [[nodiscard]] DeviceCapabilities capabilities() const noexcept { return {}; }
};
struct ThrowingCapabilities : PolledDevice {
    [[nodiscard]] DeviceCapabilities capabilities() const { return {}; }
};
static_assert(!Device<NoRun> && !Device<ThrowingCapabilities> && !Device<int>);

/// A spring to z = 0 that stops after `last` samples.
struct Spring {
    int last, seen = 0;
    double time = -1;

    DeviceCommand operator()(const DeviceSample& sample) {
        CHECK(sample.time > time);
        time = sample.time;
        ++seen;
        return {.newtons = {0, 0, -400 * sample.position.z}, .go_on = seen < last};
    }
};
static_assert(DeviceTick<Spring>);
static_assert(!DeviceTick<void (*)(const DeviceSample&)>); // gives no command

/// The rail after `updates` of a force that answers the position `late` periods before, the last one without force.
double expected(int updates, int late) {
    double z = 0.01, speed = 0, force = 0;
    for (int n = 0; n < updates; ++n) {
        const double answer = n + 1 < updates ? -400 * z : 0;
        speed += (late == 0 ? answer : force) * period;
        z += speed * period;
        force = answer;
    }
    // An exchange that is late sends its zero in a period of its own.
    if (late == 1) z += speed * period;
    return z;
}

/// A floor at height 0 of 500 N/m, felt through a guard, for a second.
struct Floor {
    ForceGuard guard{{.ramp = 0.1}};
    std::vector<double> asked{};

    DeviceCommand operator()(const DeviceSample& sample) {
        const double depth = std::max(0.0, -sample.position.z);
        const auto force = guard.update(sample, {0, 0, 500 * depth});
        asked.push_back(force.newtons.z);
        return {force.newtons, asked.size() < 1000};
    }
};
static_assert(DeviceTick<Floor>);

} // namespace

TEST_CASE("Device: one tick fits drivers that call back, are polled and exchange", "[device]") {
    CallbackDevice callback;
    PolledDevice polled;
    ExchangeDevice exchange;
    Spring a{.last = 50}, b{.last = 50}, c{.last = 50};
    CHECK(callback.run(a) == DeviceEnd::stopped);
    CHECK(polled.run(b) == DeviceEnd::stopped);
    CHECK(exchange.run(c) == DeviceEnd::stopped);
    for (const Spring& tick : {a, b, c}) CHECK(tick.seen == 50); // none after the one that said stop
    CHECK(callback.rail.z == Approx(expected(50, 0)).epsilon(1e-12));
    CHECK(polled.rail.z == Approx(expected(50, 0)).epsilon(1e-12));
    CHECK(exchange.rail.z == Approx(expected(50, exchange.capabilities().delay)).epsilon(1e-12));
    CHECK(exchange.rail.z != polled.rail.z); // the delay is felt
}

TEMPLATE_TEST_CASE("Device: a mass that falls on a guarded floor feels what the guard let through",
                   "[device]", CallbackDevice, PolledDevice, ExchangeDevice) {
    TestType device;
    device.rail.speed = -0.1;
    Floor floor;
    CHECK(device.run(floor) == DeviceEnd::stopped);
    const auto late = static_cast<std::size_t>(device.capabilities().delay);
    const auto& felt = device.rail.felt;
    REQUIRE(floor.asked.size() == 1000);
    REQUIRE(felt.size() == 1000 + late);
    CHECK(felt.back() == 0); // the last thing a device is told
    for (std::size_t n = 0; n + 1 < 1000; ++n) CHECK(felt[n + late] == floor.asked[n]);
    // ½mv² = ½kd² gives d = v·√(m/k) and F = v·√(m·k) = 2.24 N; the late floor is pressed a little deeper.
    const double most = *std::max_element(felt.begin(), felt.end());
    CHECK(most > 2.1);
    CHECK(most < 2.5);
    CHECK(device.rail.speed > 0.09); // and it came up again
    for (int k = 1; k < guard_trip_count; ++k) CHECK(floor.guard.counts().trips[k] == 0);
}

TEMPLATE_TEST_CASE("Device: a run that breaks says how, and calls no more", "[device]", CallbackDevice,
                   PolledDevice) {
    TestType device;
    device.lost_after = 7;
    Spring tick{.last = 50};
    CHECK(device.run(tick) == DeviceEnd::lost);
    CHECK(tick.seen == 7);
}

TEST_CASE("Device: a default command is no force and going on", "[device]") {
    CHECK(DeviceCommand{}.newtons == glm::dvec3{0});
    CHECK(DeviceCommand{}.go_on);
    CHECK(DeviceCapabilities{}.max_force == 0);
}
