#include "../catch.hpp"
#include "../support/presses.hpp"
#include "fake_hd.hpp"

#include "openhaptics.hpp"
#include "phantom_device.hpp"
#include "reconnect.hpp"
#include "scene.hpp"

#include <hfh/terrain/extended_field.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

using namespace hfh;
using namespace hfh::test;

namespace {

/// The fake's time; waiting lets it tick ten times, a millisecond each, or pass 50 ms when there is nothing to call.
struct FakeClock {
    [[nodiscard]] double now() const noexcept { return fake_hd().time; }
    void wait() const {
        FakeHd& hd = fake_hd();
        if (!hd.running()) hd.time += 0.05;
        for (int n = 0; n < 10 && hd.running(); ++n) {
            hd.time += 0.001;
            hd.update();
        }
    }
};

using Phantom = phantom::PhantomDevice<phantom::OpenHaptics, FakeClock>;
static_assert(hfh::Device<Phantom>);
static_assert(phantom::HapticApi<phantom::OpenHaptics>);

FakeHd& fresh() { return fake_hd() = FakeHd{}; }

/// Asks for a force, so often, and notes what it saw.
struct Asks {
    glm::dvec3 newtons{1, 2, 3};
    std::size_t often = 100;
    std::vector<DeviceSample> samples{};

    DeviceCommand operator()(const DeviceSample& sample) {
        samples.push_back(sample);
        return {newtons, samples.size() < often};
    }
};

using Names = std::vector<std::string>;

Names without_errors(const Names& calls) {
    Names left;
    std::copy_if(calls.begin(), calls.end(), std::back_inserter(left),
                 [](const auto& c) { return c != "error"; });
    return left;
}

bool forceless(const FakeHd& hd) {
    return std::all_of(hd.force.begin(), hd.force.end(), [](double f) { return f == 0; });
}

} // namespace

TEST_CASE("phantom: calls in the order that the driver asks for, and leaves it as it should be",
          "[phantom]") {
    auto& hd = fresh();
    hd.errors = {HD_BAD_HANDLE, HD_TIMER_ERROR}; // of another program's making
    {
        Phantom device;
        REQUIRE(device.is_open());
        Asks asks;
        CHECK(device.run(asks) == DeviceEnd::stopped);
        CHECK(asks.samples.size() == 100);
        CHECK(hd.left ==
              std::vector<double>{0, 0, 0}); // by the tick that said stop, not only by what follows
        CHECK(forceless(hd));
    }
    CHECK(hd.breaches == Names{});
    CHECK(hd.calls.front() == "error");
    CHECK(without_errors(hd.calls) == Names{"init", "workspace", "max force", "stiffness", "rate",
                                            "continuous force", "impulse", "model", "enable output",
                                            "enable ramping", "enable clamping", "schedule", "start",
                                            "disable output", "stop", "unschedule", "close"});
    CHECK(hd.in_tick == Names{"begin", "check calibration", "temperature", "inkwell", "safety", "position",
                              "velocity", "buttons", "force", "end", "error"});
    CHECK(hd.priority == HD_MAX_SCHEDULER_PRIORITY);
    CHECK_FALSE(hd.open);
}

TEST_CASE("phantom: runs again after a run", "[phantom]") {
    auto& hd = fresh();
    Phantom device;
    for (int n = 0; n < 3; ++n) {
        Asks asks;
        CHECK(device.run(asks) == DeviceEnd::stopped);
        CHECK(device.report().updates == 100);
    }
    CHECK(hd.breaches == Names{});
}

TEST_CASE("phantom: metres and z up, in and out", "[phantom]") {
    auto& hd = fresh();
    Phantom device;
    const auto able = device.capabilities();
    CHECK(able.max_force == 3.3);
    CHECK(able.max_stiffness == Approx(500));
    CHECK(able.rate == 1000);
    CHECK(able.workspace.x == Approx(0.16));
    CHECK(able.workspace.y == Approx(0.07));
    CHECK(able.workspace.z == Approx(0.12));

    hd.position[0] = 10, hd.position[1] = 20 + 10, hd.position[2] = 30; // the middle of y is 10
    hd.velocity[0] = 100, hd.velocity[1] = 200, hd.velocity[2] = 300;
    hd.buttons = 2;
    std::vector<double> force;
    Asks asks{.often = 3};
    hd.before_update = [&](int n) {
        if (n == 2) force = hd.force;
    };
    (void)device.run(asks);
    REQUIRE(asks.samples.size() == 3);
    const auto& sample = asks.samples[1];
    CHECK(sample.position.x == Approx(0.01));
    CHECK(sample.position.y == Approx(-0.03));
    CHECK(sample.position.z == Approx(0.02));
    CHECK(sample.has_velocity);
    CHECK(sample.velocity.x == Approx(0.1));
    CHECK(sample.velocity.y == Approx(-0.3));
    CHECK(sample.velocity.z == Approx(0.2));
    CHECK(sample.buttons == 2);
    CHECK(asks.samples[2].time - sample.time == Approx(0.001));
    CHECK(force == std::vector<double>{1, 3, -2});
    CHECK(force[0] * hd.velocity[0] + force[1] * hd.velocity[1] + force[2] * hd.velocity[2] ==
          Approx(1000 * glm::dot(asks.newtons, sample.velocity))); // the same work on both sides
}

