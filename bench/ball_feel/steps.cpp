#include "../closed_loop/hand.hpp"
#include "../terrain.hpp"
#include "report.hpp"

#include <hfh/contact/ball_tracker.hpp>
#include <hfh/traversal/ball_sweep.hpp>

#include <array>
#include <vector>

// By how much the force of a ball changes from one update to the next, beside a point's.

namespace ball_feel {
namespace {

using closed_loop::Path;
using Terrain = hfh::test::Terrain<double>;

constexpr double cell = 1e-3;                   // m, in the hand
constexpr double step = 0.5 * cell;             // seen from above, an update
constexpr std::size_t updates = 200;            // a path
constexpr hfh::Index clearance = 8;             // cells: so far paths keep away from holes and borders
constexpr double stiffness = 500;               // N/m
constexpr double tolerance = 1;                 // percent, of a mean
constexpr std::array radii{0.0, 0.5, 1.0, 2.0}; // cells
constexpr std::array depths{0.5, 3.0, 5.0};     // cells

struct Ground {
    std::string name;
    Terrain terrain;
};

[[nodiscard]] Terrain samples_of(const hfh::bench::TerrainKind& kind) {
    const auto& from = hfh::bench::terrain(kind);
    return hfh::test::terrain<double>(kind.columns, kind.rows,
                                      [&](hfh::Index i, hfh::Index j) { return from.sample(i, j); },
                                      {.spacing = kind.spacing});
}

/// What comes with a clone, then the real terrains that are there; the names of those that are not go to `missing`.
[[nodiscard]] std::vector<Ground> grounds(std::string& missing) {
    std::vector<Ground> all;
    all.push_back({"Spanish Peaks", samples_of(hfh::bench::spanish_peaks)});
    all.push_back({"Spanish Peaks at 10 m", samples_of(hfh::bench::spanish_peaks_10m)});
    all.push_back({"hills", samples_of(hfh::bench::small_hills)});
    for (const auto& names : {hfh::test::real_terrains_without_holes, hfh::test::real_terrains_with_holes}) {
        for (const auto& name : names) {
            if (name == "spanish_peaks") continue;
            if (auto terrain = hfh::test::real_terrain<double>(name)) {
                all.push_back({name, *std::move(terrain)});
            } else {
                missing += (missing.empty() ? "" : ", ") + name;
            }
        }
    }
    for (auto& ground : all) ground.terrain = closed_loop::resized(std::move(ground.terrain), cell);
    return all;
}

/// Ground with what it takes to lead a tip over it.
class Led {
public:
    explicit Led(const Ground& ground)
        : terrain_{ground.terrain}, grid_{ground.terrain.grid()}, site_{ground.terrain, 14},
          is_close_(ground.terrain.heights.size()) {
        for (hfh::Index j = -1; j <= terrain_.rows; ++j) {
            for (hfh::Index i = -1; i <= terrain_.columns; ++i) {
                if (!is_sample(i, j)) mark_around(i, j);
            }
        }
    }

    /// Wandering paths on the surface, away from holes and borders: as many as are wanted, or fewer where there is little room.
    [[nodiscard]] std::vector<Path> paths(int wanted) {
        std::vector<Path> found;
        for (int attempt = 0; attempt < 100 * wanted && static_cast<int>(found.size()) < wanted; ++attempt) {
            Path path = site_.wander(0, step, cell, updates);
            if (std::none_of(path.begin(), path.end(), [&](const auto& at) { return is_close(at); }))
                found.push_back(std::move(path));
        }
        return found;
    }

    /// Where the centre of a ball that is let down at each place of a path on the surface comes to touch.
    [[nodiscard]] Path let_down(Path path, double radius) const {
        if (radius > 0) {
            for (auto& at : path) {
                const glm::dvec3 from{at.x, at.y, highest_around(at, radius) + radius + cell};
                const glm::dvec3 to{at.x, at.y, at.z + 0.5 * radius};
                const auto sweep = hfh::first_touch(grid_, from, to, radius);
                at = from + sweep.t * (to - from);
            }
        }
        return path;
    }

