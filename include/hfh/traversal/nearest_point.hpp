#ifndef HFH_TRAVERSAL_NEAREST_POINT_HPP
#define HFH_TRAVERSAL_NEAREST_POINT_HPP

#include <hfh/geometry/patch_minima.hpp>
#include <hfh/geometry/surface_point.hpp>
#include <hfh/traversal/reach_search.hpp>
#include <hfh/traversal/surface_at.hpp>

#include <optional>

// The nearest point of the whole surface to a query, whichever patch it is on: what robots' feet, wheels, magnets and
// virtual fixtures ask for. A proxy is something else: it slides to a local closest point and does not jump (`descend`).
//
//     min over all patches of |S(u, v) − query|,  0 ≤ u, v ≤ 1                       Eq. (8)-(9) [P], of all patches

namespace hfh {

enum class NearestStatus : unsigned char {
    found,       ///< the nearest point of all; of several equally near ones either
    none_within, ///< every point of the surface is farther than `max_distance`; or there is none
    /// After max_work cells and blocks. What the result holds, if `has_point()`, is a point of the surface within
    /// max_distance, but a nearer one may exist.
    work_limit,
    /// A coordinate of the query is NaN, infinite, or `longest` or more in size; max_distance is NaN or below 0; or the
    /// field's lattice is not valid.
    bad_query
};

[[nodiscard]] constexpr const char* to_string(NearestStatus status) noexcept {
    switch (status) {
    case NearestStatus::found: return "found";
    case NearestStatus::none_within: return "none_within";
    case NearestStatus::work_limit: return "work_limit";
    case NearestStatus::bad_query: return "bad_query";
    }
    return "unknown";
}

template <Real T>
struct NearestOptions {
    /// Metres, from 0 on; +∞ limits nothing. A point counts as within it if it misses it by roundings.
    T max_distance = std::numeric_limits<T>::infinity();
    /// Cells and blocks that may be looked at, each some nanoseconds. The patch under the query is always looked at. Without
    /// bounds a query at a distance of d cells looks at about 3·d² of them.
    Index max_work = 100'000;
};

template <Real T>
struct NearestPoint {
    NearestStatus status = NearestStatus::none_within;
    /// Of the query: that on which it is of the patch over or under it; where there is none, of the nearest point's normal;
    /// `none` where the nearest point is on a rim and no patch lies over or under the query. On the surface: above.
    Side side = Side::none;
    SurfacePoint<T> point{}; ///< the cell, and where in it
    vec3<T> position{T(0)};  ///< of that point, in metres
    vec3<T> offset{T(0)}; ///< surface point − query, in metres; not rounded to the size of the coordinates
    vec3<T> normal{0, 0, 1}; ///< unit, upward; where patches meet, as in `SurfaceSample`
    T distance = std::numeric_limits<T>::infinity(); ///< metres, never below 0
    Index work = 0;                                  ///< cells and blocks looked at

