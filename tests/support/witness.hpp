#ifndef HFH_TESTS_SUPPORT_WITNESS_HPP
#define HFH_TESTS_SUPPORT_WITNESS_HPP

#include "reference.hpp"

#include <hfh/contact/proxy_glide.hpp>
#include <hfh/contact/proxy_tracker.hpp>

#include <optional>
#include <string>

// Watches a tracker from outside and says where it breaks its promises. Knows the terrain, the stylus and what update
// returned; asks the library nothing.

namespace hfh::test {

template <Real T>
class Witness {
public:
    using Grid = typename Terrain<T>::Grid;

    /// With a glide behind the tracker, if that has a speed.
    explicit Witness(const Terrain<T>& terrain, const TrackerOptions& options = {}, double glide_speed = 0)
        : surface{terrain}, grid{terrain.grid()}, tracker{grid, options}, glide_{glide_speed},
          glides_{glide_speed > 0}, options_{options} {
        holes_ = !without_holes(terrain);
    }
    Witness(const Witness&) = delete;
    Witness& operator=(const Witness&) = delete;

    const Surface<T> surface;
    const Grid grid;
    ProxyTracker<Grid> tracker;

    int updates = 0, contacts = 0, most_patches = 0, faults = 0;
    int dropped = 0;         ///< of the faults
    std::string first_fault; ///< with the two last positions and the proxy before, to be found again

    /// An update of the tracker, judged.
    Contact<T> update(const vec3<T>& stylus) {
        const Contact<T> contact = glide_.follow(grid, tracker.update(stylus), stylus);
        ++updates;
        contacts += contact.touching();
        most_patches = std::max(most_patches, contact.patches);
        std::string what = judge(stylus, contact);
        if (before_.touching() && is_dropped(stylus, contact)) {
            ++dropped;
            what = "dropped";
        }
        if (!what.empty() && faults++ == 0) {
            first_fault = what + ": update " + std::to_string(updates) + ", stylus " + digits(last_) +
                          " -> " + digits(stylus) + ", " + to_string(contact.status) + ", proxy before " +
                          (before_.touching() ? "cell " + std::to_string(before_.point.cell.i) + ' ' +
                                                    std::to_string(before_.point.cell.j) + " at " +
                                                    digits(before_.point.u) + ' ' + digits(before_.point.v)
                                              : std::string{"none"}) +
                          ", point now cell " + std::to_string(contact.point.cell.i) + ' ' +
                          std::to_string(contact.point.cell.j) + " at " + digits(contact.point.u) + ' ' +
                          digits(contact.point.v);
        }
        last_ = stylus;
        before_ = contact;
        return contact;
    }

    /// Both forget the stylus.
    void reset() {
        tracker.reset();
        glide_.reset();
        outside_ = false;
        before_ = {};
        side_ = Side::none;
    }

private:
    /// Whether an update may end before its work is done: never with what is allowed by default, and else not before the
    /// work of one in which the stylus rests; with a glide at any time.
    [[nodiscard]] bool may_stop(int patches) const {
        if (glides_) return true;
        const TrackerOptions ample;
        const bool limited = options_.max_patches < ample.max_patches ||
                             options_.max_contact_patches < ample.max_contact_patches;
        return limited && patches >= std::min(options_.max_contact_patches, options_.max_patches);
    }

    /// On ground without holes, within its rim: in contact before, the surface over it (felt from below: under it) by more
    /// than roundings, and no force.
    [[nodiscard]] bool is_dropped(const vec3<T>& stylus, const Contact<T>& c) const {
        if (holes_ || (c.touching() && c.depth > 0)) return false;
        const Point q = wide(stylus);
        const auto under = surface.under(q.x, q.y);
        if (!under || !strictly_over(q)) return false;
        const Wide over = surface.patch(under->i, under->j)->height(under->u, under->v) - q.z;
        const Wide inside = before_.side == Side::below ? -over : over;
        return inside > 32 * surface.blur(*under, q, static_cast<Wide>(epsilon<T>));
    }

