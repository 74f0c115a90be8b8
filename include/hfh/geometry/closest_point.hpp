#ifndef HFH_GEOMETRY_CLOSEST_POINT_HPP
#define HFH_GEOMETRY_CLOSEST_POINT_HPP

#include <hfh/geometry/bilinear_patch.hpp>
#include <hfh/geometry/lattice.hpp>

#include <glm/common.hpp>

#include <cmath>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.2, Eq. (8)-(11); the safeguard is that of
// projected Newton methods, Bertsekas, Projected Newton Methods for Optimization Problems with Simple
// Constraints (1982).

namespace hfh {

enum class NewtonStatus : unsigned char {
    converged, ///< |F_u| and |F_v| are below their rounding error, or push out of the patch at its border
    at_border, ///< BorderRule::stop only: on the border, and the descent leads out of the patch
    iteration_limit ///< `max_iterations` steps were taken; the point is still nearer than the start
};

/// What to do where the descent leads out of the patch.
enum class BorderRule : unsigned char {
    slide, ///< go on along the border: ends at the bounded closest point
    stop   ///< return after the step that led there, so that the caller can look at the neighbour
};

struct NewtonOptions {
    BorderRule border = BorderRule::slide;
    /// Measured (target accuracy, double, from the point over the query): with 64 no query is left with anything to
    /// gain downhill. With 8, 0.016 % are of those 1 to 5 cells below steep alpine ground and 0.18 % of those below
    /// cells of relief 1 to 1000; with 4, 0.9 % and 8 %; with 2, 20 % of both. In shallow contact, up to 0.1 cells,
    /// 2 are exact on gentle ground (8 m cells) and 3 on steep. Fewer save next to nothing: it stops by itself.
    /// In float, on cells of relief above 100, the resolution of F_u and F_v can end it in a valley: 4 % of the
    /// shallow queries on relief 1 to 1000, none on the real terrains.
    int max_iterations = 64;
};

template <Real T>
struct NewtonResult {
    T u{}, v{}; ///< the foot point, 0 ≤ u, v ≤ 1
    T gap{};    ///< z of σ = S(u, v) − query there, in metres
    NewtonStatus status = NewtonStatus::converged;
    int iterations = 0; ///< steps taken
};

/// The distance from a query to a patch as a function of (u, v), and its derivatives.
///
///     F(u, v) = ½ |σ|²,  σ = S(u, v) − query                                         Eq. (8)-(9) [P], halved
///     F_u = σ·S_u,  F_v = σ·S_v                                                      Eq. (10)
///     F_uu = S_u·S_u,  F_vv = S_v·S_v,  F_uv = S_u·S_v + σ·S_uv                      Eq. (11)
///
/// in m² per cell and m² per cell². `query` is given in the patch's parameters, z in metres.
template <Real T>
struct DistanceFunction {
    T gap00;          ///< σ_z over corner 00
    T rise_u, rise_v; ///< slopes along u and v at that corner, metres per cell
    T far_u, far_v;   ///< along u at v = 1, along v at u = 1
    T twist;          ///< Eq. (2)
    T dx2, dy2;       ///< dx², dy²
    T query_u, query_v;
    T noise_u, noise_v; ///< resolution of F_u and F_v: no descent smaller than this is believed

    [[gnu::always_inline]] DistanceFunction(const BilinearPatch<T>& patch, const CellPoint<T>& query) noexcept
        : gap00{patch.p00 - query.z}, rise_u{patch.p10 - patch.p00}, rise_v{patch.p01 - patch.p00},
          far_u{patch.p11 - patch.p01}, far_v{patch.p11 - patch.p10}, twist{patch.twist()},
          dx2{patch.spacing.x * patch.spacing.x}, dy2{patch.spacing.y * patch.spacing.y}, query_u{query.u},
          query_v{query.v} {
        // F_u = dx²(u − u_q) + σ_z·z_u. The product is good to a few roundings of the largest σ_z times the larger of
        // the two edge slopes; and u itself has steps of an ulp, each worth F_uu. Where the patch is level along u
        // there is neither: u = u_q is met to the bit.
        const T steepest_u = glm::max(std::abs(rise_u), std::abs(far_u));
        const T steepest_v = glm::max(std::abs(rise_v), std::abs(far_v));
        const T reach = std::abs(gap00) + steepest_u + steepest_v;
        noise_u = steepest_u > 0 ? 4 * epsilon<T> * (dx2 + steepest_u * reach) : T(0);
        noise_v = steepest_v > 0 ? 4 * epsilon<T> * (dy2 + steepest_v * reach) : T(0);
    }

