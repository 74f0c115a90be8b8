#ifndef HFH_CONTACT_FRICTION_CONE_HPP
#define HFH_CONTACT_FRICTION_CONE_HPP

#include <hfh/geometry/surface_point.hpp>
#include <hfh/terrain/height_field.hpp>

#include <glm/ext/vector_bool2.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

// Based on: the friction cone of Harwin and Melder (2002), hung from each normal that the ground has at a point: on an
// edge and at a vertex of the grid those are the normals of the patches that meet, and all between.

namespace hfh {

/// A surface point seen from a stylus, and the axis of the friction cone that hangs from it into the ground. A stylus
/// inside the cone is held by friction.
template <Real T>
struct FrictionCone {
    /// Surface point − stylus, metres, not rounded to world coordinates.
    vec3<T> offset;
    /// Unit, away from the surface on the side that is felt. On an edge or a vertex of the grid: of all normals that the
    /// ground has there, the one nearest in direction to the offset.
    vec3<T> normal;

    /// At (u, v) of a patch, for a stylus in the coordinates of its cell, with the normal of this patch alone.
    FrictionCone(const BilinearPatch<T>& patch, const CellPoint<T>& stylus, T u, T v,
                 Side side = Side::above) noexcept
        : offset{patch.spacing.x * (u - stylus.u), patch.spacing.y * (v - stylus.v),
                 (patch.p00 - stylus.z) + u * (patch.p10 - patch.p00) + v * patch.slope_v(u)},
          normal{side == Side::below ? -patch.normal(u, v) : patch.normal(u, v)} {}

    /// How far the stylus is outside the cone of slope `coefficient` that hangs from the point into the ground:
    ///
    ///     |offset × n| − coefficient·(offset·n)                                                   metres
    ///
    /// ≤ 0 inside. A stylus on the wrong side of the tangent plane, offset·n < 0, is outside: the coefficient counts as 1
    /// there, so that the result stays continuous and positive.
    [[nodiscard]] T outside(T coefficient) const noexcept {
        const T pressed = glm::dot(offset, normal);
        return glm::length(glm::cross(offset, normal)) - (pressed > 0 ? coefficient : T(1)) * pressed;
    }

    /// The offset, or if the stylus is outside the cone of slope `coefficient` the offset turned the shortest way until the
    /// stylus is on it.
    [[nodiscard]] vec3<T> turned_inside(T coefficient) const noexcept {
        if (outside(coefficient) <= 0) return offset;
        const vec3<T> across = offset - glm::dot(offset, normal) * normal;
        const T aside = glm::length(across);
        const vec3<T> edge = aside > 0 ? normal + coefficient / aside * across : normal;
        return glm::length(offset) / glm::length(edge) * edge;
    }

    /// On an edge or a vertex, where the slope along x is anything from low.x to high.x and that along y from low.y to
    /// high.y: takes the normal that is nearest in direction to the offset.
    ///
    /// With the offset (x, y, z), slopes s along x and t along y, and t fixed, the cosine of the angle between offset and
    /// normal is (A + B s)/√(C + s²)/|offset|, with A = z − y t, B = −x, C = 1 + t². It is greatest at s = B C/A if A > 0,
    /// else at the end of B's sign. Doing that along x and y in turn leads to the greatest cosine, for where it is positive
    /// it has no other maximum; the first guess is exact for an offset whose slopes are within the bounds.
    void turn_to_offset(const vec2<T>& low, const vec2<T>& high, Side side) noexcept {
        const vec3<T> o = side == Side::below ? -offset : offset;
        const auto best = [](T a, T b, T c, T least, T most) {
            return a > 0 ? std::clamp(b * c / a, least, most) : b > 0 ? most : least;
        };
        vec2<T> s{best(o.z, -o.x, T(1), low.x, high.x), best(o.z, -o.y, T(1), low.y, high.y)};
        for (int turn = 0; turn < 8; ++turn) {
            const vec2<T> last = s;
            s.x = best(o.z - o.y * s.y, -o.x, T(1) + s.y * s.y, low.x, high.x);
            s.y = best(o.z - o.x * s.x, -o.y, T(1) + s.x * s.x, low.y, high.y);
            if (s == last) break;
        }
        const vec3<T> nearest = glm::normalize(vec3<T>{-s, T(1)});
        // False where a slope or its square is no number: then the patch's own normal stays.
        if (glm::dot(nearest, nearest) > 0) normal = side == Side::below ? -nearest : nearest;
    }
};

/// The cone at a point of a patch, with the normals of neighbours: on an edge of the cell, across x or across y, the
/// neighbour's normal is the ground's as well, and so are all between the two. `creases` says across which axes
/// neighbours count. Reads at most two more patches; where a neighbour is missing the patch's own normal stands.
template <HeightField Field>
[[nodiscard]] FrictionCone<typename Field::Scalar>
friction_cone(const Field& field, const BilinearPatch<typename Field::Scalar>& patch,
              const CellPoint<typename Field::Scalar>& stylus, const SurfacePoint<typename Field::Scalar>& at,
              Side side, const glm::bvec2& creases = {true, true}) noexcept {
    using T = typename Field::Scalar;
    FrictionCone<T> cone{patch, stylus, at.u, at.v, side};
    const bool across_x = creases.x && !(at.u > 0 && at.u < 1);
    const bool across_y = creases.y && !(at.v > 0 && at.v < 1);
    if (!across_x && !across_y) return cone;
    vec2<T> low{patch.slope_u(at.v) / patch.spacing.x, patch.slope_v(at.u) / patch.spacing.y};
    vec2<T> high = low;
    if (across_x) {
        if (const auto beside = field.patch({at.cell.i + (at.u > 0 ? 1 : -1), at.cell.j})) {
            const T slope = beside->slope_u(at.v) / patch.spacing.x;
            low.x = std::min(low.x, slope), high.x = std::max(high.x, slope);
        }
    }
    if (across_y) {
        if (const auto beside = field.patch({at.cell.i, at.cell.j + (at.v > 0 ? 1 : -1)})) {
            const T slope = beside->slope_v(at.u) / patch.spacing.y;
            low.y = std::min(low.y, slope), high.y = std::max(high.y, slope);
        }
    }
    if (low != high) cone.turn_to_offset(low, high, side);
    return cone;
}

} // namespace hfh

#endif // HFH_CONTACT_FRICTION_CONE_HPP
