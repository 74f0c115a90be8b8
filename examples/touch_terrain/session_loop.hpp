#ifndef TOUCH_TERRAIN_SESSION_LOOP_HPP
#define TOUCH_TERRAIN_SESSION_LOOP_HPP

#include "session.hpp"

#include <hfh/hfh.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <chrono>

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

/// The session for one type of sample.
template <hfh::Real T, class HeightSource>
Summary follow(const HeightSource& heights, const hfh::GridFrame& frame, double stiffness,
               const StylusSource& path, const ForceSink& feel,
               const std::function<void(const Touch&)>& on_touch) {
    using Clock = std::chrono::steady_clock;

    const hfh::BilinearGrid<T, HeightSource> grid{heights, frame};
    hfh::ProxyTracker tracker{grid};
    const hfh::ForceEvaluator<T> force{.stiffness = static_cast<T>(stiffness)};

    Summary summary;
    summary.state_bytes = sizeof(tracker.state());
    while (const auto sample = path()) {
        const hfh::vec3<T> stylus{sample->position};

        const auto start = Clock::now();
        const hfh::Contact<T> contact = tracker.update(stylus);
        const hfh::Force<T> asked = force(contact);
        const auto stop = Clock::now();

        const bool buried = contact.status == hfh::ContactStatus::buried;
        const hfh::GuardedForce felt = feel(asked.newtons, buried);
        const Touch touch{.t = sample->t,
                          .stylus = stylus,
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
        summary.largest_force = std::max(summary.largest_force, glm::length(touch.force));
        summary.patches.add(static_cast<std::uint64_t>(std::max(0, touch.patches)));
        summary.nanoseconds.add(static_cast<std::uint64_t>((stop - start) / std::chrono::nanoseconds{1}));
        on_touch(touch);
    }
    return summary;
}

} // namespace demo

#endif // TOUCH_TERRAIN_SESSION_LOOP_HPP
