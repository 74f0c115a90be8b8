#include "goal.hpp"
#include "ground.hpp"
#include "text.hpp"

#include "../../tests/support/random.hpp"

#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/level_change.hpp>
#include <hfh/device/workspace.hpp>
#include <hfh/force/force_evaluator.hpp>
#include <hfh/terrain/blended_field.hpp>

#include <algorithm>
#include <initializer_list>
#include <numbers>

// A hand that presses while the terrain zooms under it, from the whole terrain to single cells and back: contacts that are
// lost, and how far the force steps from one update to the next.

namespace hfh::bench {
namespace {

using test::Random;

constexpr int starts = 200, ticks_a_way = 2000;  // 2 s at 1 kHz
constexpr double stiffness = 500, press = 0.002; // N/m and m at the hand: 1 N
constexpr double circle = 0.01;                  // m at the hand, its radius: within 20 mm
constexpr double cell_in_hand = 0.5e-3;

/// How many cells of level 0 each sample is from the next hole or rim, along x or along y, whichever is more.
template <HeightSource Heights>
[[nodiscard]] std::vector<int> clearance(const Heights& heights) {
    const Index w = heights.columns(), h = heights.rows();
    std::vector<int> far(static_cast<std::size_t>(w * h));
    const auto at = [&](Index i, Index j) -> int& { return far[static_cast<std::size_t>(i + j * w)]; };
    const auto around = [&](Index i, Index j, std::initializer_list<Cell> before) {
        for (const Cell d : before) {
            const Index a = i + d.i, b = j + d.j;
            const bool inside = a >= 0 && b >= 0 && a < w && b < h;
            at(i, j) = std::min(at(i, j), inside ? at(a, b) + 1 : 0);
        }
    };
    for (Index j = 0; j < h; ++j) {
        for (Index i = 0; i < w; ++i) {
            at(i, j) = heights.missing(heights(i, j)) ? 0 : std::numeric_limits<int>::max() / 2;
            around(i, j, {{-1, 0}, {-1, -1}, {0, -1}, {1, -1}});
        }
    }
    for (Index j = h; j-- > 0;) {
        for (Index i = w; i-- > 0;) around(i, j, {{1, 0}, {1, 1}, {0, 1}, {-1, 1}});
    }
    return far;
}

struct Found {
    double lost = 0, excused = 0; ///< contacts; excused: near a hole or rim
    double touched = 0;           ///< starts
    int coarsest = 0;             ///< the level of the starts
    std::vector<double> steps;    ///< N, standing
    double largest = 0;           ///< N
    std::string where;
    double numberings = 0, shaded_numberings = 0; ///< N, between both numberings of a whole level
};

template <Real T, HeightSource Heights>
class Zoom {
public:
    using Field = BlendedField<T, StridedLevels<Heights>>;

    Zoom(const Heights& heights, const glm::dvec2& spacing)
        : heights_{heights}, frame_{.spacing = spacing}, far_{clearance(heights)} {
        while ((std::min(heights.columns(), heights.rows()) - 1) >> (coarsest_ + 1) >= 8) ++coarsest_;
    }

    [[nodiscard]] Found run(bool circling) {
        Found found;
        Random random{91};
        // With holes everywhere no place is clear of them on the coarsest levels.
        while (coarsest_ > 1 && !has_clear_place()) --coarsest_;
        found.coarsest = coarsest_;
        for (int n = 0, tries = 0; n < starts && tries < 100 * starts; ++tries)
            n += start(random, circling, found);
        return found;
    }

private:
    [[nodiscard]] double scale_of(double level) const { return std::exp2(level) * cell() / cell_in_hand; }
    [[nodiscard]] double cell() const { return std::sqrt(frame_.spacing.x * frame_.spacing.y); } // level 0

    /// Cells of level 0 from the next hole or rim.
    [[nodiscard]] int cells_clear(const glm::dvec3& at) const {
        const glm::dvec2 cells = glm::dvec2{at} / frame_.spacing;
        const auto i = static_cast<Index>(std::lround(cells.x)), j = static_cast<Index>(std::lround(cells.y));
        if (i < 0 || j < 0 || i >= heights_.columns() || j >= heights_.rows()) return 0;
        return far_[static_cast<std::size_t>(i + j * heights_.columns())];
    }
    [[nodiscard]] bool clear(const glm::dvec3& stylus, const glm::dvec3& proxy, double level) const {
        return std::min(cells_clear(stylus), cells_clear(proxy)) >= (2 << static_cast<int>(level));
    }

