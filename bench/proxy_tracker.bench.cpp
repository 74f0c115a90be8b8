#include "dependent_evaluation.hpp"
#include "trace.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/force_evaluator.hpp>

#include <memory>

namespace hfh::bench {
namespace {

constexpr int replays = 25;
constexpr double too_slow = 1e6; // nanoseconds: a haptic loop runs at 1 kHz

/// What one replay found, looked at from outside.
struct Findings {
    double updates = 0, contacts = 0, patches = 0, depth = 0;
    std::string wrong; ///< empty if all is well
};

template <Real T>
Findings look_at(const Terrain& terrain, const Motion& motion, const Trace<T>& trace) {
    const auto grid = terrain.template grid<T>();
    const double width = terrain.kind.spacing.x * static_cast<double>(terrain.kind.columns),
                 depth = terrain.kind.spacing.y * static_cast<double>(terrain.kind.rows);
    // Rounding of a proxy's coordinates, and what it makes of the height on the steepest slope.
    const double tolerance =
        4 * static_cast<double>(epsilon<T>) * ((width + depth) * terrain.steepest + terrain.kind.highest);
    Findings found;
    glm::dvec3 last_proxy{0};
    bool was_touching = false;
    const auto check = [&](bool right, const char* what) {
        if (!right && found.wrong.empty()) {
            found.wrong = std::string{what} + " at update " + std::to_string(std::lround(found.updates));
        }
    };
    replay(grid, trace, [&](const Contact<T>& contact) {
        const auto k = static_cast<std::size_t>(found.updates);
        const glm::dvec3 stylus{trace.stylus[k]}, proxy{contact.proxy};
        if (k % trace.run == 0) was_touching = false;
        const bool below = stylus.z < terrain.surface(stylus.x, stylus.y) - tolerance;
        if (contact.touching()) {
            check(contact.status == ContactStatus::contact, "a limit of work was hit");
            check(std::abs(proxy.z - terrain.surface(proxy.x, proxy.y)) <= tolerance,
                  "proxy off the surface");
            // At a local closest point of a solid the way out leads up. (An averaged normal at a steep vertex need not
            // agree with it.)
            check(contact.penetration.z >= 0, "the force pulls down");
            const double distance = glm::length(proxy - stylus);
            check(std::abs(distance - static_cast<double>(contact.depth)) <= tolerance,
                  "depth is not the distance");
            if (was_touching) {
                check(distance <= glm::length(last_proxy - stylus) + tolerance, "the proxy went away");
                if (motion.doing == Doing::resting) check(proxy == last_proxy, "the proxy does not rest");
            }
            found.contacts += 1;
            found.depth += distance / terrain.cell();
        } else {
            check(!below, "free below the surface");
            check(contact.status == ContactStatus::free, "neither touching nor free");
            check(proxy == stylus, "free, and the proxy is not at the stylus");
        }
        last_proxy = proxy;
        was_touching = contact.touching();
        found.patches += contact.patches;
        found.updates += 1;
    });
    const bool ends_free = motion.doing == Doing::flying || motion.doing == Doing::lifting_off;
    const double share = found.contacts / found.updates;
    // Beside a sharp crest a stylus that comes out of one face can still be held by the other.
    const double allowed = motion.doing == Doing::lifting_off ? 0.001 : 0.0;
    check(ends_free ? share <= allowed : share == 1, "not as often in contact as it was made to be");
    check(found.updates == static_cast<double>(updates_a_trace), "not as many updates as there were to be");
    return found;
}

/// One line of the table. What does not change from run to run is found once.
template <Real T>
class TrackerBenchmark {
public:
    TrackerBenchmark(const TerrainKind& kind, const Motion& motion) : kind_{kind}, motion_{motion} {}

    void operator()(benchmark::State& state) {
        const Terrain& ground = terrain(kind_);
        if (trace_.stylus.empty()) prepare(ground);
        if (!found_.wrong.empty()) return fail(state, found_.wrong);
        if (times_.worst >= too_slow) return fail(state, "an update took 1 ms or more");

        // Time a whole update: contact and force.
        const auto grid = ground.template grid<T>();
        const ForceEvaluator<T> force{.stiffness = 500, .max_force = T(3.3)};
        while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(updates_a_trace))) {
            replay(grid, trace_, [&](const Contact<T>& contact) {
                benchmark::DoNotOptimize(contact);
                benchmark::DoNotOptimize(force(contact));
            });
        }

        state.SetLabel(ground.label());
        state.counters["worst_ns"] = times_.worst;
        state.counters["p99.9_ns"] = times_.p99_9;
        state.counters["clock_ns"] = clock_cost();
        state.counters["patches"] = found_.patches / found_.updates;
        state.counters["contact_share"] = found_.contacts / found_.updates;
        state.counters["depth_cells"] = found_.contacts > 0 ? found_.depth / found_.contacts : 0;
        state.counters["bytes_beside_heights"] = static_cast<double>(bytes_);
        state.counters["state_bytes"] = static_cast<double>(sizeof(TrackerState<T>));
    }

private:
    void prepare(const Terrain& ground) {
        trace_ = make_trace<T>(ground, motion_);
        found_ = look_at(ground, motion_, trace_);

        const std::size_t before = bytes_allocated();
        const auto grid = ground.template grid<T>();
        replay(grid, trace_, [](const Contact<T>& contact) { benchmark::DoNotOptimize(contact); });
        bytes_ = bytes_allocated() - before;

        times_ = time_by_replay(grid, trace_, replays);
    }

    TerrainKind kind_;
    Motion motion_;
    Trace<T> trace_;
    Findings found_;
    UpdateTimes times_;
    std::size_t bytes_ = 0;
};

struct NamedMotion {
    const char* name;
    Motion motion;
};
// clang-format off
constexpr NamedMotion motions[] = {
    {"free",           {Doing::flying,        0.5, 0  }},
    {"first_contact",  {Doing::touching_down, 0.5, 0.5}},
    {"slide_0.1",      {Doing::sliding,       0.1, 0.5}},
    {"slide_0.5",      {Doing::sliding,       0.5, 0.5}},
    {"slide_2",        {Doing::sliding,       2,   0.5}},
    {"slide_5",        {Doing::sliding,       5,   0.5}},
    {"slide_0.1_deep", {Doing::sliding,       0.1, 3  }},
    {"slide_0.5_deep", {Doing::sliding,       0.5, 3  }},
    {"slide_2_deep",   {Doing::sliding,       2,   3  }},
    {"slide_5_deep",   {Doing::sliding,       5,   3  }},
    {"still",          {Doing::resting,       0.5, 0.5}},
    {"lift_off",       {Doing::lifting_off,   0.5, 0.5}},
};
// clang-format on

template <Real T>
void register_all(const std::vector<TerrainKind>& kinds) {
    const std::string scalar = scalar_name<T>;
    add("reference/dependent_evaluation/hills_64x64/" + scalar,
        [](benchmark::State& state) { dependent_evaluation<T>(state, terrain(large_hills), 64); });
    for (const TerrainKind& kind : kinds) {
        for (const auto& [name, motion] : motions) {
            const std::string full = std::string{"tracker/"} + name + "/" + kind.name + "/" + scalar;
            const auto body = std::make_shared<TrackerBenchmark<T>>(kind, motion);
            add(full, [body](benchmark::State& state) { (*body)(state); });
        }
    }
}

} // namespace

void register_benchmarks() {
    const auto kinds = all_terrains();
    register_all<double>(kinds);
    register_all<float>(kinds);
}

} // namespace hfh::bench