    [[nodiscard]] std::string judge(const vec3<T>& stylus, const Contact<T>& c) {
        const Place at = place_of(wide(stylus));
        const bool was_outside = outside_;
        const Side was_side = side_;
        // Behind a hole the side is decided afresh, by a height that may be zero but for roundings. Where the lattice is in
        // float these are centimetres on cliffs: a stylus nearer to the surface than that is on the side that the tracker tells.
        const bool decided_afresh =
            !std::is_same_v<PlaceScalar<T>, double> && c.side == Side::below && !all_over_surface(at.q);
        outside_ = at.under && ((was_outside && c.touching()) || at.above > at.tolerance ||
                                (was_outside && at.above >= -at.tolerance && !decided_afresh));
        side_ = !at.under ? Side::none : c.side;

        if (!is_finite(c.proxy) || !is_finite(c.normal) || !is_finite(c.penetration) || !is_finite(c.depth)) {
            return "not finite";
        }
        if (c.status == ContactStatus::bad_input) return "refused";
        if (const std::string fault = judge_work(at.q, c); !fault.empty()) return fault;
        if (c.touching() != tracker.state().touching()) return "the state remembers something else";
        if (c.touching()) {
            if (std::string fault = judge_proxy(at, c); !fault.empty()) return fault;
            return c.status == ContactStatus::contact ? judge_minimum(at.q, c)
                   : may_stop(c.patches)              ? std::string{}
                                                      : "ran out of work";
        }
        if (c.proxy != stylus || c.penetration != vec3<T>{T(0)} || c.depth != 0 ||
            c.normal != vec3<T>{0, 0, 1}) {
            return "not touching, but something is felt";
        }
        return judge_apart(at, c, was_outside, was_side);
    }

    /// Where a stylus is: what is under it, and how far above that it is, to within `tolerance`.
    struct Place {
        Point q;
        std::optional<WideSurfacePoint> under;
        Wide tolerance, above; ///< metres; 0 over nothing
    };
    [[nodiscard]] Place place_of(const Point& q) const {
        const auto under = surface.under(
            q.x, q.y, Wide(1e-12L) * (1 + std::abs(surface.column_of(q.x)) + std::abs(surface.row_of(q.y))));
        if (!under) return {q, under, Wide(0), Wide(0)};
        // Sides are decided in what the lattice computes in, from numbers that are exact: a few roundings.
        return {q, under, 32 * surface.blur(*under, q, static_cast<Wide>(epsilon<PlaceScalar<T>>)),
                q.z - surface.patch(under->i, under->j)->height(under->u, under->v)};
    }

    [[nodiscard]] std::string judge_work(const Point& q, const Contact<T>& c) const {
        if (c.patches > options_.max_patches + 16) return "more work than was allowed";
        if (before_.touching()) {
            // The slide, and the casts that tell whether the stylus is free: from the proxy, each shorter than the last.
            const Wide moved = cells_apart(q, wide(last_));
            const Wide to_cast = cells_apart(q, wide(before_.proxy));
            if (static_cast<Wide>(c.patches) > static_cast<Wide>(options_.max_contact_patches) + 2 * moved +
                                                   4 * (1 + to_cast) + 16 + (glides_ ? 64 : 0)) {
                return "more work than was allowed in contact";
            }
        }
        return {};
    }

    /// Where the proxy is, its normal, and what is felt.
    [[nodiscard]] std::string judge_proxy(const Place& place, const Contact<T>& c) const {
        const WideSurfacePoint at = wide(c.point);
        const auto& [q, under, tolerance, above] = place;
        const Wide eps = static_cast<Wide>(epsilon<T>);
        const bool solid = options_.surface == SurfaceKind::solid;
        if (!(at.u >= 0 && at.u <= 1 && at.v >= 0 && at.v <= 1)) return "proxy outside its cell";
        if (!surface.patch(at.i, at.j)) return "proxy on no patch";
        if (c.side == Side::none || (solid && c.side != Side::above)) return "felt from no side";
        const Point proxy = surface.position(at), offset = proxy - q;
        const Wide blur = proxy_blur(at, q, proxy, eps);
        if (length(wide(c.proxy) - proxy) > 16 * blur) return "proxy off the surface";
        const Point n = surface.normal(at);
        const Wide sign = c.side == Side::below ? Wide(-1) : Wide(1);
        if (length(wide(c.normal) - Point{sign * n.x, sign * n.y, sign * n.z}) > 32 * eps)
            return "wrong normal";
        const Point penetration = wide(c.penetration);
        if (c.depth > 0 && length(penetration - offset) > 16 * blur)
            return "penetration is not proxy - stylus";
        if (std::abs(length(penetration) - static_cast<Wide>(c.depth)) >
            8 * eps * length(penetration) + std::sqrt(static_cast<Wide>(std::numeric_limits<T>::min()))) {
            return "depth is not the length of penetration";
        }
        // At a vertex among patches of very different slopes the averaged normal may be wrong about inside and
        // outside. The way from the proxy to the stylus tells: it goes in at once.
        // A proxy on its way may be anywhere: what counts is that the stylus has the surface over it.
        const bool gliding = c.status == ContactStatus::descent_limit;
        const bool covered = gliding && under && sign * above < tolerance;
        if (c.depth > 0 && sign * dot(offset, n) < -16 * blur && !covered && !goes_in(proxy, q, sign))
            return "pulls towards the surface";
        if (gliding && under && sign * above < -std::max(tolerance, 32 * surface.blur(*under, q, eps)) &&
            !(c.depth > 0))
            return "nothing felt on the way, though the stylus is inside";
        return {};
    }