    [[nodiscard]] bool has_clear_place() const {
        return *std::max_element(far_.begin(), far_.end()) >= (3 << coarsest_);
    }

    /// One press and zoom; false if there is no ground to press on at a place.
    bool start(Random& random, bool circling, Found& found) {
        Field field{StridedLevels{heights_}, frame_};
        double level = field.set_level(coarsest_);
        const glm::dvec2 size = frame_.spacing * glm::dvec2{static_cast<double>(heights_.columns() - 1),
                                                            static_cast<double>(heights_.rows() - 1)};
        const glm::dvec2 at{size.x * random.unit(), size.y * random.unit()};
        const auto ground = hfh::detail::height_over(field, at.x, at.y);
        if (!ground || !clear({at, 0}, {at, 0}, level)) return false;
        Workspace<T> workspace{{.scale = scale_of(level), .offset = {at, *ground}}};
        ProxyTracker tracker{field};
        (void)tracker.update(workspace.update({0, 0, 0.05}));
        glm::dvec3 hand{0, 0, -press};
        auto contact = tracker.update(workspace.update(hand));
        // Down or up, until it is 1 N.
        for (int n = 0; n < 200 && contact.touching(); ++n) {
            hand.z += 0.5 * (glm::length(force(workspace, contact)) / stiffness - press);
            contact = tracker.update(workspace.update(hand));
        }
        if (!contact.touching()) return false;
        found.touched += 1;
        glm::dvec3 newtons = force(workspace, contact);
        for (int tick = 1; tick <= 2 * ticks_a_way; ++tick) {
            const double share = std::abs(1 - static_cast<double>(tick) / ticks_a_way);
            const double before = level;
            const double scale = scale_of(coarsest_ * share);
            level = suitable_level(scale, cell(), cell_in_hand);
            const bool is_clear = clear(workspace.to_terrain(hand), glm::dvec3{widen(contact.proxy)}, before);
            if (is_clear && !circling && std::ceil(before) != std::ceil(level) && std::round(before) >= 1)
                compare_numberings(field, tracker, workspace, hand,
                                   std::max(std::floor(before), std::floor(level)), found);
            const double rise = change_level(field, level, tracker);
            (void)workspace.move({0, 0, rise});
            (void)workspace.zoom(scale, glm::dvec3{widen(contact.proxy)} + glm::dvec3{0, 0, rise});
            if (circling) hand = on_circle(field, workspace, tick, hand);
            const vec3<T> stylus = workspace.update(hand);
            const glm::dvec3 last{widen(contact.proxy)};
            contact = tracker.update(stylus);
            if (!contact.touching()) {
                ++(clear(glm::dvec3{widen(stylus)}, last, level) ? found.lost : found.excused);
                return true;
            }
            const glm::dvec3 now = force(workspace, contact);
            if (!circling) add_step(glm::length(now - newtons), level, last, rise, contact, found);
            newtons = now;
        }
        return true;
    }

    /// Where a hand is next that goes round once a second and presses as deep below the ground as at the start.
    [[nodiscard]] glm::dvec3 on_circle(const Field& field, const Workspace<T>& workspace, int tick,
                                       glm::dvec3 hand) const {
        // No wider than there is ground.
        const glm::dvec3 here = workspace.to_terrain(hand);
        const double room =
            0.5 * cells_clear(here) * std::min(frame_.spacing.x, frame_.spacing.y) / workspace.frame().scale;
        const double turn = 2 * std::numbers::pi * tick / 1000.0,
                     step = std::min(circle, room) * 2 * std::numbers::pi / 1000;
        hand.x += step * std::cos(turn);
        hand.y += step * std::sin(turn);
        const glm::dvec3 over = workspace.to_terrain(hand);
        if (const auto ground = hfh::detail::height_over(field, over.x, over.y))
            hand.z = workspace.to_hand({over.x, over.y, *ground}).z - press;
        return hand;
    }

    [[nodiscard]] static glm::dvec3 force(const Workspace<T>& workspace, const Contact<T>& contact) {
        const ForceEvaluator<T> spring{.stiffness = workspace.terrain_stiffness(stiffness)};
        return workspace.force_at_hand(spring(contact).newtons);
    }

