#include "fake_hd.hpp"

#include <algorithm>
#include <mutex>

namespace hfh::test {

FakeHd& fake_hd() {
    static FakeHd driver;
    return driver;
}

#ifdef HFH_TEST_HAND
void start_hand(); // sdk/hand.cpp
void stop_hand();
#else
static void start_hand() {}
static void stop_hand() {}
#endif

/// A driver may be called from any thread while it ticks in its own.
static std::unique_lock<std::mutex> lock() {
    static std::mutex mutex;
    return std::unique_lock{mutex};
}

static thread_local bool ticking = false;

/// Like a servo loop, does not hold off other calls while a callback runs.
void FakeHd::update() {
    auto locked = lock();
    if (scheduled.empty()) return;
    const int n = updates;
    locked.unlock();
    if (before_update) before_update(n);
    locked.lock();
    ++updates;
    in_tick.clear();
    for (const Scheduled& next : std::vector<Scheduled>{scheduled}) {
        if (next.is_held_up) continue;
        const int raised_elsewhere = errors_raised_elsewhere;
        locked.unlock();
        ticking = true;
        const HDCallbackCode code = next.callback(next.user);
        ticking = false;
        locked.lock();
        if (in_frame || second.in_frame) breaches.emplace_back("a tick ends within a frame");
        // One that another thread raised meanwhile may be too late for this tick.
        if (!errors.empty() && errors_raised_elsewhere == raised_elsewhere)
            breaches.emplace_back("a tick leaves errors behind");
        if (code != HD_CALLBACK_DONE && code != HD_CALLBACK_CONTINUE)
            breaches.emplace_back("a callback returns something else");
        if (code == HD_CALLBACK_CONTINUE) continue;
        std::erase_if(scheduled, [&](const Scheduled& s) { return s.handle == next.handle; });
        (current == second.handle ? second.left : left) = current == second.handle ? second.force : force;
    }
}

namespace {

void note(const char* call) {
    FakeHd& hd = fake_hd();
    (ticking ? hd.in_tick : hd.calls).emplace_back(call);
}
void must(bool holds, const char* what) {
    if (!holds) fake_hd().breaches.emplace_back(what);
}
void raise(unsigned error) {
    if (error == 0) return;
    fake_hd().errors.emplace_back(error, fake_hd().current);
    if (!ticking) ++fake_hd().errors_raised_elsewhere;
}
FakeDevice* find(HHD device) {
    FakeHd& hd = fake_hd();
    return device == hd.handle ? &hd : device == hd.second.handle ? &hd.second : nullptr;
}
/// That which calls without a handle are for.
FakeDevice& current() {
    FakeDevice* device = find(fake_hd().current);
    must(device != nullptr && device->open, "a call without a handle is for an open device");
    return device != nullptr ? *device : fake_hd();
}
/// Whether the current device knows this; raises an error if not.
bool knows(HDenum name) {
    const auto& unknown = current().unknown;
    const bool known = std::find(unknown.begin(), unknown.end(), name) == unknown.end();
    if (!known) raise(HD_INVALID_ENUM);
    return known;
}
void must_be_owner() {
    FakeHd& hd = fake_hd();
    const bool calls_back = std::any_of(hd.scheduled.begin(), hd.scheduled.end(),
                                        [](const FakeHd::Scheduled& s) { return !s.is_held_up; });
    must(ticking || !hd.started || !calls_back, "while the servo loop runs nobody else makes such a call");
}

} // namespace
} // namespace hfh::test

using namespace hfh::test;

HDErrorInfo hdGetError() {
    const auto locked = lock();
    note("error");
    must_be_owner();
    FakeHd& hd = fake_hd();
    HDErrorInfo info{};
    if (hd.errors.empty()) return info;
    info.errorCode = hd.errors.back().code;
    info.hHD = hd.errors.back().device;
    hd.errors.pop_back();
    return info;
}

