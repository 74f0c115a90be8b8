#ifndef HFH_DEVICE_DEVICE_HPP
#define HFH_DEVICE_DEVICE_HPP

#include <hfh/geometry/scalar.hpp>

#include <compare>
#include <concepts>
#include <cstdint>
#include <type_traits>

// A force-feedback device of any vendor as the rest of a program sees it: it gives samples and takes forces, in SI units, in a
// right-handed frame with z up. A driver converts from and to its own axes and units.

namespace hfh {

/// The time of a device without a double, from an origin of the device's choice: 146 years to both sides.
struct Nanoseconds {
    std::int64_t count = 0;
    friend constexpr auto operator<=>(const Nanoseconds&, const Nanoseconds&) noexcept = default;
};

/// What times are told in: seconds where F is double. A float in seconds tells no millisecond apart after some hours, so in
/// single precision times are whole numbers, and only what lies between two of them is a float.
template <Real F>
using DeviceTime = std::conditional_t<std::same_as<F, double>, double, Nanoseconds>;

/// Where the device's end effector is, in the device's workspace. F is what a device and its guard compute in: double, or
/// float where the processor has no double.
template <Real F>
struct BasicDeviceSample {
    DeviceTime<F> time{};      ///< never decreasing, from an origin of the device's choice
    vec3<F> position{F(0)};    ///< metres
    vec3<F> velocity{F(0)};    ///< metres per second, if `has_velocity`
    bool has_velocity = false; ///< the device measures it
    unsigned buttons = 0;      ///< bit k: button k is down
    /// The device refused the last force: give no force in this update, and forget the contact.
    bool force_refused = false;
    /// The device is about to take no force, as for a calibration: bring the force to zero, and back up when this is false
    /// again. The driver calls the tick until the command is zero.
    bool release = false;
    bool has_sent = false;   ///< the driver tells what it last gave to the motors:
    vec3<F> sent{F(0)};      ///< newtons, after all that changed it on the way; zero if none was given
    DeviceTime<F> sent_at{}; ///< the time of that update, with or without a tick
};
using DeviceSample = BasicDeviceSample<double>;

/// What to do until the next sample.
template <Real F>
struct BasicDeviceCommand {
    vec3<F> newtons{F(0)}; ///< force on the hand
    bool go_on = true;     ///< false: no force, and no further sample
};
using DeviceCommand = BasicDeviceCommand<double>;

/// A delay that the device does not tell. Not the same as none: what is stable without a delay need not be with one.
inline constexpr int unknown_delay = -1;

/// What a device can do. Zero where it does not tell, but for the delay.
template <Real F>
struct BasicDeviceCapabilities {
    F max_force = 0;         ///< N
    F max_stiffness = 0;     ///< N/m, closed loop, as the maker recommends
    F rate = 0;              ///< updates per second
    F resolution = 0;        ///< metres, of one step of the position
    vec3<F> workspace{F(0)}; ///< metres, extent along x, y and z, centred on 0
    /// Updates from a sample to the first one that its force has acted on, less one; or `unknown_delay`.
    int delay = 0;
    /// N/ms: the steepest rise of the force that the device lets pass (HDAPI: HD_SOFTWARE_FORCE_IMPULSE_LIMIT).
    F max_slew = 0;
};
using DeviceCapabilities = BasicDeviceCapabilities<double>;

/// How a run of a device ended.
enum class DeviceEnd : unsigned char {
    stopped,       ///< the tick said so
    not_available, ///< no device, or it did not start
    force_fault,   ///< the device kept refusing forces: too large, an amplifier fault
    lost,          ///< the connection broke
    fault          ///< another error that ends the run
};

[[nodiscard]] constexpr const char* to_string(DeviceEnd end) noexcept {
    switch (end) {
    case DeviceEnd::stopped: return "stopped";
    case DeviceEnd::not_available: return "not_available";
    case DeviceEnd::force_fault: return "force_fault";
    case DeviceEnd::lost: return "lost";
    case DeviceEnd::fault: return "fault";
    }
    return "unknown";
}

/// `tick(sample) → command`, once per update.
template <class F>
concept DeviceTick = requires(F& tick, const DeviceSample& sample) {
    { tick(sample) } -> std::same_as<DeviceCommand>;
};

/// A device. `run(tick)` calls tick once per update, in order and from one thread at a time, until it says stop or the
/// device fails, and returns after the last call, with the force at zero. Whether the driver calls back, is polled, or
/// exchanges a force for a position is hidden in `run`.
// clang-format off
template <class D>
concept Device = requires(D& device, DeviceCommand (&tick)(const DeviceSample&)) {
    { device.capabilities() } noexcept -> std::same_as<DeviceCapabilities>;
    { device.run(tick) } -> std::same_as<DeviceEnd>;
};
// clang-format on

} // namespace hfh

#endif // HFH_DEVICE_DEVICE_HPP
