#include "../wander.hpp"
#include "goal.hpp"
#include "ground.hpp"
#include "text.hpp"

#include "../clock.hpp"

#include <hfh/contact/ball_tracker.hpp>
#include <hfh/contact/proxy_tracker.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

// A ball beside a point on the same way: what an update costs, and the slowest with limited work. Of each update the shortest
// time of several replays counts.

namespace hfh::bench {
namespace {

constexpr double radii[] = {0.5, 1, 2, 5}; ///< cells

/// The styluses of a hand that holds the lowest point of a ball so deep in the ground.
template <class G>
std::vector<glm::dvec3> way_over(const G& ground, std::size_t count, double step, double deep,
                                 double radius) {
    std::vector<glm::dvec3> way;
    for (const glm::dvec2& at : wander(ground, count, step, 7))
        way.emplace_back(at, ground.surface(at.x, at.y) + (radius - deep) * ground.kind.spacing.x);
    return way;
}

/// Nanoseconds of each update, and how many were without contact after the first that had one.
struct Times {
    std::vector<double> ns;
    std::size_t lost = 0;

    [[nodiscard]] double mean() const {
        double sum = 0;
        for (const double t : ns) sum += t;
        return sum / static_cast<double>(ns.size());
    }
    [[nodiscard]] double worst() const { return *std::max_element(ns.begin(), ns.end()); }
};

/// `make` returns a tracker, which then sees the first stylus from high above.
template <class Make>
Times replay_times(const Make& make, const std::vector<glm::dvec3>& way, double above, int replays) {
    Times times{std::vector<double>(way.size(), std::numeric_limits<double>::max())};
    for (int replay = 0; replay < replays; ++replay) {
        auto tracker = make();
        (void)tracker.update(way[0] + glm::dvec3{0, 0, above});
        times.lost = 0;
        bool touched = false;
        for (std::size_t k = 0; k < way.size(); ++k) {
            const std::uint64_t begin = ticks();
            const auto contact = tracker.update(way[k]);
            const std::uint64_t end = ticks();
            touched = touched || contact.touching();
            times.lost += touched && !contact.touching();
            const double ns = static_cast<double>(end - begin) * nanoseconds_per_tick() - clock_cost();
            times.ns[k] = std::min(times.ns[k], std::max(ns, 1.0));
        }
    }
    return times;
}

template <class G>
void on(const G& ground, Findings& found) {
    const auto grid = ground.template grid<double>();
    const std::string suffix = ground.kind.source == Source::shared ? "_shared" : "";
    const double cell = ground.kind.spacing.x, above = 100 * cell;
    const auto ball = [&](double radius, const TrackerOptions& options) {
        return [&grid, r = radius * cell, options] { return BallTracker{grid, r, options}; };
    };
    for (const double deep : {0.5, 3.0}) {
        const auto point_way = way_over(ground, 8'000, 0.5, deep, 0);
        const Times point = replay_times([&] { return ProxyTracker{grid}; }, point_way, above, 9);
        for (const double radius : radii) {
            const auto way = way_over(ground, 8'000, 0.5, deep, radius);
            const Times times = replay_times(ball(radius, {}), way, above, 9);
            found.numbers.push_back({"ball" + suffix,
                                     text(deep) + " cells deep, r = " + text(radius),
                                     times.mean() / point.mean(),
                                     {times.mean(), point.mean()}});
        }
    }
    for (const double radius : {1.0, 5.0}) {
        for (const double step : {5.0, 100.0}) {
            const auto way = way_over(ground, 4'000, step, 0.5, radius);
            const Times times = replay_times(ball(radius, {.max_contact_patches = 8}), way, above, 9);
            const std::string figure = text(step) + " cells an update, r = " + text(radius);
            found.note_update(times.worst(), "a ball, " + figure);
            found.numbers.push_back({"ball_worst" + suffix, figure, times.worst() / 1e3});
            found.numbers.push_back({"ball_lost" + suffix, figure, static_cast<double>(times.lost)});
        }
    }
}

} // namespace

Findings ball(const Settings&) {
    Findings found;
    on(terrain(large_hills), found);
    if (const auto moab = real_ground<std::int16_t>("moab_standin")) {
        on(*moab, found);
    } else {
        found.skipped.push_back({"ball_shared", "it needs ../shared/data/moab_standin.bil"});
    }
    return found;
}

} // namespace hfh::bench