TEST_CASE("phantom: a device that does not open, or does not start, is not available", "[phantom]") {
    auto& hd = fresh();
    const int which = GENERATE(0, 1, 2, 3, 4);
    if (which == 0) hd.init_gives_no_handle = true;
    if (which == 1) hd.init_error = HD_DEVICE_FAULT;
    if (which == 2) hd.enable_error = HD_BAD_HANDLE;
    if (which == 3) hd.schedule_error = HD_SCHEDULER_FULL;
    if (which == 4) hd.start_error = HD_ILLEGAL_BEGIN;
    {
        Phantom device;
        CHECK(device.is_open() == (which > 1));
        Asks asks;
        CHECK(device.run(asks) == DeviceEnd::not_available);
        CHECK(asks.samples.empty());
        const unsigned codes[] = {0, HD_DEVICE_FAULT, HD_BAD_HANDLE, HD_SCHEDULER_FULL, HD_ILLEGAL_BEGIN};
        CHECK(device.report().last_error == codes[which]);
    }
    CHECK(hd.breaches == Names{});
    CHECK_FALSE(hd.open);
    CHECK_FALSE(hd.started);
    CHECK(hd.scheduled.empty());
}

TEST_CASE("phantom: a force error ends the contact, and the run goes on", "[phantom]") {
    const unsigned code = GENERATE(0x200u, 0x201u, 0x202u, 0x203u, 0x204u);
    auto& hd = fresh();
    Phantom device;
    Asks asks;
    std::vector<bool> zero(101);
    hd.before_update = [&](int n) {
        zero[static_cast<std::size_t>(n)] = forceless(hd); // what tick n − 1 has set
        if (n >= 50 && n < 53) hd.errors.push_back(code);
    };
    CHECK(device.run(asks) == DeviceEnd::stopped);
    REQUIRE(asks.samples.size() == 100);
    for (std::size_t n = 0; n < 100; ++n) {
        const bool force_refused = n > 50 && n <= 53;
        CAPTURE(n, code);
        CHECK(asks.samples[n].force_refused == force_refused);
        if (n < 99) CHECK(zero[n + 1] == force_refused);
    }
    const auto report = device.report();
    CHECK(report.force_errors == 3);
    CHECK(report.last_error == code);
    CHECK(hd.breaches == Names{});
}

TEST_CASE("phantom: force errors without an end end the run", "[phantom]") {
    auto& hd = fresh();
    Phantom device{nullptr, {.max_force_errors = 7}};
    hd.before_update = [&](int n) {
        if (n >= 20) hd.errors.push_back(HD_EXCEEDED_MAX_FORCE);
    };
    Asks asks;
    CHECK(device.run(asks) == DeviceEnd::force_fault);
    CHECK(asks.samples.size() == 27);
    CHECK(forceless(hd));
}

TEST_CASE("phantom: any other error ends the run at once, with the force at zero", "[phantom]") {
    struct Case {
        unsigned code;
        DeviceEnd end;
    };
    const auto [code, end] =
        GENERATE(Case{HD_COMM_ERROR, DeviceEnd::lost}, Case{HD_COMM_CONFIG_ERROR, DeviceEnd::lost},
                 Case{HD_FRAME_ERROR, DeviceEnd::fault}, Case{HD_ILLEGAL_BEGIN, DeviceEnd::fault},
                 Case{HD_ILLEGAL_END, DeviceEnd::fault}, Case{HD_TIMER_ERROR, DeviceEnd::fault},
                 Case{12345u, DeviceEnd::fault});
    const bool with_force_error = GENERATE(false, true);
    auto& hd = fresh();
    Phantom device;
    hd.before_update = [&, code = code](int n) {
        if (n == 30 && with_force_error) hd.errors.push_back(HD_EXCEEDED_MAX_FORCE);
        if (n == 30) hd.errors.push_back(code);
    };
    Asks asks;
    CHECK(device.run(asks) == end);
    CHECK(hd.left == std::vector<double>{0, 0, 0}); // by the driver's thread, before anything is switched off
    CHECK(asks.samples.size() == 31);
    CHECK(forceless(hd));
    CHECK(device.report().last_error == code);
    CHECK_FALSE(hd.started);
    CHECK(hd.breaches == Names{});
}

TEST_CASE("phantom: with warm motors there is no force until they have cooled, and the run goes on",
          "[phantom][regression]") {
    auto& hd = fresh();
    const bool tells = GENERATE(true, false); // the temperature
    if (!tells) hd.unknown = {HD_MOTOR_TEMPERATURE};
    Phantom device;
    std::vector<bool> zero;
    hd.before_update = [&](int n) {
        if (n > 0) zero.push_back(forceless(hd)); // what tick n - 1 has set
        if (n >= 50 && n < 250) hd.errors.push_back(HD_WARM_MOTORS);
        hd.temperature[2] = n < 40 ? 0.2 : n < 300 ? 1.0 : n < 4000 ? 0.51 : 0.49;
        if (n == 200) {
            CHECK(device.report().withheld == phantom::Withheld::warm_motors);
            CHECK(device.report().temperature == (tells ? std::optional{1.0} : std::nullopt));
        }
    };
    Asks asks{.often = 6000};
    CHECK(device.run(asks) == DeviceEnd::stopped);
    REQUIRE(asks.samples.size() == 6000);
    // Without a temperature, when the last error is more than 5 s ago; the fake's tick takes a millisecond.
    const std::size_t cooled = tells ? 4001 : 249 + 5001 + 1;
    for (std::size_t n = 0; n < 5999; ++n) {
        const bool warm = n > 50 && n < cooled;
        CAPTURE(n, tells);
        if (asks.samples[n].force_refused != warm) CHECK(asks.samples[n].force_refused == warm);
        if (zero[n] != warm) CHECK(zero[n] == warm);
    }
    CHECK(device.report().force_errors == 200);
    CHECK(device.report().withheld == phantom::Withheld::none);
    CHECK(hd.breaches == Names{});
}