    [[nodiscard]] T slope_u(T v) const noexcept { return (T(1) - v) * rise_u + v * far_u; }
    [[nodiscard]] T slope_v(T u) const noexcept { return (T(1) - u) * rise_v + u * far_v; }
    /// σ_z.
    [[nodiscard]] T gap(T u, T v) const noexcept { return gap00 + u * rise_u + v * slope_v(u); }

    /// Everything at one (u, v).
    struct Value {
        T z;             ///< σ_z
        T zu, zv;        ///< slopes, metres per cell
        T fu, fv;        ///< Eq. (10)
        T fuu, fvv, fuv; ///< Eq. (11)
        T gauss_newton; ///< determinant of Eq. (11) without σ·S_uv: dx²dy² + dx²z_v² + dy²z_u², always > 0
        T determinant; ///< determinant of Eq. (11), from the one above so that it does not cancel on steep ground
    };
    [[nodiscard, gnu::always_inline]] Value operator()(T u, T v) const noexcept {
        const T zu = slope_u(v), zv = slope_v(u), z = gap00 + u * rise_u + v * zv;
        const T slopes = zu * zv, bend = z * twist, fuu = dx2 + zu * zu, fvv = dy2 + zv * zv;
        const T gauss_newton = dx2 * fvv + dy2 * zu * zu;
        return {.z = z,
                .zu = zu,
                .zv = zv,
                .fu = dx2 * (u - query_u) + z * zu,
                .fv = dy2 * (v - query_v) + z * zv,
                .fuu = fuu,
                .fvv = fvv,
                .fuv = slopes + bend,
                .gauss_newton = gauss_newton,
                .determinant = gauss_newton - bend * (2 * slopes + bend)};
    }

    /// The u in [0, 1] that minimises F at this v, and the v at this u: F is a parabola along u and along v.
    [[nodiscard]] T best_u(T v) const noexcept {
        const T zu = slope_u(v);
        return glm::clamp((dx2 * query_u - gap(T(0), v) * zu) / (dx2 + zu * zu), T(0), T(1));
    }
    [[nodiscard]] T best_v(T u) const noexcept {
        const T zv = slope_v(u);
        return glm::clamp((dy2 * query_v - gap(u, T(0)) * zv) / (dy2 + zv * zv), T(0), T(1));
    }

    /// Where the patch is level along u or v, puts that parameter right over the query, which is as low as F gets along
    /// it. Rounding may only creep up to that: to 0 by sixteen digits a step. Worth asking after three steps, for it is
    /// rare: at once it would cost 6 % of an update.
    void meet_level(vec2<T>& at) const noexcept {
        if (rise_u == 0 && far_u == 0) at.x = glm::clamp(query_u, T(0), T(1));
        if (rise_v == 0 && far_v == 0) at.y = glm::clamp(query_v, T(0), T(1));
    }

    /// |σ|² = 2 F at (u, v), where σ_z is z.
    [[nodiscard]] T squared(T u, T v, T z) const noexcept {
        const T x = u - query_u, y = v - query_v;
        return dx2 * x * x + dy2 * y * y + z * z;
    }

    /// F(u + du, v + dv) − F(u, v): a quartic along the step, written so that nothing cancels.
    [[nodiscard]] T change(const Value& at, T du, T dv) const noexcept {
        const T z1 = at.zu * du + at.zv * dv, z2 = twist * du * dv, dz = z1 + z2;
        return at.fu * du + at.fv * dv + at.z * z2 + (dx2 * du * du + dy2 * dv * dv + dz * dz) / 2;
    }
};

/// F along a straight step (du, dv) from a point, 0 ≤ s ≤ 1: the height is a parabola in s, and so
///
///     F(s) − F(0) = slope·s + square·s² + cube·s³ + fourth·s⁴
///     slope = F_u du + F_v dv,  square = σ_z b + (dx² du² + dy² dv² + c²)/2,  cube = c b,  fourth = b²/2
///
/// with the climb c = z_u du + z_v dv and the bend b = A du dv of the height.
template <Real T>
struct StepProfile {
    T slope, square, cube, fourth;

