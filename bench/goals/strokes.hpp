#ifndef HFH_BENCH_GOALS_STROKES_HPP
#define HFH_BENCH_GOALS_STROKES_HPP

#include "../segments.hpp"
#include "../trace.hpp"
#include "goal.hpp"
#include "ground.hpp"
#include "race.hpp"
#include "text.hpp"

// What the stylus does, on any ground, with or without holes; and whether what the tracker answers is right.

namespace hfh::bench {

enum class Way {
    flying,  ///< 20 cells above
    sliding, ///< `depth` cells below
    tapping  ///< `depth` cells above and below in turn: each update is a first contact or a release
};

struct Stroke {
    const char* name;
    Way way;
    double step, depth; ///< cells
};

/// Stylus positions over the points of `path`. The first one is above the surface. Over a hole a sliding stylus stays as
/// low as it was for three updates, and then goes up and on above; behind it, it comes down again.
template <class G>
[[nodiscard]] std::vector<glm::dvec3> positions(const G& ground, const std::vector<glm::dvec2>& path, Way way,
                                                double depth) {
    const double cell = ground.cell();
    std::vector<glm::dvec3> made;
    double last = ground.kind.highest;
    int since_surface = 4; // updates; 4: as good as never
    for (std::size_t k = 0; k < path.size(); ++k) {
        const glm::dvec2 at = path[k];
        const double surface = ground.surface(at.x, at.y);
        const bool hole = std::isnan(surface), back = since_surface > 3;
        since_surface = hole ? std::min(since_surface + 1, 4) : 0;
        if (!hole) last = surface;
        double over = -depth;
        if (way == Way::flying) over = 20;
        if (way == Way::tapping && k % 2 == 0) over = depth;
        if (back || (hole && since_surface > 3)) over = 20;
        made.push_back({at, last + over * cell});
    }
    return made;
}

/// The positions as a trace in runs of `run` updates, each with the tracker's state before it.
template <Real T, HeightField Field>
[[nodiscard]] Trace<T> trace_of(const Field& field, const std::vector<glm::dvec3>& stylus, std::size_t run,
                                const TrackerOptions& options = {}) {
    Trace<T> trace;
    trace.run = run;
    trace.options = options;
    ProxyTracker tracker{field, options};
    for (std::size_t k = 0; k + run <= stylus.size(); k += run) {
        trace.before.push_back(tracker.state());
        for (std::size_t n = 0; n < run; ++n) {
            const vec3<T> at{stylus[k + n]};
            trace.stylus.push_back(at);
            (void)tracker.update(at);
        }
    }
    return trace;
}

template <Real T, class G>
[[nodiscard]] Trace<T> stroke_trace(const G& ground, const Stroke& stroke, std::size_t count, std::size_t run,
                                    const TrackerOptions& options = {}) {
    const auto grid = ground.template grid<T>();
    return trace_of<T>(grid,
                       positions(ground, wander(ground, count, stroke.step, 1), stroke.way, stroke.depth),
                       run, options);
}

/// Updates by how they ended.
struct Endings {
    double updates = 0, contacts = 0, left_at_hole = 0, limits = 0;
    double dropped =
        0; ///< in contact before, and not now, though the surface is over the stylus and has no rim there