TEST_CASE("phantom: a device fault ends the contact, and the run goes on once the driver has recovered",
          "[phantom][regression]") {
    auto& hd = fresh();
    Phantom device;
    std::vector<bool> zero;
    hd.before_update = [&](int n) {
        if (n > 0) zero.push_back(forceless(hd));
        if (n >= 50 && n < 450) hd.errors.push_back(HD_DEVICE_FAULT);
        if (n == 400) CHECK(device.report().withheld == phantom::Withheld::device_fault);
    };
    Asks asks{.often = 600};
    CHECK(device.run(asks) == DeviceEnd::stopped);
    REQUIRE(asks.samples.size() == 600);
    for (std::size_t n = 0; n < 599; ++n) {
        const bool faulty = n > 50 && n <= 450;
        if (asks.samples[n].force_refused != faulty) CHECK(asks.samples[n].force_refused == faulty);
        if (zero[n] != faulty) CHECK(zero[n] == faulty);
    }
    CHECK(device.report().device_faults == 400);
    CHECK(device.report().last_error == HD_DEVICE_FAULT);
    CHECK(hd.breaches == Names{});
}

TEST_CASE("phantom: a stop before the run ends that run, and only that", "[phantom][regression]") {
    auto& hd = fresh();
    Phantom device;
    device.stop();
    Asks asks;
    CHECK(device.run(asks) == DeviceEnd::stopped);
    CHECK(asks.samples.empty());
    CHECK_FALSE(hd.started);
    CHECK(hd.enabled.empty()); // the motors were never on
    CHECK(device.run(asks) == DeviceEnd::stopped);
    CHECK(asks.samples.size() == 100);

    hd.before_update = [&](int n) {
        if (n == 150) device.stop(); // within a run: that one's alone
    };
    Asks stopped;
    CHECK(device.run(stopped) == DeviceEnd::stopped);
    CHECK(stopped.samples.size() == 51);
    Asks again;
    CHECK(device.run(again) == DeviceEnd::stopped);
    CHECK(again.samples.size() == 100);
    CHECK(hd.breaches == Names{});
}

TEST_CASE("phantom: of errors that come together the gravest counts, of equally grave ones the most recent",
          "[phantom][regression]") {
    auto& hd = fresh();
    Phantom device;
    hd.before_update = [&](int n) {
        if (n == 10) {
            hd.errors.push_back(HD_EXCEEDED_MAX_FORCE);
            hd.errors.push_back(HD_EXCEEDED_MAX_VELOCITY); // on top of the stack
        }
        if (n == 20) {
            CHECK(device.report().last_error == HD_EXCEEDED_MAX_VELOCITY);
            hd.errors.push_back(HD_DEVICE_FAULT);
            hd.errors.push_back(HD_FORCE_ERROR);
        }
        if (n == 30) CHECK(device.report().last_error == HD_DEVICE_FAULT);
    };
    Asks asks;
    CHECK(device.run(asks) == DeviceEnd::stopped);
    CHECK(device.report().force_errors == 1);
    CHECK(device.report().device_faults == 1);
}

TEST_CASE("phantom: what the driver tells of the device is told on", "[phantom][regression]") {
    auto& hd = fresh();
    SECTION("all of it") {
        hd.temperature[1] = 0.4;
        hd.inkwell = false;
        Phantom device;
        CHECK(device.capabilities().resolution == Approx(0.055e-3));
        CHECK(device.continuous_force() == 0.88);
        CHECK(device.capabilities().max_slew == 0.7);
        Asks asks;
        CHECK(device.run(asks) == DeviceEnd::stopped);
        CHECK(device.report().temperature == 0.4);
        CHECK(device.report().inkwell_switch == false);
        CHECK(device.report().safety_switch == true);
        CHECK(device.capabilities().delay == unknown_delay);
    }
    SECTION("none of it, with an error each, which ends nothing and comes once") {
        hd.unknown = {HD_NOMINAL_MAX_CONTINUOUS_FORCE,
                      HD_SOFTWARE_FORCE_IMPULSE_LIMIT,
                      HD_DEVICE_MODEL_TYPE,
                      HD_MOTOR_TEMPERATURE,
                      HD_CURRENT_INKWELL_SWITCH,
                      HD_CURRENT_SAFETY_SWITCH};
        Phantom device;
        CHECK(device.is_open());
        CHECK(device.capabilities().resolution == 0);
        CHECK(device.continuous_force() == 0);
        CHECK(device.capabilities().max_slew == 0);
        for (int run = 0; run < 2; ++run) {
            Asks asks;
            CHECK(device.run(asks) == DeviceEnd::stopped);
            CHECK(asks.samples.size() == 100);
            CHECK_FALSE(device.report().temperature);
            CHECK_FALSE(device.report().inkwell_switch);
            CHECK_FALSE(device.report().safety_switch);
            CHECK(std::count(hd.in_tick.begin(), hd.in_tick.end(), "safety") == 0);
        }
    }
    SECTION("an error that is none of the questions' is still heard") {
        hd.before_update = [&](int n) { hd.temperature_error = n == 0 ? unsigned{HD_WARM_MOTORS} : 0u; };
        Phantom device;
        Asks asks;
        CHECK(device.run(asks) == DeviceEnd::stopped);
        CHECK(device.report().force_errors == 1);
        CHECK(device.report().temperature == 0);
        CHECK(asks.samples[1].force_refused);
    }
    CHECK(hd.breaches == Names{});
}

TEST_CASE("phantom: position resolutions by the model's name", "[phantom]") {
    const auto of = [](const char* model) { return phantom::OpenHaptics::resolution_of(model); };
    CHECK(of("Touch") == 0.055);
    CHECK(of("PHANTOM Omni") == 0.055);
    CHECK(of("Touch X") == 0.023);
    CHECK(of("PHANTOM Desktop") == 0.023);
    CHECK(of("PHANTOM Premium 1.5") == 0.03);
    CHECK(of("PHANTOM Premium 1.5 High Force") == 0.007);
    CHECK(of("Something else") == 0);
}

