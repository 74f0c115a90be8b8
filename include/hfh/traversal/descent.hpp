#ifndef HFH_TRAVERSAL_DESCENT_HPP
#define HFH_TRAVERSAL_DESCENT_HPP

#include <hfh/geometry/closest_point.hpp>
#include <hfh/geometry/surface_point.hpp>
#include <hfh/terrain/height_field.hpp>

#include <glm/geometric.hpp>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.2: the search over neighbouring patches, one at
// an edge and three at a vertex (Figure 6). The paper moves to the patch whose closest point is nearest; here the
// point moves only where the surface leads downhill from where it is, so a proxy slides and never jumps.
//
// "Downhill" means that the distance to the query falls, and F is half of its square (`DistanceFunction`).

namespace hfh {

enum class DescentStatus : unsigned char {
    minimum,    ///< no patch at the point has a descent direction
    off_border, ///< pinned to the rim of the grid, with the query beyond it
    off_hole,   ///< pinned to the rim of a hole, with the query beyond it; or the start has no patch
    work_limit ///< `max_patches` were looked at (or Newton's iterations ran out); still no farther than the start
};

[[nodiscard]] constexpr const char* to_string(DescentStatus status) noexcept {
    switch (status) {
    case DescentStatus::minimum: return "minimum";
    case DescentStatus::off_border: return "off_border";
    case DescentStatus::off_hole: return "off_hole";
    case DescentStatus::work_limit: return "work_limit";
    }
    return "unknown";
}

/// Visits to a border without coming nearer to the query, and where they began.
struct Stalls {
    unsigned char count = 0;
    unsigned char place = 0; ///< if `count`: the last four bits of the cell's i and j
};

/// How a descent goes on.
enum class DescentResume : unsigned char {
    start,  ///< it was not cut short
    step,   ///< with a step in its patch
    compare ///< by comparing the incident patches
};

/// Where a descent that was cut short is on its way, so that it goes on in another call with the same query as if it had
/// not been cut short: to the bit. Made anew where the query is another one. Heights may have been edited meanwhile.
template <Real T>
struct DescentProgress {
    /// Smallest |σ|² with which the point was on a border, in m², and visits to a border since then. Along a sharp crease
    /// two patches can hand the point back and forth for the last bits: after 8 visits without coming nearer it has arrived.
    /// But not if it travels: far below level ground a step of a cell is less than the rounding of |σ|².
    T nearest = std::numeric_limits<T>::max();
    Stalls stalls{};
    unsigned char steps = 0; ///< taken in this patch
    DescentResume resume = DescentResume::start;

    /// After so many steps in this patch; it goes on by comparing the incident patches, or with a step.
    constexpr void cut_short(int steps_here, bool compare) noexcept {
        steps = static_cast<unsigned char>(steps_here);
        resume = compare ? DescentResume::compare : DescentResume::step;
    }
};

template <Real T>
struct DescentResult {
    DescentStatus status = DescentStatus::minimum;
    SurfacePoint<T> point{};
    vec3<T> offset{T(0)};    ///< surface point − query, in metres
    vec3<T> normal{0, 0, 1}; ///< unit, upward; the average over the patches that meet at the point
    /// > 0 if the query lies below the surface at the point, < 0 if above; only the sign has a meaning. It is that of
    /// offset·normal, as in §4.3.3 [P], but where the averaged normal can point anywhere: where patches that meet at a
    /// minimum disagree (their mean normal is shorter than 3/4), the query is below in a valley and above on a ridge; at
    /// a rim the sign of offset.z holds.
    T signed_depth = 0;
    int patches = 0; ///< patches looked at; once more for each step in them that Newton's method refused
};

/// Slides a surface point downhill, patch by patch, to the local closest point to `query` (world coordinates, metres).
///
/// Inside a patch Newton's method runs to the local minimum or to the border. Over an edge the point goes on where F
/// falls beyond it; else, and at a vertex, in the patch into which F falls most steeply from that very point, its own
/// included; each hop at one point goes to a steeper patch, so hops around a vertex come to an end. The distance never
/// rises. Ends where no patch at the point has a descent direction, and says so if it ends for another reason. Where a patch
/// is missing the rim holds the point; with the query beyond that rim the point has slid off.
///
/// Stops once max_patches were looked at, but never without a step; with max_patches < 1 it takes none and describes the
/// start. Looks at max_patches + 5 patches at the most, and at the end once more at those that meet at the point. Does not
/// throw and does not allocate.
template <HeightField Field>
[[nodiscard]] DescentResult<typename Field::Scalar>
descend(const Field& field, const vec3<typename Field::Scalar>& query,
        const SurfacePoint<typename Field::Scalar>& start, int max_patches) noexcept;

namespace detail {

/// How far the point of a descent may move: any distance.
struct AnyDistance {
    [[nodiscard]] static constexpr bool is_used_up() noexcept { return false; }
    template <Real T>
    [[nodiscard]] static constexpr NewtonStep shorten(const DistanceFunction<T>&, const SurfacePoint<T>&,
                                                      const vec2<T>&, NewtonStep step) noexcept {
        return step;
    }
};

/// How far the point of a descent may move on the surface: so many metres and no more.
template <Real T>
struct DistanceLeft {
    T metres;           ///< ≥ 0
    bool moved = false; ///< the point has moved
    bool used_up = false;

