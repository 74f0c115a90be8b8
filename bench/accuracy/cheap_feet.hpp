#ifndef HFH_BENCH_ACCURACY_CHEAP_FEET_HPP
#define HFH_BENCH_ACCURACY_CHEAP_FEET_HPP

#include "query_sets.hpp"

#include <glm/geometric.hpp>

// What is done instead of looking for the closest point of the patch.

namespace accuracy {

/// Straight up or down from the query, to the border of the cell if it is not over the cell.
template <Real T>
[[nodiscard]] SurfaceFoot<T> vertical_projection(const Query<T>& query) {
    const auto over = start(query);
    return {over.x, over.y};
}

/// The point of triangle a b c nearest to the origin.
///
/// Based on: Ericson, Real-Time Collision Detection (2005), §5.1.5.
template <Real T>
[[nodiscard]] hfh::vec3<T> nearest_of_triangle(const hfh::vec3<T>& a, const hfh::vec3<T>& b,
                                               const hfh::vec3<T>& c) {
    const auto ab = b - a, ac = c - a;
    const T d1 = -glm::dot(ab, a), d2 = -glm::dot(ac, a);
    if (d1 <= 0 && d2 <= 0) return a;
    const T d3 = -glm::dot(ab, b), d4 = -glm::dot(ac, b);
    if (d3 >= 0 && d4 <= d3) return b;
    const T vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
    const T d5 = -glm::dot(ab, c), d6 = -glm::dot(ac, c);
    if (d6 >= 0 && d5 <= d6) return c;
    const T vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
    const T va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    const T scale = T(1) / (va + vb + vc);
    return a + ab * (vb * scale) + ac * (vc * scale);
}

enum class Diagonal { from_p00, from_p10 };

/// The closest point of the two triangles that the patch is cut into along a diagonal.
template <Real T>
[[nodiscard]] FacetFoot<T> two_triangles(const Query<T>& query, Diagonal diagonal) {
    const auto& p = query.patch;
    const T x = -query.at.u * p.spacing.x, y = -query.at.v * p.spacing.y, z = query.at.z;
    const hfh::vec3<T> p00{x, y, p.p00 - z}, p10{x + p.spacing.x, y, p.p10 - z},
        p01{x, y + p.spacing.y, p.p01 - z}, p11{x + p.spacing.x, y + p.spacing.y, p.p11 - z};
    const bool rising = diagonal == Diagonal::from_p00;
    const auto low = rising ? nearest_of_triangle(p00, p10, p11) : nearest_of_triangle(p00, p10, p01);
    const auto high = rising ? nearest_of_triangle(p00, p11, p01) : nearest_of_triangle(p10, p11, p01);
    // The lower triangle has the edge at v = 0, the upper one that at v = 1.
    const bool lower = glm::dot(low, low) <= glm::dot(high, high);
    const auto& foot = lower ? low : high;
    return {(foot.x - x) / p.spacing.x, (foot.y - y) / p.spacing.y, foot.z,
            lower ? p.p10 - p.p00 : p.p11 - p.p01, lower == rising ? p.p11 - p.p10 : p.p01 - p.p00};
}

} // namespace accuracy

#endif // HFH_BENCH_ACCURACY_CHEAP_FEET_HPP
