#ifndef TOUCH_TERRAIN_DEVICE_IN_HAND_HPP
#define TOUCH_TERRAIN_DEVICE_IN_HAND_HPP

#include "ground.hpp"
#include "stylus_path.hpp"

#include <hfh/simulated_device.hpp>

#include <vector>

namespace demo {

/// From the terrain to the hand: hand = (terrain − centre)·scale. Forces are what they are.
struct Mapping {
    glm::dvec3 centre{0.0}; ///< metres, in the terrain
    double scale = 1;       ///< metres in the hand per metre of terrain
};

/// So that the path fills nine tenths of the device's workspace, with `room` metres left above and below. Throws BadInput
/// where no number does that.
[[nodiscard]] Mapping fit(const hfh::DeviceModel& model, const Ground& ground,
                          const std::vector<StylusSample>& path, double room);

/// How far below the surface a hand aims that presses with 1 N: metres in the hand, what the grip and the surface give
/// way.
[[nodiscard]] double aim_depth(double stiffness) noexcept;

/// A simulated device in a hand that wants to go along a path: where the stylus gets is up to the hand, the device and
/// the forces.
class DeviceInHand {
public:
    /// `wanted`: at least one sample, in the terrain, between which the hand moves evenly. Throws BadInput where it takes
    /// more than a day.
    DeviceInHand(const hfh::DeviceModel& model, const Mapping& mapping, std::vector<StylusSample> wanted);
    DeviceInHand(const DeviceInHand&) = delete;
    DeviceInHand& operator=(const DeviceInHand&) = delete;

    /// Where the stylus is, in the terrain, an update after the last call; nothing once the path is at its end.
    [[nodiscard]] std::optional<StylusSample> next();
    /// The force for the sample that `next` gave last, in newtons; held until the next.
    void feel(const glm::dvec3& newtons) noexcept { newtons_ = newtons; }

    [[nodiscard]] double progress() const noexcept;

private:
    /// Where the hand wants to be, in the hand's metres.
    struct Wanted {
        const std::vector<StylusSample>* path;
        Mapping mapping;
        [[nodiscard]] glm::dvec3 operator()(double t) const noexcept;
    };

    std::vector<StylusSample> path_;
    Mapping mapping_;
    hfh::SimulatedDevice<Wanted> device_;
    glm::dvec3 newtons_{0.0};
    bool started_ = false;
};

} // namespace demo

#endif // TOUCH_TERRAIN_DEVICE_IN_HAND_HPP
