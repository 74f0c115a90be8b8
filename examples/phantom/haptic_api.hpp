#ifndef PHANTOM_HAPTIC_API_HPP
#define PHANTOM_HAPTIC_API_HPP

#include <concepts>

// The driver's calls, as far as they are made here. openhaptics.hpp has the real ones; tests have a fake behind the
// same C functions.

namespace phantom {

/// What kind of error the driver reports, as far as it matters here, gravest last. Numbers are the HDAPI's.
enum class ErrorKind : unsigned char {
    none,
    force, ///< 0x201 to 0x204: too much force, impulse or velocity: the force goes to zero, the run goes on
    warm,  ///< 0x200: the motors are warm: no force until they have cooled, the run goes on
    device_fault, ///< 0x300: the device has switched itself off; the driver brings it back: no force, the run goes on
    scheduling, ///< a callback could not be scheduled: that of a device that begins, whichever the error names
    other,      ///< frames, timer, handles: the run is over
    communication ///< the cable, the network: the run is over
};

struct ApiError {
    ErrorKind kind = ErrorKind::none;
    unsigned code = 0;
    long long device = -1; ///< the handle of the device that it is about; below 0: of none in particular
};

enum class Calibration : unsigned char { ok, needs_update, needs_user };

/// What a scheduler calls once per update, until it returns false.
struct Callback {
    bool (*call)(void* user) noexcept;
    void* user;
};

/// The driver's calls, in its own units and axes: mm, N, N/mm; x right, y up, z towards the user. Those without a
/// handle are for the current device.
// clang-format off
template <class A>
concept HapticApi = requires(A& api, const A& constant, const char* name, typename A::Handle handle,
                             typename A::Schedule schedule, Callback& callback, double (&three)[3], double (&six)[6]) {
        { api.error() } -> std::same_as<ApiError>; // takes one off the driver's stack, the most recent first
        { api.open(name) } -> std::same_as<typename A::Handle>; // and makes it the current one
        { constant.valid(handle) } -> std::same_as<bool>;
        { api.nominal_max_stiffness() } -> std::same_as<double>;
        { api.nominal_max_force() } -> std::same_as<double>;
        { api.update_rate() } -> std::same_as<double>;
        api.usable_workspace(six); // minimum, maximum
        api.enable_force_output();
        api.enable_force_ramping();
        api.enable_force_clamping();
        api.disable_force_output();
        { api.schedule(callback) } -> std::same_as<typename A::Schedule>; // every update, at the highest priority
        api.start();
        api.stop(); // returns when no callback is called any more
        api.unschedule(schedule);
        api.close(handle);
        // In the callback:
        api.begin_frame(handle);
        { api.calibration() } -> std::same_as<Calibration>;
        api.update_calibration();
        api.position(three);
        api.velocity(three);
        { api.buttons() } -> std::same_as<unsigned>;
        api.set_force(three);
        api.end_frame(handle);
    };

/// What a driver may tell besides. An Api without these calls drives one device at a time and tells nothing of it.
/// What a device does not know raises an error, once, and is not asked for again.
template <class A>
concept MonitoredApi = HapticApi<A> && requires(A& api, typename A::Handle handle) {
        api.make_current(handle);
        { api.nominal_max_continuous_force() } -> std::same_as<double>; // N, that does not warm the motors
        { api.force_impulse_limit() } -> std::same_as<double>;          // N/ms, above which the driver raises an error
        { api.resolution() } -> std::same_as<double>;                   // mm; 0: not known
        // In a frame:
        { api.motor_temperature() } -> std::same_as<double>; // of the warmest: 0 at room temperature, 1 overheated
        { api.inkwell_switch() } -> std::same_as<bool>;
        { api.safety_switch() } -> std::same_as<bool>;
    };
// clang-format on

} // namespace phantom

#endif // PHANTOM_HAPTIC_API_HPP