    [[nodiscard]] bool is_used_up() const noexcept { return used_up; }

    /// Shortens a step in a patch, from `at` to `to`, to what is left. The first step goes 2⁻¹² cells at least, so that a
    /// point on its way is never too slow for its coordinates. Returns what kind of step that leaves.
    [[nodiscard]] NewtonStep shorten(const DistanceFunction<T>& distance, const SurfacePoint<T>& at,
                                     vec2<T>& to, NewtonStep step) noexcept {
        const T du = to.x - at.u, dv = to.y - at.v;
        // A bound of the length on the surface, for the slope along the step is greatest at one of its ends.
        const T slope = glm::max(std::abs(distance.slope_u(at.v) * du + distance.slope_v(at.u) * dv),
                                 std::abs(distance.slope_u(to.y) * du + distance.slope_v(to.x) * dv));
        const T length = std::sqrt(distance.dx2 * du * du + distance.dy2 * dv * dv + slope * slope);
        const T least = moved ? T(0) : T(0x1p-12) / glm::max(std::abs(du), std::abs(dv));
        moved = true;
        const T share = glm::max(metres / length, least);
        used_up = share < 1;
        if (used_up) {
            // F falls all along any other step.
            const bool may_rise = step == NewtonStep::refused;
            const vec2<T> straight{at.u + share * du, at.v + share * dv};
            to = may_rise && rises(distance, at, straight) ? along_floor(distance, at, to, share, least)
                                                           : straight;
            step = NewtonStep::inside;
        }
        metres = glm::max(metres - length, T(0));
        return step;
    }

private:
    [[nodiscard]] static bool rises(const DistanceFunction<T>& distance, const SurfacePoint<T>& at,
                                    const vec2<T>& to) noexcept {
        return distance.change(distance(at.u, at.v), to.x - at.u, to.y - at.v) > 0;
    }
    /// As much of the step that `safeguarded_step` makes along a bent valley as is left: on its floor, or, where that is too
    /// far off, towards it.
    [[nodiscard]] vec2<T> along_floor(const DistanceFunction<T>& distance, const SurfacePoint<T>& at,
                                      const vec2<T>& to, T share, T least) const noexcept {
        const auto f = distance(at.u, at.v);
        const bool along_v = f.fuu >= f.fvv;
        const ValleyFloor<T> valley{distance, along_v};
        const T from = along_v ? at.v : at.u, goal = along_v ? to.y : to.x;
        const auto length_to = [&](const vec2<T>& place) {
            const T x = place.x - at.u, y = place.y - at.v, z = distance.gap(place.x, place.y) - f.z;
            return std::sqrt(distance.dx2 * x * x + distance.dy2 * y * y + z * z);
        };
        for (T part = share; part > least; part /= 2) {
            const vec2<T> place = valley.at(from + part * (goal - from));
            if (length_to(place) <= metres) return place;
        }
        const vec2<T> floor = valley.at(from), way{floor.x - at.u, floor.y - at.v};
        const T length = length_to(floor), part = length > metres ? glm::max(metres / length, least) : T(1);
        return {at.u + part * way.x, at.v + part * way.y};
    }
};

/// `descend`, from the start on or from where it was cut short. Inlined where it is the hot path, so that its result is not
/// returned through memory.
template <HeightField Field, class Way = AnyDistance>
[[nodiscard, HFH_ALWAYS_INLINED]] inline DescentResult<typename Field::Scalar>
descend_inline(const Field& field, const vec3<typename Field::Scalar>& query,
               const SurfacePoint<typename Field::Scalar>& start, int max_patches,
               DescentProgress<typename Field::Scalar>& progress, Way way = {}) noexcept;

/// The same, for where it is not the hot path.
template <HeightField Field>
[[nodiscard, gnu::noinline]] DescentResult<typename Field::Scalar>
descend_on(const Field& field, const vec3<typename Field::Scalar>& query,
           const SurfacePoint<typename Field::Scalar>& start, int max_patches,
           DescentProgress<typename Field::Scalar>& progress) noexcept {
    return descend_inline(field, query, start, max_patches, progress);
}

/// `descend` from the start on, but the point moves no farther than so many metres, or 2⁻¹² cells, and ends there with
/// work_limit.
template <HeightField Field>
[[nodiscard, gnu::noinline]] DescentResult<typename Field::Scalar>
descend_no_farther(const Field& field, const vec3<typename Field::Scalar>& query,
                   const SurfacePoint<typename Field::Scalar>& start, int max_patches,
                   typename Field::Scalar metres) noexcept {
    DescentProgress<typename Field::Scalar> progress;
    return descend_inline(field, query, start, max_patches, progress,
                          DistanceLeft<typename Field::Scalar>{metres});
}

// The patches that meet at a point on the border of its patch.

/// A step to a neighbouring cell; {0, 0} stays.
struct Neighbour {
    int di, dj;
};

/// The neighbours that share a point of a cell: one at an edge, three at a vertex (Figure 6 [P]), none inside. The last of
/// three is the one opposite.
struct Neighbours {
    Neighbour items[3];
    int count = 0;

