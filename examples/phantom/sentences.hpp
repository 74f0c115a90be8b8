#ifndef PHANTOM_SENTENCES_HPP
#define PHANTOM_SENTENCES_HPP

#include "phantom_device.hpp"

// What programs tell a person about a device.

namespace phantom {

[[nodiscard]] constexpr const char* sentence(hfh::DeviceEnd end) noexcept {
    switch (end) {
    case hfh::DeviceEnd::stopped: return "stopped";
    case hfh::DeviceEnd::not_available: return "no device, or it did not start";
    case hfh::DeviceEnd::force_fault: return "the device refused to render forces";
    case hfh::DeviceEnd::lost: return "the connection broke";
    case hfh::DeviceEnd::fault: return "the device failed";
    }
    return "unknown";
}

/// Why there is no force whatever is touched; empty where there is none to withhold.
[[nodiscard]] inline const char* sentence(const Report& report) noexcept {
    switch (report.withheld) {
    case Withheld::none: return "";
    case Withheld::force_error: return "too much force or speed: no force for now";
    case Withheld::warm_motors: return "the motors are warm: no force until they have cooled";
    case Withheld::device_fault: return "a device fault: no force until the driver has recovered";
    case Withheld::calibration:
        return report.calibration == Calibration::needs_user
                   ? "wants to be calibrated: put the stylus into its inkwell, or use the maker's tool"
                   : "wants to be calibrated: no force until it is";
    }
    return "";
}

} // namespace phantom

#endif // PHANTOM_SENTENCES_HPP
