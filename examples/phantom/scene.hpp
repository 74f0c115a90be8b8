#ifndef PHANTOM_SCENE_HPP
#define PHANTOM_SCENE_HPP

#include <hfh/hfh.hpp>

#include <hfh/device/triple_buffer.hpp>
#include <hfh/loop/haptic_loop.hpp>

#include <algorithm>
#include <cmath>

namespace phantom {

/// Where the hand is, as far as a person should know: where nothing is felt, or something that is not the terrain.
enum class Place : unsigned char {
    on_map,
    below_ground, ///< under the surface without having met it from above: no force until it has been outside once
    beyond_map, ///< outside the rim of the map: no force, or what the field does there
    over_hole,  ///< the map has no ground here: no force
    device_edge ///< at the end of the device's reach, where its own stops are felt
};

/// What to tell the person; empty where there is nothing to tell.
[[nodiscard]] constexpr const char* hint(Place place) noexcept {
    switch (place) {
    case Place::on_map: return "";
    case Place::below_ground: return "below the ground: lift the stylus out of it to feel it again";
    case Place::beyond_map: return "beyond the edge of the map";
    case Place::over_hole: return "a hole in the map";
    case Place::device_edge: return "the end of the device's reach: hold button 1 and move back";
    }
    return "";
}

/// What a display shows.
struct Shown {
    double time = 0;
    glm::dvec3 stylus{0.0}; ///< metres, on the terrain
    glm::dvec3 force{0.0};  ///< N, at the hand
    hfh::ContactStatus contact = hfh::ContactStatus::free;
    hfh::GuardTrip trip = hfh::GuardTrip::none;
    Place place = Place::on_map;
};

/// What a scene has to know to tell a person where the hand is.
struct Bounds {
    glm::dvec3 workspace{0.0}; ///< m, the device's, as in its capabilities; 0: not told
    hfh::CellRange map{};      ///< where the terrain is known, if the field goes on beyond it; else empty
    double margin = 0.005;     ///< m from the edge of the device's workspace that count as there
};

/// N/m at the hand that a device can render: below what the maker recommends; where the driver does not tell, what the
/// smallest, the Touch, can do.
[[nodiscard]] inline double stiffness_for(const hfh::DeviceCapabilities& device) noexcept {
    return device.max_stiffness > 0 ? 0.8 * device.max_stiffness : 400;
}
/// Limits that fit a device and that stiffness, behind the loop's coupling.
[[nodiscard]] inline hfh::GuardLimits limits_for(const hfh::DeviceCapabilities& device) noexcept {
    return hfh::guard_limits(device, stiffness_for(device));
}

/// A terrain in the hand: the loop, and what a display shows of it. Button 0 is the clutch.
template <hfh::HeightField Field>
class Scene {
public:
    /// `stiffness`: N/m at the hand.
    Scene(const Field& field, const hfh::WorkspaceFrame& frame, double stiffness,
          const hfh::GuardLimits& limits, const Bounds& bounds = {})
        : loop_{field,
                {.workspace = frame,
                 .material = {.stiffness = stiffness},
                 .limits = limits,
                 .clutch_buttons = 1u}},
          lattice_{field.lattice()}, bounds_{bounds} {
        if (bounds_.map.empty()) bounds_.map = field.cells();
    }

    hfh::DeviceCommand operator()(const hfh::DeviceSample& sample) noexcept {
        const hfh::DeviceCommand command = loop_.update(sample);
        const glm::dvec3 stylus = loop_.workspace().to_terrain(sample.position);
        const hfh::ContactStatus contact = loop_.contact().status;
        shown_.put({sample.time, stylus, command.newtons, contact, loop_.force().trip,
                    place_of(sample.position, stylus, contact)});
        return command;
    }

    /// From one other thread.
    [[nodiscard]] bool show(Shown& shown) noexcept { return shown_.take(shown); }
    /// After the run.
    [[nodiscard]] const hfh::GuardCounts& counts() const noexcept { return loop_.guard().counts(); }

private:
    [[nodiscard]] Place place_of(const glm::dvec3& hand, const glm::dvec3& stylus,
                                 hfh::ContactStatus contact) const noexcept {
        using hfh::ContactStatus;
        const hfh::CellRange& map = bounds_.map;
        const double u = lattice_.u_of(stylus.x, map.begin.i), v = lattice_.v_of(stylus.y, map.begin.j);
        const bool is_on_map = u >= 0 && u <= static_cast<double>(map.end.i - map.begin.i) && v >= 0 &&
                               v <= static_cast<double>(map.end.j - map.begin.j);
        if (contact == ContactStatus::buried) return Place::below_ground;
        if (!is_on_map) return Place::beyond_map;
        if (contact == ContactStatus::off_surface || contact == ContactStatus::left_at_hole)
            return Place::over_hole;
        for (int k = 0; k < 3; ++k)
            if (bounds_.workspace[k] > 0 && std::abs(hand[k]) > bounds_.workspace[k] / 2 - bounds_.margin)
                return Place::device_edge;
        return Place::on_map;
    }

    hfh::HapticLoop<Field> loop_;
    hfh::Lattice lattice_;
    Bounds bounds_;
    hfh::TripleBuffer<Shown> shown_{};
};

/// The breadth of the workspace becomes that of the terrain.
[[nodiscard]] inline hfh::WorkspaceFrame frame_for(const hfh::DeviceCapabilities& device, double breadth,
                                                   const glm::dvec3& middle) noexcept {
    const double span = std::max(device.workspace.x, device.workspace.y);
    return {.scale = breadth / (span > 0 ? span : 0.16), .offset = middle};
}

} // namespace phantom

#endif // PHANTOM_SCENE_HPP