    template <Real T>
    Neighbours(T u, T v) noexcept {
        const int di = u <= 0 ? -1 : u >= 1 ? 1 : 0, dj = v <= 0 ? -1 : v >= 1 ? 1 : 0;
        if (di != 0) items[count++] = {di, 0};
        if (dj != 0) items[count++] = {0, dj};
        if (di != 0 && dj != 0) items[count++] = {di, dj};
    }
    [[nodiscard]] const Neighbour* begin() const noexcept { return items; }
    [[nodiscard]] const Neighbour* end() const noexcept { return items + count; }
};

/// The same point of the surface, in the neighbour's parameters.
template <Real T>
[[nodiscard]] SurfacePoint<T> seen_from(Neighbour n, const SurfacePoint<T>& point) noexcept {
    return {{point.cell.i + n.di, point.cell.j + n.dj},
            n.di == 0 ? point.u : T(n.di > 0 ? 0 : 1),
            n.dj == 0 ? point.v : T(n.dj > 0 ? 0 : 1)};
}

/// Whether a query, in the parameters of a cell, lies beyond the edge or vertex at which its neighbour begins.
template <Real T>
[[nodiscard]] bool lies_across(Neighbour n, const CellPoint<T>& query) noexcept {
    const bool beyond_u = n.di == 0 || (n.di > 0 ? query.u > 1 : query.u < 0);
    const bool beyond_v = n.dj == 0 || (n.dj > 0 ? query.v > 1 : query.v < 0);
    return beyond_u && beyond_v;
}

/// How steeply F falls from (u, v) into the patch, along u and along v: F_u²/F_uu and F_v²/F_vv in m², 0 where it does not.
template <Real T>
[[nodiscard]] vec2<T> descent_rate(const DistanceFunction<T>& distance,
                                   const typename DistanceFunction<T>::Value& f, T u, T v) noexcept {
    const bool along_u =
        (f.fu > distance.gradient_error_u && u > 0) || (f.fu < -distance.gradient_error_u && u < 1);
    const bool along_v =
        (f.fv > distance.gradient_error_v && v > 0) || (f.fv < -distance.gradient_error_v && v < 1);
    return {along_u ? f.fu * f.fu / f.fuu : T(0), along_v ? f.fv * f.fv / f.fvv : T(0)};
}

/// Of the patches that meet at a point, the one into which F falls most steeply.
template <Real T>
struct SteepestPatch {
    SurfacePoint<T> point; ///< the same point in that patch
    DistanceFunction<T> distance;
    T rate;                                     ///< sum of the descent rates into that patch
    DescentStatus rim = DescentStatus::minimum; ///< off_…: a patch is missing on the side where the query is
    int patches = 0;                            ///< neighbours looked at