HHD hdInitDevice(HDstring name) {
    const auto locked = lock();
    note("init");
    FakeHd& hd = fake_hd();
    must(!hd.started, "devices are opened before the scheduler starts");
    must(hd.errors.empty(), "errors of before are taken before init");
    FakeDevice& device = name != HD_DEFAULT_DEVICE && std::string{name} == "second" ? hd.second : hd;
    raise(hd.init_error);
    if (hd.init_gives_no_handle) return HD_INVALID_HANDLE;
    device.open = true;
    return hd.current = device.handle;
}

void hdDisableDevice(HHD device) {
    const auto locked = lock();
    note("close");
    must(find(device) != nullptr && find(device)->open, "an open device is closed");
    must(!fake_hd().started, "the scheduler is stopped before the device is closed");
    if (FakeDevice* closed = find(device)) closed->open = false;
}

void hdMakeCurrentDevice(HHD device) {
    const auto locked = lock();
    must_be_owner();
    must(find(device) != nullptr && find(device)->open, "an open device is made the current one");
    fake_hd().current = device;
}

void hdEnable(HDenum capability) {
    const auto locked = lock();
    note(capability == HD_FORCE_OUTPUT         ? "enable output"
         : capability == HD_FORCE_RAMPING      ? "enable ramping"
         : capability == HD_MAX_FORCE_CLAMPING ? "enable clamping"
                                               : "enable something else");
    must(current().open, "enabled when open");
    current().enabled.push_back(capability);
    raise(current().enable_error);
}

void hdDisable(HDenum capability) {
    const auto locked = lock();
    note("disable output");
    must(capability == HD_FORCE_OUTPUT, "only the output is disabled");
    std::fill(current().force.begin(), current().force.end(), 0.0);
}

void hdGetDoublev(HDenum name, HDdouble* values) {
    const auto locked = lock();
    FakeDevice& hd = current();
    if (name == HD_CURRENT_POSITION || name == HD_CURRENT_VELOCITY) must(hd.in_frame, "read within a frame");
    switch (name) {
    case HD_CURRENT_POSITION:
        note("position");
        std::copy(hd.position, hd.position + 3, values);
        break;
    case HD_CURRENT_VELOCITY:
        note("velocity");
        std::copy(hd.velocity, hd.velocity + 3, values);
        break;
    case HD_MOTOR_TEMPERATURE:
        note("temperature");
        if (knows(name)) std::copy(hd.temperature, hd.temperature + 6, values);
        raise(hd.temperature_error);
        break;
    case HD_NOMINAL_MAX_STIFFNESS:
        note("stiffness");
        *values = hd.stiffness;
        break;
    case HD_NOMINAL_MAX_FORCE:
        note("max force");
        *values = hd.max_force;
        break;
    case HD_NOMINAL_MAX_CONTINUOUS_FORCE:
        note("continuous force");
        if (knows(name)) *values = hd.continuous_force;
        break;
    case HD_SOFTWARE_FORCE_IMPULSE_LIMIT:
        note("impulse");
        if (knows(name)) *values = hd.impulse;
        break;
    case HD_USABLE_WORKSPACE_DIMENSIONS:
        note("workspace");
        std::copy(hd.box, hd.box + 6, values);
        break;
    default: must(false, "a double that is none");
    }
}

void hdGetIntegerv(HDenum name, HDint* values) {
    const auto locked = lock();
    FakeDevice& hd = current();
    switch (name) {
    case HD_CURRENT_BUTTONS:
        note("buttons");
        *values = hd.buttons;
        break;
    case HD_UPDATE_RATE:
        note("rate");
        *values = hd.rate;
        break;
    case HD_CALIBRATION_STYLE: *values = hd.styles; break;
    default: must(false, "an integer that is none");
    }
}