    /// At the end of a slide.
    [[nodiscard]] std::string judge_minimum(const Point& q, const Contact<T>& c) const {
        const WideSurfacePoint at = wide(c.point);
        const Wide eps = static_cast<Wide>(epsilon<T>);
        const Point proxy = surface.position(at), offset = proxy - q;
        if (!(c.depth > 0) && length(offset) > 64 * proxy_blur(at, q, proxy, eps))
            return "in contact without penetration";
        const Wide fall = surface.template fall<T>(at, q);
        if (fall > 64)
            return "a patch leads down: " + std::to_string(static_cast<double>(fall)) + " ulp-scales";
        return {};
    }
    /// Metres, by which a proxy and its offset may be wrong.
    [[nodiscard]] Wide proxy_blur(const WideSurfacePoint& at, const Point& q, const Point& proxy,
                                  Wide eps) const {
        return surface.blur(at, q, eps) + surface.blur(at, proxy, eps) +
               eps * (std::abs(q.x) + std::abs(q.y) + surface.dx() + surface.dy());
    }

    /// Not in contact: whether the status fits the place.
    [[nodiscard]] std::string judge_apart(const Place& place, const Contact<T>& c, bool was_outside,
                                          Side was_side) const {
        const auto& [q, under, tolerance, above] = place;
        const bool solid = options_.surface == SurfaceKind::solid;
        switch (c.status) {
        case ContactStatus::sweep_limit: return may_stop(c.patches) ? "" : "ran out of work";
        case ContactStatus::free:
            if (!under) return "free over nothing";
            if (solid && above < -tolerance) return "free below the surface";
            if (!solid && (c.side == Side::above ? above < -tolerance : above > tolerance))
                return "on the other side";
            if (!solid && was_side != Side::none && c.side != was_side && all_over_surface(q)) {
                return "through the sheet";
            }
            return {};
        case ContactStatus::buried:
            if (!solid || !under || above > tolerance) return "buried, but not below the surface";
            if (was_outside && all_over_surface(q)) return "buried after having been outside";
            return {};
        case ContactStatus::off_surface: return under && strictly_over(q) ? "off_surface over a patch" : "";
        case ContactStatus::left_at_border:
            return under && strictly_over(q) ? "slid off the border while over the surface" : "";
        case ContactStatus::left_at_hole: return holes_ ? "" : "slid off a hole that is not there";
        default: return "impossible status";
        }
    }

    /// Whether the segment from the proxy leads below the surface (sign 1; above it: −1) over its first hundredth of a
    /// cell.
    [[nodiscard]] bool goes_in(const Point& proxy, const Point& to, Wide sign) const {
        const Wide cells =
            std::max(std::abs(to.x - proxy.x) / surface.dx(), std::abs(to.y - proxy.y) / surface.dy());
        for (const Wide part : {0.01L, 0.003L, 0.001L}) {
            const Wide t = std::min(part / std::max(cells, Wide(1e-9L)), part);
            const auto z = surface.height(proxy.x + t * (to.x - proxy.x), proxy.y + t * (to.y - proxy.y));
            if (!z || sign * (proxy.z + t * (to.z - proxy.z) - *z) >= 0) return false;
        }
        return true;
    }
    /// In plan, along the longer axis.
    [[nodiscard]] Wide cells_apart(const Point& a, const Point& b) const {
        return std::max(std::abs(a.x - b.x) / surface.dx(), std::abs(a.y - b.y) / surface.dy());
    }
    /// Over a patch and not on its rim.
    [[nodiscard]] bool strictly_over(const Point& q) const {
        const auto s = surface.under(q.x, q.y);
        return s && surface.missing_at(*s) == 0 && s->u > 1e-9L && s->u < 1 - 1e-9L && s->v > 1e-9L &&
               s->v < 1 - 1e-9L;
    }

