#include "fake_hd.hpp"

#include <algorithm>
#include <mutex>

namespace hfh::test {

FakeHd& fake_hd() {
    static FakeHd device;
    return device;
}

#ifdef HFH_TEST_HAND
void start_hand(); // sdk/hand.cpp
void stop_hand();
#else
static void start_hand() {}
static void stop_hand() {}
#endif

/// A driver may be called from any thread while it ticks in its own.
static std::unique_lock<std::recursive_mutex> lock() {
    static std::recursive_mutex mutex;
    return std::unique_lock{mutex};
}

void FakeHd::update() {
    const auto locked = lock();
    if (callback == nullptr) return; // it was done
    if (before_update) before_update(updates);
    ++updates;
    in_tick.clear();
    ticking = true;
    const HDCallbackCode code = callback(user);
    ticking = false;
    if (in_frame) breaches.emplace_back("a tick ends within a frame");
    if (!errors.empty()) breaches.emplace_back("a tick leaves errors behind");
    if (code == HD_CALLBACK_DONE) {
        callback = nullptr;
        left = force;
    } else if (code != HD_CALLBACK_CONTINUE) {
        breaches.emplace_back("a callback returns something else");
    }
}

namespace {

void note(const char* call) {
    FakeHd& hd = fake_hd();
    (hd.ticking ? hd.in_tick : hd.calls).emplace_back(call);
}
void must(bool holds, const char* what) {
    if (!holds) fake_hd().breaches.emplace_back(what);
}
void raise(unsigned error) {
    if (error != 0) fake_hd().errors.push_back(error);
}

} // namespace
} // namespace hfh::test

using namespace hfh::test;

HDErrorInfo hdGetError() {
    const auto locked = lock();
    note("error");
    FakeHd& hd = fake_hd();
    HDErrorInfo info{};
    if (hd.errors.empty()) return info;
    info.errorCode = hd.errors.front();
    hd.errors.pop_front();
    return info;
}

HHD hdInitDevice(HDstring) {
    const auto locked = lock();
    note("init");
    FakeHd& hd = fake_hd();
    must(hd.errors.empty(), "errors of before are taken before init");
    raise(hd.init_error);
    if (hd.init_gives_no_handle) return HD_INVALID_HANDLE;
    hd.open = true;
    return 5;
}

void hdDisableDevice(HHD device) {
    const auto locked = lock();
    note("close");
    must(device == 5 && fake_hd().open, "an open device is closed");
    must(!fake_hd().started, "the scheduler is stopped before the device is closed");
    fake_hd().open = false;
}

void hdEnable(HDenum capability) {
    const auto locked = lock();
    note(capability == HD_FORCE_OUTPUT         ? "enable output"
         : capability == HD_FORCE_RAMPING      ? "enable ramping"
         : capability == HD_MAX_FORCE_CLAMPING ? "enable clamping"
                                               : "enable something else");
    must(fake_hd().open, "enabled when open");
    fake_hd().enabled.push_back(capability);
    raise(fake_hd().enable_error);
}

void hdDisable(HDenum capability) {
    const auto locked = lock();
    note("disable output");
    must(capability == HD_FORCE_OUTPUT, "only the output is disabled");
    std::fill(fake_hd().force.begin(), fake_hd().force.end(), 0.0);
}

void hdGetDoublev(HDenum name, HDdouble* values) {
    const auto locked = lock();
    FakeHd& hd = fake_hd();
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
    case HD_NOMINAL_MAX_STIFFNESS:
        note("stiffness");
        *values = hd.stiffness;
        break;
    case HD_NOMINAL_MAX_FORCE:
        note("max force");
        *values = hd.max_force;
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
    FakeHd& hd = fake_hd();
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

void hdSetDoublev(HDenum name, const HDdouble* values) {
    const auto locked = lock();
    note("force");
    must(name == HD_CURRENT_FORCE && fake_hd().in_frame, "the force is set within a frame");
    fake_hd().force.assign(values, values + 3);
}

void hdBeginFrame(HHD device) {
    const auto locked = lock();
    note("begin");
    must(device == 5 && !fake_hd().in_frame && fake_hd().ticking, "a frame begins in a tick");
    fake_hd().in_frame = true;
}

void hdEndFrame(HHD device) {
    const auto locked = lock();
    note("end");
    must(device == 5 && fake_hd().in_frame, "a frame ends that has begun");
    fake_hd().in_frame = false;
}

HDenum hdCheckCalibration() {
    const auto locked = lock();
    note("check calibration");
    must(fake_hd().ticking, "calibration is checked in the servo loop");
    return fake_hd().calibration;
}

void hdUpdateCalibration(HDenum style) {
    const auto locked = lock();
    note("update calibration");
    FakeHd& hd = fake_hd();
    must(hd.ticking && !hd.in_frame, "calibration is updated in the servo loop, outside of a frame");
    must(style == HD_CALIBRATION_AUTO || style == HD_CALIBRATION_INKWELL, "never by resetting the encoders");
    must((hd.styles & static_cast<int>(style)) != 0, "in a style that the device has");
    ++hd.calibrations;
}

HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback callback, void* user, HDushort priority) {
    const auto locked = lock();
    note("schedule");
    FakeHd& hd = fake_hd();
    must(!hd.started, "scheduled before the scheduler starts");
    hd.callback = callback;
    hd.user = user;
    hd.priority = priority;
    raise(hd.schedule_error);
    return 0x1'0000'0001ul; // does not fit into an int
}

void hdUnschedule(HDSchedulerHandle handle) {
    const auto locked = lock();
    note("unschedule");
    must(handle == 0x1'0000'0001ul, "what was scheduled is unscheduled");
    must(!fake_hd().started, "stopped before it is unscheduled");
    fake_hd().callback = nullptr;
}

void hdStartScheduler() {
    const auto locked = lock();
    note("start");
    raise(fake_hd().start_error);
    fake_hd().started = fake_hd().start_error == 0;
    if (fake_hd().started) start_hand();
}

void hdStopScheduler() {
    stop_hand(); // waits for a tick that may call the driver
    const auto locked = lock();
    note("stop");
    fake_hd().started = false;
}
