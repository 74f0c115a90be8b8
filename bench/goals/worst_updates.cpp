#include "strokes.hpp"

// The slowest update of many, by replay: of each update the shortest time of many counts, which leaves out the system
// and keeps the algorithm. On all terrains there are; and on made-up ground that is level but for roundings,
// where a stylus that all but rests leaves everything to roundings.

namespace hfh::bench {
namespace {

constexpr int replays = 25, long_replays = 9; ///< long: of updates that take microseconds each

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
constexpr TrackerOptions brisk{.max_contact_patches = 8};

/// The slowest update on one ground.
struct Worst {
    double ns = 0;
    std::string where;
    Endings endings{};
};

/// The worst of several traces. What would be the slowest is timed again: a machine can be slow for longer than the
/// replays take.
template <class G, Real T>
void look_at(const G& ground, const Trace<T>& trace, int times, const std::string& what, Worst& worst,
             Findings& found) {
    worst.endings.add(check_trace(ground, trace, what));
    const auto time = [&] {
        return time_by_replay(ground.template grid<T>(), trace, times).worst - clock_cost();
    };
    double ns = time();
    for (int again = 0; again < 3 && ns > worst.ns; ++again) ns = std::min(ns, time());
    found.note_update(ns, what);
    if (ns > worst.ns) worst.ns = ns, worst.where = what;
}

template <class G>
[[nodiscard]] Worst worst_of(const G& ground, const Stroke* strokes, std::size_t kinds, std::size_t updates,
                             int times, const TrackerOptions& options, Findings& found) {
    Worst worst;
    for (std::size_t s = 0; s < kinds; ++s) {
        const std::string what = std::string{strokes[s].name} + " on " + ground.kind.name;
        look_at(ground, stroke_trace<double>(ground, strokes[s], updates, 500, options), times, what, worst,
                found);
    }
    return worst;
}

enum class Reach { near, far };

[[nodiscard]] const char* of(Reach reach) noexcept {
    return reach == Reach::near ? ", up to 5 cells" : ", up to 100 cells";
}
[[nodiscard]] const char* suffix(Source source) noexcept { return source == Source::shared ? "_shared" : ""; }

/// A worst update, for its goal. Those on terrain of ../shared/data have goals of their own.
void enter(const Worst& worst, const std::string& ground, Source source, Reach reach, bool limited,
           Findings& found) {
    const bool near = reach == Reach::near;
    const char* goal = !limited ? "worst" : near ? "worst_limited_near" : "worst_limited_far";
    const Endings& all = worst.endings;
    found.numbers.push_back({std::string{goal} + suffix(source),
                             limited ? ground : ground + of(reach),
                             worst.ns / 1e3,
                             {},
                             worst.where + "; of " + text(all.updates) + " updates " +
                                 text(all.left_at_hole) + " off a rim, " + text(all.limits) +
                                 " with a proxy on its way"});
}

/// Contacts dropped. Not asked for where there are holes: a stylus that went through one may be below the surface.
void enter_dropped(const Worst& worst, const std::string& ground, Source source, Reach reach, bool limited,
                   Findings& found) {
    found.numbers.push_back({std::string{"dropped"} + suffix(source),
                             ground + of(reach) + (limited ? ", limited" : ""), worst.endings.dropped});
}

template <class G>
[[nodiscard]] bool has_holes(const G& ground) {
    for (Index j = 0; j < ground.kind.rows; ++j) {
        for (Index i = 0; i < ground.kind.columns; ++i) {
            if (std::isnan(ground.sample(i, j))) return true;
        }
    }
    return false;
}

template <class G>
void on(const G& ground, Findings& found) {
    const bool holes = has_holes(ground);
    const auto look = [&](Reach reach, bool limited) {
        const TrackerOptions options = limited ? brisk : TrackerOptions{};
        const Worst worst =
            reach == Reach::near
                ? worst_of(ground, near_strokes, std::size(near_strokes), 8'000, replays, options, found)
                : worst_of(ground, far_strokes, std::size(far_strokes), 1'500, long_replays, options, found);
        enter(worst, ground.kind.name, ground.kind.source, reach, limited, found);
        if (!holes) enter_dropped(worst, ground.kind.name, ground.kind.source, reach, limited, found);
    };
    for (const bool limited : {false, true}) {
        look(Reach::near, limited);
        look(Reach::far, limited);
    }
}

template <class S>
void on_shared(const char* name, Findings& found) {
    if (const auto ground = real_ground<S>(name)) {
        on(*ground, found);
    } else {
        found.skipped.push_back({name, "it needs ../shared/data/" + std::string{name} + ".bil"});
    }
}

// Made-up ground.

enum class Level { folds, terraces, plateaus };

/// 96 × 96 samples in cells of a quarter of a metre, at about `height`: level with folds of so many roundings here and
/// there; steps of a cell, each eight cells wide; or squares of 8 × 8 cells at one of four heights.
template <Real T>
[[nodiscard]] Ground<T> level_ground(const char* name, Level kind, double height, double roundings) {
    constexpr Index side = 96;
    constexpr double cell = 0.25;
    const std::shared_ptr<T[]> samples{new T[side * side]};
    Random random{7};
    const double rounding = static_cast<double>(epsilon<T>) * std::max(height, cell);
    const Index squares = side / 8;
    std::vector<double> steps(static_cast<std::size_t>(squares * squares));
    for (double& step : steps) step = cell * static_cast<double>(random.whole(0, 3));
    for (Index j = 0; j < side; ++j) {
        for (Index i = 0; i < side; ++i) {
            double over = 0;
            switch (kind) {
            case Level::folds:
                over = random.one_in(6) ? rounding * roundings * random.between(-1, 1) : 0;
                break;
            case Level::terraces: over = cell * static_cast<double>((i + j) / 8); break;
            case Level::plateaus: over = steps[static_cast<std::size_t>(i / 8 + j / 8 * squares)]; break;
            }
            samples[i + j * side] = static_cast<T>(height + over);
        }
    }
    Ground<T> ground{{name, "", Source::generated, side, side, {cell, cell}, height, height + cell * 24},
                     {samples, samples.get()}};
    detail::find_steepest(ground);
    return ground;
}

/// Of a stylus that all but rests, once it is in contact: 40 updates in each of many places, on grid lines and beside them, on
/// the surface but for roundings and below it.
template <Real T, class G>
[[nodiscard]] Trace<T> all_but_resting(const G& ground, const TrackerOptions& options) {
    constexpr std::size_t places = 300;
    enum class Motion { resting, creeping, rocking };
    const double cell = ground.cell(), rounding = static_cast<double>(epsilon<T>);
    const auto grid = ground.template grid<T>();
    ProxyTracker tracker{grid, options};
    Random random{8};
    Trace<T> trace;
    trace.run = 40;
    trace.options = options;
    for (std::size_t place = 0; place < places; ++place) {
        const auto motion = static_cast<Motion>(place % 3);
        glm::dvec2 at{random.between(4, 90), random.between(4, 90)};
        for (int axis = 0; axis < 2; ++axis) {
            if (random.one_in(2)) // on a line, but for roundings
                at[axis] = std::round(at[axis]) * (1 + rounding * static_cast<double>(random.whole(-4, 4)));
        }
        at *= cell;
        const double surface = ground.surface(at.x, at.y), size = std::max(std::abs(surface), cell);
        const double deep = random.one_in(4) ? cell * random.between(0, 0.5)
                                             : rounding * size * static_cast<double>(random.whole(-4, 8));
        tracker.reset();
        (void)tracker.update(vec3<T>{glm::dvec3{at, surface + 2 * cell}});
        (void)tracker.update(vec3<T>{glm::dvec3{at, surface - deep - 0.02 * cell}});
        trace.before.push_back(tracker.state());
        for (std::size_t n = 0; n < trace.run; ++n) {
            if (motion == Motion::creeping)
                at += rounding * at * glm::dvec2{random.between(-4, 4), random.between(-4, 4)};
            glm::dvec3 stylus{at, ground.surface(at.x, at.y) - deep};
            if (motion == Motion::rocking)
                stylus += (n % 2 == 0 ? 1 : -1) * rounding * glm::dvec3{2.0 * at, 8 * size};
            trace.stylus.push_back(vec3<T>{stylus});
        }
    }
    return trace;
}

/// Level ground but for a fold of 4 mm, and a stylus at rest on it: a place where, in float, every update once used all the
/// work it was allowed (compiled without fused multiply-add). Such places are too rare to be met at random.
[[nodiscard]] Ground<float> folded_ground() {
    constexpr Index side = 20;
    constexpr double cell = 0.23822777808514814;
    const std::shared_ptr<float[]> samples{new float[side * side]{}};
    samples[19 + 18 * side] = -0.0038471512962132692f;
    samples[18 + 19 * side] = -0.004f;
    Ground<float> ground{{"a fold", "", Source::generated, side, side, {cell, cell}, -0.004, 0},
                         {samples, samples.get()}};
    detail::find_steepest(ground);
    return ground;
}
[[nodiscard]] Trace<float> resting_on_the_fold(const Ground<float>& ground, const TrackerOptions& options) {
    const auto grid = ground.grid<float>();
    ProxyTracker tracker{grid, options};
    (void)tracker.update({4.522f, 4.29f, 0.0f});
    (void)tracker.update({4.52f, 4.29f, -0.01f});
    Trace<float> trace;
    trace.run = 40;
    trace.options = options;
    trace.before.push_back(tracker.state());
    trace.stylus.assign(trace.run, {4.5218014717102051f, 4.2881002426147461f, -0.003774052020162344f});
    return trace;
}

template <Real T>
void on_level_ground(bool limited, Findings& found) {
    const TrackerOptions options = limited ? brisk : TrackerOptions{};
    Worst worst;
    const auto look = [&](const char* name, Level kind, double height, double roundings) {
        const auto ground = level_ground<T>(name, kind, height, roundings);
        look_at(ground, all_but_resting<T>(ground, options), replays,
                std::string{"all but resting on "} + name, worst, found);
    };
    for (const double height : {0.0, 512.0}) {
        const bool high = height > 0;
        look(high ? "folds of one rounding, high up" : "folds of one rounding", Level::folds, height, 1);
        look(high ? "folds of ten roundings, high up" : "folds of ten roundings", Level::folds, height, 10);
        look(high ? "folds of a hundred roundings, high up" : "folds of a hundred roundings", Level::folds,
             height, 100);
    }
    look("folds of a hundredth of a cell", Level::folds, 0, 0.01 / static_cast<double>(epsilon<T>));
    look("terraces", Level::terraces, 0, 0);
    look("plateaus", Level::plateaus, 0, 0);
    if constexpr (std::is_same_v<T, float>) {
        const auto ground = folded_ground();
        look_at(ground, resting_on_the_fold(ground, options), replays, "resting on a fold", worst, found);
    }
    const char* name = std::is_same_v<T, float> ? "level ground, float" : "level ground, double";
    enter(worst, name, Source::generated, Reach::near, limited, found);
    enter_dropped(worst, name, Source::generated, Reach::near, limited, found);
}

} // namespace

Findings worst_updates(const Settings&) {
    Findings found;
    for (const auto& kind : terrains_of_a_clone) on(terrain(kind), found);
    for (const bool limited : {false, true}) {
        on_level_ground<float>(limited, found);
        on_level_ground<double>(limited, found);
    }
    for (const auto& kind : shared_terrains) {
        if (is_there(kind)) {
            on(terrain(kind), found);
        } else {
            found.skipped.push_back(
                {kind.name, "it needs ../shared/data/" + std::string{kind.file} + ".bil"});
        }
    }
    for (const char* name : {"swissalps_voids", "kinect_boxes"}) on_shared<std::int16_t>(name, found);
    for (const char* name : {"enoriver", "mshelens_crater", "bullet_scan"}) on_shared<float>(name, found);
    return found;
}

} // namespace hfh::bench
