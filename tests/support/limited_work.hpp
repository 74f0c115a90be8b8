#ifndef HFH_TESTS_SUPPORT_LIMITED_WORK_HPP
#define HFH_TESTS_SUPPORT_LIMITED_WORK_HPP

#include "counting_field.hpp"
#include "hard_ground.hpp"
#include "reference.hpp"

#include <hfh/contact/proxy_glide.hpp>
#include <hfh/contact/proxy_tracker.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <string>

// What a tracker promises whatever `max_patches` and `max_contact_patches` are set to, judged from outside and cheaply enough for
// millions of updates a minute: the heights and the stylus are all that is asked.

namespace hfh::test {

/// A bound of how long a way over one patch is, metres.
template <Real T>
[[nodiscard]] double longest_patch(const Terrain<T>& terrain) {
    double low = 0, high = 0;
    for (const T height : terrain.heights) {
        if (!(std::abs(height) < no_height_from<T>)) continue;
        low = std::min(low, static_cast<double>(height)), high = std::max(high, static_cast<double>(height));
    }
    return terrain.frame.spacing.x + terrain.frame.spacing.y + (high - low);
}

/// The square of a smaller length is no number of T, and a depth comes out as zero.
template <Real T>
inline const Wide no_square = std::sqrt(static_cast<Wide>(std::numeric_limits<T>::min()));

/// Follows a tracker with limited work on ground that may be edited, and a glide behind it if that has a speed.
///
/// Bounded: `patches` ≤ max_patches + 16, and the looks counted in the field are no more than four times that.
/// Never dropped: on ground without holes, a stylus that was in contact, stayed over the grid and has the surface over it
/// (felt from below: under it) by more than roundings is in contact, with a force.
/// Gets there: at rest, contact or freedom after 64 + 4·n/w updates and no change by one ulp from then on, with little
/// work; w = min(max_patches, max_contact_patches), n = cells between the proxy and the stylus plus the patches that unlimited work
/// looks at on the same way. With a glide 16 more for each patch of them that is longer than its speed. At the rim and over a hole, where a rounding decides, the status may change once more.
/// Nothing out of nothing: no force where unlimited work, once at rest, gives none.
template <Real T>
class LimitedWork {
public:
    using Grid = typename Terrain<T>::Grid;
    using Field = CountingField<Grid>;

    LimitedWork(const Terrain<T>& terrain, const TrackerOptions& options, double glide_speed = 0)
        : terrain_{&terrain}, options_{options}, grid_{terrain.grid()},
          glide_speed_{glide_speed}, holes_{!without_holes(terrain)} {}
    LimitedWork(const LimitedWork&) = delete;
    LimitedWork& operator=(const LimitedWork&) = delete;

    long updates = 0, contacts = 0, rests = 0;
    bool judges_rest =
        true; ///< false: `rest` goes through the same updates, and what is true of each alone is judged

    /// An update of the tracker, judged. What breaks a promise is in `fault()` from then on.
    Contact<T> update(const vec3<T>& stylus) {
        before_ = now_;
        stylus_ = stylus;
        field_.forget_looks();
        last_ = glide_.follow(field_, tracker_.update(stylus), stylus);
        if (last_.status != ContactStatus::bad_input) now_ = {tracker_.state(), last_, glide_.state()};
        ++updates;
        contacts += last_.touching();
        if (const char* what = judge()) note(what);
        return last_;
    }

    /// Rests at `stylus` until the proxy has arrived, and three updates more. Returns the last one.
    Contact<T> rest(const vec3<T>& stylus) {
        ++rests;
        const Unlimited unlimited = settle(stylus);
        const double cells = cells_to(stylus) + unlimited.patches,
                     to_glide = glides() ? 16 * cells * (1 + longest_patch(*terrain_) / glide_speed_) : 0,
                     enough = 64 + to_glide +
                              4 * cells / std::min(options_.max_patches, options_.max_contact_patches);
        const double waits = judges_rest ? std::min(enough, most_waited_for) : 64;
        Contact<T> c = update(stylus);
        for (double n = 1; is_on_its_way(c) && n <= waits; ++n) {
            check_force(c, unlimited);
            c = update(stylus);
        }
        if (c.status == ContactStatus::bad_input) return c;
        if (is_on_its_way(c)) {
            if (judges_rest && waits == enough) note("does not get there");
            return c;
        }
        check_force(c, unlimited);
        // Off a rim in one update, off the surface in the next.
        const bool slid_off =
            c.status == ContactStatus::left_at_border || c.status == ContactStatus::left_at_hole;
        if (slid_off) c = update(stylus);
        for (int n = 0; n < 3; ++n) {
            const Contact<T> again = update(stylus);
            const bool over_surface = !std::isnan(surface_above(stylus));
            if (judges_rest && over_surface && !same(c, again)) note("changes at rest");
            if (judges_rest && again.patches > most_at_rest) note("works hard at rest");
            c = again;
        }
        return c;
    }

