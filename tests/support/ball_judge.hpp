#ifndef HFH_TESTS_SUPPORT_BALL_JUDGE_HPP
#define HFH_TESTS_SUPPORT_BALL_JUDGE_HPP

#include "ball_surface.hpp"

#include <hfh/contact/ball_contact.hpp>

#include <string>

// Judges the updates of a ball from outside: by every patch in reach, in long double. Of what is judged it takes the
// result alone.

namespace hfh::test {

/// What is promised of a ball's contact in T, as shares of the radius and of the penetration depth.
template <Real T>
struct BallPromise {
    static constexpr bool narrow = std::is_same_v<T, float>;
    static constexpr Wide penetration = narrow ? 1e-4L : 1e-9L;
    static constexpr Wide residual = narrow ? 1e-2L : 1e-6L;
    /// Between the ball and a point that it is said to touch, of r. A force that is turned by the residual stands for a
    /// centre that is as far from its place, as a share of r: this is a tenth of it.
    static constexpr Wide gap = residual / 10;
    /// Of the largest coordinate, in metres.
    [[nodiscard]] static Wide roundings(Wide coordinate) {
        return 4 * static_cast<Wide>(epsilon<T>) * coordinate;
    }
};

/// The centre of a result, as exactly as the result tells it.
template <Real T>
[[nodiscard]] Point centre_of(const vec3<T>& stylus, const BallContact<T>& found) {
    if (!found.touching()) return wide(stylus);
    return found.depth > 0 ? wide(stylus) + wide(found.penetration) : wide(found.proxy);
}

/// One update: where the ball was, where the stylus is now, and what was found.
template <Real T>
struct BallUpdate {
    std::optional<Point> last_centre{}; ///< none: the first update, or ground or radius have changed since
    ContactStatus last_status = ContactStatus::free;
    vec3<T> stylus{T(0)};
    BallContact<T> found{};
    Wide radius = 1;
    SurfaceKind kind = SurfaceKind::solid;
};

/// What was found wrong; empty if nothing. The rest is measured where the ball is in contact.
struct BallVerdict {
    std::string fault;
    Wide penetration = 0; ///< as a share of the radius
    Wide residual = 0;    ///< as a share of the depth
    bool narrow = false;  ///< at a minimum that ends within 10⁻³ r
};

template <Real T>
class BallJudge {
public:
    explicit BallJudge(const Terrain<T>& terrain) : ground_{terrain} {}

    [[nodiscard]] const BallSurface<T>& ground() const { return ground_; }

    [[nodiscard]] BallVerdict operator()(const BallUpdate<T>& update) const {
        BallVerdict verdict;
        const BallContact<T>& found = update.found;
        if (!is_number(found)) {
            verdict.fault = "not a number";
        } else if (found.touching()) {
            judge_contact(update, verdict);
            if (verdict.fault.empty() && found.side == Side::none)
                verdict.fault = "in contact from no side: 0";
        } else {
            judge_freedom(update, verdict);
        }
        return verdict;
    }

    /// Residual of a force, from the stylus to the centre, in the cone of the normals of what the ball touches there: the length
    /// of what is left, in metres. `slack`: by how much a touching point may be farther away than the radius.
    [[nodiscard]] Wide residual(const Point& centre, const Point& stylus, Wide radius, Wide slack) const {
        std::vector<HalfSpace> cone;
        for (const BallFoot& foot : ground_.feet(centre, radius + slack)) cone.push_back({foot.normal(), 0});
        const auto left = nearest_in(cone, stylus - centre);
        return left ? length(left->at) : Wide(0);
    }