TEST_CASE("phantom: a device that is opened while another runs is not opened", "[phantom]") {
    auto& hd = fresh();
    Phantom device;
    hd.before_update = [&](int n) {
        if (n == 10) CHECK_FALSE(Phantom{"second"}.is_open());
    };
    Asks asks;
    CHECK(device.run(asks) == DeviceEnd::stopped);
    CHECK(asks.samples.size() == 100);
    CHECK_FALSE(hd.second.open);
    CHECK(hd.breaches == Names{});
    CHECK(Phantom{"second"}.is_open());
}

namespace {

/// Runs `device` without end, at 2 N upward, and in its 50th update `meanwhile`. Ends so many updates after that, unless
/// something else ends it before. Its force must never be interrupted.
template <class Meanwhile>
DeviceEnd run_undisturbed(Phantom& device, Meanwhile meanwhile, int more = 100) {
    FakeHd& hd = fake_hd();
    const FakeDevice& own = hd;
    int interrupted = 0, left = -1, n = 0;
    bool is_in = false;
    hd.before_update = [&](int) {
        interrupted += n++ > 0 && own.force != std::vector<double>{0, 2, 0};
        if (n < 50 || is_in) return;
        is_in = true; // what happens meanwhile may tick
        meanwhile();
        left = more;
    };
    const auto tick = [&](const DeviceSample&) -> DeviceCommand {
        return {{0, 0, 2}, left != 0 && left-- != 0};
    };
    const DeviceEnd end = device.run(tick);
    hd.before_update = nullptr;
    CHECK(interrupted == 0);
    CHECK(left == 0); // all of it
    return end;
}

} // namespace

TEST_CASE("phantom: where a second one cannot be scheduled the first goes on, and the second is told",
          "[phantom][regression]") {
    const unsigned code = GENERATE(unsigned{HD_SCHEDULER_FULL}, unsigned{HD_INVALID_PRIORITY});
    auto& hd = fresh();
    Phantom first, second{"second"};
    Asks asks;
    const auto end = run_undisturbed(first, [&] {
        hd.schedule_error = code;
        CHECK(second.run(asks) == DeviceEnd::not_available);
        CHECK(second.report().last_error == code);
        CHECK(asks.samples.empty());
        hd.schedule_error = 0;
        CHECK(second.run(asks) == DeviceEnd::stopped); // there is room again
        CHECK(asks.samples.size() == 100);
    });
    CHECK(end == DeviceEnd::stopped);
    CHECK(first.report().last_error == 0);
    CHECK(second.report().last_error == 0);
    CHECK(hd.breaches == Names{});
}

TEST_CASE(
    "phantom: an error of scheduling that comes amid the first's questions is not taken for their answer",
    "[phantom][regression]") {
    auto& hd = fresh();
    Phantom first;
    hd.before_update = [&](int n) { hd.temperature_error = n == 0 ? unsigned{HD_SCHEDULER_FULL} : 0u; };
    hd.temperature[0] = 0.3;
    Asks asks;
    CHECK(first.run(asks) == DeviceEnd::stopped);
    CHECK(first.report().temperature == 0.3);
    CHECK(first.report().last_error == 0);
    CHECK(hd.breaches == Names{});
}

TEST_CASE("phantom: motors that cannot be switched on are told to the device whose they are, and no other",
          "[phantom][regression]") {
    auto& hd = fresh();
    Phantom first, second{"second"};
    hd.second.enable_error = HD_BAD_HANDLE;
    Asks asks;
    const auto end = run_undisturbed(first, [&] {
        CHECK(second.run(asks) == DeviceEnd::not_available);
        CHECK(second.report().last_error == HD_BAD_HANDLE);
        CHECK(asks.samples.empty());
    });
    CHECK(end == DeviceEnd::stopped);
    CHECK(first.report().last_error == 0);
    CHECK(hd.breaches == Names{});
}

TEST_CASE(
    "phantom: a device that is destroyed while another runs ends at zero, and the other goes on undisturbed",
    "[phantom][regression]") {
    auto& hd = fresh();
    Phantom first;
    std::optional<Phantom> second{std::in_place, "second"};
    bool is_lost = false;
    SECTION("before it has run") {}
    SECTION("after a run") {
        CHECK(run_undisturbed(first, [&] {
                  Asks asks;
                  CHECK(second->run(asks) == DeviceEnd::stopped);
              }) == DeviceEnd::stopped);
    }
    SECTION("after a run that was lost") { is_lost = true; }
    const auto end = run_undisturbed(first, [&] {
        if (is_lost) {
            Asks asks;
            const auto tick = [&](const DeviceSample& sample) {
                if (asks.samples.size() == 20) hd.scheduled.back().is_held_up = true; // this one tick more
                return asks(sample);
            };
            CHECK(second->run(tick) == DeviceEnd::lost);
            CHECK(second->run(tick) == DeviceEnd::not_available); // its callback may still come
            CHECK(asks.samples.size() == 21);
        }
        second.reset();
        CHECK(hd.second.open); // closed when the scheduler has stopped
        FakeClock{}.wait();
        CHECK(hd.second.force == std::vector<double>{0, 0, 0});
        hd.scheduled.back().is_held_up = false; // it comes after all
        FakeClock{}.wait();
        CHECK(hd.scheduled.size() == 1);
        hd.errors.emplace_back(HD_COMM_ERROR, hd.second.handle); // someone pulls its plug
        FakeClock{}.wait();
        CHECK(hd.second.force == std::vector<double>{0, 0, 0});
    });
    CHECK(end == DeviceEnd::stopped);
    CHECK(first.report().last_error == 0);
    CHECK_FALSE(hd.second.open);
    CHECK(hd.open);
    CHECK(Phantom{"second"}.is_open());
    CHECK(hd.breaches == Names{});
}

