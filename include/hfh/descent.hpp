#ifndef HFH_DESCENT_HPP
#define HFH_DESCENT_HPP

#include <hfh/closest_point.hpp>
#include <hfh/height_field.hpp>
#include <hfh/surface.hpp>

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
    int patches = 0; ///< patches looked at
};

namespace detail {

/// A surface point with its patch, and the query as its cell sees it.
template <Real T>
struct Foothold {
    SurfacePoint<T> point{};
    BilinearPatch<T> patch{};
    CellPoint<T> query{};
};

/// Surface point − query, in metres.
template <Real T>
[[nodiscard]] vec3<T> offset(const Foothold<T>& at) noexcept {
    return {at.patch.spacing.x * (at.point.u - at.query.u), at.patch.spacing.y * (at.point.v - at.query.v),
            DistanceFunction<T>{at.patch, at.query}.gap(at.point.u, at.point.v)};
}

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

/// How steeply F falls from a point into its patch: the sum of F_u²/F_uu and F_v²/F_vv over the components that fall
/// and may move. 0 if F does not fall across the border by which `entry` comes in (no border, if it stays).
template <Real T>
[[nodiscard]] T fall_into(const Foothold<T>& at, Neighbour entry) noexcept {
    const DistanceFunction<T> distance{at.patch, at.query};
    const T u = at.point.u, v = at.point.v;
    const auto f = distance(u, v);
    const bool falls_u = (f.fu > distance.noise_u && u > 0) || (f.fu < -distance.noise_u && u < 1);
    const bool falls_v = (f.fv > distance.noise_v && v > 0) || (f.fv < -distance.noise_v && v < 1);
    const bool stays = entry.di == 0 && entry.dj == 0;
    if (!stays && !(entry.di != 0 && falls_u) && !(entry.dj != 0 && falls_v)) return 0;
    return (falls_u ? f.fu * f.fu / f.fuu : T(0)) + (falls_v ? f.fv * f.fv / f.fvv : T(0));
}

/// What is around a point on the border of its patch.
template <Real T>
struct Surroundings {
    Foothold<T> steepest{}; ///< the neighbour into which F falls most steeply, if `leads_down`
    bool leads_down = false;
    DescentStatus rim = DescentStatus::minimum; ///< off_…: a patch is missing on the side where the query is
    int patches = 0;
};

/// Looks for a neighbour into which F falls more steeply than `fall`.
template <HeightField Field, Real T>
[[nodiscard]] Surroundings<T> look_around(const Field& field, const vec3<T>& query, const Foothold<T>& at,
                                          T fall) noexcept {
    Surroundings<T> around;
    for (const Neighbour n : Neighbours{at.point.u, at.point.v}) {
        Foothold<T> there{.point = seen_from(n, at.point)};
        const auto patch = field.patch(there.point.cell);
        ++around.patches;
        if (!patch) {
            const bool beyond_u = n.di == 0 || (n.di > 0 ? at.query.u > 1 : at.query.u < 0);
            const bool beyond_v = n.dj == 0 || (n.dj > 0 ? at.query.v > 1 : at.query.v < 0);
            if (beyond_u && beyond_v) {
                around.rim = field.cells().contains(there.point.cell) ? DescentStatus::off_hole
                                                                      : DescentStatus::off_border;
            }
            continue;
        }
        there.patch = *patch;
        there.query = field.lattice().locate(query, there.point.cell);
        if (const T fall_there = fall_into(there, n); fall_there > fall) {
            fall = fall_there;
            around.steepest = there;
            around.leads_down = true;
        }
    }
    return around;
}

/// Sets normal and outward of a result whose point is `at`.
template <HeightField Field, Real T>
void tell_side(const Field& field, const Foothold<T>& at, DescentResult<T>& result) noexcept {
    const T u = at.point.u, v = at.point.v;
    result.normal = at.patch.normal(u, v);
    result.outward = glm::dot(result.offset, result.normal);
    const Neighbours neighbours{u, v};
    if (neighbours.count == 0) return;

    int patches = 1;
    T crease = 0; // by how much the slopes, in metres per metre, rise from one side of the point to the other
    for (const Neighbour n : neighbours) {
        const SurfacePoint<T> there = seen_from(n, at.point);
        const auto patch = field.patch(there.cell);
        if (!patch) continue;
        ++patches;
        result.normal += patch->normal(there.u, there.v);
        if (n.dj == 0)
            crease += T(n.di) * (patch->slope_u(there.v) - at.patch.slope_u(v)) / at.patch.spacing.x;
        if (n.di == 0)
            crease += T(n.dj) * (patch->slope_v(there.u) - at.patch.slope_v(u)) / at.patch.spacing.y;
    }
    const T sum = glm::length(result.normal);
    result.normal /= sum;
    const bool minimum = result.status == DescentStatus::minimum, rim = patches <= neighbours.count;
    const bool agree = sum > T(0.75) * T(patches);
    result.outward = minimum && rim                     ? result.offset.z
                     : minimum && !agree && crease != 0 ? crease
                                                        : glm::dot(result.offset, result.normal);
}

} // namespace detail

