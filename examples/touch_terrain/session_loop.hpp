#ifndef TOUCH_TERRAIN_SESSION_LOOP_HPP
#define TOUCH_TERRAIN_SESSION_LOOP_HPP

#include "bad_input.hpp"
#include "numbers.hpp"
#include "session.hpp"

#include <hfh/hfh.hpp>
#include <hfh/terrain/bridged_field.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <chrono>
#include <string>

// The part of the demo that is about the library: positions in, forces and touches out.

namespace demo {

/// The trip or else the limit that acted on a force, in a word: where it is none, the force is as it was asked for.
[[nodiscard]] inline const char* what_acted(const hfh::GuardedForce& force) noexcept {
    if (force.trip != hfh::GuardTrip::none) return to_string(force.trip);
    return force.slewed      ? "slewed"
           : force.ramped    ? "ramped"
           : force.held_back ? "held_back"
           : force.clamped   ? "clamped"
                             : "none";
}

/// The session on one type of field.
template <hfh::HeightField Field>
Summary follow_on(const Field& field, const Feeling& feeling, const StepSource& path, const ForceSink& feel,
                  const std::function<void(const Touch&)>& on_touch) {
    using Clock = std::chrono::steady_clock;
    hfh::HapticLoop loop{field, feeling.loop};

    Summary summary;
    summary.state_bytes = sizeof(loop.tracker().state());
    while (const auto step = path()) {
        const auto start = Clock::now();
        const hfh::DeviceCommand command = loop.update(step->sample);
        const auto stop = Clock::now();

        const auto& contact = loop.contact();
        const bool buried = contact.status == hfh::ContactStatus::buried;
        const hfh::GuardedForce felt = feeling.guarded ? loop.force() : hfh::GuardedForce{loop.asked()};
        feel(command.newtons, buried);
        const Touch touch{.t = step->t,
                          .stylus = loop.stylus(),
                          .contact = contact.touching(),
                          .proxy = contact.proxy,
                          .normal = contact.normal,
                          .force = felt.newtons,
                          .patches = contact.patches,
                          .status = to_string(contact.status),
                          .guard = what_acted(felt)};
        ++summary.updates;
        summary.in_contact += touch.contact;
        summary.buried += buried;
        summary.refused += contact.status == hfh::ContactStatus::bad_input;
        summary.largest_force = std::max(summary.largest_force, glm::length(touch.force));
        summary.patches.add(static_cast<std::uint64_t>(std::max(0, touch.patches)));
        summary.nanoseconds.add(static_cast<std::uint64_t>((stop - start) / std::chrono::nanoseconds{1}));
        on_touch(touch);
    }
    summary.guard = loop.guard().counts();
    return summary;
}

/// The session for one type of sample.
template <hfh::Real T, class HeightSource>
Summary follow(const HeightSource& heights, const hfh::GridFrame& frame, const Feeling& feeling,
               const StepSource& path, const ForceSink& feel,
               const std::function<void(const Touch&)>& on_touch) {
    const hfh::BilinearGrid<T, HeightSource> grid{heights, frame};
    if (grid.status() != hfh::GridStatus::ok) {
        throw BadInput{"The terrain makes no surface in " + std::string{sizeof(T) == 4 ? "float" : "double"} +
                       ": its spacing of " + rounded(frame.spacing.x) + " x " + rounded(frame.spacing.y) +
                       " m or its height scale of " + rounded(frame.height_scale) + " is out of range."};
    }
    if (feeling.bridge == 0) return follow_on(grid, feeling, path, feel, on_touch);
    return follow_on(hfh::BridgedField{grid, feeling.bridge}, feeling, path, feel, on_touch);
}

} // namespace demo

#endif // TOUCH_TERRAIN_SESSION_LOOP_HPP
