#ifndef HFH_BENCH_COST_TRACES_HPP
#define HFH_BENCH_COST_TRACES_HPP

#include "ground.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/force_evaluator.hpp>

#include <algorithm>
#include <string_view>

namespace hfh::cost {

enum class Doing { flying, touching_down, sliding, resting, casting, rolling };

/// A scene, and what the stylus does. In contact it is half a cell below the ground, in free flight 20 cells above it. But for
/// friction and a ball no optional piece of the library takes part, and these must never come to cost the other scenes
/// anything.
struct TraceKind {
    std::string_view name;
    Doing doing;
    double step;   ///< cells an update, in plan; casting: cells a cast
    double relief; ///< metres: 60 makes slopes of 0.3 or so, 600 of 3
    bool in_float = false;
    bool friction = false;
    TrackerOptions options{};
};

// clang-format off
inline constexpr std::array<TraceKind, 12> all_traces{{
    {"free",                 Doing::flying,        0.5,  60},
    {"first_contact",        Doing::touching_down, 0.5,  60},
    {"slide_0.5_gentle",     Doing::sliding,       0.5,  60},
    {"slide_2_steep",        Doing::sliding,       2,   600},
    {"still",                Doing::resting,       0.5,  60},
    {"slide_0.5_gentle_float", Doing::sliding,     0.5,  60, true},
    {"slide_0.5_friction",   Doing::sliding,       0.5,  60, false, true},
    {"slide_2_steep_limited", Doing::sliding,      2,   600, false, false, {.max_contact_patches = 8}},
    {"slide_0.5_sheet",      Doing::sliding,       0.5,  60, false, false, {.surface = SurfaceKind::sheet}},
    {"cast_300",             Doing::casting,       300,  60},
    {"ball_0.5_gentle",      Doing::rolling,       0.5,  60},
    {"ball_2_steep_limited", Doing::rolling,       2,   600, false, false, {.max_contact_patches = 8}},
}};
// clang-format on

/// Stylus positions in runs of `run`, and the tracker's state before each run. Casting: each run goes from a place above the
/// ground to one below it.
template <Real T>
struct Trace {
    std::vector<vec3<T>> stylus;
    std::vector<TrackerState<T>> before;
    std::size_t run = 1;
    TrackerOptions options{};
};

inline constexpr std::size_t updates_a_trace = 20'000;
/// A ball's update takes up to forty times as many instructions as a point's.
inline constexpr std::size_t updates_of_a_ball = 2'000;

[[nodiscard]] constexpr std::size_t updates_of(const TraceKind& kind) noexcept {
    return kind.doing == Doing::rolling ? updates_of_a_ball : updates_a_trace;
}

/// From five cells above the highest ground, `cells` away along the longer way over the grid, to ten cells below the ground.
template <Real T>
void make_casts(Trace<T>& trace, const Ground& ground, double cells, const std::vector<glm::dvec2>& path) {
    const double across = (Ground::size - 1) * Ground::cell;
    const double top = *std::max_element(ground.samples.begin(), ground.samples.end()) + 5 * Ground::cell;
    trace.run = 2;
    for (std::size_t k = 0; k < updates_a_trace; ++k) {
        const glm::dvec2 to = path[k];
        // Two thirds of the cells along one axis, one third along the other.
        const glm::dvec2 way{cells * Ground::cell * 2 / 3, cells * Ground::cell / 3};
        const glm::dvec2 from{to.x < across / 2 ? to.x + way.x : to.x - way.x,
                              to.y < across / 2 ? to.y + way.y : to.y - way.y};
        trace.stylus.push_back(vec3<T>{glm::dvec3{from, top}});
        trace.stylus.push_back(vec3<T>{glm::dvec3{to, ground.height(to) - 10 * Ground::cell}});
    }
}

template <Real T>
[[nodiscard]] Trace<T> make_trace(const Ground& ground, const TraceKind& kind) {
    const auto grid = ground.template grid<T>();
    const bool casts = kind.doing == Doing::casting;
    const auto path = wander(updates_a_trace + 1, casts ? 0.5 : kind.step);
    const auto over = [&](const glm::dvec2& at, double cells) {
        return vec3<T>{glm::dvec3{at, ground.height(at) + cells * Ground::cell}};
    };
    ProxyTracker tracker{grid, kind.options};
    const auto come_to = [&](const glm::dvec2& at, double cells) { // from outside
        tracker.reset();
        (void)tracker.update(over(at, 20));
        (void)tracker.update(over(at, cells));
        return tracker.state();
    };

    Trace<T> trace;
    trace.options = kind.options;
    if (casts) {
        make_casts(trace, ground, kind.step, path);
        return trace;
    }
    trace.run = kind.doing == Doing::touching_down ? 1 : kind.doing == Doing::resting ? 100 : updates_a_trace;
    for (std::size_t k = 0; k < updates_a_trace; ++k) {
        const bool run_begins = k % trace.run == 0;
        switch (kind.doing) {
        case Doing::flying:
            if (run_begins) trace.before.push_back(come_to(path[k], 20));
            trace.stylus.push_back(over(path[k + 1], 20));
            break;
        case Doing::touching_down:
            if (run_begins) trace.before.push_back(come_to(path[k], 0.5));
            trace.stylus.push_back(over(path[k + 1], -0.5));
            break;
        case Doing::sliding:
            if (run_begins) trace.before.push_back(come_to(path[k], -0.5));
            trace.stylus.push_back(over(path[k + 1], -0.5));
            break;
        case Doing::resting:
            if (run_begins) {
                (void)come_to(path[k], -0.5);
                (void)tracker.update(over(path[k], -0.5)); // at rest from here on
                trace.before.push_back(tracker.state());
            }
            trace.stylus.push_back(over(path[k - k % trace.run], -0.5));
            break;
        case Doing::casting:
        case Doing::rolling: break;
        }
    }
    return trace;
}

/// What a replay felt, for its answers to be checked and not be optimised away.
struct Felt {
    std::size_t contacts = 0;
    double work = 0; ///< the sum of all forces, up
};

/// Keeps an answer whole, whether the rest of the replay needs all of it or not.
template <class Answer>
inline void want(const Answer& answer) noexcept {
    asm volatile("" : : "g"(&answer) : "memory");
}

/// Every update of the trace with its force. This is what is counted. `update` gives what is felt of a tracker and a stylus.
template <class Grid, Real T, class Update>
[[nodiscard]] inline Felt replay(const Grid& grid, const Trace<T>& trace, Update&& update) noexcept {
    ProxyTracker tracker{grid, trace.options};
    const ForceEvaluator<T> force{.stiffness = 500, .max_force = T(3.3)};
    Felt felt;
    const vec3<T>* stylus = trace.stylus.data();
    for (const auto& state : trace.before) {
        tracker.restore(state);
        for (std::size_t k = 0; k < trace.run; ++k, ++stylus) {
            const Contact<T> contact = update(tracker, *stylus);
            want(contact);
            felt.contacts += contact.touching();
            felt.work += static_cast<double>(force(contact).newtons.z);
        }
    }
    return felt;
}

} // namespace hfh::cost

#endif // HFH_BENCH_COST_TRACES_HPP
