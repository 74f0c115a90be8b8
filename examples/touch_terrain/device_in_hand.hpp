#ifndef TOUCH_TERRAIN_DEVICE_IN_HAND_HPP
#define TOUCH_TERRAIN_DEVICE_IN_HAND_HPP

#include "ground.hpp"
#include "stylus_path.hpp"

#include <hfh/device/workspace.hpp>
#include <hfh/loop/haptic_loop.hpp>
#include <hfh/simulation/simulated_device.hpp>

#include <vector>

namespace demo {

/// So that the path fills nine tenths of the device's workspace, with `room` metres left above and below. Throws BadInput
/// where no number does that.
[[nodiscard]] hfh::WorkspaceFrame fit(const hfh::DeviceModel& model, const Ground& ground,
                                      const std::vector<StylusSample>& path, double room);

/// How far below the surface a hand aims that presses with 1 N: metres in the hand, what the grip and the surface give
/// way.
[[nodiscard]] double aim_depth(double stiffness) noexcept;

/// A simulated device in a hand that wants to go along a path: where the stylus gets is up to the hand, the device and
/// the forces of an `hfh::HapticLoop` with `loop()` for options.
///
/// A hand that lost contact at a hole may come below the surface behind it, where it feels nothing. It moves up
/// there until it is out, as a person would, and lands again.
class DeviceInHand {
public:
    /// `stiffness`: of the terrain in the hand, N/m. `wanted`: at least one sample, in the terrain, between which the hand
    /// moves evenly. Throws BadInput where it takes more than a day.
    DeviceInHand(const hfh::DeviceModel& model, const hfh::WorkspaceFrame& frame, double stiffness,
                 std::vector<StylusSample> wanted);
    DeviceInHand(const DeviceInHand&) = delete;
    DeviceInHand& operator=(const DeviceInHand&) = delete;

    /// Workspace, stiffness and limits of the device, for a scene whose ground it is that the hand feels.
    [[nodiscard]] hfh::HapticLoopOptions loop() const noexcept;

    /// What the device tells, an update after the last call; nothing once the path is at its end.
    [[nodiscard]] std::optional<StylusStep> next();
    /// What the hand feels from the sample that `next` gave last until the next one, in newtons. `buried`: the contact's
    /// status; lifts the hand.
    void feel(const glm::dvec3& newtons, bool buried) noexcept;

    [[nodiscard]] const hfh::Workspace<double>& workspace() const noexcept { return workspace_; }
    [[nodiscard]] const hfh::GuardLimits& limits() const noexcept { return limits_; }
    [[nodiscard]] double progress() const noexcept;

private:
    /// Where the hand wants to be, in the hand's metres.
    struct Wanted {
        const std::vector<StylusSample>* path;
        const hfh::Workspace<double>* workspace;
        const double* lift;
        [[nodiscard]] glm::dvec3 operator()(double t) const noexcept;
    };

    std::vector<StylusSample> path_;
    hfh::Workspace<double> workspace_;
    double lift_ = 0; ///< how far above its path the hand wants to be, in its metres
    hfh::SimulatedDevice<Wanted> device_;
    double stiffness_; ///< N/m in the hand
    hfh::GuardLimits limits_;
    glm::dvec3 newtons_{0.0}; ///< at the hand
    bool started_ = false;
};

} // namespace demo

#endif // TOUCH_TERRAIN_DEVICE_IN_HAND_HPP
