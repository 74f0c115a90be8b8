#ifndef VIEWER_REAL_DEVICE_HPP
#define VIEWER_REAL_DEVICE_HPP

#include <hfh/device/device.hpp>

#include <functional>
#include <memory>
#include <string>

namespace viewer {

/// A device in somebody's hand, whose driver calls back.
class RealDevice {
public:
    using Tick = std::function<hfh::DeviceCommand(const hfh::DeviceSample&)>;

    virtual ~RealDevice() = default;

    [[nodiscard]] virtual hfh::DeviceCapabilities capabilities() const = 0;
    /// From now on `tick`, which must not throw, is called in the driver's thread. A connection that broke is made again.
    virtual void start(Tick tick) = 0;
    /// Ends with a force of zero. From then on `tick` is not called any more.
    virtual void stop() = 0;
    /// Why there is no force under the hand now; empty where there is no such reason.
    [[nodiscard]] virtual std::string trouble() = 0;
    /// How the updates went: a line to print at the end, after `stop`.
    [[nodiscard]] virtual std::string report() const = 0;
};

/// The user's own Phantom or Touch. Throws BadInput where this program was built without the SDK, or no device opens.
[[nodiscard]] std::unique_ptr<RealDevice> open_phantom();

} // namespace viewer

#endif // VIEWER_REAL_DEVICE_HPP
