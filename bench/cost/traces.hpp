#ifndef HFH_BENCH_COST_TRACES_HPP
#define HFH_BENCH_COST_TRACES_HPP

#include "ground.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/force_evaluator.hpp>

#include <string_view>

namespace hfh::cost {

enum class Doing { flying, touching_down, sliding, resting };

/// A scene without any optional piece of the library: these must never come to cost it anything. In contact the stylus
/// is half a cell below the ground, in free flight 20 cells above it.
struct TraceKind {
    std::string_view name;
    Doing doing;
    double step;   ///< cells an update, in plan
    double relief; ///< metres: 60 makes slopes of 0.3 or so, 600 of 3
    bool in_float;
};

// clang-format off
inline constexpr std::array<TraceKind, 6> all_traces{{
    {"free",                 Doing::flying,        0.5,  60, false},
    {"first_contact",        Doing::touching_down, 0.5,  60, false},
    {"slide_0.5_gentle",     Doing::sliding,       0.5,  60, false},
    {"slide_2_steep",        Doing::sliding,       2,   600, false},
    {"still",                Doing::resting,       0.5,  60, false},
    {"slide_0.5_gentle_float", Doing::sliding,     0.5,  60, true },
}};
// clang-format on

/// Stylus positions in runs of `run`, and the tracker's state before each run.
template <Real T>
struct Trace {
    std::vector<vec3<T>> stylus;
    std::vector<TrackerState<T>> before;
    std::size_t run = 1;
};

inline constexpr std::size_t updates_a_trace = 20'000;

template <Real T>
[[nodiscard]] Trace<T> make_trace(const Ground& ground, const TraceKind& kind) {
    const auto grid = ground.template grid<T>();
    const auto path = wander(updates_a_trace + 1, kind.step);
    const auto over = [&](const glm::dvec2& at, double cells) {
        return vec3<T>{glm::dvec3{at, ground.height(at) + cells * Ground::cell}};
    };
    ProxyTracker tracker{grid};
    const auto come_to = [&](const glm::dvec2& at, double cells) { // from outside
        tracker.reset();
        (void)tracker.update(over(at, 20));
        (void)tracker.update(over(at, cells));
        return tracker.state();
    };

    Trace<T> trace;
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
        }
    }
    return trace;
}

/// What a replay felt, for its answers to be checked and not be optimised away.
struct Felt {
    std::size_t contacts = 0;
    double work = 0; ///< the sum of all forces, up
};

/// Every update of the trace with its force. This is what is counted.
template <class Grid, Real T>
[[nodiscard]] inline Felt replay(const Grid& grid, const Trace<T>& trace) noexcept {
    ProxyTracker tracker{grid};
    const ForceEvaluator<T> force{.stiffness = 500, .max_force = T(3.3)};
    Felt felt;
    const vec3<T>* stylus = trace.stylus.data();
    for (const auto& state : trace.before) {
        tracker.restore(state);
        for (std::size_t k = 0; k < trace.run; ++k) {
            const Contact<T> contact = tracker.update(*stylus++);
            asm volatile(""
                         :
                         : "g"(&contact)
                         : "memory"); // all of it is wanted, whether the force needs it or not
            felt.contacts += contact.touching();
            felt.work += static_cast<double>(force(contact).newtons.z);
        }
    }
    return felt;
}

} // namespace hfh::cost

#endif // HFH_BENCH_COST_TRACES_HPP
