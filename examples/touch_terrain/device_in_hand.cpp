#include "device_in_hand.hpp"

#include "bad_input.hpp"
#include "numbers.hpp"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace demo {
namespace {

constexpr double longest = 86400; // s

double seconds_in(const std::vector<StylusSample>& path) noexcept { return path.back().t - path.front().t; }

} // namespace

Mapping fit(const hfh::DeviceModel& model, const Ground& ground, const std::vector<StylusSample>& path,
            double room) {
    glm::dvec3 low = path.front().position, high = low;
    for (const StylusSample& sample : path) {
        low = glm::min(low, sample.position);
        high = glm::max(high, sample.position);
    }
    const glm::dvec3& workspace = model.capabilities.workspace;
    const glm::dvec3 size = high - low, space = 0.9 * (workspace - glm::dvec3{0, 0, 2 * room});
    double scale = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        if (size[axis] > 0) scale = std::min(scale, space[axis] / size[axis]);
    }
    if (size == glm::dvec3{0.0}) scale = std::min(space.x / ground.size.x, space.y / ground.size.y);
    const Mapping mapping{low + size / 2.0, scale};
    if (!std::isnormal(scale) || scale < 0 || !hfh::is_finite(mapping.centre) ||
        !hfh::is_finite(workspace / scale)) {
        throw BadInput{"The path does not fit into the workspace of a device at any scale: it is " +
                       rounded(size.x) + " x " + rounded(size.y) + " x " + rounded(size.z) +
                       " m. Take --device none to follow it without one."};
    }
    return mapping;
}

double aim_depth(double stiffness) noexcept { return 1 / hfh::HandGrip{}.stiffness + 1 / stiffness; }

DeviceInHand::DeviceInHand(const hfh::DeviceModel& model, const Mapping& mapping,
                           std::vector<StylusSample> wanted)
    : path_{std::move(wanted)}, mapping_{mapping}, device_{model, {}, Wanted{&path_, mapping}, 0} {
    if (!(seconds_in(path_) <= longest)) {
        throw BadInput{"The path takes " + rounded(seconds_in(path_)) +
                       " s, but with a device it may take a day at the most."};
    }
}

std::optional<StylusSample> DeviceInHand::next() {
    if (started_) device_.step(newtons_);
    started_ = true;
    const auto sample = device_.sample();
    // Half an update: times are multiples of the period but for rounding.
    if (sample.time > seconds_in(path_) + 0.5 * device_.period()) return std::nullopt;
    return StylusSample{path_.front().t + sample.time, sample.position / mapping_.scale + mapping_.centre};
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
    return (position - mapping.centre) * mapping.scale;
}

} // namespace demo
