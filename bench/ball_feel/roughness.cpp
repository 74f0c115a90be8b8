#include "cones.hpp"
#include "report.hpp"

#include <hfh/contact/ball_tracker.hpp>

// Roughness over cones: how fast the centre of a ball goes up and down.

namespace ball_feel {
namespace {

constexpr double mm = 1e-3;
constexpr double radii[] = {0.25 * mm, 0.5 * mm, 1 * mm};
constexpr double cell = 0.05 * mm, step = 0.01 * mm, stroke = 10 * mm;
constexpr double deep = 0.02 * mm; ///< the hand holds the stylus so far below the centre
constexpr int spacings = 13;
constexpr double ratio =
    1.1; ///< from one spacing to the next; the first is where a ball on the floor fits between two axes
constexpr double tolerance = 10; ///< percent, of where the peak lies, and of the model's curve

/// Root mean square of the centre's rise per metre of stroke.
struct Rises {
    double measured = 0; ///< by the tracker
    double model = 0;    ///< of a ball let down on cones of the same places
    long without_contact = 0;
};

/// Straight strokes anywhere and in any direction. The hand follows the ball's height and pushes it down evenly.
[[nodiscard]] Rises rises(double radius, double spacing, int strokes) {
    hfh::test::Random random{7};
    const BallOnCone ball{radius};
    const double margin = 3 * spacing + 2 * radius;
    const Cones cones{spacing, 2 * stroke + 2 * margin, cell, random};
    const auto terrain = cones.terrain();
    const auto grid = terrain.grid();
    const auto model = [&](const glm::dvec2& at) { return ball.centre(cones.to_axis(at.x, at.y)); };

    Rises found;
    long count = 0;
    for (int n = 0; n < strokes; ++n) {
        const double heading = random.between(0, 6.283185307);
        const glm::dvec2 along{std::cos(heading), std::sin(heading)};
        const glm::dvec2 middle{random.between(margin + stroke / 2, cones.size() - margin - stroke / 2),
                                random.between(margin + stroke / 2, cones.size() - margin - stroke / 2)};
        const glm::dvec2 begin = middle - 0.5 * stroke * along;
        hfh::BallTracker tracker{grid, radius};
        double before = model(begin);
        (void)tracker.update({begin, before + cell});
        double hand = before - deep;
        for (int k = 0; k * step < stroke; ++k) {
            const glm::dvec2 at = begin + k * step * along;
            const double height = tracker.centre().z;
            found.without_contact += !tracker.update({at, hand}).touching();
            hand = tracker.centre().z - deep;
            if (k > 20) { // it has settled
                const double rise = tracker.centre().z - height, of_model = model(at) - before;
                found.measured += rise * rise;
                found.model += of_model * of_model;
                ++count;
            }
            before = model(at);
        }
    }
    found.measured = std::sqrt(found.measured / static_cast<double>(count)) / step;
    found.model = std::sqrt(found.model / static_cast<double>(count)) / step;
    return found;
}

constexpr const char* setting =
    R"(## Roughness, as a probe feels it

![Vertical speed of the centre against the spacing of the cones, three radii](ball_roughness.png)

Cones of 0.4 mm with flanks of 45° stand on a square lattice, each moved by up to 15 % of the spacing along either axis; a ball is stroked over them in straight lines, with a hand that holds its stylus 0.02 mm below the height of the ball's centre. Cells of 0.05 mm, 0.01 mm an update. *Roughness* is the root mean square of the centre's vertical speed over the speed of the stroke.

*The model.* A ball of radius r that stands on the floor and touches a cone with flanks of slope angle α stands r·tan(α/2) from where the flank meets the floor, so ℓ = h/tan α + r·tan(α/2) from the axis (if it touches the flank below the apex, r·(1 − cos α) ≤ h, as all three do). On a square lattice of spacing s it gets to the floor in the middle of four cones if s ≥ √2·ℓ, and anywhere between two neighbours if s ≥ 2·ℓ. Below the first a wider spacing lets it sink deeper; above the second each cone is climbed whole, and there are fewer of them for a metre. So the peak has to lie between the two. The dashed curve is the model whole: the height of a ball let down on perfect cones in the places of the same strokes. Unger, Hollis and Klatzky (2011) found that people judge such surfaces roughest near where the probe gets down to the floor, a little above what such a static model tells.

)";

[[nodiscard]] std::string curve(double radius, const std::string& points) {
    return text("$r%03.0f << EOD\n", radius / mm * 100) + points + "EOD\n";
}

} // namespace

