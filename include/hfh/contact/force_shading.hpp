#ifndef HFH_CONTACT_FORCE_SHADING_HPP
#define HFH_CONTACT_FORCE_SHADING_HPP

#include <hfh/contact/contact.hpp>
#include <hfh/terrain/height_field.hpp>

#include <algorithm>
#include <cmath>

// Based on: Morgenbesser and Srinivasan, Force Shading for Haptic Shape Perception (1996), which is the shading of
// Phong (1975) for the hand; Ruspini, Kolarov and Khatib (1997) use the same for proxies.

namespace hfh {

namespace detail {

/// The slopes of the surface at the four vertices of a cell, each a mean over the patches that meet there.
template <Real T>
class VertexSlopes {
public:
    /// Counts the patch that lies di columns and dj rows beside the cell, each −1, 0 or 1, at those vertices of the cell
    /// that it has.
    void add(const BilinearPatch<T>& patch, Index di, Index dj) noexcept {
        for (Index b = std::max(dj, Index(0)); b <= std::min(dj + 1, Index(1)); ++b) {
            for (Index a = std::max(di, Index(0)); a <= std::min(di + 1, Index(1)); ++a) {
                sum_[b][a] += vec2<T>{(b == dj ? patch.p10 - patch.p00 : patch.p11 - patch.p01),
                                      (a == di ? patch.p01 - patch.p00 : patch.p11 - patch.p10)} /
                              patch.spacing;
                ++patches_[b][a];
            }
        }
    }

    /// Whether a patch was added that has vertex (a, b) of the cell; all four if the cell's own was.
    [[nodiscard]] bool has(int a, int b) const noexcept { return patches_[b][a] > 0; }

