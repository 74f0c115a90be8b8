#include "bounded.hpp"
#include "strokes.hpp"

// The slowest update of many, by replay: of each update the shortest time of 25 counts, which leaves out the system
// and keeps the algorithm. On all terrains of the data directory.

namespace hfh::bench {
namespace {

constexpr int replays = 25;

constexpr Stroke near_strokes[] = {
    {"sliding 0.1, 0.01 deep", Way::sliding, 0.1, 0.01},
    {"sliding 0.5, 0.5 deep", Way::sliding, 0.5, 0.5},
    {"sliding 1, 5 deep", Way::sliding, 1, 5},
    {"sliding 2, 3 deep", Way::sliding, 2, 3},
    {"sliding 3, 0.5 deep", Way::sliding, 3, 0.5},
    {"sliding 5, 0.5 deep", Way::sliding, 5, 0.5},
    {"sliding 5, 5 deep", Way::sliding, 5, 5},
    {"tapping 5", Way::tapping, 5, 0.5},
    {"flying 5", Way::flying, 5, 0},
};
constexpr Stroke far_strokes[] = {
    {"sliding 30, 0.5 deep", Way::sliding, 30, 0.5},
    {"sliding 100, 0.5 deep", Way::sliding, 100, 0.5},
    {"sliding 100, 5 deep", Way::sliding, 100, 5},
    {"tapping 100", Way::tapping, 100, 0.5},
    {"flying 100", Way::flying, 100, 0},
};

/// What a driver takes that wants its updates short more than its proxy at rest.
constexpr TrackerOptions brisk{.max_slide = 8};

struct Worst {
    double ns = 0;
    std::string where;
    Endings endings{};
    std::string by_ground;
};

template <class G>
void look_for_worst(const G& ground, const Stroke* strokes, std::size_t kinds, std::size_t updates,
                    const TrackerOptions& options, Worst& worst, Findings& found) {
    double here = 0;
    for (std::size_t s = 0; s < kinds; ++s) {
        const auto trace = stroke_trace<double>(ground, strokes[s], updates, 500, options);
        const std::string what = std::string{strokes[s].name} + " on " + ground.kind.name;
        worst.endings.add(check_trace(ground, trace, what));
        const auto time = [&] {
            return time_by_replay(ground.template grid<double>(), trace, replays).worst - clock_cost();
        };
        double ns = time();
        // A machine can be slow for longer than the replays take: what would be the slowest is timed again.
        for (int again = 0; again < 10 && ns > worst.ns; ++again) ns = std::min(ns, time());
        found.note_update(ns, what);
        here = std::max(here, ns);
        if (ns > worst.ns) worst.ns = ns, worst.where = what;
    }
    worst.by_ground +=
        (worst.by_ground.empty() ? "" : ", ") + std::string{ground.kind.name} + ' ' + text(here / 1e3);
}

template <class Visitor>
void each_ground(Visitor&& visit) {
    for (std::size_t t = 0; t < std::size(all_terrains); ++t) visit(terrain(t));
    for (const char* name : {"spanish_peaks", "swissalps_voids", "kinect_boxes"}) {
        if (const auto ground = real_ground<std::int16_t>(name)) visit(*ground);
    }
    for (const char* name : {"enoriver", "mshelens_crater", "bullet_scan"}) {
        if (const auto ground = real_ground<float>(name)) visit(*ground);
    }
}

Row row_of(const std::string& name, double bound, const Worst& worst) {
    return {name,
            "µs",
            {{"", Figure::Goal::at_most, bound, worst.ns / 1e3}},
            "the slowest: " + worst.where + "; by terrain: " + worst.by_ground + "; of " +
                text(worst.endings.updates) + " updates " + text(worst.endings.left_at_hole) +
                " off the rim of a hole, " + text(worst.endings.limits) + " with a proxy on its way"};
}

} // namespace

Findings worst_updates(const Settings&) {
    Worst near, far, brisk_near, brisk_far;
    Findings found;
    each_ground([&](const auto& ground) {
        const auto look = [&](const TrackerOptions& options, Worst& slow, Worst& fast) {
            look_for_worst(ground, near_strokes, std::size(near_strokes), 8'000, options, slow, found);
            look_for_worst(ground, far_strokes, std::size(far_strokes), 1'500, options, fast, found);
        };
        look({}, near, far);
        look(brisk, brisk_near, brisk_far);
    });
    constexpr const char *up_to_5 = "worst update by replay, all terrains, up to 5 cells an update",
                         *up_to_100 = "worst update by replay, all terrains, up to 100 cells an update";
    const std::string with = ", `max_slide` = 8";
    found.rows.push_back(row_of(up_to_5, 3, near));
    found.rows.push_back(row_of(up_to_100, 20, far));
    found.rows.push_back(row_of(up_to_5 + with, 3, brisk_near));
    found.rows.push_back(row_of(up_to_100 + with, 20, brisk_far));
    return found;
}

} // namespace hfh::bench
