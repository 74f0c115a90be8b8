#include "catch.hpp"

#include <hfh/device.hpp>
#include <hfh/force_guard.hpp>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

using namespace hfh;

// The three ways in which drivers are called, each with a tiny driver of our own: it calls back, it is polled, or it
// gives a position only for a force. The device hides which; the tick is the same.

namespace {

/// A hand that presses 10 mm into a floor and comes back, in a second.
glm::dvec3 hand_at(int update) { return {0, 0, 0.005 - 0.01 * std::sin(3.14159265 * update / 1000)}; }

// ---- Calls back, from its own loop, in millimetres and y up, until the callback says so (as HDAPI does).
struct CallbackDriver {
    void (*callback)(void*, bool& go_on) = nullptr;
    void* user = nullptr;
    int update = 0;
    double force[3]{};
    std::vector<double> up_forces{};

    void position(double (&mm)[3]) const {
        const auto p = hand_at(update) * 1000.0;
        mm[0] = p.x, mm[1] = p.z, mm[2] = -p.y;
    }
    void run() {
        for (bool go_on = true; go_on; ++update) {
            callback(user, go_on);
            up_forces.push_back(force[1]);
        }
    }
};

class CallbackDevice {
public:
    explicit CallbackDevice(CallbackDriver& driver) : driver_{driver} {}

    [[nodiscard]] DeviceCapabilities capabilities() const noexcept {
        return {.max_force = 3.3, .rate = 1000};
    }

    template <DeviceTick Tick>
    DeviceEnd run(Tick&& tick) {
        struct Call {
            CallbackDriver& driver;
            std::remove_reference_t<Tick>& tick;
        } call{driver_, tick};
        driver_.user = &call;
        driver_.callback = [](void* user, bool& go_on) {
            auto& [driver, inner] = *static_cast<Call*>(user);
            double mm[3];
            driver.position(mm);
            const DeviceCommand command = inner(DeviceSample{
                .time = driver.update * 1e-3, .position = {mm[0] / 1000, -mm[2] / 1000, mm[1] / 1000}});
            const auto f = command.go_on ? command.newtons : glm::dvec3{0.0};
            driver.force[0] = f.x, driver.force[1] = f.z, driver.force[2] = -f.y;
            go_on = command.go_on;
        };
        driver_.run();
        return DeviceEnd::stopped;
    }

private:
    CallbackDriver& driver_;
};

// ---- Is polled: read, compute, write, as often as one likes; below 0 is an error, above 0 is not (as Force Dimension's).
struct PolledDriver {
    int update = -1, unplugged_at = 1 << 30;
    std::vector<double> up_forces{};

    int get_position(double& x, double& y, double& z) {
        if (++update >= unplugged_at) return -1;
        const auto p = hand_at(update);
        x = p.x, y = p.y, z = p.z;
        return update % 3; // 1 and 2: news that are no errors
    }
    int set_force(double, double, double fz) {
        up_forces.push_back(fz);
        return update % 3;
    }
};

class PolledDevice {
public:
    explicit PolledDevice(PolledDriver& driver) : driver_{driver} {}

    [[nodiscard]] DeviceCapabilities capabilities() const noexcept { return {.max_force = 12, .rate = 4000}; }

    template <DeviceTick Tick>
    DeviceEnd run(Tick&& tick) {
        for (;;) {
            DeviceSample sample;
            if (driver_.get_position(sample.position.x, sample.position.y, sample.position.z) < 0)
                return DeviceEnd::lost;
            sample.time = driver_.update * 1e-3;
            const DeviceCommand command = tick(sample);
            const auto f = command.go_on ? command.newtons : glm::dvec3{0.0};
            if (driver_.set_force(f.x, f.y, f.z) < 0) return DeviceEnd::lost;
            if (!command.go_on) return DeviceEnd::stopped;
        }
    }

private:
    PolledDriver& driver_;
};

// ---- Exchanges: a position comes back only for a force that was sent, so the first force is a zero for nothing, and
// the force for a position acts after the next one has been taken (as Haply's).
struct ExchangeDriver {
    int update = 0;
    std::vector<double> up_forces{};

    glm::dvec3 exchange(const glm::dvec3& newtons) {
        up_forces.push_back(newtons.z);
        return hand_at(update++);
    }
};

class ExchangeDevice {
public:
    explicit ExchangeDevice(ExchangeDriver& driver) : driver_{driver} {}

    [[nodiscard]] DeviceCapabilities capabilities() const noexcept {
        return {.max_force = 8, .rate = 1000, .delay = 1};
    }

    template <DeviceTick Tick>
    DeviceEnd run(Tick&& tick) {
        glm::dvec3 newtons{0.0};
        for (;;) {
            const DeviceSample sample{.time = driver_.update * 1e-3, .position = driver_.exchange(newtons)};
            const DeviceCommand command = tick(sample);
            newtons = command.newtons;
            if (command.go_on) continue;
            (void)driver_.exchange(glm::dvec3{0.0});
            return DeviceEnd::stopped;
        }
    }

private:
    ExchangeDriver& driver_;
};

static_assert(Device<CallbackDevice> && Device<PolledDevice> && Device<ExchangeDevice>);

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

template <class Driver>
void check_floor(const Driver& driver, const Floor& floor, std::size_t late) {
    REQUIRE(floor.asked.size() == 1000);
    REQUIRE(driver.up_forces.size() == 1000 + late);
    CHECK(*std::max_element(floor.asked.begin(), floor.asked.end()) == Approx(2.5).epsilon(1e-6));
    CHECK(driver.up_forces.back() == 0); // the last thing a device is told
    for (std::size_t n = 0; n + 1 < 1000; ++n) CHECK(driver.up_forces[n + late] == floor.asked[n]);
}

} // namespace

TEST_CASE("Device: a driver that calls back", "[device]") {
    CallbackDriver driver;
    CallbackDevice device{driver};
    Floor floor;
    CHECK(device.run(floor) == DeviceEnd::stopped);
    check_floor(driver, floor, 0);
}

TEST_CASE("Device: a driver that is polled", "[device]") {
    PolledDriver driver;
    PolledDevice device{driver};
    Floor floor;
    CHECK(device.run(floor) == DeviceEnd::stopped);
    check_floor(driver, floor, 0);

    PolledDriver unplugged{.unplugged_at = 10};
    PolledDevice lost{unplugged};
    int ticks = 0;
    CHECK(lost.run([&](const DeviceSample&) -> DeviceCommand {
        return {{}, ++ticks < 100};
    }) == DeviceEnd::lost);
    CHECK(ticks == 10);
}

TEST_CASE("Device: a driver that gives a position for a force acts one update late, and tells so",
          "[device]") {
    ExchangeDriver driver;
    ExchangeDevice device{driver};
    Floor floor;
    CHECK(device.run(floor) == DeviceEnd::stopped);
    CHECK(device.capabilities().delay == 1);
    check_floor(driver, floor, static_cast<std::size_t>(device.capabilities().delay));
}
