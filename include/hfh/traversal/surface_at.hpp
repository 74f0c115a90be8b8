#ifndef HFH_TRAVERSAL_SURFACE_AT_HPP
#define HFH_TRAVERSAL_SURFACE_AT_HPP

#include <hfh/traversal/candidate_walker.hpp>
#include <hfh/traversal/descent.hpp>

#include <glm/geometric.hpp>

#include <cmath>
#include <initializer_list>
#include <optional>

// Height and normal of the surface over a place in plan.
//
// Based on: Bærentzen and Aanæs, Signed Distance Computation Using the Angle Weighted Pseudonormal (2005), for the normal
// where patches meet.

namespace hfh {

/// The surface over a place in plan.
template <Real T>
struct SurfaceSample {
    SurfacePoint<T> point{};
    T height{}; ///< metres
    vec3<T> normal{
        0, 0,
        1}; ///< unit, upward; where patches meet, the mean of theirs, weighted by the angles that they fill
    bool on_rim = false; ///< a cell that meets at the point has no patch
};

/// Height and normal of the surface over (x, y), in metres; empty where there is none.
///
/// On a grid line the surface is that of either side, so there is a height on the far rims, and on the rim of a hole. A
/// place counts as on a line that it misses by no more than the rounding of its coordinate in U, so a rim is met by
/// x₀ + n·dx, however that was rounded. Any numbers may be given: there is no surface at NaN or infinity.
///
/// Computes in double. Does not throw and does not allocate; looks at four patches at the most, and once more at those that
/// meet at the point.
template <HeightField Field, Real U>
[[nodiscard]] std::optional<SurfaceSample<typename Field::Scalar>> surface_at(const Field& field,
                                                                              const vec2<U>& at) noexcept;

namespace detail {

/// The height of the surface over (x, y) in plan, in double; empty where there is none.
template <HeightField Field>
[[nodiscard]] std::optional<double> height_over(const Field& field, double x, double y) noexcept {
    const Lattice lattice = field.lattice();
    const double u = lattice.u_of(x, 0), v = lattice.v_of(y, 0);
    const Cell cell{static_cast<Index>(std::floor(u)), static_cast<Index>(std::floor(v))};
    const auto patch = field.patch(cell);
    if (!patch) return std::nullopt;
    return widen(*patch).height(lattice.u_of(x, cell.i), lattice.v_of(y, cell.j));
}

/// The height of the surface at a point of it.
template <HeightField Field>
[[nodiscard]] std::optional<double> height_at(const Field& field,
                                              const SurfacePoint<typename Field::Scalar>& at) noexcept {
    const auto patch = field.patch(at.cell);
    if (!patch) return std::nullopt;
    return widen(*patch).height(widen(at.u), widen(at.v));
}

/// Which side of the surface a point is on, vertically; none where there is no surface over or under it.
template <HeightField Field>
[[nodiscard]] Side side_of(const Field& field, const glm::dvec3& at) noexcept {
    const auto height = height_over(field, at.x, at.y);
    return !height ? Side::none : at.z < *height ? Side::below : Side::above;
}

/// The mean normal of the patches that meet at a point, and whether there are as many as cells.
struct MeanNormal {
    glm::dvec3 normal{0, 0, 1};
    bool on_rim = false;
};

/// Weighted by the angle between the two directions along the border in which a patch goes on from the point.
template <HeightField Field>
[[nodiscard, gnu::noinline]] MeanNormal mean_normal(const Field& field,
                                                    const SurfacePoint<double>& at) noexcept {
    const Neighbours neighbours{at.u, at.v};
    glm::dvec3 sum{0.0};
    MeanNormal result;
    const auto add = [&](const SurfacePoint<double>& point) {
        const auto found = field.patch(point.cell);
        if (!found) {
            result.on_rim = true;
            return;
        }
        const BilinearPatch<double> patch = widen(*found);
        double angle = 1;
        if (neighbours.count == 3) {
            const glm::dvec3 along_u = glm::normalize(patch.partial_u(point.v)),
                             along_v = glm::normalize(patch.partial_v(point.u));
            const double same_way = (point.u <= 0) == (point.v <= 0) ? 1 : -1;
            angle = std::acos(glm::clamp(same_way * glm::dot(along_u, along_v), -1.0, 1.0));
        }
        sum += angle * patch.normal(point.u, point.v);
    };
    add(at);
    for (const Neighbour n : neighbours) add(seen_from(n, at));
    const double length = glm::length(sum);
    if (length > 0) result.normal = sum / length;
    return result;
}

/// A coordinate in cells: which cell, and where in it. On a line that it misses by no more than `rounding` metres it is on it,
/// and the cell below the line is another one to look into.
struct PlaceInCells {
    Index cell;
    double parameter;
    bool on_line;
};
template <Real T = double>
[[nodiscard]] PlaceInCells place_in_cells(double x, double origin, double spacing, double per_metre,
                                          double rounding) noexcept {
    const auto at = cell_coordinate(x, origin, spacing, per_metre);
    if (at.rest <= rounding) return {at.cell, 0, true};
    if (spacing - at.rest <= rounding) return {at.cell + 1, 0, true};
    return {at.cell, glm::clamp(at.rest * per_metre, 0.0, 1.0), false};
}

} // namespace detail

template <HeightField Field, Real U>
std::optional<SurfaceSample<typename Field::Scalar>> surface_at(const Field& field,
                                                                const vec2<U>& at) noexcept {
    using T = typename Field::Scalar;
    const glm::dvec2 place{widen(at.x), widen(at.y)};
    std::optional<SurfaceSample<T>> result;
    const Lattice lattice = field.lattice();
    if (!is_finite(place.x) || !is_finite(place.y) || !lattice.reaches(glm::dvec3{place, 0.0})) return result;
    const auto along = [&](glm::length_t axis) {
        const double origin = lattice.origin()[axis], spacing = lattice.spacing()[axis];
        const double size = glm::max(std::abs(place[axis]), std::abs(origin));
        return detail::place_in_cells(place[axis], origin, spacing, lattice.cells_per_metre()[axis],
                                      glm::min(widen(epsilon<U>) * size, spacing / 4));
    };
    const auto i = along(0), j = along(1);
    for (const Index below_j : {0, 1}) {
        if (below_j > 0 && !j.on_line) break;
        for (const Index below_i : {0, 1}) {
            if (below_i > 0 && !i.on_line) break;
            const SurfacePoint<double> point{{i.cell - below_i, j.cell - below_j},
                                             below_i > 0 ? 1 : i.parameter,
                                             below_j > 0 ? 1 : j.parameter};
            const auto found = field.patch(point.cell);
            if (!found) continue;
            const BilinearPatch<double> patch = widen(*found);
            detail::MeanNormal mean;
            if (on_border(point)) {
                mean = detail::mean_normal(field, point);
            } else {
                mean.normal = patch.normal(point.u, point.v);
            }
            result.emplace(SurfaceSample<T>{{point.cell, static_cast<T>(point.u), static_cast<T>(point.v)},
                                            static_cast<T>(patch.height(point.u, point.v)),
                                            vec3<T>{mean.normal},
                                            mean.on_rim});
            return result;
        }
    }
    return result;
}

} // namespace hfh

#endif // HFH_TRAVERSAL_SURFACE_AT_HPP