    /// By how much the ball gets nearer to the stylus when it is moved by `step` in one of 16 directions across the force, lowered
    /// by a tenth of that and pushed clear, beyond what a residual of `slope` would give: in metres, and not less than
    /// zero. It is compared with the ball that is pushed clear at its place. The mean of opposite ways,
    /// in which the slope cancels, is looked at as well: it is at least as far as the place between them but for what a
    /// curvature of 0.001/r makes.
    [[nodiscard]] Wide gain_nearby(const Point& centre, const Point& stylus, Wide radius, Wide slope,
                                   Wide step) const {
        const Point force = centre - stylus;
        const Wide depth = length(force);
        if (!(depth > 10 * step)) return 0;
        const Nearby nearby{ground_, centre, radius, 20 * step};
        const Point down = (-1 / depth) * force;
        const Point aside = std::abs(down.z) < 0.5L ? Point{0, 0, 1} : Point{1, 0, 0};
        Point one = cross_product(down, aside);
        one = (1 / length(one)) * one;
        const Point other = cross_product(down, one);
        const auto after = [&](const Point& moved) -> std::optional<Wide> {
            const auto to = nearby.pushed_clear(moved);
            return to ? std::optional{length(*to - (stylus - centre))} : std::nullopt;
        };
        const Point dip = step / 10 * down;
        const auto clear = after({}), lowered = after(dip);
        if (!clear || !lowered) return 0;
        const Wide here = std::min(*clear, *lowered);
        Wide gain = 0;
        constexpr int pairs = 8;
        for (int k = 0; k < pairs; ++k) {
            const Wide angle = static_cast<Wide>(k) * 3.14159265358979323846L / pairs;
            const Point way = std::cos(angle) * one + std::sin(angle) * other;
            const auto to = after(dip + step * way), fro = after(dip - step * way);
            const Wide expected = slope * step + 1e-15L * radius,
                       bent = 1e-3L * step * step / radius + 1e-15L * radius;
            if (to) gain = std::max(gain, here - *to - expected);
            if (fro) gain = std::max(gain, here - *fro - expected);
            if (to && fro) gain = std::max(gain, here - (*to + *fro) / 2 - bent);
        }
        return gain;
    }

    /// Whether the ball may have slid to a rim: the centre has stayed as near to the stylus as it was.
    [[nodiscard]] bool may_have_left(const BallUpdate<T>& update) const {
        if (!update.last_centre || !without_holes(ground_.terrain())) return true;
        const Terrain<T>& t = ground_.terrain();
        const glm::dvec2 low = t.low(), high = t.high();
        const Point stylus = wide(update.stylus);
        const Wide reach = length(*update.last_centre - stylus) + update.radius;
        return !(stylus.x - reach > static_cast<Wide>(low.x) && stylus.y - reach > static_cast<Wide>(low.y) &&
                 stylus.x + reach < static_cast<Wide>(high.x) &&
                 stylus.y + reach < static_cast<Wide>(high.y));
    }

private:
    /// The patches that a ball may touch within `most` of its centre, seen from there.
    class Nearby {
    public:
        Nearby(const BallSurface<T>& ground, const Point& centre, Wide radius, Wide most)
            : radius_{radius}, most_{most} {
            const Surface<T>& surface = ground.surface();
            ground.each_foot(centre, radius + most, [&](const BallFoot& foot) {
                const bool known = std::any_of(patches_.begin(), patches_.end(), [&](const Seen& seen) {
                    return seen.i == foot.at.i && seen.j == foot.at.j;
                });
                if (known) return;
                patches_.push_back({*surface.patch(foot.at.i, foot.at.j),
                                    surface.seen_from(centre, foot.at.i, foot.at.j), foot.at.i, foot.at.j});
            });
        }
        /// The centre moved by `way` and out of what the ball overlaps there, seen from the centre. Nothing if that is too far.
        [[nodiscard]] std::optional<Point> pushed_clear(Point way) const {
            std::vector<HalfSpace> spaces;
            for (int n = 0; n < 60; ++n) {
                spaces.clear();
                Wide nearest = radius_;
                for (const Seen& seen : patches_) {
                    each_local_minimum(
                        seen.patch, seen.centre + way, [&](Wide x, Wide y, Wide z, Wide distance) {
                            if (!(distance < radius_ + most_)) return;
                            nearest = std::min(nearest, distance);
                            spaces.push_back({(-1 / distance) * Point{x, y, z}, radius_ - distance});
                        });
                }
                if (!(nearest < radius_ * (1 - 1e-15L))) return way;
                const auto step = nearest_in(spaces, {});
                if (!step || !(length(way + step->at) < most_ / 2)) return {};
                way = way + step->at;
            }
            return {};
        }

    private:
        struct Seen {
            WidePatch patch;
            Point centre;
            Index i, j;
        };
        std::vector<Seen> patches_;
        Wide radius_, most_;
    };