    void add(const Endings& more) {
        updates += more.updates, contacts += more.contacts;
        left_at_hole += more.left_at_hole, limits += more.limits, dropped += more.dropped;
    }
};

/// Whether the surface is nowhere nearer, by more than slopes of rounding, a hundred-thousandth of a cell aside of the proxy.
/// Beyond an edge that is nearer than that another minimum may begin: there it takes the contact's word.
template <class G>
[[nodiscard]] bool is_local_minimum(const G& ground, const Contact<double>& contact,
                                    const glm::dvec3& stylus) {
    const auto clear = [](double u) { return u == 0 || u == 1 || (u > 2e-5 && u < 1 - 2e-5); };
    if (!clear(contact.point.u) || !clear(contact.point.v)) return true;
    const double distance = glm::length(contact.proxy - stylus), aside = 1e-5 * ground.cell();
    for (int turn = 0; turn < 8; ++turn) {
        const double angle = 0.785398163397448 * turn;
        const double x = contact.proxy.x + aside * std::cos(angle),
                     y = contact.proxy.y + aside * std::sin(angle);
        if (glm::length(glm::dvec3{x, y, ground.surface(x, y)} - stylus) < distance - 1e-3 * aside)
            return false;
    }
    return true;
}

/// Adds how this update ended.
template <Real T>
void count(Endings& endings, const Contact<T>& contact) noexcept {
    endings.updates += 1;
    endings.contacts += contact.touching() ? 1 : 0;
    endings.left_at_hole += contact.status == ContactStatus::left_at_hole ? 1 : 0;
    endings.limits +=
        contact.status == ContactStatus::descent_limit || contact.status == ContactStatus::sweep_limit ? 1
                                                                                                       : 0;
}

/// Looks at every answer from outside; throws a Fault where one is wrong.
template <Real T, class G>
Endings check_trace(const G& ground, const Trace<T>& trace, const std::string& what) {
    const auto grid = ground.template grid<T>();
    const double size = ground.kind.spacing.x * static_cast<double>(ground.kind.columns) +
                        ground.kind.spacing.y * static_cast<double>(ground.kind.rows);
    // Rounding of a proxy's coordinates, and what it makes of the height on the steepest slope.
    const double tolerance =
        8 * static_cast<double>(epsilon<T>) * (size * (1 + ground.steepest) + ground.kind.highest);
    Endings endings;
    glm::dvec3 last{0};
    bool was_touching = false;
    std::size_t k = 0;
    std::string fault; // the first one: `replay` lets no exception through
    const auto check = [&](bool right, const char* which) {
        if (!right && fault.empty()) fault = what + ": " + which + " at update " + std::to_string(k);
    };
    replay(grid, trace, [&](const Contact<T>& contact) {
        const glm::dvec3 stylus{trace.stylus[k]}, proxy{contact.proxy};
        if (k % trace.run == 0) was_touching = false;
        count(endings, contact);
        if (contact.touching()) {
            const double surface = ground.surface(proxy.x, proxy.y);
            check(!(std::abs(proxy.z - surface) > tolerance), "proxy off the surface"); // NaN: at a rim
            const double distance = glm::length(proxy - stylus);
            check(contact.depth == 0 || std::abs(distance - static_cast<double>(contact.depth)) <= tolerance,
                  "depth is not the distance");
            if (was_touching) {
                check(distance <= glm::length(last - stylus) + tolerance, "the proxy went away");
            }
            if constexpr (std::is_same_v<T, double>) {
                if (k % 16 == 0 && contact.status == ContactStatus::contact)
                    check(is_local_minimum(ground, contact, stylus), "not a local closest point");
            }
        } else {
            const bool below = stylus.z < ground.surface(stylus.x, stylus.y) - tolerance;
            check(contact.status != ContactStatus::free || !below, "free below the surface");
            endings.dropped += was_touching && below && contact.status != ContactStatus::left_at_hole ? 1 : 0;
            check(proxy == stylus, "free, and the proxy is not at the stylus");
        }
        last = proxy;
        was_touching = contact.touching();
        ++k;
    });
    check(k == trace.stylus.size() && k > 0, "not as many updates as there were to be");
    if (!fault.empty()) throw Fault{fault};
    return endings;
}

/// The trace, a run a slice.
template <class G, Real T>
[[nodiscard]] Runner updates(const G& ground, const Trace<T>& trace) {
    return {trace.before.size(), static_cast<double>(trace.run),
            [tracker_field = std::make_shared<typename G::template Grid<T>>(ground.template grid<T>()),
             &trace](std::size_t slice) {
                ProxyTracker tracker{*tracker_field, trace.options};
                tracker.restore(trace.before[slice]);
                const auto* stylus = &trace.stylus[slice * trace.run];
                for (std::size_t k = 0; k < trace.run; ++k) {
                    benchmark::DoNotOptimize(tracker.update(stylus[k]));
                }
            }};
}

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_STROKES_HPP
