#ifndef HFH_CONTACT_FORCE_SHADING_HPP
#define HFH_CONTACT_FORCE_SHADING_HPP

#include <hfh/contact/contact.hpp>
#include <hfh/terrain/height_field.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

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

/// The slopes that shading gives the points of one cell, metres per metre.
template <Real T>
struct ShadedCell {
    vec2<T> at[2][2]; ///< at vertex (a, b): at[b][a]

    /// Interpolated bilinearly.
    [[nodiscard]] vec2<T> operator()(T u, T v) const noexcept {
        const vec2<T> at_v0 = (T(1) - u) * at[0][0] + u * at[0][1];
        const vec2<T> at_v1 = (T(1) - u) * at[1][0] + u * at[1][1];
        return (T(1) - v) * at_v0 + v * at_v1;
    }
};

/// Empty where there is no patch. Reads nine patches.
template <HeightField Field>
[[nodiscard]] std::optional<ShadedCell<typename Field::Scalar>> shaded_cell(const Field& field,
                                                                            Cell cell) noexcept {
    using T = typename Field::Scalar;
    if (!field.patch(cell)) return std::nullopt;
    const auto slopes = slopes_around(field, cell);
    return ShadedCell<T>{{{slopes.mean(0, 0), slopes.mean(1, 0)}, {slopes.mean(0, 1), slopes.mean(1, 1)}}};
}

/// The slopes of both levels, blended as the heights are, vertex by vertex. Reads eighteen patches.
template <BlendedHeightField Field>
[[nodiscard]] std::optional<ShadedCell<typename Field::Scalar>> shaded_cell(const Field& field,
                                                                            Cell cell) noexcept {
    using T = typename Field::Scalar;
    if (!field.patch(cell)) return std::nullopt;
    const auto fine = slopes_around(field.finer(), cell);
    ShadedCell<T> blend{{{fine.mean(0, 0), fine.mean(1, 0)}, {fine.mean(0, 1), fine.mean(1, 1)}}};
    if (const T alpha = static_cast<T>(field.alpha()); alpha != 0) {
        const auto coarse = slopes_around(field.coarser(), {cell.i >> 1, cell.j >> 1});
        for (int b = 0; b < 2; ++b) {
            for (int a = 0; a < 2; ++a) {
                const auto mean = mean_slopes(coarse, cell, a, b);
                if (!mean) continue;
                vec2<T>& at = blend.at[b][a];
                const vec2<T> off = *mean - at;
                at = {multiply_add(alpha, off.x, at.x), multiply_add(alpha, off.y, at.y)};
            }
        }
    }
    return blend;
}

/// The unit normal of shading on the side that is felt, for slopes that it gives a point. Where it would point into the
/// face, whose unit normal there is `face`, it is turned back until it lies in the face: the force then never pushes into
/// it. Empty where the slopes or their squares are no numbers.
template <Real T>
[[nodiscard]] std::optional<vec3<T>> shaded_normal(const vec2<T>& slopes, Side side,
                                                   const vec3<T>& face) noexcept {
    const T steepness = std::sqrt(T(1) + slopes.x * slopes.x + slopes.y * slopes.y);
    if (!is_finite(steepness)) return std::nullopt;
    const vec3<T> normal =
        vec3<T>{-slopes.x, -slopes.y, T(1)} / (side == Side::below ? -steepness : steepness);
    const T out = glm::dot(normal, face);
    if (!(out < 0)) return normal;
    const vec3<T> along = normal - out * face;
    const T length = glm::length(along);
    return length > 0 ? along / length : face;
}

} // namespace detail

/// The slopes ∂z/∂x and ∂z/∂y, in metres per metre, that shading gives a surface point: those at the four vertices of
/// its cell, interpolated bilinearly. The slopes at a vertex are the mean over the patches that meet there, holes left
/// out: with all four patches they are the central differences of the samples.
///
/// Continuous over the whole surface: neighbouring cells compute the slopes of a vertex from the same patches in the
/// same order and interpolate along an edge by the same expression, so a point of an edge or a vertex has the same
/// slopes in each of them, to the bit. Reads nine patches. Empty where there is no patch.
///
/// On a blend of two levels the slopes of both are blended as the heights are, vertex by vertex. So the shaded normal does
/// not jump where the level passes a whole number. Reads eighteen patches.
template <HeightField Field>
[[nodiscard]] std::optional<vec2<typename Field::Scalar>>
shaded_slopes(const Field& field, const SurfacePoint<typename Field::Scalar>& point) noexcept {
    const auto shading = detail::shaded_cell(field, point.cell);
    if (!shading) return std::nullopt;
    return (*shading)(point.u, point.v);
}

/// A contact with the shaded normal: the direction of its force is continuous across cells, its depth is that of the
/// true surface.
///
///     normal = ± (−∂z/∂x, −∂z/∂y, 1) / |…|,   penetration = depth·normal,   depth, proxy and point as they were
///
/// So it never pushes into the face, whose normal is the contact's before: where the mean slopes around lean so far off that
/// it would (normal·face < 0), it is turned back until it lies in the face.
///
/// The proxy is the true one, so the penetration of the result is not proxy − stylus. `shaded` is set, and friction then
/// goes by the shaded normals as well (friction.hpp). Shading comes right behind the tracker: tracker, shading, friction,
/// then damping with the force. A contact that does not touch is returned as it is, and so is one that is shaded already.
/// Has no state, does not throw, does not allocate.
template <HeightField Field>
[[nodiscard]] Contact<typename Field::Scalar>
shade_force(const Field& field, const Contact<typename Field::Scalar>& contact) noexcept {
    if (!contact.touching() || contact.shaded) return contact;
    const auto slopes = shaded_slopes(field, contact.point);
    if (!slopes) return contact;
    const auto normal = detail::shaded_normal(*slopes, contact.side, contact.normal);
    if (!normal) return contact;
    Contact<typename Field::Scalar> shaded = contact;
    shaded.shaded = true;
    shaded.normal = *normal;
    shaded.penetration = contact.depth * shaded.normal;
    return shaded;
}

} // namespace hfh

#endif // HFH_CONTACT_FORCE_SHADING_HPP