    [[nodiscard]] static bool is_number(const BallContact<T>& c) {
        const auto holds = [](const vec3<T>& p) {
            return holds_number(p.x) && holds_number(p.y) && holds_number(p.z);
        };
        bool all = holds(c.proxy) && holds(c.normal) && holds(c.penetration) && holds_number(c.depth) &&
                   0 <= c.count && c.count <= BallContact<T>::max_touches;
        for (int n = 0; all && n < c.count; ++n)
            all = holds(c.touches[n].normal) && holds_number(c.touches[n].share);
        return all;
    }
    [[nodiscard]] static std::string measured(const char* what, Wide value) {
        char text[120];
        std::snprintf(text, sizeof text, "%s: %.3Lg", what, value);
        return text;
    }

    void judge_contact(const BallUpdate<T>& update, BallVerdict& verdict) const {
        const BallContact<T>& found = update.found;
        const Point stylus = wide(update.stylus), centre = centre_of(update.stylus, found);
        const Wide r = update.radius, depth = length(centre - stylus);
        const Wide roundings =
            BallPromise<T>::roundings(std::max(largest_coordinate(centre), largest_coordinate(stylus)));
        const Wide allowed = BallPromise<T>::penetration * r + roundings;
        const auto fault = [&](const char* what, Wide value) {
            if (verdict.fault.empty()) verdict.fault = measured(what, value);
        };
        if (update.kind == SurfaceKind::solid && found.normal.z < 0 && found.count > 0 && rims_alone(found))
            fault("held by rims alone from above, by a force with z", static_cast<Wide>(found.normal.z));
        const auto nearest = ground_.nearest(centre, r);
        const Wide overlap = nearest ? r - nearest->distance : Wide(0);
        verdict.penetration = overlap / r;
        if (overlap > allowed)
            fault(seen_from_below(centre, r - allowed) ? "penetration from below, at a rim, of r"
                                                       : "penetration, of r",
                  overlap / r);
        judge_side(update, centre, allowed, verdict);
        if (length(wide(found.proxy) - centre) > roundings)
            fault("proxy is not stylus + penetration", length(wide(found.proxy) - centre));
        if (update.last_centre) {
            const Wide farther = depth - length(*update.last_centre - stylus);
            if (farther > allowed) fault("farther than the last centre, by r times", farther / r);
        }
        judge_touches(update, centre, depth, roundings, verdict);
        if (found.status != ContactStatus::contact || !(found.depth > 0)) return; // on its way
        const Wide left = residual(centre, stylus, r, 2 * allowed + BallPromise<T>::gap * r);
        verdict.residual = left / depth;
        if (left > BallPromise<T>::residual * depth + roundings * (1 + depth / r))
            fault("residual, of the depth", left / depth);
        if (!verdict.fault.empty()) return;
        const Wide slope = BallPromise<T>::residual + roundings / r;
        const Wide gain = gain_nearby(centre, stylus, r, slope, 1e-3L * r);
        for (const Wide step : {1e-4L, 1e-5L, 1e-6L, 1e-7L}) {
            if (!(gain > 0) || gain_nearby(centre, stylus, r, slope, step * r) > 0) continue;
            // A minimum all the same, narrower than 10⁻³ r: the gradient flow ends there as well.
            verdict.narrow = true;
            return;
        }
        if (gain > 0) fault("nearer nearby, by r times", gain / r);
    }

    [[nodiscard]] bool rims_alone(const BallContact<T>& found) const {
        bool all = true;
        for (int n = 0; n < found.count; ++n) all = all && ground_.on_rim(wide(found.touches[n].point));
        return all;
    }
    /// Whether all that a ball overlaps lies higher than its centre, as it does where the centre is beside a rim.
    [[nodiscard]] bool seen_from_below(const Point& centre, Wide radius) const {
        bool all = true;
        ground_.each_foot(centre, radius, [&](const BallFoot& foot) { all = all && foot.offset.z > 0; });
        return all;
    }

    void judge_side(const BallUpdate<T>& update, const Point& centre, Wide allowed,
                    BallVerdict& verdict) const {
        if (!verdict.fault.empty() || update.found.side == Side::none) return;
        const Surface<T>& surface = ground_.surface();
        const auto height = surface.height(centre.x, centre.y);
        const bool from_below = update.kind == SurfaceKind::sheet && update.found.side == Side::below;
        // At a rim a rounding decides whether there is ground under it.
        for (const Wide away : {-allowed, allowed}) {
            if (!surface.under(centre.x + away, centre.y) || !surface.under(centre.x, centre.y + away))
                return;
        }
        if (!height) return;
        const Wide below = from_below ? centre.z - *height : *height - centre.z;
        if (below > allowed)
            verdict.fault = measured("centre on the other side, by r times", below / update.radius);
    }