    [[nodiscard]] const Terrain::Grid& grid() const { return grid_; }

private:
    [[nodiscard]] bool is_sample(hfh::Index i, hfh::Index j) const {
        return i >= 0 && j >= 0 && i < terrain_.columns && j < terrain_.rows &&
               hfh::test::holds_number(terrain_.at(i, j));
    }
    void mark_around(hfh::Index i, hfh::Index j) {
        for (auto b = std::max<hfh::Index>(j - clearance, 0); b <= std::min(j + clearance, terrain_.rows - 1);
             ++b) {
            for (auto a = std::max<hfh::Index>(i - clearance, 0);
                 a <= std::min(i + clearance, terrain_.columns - 1); ++a)
                is_close_[index(a, b)] = true;
        }
    }
    [[nodiscard]] std::size_t index(hfh::Index i, hfh::Index j) const {
        return static_cast<std::size_t>(i + j * terrain_.columns);
    }
    [[nodiscard]] hfh::Index column(double x) const {
        return static_cast<hfh::Index>(std::floor(x / terrain_.frame.spacing.x));
    }
    [[nodiscard]] hfh::Index row(double y) const {
        return static_cast<hfh::Index>(std::floor(y / terrain_.frame.spacing.y));
    }
    [[nodiscard]] bool is_close(const glm::dvec3& at) const {
        return is_close_[index(column(at.x), row(at.y))];
    }
    [[nodiscard]] double highest_around(const glm::dvec3& at, double radius) const {
        double highest = at.z;
        for (auto j = row(at.y - radius); j <= row(at.y + radius) + 1; ++j) {
            for (auto i = column(at.x - radius); i <= column(at.x + radius) + 1; ++i) {
                if (is_sample(i, j)) highest = std::max(highest, terrain_.at(i, j));
            }
        }
        return highest;
    }

    const Terrain& terrain_;
    Terrain::Grid grid_;
    closed_loop::Site<double> site_;
    std::vector<bool> is_close_; ///< sample by sample: to a hole or a border
};

/// What a tip feels on a path.
struct Felt {
    std::vector<glm::dvec3> newtons; ///< an update
    std::vector<double> ratios;      ///< |ΔF|/(k·|Δhand|), from the second update on
    long without_contact = 0;
};

/// A tip whose stylus is `deep` metres below each place of `path`. It comes from above `start`, where it touches when let down.
void follow(const Terrain::Grid& grid, double radius, const glm::dvec3& start, const Path& path, double deep,
            Felt& felt) {
    hfh::BallTracker tracker{grid, radius};
    (void)tracker.update(start + glm::dvec3{0, 0, 1e-3 * cell});
    const glm::dvec3 down{0, 0, -deep};
    for (std::size_t k = 0; k < path.size(); ++k) {
        const auto contact = tracker.update(path[k] + down);
        felt.without_contact += !contact.touching();
        felt.newtons.push_back(contact.touching() ? stiffness * contact.penetration : glm::dvec3{0.0});
        if (k == 0) continue;
        const std::size_t now = felt.newtons.size() - 1;
        felt.ratios.push_back(glm::length(felt.newtons[now] - felt.newtons[now - 1]) /
                              (stiffness * glm::length(path[k] - path[k - 1])));
    }
}

[[nodiscard]] double mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

[[nodiscard]] std::vector<double> means_of_paths(const std::vector<double>& ratios) {
    std::vector<double> means;
    constexpr std::size_t steps = updates - 1;
    for (std::size_t k = 0; k < ratios.size(); k += steps) {
        const auto begin = ratios.begin() + static_cast<std::ptrdiff_t>(k);
        means.push_back(mean({begin, begin + static_cast<std::ptrdiff_t>(steps)}));
    }
    return means;
}

/// Whether the mean of all paths rises by less than the tolerance and two standard errors of the paths' differences.
[[nodiscard]] bool does_not_rise(const std::vector<double>& before, const std::vector<double>& after) {
    const double rise = mean(after) - mean(before), count = static_cast<double>(before.size());
    double squares = 0;
    for (std::size_t k = 0; k < before.size(); ++k)
        squares += (after[k] - before[k] - rise) * (after[k] - before[k] - rise);
    return rise <= tolerance / 100 * mean(before) + 2 * std::sqrt(squares / (count * (count - 1)));
}

constexpr const char* setting =
    R"(What a ball feels like beside a point. `cmake --build build --target ball_feel`; in `double`, no clock in it.

## Steps of the force

![Force and its steps over time, a point and two balls on one path](ball_steps.png)

The picture: Spanish Peaks at 10 m spacing, half a cell deep.

The change of the force in an update over stiffness times the way of the hand: mean, 99 %, largest. A point (r = 0) and balls of 0.5, 1 and 2 cells go the same wandering paths seen from above; cells of 1 mm, 0.5 mm an update, 200 updates a path. The hand does not give way. Each tip is so far below the place where it would touch if it were let down there, so that all are equally deep. Paths keep 8 cells away from holes and borders: the rim of a hole holds a ball where it lets a point fall.

)";

constexpr const char* notes =
    R"(
Goal: from one radius to the next the mean does not rise by more than 1 % and two standard errors of the paths' differences. It falls where the ball bridges what is narrower than itself, and stays where it follows the same faces: that a normal turns by an angle over a fold of the ground is the same for every tip, only spread over more updates.

*kinect_boxes* is without a goal: a depth image of cliffs, with slopes of 39° in the mean and 82° at 99 %. Half a cell deep its steps shrink like the others'. Three cells deep they grow, and not by a fault of the tracker: a wall of one sample stands 2r wider against a ball, and as long as a tip below its top is held by its face, each update's whole way goes into the force, a ratio of 1. So a wall 10 cells high and alone on flat ground, 3 cells deep, gives the four tips means of)";

