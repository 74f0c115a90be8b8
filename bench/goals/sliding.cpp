#include "../dependent_evaluation.hpp"
#include "strokes.hpp"

// One update against one dependent evaluation of a patch; float against double.

namespace hfh::bench {
namespace {

constexpr std::size_t updates_a_stroke = 20'000, updates_a_slice = 1'000;
constexpr int rounds = 25;

constexpr Stroke strokes[] = {
    {"sliding 0.1", Way::sliding, 0.1, 0.5}, {"sliding 0.5", Way::sliding, 0.5, 0.5},
    {"sliding 2", Way::sliding, 2, 0.5},     {"still", Way::resting, 0.5, 0.5},
    {"free", Way::flying, 0.5, 0},           {"touching down, lifting off", Way::tapping, 0.5, 0.5},
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

template <Real T>
std::vector<Trace<T>> traces() {
    std::vector<Trace<T>> made;
    for (const auto& stroke : strokes) {
        made.push_back(stroke_trace<T>(terrain(1), stroke, updates_a_stroke, updates_a_slice));
        const auto endings = check_trace(terrain(1), made.back(), stroke.name);
        // Standing still begins each place above it.
        const double share = endings.contacts / endings.updates;
        const double wanted = stroke.way == Way::flying ? 0 : stroke.way == Way::tapping ? 0.5 : 1;
        if (std::abs(share - wanted) > 0.02 || endings.limits > 0) {
            throw Fault{std::string{stroke.name} + ": not as often in contact as it was made to be"};
        }
    }
    return made;
}

} // namespace

Findings sliding(const Settings&) {
    const auto all = traces<double>();
    std::vector<Runner> runners{reference<double>()};
    for (const auto& trace : all) runners.push_back(updates(terrain(1), trace));
    const auto paces = race(runners, rounds);
    const double one = paces[0].fastest;

    Findings found;
    const auto figure = [&](std::size_t stroke, double bound) {
        return Figure{strokes[stroke].name, Figure::Goal::at_most, bound, paces[1 + stroke].fastest / one};
    };
    const auto ns = [&](std::initializer_list<std::size_t> which) {
        std::string list;
        for (const auto k : which) list += (list.empty() ? "" : " / ") + text(paces[1 + k].fastest);
        return list + " ns against " + text(one);
    };
    found.rows.push_back({"sliding contact, 0.1 / 0.5 / 2 cells an update, against one dependent evaluation",
                          "×",
                          {figure(0, 2.5), figure(1, 4), figure(2, 8)},
                          ns({0, 1, 2})});
    found.rows.push_back({"standing still in contact / free, against the same",
                          "×",
                          {figure(3, 1), figure(4, 0.5)},
                          ns({3, 4})});
    return found;
}

Findings scalars(const Settings&) {
    const auto wide = traces<double>();
    const auto narrow = traces<float>();
    double worst = 0;
    std::string list, worst_name;
    const auto enter = [&](const std::string& name, const Runner& in_double, const Runner& in_float) {
        const auto paces = race({in_double, in_float}, rounds);
        const double ratio = paces[1].fastest / paces[0].fastest;
        if (ratio > worst) worst = ratio, worst_name = name;
        list += (list.empty() ? "" : "; ") + name + ' ' + text(ratio);
    };
    for (std::size_t k = 0; k < std::size(strokes); ++k) {
        enter(strokes[k].name, updates(terrain(1), wide[k]), updates(terrain(1), narrow[k]));
    }
    for (const double length : {0.5, 3.0, 30.0, 300.0}) {
        const auto queries = segments(terrain(1), 1024, length);
        const auto casts = [&queries](auto grid) {
            return Runner{4, 256, [&queries, grid](std::size_t slice) {
                              for (std::size_t k = 256 * slice; k < 256 * (slice + 1); ++k) {
                                  benchmark::DoNotOptimize(first_hit(grid, queries[k].a, queries[k].b));
                              }
                          }};
        };
        enter("cast " + text(length), casts(terrain(1).grid<double>()), casts(terrain(1).grid<float>()));
    }
    Findings found;
    // The same to a fiftieth is no slower: times repeat to one or two hundredths.
    found.rows.push_back({"float against double, the slowest of all subjects (2 % are noise)",
                          "×",
                          {{worst_name, Figure::Goal::at_most, 1.02, worst}},
                          list});
    return found;
}

} // namespace hfh::bench
