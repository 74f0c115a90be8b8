#ifndef HFH_BENCH_TRACE_HPP
#define HFH_BENCH_TRACE_HPP

#include "clock.hpp"
#include "run.hpp"
#include "wander.hpp"

#include <hfh/contact/proxy_tracker.hpp>

#include <limits>

namespace hfh::bench {

/// Stylus positions in runs of `run` updates, and the state before each run of the tracker that follows them.
template <Real T>
struct Trace {
    std::vector<vec3<T>> stylus;
    std::vector<TrackerState<T>> before;
    std::size_t run = 1;
    TrackerOptions options{};
};

/// All updates of a trace; `visit(contact)` after each.
template <HeightField Field, class Visitor>
void replay(const Field& field, const Trace<typename Field::Scalar>& trace, Visitor&& visit) noexcept {
    ProxyTracker tracker{field, trace.options};
    const auto* stylus = trace.stylus.data();
    for (const auto& state : trace.before) {
        tracker.restore(state);
        for (std::size_t k = 0; k < trace.run; ++k) visit(tracker.update(*stylus++));
    }
}

/// Update times that are the program's own: the same trace is replayed many times, and of each update the shortest
/// time counts. What the system does to a replay hits another update in the next one; what the update itself needs
/// comes back every time. The clock is in the times.
struct UpdateTimes {
    double worst = 0, p99_9 = 0; ///< nanoseconds
};
template <HeightField Field>
[[nodiscard]] UpdateTimes time_by_replay(const Field& field, const Trace<typename Field::Scalar>& trace,
                                         int replays) {
    const std::size_t count = trace.stylus.size();
    std::vector<std::uint64_t> stamps(count + 1), shortest(count, std::numeric_limits<std::uint64_t>::max());
    for (int r = 0; r < replays; ++r) {
        std::uint64_t* stamp = stamps.data();
        *stamp = ticks();
        replay(field, trace, [&](const auto& contact) {
            benchmark::DoNotOptimize(contact);
            *++stamp = ticks();
        });
        for (std::size_t k = 0; k < count; ++k) {
            shortest[k] = std::min(shortest[k], stamps[k + 1] - stamps[k]);
        }
    }
    std::sort(shortest.begin(), shortest.end());
    const auto in_ns = [](std::uint64_t t) { return static_cast<double>(t) * nanoseconds_per_tick(); };
    return {in_ns(shortest.back()), in_ns(shortest[count - 1 - count / 1000])};
}

/// What the stylus does.
enum class Doing { flying, touching_down, sliding, resting, lifting_off };

struct Motion {
    Doing doing;
    double step;  ///< cells an update, in plan
    double depth; ///< cells straight down from the surface to the stylus
};

inline constexpr std::size_t updates_a_trace = 20'000;

/// The stylus of `motion` on `terrain`, on one and the same wandering path for a given step.
template <Real T>
[[nodiscard]] Trace<T> make_trace(const Terrain& terrain, const Motion& motion) {
    const auto grid = terrain.template grid<T>();
    const double cell = terrain.cell();
    const auto path = wander(terrain, updates_a_trace + 1, motion.step);
    const auto over = [&](const glm::dvec2& at, double cells) {
        return vec3<T>{glm::dvec3{at, terrain.surface(at.x, at.y) + cells * cell}};
    };
    ProxyTracker tracker{grid};
    const auto touch_down = [&](const glm::dvec2& at) {
        tracker.reset();
        (void)tracker.update(over(at, 20));
        (void)tracker.update(over(at, -motion.depth));
    };

    Trace<T> trace;
    switch (motion.doing) {
    case Doing::flying:
        trace.run = updates_a_trace;
        (void)tracker.update(over(path.front(), 20));
        trace.before.push_back(tracker.state());
        for (std::size_t k = 1; k < path.size(); ++k) trace.stylus.push_back(over(path[k], 20));
        break;
    case Doing::touching_down: // from as far above the surface as it ends below
        for (std::size_t k = 1; k < path.size(); ++k) {
            tracker.reset();
            (void)tracker.update(over(path[k - 1], motion.depth));
            trace.before.push_back(tracker.state());
            trace.stylus.push_back(over(path[k], -motion.depth));
        }
        break;
    case Doing::sliding:
        trace.run = updates_a_trace;
        touch_down(path.front());
        trace.before.push_back(tracker.state());
        for (std::size_t k = 1; k < path.size(); ++k) trace.stylus.push_back(over(path[k], -motion.depth));
        break;
    case Doing::resting: // 100 updates in each of 200 places
        trace.run = 100;
        for (std::size_t k = trace.run; k < path.size(); k += trace.run) {
            touch_down(path[k]);
            const vec3<T> stylus = over(path[k], -motion.depth);
            (void)tracker.update(stylus);
            trace.before.push_back(tracker.state());
            trace.stylus.insert(trace.stylus.end(), trace.run, stylus);
        }
        break;
    case Doing::lifting_off: // to as far above the surface as it was below
        for (std::size_t k = 1; k < path.size(); ++k) {
            touch_down(path[k - 1]);
            trace.before.push_back(tracker.state());
            trace.stylus.push_back(over(path[k], motion.depth));
        }
        break;
    }
    return trace;
}

} // namespace hfh::bench

#endif // HFH_BENCH_TRACE_HPP