    /// The touches are real, and their shares make up the force.
    void judge_touches(const BallUpdate<T>& update, const Point& centre, Wide depth, Wide roundings,
                       BallVerdict& verdict) const {
        const BallContact<T>& found = update.found;
        const Wide r = update.radius, eps = static_cast<Wide>(epsilon<T>),
                   allowed = BallPromise<T>::penetration * r + roundings;
        const auto fault = [&](const char* what, Wide value) {
            if (verdict.fault.empty()) verdict.fault = measured(what, value);
        };
        if (!(found.depth > 0)) return;
        if (std::abs(static_cast<Wide>(found.depth) - depth) > 8 * eps * depth + roundings)
            fault("depth is not that of the penetration", static_cast<Wide>(found.depth) - depth);
        const Wide apart = length(depth * wide(found.normal) - wide(found.penetration));
        if (apart > 8 * eps * depth + roundings) fault("normal is not that of the force", apart / depth);
        if (found.status == ContactStatus::contact && found.count == 0) fault("no touch", 0);
        Point sum;
        Wide unsure = 0; // of the sum, for what the touches are rounded to
        for (int n = 0; n < found.count; ++n) {
            const BallTouch<T>& touch = found.touches[n];
            const WideSurfacePoint at = wide(touch.point);
            const auto patch = ground_.surface().patch(at.i, at.j);
            if (!patch || !(0 <= at.u && at.u <= 1 && 0 <= at.v && at.v <= 1)) {
                fault("a touch off the surface", static_cast<Wide>(n));
                return;
            }
            // How far a rounding of u and v moves the point.
            const Wide moved = 2 * eps * (patch->dx + patch->dy + patch->highest() - patch->lowest());
            const Point arm = ground_.surface().seen_from(centre, at.i, at.j) - patch->position(at.u, at.v);
            if (found.status == ContactStatus::contact &&
                std::abs(length(arm) - r) > allowed + moved + BallPromise<T>::gap * r)
                fault("a touch that is not at r, off by r times", length(arm) / r - 1);
            const Wide turned = length(r * wide(touch.normal) - arm);
            if (found.status == ContactStatus::contact &&
                turned > 4 * (allowed + moved + BallPromise<T>::gap * r) + 16 * eps * r)
                fault("normal of a touch", turned / r);
            if (!(touch.share >= 0)) fault("a share below zero", static_cast<Wide>(touch.share));
            if (n > 0 && touch.share > found.touches[n - 1].share)
                fault("shares out of order", static_cast<Wide>(n));
            sum = sum + static_cast<Wide>(touch.share) * wide(touch.normal);
            unsure += static_cast<Wide>(touch.share) * (moved / r + 4 * eps);
        }
        if (found.count > 0) {
            const SurfacePoint<T>& first = found.touches[0].point;
            const bool same =
                first.cell == found.point.cell && first.u == found.point.u && first.v == found.point.v;
            if (!same) fault("point is not that of the largest share", 0);
        }
        if (found.status != ContactStatus::contact) return;
        const Wide left = length(sum - wide(found.penetration));
        if (left > BallPromise<T>::residual * depth + allowed + unsure)
            fault("shares do not make up the penetration, left of the depth", left / depth);
    }

