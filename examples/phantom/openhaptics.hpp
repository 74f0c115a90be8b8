#ifndef PHANTOM_OPENHAPTICS_HPP
#define PHANTOM_OPENHAPTICS_HPP

#include "phantom_device.hpp"

#include <HD/hd.h> // the user's own SDK

namespace phantom {

/// The calls of the HDAPI, one each. Names and meanings as in the maker's public API reference.
struct OpenHaptics {
    using Handle = HHD;
    using Schedule = HDSchedulerHandle;

    static ApiError error() {
        const HDErrorInfo info = hdGetError();
        return {kind_of(info.errorCode), static_cast<unsigned>(info.errorCode)};
    }
    static ErrorKind kind_of(HDerror code) noexcept {
        switch (code) {
        case HD_SUCCESS: return ErrorKind::none;
        case HD_WARM_MOTORS:
        case HD_EXCEEDED_MAX_FORCE:
        case HD_EXCEEDED_MAX_FORCE_IMPULSE:
        case HD_EXCEEDED_MAX_VELOCITY:
        case HD_FORCE_ERROR: return ErrorKind::force;
        case HD_COMM_ERROR:
        case HD_COMM_CONFIG_ERROR: return ErrorKind::communication;
        default: return ErrorKind::other;
        }
    }

    static Handle open(const char* name) { return hdInitDevice(name != nullptr ? name : HD_DEFAULT_DEVICE); }
    static bool valid(Handle handle) noexcept { return handle != HD_INVALID_HANDLE; }
    static void close(Handle handle) { hdDisableDevice(handle); }

    static double nominal_max_stiffness() { return number(HD_NOMINAL_MAX_STIFFNESS); }
    static double nominal_max_force() { return number(HD_NOMINAL_MAX_FORCE); }
    static double update_rate() { return static_cast<double>(integer(HD_UPDATE_RATE)); }
    static void usable_workspace(double (&box)[6]) { hdGetDoublev(HD_USABLE_WORKSPACE_DIMENSIONS, box); }

    static void enable_force_output() { hdEnable(HD_FORCE_OUTPUT); }
    static void enable_force_ramping() { hdEnable(HD_FORCE_RAMPING); }
    static void enable_force_clamping() { hdEnable(HD_MAX_FORCE_CLAMPING); }
    static void disable_force_output() { hdDisable(HD_FORCE_OUTPUT); }

    static Schedule schedule(Callback& callback) {
        return hdScheduleAsynchronous(&call, &callback, HD_MAX_SCHEDULER_PRIORITY);
    }
    static void start() { hdStartScheduler(); }
    static void stop() { hdStopScheduler(); }
    static void unschedule(Schedule schedule) { hdUnschedule(schedule); }

    static void begin_frame(Handle handle) { hdBeginFrame(handle); }
    static void end_frame(Handle handle) { hdEndFrame(handle); }
    static void position(double (&mm)[3]) { hdGetDoublev(HD_CURRENT_POSITION, mm); }
    static void velocity(double (&mm_per_second)[3]) { hdGetDoublev(HD_CURRENT_VELOCITY, mm_per_second); }
    static unsigned buttons() { return static_cast<unsigned>(integer(HD_CURRENT_BUTTONS)); }
    static void set_force(const double (&newtons)[3]) { hdSetDoublev(HD_CURRENT_FORCE, newtons); }

    static Calibration calibration() {
        switch (hdCheckCalibration()) {
        case HD_CALIBRATION_OK: return Calibration::ok;
        case HD_CALIBRATION_NEEDS_UPDATE:
            return own_style() != 0 ? Calibration::needs_update : Calibration::needs_user;
        default: return Calibration::needs_user;
        }
    }
    static void update_calibration() { hdUpdateCalibration(own_style()); }

private:
    /// A style that needs no hand in a certain pose. Resetting the encoders wherever the arm happens to be would make
    /// every position wrong; that is left to the maker's tool.
    static HDenum own_style() {
        const HDint styles = integer(HD_CALIBRATION_STYLE);
        if ((styles & HD_CALIBRATION_AUTO) != 0) return HD_CALIBRATION_AUTO;
        if ((styles & HD_CALIBRATION_INKWELL) != 0) return HD_CALIBRATION_INKWELL;
        return 0;
    }
    static HDCallbackCode HDCALLBACK call(void* user) {
        const auto& callback = *static_cast<Callback*>(user);
        return callback.call(callback.user) ? HD_CALLBACK_CONTINUE : HD_CALLBACK_DONE;
    }
    static double number(HDenum name) {
        HDdouble value = 0;
        hdGetDoublev(name, &value);
        return value;
    }
    static HDint integer(HDenum name) {
        HDint value = 0;
        hdGetIntegerv(name, &value);
        return value;
    }
};

} // namespace phantom

#endif // PHANTOM_OPENHAPTICS_HPP