void hdGetBooleanv(HDenum name, HDboolean* values) {
    const auto locked = lock();
    FakeDevice& hd = current();
    must(hd.in_frame, "switches are read within a frame");
    note(name == HD_CURRENT_INKWELL_SWITCH ? "inkwell" : "safety");
    must(name == HD_CURRENT_INKWELL_SWITCH || name == HD_CURRENT_SAFETY_SWITCH, "a boolean that is none");
    if (knows(name)) *values = name == HD_CURRENT_INKWELL_SWITCH ? hd.inkwell : hd.safety;
}

HDstring hdGetString(HDenum name) {
    const auto locked = lock();
    note("model");
    must(name == HD_DEVICE_MODEL_TYPE, "a string that is none");
    return knows(name) ? current().model : nullptr;
}

void hdSetDoublev(HDenum name, const HDdouble* values) {
    const auto locked = lock();
    note("force");
    must(name == HD_CURRENT_FORCE && current().in_frame, "the force is set within a frame");
    current().force.assign(values, values + 3);
}

void hdBeginFrame(HHD device) {
    const auto locked = lock();
    note("begin");
    must(device == fake_hd().current && !current().in_frame && ticking, "a frame begins in a tick");
    current().in_frame = true;
}

void hdEndFrame(HHD device) {
    const auto locked = lock();
    note("end");
    must(device == fake_hd().current && current().in_frame, "a frame ends that has begun");
    current().in_frame = false;
}

HDenum hdCheckCalibration() {
    const auto locked = lock();
    note("check calibration");
    must(ticking, "calibration is checked in the servo loop");
    return current().calibration;
}

void hdUpdateCalibration(HDenum style) {
    const auto locked = lock();
    note("update calibration");
    FakeDevice& hd = current();
    must(ticking && !hd.in_frame, "calibration is updated in the servo loop, outside of a frame");
    must(style == HD_CALIBRATION_AUTO || style == HD_CALIBRATION_INKWELL, "never by resetting the encoders");
    must((hd.styles & static_cast<int>(style)) != 0, "in a style that the device has");
    must(std::all_of(hd.force.begin(), hd.force.end(), [](double f) { return f == 0; }),
         "the force is zero when the position jumps");
    ++hd.calibrations;
    if (fake_hd().calibrated) fake_hd().calibrated(hd.calibrations);
}

HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback callback, void* user, HDushort priority) {
    const auto locked = lock();
    note("schedule");
    FakeHd& hd = fake_hd();
    hd.priority = priority;
    raise(hd.schedule_error); // about the current device, as the driver has it, whoever schedules
    if (hd.schedule_error != 0) return HD_INVALID_HANDLE;
    hd.scheduled.push_back({++hd.last_schedule, callback, user});
    return hd.last_schedule;
}

void hdUnschedule(HDSchedulerHandle handle) {
    const auto locked = lock();
    note("unschedule");
    FakeHd& hd = fake_hd();
    must(0x1'0000'0000ul < handle && handle <= hd.last_schedule, "what was scheduled is unscheduled");
    const bool found =
        std::erase_if(hd.scheduled, [&](const FakeHd::Scheduled& s) { return s.handle == handle; }) > 0;
    // HD_INVALID_OPERATION, as the reference says of an operation that has ended; on the stack of who runs.
    if (!found && hd.started) raise(0x0102);
    must(!hd.started || !hd.scheduled.empty(), "stopped before the last one is unscheduled");
}

void hdStartScheduler() {
    auto locked = lock();
    note("start");
    must(!fake_hd().started, "started once");
    raise(fake_hd().start_error);
    fake_hd().started = fake_hd().start_error == 0;
    if (!fake_hd().started) return;
    locked.unlock(); // it may tick before this returns
    start_hand();
}

void hdStopScheduler() {
    stop_hand(); // waits for a tick that may call the driver
    const auto locked = lock();
    note("stop");
    if (!fake_hd().started) raise(HD_TIMER_ERROR);
    fake_hd().started = false;
}