    /// Whether the promise holds that a stylus outside does not get below unfelt: between the last position and this one
    /// there was surface all the way. Among holes that holds while the stylus is free only, for the proxy goes its own
    /// way, and so does a search that has not got to the stylus.
    [[nodiscard]] bool all_over_surface(const Point& to) const {
        if (!holes_) return true;
        if (before_.touching() || before_.status == ContactStatus::sweep_limit) return false;
        const Point from = wide(last_);
        for (int k = 0; k <= 1000; ++k) {
            const Wide t = Wide(k) / 1000;
            const auto s = surface.under(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y));
            if (!s || surface.missing_at(*s) > 0) return false;
        }
        return true;
    }

    ProxyGlide<T> glide_;
    bool glides_;
    TrackerOptions options_;
    bool holes_ = false;
    Contact<T> before_{};
    vec3<T> last_{T(0)};
    bool outside_ = false;   // has been above the surface, and over it ever since
    Side side_ = Side::none; // sheet: the side it was on, over the surface
};

/// A hand that does all a hand can do: slides, presses, swipes, leaves the terrain and comes back.
template <Real T>
class Hand {
public:
    Hand(const Terrain<T>& terrain, std::uint64_t seed, double longest_swipe = 100)
        : terrain_{&terrain}, surface_{terrain}, random_{seed}, longest_swipe_{longest_swipe} {
        x_ = random_.between(0, columns());
        y_ = random_.between(0, rows());
    }

    /// The next position.
    [[nodiscard]] vec3<T> next() {
        if (left_ == 0) choose();
        --left_;
        heading_ += random_.between(-0.3, 0.3);
        double step = step_ * random_.unit();
        if (mode_ == Mode::swipe) heading_ += random_.between(-1, 1);
        x_ += step * std::cos(heading_);
        y_ += step * std::sin(heading_);
        if (mode_ != Mode::leave) {
            if (x_ < 0 || x_ > columns()) heading_ = 3.14159265 - heading_;
            if (y_ < 0 || y_ > rows()) heading_ = -heading_;
            x_ = std::clamp(x_, 0.0, columns());
            y_ = std::clamp(y_, 0.0, rows());
        } else {
            x_ = std::clamp(x_, -3.0, columns() + 3);
            y_ = std::clamp(y_, -3.0, rows() + 3);
        }
        if (mode_ == Mode::press || mode_ == Mode::swipe) offset_ = deep_ * random_.between(-1, 0.5);
        return here();
    }

private:
    enum class Mode { slide, press, swipe, leave };

    void choose() {
        const auto n = random_.whole(0, 9);
        mode_ = n < 5 ? Mode::slide : n < 8 ? Mode::press : n < 9 ? Mode::swipe : Mode::leave;
        left_ = static_cast<int>(mode_ == Mode::swipe ? random_.whole(2, 8) : random_.whole(10, 60));
        step_ = mode_ == Mode::swipe   ? longest_swipe_ * random_.unit()
                : mode_ == Mode::press ? 0.05
                : mode_ == Mode::leave ? 2.0
                                       : 0.05 * std::pow(40, random_.unit());
        deep_ = 0.01 * std::pow(500, random_.unit());
        offset_ = random_.one_in(6) ? deep_ : -deep_;
        heading_ = random_.between(0, 6.283185307);
        if (mode_ == Mode::leave) { // off over the nearest border
            heading_ = x_ < columns() - x_ ? 3.14159265 : 0.0;
            left_ = 40;
        }
    }
    [[nodiscard]] double columns() const { return static_cast<double>(terrain_->columns - 1); }
    [[nodiscard]] double rows() const { return static_cast<double>(terrain_->rows - 1); }
    [[nodiscard]] vec3<T> here() {
        const auto& f = terrain_->frame;
        const double x = f.origin.x + x_ * f.spacing.x, y = f.origin.y + y_ * f.spacing.y;
        if (const auto z = surface_.height(static_cast<Wide>(x), static_cast<Wide>(y)))
            ground_ = static_cast<double>(*z);
        return {static_cast<T>(x), static_cast<T>(y), static_cast<T>(ground_ + offset_ * f.spacing.x)};
    }

    const Terrain<T>* terrain_;
    Surface<T> surface_;
    Random random_;
    double longest_swipe_;
    double x_ = 0, y_ = 0, heading_ = 0, step_ = 0, deep_ = 0, offset_ = 1,
           ground_ = 0; // in cells; ground in metres
    int left_ = 0;
    Mode mode_ = Mode::slide;
};

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_WITNESS_HPP
