#include "report.hpp"
#include "text.hpp"

#include <functional>
#include <stdexcept>
#include <string_view>

namespace accuracy {
namespace {

using Sets = std::vector<const Measured*>;

[[nodiscard]] Sets in_scalar(const Run& run, std::string_view scalar) {
    Sets sets;
    for (const Measured& set : run.sets) {
        if (set.scalar == scalar) sets.push_back(&set);
    }
    return sets;
}

/// The figures of the first method of a family with at least `steps`, on one set.
[[nodiscard]] const Figures& figures_of(const Measured& set, Family family, int steps = 0) {
    for (const Figures& figures : set.methods) {
        if (figures.title.family == family && figures.title.steps >= steps) return figures;
    }
    throw std::logic_error{"no such method"};
}

[[nodiscard]] std::string percent(double share) {
    if (share <= 0) return "none";
    return share < 1e-4 ? "< 0.01 %" : text("%.2g %%", 100 * share);
}

/// 99.9 % distance error and share wrong of one method on one set.
[[nodiscard]] std::string in_short(const Figures& figures, const std::string& scalar) {
    const bool exact = figures.distance.most <= rounding_error(scalar);
    std::string out = exact ? "exact" : text("%.0e", figures.distance.most);
    if (figures.wrong > 0) out += filled(", {}", {percent(figures.wrong)});
    return out;
}

/// The time of method m, the least and the most of all sets.
[[nodiscard]] std::string times(const Sets& sets, std::size_t m) {
    double least = std::numeric_limits<double>::max(), most = 0;
    for (const Measured* set : sets) {
        least = std::min(least, set->methods[m].nanoseconds);
        most = std::max(most, set->methods[m].nanoseconds);
    }
    return most < 2 ? text("%.1f", most) : text("%.0f–%.0f", least, most);
}

/// A Markdown table with a column a set.
class Table {
public:
    /// `corner` heads the columns before the sets.
    Table(const Sets& sets, const std::string& corner) : text_{filled("| {} |", {corner})} {
        std::string rule = corner.find('|') == std::string::npos ? "\n|---|" : "\n|---|---|";
        for (const Measured* set : sets) {
            text_ += filled(" {} |", {set->name()});
            rule += "---|";
        }
        text_ += rule;
    }
    void row(const std::string& first, const Sets& sets,
             const std::function<std::string(const Measured&)>& cell) {
        text_ += filled("\n| {} |", {first});
        for (const Measured* set : sets) text_ += filled(" {} |", {cell(*set)});
    }
    [[nodiscard]] std::string text() const { return text_ + "\n\n"; }

private:
    std::string text_;
};

[[nodiscard]] std::string side_by_side(const Run& run, const std::string& scalar) {
    const Sets sets = in_scalar(run, scalar);
    Table table{sets, filled("{} | ns", {scalar})};
    for (std::size_t m = 0; m < sets.front()->methods.size(); ++m) {
        const Title& title = sets.front()->methods[m].title;
        if (title.family == Family::paper && title.steps > 4 && title.steps < 8) continue;
        table.row(filled("{} | {}", {title.name, times(sets, m)}), sets,
                  [&](const Measured& set) { return in_short(set.methods[m], scalar); });
    }
    return table.text();
}

/// What each max_iterations leaves undone.
[[nodiscard]] std::string by_iterations(const Run& run, const std::string& scalar) {
    const Sets sets = in_scalar(run, scalar);
    Table table{sets, filled("`max_iterations`, {}", {scalar})};
    for (const int steps : {1, 2, 3, 4, 8, 64}) {
        table.row(std::to_string(steps), sets, [steps](const Measured& set) {
            return percent(figures_of(set, Family::ours, steps).unfinished);
        });
    }
    return table.text();
}

/// The fewest steps after which the paper's method is exact and never wrong on a set.
[[nodiscard]] std::string steps_to_exact(const Measured& set) {
    for (const Figures& f : set.methods) {
        if (f.title.family == Family::paper && f.wrong <= 0 && f.distance.most <= rounding_error(set.scalar))
            return text("%d", f.title.steps);
    }
    return "no number of";
}

[[nodiscard]] std::string advice(const Run& run) {
    const Sets sets = in_scalar(run, "double");
    if (sets.size() < 6) return "The real terrains were absent; there is nothing to advise from.\n\n";
    const Measured &gentle = *sets[0], &steep = *sets[2], &steep_deep = *sets[3], &hard_deep = *sets[5];
    const auto unfinished = [](const Measured& set, int steps) {
        return percent(figures_of(set, Family::ours, steps).unfinished);
    };
    const auto wrong = [](const Measured& set, Family family, int steps) {
        return percent(figures_of(set, family, steps).wrong);
    };
    const double ours = figures_of(steep_deep, Family::ours, 64).nanoseconds,
                 complete = figures_of(steep_deep, Family::complete).nanoseconds,
                 complete_on_hard = figures_of(hard_deep, Family::complete).nanoseconds;
    double worst = 0;
    for (const Measured& set : run.sets) worst = std::max(worst, figures_of(set, Family::complete).wrong);
    const Figures &vertical = figures_of(steep, Family::vertical),
                  &triangles = figures_of(steep, Family::triangles);

    std::string out = filled(
        "**Which to choose.** For touch, `newton_closest_point` as it comes (`max_iterations = 64`): it "
        "stops "
        "by itself, so a lower limit saves next to nothing and only cuts the rare long way short. Where the "
        "time of one call has to be bounded, 8 leaves {} of the deep queries on steep ground and {} of the "
        "hard ones unfinished, 4 leaves {} and {}. ",
        {unfinished(steep_deep, 8), unfinished(hard_deep, 8), unfinished(steep_deep, 4),
         unfinished(hard_deep, 4)});
    out += filled(
        "It finds the minimum below its start, as a proxy has to, which slides; that is not the closest "
        "point of the patch for {} of the deep queries on steep ground and {} of the hard ones. In float it "
        "stops early in {} of the shallow hard queries, without noticing, and in {} of the deep ones on "
        "steep ground. Where the closest point itself is wanted, take `global_closest_point`: {} of its "
        "answers are wrong in the worst set; it takes {} ns against {} on steep ground, deep, and {} µs on "
        "the hard set. ",
        {wrong(steep_deep, Family::ours, 64), wrong(hard_deep, Family::ours, 64),
         unfinished(*in_scalar(run, "float")[4], 64), unfinished(*in_scalar(run, "float")[3], 64),
         percent(worst), text("%.0f", complete), text("%.0f", ours), text("%.1f", complete_on_hard / 1000)});
    out += filled(
        "The paper's plain Newton is as exact as ours while the stylus is shallow, after {} iterations on "
        "gentle ground and {} on steep; of the deep queries it gets {} wrong on steep ground and {} on the "
        "hard set with 8 iterations, and {} and {} when it goes on until it is still. ",
        {steps_to_exact(gentle), steps_to_exact(steep), wrong(steep_deep, Family::paper, 8),
         wrong(hard_deep, Family::paper, 8), wrong(steep_deep, Family::paper, 64),
         wrong(hard_deep, Family::paper, 64)});
    return out +
           filled("Vertical projection costs {} ns and is off by up to {} cells on steep ground within a "
                  "tenth of a cell of it; two triangles are off by {}, and their normal by {}° there and {}° "
                  "on gentle "
                  "ground (all: "
                  "99.9 %).\n\n",
                  {text("%.1f", vertical.nanoseconds), text("%.1g", vertical.distance.most),
                   text("%.1g", triangles.distance.most), text("%.0f", triangles.angle.most),
                   text("%.0f", figures_of(gentle, Family::triangles).angle.most)});
}

} // namespace

std::string markdown(const Run& run) {
    std::string out = "Closest point of one patch: nanoseconds a query (the least and the most of the sets) "
                      "and, on the same "
                      "queries, the distance error that 99.9 % of them stay within, in cells, with the share "
                      "of wrong answers if "
                      "there are any (distance off by more than 1e-12 in double or 4e-6 in float of the "
                      "largest of cell diagonal, "
                      "relief and distance). *exact*: to four roundings. The numbers after *paper* and "
                      "*ours* are iterations; "
                      "*until still* ends at a step below √ε cells. All Newton methods start over the query, "
                      "at the nearest point "
                      "of the cell.\n\n";
    for (const Measured* set : in_scalar(run, "double"))
        out += filled("- {}: {}\n", {set->name(), set->about});
    out += "\n";
    out += side_by_side(run, "double");
    out += side_by_side(run, "float");
    out += advice(run);
    out += "Queries from which `newton_closest_point` leaves more to gain by going downhill than counts as "
           "wrong:\n\n";
    out += by_iterations(run, "double");
    out += by_iterations(run, "float");
    return out + filled("{} queries a set. {}.\n", {std::to_string(run.queries), machine()});
}

} // namespace accuracy