TEST_CASE("phantom: a device that is lost while another runs ends at zero, and the other goes on undisturbed",
          "[phantom][regression]") {
    auto& hd = fresh();
    const bool comes_late = GENERATE(false, true);
    Phantom first, second{"second"};
    const auto end = run_undisturbed(first, [&] {
        Asks asks;
        const auto tick = [&](const DeviceSample& sample) {
            if (asks.samples.size() == 20) hd.scheduled.back().is_held_up = true;
            return asks(sample);
        };
        CHECK(second.run(tick) == DeviceEnd::lost);
        FakeClock{}.wait();
        CHECK(hd.second.force == std::vector<double>{0, 0, 0});
        if (!comes_late) return;
        hd.scheduled.back().is_held_up = false;
        FakeClock{}.wait();
        CHECK(asks.samples.size() == 21); // it comes late, is not heard, and is off the schedule
        CHECK(hd.scheduled.size() == 1);
        CHECK(second.run(asks) == DeviceEnd::stopped);
        CHECK(asks.samples.size() == 100);
    });
    CHECK(end == DeviceEnd::stopped);
    CHECK(first.report().last_error == 0);
    CHECK(hd.scheduled.empty());
    CHECK(hd.breaches == Names{});
}

TEST_CASE("phantom: a driver that stops calling back is lost", "[phantom]") {
    auto& hd = fresh();
    Phantom device;
    hd.before_update = [&](int n) {
        if (n == 30) hd.started = false; // this one tick more
    };
    Asks asks;
    CHECK(device.run(asks) == DeviceEnd::lost);
    CHECK(asks.samples.size() == 31);
    CHECK(forceless(hd));
}

TEST_CASE("phantom: after a connection that broke a device that does not open or start is tried again",
          "[phantom][regression]") {
    auto& hd = fresh();
    const bool was_there = GENERATE(true, false);
    const DeviceEnd last = GENERATE(DeviceEnd::stopped, DeviceEnd::fault, DeviceEnd::not_available);
    int attempts = 0, waits = 0;
    const auto attempt = [&] {
        const int n = ++attempts;
        const bool is_there = n == 1 ? was_there : n >= 6;
        hd.init_gives_no_handle = n == 2;
        hd.enable_error = n == 3 ? unsigned{HD_BAD_HANDLE} : 0u;
        hd.schedule_error = n == 4 ? unsigned{HD_SCHEDULER_FULL} : 0u;
        hd.start_error =
            n == 5 || !is_there || last == DeviceEnd::not_available ? unsigned{HD_TIMER_ERROR} : 0u;
        if (n == 1 && was_there) hd.start_error = 0;
        hd.updates = 0;
        hd.before_update = [&hd, n, last](int update) {
            if (update == 20 && n == 1) hd.errors.push_back(HD_COMM_ERROR);
            if (update == 20 && n > 1 && last == DeviceEnd::fault) hd.errors.push_back(HD_FRAME_ERROR);
        };
        Phantom device;
        Asks asks;
        return device.run(asks);
    };
    const auto wait = [&] { ++waits; };
    const auto goes_on = [&] { return attempts < 10; };
    const DeviceEnd end = phantom::run_and_reconnect(attempt, wait, goes_on);
    if (was_there) {
        CHECK(end == last);
        CHECK(attempts == (last == DeviceEnd::not_available ? 10 : 6));
        CHECK(waits == attempts - 1);
    } else {
        CHECK(end == DeviceEnd::not_available);
        CHECK(attempts == 1);
    }
    CHECK(hd.breaches == Names{});
}

TEST_CASE("phantom: a callback that comes late is counted and measured", "[phantom]") {
    auto& hd = fresh();
    Phantom device;
    hd.before_update = [&](int n) {
        if (n == 20) hd.time += 0.0009; // past due, but by less than a millisecond
        if (n == 40 || n == 60) hd.time += 0.0011;
        if (n == 80) hd.time += 0.25;
    };
    Asks asks;
    CHECK(device.run(asks) == DeviceEnd::stopped);
    const auto report = device.report();
    CHECK(report.updates == 100);
    CHECK(report.late == 3);
    CHECK(report.latest == Approx(0.25).epsilon(1e-3));
}

TEST_CASE("phantom: after a callback that comes too late the guard gives zero at once, then the ramp",
          "[phantom]") {
    auto& hd = fresh();
    Phantom device;
    ForceGuard guard{{.ramp = 0.1}};
    int tick = 0;
    const auto guarded = [&](const DeviceSample& sample) -> DeviceCommand {
        return {guard.update(sample, {0, 0, 2}).newtons, ++tick < 1000};
    };
    std::vector<double> up;
    hd.before_update = [&](int n) {
        if (n > 0) up.push_back(hd.force[1]);
        if (n == 300) hd.time += 0.0015; // late, but nothing to a hand
        if (n == 600) hd.time += 0.020;
    };
    CHECK(device.run(guarded) == DeviceEnd::stopped);
    CHECK(device.report().late == 2);
    CHECK(guard.counts().trips[static_cast<int>(GuardTrip::stale)] == 1);
    CHECK(up[200] == 2);
    CHECK(up[300] == 2);
    CHECK(up[599] == 2);
    CHECK(up[600] == 0);
    CHECK(up[650] == Approx(1).epsilon(0.03));
    CHECK(up[750] == 2);
}

TEST_CASE("phantom: how long the tick takes is measured", "[phantom]") {
    auto& hd = fresh();
    Phantom device;
    int n = 0;
    const auto slow = [&](const DeviceSample&) -> DeviceCommand {
        if (++n == 10) hd.time += 0.003;
        return {glm::dvec3{0.0}, n < 20};
    };
    CHECK(device.run(slow) == DeviceEnd::stopped);
    CHECK(device.report().longest_tick == Approx(0.003).epsilon(1e-3));
    CHECK(device.report().late == 1); // the next one came three milliseconds past due
}