    /// The first promise that was broken, and a program that shows it; empty if none was.
    [[nodiscard]] const std::string& fault() const noexcept { return fault_; }

    /// To be told when a sample was edited.
    void edited() { holes_ = !without_holes(*terrain_); }

    /// A moment to come back to: the tracker's state, and the contact with which it came there.
    struct Moment {
        typename ProxyTracker<Field>::State state{};
        Contact<T> contact{};
        GlideState<T> glide{};
    };
    [[nodiscard]] const Moment& now() const noexcept { return now_; }
    void go_back_to(const Moment& moment) noexcept {
        now_ = moment;
        tracker_.restore(moment.state);
        glide_.restore(moment.glide);
    }
    void reset() noexcept {
        now_ = {};
        tracker_.reset();
        glide_.reset();
    }
    [[nodiscard]] const ProxyTracker<Field>& tracker() const noexcept { return tracker_; }

    /// The surface over the stylus, in metres above it; NaN outside the grid and over a hole.
    [[nodiscard]] Wide surface_above(const vec3<T>& stylus) const {
        const Place at = place_of(stylus);
        const Wide last_column = static_cast<Wide>(terrain_->columns - 1),
                   last_row = static_cast<Wide>(terrain_->rows - 1);
        constexpr Wide hair = 1e-6L; // of a cell, from the rim
        if (!(at.column > hair && at.column < last_column - hair && at.row > hair &&
              at.row < last_row - hair))
            return nothing;
        const WidePatch p = patch(at.i, at.j);
        return p.height(at.column - static_cast<Wide>(at.i), at.row - static_cast<Wide>(at.j)) -
               static_cast<Wide>(stylus.z);
    }
    /// How far roundings may lift or lower the surface over the stylus: those of its place and of the heights, of the cell
    /// it is over and of those whose line it is on but for roundings; and those that make no depth.
    [[nodiscard]] Wide roundings(const vec3<T>& stylus) const {
        const Place at = place_of(stylus);
        constexpr Wide near = 1e-5L;
        const Wide u = at.column - static_cast<Wide>(at.i), v = at.row - static_cast<Wide>(at.j);
        const Wide x = std::abs(static_cast<Wide>(stylus.x)) / dx(),
                   y = std::abs(static_cast<Wide>(stylus.y)) / dy();
        Wide most = 0, top = std::abs(static_cast<Wide>(stylus.z));
        for (Index j = v < near ? at.j - 1 : at.j; j <= (v > 1 - near ? at.j + 1 : at.j); ++j) {
            for (Index i = u < near ? at.i - 1 : at.i; i <= (u > 1 - near ? at.i + 1 : at.i); ++i) {
                if (i < 0 || j < 0 || i + 1 >= terrain_->columns || j + 1 >= terrain_->rows) continue;
                const WidePatch p = patch(i, j);
                const Wide along_x = std::max(std::abs(p.along_u(0)), std::abs(p.along_u(1))),
                           along_y = std::max(std::abs(p.along_v(0)), std::abs(p.along_v(1)));
                top = std::max({top, std::abs(p.lowest()), std::abs(p.highest())});
                most = std::max(most, along_x * (1 + x) + along_y * (1 + y));
            }
        }
        return 64 * static_cast<Wide>(epsilon<T>) * (top + most) + no_square<T>;
    }

private:
    static constexpr Wide nothing = std::numeric_limits<Wide>::quiet_NaN();
    static constexpr int most_at_rest = 64; // patches: some casts from the proxy and looks around it
    static constexpr double most_waited_for = 50'000; // updates: a slow glide over cliffs takes millions

