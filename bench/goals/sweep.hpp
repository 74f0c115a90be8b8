#ifndef HFH_BENCH_GOALS_SWEEP_HPP
#define HFH_BENCH_GOALS_SWEEP_HPP

#include "strokes.hpp"

namespace hfh::bench {

/// The slowest of single updates that sweep from corner to corner, in nanoseconds: both diagonals, high above, a cell
/// above and a hair above the highest point on the way, and down into the ground at the far corner, clear of all before
/// the last cells. (A way that meets a hill half way measures how long the proxy slides from there.)
template <class G, HeightField Field>
[[nodiscard]] double longest_sweep(const G& ground, const Field& field, std::string& where) {
    const double width = ground.kind.spacing.x * static_cast<double>(ground.kind.columns - 1),
                 depth = ground.kind.spacing.y * static_cast<double>(ground.kind.rows - 1);
    const double cell = ground.cell();
    double slowest = 0;
    for (const bool rising : {true, false}) {
        const glm::dvec2 a{0.25 * cell, rising ? 0.25 * cell : depth - 0.25 * cell},
            b{width - 0.25 * cell, rising ? depth - 0.25 * cell : 0.25 * cell};
        // The line just clear of the ground, of those from above the one corner to above the other.
        const double from = ground.surface(a.x, a.y), to = ground.surface(b.x, b.y);
        double lift = 0;
        // The same at a, of those that end a cell below the ground at b and meet it in the last cells.
        double reach = 0;
        const double landing = 1 - 64.0 / static_cast<double>(ground.kind.columns + ground.kind.rows);
        const int looks = 8 * static_cast<int>(ground.kind.columns + ground.kind.rows);
        for (int k = 0; k <= looks; ++k) {
            const double t = static_cast<double>(k) / looks;
            const glm::dvec2 at = a + t * (b - a);
            const double over = ground.surface(at.x, at.y) - (from + t * (to - from));
            lift = std::max(lift, over);
            if (t <= landing) reach = std::max(reach, (over + t * cell) / (1 - t));
        }
        struct Height {
            const char* name;
            double over_a, over_b; ///< metres over the line
        };
        for (const Height& way :
             {Height{"100 cells above", 100 * cell, 100 * cell}, Height{"a cell above", cell, cell},
              Height{"a hair above", 0.25 * cell, 0.25 * cell},
              Height{"into the far corner", reach - lift + cell, -lift - cell}}) {
            const glm::dvec3 begin{a, from + lift + way.over_a}, end{b, to + lift + way.over_b};
            double shortest = std::numeric_limits<double>::max();
            Contact<double> contact;
            for (int replay = 0; replay < 25; ++replay) {
                // As much work as it takes: a sweep may not end half way.
                ProxyTracker tracker{field, {.max_patches = 1 << 30}};
                (void)tracker.update(begin);
                const std::uint64_t start = ticks();
                contact = tracker.update(end);
                shortest = std::min(shortest, static_cast<double>(ticks() - start));
            }
            const bool must_touch = way.over_b < 0;
            if (must_touch ? !contact.touching() : contact.status != ContactStatus::free) {
                throw Fault{std::string{"sweep "} + way.name + " on " + ground.kind.name + ": wrong end, " +
                            to_string(contact.status)};
            }
            if (must_touch && first_hit(field, begin, end).t < landing) {
                throw Fault{std::string{"sweep "} + way.name + " on " + ground.kind.name +
                            ": met the ground on the way"};
            }
            const double ns = shortest * nanoseconds_per_tick();
            if (ns > slowest) {
                slowest = ns;
                where =
                    std::string{way.name} + ", " + text(static_cast<double>(contact.patches), 6) + " patches";
            }
        }
    }
    return slowest;
}

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_SWEEP_HPP
