#include "../catch.hpp"
#include "fake_hd.hpp"

#include "openhaptics.hpp"
#include "scene.hpp"

#include <algorithm>
#include <cmath>
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
                                            "enable output", "enable ramping", "enable clamping", "schedule",
                                            "start", "disable output", "stop", "unschedule", "close"});
    CHECK(hd.in_tick ==
          Names{"begin", "check calibration", "position", "velocity", "buttons", "force", "end", "error"});
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
    if (which == 4) hd.start_error = HD_TIMER_ERROR;
    {
        Phantom device;
        CHECK(device.is_open() == (which > 1));
        Asks asks;
        CHECK(device.run(asks) == DeviceEnd::not_available);
        CHECK(asks.samples.empty());
        const unsigned codes[] = {0, HD_DEVICE_FAULT, HD_BAD_HANDLE, HD_SCHEDULER_FULL, HD_TIMER_ERROR};
        CHECK(device.report().last_error == codes[which]);
    }
    CHECK(hd.breaches == Names{});
    CHECK_FALSE(hd.open);
    CHECK_FALSE(hd.started);
    CHECK(hd.callback == nullptr);
}

TEST_CASE("phantom: a force error lets go of the contact, and the run goes on", "[phantom]") {
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
        if (n >= 20) hd.errors.push_back(HD_WARM_MOTORS);
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
                 Case{HD_ILLEGAL_END, DeviceEnd::fault}, Case{HD_DEVICE_FAULT, DeviceEnd::fault},
                 Case{HD_TIMER_ERROR, DeviceEnd::fault}, Case{12345u, DeviceEnd::fault});
    const bool with_force_error = GENERATE(false, true);
    auto& hd = fresh();
    Phantom device;
    hd.before_update = [&, code = code](int n) {
        if (n == 30 && with_force_error) hd.errors.push_back(HD_EXCEEDED_MAX_FORCE);
        if (n == 30) hd.errors.push_back(code);
    };
    Asks asks;
    CHECK(device.run(asks) == end);
    CHECK(asks.samples.size() == 31);
    CHECK(forceless(hd));
    CHECK(device.report().last_error == code);
    CHECK_FALSE(hd.started);
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
        CHECK(up[static_cast<std::size_t>(n)] == 0); // let go: buried until out once
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