    /// How an update with all the work it wants ends at rest.
    struct Unlimited {
        Contact<T> contact;
        int patches = 0; // on the way
    };
    struct Place {
        Wide column, row;
        Index i, j;
    };

    [[nodiscard]] static bool is_on_its_way(const Contact<T>& c) noexcept {
        return c.status == ContactStatus::sweep_limit || c.status == ContactStatus::descent_limit;
    }
    [[nodiscard]] static bool same(const Contact<T>& a, const Contact<T>& b) noexcept {
        return a.status == b.status && a.side == b.side && a.proxy == b.proxy && a.normal == b.normal &&
               a.penetration == b.penetration && a.point.cell == b.point.cell && a.point.u == b.point.u &&
               a.point.v == b.point.v;
    }

    [[nodiscard]] Wide dx() const { return static_cast<Wide>(terrain_->frame.spacing.x); }
    [[nodiscard]] Wide dy() const { return static_cast<Wide>(terrain_->frame.spacing.y); }
    [[nodiscard]] Place place_of(const vec3<T>& p) const {
        const Wide column = (static_cast<Wide>(p.x) - static_cast<Wide>(terrain_->frame.origin.x)) / dx(),
                   row = (static_cast<Wide>(p.y) - static_cast<Wide>(terrain_->frame.origin.y)) / dy();
        const auto cell = [](Wide x, Index samples) {
            return static_cast<Index>(std::clamp(x, Wide(0), static_cast<Wide>(samples - 2)));
        };
        return {column, row, cell(column, terrain_->columns), cell(row, terrain_->rows)};
    }
    [[nodiscard]] WidePatch patch(Index i, Index j) const {
        const auto sample = [&](Index m, Index n) {
            const T height = terrain_->at(m, n);
            return std::abs(height) < no_height_from<T> ? static_cast<Wide>(height) : nothing;
        };
        return {sample(i, j), sample(i + 1, j), sample(i, j + 1), sample(i + 1, j + 1), dx(), dy()};
    }

    [[nodiscard]] bool glides() const { return glide_speed_ > 0; }

    [[nodiscard]] const char* judge() const {
        const Contact<T>& c = last_;
        if (!is_finite(c.proxy) || !is_finite(c.normal) || !is_finite(c.penetration) || !is_finite(c.depth))
            return "not finite";
        const int allowed = (glides() ? 2 : 1) * (options_.max_patches + 16);
        if (c.patches > allowed) return "more work than was allowed";
        if (field_.looks() > 4L * allowed) return "more looks than were allowed";
        const bool felt = c.touching() && c.depth > 0;
        if (before_.contact.touching() && !felt && !holes_ && c.status != ContactStatus::bad_input) {
            const Wide over = surface_above(stylus_),
                       inside = before_.contact.side == Side::below ? -over : over;
            if (inside > 0 && inside > roundings(stylus_)) return "dropped";
        }
        return nullptr;
    }

    /// From the same state, with all the work it wants, until it rests.
    [[nodiscard]] Unlimited settle(const vec3<T>& stylus) {
        ProxyTracker<Field> twin{field_, {.surface = options_.surface}};
        twin.restore(now_.state);
        Unlimited found;
        // On cliffs Newton's method takes more steps than an update has.
        for (int n = 0; n < 3 || (judges_rest && is_on_its_way(found.contact) && n < 100); ++n) {
            found.contact = twin.update(stylus);
            found.patches += found.contact.patches;
        }
        return found;
    }
    /// On its way too: but not off the rim of the grid or of a hole, and for a stylus on the surface but for roundings both
    /// are right. A face holds a stylus that is inside of it as long as the proxy slides over it.
    void check_force(const Contact<T>& c, const Unlimited& unlimited) {
        if (!judges_rest || unlimited.contact.depth > 0 || is_on_its_way(unlimited.contact)) return;
        const Wide over = surface_above(stylus_), unseen = std::isnan(over) ? Wide(0) : roundings(stylus_);
        const bool held = dot(wide(c.penetration), wide(c.normal)) > 0;
        if (is_on_its_way(c) && (holes_ || held || std::isnan(over) || std::abs(over) <= unseen)) return;
        const Wide of_the_proxy = c.depth > 0 ? roundings(c.proxy) : Wide(0);
        if (static_cast<Wide>(c.depth) > std::max(unseen, of_the_proxy))
            note("a force where unlimited work gives none");
    }
    /// From the proxy, in plan, as far as that is over the grid.
    [[nodiscard]] double cells_to(const vec3<T>& stylus) const {
        const glm::dvec3 way = glm::dvec3{stylus} - glm::dvec3{now_.contact.proxy};
        const double cells =
            std::abs(way.x) / terrain_->frame.spacing.x + std::abs(way.y) / terrain_->frame.spacing.y;
        return std::min(cells, static_cast<double>(terrain_->columns + terrain_->rows));
    }