TEST_CASE("phantom: no tick and no force while the device wants calibration", "[phantom]") {
    auto& hd = fresh();
    SECTION("it can do by itself") { hd.styles = HD_CALIBRATION_ENCODER_RESET | HD_CALIBRATION_AUTO; }
    SECTION("it can do in the inkwell") { hd.styles = HD_CALIBRATION_ENCODER_RESET | HD_CALIBRATION_INKWELL; }
    hd.calibration = HD_CALIBRATION_NEEDS_UPDATE;
    Phantom device;
    hd.before_update = [&](int n) {
        if (n < 21) CHECK(forceless(hd));
        if (n == 10) CHECK(device.report().calibration == phantom::Calibration::needs_update);
        if (n == 20) hd.calibration = HD_CALIBRATION_OK;
    };
    Asks asks;
    CHECK(device.run(asks) == DeviceEnd::stopped);
    CHECK(hd.calibrations == 20);
    CHECK(asks.samples.size() == 100);
    CHECK(device.report().updates == 120);
    CHECK(device.report().calibration == phantom::Calibration::ok);
    CHECK(hd.breaches == Names{});
}

/// The hand of the calibration tests: presses through the ground, 3.1 mm below the middle, to 7 mm below it.
struct PressingHand {
    double at = 5; ///< mm above the middle, by the hand's own account

    void move(FakeHd& hd, int n, double shift) {
        at += std::clamp((n > 1000 ? -7.0 : 5.0) - at, -0.05, 0.05);
        hd.position[1] = 10 + at + shift;
    }
};

TEST_CASE("phantom: a calibration while pressed takes the force back first, and gives it back by the ramp",
          "[phantom][regression]") {
    auto& hd = fresh();
    hd.styles = HD_CALIBRATION_ENCODER_RESET | HD_CALIBRATION_AUTO;
    const std::vector<std::int16_t> flat(256 * 256, 100);
    const BilinearGrid<double, HeightView<std::int16_t>> grid{HeightView{flat.data(), 256, 256},
                                                              {.spacing = {10.0, 10.0}}};
    Phantom device;
    const auto able = device.capabilities();
    phantom::Scene scene{grid, phantom::frame_for(able, 2560, {1280, 1280, 150}),
                         phantom::stiffness_for(able), phantom::limits_for(able)};
    // Whether the device goes on wanting it until it is calibrated, or only in one update, as if by mistake.
    const bool goes_on = GENERATE(true, false);
    PressingHand hand;
    double shift = 0;
    std::vector<double> up;
    std::vector<DeviceSample> samples;
    hd.before_update = [&](int n) {
        if (n > 0) up.push_back(hd.force[1]);
        if (n == 2000) hd.calibration = HD_CALIBRATION_NEEDS_UPDATE;
        if (n == 2001 && !goes_on) hd.calibration = HD_CALIBRATION_OK;
        hand.move(hd, n, shift);
        if (n == 2400) CHECK((device.report().withheld == phantom::Withheld::calibration) == goes_on);
    };
    hd.calibrated = [&](int) {
        shift -= 3; // deeper
        hd.calibration = HD_CALIBRATION_OK;
    };
    const auto until_4000 = [&](const DeviceSample& sample) -> DeviceCommand {
        samples.push_back(sample);
        DeviceCommand command = scene(sample);
        command.go_on = hd.updates < 4000;
        return command;
    };
    CHECK(device.run(until_4000) == DeviceEnd::stopped);
    CHECK(hd.breaches == Names{}); // one of which: calibrated while there is a force
    REQUIRE(up.size() == 3999);

    const double slew = phantom::limits_for(able).max_slew; // N/ms
    CHECK(slew == 0.7);
    for (std::size_t n = 1; n < up.size(); ++n) {
        CAPTURE(n, up[n - 1], up[n]);
        if (up[n] - up[n - 1] > slew + 1e-12) CHECK(up[n] - up[n - 1] <= slew + 1e-12);
        // Before the calibration it falls as slowly as it comes: 3.3 N in half a second, and a margin. The hand itself stops
        // before that, and the coupling's damper of ¾·400 N/m · 0.05 mm goes.
        const double most = n < 1300 ? 0.0151 : 0.01;
        if (up[n - 1] - up[n] > most) CHECK(up[n - 1] - up[n] <= most);
    }
    CHECK(up[1999] == Approx(1.55).epsilon(0.01));
    const auto calls = static_cast<std::size_t>(hd.updates) - samples.size(); // updates without a tick
    if (goes_on) {
        CHECK(hd.calibrations == 1);
        CHECK(calls == 1); // that of the calibration
        CHECK(up[2250] > 0.5);
        CHECK(up[2600] == 0); // the old contact is forgotten, and the stylus is under the ground
        CHECK(scene.counts().trips[static_cast<int>(GuardTrip::jump)] == 0);
        CHECK(scene.counts().trips[static_cast<int>(GuardTrip::stale)] == 0);
        CHECK(std::count_if(samples.begin(), samples.end(), [](const auto& s) { return s.force_refused; }) ==
              1);
    } else {
        CHECK(hd.calibrations == 0);
        CHECK(calls == 0);
        CHECK(up[2100] == Approx(1.55).epsilon(0.01)); // hardly noticed
        CHECK(up[2001] > 1.5);
    }
}