    StepProfile(const DistanceFunction<T>& distance, const typename DistanceFunction<T>::Value& at, T du,
                T dv) noexcept {
        const T climb = at.zu * du + at.zv * dv, bend = distance.twist * du * dv;
        slope = at.fu * du + at.fv * dv;
        square = at.z * bend + (distance.dx2 * du * du + distance.dy2 * dv * dv + climb * climb) / 2;
        cube = climb * bend;
        fourth = bend * bend / 2;
    }

    /// F(s) − F(0).
    [[nodiscard]] T change(T s) const noexcept {
        return s * (slope + s * (square + s * (cube + s * fourth)));
    }
    /// F'(s).
    [[nodiscard]] T rate(T s) const noexcept {
        return slope + s * (2 * square + s * (3 * cube + 4 * s * fourth));
    }

    /// The part of the step on which F falls all along: all of it, 1, or up to the first minimum of F, or to where F is
    /// all but level before that. 0 if F does not fall at once.
    [[nodiscard, gnu::noinline]] T up_to_first_minimum() const noexcept {
        if (!(slope < 0)) return T(0);
        // The rate may rise to a highest value, then falls to a lowest one and rises again, since fourth ≥ 0. So it is
        // zero at most once before the highest value, and if it is not there, at most once before the end.
        T high = 1;
        if (cube < 0 && square > 0) {
            const T root = 9 * cube * cube - 24 * fourth * square;
            const T highest = root >= 0 ? 2 * square / (std::sqrt(root) - 3 * cube) : T(1);
            if (highest < 1 && rate(highest) > 0) high = highest;
        }
        T rate_high = rate(high);
        if (!(rate_high > 0)) return T(1);
        // Regula falsi in the form of Illinois: the weight of an end that stays twice is halved.
        T low = 0, rate_low = slope;
        int stayed = 0;
        for (int secant = 0; secant < 32; ++secant) {
            const T middle = low + (high - low) * (rate_low / (rate_low - rate_high));
            if (!(middle > low && middle < high)) break;
            const T here = rate(middle);
            if (here > 0) {
                high = middle, rate_high = here;
                if (stayed > 0) rate_low /= 2;
                stayed = 1;
            } else {
                low = middle, rate_low = here;
                if (64 * here > slope) break;
                if (stayed < 0) rate_high /= 2;
                stayed = -1;
            }
        }
        return low;
    }
};

namespace detail {

enum class NewtonStep : unsigned char { refused, arrived, inside, to_border, barely_to_border };

/// Newton's step from `at`, as much of it as stays in the patch.
///
/// refused: Eq. (11) is not safely positive definite, or the step is not worth its while: it does not lower F by a
/// quarter of F_u²/F_uu + F_v²/F_vv, which is at least half of what minimising along u or v alone can give; `at` is as
/// it was.
/// inside, arrived: the whole step was taken; arrived, if what it leaves of F_u and F_v is below their resolution.
/// That is known without looking: beside the rounding of the step itself the terms that Eq. (11) does not hold,
/// A dv ẑ + z_u A du dv and A du ẑ + z_v A du dv with ẑ the change of height.
/// to_border, barely_to_border: up to the border that it meets first; barely, if that lowers F by a quarter of what its
/// slope promises, but is worth its while only if the surface goes on there.
/// A step on which F would rise again ends at the first minimum of F, inside: F falls all along every step, or it could
/// lead through a ridge (the tracker's proxy slides, and must not).
template <Real T>
[[nodiscard, gnu::always_inline]] inline NewtonStep newton_step(const DistanceFunction<T>& distance,
                                                                const typename DistanceFunction<T>::Value& f,
                                                                vec2<T>& at) noexcept {
    if (!(f.determinant > f.gauss_newton / 2)) return NewtonStep::refused;
    // The step times the determinant: where this meets a border is known without waiting for the quotient.
    const T way_u = f.fuv * f.fv - f.fvv * f.fu, way_v = f.fuv * f.fu - f.fuu * f.fv;
    const T scale = T(1) / f.determinant;
    T du = way_u * scale, dv = way_v * scale;
    vec2<T> to{at.x + du, at.y + dv};
    const bool whole = to.x >= 0 && to.x <= 1 && to.y >= 0 && to.y <= 1;
    T taken = 1; // of Newton's step
    if (!whole) {
        const T border_u = way_u > 0 ? T(1) : T(0), border_v = way_v > 0 ? T(1) : T(0);
        const T never = std::numeric_limits<T>::max();
        const T part_u = way_u != 0 ? (border_u - at.x) / way_u : never;
        const T part_v = way_v != 0 ? (border_v - at.y) / way_v : never;
        // The parameter that meets its border first is on it, not a rounding away.
        to = part_u < part_v ? vec2<T>{border_u, glm::clamp(at.y + part_u * way_v, T(0), T(1))}
                             : vec2<T>{glm::clamp(at.x + part_v * way_u, T(0), T(1)), border_v};
        du = to.x - at.x, dv = to.y - at.y;
        taken = glm::min(part_u, part_v) * f.determinant;
    }
    const T slope = f.fu * du + f.fv * dv, bent = distance.twist * du * dv;
    const T tangent = f.zu * du + f.zv * dv, climb = tangent + bent;
    const T change =
        slope + f.z * bent + (distance.dx2 * du * du + distance.dy2 * dv * dv + climb * climb) / 2;
    const T worth = f.fu * f.fu * f.fvv + f.fv * f.fv * f.fuu;
    const bool enough = 4 * change * f.fuu * f.fvv <= -worth;
    if (!enough && (whole || !(slope < 0 && 4 * change <= slope))) return NewtonStep::refused;
    if (whole) {
        const T left_u = f.fu + f.fuu * du + f.fuv * dv + (distance.twist * dv * climb + f.zu * bent);
        const T left_v = f.fv + f.fuv * du + f.fvv * dv + (distance.twist * du * climb + f.zv * bent);
        if (2 * std::abs(left_u) < distance.noise_u && 2 * std::abs(left_v) < distance.noise_v) {
            at = to;
            return NewtonStep::arrived;
        }
    }
    // Along Newton's step, as far as it is taken, `StepProfile::square` is −taken·slope/2. So this is F' at the end, and
    // F is convex all along if half of F″ at the start is more than the bend can take from it.
    const T cube = tangent * bent, rate = slope * (1 - taken) + (3 * cube + 2 * bent * bent);
    const bool convex = 6 * cube >= taken * slope;
    if (rate > 0 || !convex) {
        // Mostly F' is convex, too, and the step a little too long: the chord of F' ends before the minimum.
        const bool little = cube >= 0 && 0 < rate && rate < -slope;
        T part = little ? slope / (slope - rate) : T(1);
        if (!little) [[unlikely]] {
            const StepProfile<T> profile{distance, f, du, dv};
            part = profile.up_to_first_minimum();
            // A small part of it is no way along a bent valley.
            if (part < T(0.25)) return NewtonStep::refused;
            if (part < 1 && !(4 * profile.change(part) * f.fuu * f.fvv <= -worth)) return NewtonStep::refused;
        }
        if (part < 1) {
            at = {at.x + part * du, at.y + part * dv};
            return NewtonStep::inside;
        }
    }
    at = to;
    return whole ? NewtonStep::inside : enough ? NewtonStep::to_border : NewtonStep::barely_to_border;
}

/// The floor of a bent valley: the curve on which the stiffer parameter is at its best for each value of the other. Along
/// it F is a function of the other parameter alone, with curvature det/F_uu (or det/F_vv).
template <Real T>
struct FloorPath {
    const DistanceFunction<T>& distance;
    bool along_v;

