#include "bounded.hpp"
#include "mapped.hpp"
#include "sweep.hpp"

// That the cost of an update does not depend on the size of the model: the same hills at all sizes up to a billion
// samples, the paper's three sizes on real ground; and the longest sweep there can be.

namespace hfh::bench {
namespace {

/// Many strokes, each in another place, so that all together touch more memory than a cache holds: a stroke is new
/// ground to the processor every time it is run.
constexpr std::size_t strokes = 512, updates_a_stroke = 1'000;

template <class G>
Trace<double> far_flung(const G& ground, double step) {
    const auto grid = ground.template grid<double>();
    Trace<double> all;
    all.run = updates_a_stroke;
    Random random{5};
    // `wander` starts in the middle; the strokes are moved anywhere.
    const double columns = static_cast<double>(ground.kind.columns - 1),
                 rows = static_cast<double>(ground.kind.rows - 1);
    for (std::size_t s = 0; s < strokes; ++s) {
        std::vector<glm::dvec2> path;
        const double margin = 16;
        double u = random.between(margin, columns - margin), v = random.between(margin, rows - margin);
        double heading = random.between(0, 2 * std::numbers::pi);
        while (path.size() < updates_a_stroke + 2) {
            path.push_back({u * ground.kind.spacing.x, v * ground.kind.spacing.y});
            heading += random.between(-1, 1) * 0.4 * std::sqrt(step);
            const double to_u = u + step * std::cos(heading), to_v = v + step * std::sin(heading);
            if (to_u < margin || to_u > columns - margin) heading = std::numbers::pi - heading;
            if (to_v < margin || to_v > rows - margin) heading = -heading;
            u += step * std::cos(heading);
            v += step * std::sin(heading);
        }
        const auto stylus = positions(ground, path, Way::sliding, 0.5);
        ProxyTracker tracker{grid};
        (void)tracker.update(stylus[0]);
        (void)tracker.update(stylus[1]);
        all.before.push_back(tracker.state());
        all.stylus.insert(all.stylus.end(), stylus.begin() + 2, stylus.end());
    }
    return all;
}

/// A hand's motion of all kinds: each 200 updates with another step, 0.1 to 3 cells, and another depth, 0.01 to 5.
template <class G>
std::vector<glm::dvec3> coherent(const G& ground, std::size_t count) {
    Random random{3};
    std::vector<glm::dvec3> all;
    while (all.size() < count) {
        const double step = 0.1 * std::pow(30.0, random.unit()),
                     depth = 0.01 * std::pow(500.0, random.unit());
        const auto path = wander(ground, 200, step, static_cast<std::uint64_t>(random.whole(0, 1'000'000)));
        const auto part = positions(ground, path, Way::sliding, depth);
        all.insert(all.end(), part.begin(), part.end());
    }
    return all;
}

/// A first contact anywhere on the ground, then another one: two updates a place, above and below.
template <class G>
std::vector<glm::dvec3> anywhere(const G& ground, std::size_t count) {
    Random random{4};
    std::vector<glm::dvec3> all;
    while (all.size() < count) {
        const glm::dvec2 at{
            ground.kind.spacing.x * static_cast<double>(ground.kind.columns - 1) * random.unit(),
            ground.kind.spacing.y * static_cast<double>(ground.kind.rows - 1) * random.unit()};
        const double surface = ground.surface(at.x, at.y);
        if (std::isnan(surface)) continue;
        all.push_back({at, surface + ground.cell() / 2});
        all.push_back({at, surface - ground.cell() / 2});
    }
    return all;
}

template <class G>
void measure(const G& ground, std::vector<Workload>& workloads) {
    const auto grid = ground.template grid<double>();
    const double cells = static_cast<double>((ground.kind.columns - 1) * (ground.kind.rows - 1));
    const auto enter = [&](const char* name, const Trace<double>& trace) {
        check_trace(ground, trace, std::string{name} + " on " + ground.kind.name);
        const auto pace = race({updates(ground, trace)}, 5);
        const auto times = time_by_replay(grid, trace, 9);
        if (times.worst >= 1e6) throw Fault{std::string{name} + ": an update took 1 ms or more"};
        workloads.push_back({name, ground.kind.name, cells, pace[0].fastest, times.worst - clock_cost()});
    };
    enter("coherent sliding, steps 0.1 to 3, 0.01 to 5 deep",
          trace_of<double>(grid, coherent(ground, 20'000), 200));

    // Random queries: the tracker is told to forget in between, so the way there is not cast.
    Trace<double> random;
    random.run = 1;
    const auto places = anywhere(ground, 20'000);
    for (std::size_t k = 0; k + 1 < places.size(); k += 2) {
        ProxyTracker tracker{grid};
        (void)tracker.update(places[k]);
        random.before.push_back(tracker.state());
        random.stylus.push_back(places[k + 1]);
    }
    enter("random first contacts, half a cell deep", random);
    enter("swipes, 100 cells an update, half a cell deep",
          stroke_trace<double>(ground, {"", Way::sliding, 100, 0.5}, 5'000, 100));
}

} // namespace

Findings vast(const Settings& settings) {
    Findings found;
    for (std::size_t t = 0; t < 3; ++t) measure(terrain(t), found.workloads);
    if (const auto holes = real_ground<std::int16_t>("swissalps_voids")) measure(*holes, found.workloads);
    if (const auto holes = real_ground<float>("mshelens_crater")) measure(*holes, found.workloads);
    measure(made_up_ground("hills", 4097, 4097), found.workloads);

    Row mean{
        "mean sliding cost, 0.1 / 0.5 / 2 cells an update, 1.07 G samples mapped from a file over 0.28 M, "
        "always on new ground",
        "×",
        {}};
    constexpr double steps[] = {0.1, 0.5, 2};
    for (const double step : steps) {
        mean.figures.push_back({text(step) + " cells an update", Figure::Goal::at_most, 1.3});
    }
    Row small_sweep{"longest possible sweep, corner to corner, 1.56 M cells, no bounds",
                    "ms",
                    {{"", Figure::Goal::below, 1}}};
    Row vast_sweep{"longest possible sweep, corner to corner, 1.07 G samples, with bounds",
                   "ms",
                   {{"", Figure::Goal::below, 1}}};
    std::string where;
    small_sweep.figures[0].measured = longest_sweep(terrain(1), terrain(1).grid<double>(), where) / 1e6;
    small_sweep.beside = where;

    if (!settings.quick) {
        measure(made_up_ground("hills", 16385, 16385), found.workloads);
        const auto vast = mapped_hills(settings.scratch, 32768);
        measure(vast, found.workloads);
        const auto small = made_up_ground("hills", 541, 511);
        for (std::size_t s = 0; s < std::size(steps); ++s) {
            const auto there = far_flung(vast, steps[s]), here = far_flung(small, steps[s]);
            check_trace(vast, there, "sliding on a billion samples");
            check_trace(small, here, "sliding on the same hills, small");
            const auto paces = race({updates(small, here), updates(vast, there)}, 7);
            mean.figures[s].measured = paces[1].median / paces[0].median;
            mean.beside += (s > 0 ? ", " : "") + text(paces[1].median) + " against " + text(paces[0].median);
        }
        mean.beside += " ns";
#ifdef HFH_HAS_BOUNDS
        Bounded bounded{vast.grid<double>()};
        if (!bounded.build()) throw Fault{"no bounds could be built"};
        vast_sweep.figures[0].measured = longest_sweep(vast, bounded.field(), where) / 1e6;
        vast_sweep.beside = where;
#endif
    }
    for (auto* row : {&mean, &small_sweep, &vast_sweep}) found.rows.push_back(std::move(*row));
    return found;
}

} // namespace hfh::bench
