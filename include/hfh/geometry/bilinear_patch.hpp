#ifndef HFH_GEOMETRY_BILINEAR_PATCH_HPP
#define HFH_GEOMETRY_BILINEAR_PATCH_HPP

#include <hfh/geometry/scalar.hpp>

#include <glm/common.hpp>

#include <cmath>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.1, Eq. (1)-(7).

namespace hfh {

/// One bilinear patch: four corner heights over a cell of dx × dy metres, 0 ≤ u, v ≤ 1.
///
///     P(u, v) = u v A + u B + v C + D                                               Eq. (1) [P]
///
/// With P₀₀ at the cell's corner, x = u·dx and y = v·dy (Eq. (6)-(7) with the spacing kept, so that distances
/// are true distances), and only z is bilinear.
template <Real T>
struct BilinearPatch {
    T p00{}, p10{}, p01{}, p11{}; ///< corner heights in metres; first digit along u, second along v
    vec2<T> spacing{T(1)};        ///< dx, dy in metres, both > 0

    /// z of A, Eq. (2) [P], in metres: how much the slope along u changes from v = 0 to v = 1, and as much that along v.
    [[nodiscard]] constexpr T twist() const noexcept { return (p11 - p01) - (p10 - p00); }

    /// z of Eq. (1), in metres. On an edge it is the same expression of the same two heights and the parameter along the
    /// edge, in either of the two patches that share it; at a corner it is the corner's height, to the bit.
    [[nodiscard]] constexpr T height(T u, T v) const noexcept {
        const T at_v0 = (T(1) - u) * p00 + u * p10;
        const T at_v1 = (T(1) - u) * p01 + u * p11;
        return (T(1) - v) * at_v0 + v * at_v1;
    }

    /// z of S_u = A v + B: metres of height per cell along u.
    [[nodiscard]] constexpr T slope_u(T v) const noexcept {
        return (T(1) - v) * (p10 - p00) + v * (p11 - p01);
    }
    /// z of S_v = A u + C: metres of height per cell along v.
    [[nodiscard]] constexpr T slope_v(T u) const noexcept {
        return (T(1) - u) * (p01 - p00) + u * (p11 - p10);
    }

    /// Eq. (1): the surface point, in metres from the cell's corner (z as the heights).
    [[nodiscard]] constexpr vec3<T> position(T u, T v) const noexcept {
        return {u * spacing.x, v * spacing.y, height(u, v)};
    }
    /// S_u, in metres per cell.
    [[nodiscard]] constexpr vec3<T> partial_u(T v) const noexcept { return {spacing.x, T(0), slope_u(v)}; }
    /// S_v, in metres per cell.
    [[nodiscard]] constexpr vec3<T> partial_v(T u) const noexcept { return {T(0), spacing.y, slope_v(u)}; }

    /// Unit normal S_u × S_v / |S_u × S_v|; its z is never negative.
    [[nodiscard]] vec3<T> normal(T u, T v) const noexcept {
        const T x = slope_u(v) / spacing.x, y = slope_v(u) / spacing.y;
        const T scale = T(1) / std::sqrt(T(1) + x * x + y * y);
        return {-x * scale, -y * scale, scale};
    }

    [[nodiscard]] constexpr T lowest() const noexcept {
        return glm::min(glm::min(p00, p10), glm::min(p01, p11));
    }
    [[nodiscard]] constexpr T highest() const noexcept {
        return glm::max(glm::max(p00, p10), glm::max(p01, p11));
    }
};

/// The same patch in double.
template <Real T>
[[nodiscard]] constexpr BilinearPatch<double> widen(const BilinearPatch<T>& p) noexcept {
    return {widen(p.p00), widen(p.p10), widen(p.p01), widen(p.p11), {widen(p.spacing.x), widen(p.spacing.y)}};
}

namespace detail {

/// The same patch in F, which holds all that its own scalar holds.
template <Real F>
[[nodiscard]] constexpr const BilinearPatch<F>& widen_to(const BilinearPatch<F>& p) noexcept {
    return p;
}
template <std::same_as<double>>
[[nodiscard]] constexpr BilinearPatch<double> widen_to(const BilinearPatch<float>& p) noexcept {
    return widen(p);
}

} // namespace detail

} // namespace hfh

#endif // HFH_GEOMETRY_BILINEAR_PATCH_HPP
