#include "catch.hpp"

#include <hfh/device.hpp>

#include <functional>

using namespace hfh;

// Three made-up drivers, one for each way in which real ones call: the concept must fit them all, and one and the same
// tick must work with each. A mass on a frictionless rail stands in for the hand: it shows which force was felt when.

namespace {

constexpr double period = 0.001;

/// Moves under the last force, one period at a time. 1 kg, so that newtons are metres per second squared.
struct Rail {
    double x = 0.01, speed = 0;
    void move(const glm::dvec3& newtons) {
        speed += newtons.x * period;
        x += speed * period;
    }
};

/// The vendor's scheduler calls back, once per period, until the callback says that it is done.
class CallbackDevice {
public:
    explicit CallbackDevice(int breaks_after) : breaks_after_{breaks_after} {}
    [[nodiscard]] DeviceCapabilities capabilities() const noexcept { return {.max_force = 3, .rate = 1000}; }

    template <DeviceTick Tick>
    DeviceEnd run(Tick& tick) {
        DeviceEnd end = DeviceEnd::stopped;
        schedule([&](int n) {
            if (n == breaks_after_) {
                end = DeviceEnd::lost;
                return false;
            }
            const DeviceCommand command = tick(DeviceSample{n * period, {rail.x, 0, 0}});
            rail.move(command.go_on ? command.newtons : glm::dvec3{0});
            return command.go_on;
        });
        return end;
    }
    Rail rail;

private:
    static void schedule(const std::function<bool(int)>& callback) {
        for (int n = 0; callback(n); ++n) {
        }
    }
    int breaks_after_;
};

/// The program asks for a position and sets a force, in its own time.
class PolledDevice {
public:
    [[nodiscard]] DeviceCapabilities capabilities() const noexcept { return {.max_force = 12, .rate = 4000}; }

    template <DeviceTick Tick>
    DeviceEnd run(Tick& tick) {
        for (int n = 0;; ++n) {
            const DeviceCommand command = tick(DeviceSample{n * period, {rail.x, 0, 0}});
            rail.move(command.go_on ? command.newtons : glm::dvec3{0});
            if (!command.go_on) return DeviceEnd::stopped;
        }
    }
    Rail rail;
};

/// A position comes back only for a force sent, so the force that answers it acts one period late.
class ExchangeDevice {
public:
    [[nodiscard]] DeviceCapabilities capabilities() const noexcept { return {.rate = 1000, .delay = 1}; }

    template <DeviceTick Tick>
    DeviceEnd run(Tick& tick) {
        glm::dvec3 newtons{0};
        for (int n = 0;; ++n) {
            const double x = exchange(newtons);
            const DeviceCommand command = tick(DeviceSample{n * period, {x, 0, 0}});
            if (!command.go_on) {
                static_cast<void>(exchange(glm::dvec3{0}));
                return DeviceEnd::stopped;
            }
            newtons = command.newtons;
        }
    }
    Rail rail;

private:
    double exchange(const glm::dvec3& newtons) {
        const double seen = rail.x;
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

/// A spring to x = 0 that stops after `last` samples.
struct Spring {
    int last, seen = 0;
    double time = -1;
    DeviceCommand operator()(const DeviceSample& sample) {
        CHECK(sample.time > time);
        time = sample.time;
        ++seen;
        return {.newtons = {-400 * sample.position.x, 0, 0}, .go_on = seen < last};
    }
};
static_assert(DeviceTick<Spring>);
static_assert(!DeviceTick<void (*)(const DeviceSample&)>); // gives no command

/// The rail after `updates` of a force that answers the position `late` periods before, the last one without force.
double expected(int updates, int late) {
    double x = 0.01, speed = 0, force = 0;
    for (int n = 0; n < updates; ++n) {
        const double answer = n + 1 < updates ? -400 * x : 0;
        speed += (late == 0 ? answer : force) * period;
        x += speed * period;
        force = answer;
    }
    // An exchange that is late sends its zero in a period of its own.
    if (late == 1) x += speed * period;
    return x;
}

} // namespace

TEST_CASE("Device: one tick fits drivers that call back, are polled and exchange", "[device]") {
    CallbackDevice callback{-1};
    PolledDevice polled;
    ExchangeDevice exchange;
    Spring a{.last = 50}, b{.last = 50}, c{.last = 50};
    CHECK(callback.run(a) == DeviceEnd::stopped);
    CHECK(polled.run(b) == DeviceEnd::stopped);
    CHECK(exchange.run(c) == DeviceEnd::stopped);
    for (const Spring& tick : {a, b, c}) CHECK(tick.seen == 50); // none after the one that said stop
    CHECK(callback.rail.x == Approx(expected(50, 0)).epsilon(1e-12));
    CHECK(polled.rail.x == Approx(expected(50, 0)).epsilon(1e-12));
    CHECK(exchange.rail.x == Approx(expected(50, exchange.capabilities().delay)).epsilon(1e-12));
    CHECK(exchange.rail.x != polled.rail.x); // the delay is felt
}

TEST_CASE("Device: a run that breaks says how, and calls no more", "[device]") {
    CallbackDevice device{7};
    Spring tick{.last = 50};
    CHECK(device.run(tick) == DeviceEnd::lost);
    CHECK(tick.seen == 7);
}

TEST_CASE("Device: a default command is no force and going on", "[device]") {
    CHECK(DeviceCommand{}.newtons == glm::dvec3{0});
    CHECK(DeviceCommand{}.go_on);
    CHECK(DeviceCapabilities{}.max_force == 0);
}