constexpr const char* second_path =
    R"(The same hand for all, with the lowest point of each tip 0.5 and 3 cells below the ground under its middle: the means. Here they do rise where the hand is shallow. On a slope θ it is a ball's side that touches, and the ball is depth·cos θ + r·(1 − cos θ) deep: on slopes the hand presses a ball harder than a point, and the force changes with the slope.

)";

/// The means of the four tips, straight over flat ground towards a wall of one sample, which holds them from where they meet it.
[[nodiscard]] std::string at_a_wall() {
    const Ground ground{
        "wall",
        closed_loop::resized(
            hfh::test::terrain<double>(60, 40, [](hfh::Index i, hfh::Index) { return i == 24 ? 10.0 : 0.0; }),
            cell)};
    const Led led{ground};
    Path path;
    for (int k = 0; k < 100; ++k) {
        const double x = 5.13 + 0.5 * k, from_wall = std::abs(x - 24);
        path.push_back(cell * glm::dvec3{x, 20.3, 10 * std::max(1 - from_wall, 0.0)});
    }
    std::string means;
    for (const double radius : radii) {
        Felt felt;
        const Path let_down = led.let_down(path, radius * cell);
        follow(led.grid(), radius * cell, let_down[0], let_down, 3 * cell, felt);
        means += text(" %.3f", mean(felt.ratios));
    }
    return means;
}

/// The path of the picture: Spanish Peaks at 10 m, half a cell deep.
[[nodiscard]] std::string plot(const Led& led, const Path& path) {
    struct Look {
        double radius;
        const char *colour, *style, *title;
    };
    std::string data, force, steps;
    int number = 0;
    for (const Look& look :
         {Look{0, black, "lw 1.5 dt 1", "point"}, Look{0.5, vermilion, "lw 2 dt '-'", "r = 0.5 cells"},
          Look{2, blue, "lw 2.5 dt 1", "r = 2 cells"}}) {
        Felt felt;
        const Path let_down = led.let_down(path, look.radius * cell);
        follow(led.grid(), look.radius * cell, let_down[0], let_down, 0.5 * cell, felt);
        data += text("$tip%d << EOD\n", number);
        for (std::size_t k = 1; k < felt.newtons.size(); ++k)
            data += text("%zu %g %g\n", k, felt.newtons[k].x, felt.ratios[k - 1]);
        data += "EOD\n";
        force += text("$tip%d using 1:2 with lines %s lc rgb '%s' title '%s', ", number, look.style,
                      look.colour, look.title);
        steps +=
            text("$tip%d using 1:3 with lines %s lc rgb '%s' notitle, ", number, look.style, look.colour);
        ++number;
    }
    force.resize(force.size() - 2), steps.resize(steps.size() - 2);
    return data +
           "set multiplot\nset lmargin at screen 0.085\nset rmargin at screen 0.985\nset xrange [0:200]\n"
           "set tmargin at screen 0.93\nset bmargin at screen 0.52\nset xtics format ''\n"
           "set key at screen 0.53, screen 0.97 center horizontal samplen 4 width 2\n"
           "set ylabel 'force to the east, N' offset 0.5,0\nplot " +
           force +
           "\nset tmargin at screen 0.48\nset bmargin at screen 0.09\nset xtics format '%g'\nunset key\n"
           "set xlabel 'time, ms (one update each)'\nset yrange [0:*]\n"
           "set ylabel 'step of the force, |ΔF| / (k · |Δhand|)' offset 0.5,0\nplot " +
           steps + "\nunset multiplot\n";
}

