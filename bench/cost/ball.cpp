#include "replays.hpp"

#include <hfh/contact/ball_tracker.hpp>

// The traces of a ball. Apart from the point's, whose counts must not hang on how a compiler inlines these.

using hfh::cost::Felt;
using hfh::cost::Grid;
using hfh::cost::Ground;

namespace {

constexpr double radius = Ground::cell; // metres

/// A ball in contact on its way.
struct BallTrace {
    std::vector<glm::dvec3> stylus;
    hfh::BallState<double> before; ///< the state at the first stylus
    hfh::TrackerOptions options{};
};

/// Its lowest point is half a cell below the ground.
[[nodiscard]] BallTrace make_ball_trace(const Ground& ground, const hfh::cost::TraceKind& kind) {
    const std::size_t count = updates_of(kind);
    const auto path = hfh::cost::wander(count + 1, kind.step);
    const auto over = [&](const glm::dvec2& at, double cells) {
        return glm::dvec3{at, ground.height(at) + cells * Ground::cell};
    };
    const auto grid = ground.grid<double>();
    hfh::BallTracker tracker{grid, radius};
    (void)tracker.update(over(path[0], 20));
    (void)tracker.update(over(path[0], 0.5));
    BallTrace trace{{}, tracker.state(), kind.options};
    for (std::size_t k = 0; k < count; ++k) trace.stylus.push_back(over(path[k + 1], 0.5));
    return trace;
}

} // namespace

extern "C" [[gnu::noinline]] void hfh_cost_replay_ball(const Grid<double>& grid, const BallTrace& trace,
                                                       Felt& felt) noexcept {
    hfh::BallTracker tracker{grid, radius, trace.options};
    const hfh::ForceEvaluator<double> force{.stiffness = 500, .max_force = 3.3};
    tracker.restore(trace.before);
    for (const auto& stylus : trace.stylus) {
        const hfh::BallContact<double> contact = tracker.update(stylus);
        hfh::cost::want(contact);
        felt.contacts += contact.touching();
        felt.work += force(contact).newtons.z;
    }
}

Felt hfh::cost::roll_ball(const Ground& ground, const TraceKind& kind) {
    Felt felt;
    hfh_cost_replay_ball(ground.grid<double>(), make_ball_trace(ground, kind), felt);
    return felt;
}