    /// Keeps the first fault, with the last update as lines of C++ that show it again.
    void note(const char* what) {
        if (!fault_.empty()) return;
        const auto add = [&](auto... parts) { ((fault_ += parts), ...); };
        const auto number = [](auto x) {
            char text[40];
            std::snprintf(text, sizeof text, is_finite(x) ? "%a" : "NAN", static_cast<double>(x));
            return std::string{text};
        };
        const auto whole = [](auto n) { return std::to_string(n); };
        const std::string scalar = sizeof(T) == 4 ? "float" : "double";
        const auto& f = terrain_->frame;
        add(what, ":\nstatic const ", scalar, " h[]{");
        for (const T height : terrain_->heights) add(number(height), ", ");
        add("};\nHeightView view{h, ", whole(terrain_->columns), ", ", whole(terrain_->rows), "};\n");
        add("BilinearGrid<", scalar, ", decltype(view)> grid{view, {.origin = {", number(f.origin.x), ", ",
            number(f.origin.y), "}, .spacing = {", number(f.spacing.x), ", ", number(f.spacing.y), "}}};\n");
        add("ProxyTracker tracker{grid, {.surface = SurfaceKind::",
            options_.surface == SurfaceKind::solid ? "solid" : "sheet",
            ", .max_patches = ", whole(options_.max_patches),
            ", .max_contact_patches = ", whole(options_.max_contact_patches), "}};\n");
        if (glides())
            add("ProxyGlide<", scalar, "> glide{", number(glide_speed_), "}; // proxy in cell ",
                whole(before_.glide.proxy.cell.i), ' ', whole(before_.glide.proxy.cell.j), " at ",
                number(before_.glide.proxy.u), ' ', number(before_.glide.proxy.v), '\n');
        add("tracker.restore(std::bit_cast<TrackerState<", scalar, ">>(std::to_array<unsigned char>({");
        for (const auto byte : std::bit_cast<std::array<unsigned char, sizeof before_.state>>(before_.state))
            add(whole(int{byte}), ", ");
        add("})));\n(void)tracker.update({", number(stylus_.x), ", ", number(stylus_.y), ", ",
            number(stylus_.z), "}); // ", to_string(last_.status), ", depth ", digits(last_.depth), ", ",
            whole(last_.patches), " patches, ", whole(field_.looks()), " looks");
    }