    [[nodiscard]] vec2<T> at(T along) const noexcept {
        return along_v ? vec2<T>{distance.best_u(along), along} : vec2<T>{along, distance.best_v(along)};
    }
    /// Whether F falls on the way from one place to another. Told from F and its slope at nine places on it, so false where
    /// the slope across the valley doubles or halves on the way: there the floor may bend too sharply to be told so.
    [[nodiscard]] bool falls(T from, T to) const noexcept {
        const T across = slope_across(from), across_there = slope_across(to);
        if (!(across * across_there > 0) || std::abs(across) > 2 * std::abs(across_there) ||
            std::abs(across_there) > 2 * std::abs(across)) {
            return false;
        }
        T last = std::numeric_limits<T>::max();
        for (int eighth = 0; eighth <= 8; ++eighth) {
            const vec2<T> here = at(from + static_cast<T>(eighth) / 8 * (to - from));
            const auto f = distance(here.x, here.y);
            const T squared = distance.squared(here.x, here.y, f.z);
            if ((along_v ? f.fv : f.fu) * (to - from) > 0 || squared > last) return false;
            last = squared;
        }
        return true;
    }

private:
    [[nodiscard]] T slope_across(T along) const noexcept {
        return along_v ? distance.slope_u(along) : distance.slope_v(along);
    }
};

/// A step to a point of the valley's floor: straight, as far as F falls all along, or, where the straight way leads over
/// the valley's side at once, down to the floor and along it. Leaves `at` alone and returns false if no such step lowers F
/// by more than `gain` (< 0) does.
template <Real T>
[[nodiscard]] bool valley_step(const DistanceFunction<T>& distance,
                               const typename DistanceFunction<T>::Value& f, T gain, vec2<T>& at) noexcept {
    const bool along_v = f.fuu >= f.fvv;
    const FloorPath<T> valley{distance, along_v};
    const T from = along_v ? at.y : at.x, stiff = along_v ? f.fuu : f.fvv;
    const T slope = along_v ? f.fuu * f.fv - f.fuv * f.fu : f.fvv * f.fu - f.fuv * f.fv;
    const T curvature = glm::max(std::abs(f.determinant), epsilon<T> * stiff * stiff);
    T step = glm::clamp(from - slope / curvature, T(0), T(1)) - from;
    T last = std::numeric_limits<T>::max();
    for (int halving = 0; halving < 16; ++halving, step /= 2) {
        const T to = glm::clamp(from + step, T(0), T(1));
        const vec2<T> floor = valley.at(to);
        const StepProfile<T> profile{distance, f, floor.x - at.x, floor.y - at.y};
        const T part = profile.up_to_first_minimum(), straight = profile.change(part),
                whole = profile.change(T(1));
        if (straight < gain && part >= T(0.25)) {
            at = part < 1 ? at + part * (floor - at) : floor;
            return true;
        }
        if (whole < gain && valley.falls(from, to)) {
            at = floor;
            return true;
        }
        if (whole < 0 && !(whole < last)) return false; // the best step of all was longer
        last = whole;
    }
    return false;
}

/// What may move at a point: a parameter along which F falls by more than noise, and not out of the patch.
struct Freedom {
    bool pulls_u, pulls_v; ///< F falls along u, along v
    bool held_u, held_v;   ///< on a border, out of which F falls along u, along v

