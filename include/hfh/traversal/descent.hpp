#ifndef HFH_TRAVERSAL_DESCENT_HPP
#define HFH_TRAVERSAL_DESCENT_HPP

#include <hfh/geometry/closest_point.hpp>
#include <hfh/geometry/surface_point.hpp>
#include <hfh/terrain/height_field.hpp>

#include <glm/geometric.hpp>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.2: the search over neighbouring patches, one at
// an edge and three at a vertex (Figure 6). The paper moves to the patch whose closest point is nearest; here the
// proxy moves only where the surface leads downhill from where it is, so it slides and never jumps.

namespace hfh {

enum class DescentStatus : unsigned char {
    minimum,    ///< no patch at the point has a descent direction
    off_border, ///< pinned to the rim of the grid, with the query beyond it
    off_hole,   ///< pinned to the rim of a hole, with the query beyond it; or the start has no patch
    work_limit ///< `max_patches` were looked at (or Newton's iterations ran out); still no farther than the start
};

/// Where a descent that was cut short is on its way, so that it goes on in another call with the same query as if it had
/// not been cut short: to the bit. Made anew where the query is another one. Heights may have been edited meanwhile.
template <Real T>
struct DescentProgress {
    /// Smallest |σ|² with which the point was on a border, and visits to a border since then. Along a sharp crease two
    /// patches can hand the point back and forth for the last bits: after 8 visits without coming nearer it has arrived.
    T nearest = std::numeric_limits<T>::max();
    unsigned char stalls = 0;
    unsigned char steps = 0; ///< in this patch
    bool under_way = false;  ///< was cut short,
    bool look = false;       ///< where the patches around the point are to be compared
};

template <Real T>
struct DescentResult {
    DescentStatus status = DescentStatus::minimum;
    SurfacePoint<T> point{};
    vec3<T> offset{T(0)};    ///< surface point − query, in metres
    vec3<T> normal{0, 0, 1}; ///< unit, upward; the average over the patches that meet at the point
    /// > 0 if the query lies below the surface at the point, < 0 if above. The sign of offset·normal, as in §4.3.3
    /// [P], but where the averaged normal can point anywhere: where patches that meet there disagree (their mean
    /// normal is shorter than 3/4), a minimum is seen from below in a valley and from above on a ridge; at a rim the
    /// sign of offset.z holds.
    T outward = 0;
    int patches = 0; ///< patches looked at; once more for each step in them that Newton's method refused
};

namespace detail {

/// A step to a neighbouring cell; {0, 0} stays.
struct Neighbour {
    int di, dj;
};

/// The neighbours that share a point of a cell: one at an edge, three at a vertex (Figure 6 [P]), none inside.
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

/// The same point of the surface, as the neighbour sees it.
template <Real T>
[[nodiscard]] SurfacePoint<T> seen_from(Neighbour n, const SurfacePoint<T>& point) noexcept {
    return {{point.cell.i + n.di, point.cell.j + n.dj},
            n.di == 0 ? point.u : T(n.di > 0 ? 0 : 1),
            n.dj == 0 ? point.v : T(n.dj > 0 ? 0 : 1)};
}

/// How steeply F falls from (u, v) along u and along v: F_u²/F_uu and F_v²/F_vv, 0 where it does not fall into the patch.
template <Real T>
[[nodiscard]] vec2<T> falls(const DistanceFunction<T>& distance, const typename DistanceFunction<T>::Value& f,
                            T u, T v) noexcept {
    const bool falls_u =
        (f.fu > distance.gradient_error_u && u > 0) || (f.fu < -distance.gradient_error_u && u < 1);
    const bool falls_v =
        (f.fv > distance.gradient_error_v && v > 0) || (f.fv < -distance.gradient_error_v && v < 1);
    return {falls_u ? f.fu * f.fu / f.fuu : T(0), falls_v ? f.fv * f.fv / f.fvv : T(0)};
}

/// What is around a point on the border of its patch.
template <Real T>
struct Surroundings {
    SurfacePoint<T>
        steepest; ///< the same point in the patch into which F falls most steeply, its own included
    DistanceFunction<T> distance;               ///< of that patch
    bool leads_down = false;                    ///< F falls into that patch
    DescentStatus rim = DescentStatus::minimum; ///< off_…: a patch is missing on the side where the query is
    int patches = 0;                            ///< neighbours looked at
};

/// Compares the patches that meet at a point on the border of its patch, into which F falls by `own`.
template <HeightField Field, Real T>
[[nodiscard, gnu::noinline]] Surroundings<T>
look_around(const Field& field, const vec3<T>& query, const SurfacePoint<T>& at,
            const DistanceFunction<T>& distance, vec2<T> own) noexcept {
    T steepest = own.x + own.y;
    Surroundings<T> around{.steepest = at, .distance = distance, .leads_down = steepest > 0};
    // Of a patch that F falls into, along u and v; < 0: there is none.
    const auto look_into = [&](Neighbour n) {
        ++around.patches;
        const auto there = seen_from(n, at);
        const auto patch = field.patch(there.cell);
        if (!patch) return vec2<T>{-1};
        const DistanceFunction<T> beyond{*patch, field.lattice().locate(query, there.cell)};
        const vec2<T> fall = falls(beyond, beyond(there.u, there.v), there.u, there.v);
        // Along an edge F falls as much on either side, but a steep patch cannot resolve what a level one can.
        const bool enters = (n.di != 0 && fall.x > 0) || (n.dj != 0 && fall.y > 0) || !around.leads_down;
        if (enters && fall.x + fall.y > steepest) {
            steepest = fall.x + fall.y;
            around.steepest = there;
            around.distance = beyond;
            around.leads_down = true;
        }
        return fall;
    };
    Neighbours neighbours{at.u, at.v};
    if (neighbours.count == 3) {
        // Two patches that share an edge have the same slope along it. So the point's own patch and the one opposite tell
        // for all four on which side F is steeper, along u and along v.
        const Neighbour opposite = neighbours.items[2];
        if (const vec2<T> fall = look_into(opposite); fall.x >= 0) {
            const Neighbour steeper{fall.x < own.x ? 0 : opposite.di, fall.y < own.y ? 0 : opposite.dj};
            if ((steeper.di == 0) != (steeper.dj == 0)) (void)look_into(steeper);
            if (around.leads_down) return around;
            neighbours.count = 2; // it is no hole
        }
    }
    const auto seen = field.lattice().locate(query, at.cell);
    for (const Neighbour n : neighbours) {
        if (look_into(n).x >= 0) continue;
        const bool beyond_u = n.di == 0 || (n.di > 0 ? seen.u > 1 : seen.u < 0);
        const bool beyond_v = n.dj == 0 || (n.dj > 0 ? seen.v > 1 : seen.v < 0);
        if (beyond_u && beyond_v) {
            around.rim = field.cells().contains(seen_from(n, at).cell) ? DescentStatus::off_hole
                                                                       : DescentStatus::off_border;
        }
    }
    return around;
}

/// `DescentResult::normal` and `outward`.
template <Real T>
struct Facing {
    vec3<T> normal;
    T outward;
};

/// That of a point on the border of its patch.
template <HeightField Field, Real T>
[[nodiscard, gnu::noinline]] Facing<T> tell_side(const Field& field, SurfacePoint<T> at, vec3<T> offset,
                                                 bool minimum) noexcept {
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

/// `descend`, for a caller in which it is the hot path: returned through memory, its result would cost 6 ns.
template <HeightField Field>
[[nodiscard, gnu::always_inline]] inline DescentResult<typename Field::Scalar>
descend_inline(const Field& field, const vec3<typename Field::Scalar>& query,
               const SurfacePoint<typename Field::Scalar>& start, int max_patches,
               DescentProgress<typename Field::Scalar>& progress) noexcept {
    using T = typename Field::Scalar;
    using enum NewtonStep;
    const auto first = field.patch(start.cell);
    if (!first) return {.status = DescentStatus::off_hole, .point = start, .patches = 1};

    SurfacePoint<T> at = start;
    const vec2<T> spacing = first->spacing;
    DistanceFunction<T> distance{*first, field.lattice().locate(query, at.cell)};
    auto f = distance(at.u, at.v);
    auto status = max_patches > 0 ? DescentStatus::minimum : DescentStatus::work_limit;
    int patches = 1;
    // The point is no farther than it was on a border before, unless the ground was edited.
    if (progress.under_way && distance.squared(at.u, at.v, f.z) > (1 + 8 * epsilon<T>)*progress.nearest)
        progress = {};
    int steps = progress.steps; // in this patch
    ActiveSet active{distance, f, vec2<T>{at.u, at.v}};
    bool look = on_border(at) && (!progress.under_way || progress.look || active.is_stationary());
    const auto cut_short = [&] {
        progress.steps = static_cast<unsigned char>(steps);
        progress.under_way = true;
        progress.look = look;
        status = DescentStatus::work_limit;
    };
    while (max_patches > 0) {
        if (look) {
            const T squared = distance.squared(at.u, at.v, f.z);
            progress.stalls =
                squared < progress.nearest ? 0 : static_cast<unsigned char>(progress.stalls + 1);
            progress.nearest = glm::min(progress.nearest, squared);
            if (progress.stalls >= 8) break;
            const auto around = look_around(field, query, at, distance, falls(distance, f, at.u, at.v));
            patches += around.patches;
            status = around.rim;
            if (!around.leads_down) break;
            if (around.steepest.cell != at.cell) {
                at = around.steepest;
                distance = around.distance;
                f = distance(at.u, at.v);
                active = {distance, f, vec2<T>{at.u, at.v}};
                steps = 0;
            }
        }
        if (active.is_stationary()) {
            status = DescentStatus::minimum;
            break;
        }
        if (steps++ == NewtonOptions{}.max_iterations) {
            steps = 0;
            look = false;
            cut_short();
            break;
        }
        vec2<T> to{at.u, at.v};
        const auto step = active.is_empty() ? newton_step(distance, f, to) : refused;
        if (step == refused) {
            to = safeguarded_step(distance, {at.u, at.v});
            ++patches;
        }
        if (steps > 3) [[unlikely]]
            distance.snap_flat_axis(to);
        if (to.x == at.u && to.y == at.v) break; // below the resolution of u and v
        at.u = to.x;
        at.v = to.y;
        const bool border = on_border(at);
        if (step == arrived && !border) {
            status = DescentStatus::minimum;
            break;
        }
        if (border && (step == to_border || step == barely_to_border)) {
            // Most edges lie across the way: on with the neighbour's slope at once, if F falls there and not back here.
            const bool over_u = at.u <= 0 || at.u >= 1;
            const int way = (over_u ? at.u : at.v) > 0 ? 1 : -1;
            const auto beyond = seen_from({over_u ? way : 0, over_u ? 0 : way}, at);
            if (const auto next = field.patch(beyond.cell)) {
                const DistanceFunction<T> there{*next, field.lattice().locate(query, beyond.cell)};
                const auto g = there(beyond.u, beyond.v);
                const T squared = there.squared(beyond.u, beyond.v, g.z);
                const T back = over_u
                                   ? distance.dx2 * (at.u - distance.query_u) + g.z * distance.slope_u(at.v)
                                   : distance.dy2 * (at.v - distance.query_v) + g.z * distance.slope_v(at.u);
                const bool holds =
                    T(way) * back <= (over_u ? distance.gradient_error_u : distance.gradient_error_v);
                const bool falls = T(-way) * (over_u ? g.fu : g.fv) >
                                   (over_u ? there.gradient_error_u : there.gradient_error_v);
                if (holds && falls && squared < progress.nearest) {
                    progress.nearest = squared;
                    progress.stalls = 0;
                    at = beyond;
                    distance = there;
                    f = g;
                    active = {distance, f, vec2<T>{at.u, at.v}};
                    ++patches;
                    steps = 0;
                    look = false;
                    if (patches < max_patches) continue;
                    cut_short();
                    break;
                }
            }
        }
        f = distance(at.u, at.v);
        active = {distance, f, vec2<T>{at.u, at.v}};
        look = border && (active.is_stationary() || active.leads_out());
        if (patches >= max_patches && (border || step == refused)) {
            cut_short();
            break;
        }
    }

    const T zu = distance.slope_u(at.v), zv = distance.slope_v(at.u);
    const T x = spacing.x * (at.u - distance.query_u), y = spacing.y * (at.v - distance.query_v),
            z = distance.gap(at.u, at.v);
    if (on_border(at)) {
        const auto facing = tell_side(field, at, {x, y, z}, status == DescentStatus::minimum);
        return {status, at, {x, y, z}, facing.normal, facing.outward, patches};
    }
    // S_u × S_v over its length, the square of which is the determinant of Eq. (11) without σ·S_uv.
    const T scale = T(1) / std::sqrt(distance.dx2 * (distance.dy2 + zv * zv) + distance.dy2 * zu * zu);
    const T nx = -zu * spacing.y * scale, ny = -zv * spacing.x * scale, nz = spacing.x * spacing.y * scale;
    return {status, at, {x, y, z}, {nx, ny, nz}, x * nx + y * ny + z * nz, patches};
}

/// `descend`, beginning anew or going on, for where it is not the hot path.
template <HeightField Field>
[[nodiscard, gnu::noinline]] DescentResult<typename Field::Scalar>
descend_on(const Field& field, const vec3<typename Field::Scalar>& query,
           const SurfacePoint<typename Field::Scalar>& start, int max_patches,
           DescentProgress<typename Field::Scalar>& progress) noexcept {
    return descend_inline(field, query, start, max_patches, progress);
}

} // namespace detail

/// Slides a surface point downhill, patch by patch, to the local closest point to `query` (world coordinates).
///
/// Inside a patch Newton's method runs to the local minimum or to the border. Over an edge the point goes on where F
/// falls beyond it; else, and at a vertex, in the patch into which the distance falls most steeply from that very
/// point, its own included; each hop at one point goes to a steeper patch, so hops around a vertex come to an end.
/// The distance never rises. Ends where no patch at the point has a descent direction, and says so if it ends for
/// another reason. Where a patch is missing the rim holds the point; with the query beyond that rim the point has slid
/// off.
///
/// Stops once max_patches were looked at, but never without a step; with max_patches < 1 it takes none, and tells of the
/// start. Looks at max_patches + 5 patches at the most, and at the end once more at those that meet at the point. Does not
/// throw, does not allocate.
template <HeightField Field>
[[nodiscard]] DescentResult<typename Field::Scalar>
descend(const Field& field, const vec3<typename Field::Scalar>& query,
        const SurfacePoint<typename Field::Scalar>& start, int max_patches) noexcept {
    DescentProgress<typename Field::Scalar> progress;
    return detail::descend_on(field, query, start, max_patches, progress);
}

} // namespace hfh

#endif // HFH_TRAVERSAL_DESCENT_HPP