    /// Not in contact: the ball at the stylus overlaps nothing of a solid. Rims hold nothing from below, and under
    /// a rim or beside the grid the ball may be anywhere.
    void judge_freedom(const BallUpdate<T>& update, BallVerdict& verdict) const {
        const BallContact<T>& found = update.found;
        if (found.status == ContactStatus::bad_input || found.status == ContactStatus::sweep_limit) return;
        const auto fault = [&](const char* what, Wide value) {
            if (verdict.fault.empty()) verdict.fault = measured(what, value);
        };
        if (found.depth != 0 || found.count != 0)
            fault("a force without contact", static_cast<Wide>(found.depth));
        if (update.kind == SurfaceKind::sheet) return;
        if (found.status != ContactStatus::free) {
            const bool was_outside =
                update.last_centre &&
                (update.last_status == ContactStatus::free || update.last_status == ContactStatus::contact ||
                 update.last_status == ContactStatus::descent_limit);
            const bool may_be = found.status == ContactStatus::buried && !was_outside;
            if (!may_be && !may_have_left(update)) fault("not felt, though no rim is in reach", 0);
            return;
        }
        const Point stylus = wide(update.stylus);
        const Wide r = update.radius;
        const Wide allowed =
            BallPromise<T>::penetration * r + BallPromise<T>::roundings(largest_coordinate(stylus));
        const auto height = ground_.surface().height(stylus.x, stylus.y);
        if (height && *height - stylus.z > allowed)
            fault("free below the ground, by r times", (*height - stylus.z) / r);
        const auto nearest = ground_.nearest(stylus, r - allowed);
        if (!nearest || (nearest->offset.z >= 0 && ground_.on_rim(nearest->at))) return;
        fault("free in the ground, by r times", 1 - nearest->distance / r);
    }
    BallSurface<T> ground_;
};

// The first touch of a moving ball.

/// Whether a ball on the way `from` → `to` is clear of the surface up to t.
enum class SweepVerdict : unsigned char {
    right,
    starts_in_the_surface, ///< which is no question
    nearer_before,         ///< the surface is nearer than r(1 − 10⁻⁹) at an earlier t
    nothing_there,         ///< at t the surface is farther than r(1 + 10⁻⁹)
    unclear                ///< the ball glides along the surface at r for too long to tell
};

/// Judges where a ball that moves `from` → `to` touches first: at t in [0, 1], or nowhere if t is none. Lengths have four
/// roundings of the largest coordinate, in double, beside 10⁻⁹ r.
///
/// An interval is clear if its ends are clear by half its length, for the distance changes by no more than the way; or
/// if it is so short that the distance cannot dip to r between its ends: each point's distance, along the way s, has a
/// second derivative of at most 1/distance, so the least of all of them is at most s²/(8·distance) below its chord.
template <Real T>
[[nodiscard]] SweepVerdict judge_first_touch(const BallSurface<T>& ground, const Point& from, const Point& to,
                                             Wide radius, std::optional<Wide> t, int max_evaluations = 4000) {
    const Point way = to - from;
    const Wide far = length(way);
    const Wide roundings =
        4 * static_cast<Wide>(epsilon<double>) * std::max(largest_coordinate(from), largest_coordinate(to));
    const Wide least = radius * (1 - 1e-9L) - roundings;
    int evaluations = 0;
    const auto clearance = [&](Wide s) {
        ++evaluations;
        const Wide reach = radius + std::min(std::max(far, 1e-3L * radius), 2 * radius + 2 * ground.cell());
        return ground.distance(from + s * way, reach) - least;
    };
    const Wide end = t.value_or(1), at_start = clearance(0);
    if (at_start < 0) return SweepVerdict::starts_in_the_surface;
    const Wide at_end = clearance(end);
    if (t && at_end > 2e-9L * radius + 2 * roundings) return SweepVerdict::nothing_there;
    if (at_end < 0) return SweepVerdict::nearer_before;
    struct Piece {
        Wide begin, end, at_begin, at_end;
    };
    std::vector<Piece> open{{0, end, at_start, at_end}};
    while (!open.empty()) {
        const Piece piece = open.back();
        open.pop_back();
        const Wide longest = (piece.end - piece.begin) * far;
        const Wide low = std::min(piece.at_begin, piece.at_end);
        if (longest <= piece.at_begin + piece.at_end) continue;
        // Nothing in between is nearer than r/2, nor than half of r and the clearance.
        const bool short_enough = longest <= radius / 4;
        if (short_enough && longest * longest <= 8 * (radius / 2) * low) continue;
        if (evaluations > max_evaluations) return SweepVerdict::unclear;
        const Wide middle = (piece.begin + piece.end) / 2;
        const Wide here = clearance(middle);
        if (here < 0) return SweepVerdict::nearer_before;
        if (longest < 1e-12L * radius) continue; // the margin of the touch itself
        open.push_back({middle, piece.end, here, piece.at_end});
        open.push_back({piece.begin, middle, piece.at_begin, here});
    }
    return SweepVerdict::right;
}
template <Real T>
[[nodiscard]] SweepVerdict judge_first_touch(const Terrain<T>& terrain, const glm::dvec3& from,
                                             const glm::dvec3& to, double radius, std::optional<double> t) {
    const auto point = [](const glm::dvec3& p) { return wide(vec3<double>{p}); };
    return judge_first_touch(BallSurface<T>{terrain}, point(from), point(to), static_cast<Wide>(radius),
                             t ? std::optional{static_cast<Wide>(*t)} : std::nullopt);
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_BALL_JUDGE_HPP