    // Asks first where the point is and then for the sign of a slope: the sign is anyone's guess, and a branch on it
    // would be mispredicted half of the time.
    template <Real T>
    [[gnu::always_inline]] Freedom(const DistanceFunction<T>& distance,
                                   const typename DistanceFunction<T>::Value& f, const vec2<T>& at) noexcept
        : pulls_u{std::abs(f.fu) > distance.noise_u}, pulls_v{std::abs(f.fv) > distance.noise_v},
          held_u{at.x <= 0 ? f.fu > 0 : at.x >= 1 && f.fu <= 0}, held_v{at.y <= 0 ? f.fv > 0
                                                                                  : at.y >= 1 && f.fv <= 0} {}

    [[nodiscard]] bool none() const noexcept { return !(pulls_u && !held_u) && !(pulls_v && !held_v); }
    [[nodiscard]] bool inside() const noexcept { return !held_u && !held_v; }
    /// F falls beyond the border.
    [[nodiscard]] bool beyond() const noexcept { return (pulls_u && held_u) || (pulls_v && held_v); }
};

/// Where to go from `at` if Newton's step will not do: along the floor of the valley, or to the minimum along u or v
/// alone, whichever is worth more. Far from the query both lie on borders of the patch, and the corner where these meet
/// is lower than either: there is no floor to look for then, which would take half of the time of a long slide.
template <Real T>
[[nodiscard, gnu::noinline]] vec2<T> cautious_step(const DistanceFunction<T>& distance, vec2<T> at) noexcept {
    const auto f = distance(at.x, at.y);
    const Freedom may{distance, f, at};
    const bool free_u = may.pulls_u && !may.held_u, free_v = may.pulls_v && !may.held_v;
    const T u = free_u ? glm::clamp(at.x - f.fu / f.fuu, T(0), T(1)) : at.x;
    const T v = free_v ? glm::clamp(at.y - f.fv / f.fvv, T(0), T(1)) : at.y;
    const T gain_u = distance.change(f, u - at.x, T(0)), gain_v = distance.change(f, T(0), v - at.y);
    const T gain = glm::min(gain_u, gain_v);
    const bool to_corner = u != at.x && v != at.y && (u == 0 || u == 1) && (v == 0 || v == 1);
    if (to_corner) {
        const StepProfile<T> profile{distance, f, u - at.x, v - at.y};
        if (profile.up_to_first_minimum() == 1 && profile.change(T(1)) < gain) return {u, v};
    }
    if (may.inside() && valley_step(distance, f, gain, at)) return at;
    return free_u && (!free_v || gain_u <= gain_v) ? vec2<T>{u, at.y} : vec2<T>{at.x, v};
}

} // namespace detail

/// The local closest point of §4.3.2 on one closed patch, downhill from `start`.
///
/// Newton's method on Eq. (10), kept in 0 ≤ u, v ≤ 1, with two safeguards: where Eq. (11) is not safely positive
/// definite, or a step is not worth its while, the point follows the floor of the valley that F has there, or goes
/// to the minimum along u or v alone, which is always possible. F never rises, so the point never gets farther
/// from the query. The paper iterates plain Newton; for depths near the radius of curvature that ends elsewhere or
/// nowhere.
///
/// Finds a local minimum, the one below `start`. start: 0 ≤ u, v ≤ 1. Does not allocate.
template <Real T>
[[nodiscard]] NewtonResult<T> newton_closest_point(const BilinearPatch<T>& patch, const CellPoint<T>& query,
                                                   const vec2<T>& start,
                                                   const NewtonOptions& options = {}) noexcept {
    const DistanceFunction<T> distance{patch, query};
    NewtonResult<T> foot{start.x, start.y};
    for (;; ++foot.iterations) {
        vec2<T> at{foot.u, foot.v};
        const auto f = distance(at.x, at.y);
        foot.gap = f.z;
        const detail::Freedom may{distance, f, at};
        if (options.border == BorderRule::stop && (foot.iterations > 0 || may.none()) && may.beyond()) {
            foot.status = NewtonStatus::at_border;
            return foot;
        }
        if (may.none()) return foot;

        if (foot.iterations == options.max_iterations) {
            foot.status = NewtonStatus::iteration_limit;
            return foot;
        }
        using enum detail::NewtonStep;
        const auto step = may.inside() ? detail::newton_step(distance, f, at) : refused;
        if (step == refused || step == barely_to_border)
            at = detail::cautious_step(distance, {foot.u, foot.v});
        if (foot.iterations >= 3) [[unlikely]]
            distance.meet_level(at);
        if (at.x == foot.u && at.y == foot.v) return foot; // below the resolution of u and v
        foot.u = at.x;
        foot.v = at.y;
        if (step == arrived) {
            foot.gap = distance.gap(at.x, at.y);
            ++foot.iterations;
            return foot;
        }
    }
}

} // namespace hfh

#endif // HFH_GEOMETRY_CLOSEST_POINT_HPP
