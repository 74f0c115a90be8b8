// Ground that gives way: a stylus presses, and where it pushes harder than the ground can bear the ground sinks; then a
// brush raises ground under a hand that rests on it. The samples are edited between updates, nothing is rebuilt, nobody
// tells the tracker. Draws the force over time and the ground before and after, and says how far the force moved in
// one update against what the edit and the hand moved.
//
// The force is shown as the ground asks for it, without the guard that a device needs (touch_terrain has one): a guard
// would hide a kick. It would not act here; tests/edits.test.cpp sends such a force through one.

#include <hfh/hfh.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace {

constexpr int columns = 81, rows = 41;
constexpr double spacing = 0.002;                                     // metres
constexpr double stiffness = 500, yields_at = 1.0, gives = 0.3;       // N/m, N, share of the excess an update
constexpr double stamp = 0.012, brush = 0.03, fastest_edit = 0.00005; // radii and metres an update

/// Ground of one's own, to be felt through a view.
class Ground {
public:
    Ground() : heights_(columns * rows) {
        for (int j = 0; j < rows; ++j) {
            for (int i = 0; i < columns; ++i)
                at(i, j) = 0.03 + 0.004 * std::sin(i * 0.1) * std::cos(j * 0.12);
        }
    }

    [[nodiscard]] auto grid() const {
        return hfh::BilinearGrid{hfh::HeightView{heights_.data(), columns, rows},
                                 {.spacing = {spacing, spacing}}};
    }

    /// Lifts the samples within `radius` of (x, y) by up to `by` metres, most in the middle and smoothly to nothing.
    void lift(double x, double y, double radius, double by) {
        const auto first = [](double edge) {
            return std::max(0, static_cast<int>(std::ceil(edge / spacing)));
        };
        for (int j = first(y - radius); j < rows && j * spacing < y + radius; ++j) {
            for (int i = first(x - radius); i < columns && i * spacing < x + radius; ++i) {
                const double dx = i * spacing - x, dy = j * spacing - y;
                const double inside = 1 - (dx * dx + dy * dy) / (radius * radius);
                if (inside > 0) at(i, j) += by * inside * inside;
            }
        }
    }

    /// Heights along y = 0.04, in mm.
    [[nodiscard]] std::vector<double> profile() const {
        std::vector<double> line;
        for (int i = 0; i < columns; ++i)
            line.push_back(1000 * heights_[static_cast<std::size_t>(i + 20 * columns)]);
        return line;
    }

private:
    [[nodiscard]] double& at(int i, int j) { return heights_[static_cast<std::size_t>(i + j * columns)]; }

    std::vector<double> heights_;
};

/// A hand, at one position a millisecond.
hfh::vec3<double> hand(int ms) {
    const double press = std::clamp((ms - 200) / 800.0, 0.0, 1.0);  // down 12 mm,
    const double drag = std::clamp((ms - 1200) / 1000.0, 0.0, 1.0); // along 60 mm,
    const double lift = std::clamp((ms - 2400) / 200.0, 0.0, 1.0);  // up 3 mm, and rest
    return {0.04 + 0.06 * drag, 0.04, 0.036 - 0.012 * press + 0.003 * lift};
}

/// What the hand does at a time, in words.
const char* doing(int ms) {
    struct Phase {
        int end; // ms
        const char* words;
    };
    constexpr Phase phases[] = {
        {200, "waits"},  {1000, "presses down"}, {1200, "holds"}, {2200, "drags"},
        {2400, "holds"}, {2600, "lifts"},        {3000, "rests"}, {3400, "rests; a brush heaps up"}};
    for (const auto& [end, words] : phases)
        if (ms < end) return words;
    return "rests";
}

/// A cross-section, drawn with '.' for ground that was dug away, '+' for ground that was heaped up and '#' for the rest.
void draw(const std::vector<double>& before, const std::vector<double>& after) {
    for (int mm = 35; mm >= 22; --mm) {
        std::printf("%5d mm  ", mm);
        for (int i = 0; i < columns; ++i) {
            const bool was = before[static_cast<std::size_t>(i)] >= mm,
                       is = after[static_cast<std::size_t>(i)] >= mm;
            std::putchar(was && is ? '#' : was ? '.' : is ? '+' : ' ');
        }
        std::putchar('\n');
    }
}

} // namespace

int main() {
    Ground ground;
    const auto grid = ground.grid();
    hfh::ProxyTracker tracker{grid};
    const hfh::ForceEvaluator<double> force{.stiffness = stiffness, .max_force = 3.3};

    const auto before = ground.profile();
    std::printf("   ms   hand x  hand z  force\n            mm      mm      N\n");
    auto last_hand = hand(0), last_force = hfh::vec3<double>{0.0};
    double dug = 0, raised = 0, edit = 0, strongest = 0, largest_step = 0, largest_share = 0;
    for (int ms = 0; ms <= 4000; ++ms) {
        const auto at = hand(ms);
        const auto contact = tracker.update(at);
        const auto felt = force(contact).newtons;

        // How far the force moved, against the most that a spring can for what the ground and the hand moved.
        const double step = glm::length(felt - last_force);
        const double allowed = stiffness * (edit + glm::length(at - last_hand));
        largest_step = std::max(largest_step, step);
        if (step > 1e-9) largest_share = std::max(largest_share, step / allowed);
        strongest = std::max(strongest, glm::length(felt));
        if (ms % 200 == 0) {
            std::printf(
                "%5d   %6.1f  %6.1f  %5.2f  %-25s %s\n", ms, 1000 * at.x, 1000 * at.z, glm::length(felt),
                std::string(static_cast<std::size_t>(10 * glm::length(felt) + 0.5), '=').c_str(), doing(ms));
        }
        last_force = felt;
        last_hand = at;

        // The ground gives way under more than it bears; from 3 s on a brush raises it under the resting hand.
        edit = 0;
        const double excess = contact.depth - yields_at / stiffness;
        if (ms < 3000 && excess > 0) {
            edit = std::min(gives * excess, fastest_edit);
            ground.lift(contact.proxy.x, contact.proxy.y, stamp, -edit);
            dug += edit;
        } else if (ms >= 3000 && ms < 3400) {
            edit = 0.25 * fastest_edit;
            ground.lift(at.x, at.y, brush, edit);
            raised += edit;
        }
    }
    std::printf("\nThe ground along the stroke, from x = 0 to 160 mm: . dug away, + heaped up\n\n");
    draw(before, ground.profile());
    std::printf("\nStrongest force %.2f N. In one update it moved by %.3f N at most, and never by more than "
                "%.2f times\n"
                "what a spring of %.0f N/m does for the way that ground and hand moved: no kick.\n",
                strongest, largest_step, largest_share, stiffness);
    return largest_share <= 1.01 && dug > 0 && raised > 0 ? 0 : 1;
}
