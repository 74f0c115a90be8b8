#ifndef PHANTOM_SCENE_HPP
#define PHANTOM_SCENE_HPP

#include <hfh/hfh.hpp>

#include <hfh/device.hpp>
#include <hfh/force_guard.hpp>
#include <hfh/latest_value.hpp>
#include <hfh/workspace.hpp>

#include <algorithm>

namespace phantom {

/// What a display shows.
struct Shown {
    double time = 0;
    glm::dvec3 stylus{0.0}; ///< metres, on the terrain
    glm::dvec3 force{0.0};  ///< N, at the hand
    hfh::ContactStatus contact = hfh::ContactStatus::free;
    hfh::GuardTrip trip = hfh::GuardTrip::none;
};

/// A terrain in the hand: what happens in one update, from sample to force. Button 0 is the clutch. Where a ridge lets go
/// of the proxy far from the stylus it glides, so that no update takes long.
template <hfh::HeightField Field>
class Scene {
public:
    using Scalar = typename Field::Scalar;

    /// `stiffness`: N/m at the hand.
    Scene(const Field& field, const hfh::WorkspaceFrame& frame, double stiffness,
          const hfh::GuardLimits& limits)
        : workspace_{frame}, tracker_{field, {.max_slide = 8}}, guard_{limits},
          force_{.stiffness = workspace_.terrain_stiffness(stiffness)} {}

    hfh::DeviceCommand operator()(const hfh::DeviceSample& sample) noexcept {
        if (sample.force_refused) tracker_.reset();
        const bool clutch = (sample.buttons & 1u) != 0;
        const auto contact = tracker_.update(workspace_.update(sample.position, clutch));
        const auto asked = clutch ? glm::dvec3{0.0} : workspace_.force_at_hand(force_(contact).newtons);
        const auto sent = guard_.update(sample, asked, contact.status == hfh::ContactStatus::buried);
        if (clutch) guard_.restart(); // no force meanwhile, and the ramp afterwards
        const hfh::DeviceCommand command{clutch ? glm::dvec3{0.0} : sent.newtons};
        shown_.put({sample.time, workspace_.to_terrain(sample.position), command.newtons, contact.status,
                    sent.trip});
        return command;
    }

    /// From one other thread.
    [[nodiscard]] bool show(Shown& shown) noexcept { return shown_.take(shown); }
    /// After the run.
    [[nodiscard]] const hfh::GuardCounts& counts() const noexcept { return guard_.counts(); }

private:
    hfh::Workspace<Scalar> workspace_;
    hfh::ProxyTracker<Field> tracker_;
    hfh::ForceGuard guard_;
    hfh::ForceEvaluator<Scalar> force_;
    hfh::LatestValue<Shown> shown_{};
};

/// Limits and stiffness that a device can do; what it does not tell is taken from the smallest, the Touch. No more N/ms
/// than the stiffest wall takes when a hand meets it at 2 m/s, which is a fast reach.
[[nodiscard]] inline hfh::GuardLimits limits_for(const hfh::DeviceCapabilities& device) noexcept {
    return {.max_force = device.max_force > 0 ? device.max_force : 3.3,
            .max_slew = device.max_stiffness > 0 ? 0.002 * device.max_stiffness : 1.0};
}
[[nodiscard]] inline double stiffness_for(const hfh::DeviceCapabilities& device) noexcept {
    return device.max_stiffness > 0 ? 0.8 * device.max_stiffness : 400;
}

/// The breadth of the workspace becomes that of the terrain.
[[nodiscard]] inline hfh::WorkspaceFrame frame_for(const hfh::DeviceCapabilities& device, double breadth,
                                                   const glm::dvec3& middle) noexcept {
    const double span = std::max(device.workspace.x, device.workspace.y);
    return {.scale = breadth / (span > 0 ? span : 0.16), .offset = middle};
}

} // namespace phantom

#endif // PHANTOM_SCENE_HPP
