#ifndef HFH_TRAVERSAL_LOCAL_CLOSEST_POINTS_HPP
#define HFH_TRAVERSAL_LOCAL_CLOSEST_POINTS_HPP

#include <hfh/geometry/patch_minima.hpp>
#include <hfh/geometry/surface_point.hpp>
#include <hfh/traversal/nearest_point.hpp>
#include <hfh/traversal/reach_search.hpp>

#include <span>

// All local closest points of all patches within a distance of a query: what may touch a ball around it.

namespace hfh {

enum class LocalPointsStatus : unsigned char {
    complete,    ///< there are no others
    stopped,     ///< the visitor returned false
    buffer_full, ///< there are more than the caller's span holds
    /// After max_work cells and blocks, or with a patch whose search took too long (`GlobalClosestPoint::max_intervals`):
    /// there may be others.
    work_limit,
    /// A coordinate of the query is NaN, infinite, or `longest` or more in size; `within` is NaN or below 0; or the field's
    /// lattice is not valid.
    bad_query
};
[[nodiscard]] constexpr const char* to_string(LocalPointsStatus status) noexcept {
    switch (status) {
    case LocalPointsStatus::complete: return "complete";
    case LocalPointsStatus::stopped: return "stopped";
    case LocalPointsStatus::buffer_full: return "buffer_full";
    case LocalPointsStatus::work_limit: return "work_limit";
    case LocalPointsStatus::bad_query: return "bad_query";
    }
    return "unknown";
}

/// A point of a patch than which no point of this patch close by is nearer to the query.
template <Real T>
struct LocalClosestPoint {
    SurfacePoint<T> point{}; ///< the patch, and where in it
    vec3<T> offset{T(0)};    ///< surface point − query, in metres
    T distance{};            ///< metres
};

struct LocalPointsResult {
    LocalPointsStatus status = LocalPointsStatus::complete;
    Index count = 0; ///< points that were visited
    Index work = 0;  ///< cells and blocks looked at
};

/// Calls `visit(const LocalClosestPoint<Scalar>&)` for every local closest point of every patch within a distance of the
/// query (world coordinates, metres), in no order, until it returns false.
///
/// A point is a local closest point of its patch if the distance rises, or stays, in every direction into the patch. One
/// patch has up to three inside and more on its edges; two are common where it is bent more sharply than the query is far.
/// Patches are closed and each is asked by itself: a point on an edge is visited once for each patch of which it is one. It
/// need not be one of the surface: beyond a valley's edge the neighbour may be nearer.
///
/// Complete: none is left out, by bounds on the distance and its derivatives (`global_closest_point`). On an edge one may be
/// too many, where the distance is level to first order, within roundings. `within` may be +∞, and a point counts as within it
/// if it misses it by roundings. `max_work` as for `nearest_point`.
///
/// Computes in double. Does not throw and does not allocate, unless the visitor does.
template <HeightField Field, class Visitor>
LocalPointsResult visit_local_closest_points(const Field& field, const vec3<typename Field::Scalar>& query,
                                             typename Field::Scalar within, Visitor&& visit,
                                             Index max_work = 100'000) noexcept;

/// The same into a span of the caller's, from its beginning on; `count` of them are set.
template <HeightField Field>
LocalPointsResult collect_local_closest_points(const Field& field, const vec3<typename Field::Scalar>& query,
                                               typename Field::Scalar within,
                                               std::span<LocalClosestPoint<typename Field::Scalar>> into,
                                               Index max_work = 100'000) noexcept {
    using T = typename Field::Scalar;
    std::size_t count = 0;
    auto result = visit_local_closest_points(
        field, query, within,
        [&](const LocalClosestPoint<T>& found) {
            if (count == into.size()) return false;
            into[count++] = found;
            return true;
        },
        max_work);
    if (result.status == LocalPointsStatus::stopped) {
        result.status = LocalPointsStatus::buffer_full;
        --result.count;
    }
    return result;
}

template <HeightField Field, class Visitor>
LocalPointsResult visit_local_closest_points(const Field& field, const vec3<typename Field::Scalar>& query,
                                             typename Field::Scalar within, Visitor&& visit,
                                             Index max_work) noexcept {
    using T = typename Field::Scalar;
    using detail::MinimaEnd;
    using detail::RelativePatch;
    LocalPointsResult result;
    if (!detail::is_query(field, query, within)) {
        result.status = LocalPointsStatus::bad_query;
        return result;
    }
    if (field.cells().empty()) return result;

    detail::ReachSearch<Field> search{field, query, detail::square_of_reach(within), max_work};
    const auto look = [&](Cell cell, const RelativePatch& patch) {
        const auto end =
            detail::visit_minima(patch, search.reach_squared(), [&](const RelativePatch::Foot& foot) {
                ++result.count;
                return static_cast<bool>(
                    visit(LocalClosestPoint<T>{{cell, static_cast<T>(foot.u), static_cast<T>(foot.v)},
                                               vec3<T>{foot.offset},
                                               static_cast<T>(std::sqrt(foot.squared))}));
            });
        if (end == MinimaEnd::cut_short) result.status = LocalPointsStatus::work_limit;
        if (end == MinimaEnd::stopped) result.status = LocalPointsStatus::stopped;
        return end != MinimaEnd::stopped;
    };
    RelativePatch under;
    const bool goes_on = !search.read(search.base(), under) || look(search.base(), under);
    if (goes_on && search.reaches_out() && !search.run(look) && result.status != LocalPointsStatus::stopped)
        result.status = LocalPointsStatus::work_limit;
    result.work = max_work - search.work_left();
    return result;
}

} // namespace hfh

#endif // HFH_TRAVERSAL_LOCAL_CLOSEST_POINTS_HPP