TEST_CASE("phantom: before a calibration a tick that keeps its force has it taken back, and is told",
          "[phantom][regression]") {
    auto& hd = fresh();
    Phantom device;
    std::vector<double> up;
    hd.before_update = [&](int n) {
        if (n > 0) up.push_back(hd.force[1]);
        if (n == 100) hd.calibration = HD_CALIBRATION_NEEDS_UPDATE;
    };
    hd.calibrated = [&](int) { hd.calibration = HD_CALIBRATION_OK; };
    Asks asks{.newtons = {0, 0, 3}, .often = 1300};
    CHECK(device.run(asks) == DeviceEnd::stopped);
    CHECK(hd.breaches == Names{});
    CHECK(hd.calibrations == 1);
    CHECK(up[99] == 3);
    for (std::size_t n = 100; n < 1099; ++n)
        if (std::abs(up[n - 1] - up[n] - 0.003) > 1e-9) CHECK(up[n - 1] - up[n] == Approx(0.003));
    CHECK(up[1101] == 0);
    CHECK(up[1150] == 3);
    // Told what the motors got, and when: also in the update without a tick.
    CHECK_FALSE(asks.samples[0].has_sent);
    for (std::size_t n = 1; n < 1000; ++n) {
        if (asks.samples[n].sent.z != up[n - 1]) CHECK(asks.samples[n].sent.z == up[n - 1]);
        if (asks.samples[n].sent_at != asks.samples[n - 1].time)
            CHECK(asks.samples[n].sent_at == asks.samples[n - 1].time);
        const bool release = n >= 100;
        if (asks.samples[n].release != release) CHECK(asks.samples[n].release == release);
    }
    const auto back =
        std::find_if(asks.samples.begin(), asks.samples.end(), [](const auto& s) { return s.force_refused; });
    REQUIRE(back != asks.samples.end());
    CHECK_FALSE(back->release);
    CHECK(back->sent == glm::dvec3{0});
    CHECK(back->time - back->sent_at == Approx(0.001));
    CHECK(back->time - (back - 1)->time == Approx(0.002)); // one update without a tick lies between
}

TEST_CASE("phantom: where calibration needs a person it waits, and can be stopped", "[phantom]") {
    auto& hd = fresh();
    const bool manual = GENERATE(true, false);
    hd.calibration = manual ? HD_CALIBRATION_NEEDS_MANUAL_INPUT : HD_CALIBRATION_NEEDS_UPDATE;
    hd.styles = HD_CALIBRATION_ENCODER_RESET; // which only a person can do
    Phantom device;
    hd.before_update = [&](int n) {
        if (n == 50) device.stop();
    };
    Asks asks;
    CHECK(device.run(asks) == DeviceEnd::stopped);
    CHECK(asks.samples.empty());
    CHECK(hd.calibrations == 0);
    CHECK(device.report().calibration == phantom::Calibration::needs_user);
    CHECK(forceless(hd));
}

TEST_CASE("phantom: a force that is no number is not sent", "[phantom]") {
    auto& hd = fresh();
    Phantom device;
    hd.before_update = [&](int) { CHECK(forceless(hd)); };
    Asks asks{.newtons = {0, std::nan(""), 1}};
    CHECK(device.run(asks) == DeviceEnd::stopped);
}

TEST_CASE("phantom: a terrain is felt through tracker, workspace and guard", "[phantom]") {
    auto& hd = fresh();
    Phantom device;
    const std::vector<float> flat(11 * 11, 100.0f);
    const BilinearGrid<double, HeightView<float>> grid{HeightView{flat.data(), 11, 11},
                                                       {.spacing = {256, 256}}};
    const auto able = device.capabilities();
    phantom::Scene scene{grid, phantom::frame_for(able, 2560, {1280, 1280, 100}),
                         phantom::stiffness_for(able), phantom::limits_for(able)};
    // In air for a second, then 4 mm into level ground at 0.4 N/mm, then a force error, then up and down again, and at
    // last the clutch.
    std::vector<double> up;
    hd.before_update = [&](int n) {
        if (n > 0) up.push_back(hd.force[1]);
        const bool down = (n >= 1000 && n < 3000) || (n >= 3200 && n < 6000);
        const double to = down ? -4 : 4; // mm about the middle
        const double at = n == 0 ? 4 : hd.position[1] - 10;
        hd.position[1] = 10 + at + std::clamp(to - at, -0.2, 0.2);
        if (n == 2000) hd.errors.push_back(HD_EXCEEDED_MAX_FORCE);
        hd.buttons = n >= 5000 && n < 5100 ? 1 : 0;
        if (n == 5900) device.stop();
    };
    CHECK(device.run(scene) == DeviceEnd::stopped);
    CHECK(hd.breaches == Names{});
    CHECK(up[900] == 0);
    CHECK(up[1500] == Approx(1.6));
    for (int n = 2001; n < 3218; ++n)
        CHECK(up[static_cast<std::size_t>(n)] == 0); // contact ended: buried until out once
    CHECK(up[4900] == Approx(1.6));
    CHECK(up[5000] == 0);                         // the clutch
    CHECK(up[5350] == Approx(0.8).epsilon(0.02)); // half the ramp
    CHECK(up[5800] == Approx(1.6));
    CHECK(scene.counts().trips[static_cast<int>(GuardTrip::device_fault)] == 1);
    CHECK(scene.counts().trips[static_cast<int>(GuardTrip::buried)] == 1);
    phantom::Shown shown;
    CHECK(scene.show(shown));
    CHECK(shown.contact == ContactStatus::contact);
    CHECK(shown.stylus.z == Approx(100 - 0.004 * 16000));
}

namespace {

/// Takes a hand through a scene over 21 × 21 samples of level ground at 100 m, 10 m apart, at 1000 m a metre, and notes
/// what was felt and told. Positions of the hand in mm from the middle of the map at the height of the ground.
struct Walk {
    std::vector<float> heights = std::vector<float>(21 * 21, 100.0f);
    BilinearGrid<double, HeightView<float>> grid{HeightView{heights.data(), 21, 21}, {.spacing = {10, 10}}};
    WorkspaceFrame frame{.scale = 1000, .offset = {100, 100, 100}};
    double time = 0;
    glm::dvec3 at{0, 0, 3};
    phantom::Shown shown{};
    double felt = 0, steepest_rise = 0;

