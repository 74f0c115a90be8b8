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
    const auto chain = std::make_shared<DependentEvaluation<T>>(terrain(1), 64);
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
    const Terrain& ground = terrain(1);
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
    for (const auto& subject : all) runners.push_back(updates(terrain(1), subject.wide));
    const auto paces = race(runners, rounds);
    const double one = paces[0].fastest;
    const std::string noise = "; the reference against itself " + text(paces[1].fastest / one) + " ×";

    Findings found;
    const auto row = [&](const std::string& name, std::vector<Figure> figures) {
        std::string times;
        for (auto& f : figures) {
            for (std::size_t k = 0; k < all.size(); ++k) {
                if (all[k].name != f.what) continue;
                f.measured = paces[2 + k].fastest / one;
                times += (times.empty() ? "" : " / ") + text(paces[2 + k].fastest);
            }
        }
        found.rows.push_back({name, "×", std::move(figures), times + " ns against " + text(one) + noise});
    };
    constexpr auto at_most = Figure::Goal::at_most;
    row("sliding contact, 0.1 / 0.5 / 2 cells an update, against one dependent evaluation",
        {{"sliding 0.1", at_most, 2.5}, {"sliding 0.5", at_most, 4}, {"sliding 2", at_most, 8}});
    row("standing still in contact / free, against the same",
        {{"still", at_most, 1}, {"free", at_most, 0.5}});
    return found;
}

Findings scalars(const Settings&) {
    double worst = 0;
    std::string list, worst_name;
    const auto enter = [&](const std::string& name, const Runner& in_double, const Runner& in_float) {
        const auto paces = race({in_double, in_float}, 4 * rounds); // short, and close to each other
        const double ratio = paces[1].fastest / paces[0].fastest;
        if (ratio > worst) worst = ratio, worst_name = name;
        list += (list.empty() ? "" : "; ") + name + ' ' + text(ratio);
    };
    const auto all = subjects();
    for (const auto& s : all) enter(s.name, updates(terrain(1), s.wide), updates(terrain(1), s.narrow));
    for (const double length : {0.5, 3.0, 30.0, 300.0}) {
        const auto wide = terrain(1).grid<double>();
        const auto narrow = terrain(1).grid<float>();
        auto in_double = cast_set<double>(wide, terrain(1), length, 1024);
        auto in_float = cast_set<float>(narrow, terrain(1), length, 1024);
        check_casts(terrain(1), in_double);
        check_casts(terrain(1), in_float);
        enter("cast " + text(length), casts(wide, in_double), casts(narrow, in_float));
    }
    Findings found;
    // The same to a fiftieth is no slower: times repeat to one or two hundredths.
    found.rows.push_back({"float against double, the slowest of all subjects (2 % are noise)",
                          "×",
                          {{"", Figure::Goal::at_most, 1.02, worst}},
                          "the slowest: " + worst_name + "; " + list});
    return found;
}

} // namespace hfh::bench
