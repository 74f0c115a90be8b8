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
    int patches = 0;         ///< patches looked at
};

namespace detail {

/// A step to a neighbouring cell across the border on which (u, v) lies.
struct Neighbour {
    int di, dj;
};

/// The neighbours that share the point: one at an edge, three at a vertex, none inside. Returns how many.
template <Real T>
[[nodiscard]] int neighbours_at(T u, T v, Neighbour (&out)[3]) noexcept {
    const int di = u <= 0 ? -1 : u >= 1 ? 1 : 0, dj = v <= 0 ? -1 : v >= 1 ? 1 : 0;
    int count = 0;
    if (di != 0) out[count++] = {di, 0};
    if (dj != 0) out[count++] = {0, dj};
    if (di != 0 && dj != 0) out[count++] = {di, dj};
    return count;
}

template <Real T>
[[nodiscard]] SurfacePoint<T> seen_from(const SurfacePoint<T>& point, Neighbour n) noexcept {
    return {{point.cell.i + n.di, point.cell.j + n.dj},
            n.di == 0 ? point.u : T(n.di > 0 ? 0 : 1),
            n.dj == 0 ? point.v : T(n.dj > 0 ? 0 : 1)};
}

/// How steeply F falls from (u, v) into a patch: the sum of F_u²/F_uu and F_v²/F_vv over the components that fall
/// and may move. 0 if F does not fall across the border by which `entry` comes in (no border, if it stays).
template <Real T>
[[nodiscard]] T descent_into(const BilinearPatch<T>& patch, const CellPoint<T>& query, T u, T v,
                             Neighbour entry) noexcept {
    const DistanceFunction<T> distance{patch, query};
    const auto f = distance(u, v);
    const bool falls_u = (f.fu > distance.noise_u && u > 0) || (f.fu < -distance.noise_u && u < 1);
    const bool falls_v = (f.fv > distance.noise_v && v > 0) || (f.fv < -distance.noise_v && v < 1);
    const bool stays = entry.di == 0 && entry.dj == 0;
    if (!stays && !(entry.di != 0 && falls_u) && !(entry.dj != 0 && falls_v)) return 0;
    return (falls_u ? f.fu * f.fu / f.fuu : T(0)) + (falls_v ? f.fv * f.fv / f.fvv : T(0));
}

} // namespace detail

/// Slides a surface point downhill, patch by patch, to the local closest point to `query` (world coordinates).
///
/// On each patch Newton's method runs to the local minimum or to the border. At the border the proxy goes on in
/// the patch in which the distance falls most steeply from that very point; if that is none of the neighbours, it
/// slides along the border. The distance never rises. Ends where no patch at the point has a descent direction, and
/// says so if it ends for another reason. Where a patch is missing the rim holds the point; with the query beyond
/// that rim the point has slid off.
///
/// Looks at no more than about max_patches patches. Does not throw, does not allocate.
template <HeightField Field>
[[nodiscard]] DescentResult<typename Field::Scalar>
descend(const Field& field, const vec3<typename Field::Scalar>& query,
        const SurfacePoint<typename Field::Scalar>& start, int max_patches) noexcept {
    using T = typename Field::Scalar;
    const Lattice& lattice = field.lattice();
    DescentResult<T> result;
    SurfacePoint<T>& at = result.point;
    at = start;

    auto patch = field.patch(at.cell);
    ++result.patches;
    if (!patch) {
        result.status = DescentStatus::off_hole;
        return result;
    }
    auto local = lattice.locate(query, at.cell);
    NewtonOptions newton{.border = BorderRule::stop};
    detail::Neighbour neighbours[3];
    bool finished = false;
    T gap = 0;

    while (!finished) {
        const auto foot = newton_closest_point(*patch, local, {at.u, at.v}, newton);
        at.u = foot.u;
        at.v = foot.v;
        gap = foot.gap;

        // The patch that leads down most steeply, this one included: each hop at one point goes to a steeper
        // patch, so hops around a vertex come to an end.
        T steepest = foot.status == NewtonStatus::at_border
                         ? detail::descent_into(*patch, local, at.u, at.v, {0, 0})
                         : T(0);
        SurfacePoint<T> next{};
        std::optional<BilinearPatch<T>> next_patch;
        CellPoint<T> next_local{};
        DescentStatus rim = DescentStatus::minimum;
        const int count = detail::neighbours_at(at.u, at.v, neighbours);
        for (int k = 0; k < count; ++k) {
            const auto n = neighbours[k];
            const SurfacePoint<T> there = detail::seen_from(at, n);
            const auto candidate = field.patch(there.cell);
            ++result.patches;
            if (!candidate) {
                const bool beyond_u = n.di == 0 || (n.di > 0 ? local.u > 1 : local.u < 0);
                const bool beyond_v = n.dj == 0 || (n.dj > 0 ? local.v > 1 : local.v < 0);
                if (beyond_u && beyond_v) {
                    rim = field.cells().contains(there.cell) ? DescentStatus::off_hole
                                                             : DescentStatus::off_border;
                }
                continue;
            }
            const auto seen = lattice.locate(query, there.cell);
            const T fall = detail::descent_into(*candidate, seen, there.u, there.v, n);
            if (fall > steepest) {
                steepest = fall;
                next = there;
                next_patch = candidate;
                next_local = seen;
            }
        }

        if (next_patch) {
            if (result.patches >= max_patches) {
                result.status = DescentStatus::work_limit;
                break;
            }
            at = next;
            patch = next_patch;
            local = next_local;
            newton.border = BorderRule::stop;
        } else if (foot.status == NewtonStatus::at_border) {
            newton.border = BorderRule::slide;
        } else {
            result.status = foot.status == NewtonStatus::iteration_limit ? DescentStatus::work_limit : rim;
            finished = true;
        }
    }

    const auto spacing = patch->spacing;
    result.offset = {spacing.x * (at.u - local.u), spacing.y * (at.v - local.v), gap};
    result.normal = patch->normal(at.u, at.v);
    const int count = detail::neighbours_at(at.u, at.v, neighbours);
    for (int k = 0; k < count; ++k) {
        const SurfacePoint<T> there = detail::seen_from(at, neighbours[k]);
        if (const auto beside = field.patch(there.cell)) result.normal += beside->normal(there.u, there.v);
    }
    if (count > 0) result.normal = glm::normalize(result.normal);
    return result;
}

} // namespace hfh

#endif // HFH_DESCENT_HPP