/// Slides a surface point downhill, patch by patch, to the local closest point to `query` (world coordinates).
///
/// Inside a patch Newton's method runs to the local minimum or to the border. On a border the point goes on in the
/// patch into which the distance falls most steeply from that very point, its own included; each hop at one point
/// goes to a steeper patch, so hops around a vertex come to an end. The distance never rises. Ends where no patch at
/// the point has a descent direction, and says so if it ends for another reason. Where a patch is missing the rim
/// holds the point; with the query beyond that rim the point has slid off.
///
/// Stops once max_patches were looked at, but never without having got on. Does not throw, does not allocate.
template <HeightField Field>
[[nodiscard]] DescentResult<typename Field::Scalar>
descend(const Field& field, const vec3<typename Field::Scalar>& query,
        const SurfacePoint<typename Field::Scalar>& start, int max_patches) noexcept {
    using T = typename Field::Scalar;
    DescentResult<T> result;
    result.point = start;
    const auto patch = field.patch(start.cell);
    result.patches = 1;
    if (!patch) {
        result.status = DescentStatus::off_hole;
        return result;
    }

    detail::Foothold<T> at{start, *patch, field.lattice().locate(query, start.cell)};
    T nearest = std::numeric_limits<T>::max();
    int stalls = 0; // visits to a border without having come nearer
    for (;;) {
        if (on_border(at.point)) {
            // Along a sharp crease two patches can hand the point back and forth for the last bits.
            const vec3<T> offset = detail::offset(at);
            const T squared = glm::dot(offset, offset);
            stalls = squared < nearest ? 0 : stalls + 1;
            nearest = std::min(nearest, squared);
            if (stalls == 8) break;

            const T fall = detail::fall_into(at, {0, 0});
            const auto around = detail::look_around(field, query, at, fall);
            result.patches += around.patches;
            result.status = around.rim;
            if (around.leads_down) {
                at = around.steepest;
            } else if (fall == 0) {
                break;
            }
        }
        const auto foot =
            newton_closest_point(at.patch, at.query, {at.point.u, at.point.v}, {.border = BorderRule::stop});
        const bool moved = foot.u != at.point.u || foot.v != at.point.v;
        at.point.u = foot.u;
        at.point.v = foot.v;
        if (foot.status == NewtonStatus::iteration_limit) {
            result.status = DescentStatus::work_limit;
            break;
        }
        if (!moved) break;
        if (!on_border(at.point)) {
            result.status = DescentStatus::minimum;
            break;
        }
        if (result.patches >= max_patches) {
            result.status = DescentStatus::work_limit;
            break;
        }
    }
    result.point = at.point;
    result.offset = detail::offset(at);
    detail::tell_side(field, at, result);
    return result;
}

} // namespace hfh

#endif // HFH_DESCENT_HPP