/// What the tips feel on some ground, equally deep.
struct Compared {
    std::vector<std::string> cells; ///< a radius
    std::vector<std::string> means; ///< a radius, with the lowest point of each tip on one path
    bool is_met = true;
};

using Paths = std::vector<Path>;

[[nodiscard]] Compared compare(const Led& led, const Paths& paths,
                               const std::array<Paths, radii.size()>& let_down, double deep) {
    Compared found;
    std::vector<double> before;
    for (std::size_t n = 0; n < radii.size(); ++n) {
        const double radius = radii[n] * cell;
        Felt felt, lowest;
        for (std::size_t k = 0; k < paths.size(); ++k) {
            const Path& path = let_down[n][k];
            follow(led.grid(), radius, path[0], path, deep, felt);
            Path raised = paths[k];
            for (auto& at : raised) at.z += radius;
            follow(led.grid(), radius, path[0], raised, deep, lowest);
        }
        const auto by_path = means_of_paths(felt.ratios);
        found.is_met =
            found.is_met && felt.without_contact == 0 && (n == 0 || does_not_rise(before, by_path));
        before = by_path;
        std::sort(felt.ratios.begin(), felt.ratios.end());
        const auto at_99 = static_cast<std::size_t>(0.99 * static_cast<double>(felt.ratios.size() - 1));
        found.cells.push_back(
            text("%.3f, %.2f, %.1f", mean(felt.ratios), felt.ratios[at_99], felt.ratios.back()));
        if (felt.without_contact > 0)
            found.cells.back() += text(" (%ld without contact)", felt.without_contact);
        found.means.push_back(text("%.3f", mean(lowest.ratios)));
    }
    return found;
}

[[nodiscard]] std::string row(const std::string& ground, double deep, const std::vector<std::string>& cells,
                              const char* verdict) {
    std::string out = "| " + ground + text(" | %g |", deep);
    for (const auto& figures : cells) out += " " + figures + " |";
    return out + " " + verdict + " |\n";
}

constexpr const char* heading = "| ground | deep | r = 0 | 0.5 | 1 | 2 | |\n|---|--:|--:|--:|--:|--:|---|\n";

} // namespace

Section force_steps(const Effort& effort) {
    Section section{setting, {}, true};
    std::string missing, skipped, table = heading, second = heading;
    const int wanted = effort.counted(40, 5);
    for (const Ground& ground : grounds(missing)) {
        Led led{ground};
        const Paths paths = led.paths(wanted);
        if (static_cast<int>(paths.size()) < wanted) {
            skipped += (skipped.empty() ? "" : ", ") + ground.name;
            continue;
        }
        if (ground.name == "Spanish Peaks at 10 m") section.plot = plot(led, paths[0]);
        std::array<Paths, radii.size()> let_down;
        for (std::size_t n = 0; n < radii.size(); ++n) {
            for (const Path& path : paths) let_down[n].push_back(led.let_down(path, radii[n] * cell));
        }
        const bool has_goal = ground.name != "kinect_boxes";
        for (const double deep : depths) {
            const Compared found = compare(led, paths, let_down, deep * cell);
            section.is_met = section.is_met && (found.is_met || !has_goal);
            table += row(ground.name, deep, found.cells, !has_goal ? "" : found.is_met ? "met" : "not met");
            if (deep < 5) second += row(ground.name, deep, found.means, "");
        }
    }
    if (!missing.empty())
        section.markdown += "**Skipped, because they are not in `../shared/data`: " + missing + ".**\n\n";
    if (!skipped.empty())
        section.markdown += "Skipped, because holes leave too little room for paths: " + skipped + ".\n\n";
    section.markdown += table + notes + at_a_wall() + ".\n\n" + second_path + second;
    return section;
}

} // namespace ball_feel
