#include "../dependent_evaluation.hpp"
#include "casts.hpp"
#include "strokes.hpp"

// One update against one dependent evaluation of a patch; float against double.

namespace hfh::bench {
namespace {

constexpr std::size_t updates_a_stroke = 20'000, updates_a_slice = 1'000;
constexpr int rounds = 25;

constexpr const char* tapping_name = "touching down, lifting off";
constexpr Stroke strokes[] = {
    {"sliding 0.1", Way::sliding, 0.1, 0.5}, {"sliding 0.5", Way::sliding, 0.5, 0.5},
    {"sliding 2", Way::sliding, 2, 0.5},     {"free", Way::flying, 0.5, 0},
    {tapping_name, Way::tapping, 0.5, 0.5},
};

/// 2048 evaluations a slice, each waiting for the last, on cells that stay in the first-level cache.
template <Real T>
Runner reference() {
    const auto chain = std::make_shared<DependentEvaluation<T>>(terrain(large_hills), 64);
    return {8, 2048, [chain](std::size_t) {
                auto here = *chain; // in registers
                for (int k = 0; k < 2048; ++k) {
                    if (!here.step()) throw Fault{"dependent evaluation: there is no patch"};
                }
                benchmark::DoNotOptimize(here.key());
                *chain = here;
                if (!here.right()) throw Fault{"dependent evaluation: the height is wrong"};
            }};
}

struct Subject {
    std::string name;
    Trace<double> wide;
    Trace<float> narrow;
};

/// Each motion in both scalars, checked.
std::vector<Subject> subjects() {
    const Terrain& ground = terrain(large_hills);
    std::vector<Subject> made;
    for (const auto& stroke : strokes) {
        made.push_back({stroke.name, stroke_trace<double>(ground, stroke, updates_a_stroke, updates_a_slice),
                        stroke_trace<float>(ground, stroke, updates_a_stroke, updates_a_slice)});
    }
    // 100 updates in each of 200 places, and the proxy has come to rest before them.
    const Motion resting{Doing::resting, 0.5, 0.5};
    made.push_back({"still", make_trace<double>(ground, resting), make_trace<float>(ground, resting)});

    for (const auto& subject : made) {
        const double wanted = subject.name == "free" ? 0 : subject.name == tapping_name ? 0.5 : 1;
        for (const Endings& endings : {check_trace(ground, subject.wide, subject.name),
                                       check_trace(ground, subject.narrow, subject.name + ", float")}) {
            if (std::abs(endings.contacts / endings.updates - wanted) > 0.002 || endings.limits > 0) {
                throw Fault{subject.name + ": not as often in contact as it was made to be"};
            }
        }
    }
    return made;
}

} // namespace

Findings sliding(const Settings&) {
    const auto all = subjects();
    std::vector<Runner> runners{reference<double>(), reference<double>()};
    for (const auto& subject : all) runners.push_back(updates(terrain(large_hills), subject.wide));
    const auto paces = race(runners, rounds);
    const double one = paces[0].fastest;
    const std::string noise = "the reference against itself " + text(paces[1].fastest / one) + " ×";

    Findings found;
    for (std::size_t k = 0; k < all.size(); ++k) {
        if (all[k].name == tapping_name) continue; // has no goal of its own
        const double ours = paces[2 + k].fastest;
        found.numbers.push_back({"evaluations", all[k].name, ours / one, {one, ours}, noise});
    }
    return found;
}

Findings scalars(const Settings&) {
    Findings found;
    const auto enter = [&](const std::string& name, const Runner& in_double, const Runner& in_float) {
        const auto paces = race({in_double, in_float}, 4 * rounds); // short, and close to each other
        const double wide = paces[0].fastest, narrow = paces[1].fastest;
        found.numbers.push_back({"float", name, narrow / wide, {wide, narrow}});
    };
    const auto all = subjects();
    for (const auto& s : all)
        enter(s.name, updates(terrain(large_hills), s.wide), updates(terrain(large_hills), s.narrow));
    for (const double length : {0.5, 3.0, 30.0, 300.0}) {
        const auto wide = terrain(large_hills).grid<double>();
        const auto narrow = terrain(large_hills).grid<float>();
        auto in_double = cast_set<double>(wide, terrain(large_hills), length, 1024);
        auto in_float = cast_set<float>(narrow, terrain(large_hills), length, 1024);
        check_casts(terrain(large_hills), in_double);
        check_casts(terrain(large_hills), in_float);
        enter("cast " + text(length), casts(wide, in_double), casts(narrow, in_float));
    }
    return found;
}

} // namespace hfh::bench
