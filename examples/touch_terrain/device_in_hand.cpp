#include "device_in_hand.hpp"

#include "bad_input.hpp"
#include "numbers.hpp"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>

namespace demo {
namespace {

constexpr double longest = 86400; // s
constexpr double lifting = 0.1;   // m/s of the hand, out of the ground and back to the path

/// The device's limits, for one whose samples are never late, and for a terrain that may be stiffer than it can be.
hfh::GuardLimits limits_of(const hfh::DeviceCapabilities& device, double stiffness) noexcept {
    hfh::GuardLimits limits = hfh::guard_limits(device);
    limits.max_gap = 3 * limits.period;
    limits.stiffness = std::min(stiffness, 0x1p63); // a number to a guard
    return limits;
}

double seconds_in(const std::vector<StylusSample>& path) noexcept { return path.back().t - path.front().t; }

} // namespace

hfh::WorkspaceFrame fit(const hfh::DeviceModel& model, const Ground& ground,
                        const std::vector<StylusSample>& path, double room) {
    glm::dvec3 low = path.front().position, high = low;
    for (const StylusSample& sample : path) {
        low = glm::min(low, sample.position);
        high = glm::max(high, sample.position);
    }
    const glm::dvec3& workspace = model.capabilities.workspace;
    const glm::dvec3 size = high - low, space = 0.9 * (workspace - glm::dvec3{0, 0, 2 * room});
    double scale = 0;
    for (int axis = 0; axis < 3; ++axis) scale = std::max(scale, size[axis] / space[axis]);
    if (size == glm::dvec3{0.0}) scale = std::max(ground.size.x / space.x, ground.size.y / space.y);
    const hfh::WorkspaceFrame frame{.scale = scale, .offset = low + size / 2.0};
    if (!std::isnormal(scale) || check(frame) != hfh::WorkspaceStatus::ok ||
        !hfh::is_finite(workspace * scale)) {
        throw BadInput{"The path does not fit into the workspace of a device at any scale: it is " +
                       rounded(size.x) + " x " + rounded(size.y) + " x " + rounded(size.z) +
                       " m. Take --device none to follow it without one."};
    }
    return frame;
}

double aim_depth(double stiffness) noexcept { return 1 / hfh::HandGrip{}.stiffness + 1 / stiffness; }

DeviceInHand::DeviceInHand(const hfh::DeviceModel& model, const hfh::WorkspaceFrame& frame, double stiffness,
                           std::vector<StylusSample> wanted)
    : path_{std::move(wanted)}, workspace_{frame}, device_{model, {}, Wanted{&path_, &workspace_, &lift_}, 0},
      stiffness_{stiffness}, limits_{limits_of(model.capabilities, stiffness)} {
    if (!(seconds_in(path_) <= longest)) {
        throw BadInput{"The path takes " + rounded(seconds_in(path_)) +
                       " s, but with a device it may take a day at the most."};
    }
}

hfh::HapticLoopOptions DeviceInHand::loop() const noexcept {
    // The spring as it is, so that the record shows what the terrain gives back: without the damper of a coupling.
    return {.workspace = workspace_.frame(),
            .material = {.stiffness = stiffness_},
            .limits = limits_,
            .tracker = {},
            .lag = 0};
}

std::optional<StylusStep> DeviceInHand::next() {
    if (started_) device_.step(newtons_);
    started_ = true;
    const auto sample = device_.sample();
    // Half an update: times are multiples of the period but for rounding.
    if (sample.time > seconds_in(path_) + 0.5 * device_.period()) return std::nullopt;
    return StylusStep{path_.front().t + sample.time, sample};
}

void DeviceInHand::feel(const glm::dvec3& newtons, bool buried) noexcept {
    newtons_ = newtons;
    lift_ = std::max(0.0, lift_ + (buried ? lifting : -lifting) * device_.period());
}

double DeviceInHand::progress() const noexcept {
    const double seconds = seconds_in(path_);
    return seconds > 0 ? std::min(1.0, device_.time() / seconds) : 1.0;
}

glm::dvec3 DeviceInHand::Wanted::operator()(double t) const noexcept {
    const double at = path->front().t + t;
    const auto next = std::ranges::upper_bound(*path, at, {}, &StylusSample::t);
    glm::dvec3 position = path->back().position;
    if (next != path->end() && next != path->begin()) {
        const StylusSample& last = *std::prev(next);
        position = glm::mix(last.position, next->position, (at - last.t) / (next->t - last.t));
    } else if (next == path->begin()) {
        position = path->front().position;
    }
    return workspace->to_hand(position) + glm::dvec3{0, 0, *lift};
}

} // namespace demo
