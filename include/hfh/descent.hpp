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

/// A surface point in its patch, and the distance to the query there.
template <Real T>
struct Foothold {
    SurfacePoint<T> point;
    vec2<T> spacing;
    DistanceFunction<T> distance;

    [[nodiscard]] vec2<T> where() const noexcept { return {point.u, point.v}; }
    /// Surface point − query, in metres.
    [[nodiscard]] vec3<T> offset() const noexcept {
        return {spacing.x * (point.u - distance.query_u), spacing.y * (point.v - distance.query_v),
                distance.gap(point.u, point.v)};
    }
    /// Unit normal of the patch: S_u × S_v over its length.
    [[nodiscard]] vec3<T> normal() const noexcept {
        const T x = distance.slope_u(point.v) * spacing.y, y = distance.slope_v(point.u) * spacing.x;
        const T z = spacing.x * spacing.y, scale = T(1) / std::sqrt(x * x + y * y + z * z);
        return {-x * scale, -y * scale, z * scale};
    }
};

/// Empty where there is no patch.
template <HeightField Field, Real T>
[[nodiscard, gnu::always_inline]] inline std::optional<Foothold<T>>
stand(const Field& field, const vec3<T>& query, const SurfacePoint<T>& point) noexcept {
    const auto patch = field.patch(point.cell);
    if (!patch) return std::nullopt;
    return Foothold<T>{point, patch->spacing, {*patch, field.lattice().locate(query, point.cell)}};
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
[[nodiscard]] T fall_into(const Foothold<T>& at, const typename DistanceFunction<T>::Value& f,
                          Neighbour entry) noexcept {
    const auto& distance = at.distance;
    const T u = at.point.u, v = at.point.v;
    const bool falls_u = (f.fu > distance.noise_u && u > 0) || (f.fu < -distance.noise_u && u < 1);
    const bool falls_v = (f.fv > distance.noise_v && v > 0) || (f.fv < -distance.noise_v && v < 1);
    const bool stays = entry.di == 0 && entry.dj == 0;
    if (!stays && !(entry.di != 0 && falls_u) && !(entry.dj != 0 && falls_v)) return 0;
    return (falls_u ? f.fu * f.fu / f.fuu : T(0)) + (falls_v ? f.fv * f.fv / f.fvv : T(0));
}

/// What a missing neighbour means: off_… if the query is on its side.
template <HeightField Field, Real T>
[[nodiscard]] DescentStatus rim(const Field& field, const Foothold<T>& at, Neighbour n) noexcept {
    const T u = at.distance.query_u, v = at.distance.query_v;
    const bool beyond_u = n.di == 0 || (n.di > 0 ? u > 1 : u < 0);
    const bool beyond_v = n.dj == 0 || (n.dj > 0 ? v > 1 : v < 0);
    if (!beyond_u || !beyond_v) return DescentStatus::minimum;
    return field.cells().contains(seen_from(n, at.point).cell) ? DescentStatus::off_hole
                                                               : DescentStatus::off_border;
}

enum class Way : unsigned char {
    on,    ///< F falls into the patch of the foothold, which may be another one than before
    moved, ///< along the edge on which the foothold was pinned, nearer; look again from there
    ended  ///< no way down
};

/// From a point on an edge: over it, if F falls more steeply there; or back; or along it, if neither side leads down.
/// `f` is the value of F at `at` before and, unless moved, after.
template <HeightField Field, Real T>
[[nodiscard, gnu::always_inline]] inline Way
from_edge(const Field& field, const vec3<T>& query, Foothold<T>& at, typename DistanceFunction<T>::Value& f,
          DescentResult<T>& result) noexcept {
    const bool over_u = at.point.u <= 0 || at.point.u >= 1;
    const Neighbour n =
        over_u ? Neighbour{at.point.u <= 0 ? -1 : 1, 0} : Neighbour{0, at.point.v <= 0 ? -1 : 1};
    const bool forth = n.di + n.dj > 0;
    auto there = stand(field, query, seen_from(n, at.point));
    ++result.patches;
    result.status = there ? DescentStatus::minimum : rim(field, at, n);

    // Along the edge F is the same for both; what differs is how it falls across.
    const auto across = [&](const DistanceFunction<T>& distance, const auto& value, bool forth_is_down,
                            T& slope, T& curvature) {
        slope = over_u ? value.fu : value.fv;
        curvature = over_u ? value.fuu : value.fvv;
        const T noise = over_u ? distance.noise_u : distance.noise_v;
        return forth_is_down ? slope < -noise : slope > noise;
    };
    T slope, curvature;
    const bool back = across(at.distance, f, !forth, slope, curvature);
    if (there) {
        const auto g = there->distance(there->point.u, there->point.v);
        T slope_there, curvature_there;
        const bool over = across(there->distance, g, forth, slope_there, curvature_there);
        if (over && (!back || slope_there * slope_there * curvature > slope * slope * curvature_there)) {
            at = *there;
            f = g;
            return Way::on;
        }
    }
    if (back) return Way::on;
    if (over_u) {
        const T v = std::abs(f.fv) > at.distance.noise_v ? at.distance.best_v(at.point.u) : at.point.v;
        if (v == at.point.v) return Way::ended;
        at.point.v = v;
    } else {
        const T u = std::abs(f.fu) > at.distance.noise_u ? at.distance.best_u(at.point.v) : at.point.u;
        if (u == at.point.u) return Way::ended;
        at.point.u = u;
    }
    return Way::moved;
}

/// From a vertex: into the patch of the four into which F falls most steeply.
template <HeightField Field, Real T>
[[nodiscard, gnu::noinline]] Way from_vertex(const Field& field, const vec3<T>& query, Foothold<T>& at,
                                             typename DistanceFunction<T>::Value& f,
                                             DescentResult<T>& result) noexcept {
    T fall = fall_into(at, f, {0, 0});
    const Foothold<T> here = at;
    result.status = DescentStatus::minimum;
    for (const Neighbour n : Neighbours{here.point.u, here.point.v}) {
        const auto there = stand(field, query, seen_from(n, here.point));
        ++result.patches;
        if (!there) {
            if (const auto missing = rim(field, here, n); missing != DescentStatus::minimum)
                result.status = missing;
            continue;
        }
        const auto g = there->distance(there->point.u, there->point.v);
        if (const T fall_there = fall_into(*there, g, n); fall_there > fall) {
            fall = fall_there;
            at = *there;
            f = g;
        }
    }
    return fall > 0 ? Way::on : Way::ended;
}

/// Completes normal and outward of a result whose point is `at`, on the border of its patch.
template <HeightField Field, Real T>
[[gnu::noinline]] void tell_side(const Field& field, const Foothold<T>& at,
                                 DescentResult<T>& result) noexcept {
    const T u = at.point.u, v = at.point.v;
    const Neighbours neighbours{u, v};
    int patches = 1;
    T crease = 0; // by how much the slopes, in metres per metre, rise from one side of the point to the other
    for (const Neighbour n : neighbours) {
        const SurfacePoint<T> there = seen_from(n, at.point);
        const auto patch = field.patch(there.cell);
        if (!patch) continue;
        ++patches;
        result.normal += patch->normal(there.u, there.v);
        if (n.dj == 0) crease += T(n.di) * (patch->slope_u(there.v) - at.distance.slope_u(v)) / at.spacing.x;
        if (n.di == 0) crease += T(n.dj) * (patch->slope_v(there.u) - at.distance.slope_v(u)) / at.spacing.y;
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
    result.patches = 1;
    auto found = detail::stand(field, query, start);
    if (!found) {
        result.status = DescentStatus::off_hole;
        return result;
    }

    detail::Foothold<T>& at = *found;
    auto f = at.distance(start.u, start.v);
    T nearest = std::numeric_limits<T>::max();
    int stalls = 0; // visits to a border without having come nearer
    int steps = 0;  // in this patch
    for (;;) {
        const bool border = on_border(at.point);
        if (border) {
            // Along a sharp crease two patches can hand the point back and forth for the last bits.
            const vec3<T> offset = at.offset();
            const T squared = glm::dot(offset, offset);
            stalls = squared < nearest ? 0 : stalls + 1;
            nearest = std::min(nearest, squared);
            if (stalls == 8) break;

            const Cell before = at.point.cell;
            const bool vertex = detail::Neighbours{at.point.u, at.point.v}.count == 3;
            const auto way = vertex ? detail::from_vertex(field, query, at, f, result)
                                    : detail::from_edge(field, query, at, f, result);
            if (way == detail::Way::ended) break;
            if (way == detail::Way::moved) {
                f = at.distance(at.point.u, at.point.v);
                continue;
            }
            if (at.point.cell != before) steps = 0;
        }
        const detail::Freedom may{at.distance, f, at.where()};
        if (may.none()) {
            result.status = DescentStatus::minimum;
            break;
        }
        if (steps++ == NewtonOptions{}.max_iterations) {
            result.status = DescentStatus::work_limit;
            break;
        }
        vec2<T> to = at.where();
        const auto step =
            may.inside() ? detail::newton_step(at.distance, f, to) : detail::NewtonStep::refused;
        if (step == detail::NewtonStep::refused) detail::cautious_step(at.distance, f, may, to);
        if (to == at.where()) break; // below the resolution of u and v
        at.point.u = to.x;
        at.point.v = to.y;
        if (step == detail::NewtonStep::arrived) {
            result.status = DescentStatus::minimum;
            break;
        }
        if (result.patches >= max_patches && on_border(at.point)) {
            result.status = DescentStatus::work_limit;
            break;
        }
        f = at.distance(to.x, to.y);
    }
    result.point = at.point;
    result.offset = at.offset();
    result.normal = at.normal();
    result.outward = glm::dot(result.offset, result.normal);
    if (on_border(at.point)) detail::tell_side(field, at, result);
    return result;
}

} // namespace hfh

#endif // HFH_DESCENT_HPP