    const Terrain<T>* terrain_;
    TrackerOptions options_;
    Grid grid_;
    Field field_{grid_};
    double glide_speed_; // 0: none
    ProxyTracker<Field> tracker_{field_, options_};
    ProxyGlide<T> glide_{glide_speed_, options_.max_patches};
    bool holes_;
    // The last update.
    Moment before_{}, now_{};
    vec3<T> stylus_{T(0)};
    Contact<T> last_{};
    std::string fault_;
};

/// A limit of work: every small one, those between, and none.
[[nodiscard]] inline int any_limit(Random& random) {
    switch (random.whole(0, 3)) {
    case 0: return static_cast<int>(random.whole(1, 4));
    case 1: return static_cast<int>(random.whole(1, 40));
    case 2: return static_cast<int>(log_between(random, 1, 8192));
    default: return TrackerOptions{}.max_patches;
    }
}

/// The speed of a glide: none as often as one, from that of a patch an update to a sixteenth of it.
template <Real T>
[[nodiscard]] double any_glide_speed(Random& random, const Terrain<T>& terrain) {
    return random.one_in(2) ? 0 : longest_patch(terrain) / static_cast<double>(random.whole(1, 16));
}

/// How the height of a stroke goes.
enum class Way { level, at_random, waving, adrift, falling, on_the_surface, keeping_height };

/// The next height, in metres, of a stylus at `z` over a surface at `surface`, `deep` below it or so, after a motion in plan of
/// `moved`. `phase`: of a wave, in radians.
template <Real T>
[[nodiscard]] double next_height(Way way, double z, double surface, double deep, double moved, double phase,
                                 double cell, Random& random) {
    switch (way) {
    case Way::level: return surface - deep;
    case Way::at_random: return surface + deep * random.between(-1, 1);
    case Way::waving: return surface - deep * std::sin(phase);
    case Way::adrift: return z + moved * random.between(-1, 1);
    case Way::falling: return z - moved / 2;
    case Way::on_the_surface:
        return surface + static_cast<double>(epsilon<T>) * (std::abs(surface) + cell) *
                             static_cast<double>(random.whole(-6, 2));
    case Way::keeping_height: break;
    }
    return z;
}

/// Some strokes of a hand that follows the ground, presses, falls, rocks by roundings and stops. Never leaves the grid. Ends
/// at the first fault.
template <Real T>
void stroke_about(LimitedWork<T>& work, const Terrain<T>& ground, Random& random) {
    const auto& f = ground.frame;
    const double dx = f.spacing.x, columns = static_cast<double>(ground.columns - 1),
                 rows = static_cast<double>(ground.rows - 1);
    const double highest = sizeof(T) == 4 ? 1e9 : 1e70; // what a tracker takes, with room to spare
    double top = -highest;
    for (const T height : ground.heights) {
        if (std::abs(height) < no_height_from<T>) top = std::max(top, static_cast<double>(height));
    }
    double x = columns * random.between(0.1, 0.9), y = rows * random.between(0.1, 0.9),
           z = std::min(top + dx * log_between(random, 0.01, 10), highest), surface = z;
    const auto here = [&] {
        return vec3<T>{static_cast<T>(f.origin.x + x * dx), static_cast<T>(f.origin.y + y * f.spacing.y),
                       static_cast<T>(std::clamp(z, -highest, highest))};
    };
    work.update(here());
    for (auto strokes = random.whole(1, 6); strokes > 0; --strokes) {
        const auto way = static_cast<Way>(random.whole(0, 6));
        const double step = random.one_in(6) ? 4 * static_cast<double>(epsilon<T>)
                                             : log_between(random, 1e-3, random.one_in(10) ? 100 : 5),
                     deep = dx * log_between(random, 1e-4, 20), turn = random.between(0, 2),
                     rhythm = random.between(0, 0.5);
        double heading = random.between(0, 6.283185307);
        for (auto n = random.whole(5, 60); n > 0; --n) {
            if (!work.fault().empty()) return;
            heading += turn * random.between(-1, 1);
            const double far = step * random.unit();
            x += far * std::cos(heading), y += far * std::sin(heading);
            // On a grid line, but for roundings.
            const auto beside = [&] {
                return 1 + static_cast<double>(epsilon<T>) * static_cast<double>(random.whole(-3, 3));
            };
            if (random.one_in(20)) x = std::round(x) * beside();
            if (random.one_in(20)) y = std::round(y) * beside();
            x = std::clamp(x, 0.01, columns - 0.01), y = std::clamp(y, 0.01, rows - 0.01);
            if (const Wide above = work.surface_above(here()); !std::isnan(above))
                surface = static_cast<double>(above) + static_cast<double>(here().z);
            z = next_height<T>(way, z, surface, deep, dx * far, static_cast<double>(n) * rhythm, dx, random);
            const auto contact = work.update(here());
            const bool on_its_way = contact.status == ContactStatus::sweep_limit ||
                                    contact.status == ContactStatus::descent_limit;
            if (random.one_in(on_its_way ? 4 : 25)) {
                const auto moment = work.now();
                work.rest(here());
                if (!random.one_in(3)) work.go_back_to(moment);
            }
        }
    }
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_LIMITED_WORK_HPP
