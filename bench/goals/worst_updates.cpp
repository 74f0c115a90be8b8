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

struct Worst {
    double ns = 0;
    std::string where;
    double hole_exits = 0;
    std::string by_ground;
};

template <class G>
void look_for_worst(const G& ground, const Stroke* strokes, std::size_t kinds, std::size_t updates,
                    Worst& worst, Findings& found) {
    double here = 0;
    for (std::size_t s = 0; s < kinds; ++s) {
        const auto trace = stroke_trace<double>(ground, strokes[s], updates, 500);
        const std::string what = std::string{strokes[s].name} + " on " + ground.kind.name;
        worst.hole_exits += check_trace(ground, trace, what).left_at_hole;
        const auto times = time_by_replay(ground.template grid<double>(), trace, replays);
        const double ns = times.worst - clock_cost();
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

Row row_of(const char* name, double bound, const Worst& worst) {
    return {name,
            "µs",
            {{"", Figure::Goal::at_most, bound, worst.ns / 1e3}},
            "the slowest: " + worst.where + "; by terrain: " + worst.by_ground + "; " +
                text(worst.hole_exits) + " times off the rim of a hole"};
}

} // namespace

Findings worst_updates(const Settings&) {
    Worst near, far;
    Findings found;
    each_ground([&](const auto& ground) {
        look_for_worst(ground, near_strokes, std::size(near_strokes), 8'000, near, found);
        look_for_worst(ground, far_strokes, std::size(far_strokes), 1'500, far, found);
    });
    found.rows.push_back(row_of("worst update by replay, all terrains, up to 5 cells an update", 3, near));
    found.rows.push_back(row_of("worst update by replay, all terrains, up to 100 cells an update", 20, far));
    return found;
}

} // namespace hfh::bench
