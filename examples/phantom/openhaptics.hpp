#ifndef PHANTOM_OPENHAPTICS_HPP
#define PHANTOM_OPENHAPTICS_HPP

#include "haptic_api.hpp"

#include <HD/hd.h> // the user's own SDK

#include <algorithm>
#include <iterator>
#include <string_view>

namespace phantom {

/// The calls of the HDAPI, one each. Names and meanings as in the maker's public API reference.
struct OpenHaptics {
    using Handle = HHD;
    using Schedule = HDSchedulerHandle;

    static ApiError error() {
        const HDErrorInfo info = hdGetError();
        return {kind_of(info.errorCode), static_cast<unsigned>(info.errorCode),
                info.hHD == HD_INVALID_HANDLE ? -1 : static_cast<long long>(info.hHD)};
    }
    static ErrorKind kind_of(HDerror code) noexcept {
        switch (code) {
        case HD_SUCCESS: return ErrorKind::none;
        case HD_WARM_MOTORS: return ErrorKind::warm;
        case HD_EXCEEDED_MAX_FORCE:
        case HD_EXCEEDED_MAX_FORCE_IMPULSE:
        case HD_EXCEEDED_MAX_VELOCITY:
        case HD_FORCE_ERROR: return ErrorKind::force;
        case HD_DEVICE_FAULT: return ErrorKind::device_fault;
        case HD_INVALID_PRIORITY:
        case HD_SCHEDULER_FULL: return ErrorKind::scheduling;
        case HD_COMM_ERROR:
        case HD_COMM_CONFIG_ERROR: return ErrorKind::communication;
        default: return ErrorKind::other;
        }
    }

    static Handle open(const char* name) { return hdInitDevice(name != nullptr ? name : HD_DEFAULT_DEVICE); }
    static bool valid(Handle handle) noexcept { return handle != HD_INVALID_HANDLE; }
    static void close(Handle handle) { hdDisableDevice(handle); }
    static void make_current(Handle handle) { hdMakeCurrentDevice(handle); }

    static double nominal_max_stiffness() { return number(HD_NOMINAL_MAX_STIFFNESS); }
    static double nominal_max_force() { return number(HD_NOMINAL_MAX_FORCE); }
    static double nominal_max_continuous_force() { return number(HD_NOMINAL_MAX_CONTINUOUS_FORCE); }
    static double force_impulse_limit() { return number(HD_SOFTWARE_FORCE_IMPULSE_LIMIT); }
    static double resolution() {
        const HDstring model = hdGetString(HD_DEVICE_MODEL_TYPE);
        return model != nullptr ? resolution_of(model) : 0;
    }
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
    static double motor_temperature() {
        HDdouble temperatures[6]{}; // one a motor, of which there are at most six
        hdGetDoublev(HD_MOTOR_TEMPERATURE, temperatures);
        return *std::max_element(std::begin(temperatures), std::end(temperatures));
    }
    static bool inkwell_switch() { return flag(HD_CURRENT_INKWELL_SWITCH); }
    static bool safety_switch() { return flag(HD_CURRENT_SAFETY_SWITCH); }
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

    /// mm, the maker's nominal position resolution by the model's name; 0 for a model that is not listed. HDAPI has no
    /// call for it. The figures are those of the makers' data sheets, quoted from memory; in dots per inch: Touch and Omni 450,
    /// Touch X and Desktop 1100, Premium 1.5 and 3.0 860 and 1000.
    static double resolution_of(std::string_view model) noexcept {
        struct Known {
            std::string_view part;
            double mm;
        };
        static constexpr Known models[]{// the longer name first
                                        {"Touch X", 0.023},   {"Desktop", 0.023},    {"Touch", 0.055},
                                        {"Omni", 0.055},      {"High Force", 0.007}, {"Premium 1.5", 0.03},
                                        {"Premium 3.0", 0.02}};
        for (const Known& known : models)
            if (model.find(known.part) != std::string_view::npos) return known.mm;
        return 0;
    }

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
    static bool flag(HDenum name) {
        HDboolean value = 0;
        hdGetBooleanv(name, &value);
        return value != 0;
    }
    static HDint integer(HDenum name) {
        HDint value = 0;
        hdGetIntegerv(name, &value);
        return value;
    }
};

} // namespace phantom

#endif // PHANTOM_OPENHAPTICS_HPP
