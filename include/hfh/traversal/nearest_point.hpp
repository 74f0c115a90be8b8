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

/// The nearest point so far, and the patch that it is on.
struct NearestSoFar {
    RelativePatch::Foot foot;
    RelativePatch patch{};
    Cell cell{};
    bool found = false;

    /// Takes the closest point of a patch if it is nearer.
    void offer(Cell where, const RelativePatch& other, const RelativePatch::Foot& closest) noexcept {
        if (!(closest.squared < foot.squared)) return;
        foot = closest;
        patch = other;
        cell = where;
        found = true;
    }
};

/// The closest point of the patch that is nearest in plan, and the side of a query over or under it; `none` beside it.
template <Real T = double>
[[nodiscard, HFH_ALWAYS_INLINED]] inline RelativePatch::Foot closest_of_base(const RelativePatch& patch,
                                                                             Side& side) noexcept {
    const auto at = patch.query();
    if (0 <= at.u && at.u <= 1 && 0 <= at.v && at.v <= 1) {
        side = patch.foot(at.u, at.v).offset.z > 0 ? Side::below : Side::above;
        const auto foot = secular_foot(patch);
        if (foot.squared < not_found) return foot;
    }
    return closest_of_patch(patch);
}

/// All of the result but status and work.
template <HeightField Field>
[[HFH_ALWAYS_INLINED]] inline void
describe_nearest(const Field& field, const vec3<typename Field::Scalar>& query, const NearestSoFar& nearest,
                 NearestPoint<typename Field::Scalar>& result) noexcept {
    using T = typename Field::Scalar;
    const RelativePatch::Foot& foot = nearest.foot;
    result.point = {nearest.cell, static_cast<T>(foot.u), static_cast<T>(foot.v)};
    result.offset = vec3<T>{foot.offset};
    result.position = vec3<T>{widen(query) + foot.offset};
    result.distance = static_cast<T>(std::sqrt(foot.squared));
    const SurfacePoint<double> at{nearest.cell, foot.u, foot.v};
    if (on_border(at) || result.side == Side::none) {
        describe_at_border(field, query, at, foot.offset, result);
    } else {
        result.normal = vec3<T>{nearest.patch.patch().normal(foot.u, foot.v)};
    }
}

} // namespace detail

template <HeightField Field>
NearestPoint<typename Field::Scalar>
nearest_point(const Field& field, const vec3<typename Field::Scalar>& query,
              const NearestOptions<typename Field::Scalar>& options) noexcept {
    NearestPoint<typename Field::Scalar> result;
    if (!detail::is_query(field, query, options.max_distance)) {
        result.status = NearestStatus::bad_query;
        return result;
    }
    if (field.cells().empty()) return result;

    detail::ReachSearch<Field> search{field, widen(query), detail::square_of_reach(options.max_distance),
                                      options.max_work};
    detail::NearestSoFar nearest{.foot = {.squared = search.reach_squared()}};
    Side side = Side::none;
    detail::RelativePatch base;
    if (search.read(search.base(), base)) {
        nearest.offer(search.base(), base, detail::closest_of_base(base, side));
        search.set_reach_squared(nearest.foot.squared);
    }
    const bool complete =
        !search.reaches_out() || search.run([&](Cell cell, const detail::RelativePatch& patch) {
            if (nearest.found && patch.is_beyond(nearest.foot)) return true;
            nearest.offer(cell, patch, detail::closest_of_patch(patch));
            search.set_reach_squared(nearest.foot.squared);
            return true;
        });
    result.work = options.max_work - search.work_left();
    result.status = !complete       ? NearestStatus::work_limit
                    : nearest.found ? NearestStatus::found
                                    : NearestStatus::none_within;
    if (nearest.found) {
        result.side = side;
        detail::describe_nearest(field, query, nearest, result);
    }
    return result;
}

} // namespace hfh

#endif // HFH_TRAVERSAL_NEAREST_POINT_HPP