    void add_step(double newtons, double level, const glm::dvec3& last, double rise,
                  const Contact<T>& contact, Found& found) const {
        found.steps.push_back(newtons);
        if (newtons <= found.largest) return;
        found.largest = newtons;
        const glm::dvec3 slid = glm::dvec3{widen(contact.proxy)} - last - glm::dvec3{0, 0, rise};
        const double wide = std::exp2(std::floor(level)) * cell();
        found.where = "largest step " + text(1e3 * newtons) + " mN, on level " + text(level) +
                      ", as the proxy slid " + text(glm::length(slid) / wide) + " cells";
    }

    /// Both numberings of whole level k, from the state before the update.
    void compare_numberings(const Field& field, const ProxyTracker<Field>& tracker, Workspace<T> workspace,
                            const glm::dvec3& hand, double k, Found& found) const {
        Field coarse = field, fine = field;
        ProxyTracker one{coarse};
        one.restore(tracker.state());
        (void)workspace.move({0, 0, change_level(coarse, k, one)});
        auto state = one.state();
        fine.blend(static_cast<int>(k) - 1, 1);
        state.proxy = renumbered(state.proxy, -1);
        ProxyTracker other{fine};
        other.restore(state);
        const vec3<T> stylus = workspace.update(hand);
        const auto a = one.update(stylus), b = other.update(stylus);
        if (a.touching() != b.touching()) {
            found.numberings = std::numeric_limits<double>::max();
            return;
        }
        const auto differ = [&](const Contact<T>& x, const Contact<T>& y) {
            return glm::length(force(workspace, x) - force(workspace, y));
        };
        found.numberings = std::max(found.numberings, differ(a, b));
        found.shaded_numberings =
            std::max(found.shaded_numberings, differ(shade_force(coarse, a), shade_force(fine, b)));
    }

    Heights heights_;
    GridFrame frame_;
    std::vector<int> far_;
    int coarsest_ = 0;
};

void enter(const Found& standing, const Found& circling, const std::string& name, Source source,
           Findings& found) {
    const std::string shared = source == Source::shared ? "_shared" : "";
    const auto put = [&](const char* goal, const std::string& figure, double value, const std::string& note) {
        found.numbers.push_back({goal + shared, figure, value, {}, note});
    };
    const auto lost = [&](const Found& f) {
        return "of " + text(f.touched) + " presses from level " + std::to_string(f.coarsest) + "; " +
               text(f.excused) + " ended at holes or rims";
    };
    put("zoom_lost", name + ", standing", standing.lost, lost(standing));
    put("zoom_lost", name + ", circling", circling.lost, lost(circling));
    if (standing.steps.empty()) return;
    auto steps = standing.steps;
    double sum = 0;
    for (const double step : steps) sum += step;
    const auto rank = static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(steps.size()));
    std::nth_element(steps.begin(), steps.begin() + rank, steps.end());
    put("zoom_mean", name, sum / static_cast<double>(steps.size()) * 1e3, standing.where);
    put("zoom_most", name, steps[static_cast<std::size_t>(rank)] * 1e3, standing.where);
    put("zoom_numberings", name, standing.numberings * 1e3, "");
    put("zoom_numberings", name + ", shaded", standing.shaded_numberings * 1e3, "");
}

template <HeightSource Heights>
void on(const Heights& heights, const TerrainKind& kind, Findings& found) {
    const auto run = [&]<Real T>(const std::string& scalar) {
        Zoom<T, Heights> zoom{heights, kind.spacing};
        const Found standing = zoom.run(false), circling = zoom.run(true);
        enter(standing, circling, kind.name + scalar, kind.source, found);
    };
    run.template operator()<double>("");
    run.template operator()<float>(", float");
}

template <Sample S>
void on_shared(const char* name, Findings& found) {
    if (const auto ground = real_ground<S>(name)) {
        on(ground->template grid<double>().heights(), ground->kind, found);
    } else {
        found.skipped.push_back({name, "it needs ../shared/data/" + std::string{name} + ".bil"});
    }
}

} // namespace

Findings zoom(const Settings&) {
    Findings found;
    for (const auto& kind : terrains_of_a_clone) on(terrain(kind).grid<double>().heights(), kind, found);
    for (const char* name :
         {"sugarhouse_standin", "moab_standin", "devilshole_standin", "swissalps_voids", "kinect_boxes"})
        on_shared<std::int16_t>(name, found);
    for (const char* name : {"enoriver", "mshelens_crater", "bullet_scan"}) on_shared<float>(name, found);
    return found;
}

} // namespace hfh::bench