    [[nodiscard]] bool has_point() const noexcept { return is_finite(distance); }
    /// Above 0 over the surface, below 0 under it; none where a rim leaves no side, or no point was found.
    [[nodiscard]] std::optional<T> signed_distance() const noexcept {
        if (side == Side::none) return std::nullopt;
        return side == Side::below ? -distance : distance;
    }
};

/// The nearest point of the surface to `query` (world coordinates, metres) within a distance.
///
/// Exact on the bilinear patches, with holes, rims and queries beside the grid: no point of the surface is nearer by more
/// than 1e-12 in double and 4e-6 in float of the largest of the distance, the cell's diagonal and the relief of the patch,
/// and by the rounding of x − x₀ and y − y₀. The patch under the query is solved first. Then only cells are read that come
/// as near in plan: ring by ring around the query's, or, with a `BoundedHeightField`, block by block, the nearest first.
/// Patches whose corners lie too far are not solved.
///
/// Computes in double. Does not throw and does not allocate.
template <HeightField Field>
[[nodiscard]] NearestPoint<typename Field::Scalar>
nearest_point(const Field& field, const vec3<typename Field::Scalar>& query,
              const NearestOptions<typename Field::Scalar>& options = {}) noexcept;

namespace detail {

/// Whether queries can be answered; else the status is `bad_query`.
template <HeightField Field>
[[nodiscard]] bool is_query(const Field& field, const vec3<typename Field::Scalar>& query,
                            typename Field::Scalar max_distance) noexcept {
    return is_height(query.x) && is_height(query.y) && is_height(query.z) && is_upper_limit(max_distance) &&
           field.lattice().valid();
}

/// The square of a distance, and a little more: a point at this very distance counts as within it.
template <Real T>
[[nodiscard]] double square_of_reach(T distance) noexcept {
    const double d = widen(distance);
    if (!(is_finite(distance) && d < 1e150)) return not_found;
    return d * d * (1 + 4 * widen(epsilon<T>)) + std::numeric_limits<double>::min();
}

/// The side of a query with the nearest point `foot` on this cell, and the normal there.
template <HeightField Field>
[[gnu::noinline]] void describe_at_border(const Field& field, const vec3<typename Field::Scalar>& query,
                                          const SurfacePoint<double>& at, const glm::dvec3& offset,
                                          NearestPoint<typename Field::Scalar>& result) noexcept {
    using T = typename Field::Scalar;
    MeanNormal mean;
    if (on_border(at)) {
        mean = mean_normal(field, at);
    } else if (const auto patch = field.patch(at.cell)) {
        mean.normal = widen(*patch).normal(at.u, at.v);
    }
    result.normal = vec3<T>{mean.normal};
    if (result.side != Side::none) return;
    if (const auto under = surface_at(field, vec2<T>{query.x, query.y})) {
        result.side = query.z < under->height ? Side::below : Side::above;
    } else if (!mean.on_rim) {
        result.side = glm::dot(offset, mean.normal) > 0 ? Side::below : Side::above;
    }
}

} // namespace detail

template <HeightField Field>
NearestPoint<typename Field::Scalar>
nearest_point(const Field& field, const vec3<typename Field::Scalar>& query,
              const NearestOptions<typename Field::Scalar>& options) noexcept {
    using T = typename Field::Scalar;
    using detail::RelativePatch;
    NearestPoint<T> result;
    if (!detail::is_query(field, query, options.max_distance)) {
        result.status = NearestStatus::bad_query;
        return result;
    }
    if (field.cells().empty()) return result;

    detail::ReachSearch<Field> search{field, query, detail::square_of_reach(options.max_distance),
                                      options.max_work};
    RelativePatch::Foot best{.squared = search.reach_squared()};
    RelativePatch nearest;
    Cell cell = search.base();
    bool found = false, over = false;
    if (search.read(cell, nearest)) {
        const auto at = nearest.query();
        over = 0 <= at.u && at.u <= 1 && 0 <= at.v && at.v <= 1;
        RelativePatch::Foot foot{.squared = detail::not_found};
        if (over) {
            result.side = nearest.foot(at.u, at.v).offset.z > 0 ? Side::below : Side::above;
            foot = detail::secular_foot(nearest);
        }
        if (!(foot.squared < detail::not_found)) foot = detail::closest_of_patch(nearest);
        found = foot.squared < best.squared;
        if (found) best = foot;
    }
    bool complete = true;
    search.set_reach_squared(best.squared);
    if (search.reaches_out()) {
        complete = search.run([&](Cell where, const RelativePatch& patch) {
            if (found && patch.is_beyond(best)) return true;
            const auto foot = detail::closest_of_patch(patch);
            if (!(foot.squared < best.squared)) return true;
            best = foot;
            cell = where;
            nearest = patch;
            found = true;
            search.set_reach_squared(best.squared);
            return true;
        });
    }
    result.work = options.max_work - search.work_left();
    result.status = !complete ? NearestStatus::work_limit
                    : found   ? NearestStatus::found
                              : NearestStatus::none_within;
    if (!found) {
        result.side = Side::none;
        return result;
    }
    result.point = {cell, static_cast<T>(best.u), static_cast<T>(best.v)};
    result.offset = vec3<T>{best.offset};
    result.position = vec3<T>{glm::dvec3{widen(query)} + best.offset};
    result.distance = static_cast<T>(std::sqrt(best.squared));
    const SurfacePoint<double> at{cell, best.u, best.v};
    if (on_border(at) || result.side == Side::none) {
        detail::describe_at_border(field, query, at, best.offset, result);
    } else {
        result.normal = vec3<T>{nearest.patch().normal(best.u, best.v)};
    }
    return result;
}

} // namespace hfh

#endif // HFH_TRAVERSAL_NEAREST_POINT_HPP