Section roughness(const Effort& effort) {
    Section section{setting, {}, true};
    const int strokes = effort.counted(24, 4);
    std::string data, plots, band;
    std::string table =
        "| radius | gets to the floor in the middle of four … between two | peak at | off the model's curve, "
        "at most | updates without contact | |\n|--:|--:|--:|--:|--:|---|\n";
    const char* const colours[] = {black, vermilion, blue};
    int number = 0;
    for (const double radius : radii) {
        const double clear = BallOnCone{radius}.clear();
        const double low = std::sqrt(2.0) * clear, high = 2 * clear;
        double peak = 0, highest = 0, off = 0, spacing = clear;
        long without_contact = 0;
        std::string points;
        for (int n = 0; n < spacings; ++n, spacing *= ratio) {
            const Rises here = rises(radius, spacing, strokes);
            points += text("%g %g %g\n", spacing / mm, here.measured, here.model);
            if (here.measured > highest) highest = here.measured, peak = spacing;
            off = std::max(off, std::abs(100 * (here.measured / here.model - 1)));
            without_contact += here.without_contact;
        }
        const double share = tolerance / 100;
        const bool is_met = peak >= low * (1 - share) && peak <= high * (1 + share) && off <= tolerance &&
                            without_contact == 0;
        section.is_met = section.is_met && is_met;
        table += text("| %.2f mm | %.2f … %.2f mm | %.2f mm | %.1f %% | %ld | %s |\n", radius / mm, low / mm,
                      high / mm, peak / mm, off, without_contact, is_met ? "met" : "not met");
        data += curve(radius, points);
        const std::string block = text("$r%03.0f", radius / mm * 100);
        const char* const colour = colours[number];
        // A band a radius, one above the other at the foot of the plot.
        const double foot = 0.02 + 0.035 * (2 - number);
        band += text("set object %d rectangle from first %g, graph %g to first %g, graph %g fillcolor rgb "
                     "'%s' fillstyle "
                     "solid 0.55 noborder\n",
                     number + 1, low / mm, foot, high / mm, foot + 0.025, colour);
        const int points_of[] = {7, 9, 5};
        plots +=
            text("%s using 1:2 with linespoints lw 2 pt %d ps 1.2 lc rgb '%s' title 'r = %g mm, tracker', ",
                 block.c_str(), points_of[number], colour, radius / mm);
        plots += text("%s using 1:3 with lines lw 2 dt '-' lc rgb '%s' title 'r = %g mm, model', ",
                      block.c_str(), colour, radius / mm);
        ++number;
    }
    plots.resize(plots.size() - 2);
    section.markdown +=
        table + text("\nGoals: the peak lies from the first of the two spacings to the second, ± %g %%; the "
                     "tracker's curve is within %g %% of the model's. Spacings go in steps of 10 %%, %d "
                     "strokes of 10 mm each.\n",
                     tolerance, tolerance, strokes);
    section.plot =
        data + band +
        "set xlabel 'mean spacing of the cones, mm'\n"
        "set ylabel 'RMS vertical speed of the centre / speed of the stroke'\n"
        "set logscale x\nset xrange [0.48:2.7]\nset yrange [0:0.8]\n"
        "set xtics (0.5, 0.6, 0.8, 1, 1.2, 1.5, 2, 2.5)\n"
        "set key top right maxrows 2 width 1 samplen 3 spacing 1.2\n"
        "set label 'bars: spacings at which the ball gets to the floor,' at graph 0.015, graph 0.205 left\n"
        "set label 'in the middle of four cones … between any two' at graph 0.015, graph 0.165 left\n"
        "plot " +
        plots + "\n";
    return section;
}

} // namespace ball_feel
