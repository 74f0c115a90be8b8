#ifndef HFH_DEVICE_DEVICE_HPP
#define HFH_DEVICE_DEVICE_HPP

#include <hfh/geometry/scalar.hpp>

#include <concepts>

// A force-feedback device of any vendor as the rest of a program sees it: it gives samples and takes forces, in SI units, in a
// right-handed frame with z up. A driver converts from and to its own axes and units.

namespace hfh {

/// Where the device's end effector is, in the device's workspace.
struct DeviceSample {
    double time = 0;           ///< seconds, never decreasing, from an origin of the device's choice
    glm::dvec3 position{0.0};  ///< metres
    glm::dvec3 velocity{0.0};  ///< metres per second, if `has_velocity`
    bool has_velocity = false; ///< the device measures it
    unsigned buttons = 0;      ///< bit k: button k is down
    /// The device refused the last force: give no force in this update, and forget the contact.
    bool force_refused = false;
    /// The device is about to take no force, as for a calibration: bring the force to zero, and back up when this is false
    /// again. The driver calls the tick until the command is zero.
    bool release = false;
    bool has_sent = false; ///< the driver tells what it last gave to the motors:
    glm::dvec3 sent{0.0};  ///< newtons, after all that changed it on the way; zero if none was given
    double sent_at = 0;    ///< seconds: the time of that update, with or without a tick
};

/// What to do until the next sample.
struct DeviceCommand {
    glm::dvec3 newtons{0.0}; ///< force on the hand
    bool go_on = true;       ///< false: no force, and no further sample
};

/// A delay that the device does not tell. Not the same as none: what is stable without a delay need not be with one.
inline constexpr int unknown_delay = -1;

/// What a device can do. Zero where it does not tell, but for the delay.
struct DeviceCapabilities {
    double max_force = 0;      ///< N
    double max_stiffness = 0;  ///< N/m, closed loop, as the maker recommends
    double rate = 0;           ///< updates per second
    double resolution = 0;     ///< metres, of one step of the position
    glm::dvec3 workspace{0.0}; ///< metres, extent along x, y and z, centred on 0
    /// Updates from a sample to the first one that its force has acted on, less one; or `unknown_delay`.
    int delay = 0;
    /// N/ms: the steepest rise of the force that the device lets pass (HDAPI: HD_SOFTWARE_FORCE_IMPULSE_LIMIT).
    double max_slew = 0;
};

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