    /// At 0.1 m/s.
    template <class Scene>
    void to(Scene& scene, const glm::dvec3& mm) {
        while (at != mm) {
            const glm::dvec3 way = mm - at;
            at = glm::length(way) <= 0.1 ? mm : at + way * (0.1 / glm::length(way));
            feel(scene);
        }
        feel(scene); // at rest: the spring without the coupling's damper
        (void)scene.show(shown);
    }

    template <class Scene>
    void feel(Scene& scene) {
        time += 0.001;
        const auto command = scene({.time = time, .position = at / 1000.0});
        steepest_rise = std::max(steepest_rise, glm::length(command.newtons) - felt);
        felt = glm::length(command.newtons);
    }
};

} // namespace

TEST_CASE("phantom: a hand that presses the terrain gets no energy from it", "[phantom][regression]") {
    // By the spring alone 0.26 mJ at 0.1 m/s, and 0.69 at 0.2 m/s.
    const std::vector<float> flat(21 * 21, 100.0f);
    const BilinearGrid<double, HeightView<float>> grid{HeightView{flat.data(), 21, 21},
                                                       {.spacing = {10, 10}}};
    const DeviceCapabilities& able = simulated_touch.capabilities;
    for (const double speed : {0.02, 0.1, 0.2}) {
        phantom::Scene scene{grid,
                             {.scale = 1000, .offset = {100, 100, 100}},
                             phantom::stiffness_for(able),
                             phantom::limits_for(able)};
        const Presses presses{.depth = 0.01, .speed = speed};
        double time = 0;
        for (; time < 0.6; time += 0.001) (void)scene({.time = time, .position = {0, 0, 0.002}}); // the ramp
        const auto felt =
            press_wall(simulated_touch, {}, presses, 3, 400, [&](const glm::dvec3& at, const glm::dvec3&) {
                time += 0.001;
                return scene({.time = time, .position = at}).newtons;
            });
        CAPTURE(speed, felt.lowest);
        CHECK(felt.lowest >= -1e-4);
        CHECK(felt.most > 1);
        CHECK(scene.counts().held_back == 0);
    }
}

TEST_CASE("phantom: over the rim of a map without more, and under it: nothing is felt, and it is told",
          "[phantom][regression]") {
    using phantom::Place;
    Walk walk;
    phantom::Scene scene{walk.grid, walk.frame, 400, {}};
    walk.to(scene, {0, 0, 3});
    walk.to(scene, {60, 0, 3}); // long enough for the ramp
    walk.to(scene, {90, 0, -3});
    CHECK(walk.shown.place == Place::on_map);
    CHECK(walk.felt == Approx(1.2));
    walk.to(scene, {101, 0, -3});
    CHECK(walk.shown.place == Place::beyond_map);
    walk.to(scene, {105, 0, -3});
    CHECK(walk.shown.place == Place::beyond_map);
    CHECK(walk.felt == 0);
    walk.to(scene, {90, 0, -3});
    CHECK(walk.shown.place == Place::below_ground);
    CHECK(walk.shown.trip == GuardTrip::buried);
    CHECK(walk.felt == 0);
    walk.to(scene, {90, 0, 1});
    CHECK(walk.shown.place == Place::on_map);
    walk.to(scene, {40, 0, 1}); // long enough for the ramp
    walk.to(scene, {40, 0, -3});
    CHECK(walk.felt == Approx(1.2)); // felt again
    CHECK(walk.steepest_rise < 0.1);
}

TEST_CASE("phantom: over the rim of a map that goes on level the ground is felt, and the edge is told",
          "[phantom][regression]") {
    using phantom::Place;
    Walk walk;
    const ExtendedField ground{walk.grid};
    phantom::Scene scene{ground, walk.frame, 400, {}, phantom::Bounds{.map = walk.grid.cells()}};
    walk.to(scene, {60, 0, 3});
    walk.to(scene, {60, 0, -3});
    walk.to(scene, {99, 0, -3});
    CHECK(walk.shown.place == Place::on_map);
    walk.to(scene, {120, 0, -3});
    CHECK(walk.shown.place == Place::beyond_map);
    CHECK(walk.felt == Approx(1.2));
    walk.to(scene, {0, -101, -3});
    CHECK(walk.shown.place == Place::beyond_map);
    walk.to(scene, {0, -99, -3});
    CHECK(walk.shown.place == Place::on_map);
    CHECK(walk.felt == Approx(1.2));
}

TEST_CASE("phantom: a hole in the map, and the end of the device's reach, are told",
          "[phantom][regression]") {
    using phantom::Place;
    Walk walk;
    walk.heights[10 * 21 + 12] = std::nanf(""); // at 20 m, 0 m from the middle
    phantom::Scene scene{walk.grid, walk.frame, 400, {}, phantom::Bounds{.workspace = {0.16, 0.07, 0.12}}};
    walk.to(scene, {18, 0, -3});
    CHECK(walk.shown.place == Place::over_hole);
    CHECK(walk.felt == 0);
    walk.to(scene, {18, 0, 3});
    walk.to(scene, {40, 0, 3});
    CHECK(walk.shown.place == Place::on_map);
    walk.to(scene, {40, 0, -3});
    walk.to(scene, {74, 0, -3});
    CHECK(walk.shown.place == Place::on_map);
    walk.to(scene, {76, 0, -3});
    CHECK(walk.shown.place == Place::device_edge);
    CHECK(walk.felt == Approx(1.2)); // the terrain is felt as elsewhere
    walk.to(scene, {40, -31, 3});
    CHECK(walk.shown.place == Place::device_edge);
    for (const Place place : {Place::below_ground, Place::beyond_map, Place::over_hole, Place::device_edge})
        CHECK(std::string{hint(place)} != "");
    CHECK(std::string{hint(Place::on_map)} == "");
}