    /// F falls into that patch.
    [[nodiscard]] bool leads_down() const noexcept { return rate > 0; }
};

/// Compares the neighbour's patch with the steepest so far, and keeps the steeper. Returns the descent rates into it, −1 if
/// there is none.
template <HeightField Field, Real T>
[[HFH_ALWAYS_INLINED]] inline vec2<T> keep_steeper(const Field& field, const vec3<T>& query,
                                                   const SurfacePoint<T>& at, Neighbour n,
                                                   SteepestPatch<T>& steepest) noexcept {
    ++steepest.patches;
    const auto there = seen_from(n, at);
    const auto patch = field.patch(there.cell);
    if (!patch) return vec2<T>{-1};
    const DistanceFunction<T> distance{*patch, field.lattice().locate(query, there.cell)};
    const vec2<T> rate = descent_rate(distance, distance(there.u, there.v), there.u, there.v);
    // F falls along a shared edge as much on either side of it. That rate counts for a patch only if F falls into it as well:
    // else a level patch, whose gradient has the smaller rounding, would be taken for the steeper one.
    const bool enters = (n.di != 0 && rate.x > 0) || (n.dj != 0 && rate.y > 0) || !steepest.leads_down();
    if (enters && rate.x + rate.y > steepest.rate) {
        steepest.rate = rate.x + rate.y;
        steepest.point = there;
        steepest.distance = distance;
    }
    return rate;
}

/// Compares the incident patches of a point on the border of its patch, into which F falls at the rate `own`.
template <HeightField Field, Real T>
[[nodiscard, gnu::noinline]] SteepestPatch<T>
steepest_incident_patch(const Field& field, const vec3<T>& query, const SurfacePoint<T>& at,
                        const DistanceFunction<T>& distance, vec2<T> own) noexcept {
    SteepestPatch<T> steepest{.point = at, .distance = distance, .rate = own.x + own.y};
    Neighbours neighbours{at.u, at.v};
    if (neighbours.count == 3) {
        // Two patches that share an edge have the same slope along it. So the slopes of the point's own patch and of the one
        // opposite are those of all four, and are enough to see on which side F is steeper, along u and along v.
        const Neighbour opposite = neighbours.items[2];
        if (const vec2<T> rate = keep_steeper(field, query, at, opposite, steepest); rate.x >= 0) {
            const Neighbour steeper{rate.x < own.x ? 0 : opposite.di, rate.y < own.y ? 0 : opposite.dj};
            if ((steeper.di == 0) != (steeper.dj == 0)) keep_steeper(field, query, at, steeper, steepest);
            if (steepest.leads_down()) return steepest;
            neighbours.count = 2; // the opposite one is no hole
        }
    }
    const auto seen = field.lattice().locate(query, at.cell);
    for (const Neighbour n : neighbours) {
        const bool is_missing = !(keep_steeper(field, query, at, n, steepest).x >= 0);
        if (is_missing && lies_across(n, seen)) {
            steepest.rim = field.cells().contains(seen_from(n, at).cell) ? DescentStatus::off_hole
                                                                         : DescentStatus::off_border;
        }
    }
    return steepest;
}

/// `DescentResult::normal` and `signed_depth`.
template <Real T>
struct QuerySide {
    vec3<T> normal;
    T signed_depth;
};

/// The side of a query that is `offset` from a point on the border of its patch; `minimum`: the point is a minimum.
template <HeightField Field, Real T>
[[nodiscard, gnu::noinline]] QuerySide<T> classify_side(const Field& field, SurfacePoint<T> at,
                                                        vec3<T> offset, bool minimum) noexcept {
    const auto own = field.patch(at.cell);
    if (!own) return {{0, 0, 1}, offset.z}; // it was there a moment ago
    const Neighbours neighbours{at.u, at.v};
    int patches = 1;
    T crease = 0; // by how much the slopes, in metres per metre, rise from one side of the point to the other
    vec3<T> normal = own->normal(at.u, at.v);
    for (const Neighbour n : neighbours) {
        const SurfacePoint<T> there = seen_from(n, at);
        const auto patch = field.patch(there.cell);
        if (!patch) continue;
        ++patches;
        normal += patch->normal(there.u, there.v);
        if (n.dj == 0) crease += T(n.di) * (patch->slope_u(there.v) - own->slope_u(at.v)) / own->spacing.x;
        if (n.di == 0) crease += T(n.dj) * (patch->slope_v(there.u) - own->slope_v(at.u)) / own->spacing.y;
    }
    const T sum = glm::length(normal);
    normal /= sum;
    const bool rim = patches <= neighbours.count, agree = sum > T(0.75) * T(patches);
    return {normal, minimum && rim                     ? offset.z
                    : minimum && !agree && crease != 0 ? crease
                                                       : glm::dot(offset, normal)};
}

// The steps of a descent: `at`, the distance function of its patch, and `f` and `active` there. Separate arguments, for an
// object that holds all of them would be kept in memory.

/// How Newton's method in one patch ended.
enum class PatchEnd : unsigned char {
    minimum,    ///< at a minimum inside the patch, or on its border with F falling nowhere in the patch
    resolution, ///< the next step is below the resolution of u and v
    work_limit, ///< after as many steps or refused steps as are allowed
    border,     ///< on a border
    crossing    ///< on a border, across which Newton's step leads
};

/// Whether a step that ended on a border would go on behind it.
[[nodiscard]] constexpr bool leads_across(NewtonStep step) noexcept {
    return step == NewtonStep::to_border || step == NewtonStep::barely_to_border;
}

/// Newton's method from `at` to the minimum of the patch or to its border. `f` and `active` are those of `at`, and again
/// after PatchEnd::work_limit.
template <Real T, class Way>
[[nodiscard, HFH_ALWAYS_INLINED]] inline PatchEnd
descend_in_patch(const DistanceFunction<T>& distance, SurfacePoint<T>& at,
                 typename DistanceFunction<T>::Value& f, ActiveSet& active, int& steps, int& patches,
                 int max_patches, Way& way) noexcept {
    using enum NewtonStep;
    if (active.is_stationary()) return PatchEnd::minimum;
    while (!way.is_used_up()) {
        if (steps++ == NewtonOptions{}.max_iterations) {
            steps = 0;
            return PatchEnd::work_limit;
        }
        vec2<T> to{at.u, at.v};
        const auto step = active.is_empty() ? newton_step(distance, f, to) : refused;
        if (step == refused) {
            to = safeguarded_step(distance, {at.u, at.v});
            ++patches;
        }
        // Rarely needed, so not before three steps.
        if (steps > 3) [[unlikely]]
            distance.snap_flat_axis(to);
        if (to.x == at.u && to.y == at.v) return PatchEnd::resolution;
        const auto taken = way.shorten(distance, at, to, step);
        at.u = to.x;
        at.v = to.y;
        if (on_border(at)) return leads_across(taken) ? PatchEnd::crossing : PatchEnd::border;
        // A minimum is one by F_u and F_v at the point itself, as the next descent will see them: from the step alone they are
        // not known to within their rounding, and at rest the point would move once more.
        f = distance(at.u, at.v);
        active = {distance, f, vec2<T>{at.u, at.v}};
        if (step == refused && patches >= max_patches) return PatchEnd::work_limit;
        if (active.is_stationary()) return PatchEnd::minimum;
    }
    return PatchEnd::work_limit;
}

/// Goes on in the patch across the edge that was just reached, if F falls there and not back here. Most edges lie across
/// the way, and then there is no need to compare all incident patches.
template <HeightField Field, Real T>
[[nodiscard, HFH_ALWAYS_INLINED]] inline bool
cross_edge(const Field& field, const vec3<T>& query, SurfacePoint<T>& at, DistanceFunction<T>& distance,
           typename DistanceFunction<T>::Value& f, DescentProgress<T>& progress) noexcept {
    const bool over_u = at.u <= 0 || at.u >= 1;
    const int way = (over_u ? at.u : at.v) > 0 ? 1 : -1;
    const auto beyond = seen_from({over_u ? way : 0, over_u ? 0 : way}, at);
    const auto next = field.patch(beyond.cell);
    if (!next) return false;
    const DistanceFunction<T> there{*next, field.lattice().locate(query, beyond.cell)};
    const auto g = there(beyond.u, beyond.v);
    const T squared = there.squared(beyond.u, beyond.v, g.z);
    // F_u or F_v at the same point in the patch that the step came from.
    const T back = over_u ? distance.dx2 * (at.u - distance.query_u) + g.z * distance.slope_u(at.v)
                          : distance.dy2 * (at.v - distance.query_v) + g.z * distance.slope_v(at.u);
    const bool falls_back =
        !(T(way) * back <= (over_u ? distance.gradient_error_u : distance.gradient_error_v));
    const bool falls_on =
        T(-way) * (over_u ? g.fu : g.fv) > (over_u ? there.gradient_error_u : there.gradient_error_v);
    if (falls_back || !falls_on || !(squared < progress.nearest)) return false;
    progress.nearest = squared;
    progress.stalls = {};
    at = beyond;
    distance = there;
    f = g;
    return true;
}

/// Counts a visit to a border without coming nearer; from 1 again two cells or more from where the others began.
[[nodiscard, gnu::noinline]] inline Stalls one_more_stall(Stalls before, Cell at) noexcept {
    const auto i = static_cast<unsigned>(at.i), j = static_cast<unsigned>(at.j),
               place = unsigned{before.place};
    const bool is_near = (i - place + 1) % 16 <= 2 && (j - place / 16 + 1) % 16 <= 2;
    if (before.count > 0 && is_near) return {static_cast<unsigned char>(before.count + 1), before.place};
    return {1, static_cast<unsigned char>(i % 16 + 16 * (j % 16))};
}

/// Counts a visit to a border, |σ|² from the query. True if the point does not come nearer any more.
template <Real T>
[[nodiscard, HFH_ALWAYS_INLINED]] inline bool has_stalled(DescentProgress<T>& progress, Cell at,
                                                          T squared) noexcept {
    if (squared < progress.nearest) {
        progress.nearest = squared;
        progress.stalls = {};
        return false;
    }
    progress.stalls = one_more_stall(progress.stalls, at);
    return progress.stalls.count >= 8;
}

/// Begins a descent at a point, |σ|² from the query, or takes it up where it was cut short. True if it goes on by comparing
/// the incident patches.
template <Real T>
[[nodiscard, HFH_ALWAYS_INLINED]] inline bool take_up(DescentProgress<T>& progress, const SurfacePoint<T>& at,
                                                      const ActiveSet& active, T squared) noexcept {
    // The point is no farther than it was on a border before, unless the ground was edited.
    if (progress.resume != DescentResume::start && squared > (1 + 8 * epsilon<T>)*progress.nearest)
        progress = {};
    return on_border(at) && (progress.resume != DescentResume::step || active.is_stationary());
}

/// Goes on in the steepest incident patch.
template <Real T>
[[HFH_ALWAYS_INLINED]] inline void
enter(const SteepestPatch<T>& steepest, SurfacePoint<T>& at, DistanceFunction<T>& distance,
      typename DistanceFunction<T>::Value& f, ActiveSet& active, int& steps) noexcept {
    if (steepest.point.cell == at.cell) return;
    at = steepest.point;
    distance = steepest.distance;
    f = distance(at.u, at.v);
    active = {distance, f, vec2<T>{at.u, at.v}};
    steps = 0;
}

/// The result of a descent that ended at `at`.
template <HeightField Field, Real T>
[[nodiscard, HFH_ALWAYS_INLINED]] inline DescentResult<T>
describe(const Field& field, const SurfacePoint<T>& at, const DistanceFunction<T>& distance, vec2<T> spacing,
         DescentStatus status, int patches) noexcept {
    const T x = spacing.x * (at.u - distance.query_u), y = spacing.y * (at.v - distance.query_v),
            z = distance.gap(at.u, at.v);
    if (on_border(at)) {
        const auto query_side = classify_side(field, at, {x, y, z}, status == DescentStatus::minimum);
        return {status, at, {x, y, z}, query_side.normal, query_side.signed_depth, patches};
    }
    const T zu = distance.slope_u(at.v), zv = distance.slope_v(at.u);
    // S_u × S_v over its length, the square of which is the determinant of Eq. (11) without σ·S_uv.
    const T scale = T(1) / std::sqrt(distance.dx2 * (distance.dy2 + zv * zv) + distance.dy2 * zu * zu);
    const T nx = -zu * spacing.y * scale, ny = -zv * spacing.x * scale, nz = spacing.x * spacing.y * scale;
    return {status, at, {x, y, z}, {nx, ny, nz}, x * nx + y * ny + z * nz, patches};
}

template <HeightField Field, class Way>
[[nodiscard, HFH_ALWAYS_INLINED]] inline DescentResult<typename Field::Scalar>
descend_inline(const Field& field, const vec3<typename Field::Scalar>& query,
               const SurfacePoint<typename Field::Scalar>& start, int max_patches,
               DescentProgress<typename Field::Scalar>& progress, Way way) noexcept {
    using T = typename Field::Scalar;
    const auto first = field.patch(start.cell);
    if (!first) return {.status = DescentStatus::off_hole, .point = start, .patches = 1};

    SurfacePoint<T> at = start;
    DistanceFunction<T> distance{*first, field.lattice().locate(query, at.cell)};
    auto f = distance(at.u, at.v);
    ActiveSet active{distance, f, vec2<T>{at.u, at.v}};
    bool compare = take_up(progress, at, active, distance.squared(at.u, at.v, f.z));
    int steps = progress.steps; // in this patch
    int patches = 1;
    auto status = max_patches > 0 ? DescentStatus::minimum : DescentStatus::work_limit;
    while (max_patches > 0) {
        if (compare) [[unlikely]] {
            if (has_stalled(progress, at.cell, distance.squared(at.u, at.v, f.z))) break;
            const auto steepest =
                steepest_incident_patch(field, query, at, distance, descent_rate(distance, f, at.u, at.v));
            patches += steepest.patches;
            status = steepest.rim;
            if (!steepest.leads_down()) break;
            enter(steepest, at, distance, f, active, steps);
        }
        const auto end = descend_in_patch(distance, at, f, active, steps, patches, max_patches, way);
        if (end == PatchEnd::resolution) break; // with the status of the last comparison
        if (end == PatchEnd::minimum) {
            status = DescentStatus::minimum;
            break;
        }
        compare = false;
        if (end == PatchEnd::crossing && cross_edge(field, query, at, distance, f, progress)) {
            active = {distance, f, vec2<T>{at.u, at.v}};
            steps = 0;
            ++patches;
        } else if (end != PatchEnd::work_limit) {
            f = distance(at.u, at.v);
            active = {distance, f, vec2<T>{at.u, at.v}};
            compare = active.is_stationary() || active.leads_out();
        }
        if (end == PatchEnd::work_limit || patches >= max_patches) [[unlikely]] {
            progress.cut_short(steps, compare);
            status = DescentStatus::work_limit;
            break;
        }
    }
    return describe(field, at, distance, first->spacing, status, patches);
}

} // namespace detail

template <HeightField Field>
[[nodiscard]] DescentResult<typename Field::Scalar>
descend(const Field& field, const vec3<typename Field::Scalar>& query,
        const SurfacePoint<typename Field::Scalar>& start, int max_patches) noexcept {
    DescentProgress<typename Field::Scalar> progress;
    return detail::descend_on(field, query, start, max_patches, progress);
}

} // namespace hfh

#endif // HFH_TRAVERSAL_DESCENT_HPP
