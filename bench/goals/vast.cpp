#include "bounded.hpp"
#include "mapped.hpp"
#include "sweep.hpp"

// That the cost of an update does not depend on the size of the model: the same hills at all sizes up to a billion
// samples, the paper's three sizes on real ground; and the longest sweep there can be.

namespace hfh::bench {
namespace {

/// Many strokes, each in another place: at two cells an update they touch twice the memory that the last cache holds, so
/// that a stroke is new ground to the processor every time it is run.
constexpr std::size_t strokes = 512, updates_a_stroke = 1'000;

/// A stylus that comes down at the first of the positions and is there at the second; the rest is a run of the trace.
template <HeightField Field>
void add_run(Trace<double>& trace, const Field& field, const std::vector<glm::dvec3>& stylus) {
    ProxyTracker tracker{field};
    (void)tracker.update(stylus[0]);
    (void)tracker.update(stylus[1]);
    trace.before.push_back(tracker.state());
    trace.stylus.insert(trace.stylus.end(), stylus.begin() + 2, stylus.end());
    trace.run = stylus.size() - 2;
}

template <class G>
Trace<double> far_flung(const G& ground, double step) {
    const auto grid = ground.template grid<double>();
    Trace<double> all;
    for (std::size_t s = 0; s < strokes; ++s) {
        add_run(all, grid,
                positions(ground, wander(ground, updates_a_stroke + 2, step, s, 0), Way::sliding, 0.5));
    }
    return all;
}

/// A hand's motion of all kinds: each 200 updates anew, anywhere, with another step, 0.1 to 3 cells, and another depth,
/// 0.01 to 5.
template <class G>
Trace<double> coherent(const G& ground) {
    const auto grid = ground.template grid<double>();
    Random random{3};
    Trace<double> all;
    for (std::uint64_t s = 0; s < 100; ++s) {
        const double step = 0.1 * std::pow(30.0, random.unit()),
                     depth = 0.01 * std::pow(500.0, random.unit());
        add_run(all, grid, positions(ground, wander(ground, 202, step, s, 0), Way::sliding, depth));
    }
    return all;
}

/// A first contact from half a cell above to half a cell below, anywhere on the ground. The tracker is told to forget in
/// between, so the way there is not cast.
template <class G>
Trace<double> anywhere(const G& ground, std::size_t count) {
    const auto grid = ground.template grid<double>();
    Random random{4};
    Trace<double> all;
    while (all.stylus.size() < count) {
        const glm::dvec2 at{
            ground.kind.spacing.x * static_cast<double>(ground.kind.columns - 1) * random.unit(),
            ground.kind.spacing.y * static_cast<double>(ground.kind.rows - 1) * random.unit()};
        const double surface = ground.surface(at.x, at.y);
        if (std::isnan(surface)) continue;
        ProxyTracker tracker{grid};
        (void)tracker.update({at, surface + ground.cell() / 2});
        all.before.push_back(tracker.state());
        all.stylus.push_back({at, surface - ground.cell() / 2});
    }
    return all;
}

template <class G>
void measure(const G& ground, Findings& found, bool has_holes = false) {
    const auto grid = ground.template grid<double>();
    const double cells = static_cast<double>((ground.kind.columns - 1) * (ground.kind.rows - 1));
    double hole_exits = 0;
    const auto enter = [&](const char* name, const Trace<double>& trace) {
        const std::string what = std::string{name} + " on " + ground.kind.name;
        hole_exits += check_trace(ground, trace, what).left_at_hole;
        const auto pace = race({updates(ground, trace)}, 5);
        const auto times = time_by_replay(grid, trace, 9);
        found.note_update(times.worst, what);
        found.workloads.push_back({name, ground.kind.name, to_string(ground.kind.source), cells,
                                   pace[0].fastest, times.worst - clock_cost()});
    };
    enter("coherent sliding, steps 0.1 to 3, 0.01 to 5 deep", coherent(ground));
    enter("random first contacts, half a cell deep", anywhere(ground, 10'000));
    enter("swipes, 100 cells an update, half a cell deep",
          stroke_trace<double>(ground, {"", Way::sliding, 100, 0.5}, 5'000, 100));
    if (has_holes && hole_exits == 0)
        throw Fault{std::string{"no way over "} + ground.kind.name + " met a hole"};
}

} // namespace

Findings vast(const Settings& settings) {
    Findings found;
    for (const auto& kind : terrains_of_a_clone) measure(terrain(kind), found);
    measure(hills_in_memory("hills", 4097, 4097), found);
    for (const auto& kind : shared_terrains) {
        if (is_there(kind)) measure(terrain(kind), found);
    }
    if (const auto holes = real_ground<std::int16_t>("swissalps_voids")) measure(*holes, found, true);
    if (const auto holes = real_ground<float>("mshelens_crater")) measure(*holes, found, true);

    std::string where;
    const auto sweep = [&](const char* figure, const auto& ground, const auto& field) {
        const double ns = longest_sweep(ground, field, where);
        found.note_update(ns, std::string{"longest sweep, "} + figure);
        found.numbers.push_back({"sweep", figure, ns / 1e3, {}, where});
    };
    sweep("1.56 M cells, no bounds", terrain(large_hills), terrain(large_hills).grid<double>());

    const char* const vast_goal = "size";
    if (!settings.vast) {
        found.skipped.push_back({vast_goal, "it takes 4 GB of memory: target bench_full"});
        return found;
    }
    if (available_memory() < 4e9) {
        found.skipped.push_back({vast_goal, "less than 4 GB of memory are free"});
        return found;
    }
    measure(hills_in_memory("hills", 16385, 16385), found);
    const auto vast = mapped_hills(settings.scratch, 32768);
    measure(vast, found);
    const auto& small = terrain(small_hills);
    for (const double step : {0.1, 0.5, 2.0}) {
        const auto there = far_flung(vast, step), here = far_flung(small, step);
        check_trace(vast, there, "sliding on a billion samples");
        check_trace(small, here, "sliding on the same hills, small");
        const auto paces = race({updates(small, here), updates(vast, there)}, 7);
        const double at_home = paces[0].median, far_out = paces[1].median;
        found.numbers.push_back({vast_goal, text(step) + " cells", far_out / at_home, {at_home, far_out}});
    }
    Bounded bounded{vast.grid<double>()};
    if (!bounded.build()) throw Fault{"no bounds could be built"};
    sweep("1.07 G samples, with bounds", vast, bounded.field());
    return found;
}

} // namespace hfh::bench