    /// The mean slopes, metres per metre, at vertex (a, b) of the cell. Precondition: there are any.
    [[nodiscard]] vec2<T> mean(int a, int b) const noexcept {
        return sum_[b][a] / static_cast<T>(patches_[b][a]);
    }

private:
    vec2<T> sum_[2][2]{{vec2<T>{T(0)}, vec2<T>{T(0)}}, {vec2<T>{T(0)}, vec2<T>{T(0)}}};
    int patches_[2][2]{};
};

/// The slopes at the vertices of a cell, from the nine patches around it.
template <HeightField Field>
[[nodiscard]] VertexSlopes<typename Field::Scalar> slopes_around(const Field& field, Cell cell) noexcept {
    VertexSlopes<typename Field::Scalar> slopes;
    for (Index dj = -1; dj <= 1; ++dj) {
        for (Index di = -1; di <= 1; ++di) {
            if (const auto patch = field.patch({cell.i + di, cell.j + dj})) slopes.add(*patch, di, dj);
        }
    }
    return slopes;
}

/// The slopes at vertex (a, b) of a cell as those of the next coarser level have them: `slopes` are at the vertices of the
/// cell there, of which this one is a quarter. A mean of 1, 2 or 4; empty where one of them is missing.
template <Real T>
[[nodiscard]] std::optional<vec2<T>> mean_slopes(const VertexSlopes<T>& slopes, Cell cell, int a,
                                                 int b) noexcept {
    const int twice_u = static_cast<int>(cell.i & 1) + a, twice_v = static_cast<int>(cell.j & 1) + b;
    vec2<T> sum{T(0)};
    for (int q = 0; q < 2; ++q) {
        for (int p = 0; p < 2; ++p) {
            const int share = (p == 0 ? 2 - twice_u : twice_u) * (q == 0 ? 2 - twice_v : twice_v);
            if (share == 0) continue;
            if (!slopes.has(p, q)) return std::nullopt;
            sum += T(0.25) * static_cast<T>(share) * slopes.mean(p, q);
        }
    }
    return sum;
}

} // namespace detail

/// The slopes ∂z/∂x and ∂z/∂y, in metres per metre, that shading gives a surface point: those at the four vertices of
/// its cell, interpolated bilinearly. The slopes at a vertex are the mean over the patches that meet there, holes left
/// out: with all four patches they are the central differences of the samples.
///
/// Continuous over the whole surface: neighbouring cells compute the slopes of a vertex from the same patches in the
/// same order and interpolate along an edge by the same expression, so a point of an edge or a vertex has the same
/// slopes in each of them, to the bit. Reads nine patches. Empty where there is no patch.
template <HeightField Field>
[[nodiscard]] std::optional<vec2<typename Field::Scalar>>
shaded_slopes(const Field& field, const SurfacePoint<typename Field::Scalar>& point) noexcept {
    using T = typename Field::Scalar;
    detail::VertexSlopes<T> slopes;
    for (Index dj = -1; dj <= 1; ++dj) {
        for (Index di = -1; di <= 1; ++di) {
            const auto patch = field.patch({point.cell.i + di, point.cell.j + dj});
            if (patch)
                slopes.add(*patch, di, dj);
            else if (di == 0 && dj == 0)
                return std::nullopt;
        }
    }
    const T u = point.u, v = point.v;
    const vec2<T> at_v0 = (T(1) - u) * slopes.mean(0, 0) + u * slopes.mean(1, 0);
    const vec2<T> at_v1 = (T(1) - u) * slopes.mean(0, 1) + u * slopes.mean(1, 1);
    return (T(1) - v) * at_v0 + v * at_v1;
}

/// The same on a blend of two levels: the slopes of both levels are blended as the heights are, vertex by vertex. So the
/// shaded normal does not jump where the level passes a whole number. Reads eighteen patches.
template <BlendedHeightField Field>
[[nodiscard]] std::optional<vec2<typename Field::Scalar>>
shaded_slopes(const Field& field, const SurfacePoint<typename Field::Scalar>& point) noexcept {
    using T = typename Field::Scalar;
    if (!field.patch(point.cell)) return std::nullopt;
    const auto fine = detail::slopes_around(field.finer(), point.cell);
    vec2<T> at[2][2] = {{fine.mean(0, 0), fine.mean(1, 0)}, {fine.mean(0, 1), fine.mean(1, 1)}};
    if (const T alpha = static_cast<T>(field.alpha()); alpha != 0) {
        const auto coarse = detail::slopes_around(field.coarser(), {point.cell.i >> 1, point.cell.j >> 1});
        for (int b = 0; b < 2; ++b) {
            for (int a = 0; a < 2; ++a) {
                const auto mean = detail::mean_slopes(coarse, point.cell, a, b);
                if (!mean) continue;
                const vec2<T> off = *mean - at[b][a];
                at[b][a] = {multiply_add(alpha, off.x, at[b][a].x), multiply_add(alpha, off.y, at[b][a].y)};
            }
        }
    }
    const T u = point.u, v = point.v;
    const vec2<T> at_v0 = (T(1) - u) * at[0][0] + u * at[0][1];
    const vec2<T> at_v1 = (T(1) - u) * at[1][0] + u * at[1][1];
    return (T(1) - v) * at_v0 + v * at_v1;
}

/// A contact with the shaded normal: the direction of its force is continuous across cells, its depth is that of the
/// true surface.
///
///     normal = ± (−∂z/∂x, −∂z/∂y, 1) / |…|,   penetration = depth·normal,   depth, proxy and point as they were
///
/// The proxy is the true one, so the penetration of the result is not proxy − stylus. Force evaluator, damping and
/// friction go by penetration and normal, and take the result as they take any contact. Shading comes right behind the
/// tracker: tracker, shading, friction, then damping with the force. A contact that does not touch is returned as it
/// is. Has no state, does not throw, does not allocate.
template <HeightField Field>
[[nodiscard]] Contact<typename Field::Scalar>
shade_force(const Field& field, const Contact<typename Field::Scalar>& contact) noexcept {
    using T = typename Field::Scalar;
    if (!contact.touching()) return contact;
    const auto slopes = shaded_slopes(field, contact.point);
    if (!slopes) return contact;
    const T steepness = std::sqrt(T(1) + slopes->x * slopes->x + slopes->y * slopes->y);
    if (!is_finite(steepness)) return contact;
    Contact<T> shaded = contact;
    shaded.normal =
        vec3<T>{-slopes->x, -slopes->y, T(1)} / (contact.side == Side::below ? -steepness : steepness);
    shaded.penetration = contact.depth * shaded.normal;
    return shaded;
}

} // namespace hfh

#endif // HFH_CONTACT_FORCE_SHADING_HPP
