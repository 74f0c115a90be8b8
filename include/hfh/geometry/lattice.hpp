#ifndef HFH_GEOMETRY_LATTICE_HPP
#define HFH_GEOMETRY_LATTICE_HPP

#include <hfh/geometry/scalar.hpp>

#include <cmath>
#include <concepts>

// Where the grid lines are: the "direct 1-1 mapping from 2 to 3 space and back" of [P] §4.1 with origin and
// spacing kept, Eq. (6)-(7) in metres.

namespace hfh {

namespace detail {

/// The last cell of a field without a border: 2⁵¹ − 1, the last whose middle a double still counts, or as far as cells
/// of type I can be numbered. The sums of the algorithms need four times as much and a little more.
template <std::signed_integral I>
[[nodiscard]] constexpr I farthest_cell() noexcept {
    constexpr I countable = std::numeric_limits<I>::max() / 4 - 1024;
    if constexpr (std::numeric_limits<I>::digits > 53) {
        constexpr I exact = (I{1} << 51) - 1;
        return countable < exact ? countable : exact;
    } else {
        return countable;
    }
}

} // namespace detail

/// Cell (i, j) lies between vertices (i, j) and (i+1, j+1).
struct Cell {
    Index i = 0;
    Index j = 0;
    friend constexpr bool operator==(const Cell&, const Cell&) noexcept = default;
};

/// The cells begin.i ≤ i < end.i, begin.j ≤ j < end.j.
struct CellRange {
    Cell begin{};
    Cell end{};

    [[nodiscard]] constexpr bool contains(Cell c) const noexcept {
        return begin.i <= c.i && c.i < end.i && begin.j <= c.j && c.j < end.j;
    }
    [[nodiscard]] constexpr bool empty() const noexcept { return end.i <= begin.i || end.j <= begin.j; }

    /// For a field that has no border (a formula): 2⁵¹ cells to every side, where an Index has 32 bits 5·10⁸. That is
    /// 5000 km of cells of a centimetre.
    [[nodiscard]] static constexpr CellRange endless() noexcept {
        constexpr Index farthest = detail::farthest_cell<Index>();
        return {{-farthest, -farthest}, {farthest, farthest}};
    }
};

/// Vertex (i, j) is where grid lines i and j cross: the place of sample (i, j), a corner of the cells (i−1, j−1) to (i, j).
struct Vertex {
    Index i = 0;
    Index j = 0;
    friend constexpr bool operator==(const Vertex&, const Vertex&) noexcept = default;
};

/// The vertices begin.i ≤ i < end.i, begin.j ≤ j < end.j.
struct VertexRange {
    Vertex begin{};
    Vertex end{};

    [[nodiscard]] constexpr bool empty() const noexcept { return end.i <= begin.i || end.j <= begin.j; }
};

/// A point in the parameters of one cell: u along x and v along y, in cells (0 ≤ u, v ≤ 1 inside), z in metres.
template <Real T>
struct CellPoint {
    T u{};
    T v{};
    T z{};
};

/// Whether patches of this spacing can be computed with: each of dx and dy between 1/`longest` and `longest`.
template <Real T>
[[nodiscard]] constexpr bool spacing_in_range(const glm::dvec2& spacing) noexcept {
    constexpr double most = widen(longest<T>), least = 1 / most;
    return is_finite(spacing.x) && is_finite(spacing.y) && least <= spacing.x && spacing.x <= most &&
           least <= spacing.y && spacing.y <= most;
}

namespace detail {

/// metres − lines·spacing, where a line is the number of a grid line. In float it is rounded once, at the end: so two
/// cells see one point at places that are one spacing apart, as far as these can be told, and not to a rounding of `metres`.
template <Real F>
[[nodiscard]] constexpr F from_line(F metres, F lines, F spacing) noexcept {
    if constexpr (std::same_as<F, float>) {
        if (std::is_constant_evaluated())
            return static_cast<float>(widen(metres) - widen(lines) * widen(spacing)); // the product is exact
        return std::fma(-lines, spacing, metres);
    } else {
        return metres - lines * spacing;
    }
}

/// Up to which cell positions in F can tell where in a cell they are: from 2²² on a float has no more than half cells.
template <Real F>
inline constexpr Index farthest_countable = std::same_as<F, float> ? (Index{1} << 22) - 1
                                                                   : CellRange::endless().end.i;

} // namespace detail

/// The horizontal frame of a height field: grid line i is x = x₀ + i·dx, grid line j is y = y₀ + j·dy.
///
/// F is what places are computed in, and by the field's lattice all that a tracker and a cast compute of positions:
/// - double (`Lattice`) is right for every frame, also for a field with Scalar float. The corner of a cell is subtracted
///   before anything is rounded to the scalar, which is what keeps a float field accurate far from the origin: rounding
///   first loses 4 mm at 40 km, 1 m at 10⁷ m.
/// - float (`FloatLattice`) is for processors without a double, with Scalar float, and for a frame near the origin: one
///   whose corners are no more than some thousands of cells from (0, 0). There a position in float tells a thousandth of a
///   cell or less, and nothing here loses more than that: x − x₀ is rounded as x is, and i·dx is subtracted exactly. Farther
///   off the surface is where it is to a rounding of the position, but slopes are felt in steps of that rounding. Origin and
///   spacing are rounded to float.
template <Real F>
class BasicLattice {
public:
    using Scalar = F;

    constexpr BasicLattice() noexcept = default;

    /// Origin (x₀, y₀) and spacing (dx, dy) in metres. Precondition: all finite, dx > 0, dy > 0 (`valid()`). As every
    /// function marked GLM_CONSTEXPR, constexpr where GLM's vectors are, which is everywhere but under GLM_FORCE_INTRINSICS.
    GLM_CONSTEXPR BasicLattice(vec2<F> origin, vec2<F> spacing) noexcept
        : origin_{origin}, spacing_{spacing}, per_metre_{F(1) / spacing.x, F(1) / spacing.y} {}

    [[nodiscard]] constexpr vec2<F> origin() const noexcept { return origin_; }
    [[nodiscard]] constexpr vec2<F> spacing() const noexcept { return spacing_; }
    [[nodiscard]] constexpr vec2<F> cells_per_metre() const noexcept { return per_metre_; }

    [[nodiscard]] constexpr bool valid() const noexcept {
        return is_finite(origin_.x) && is_finite(origin_.y) && is_finite(spacing_.x) &&
               is_finite(spacing_.y) && spacing_.x > 0 && spacing_.y > 0 && is_finite(per_metre_.x) &&
               is_finite(per_metre_.y);
    }

    /// x in cells from grid line i: u = (x − x₀ − i·dx) / dx. Exact to a rounding of the result near line i.
    [[nodiscard]] constexpr F u_of(F x, Index i) const noexcept {
        return detail::from_line(x - origin_.x, static_cast<F>(i), spacing_.x) * per_metre_.x;
    }
    /// y in cells from grid line j.
    [[nodiscard]] constexpr F v_of(F y, Index j) const noexcept {
        return detail::from_line(y - origin_.y, static_cast<F>(j), spacing_.y) * per_metre_.y;
    }

    /// The point p seen from cell c. Eq. (6)-(7) [P] solved for u and v.
    template <Real T>
    [[nodiscard]] constexpr CellPoint<T> locate(const vec3<T>& p, Cell c) const noexcept {
        return {static_cast<T>(u_of(detail::widen_to<F>(p.x), c.i)),
                static_cast<T>(v_of(detail::widen_to<F>(p.y), c.j)), p.z};
    }

    /// Whether column and row numbers of p can be computed at all (an Index holds them, an F counts them).
    template <Real T>
    [[nodiscard]] constexpr bool reaches(const vec3<T>& p) const noexcept {
        constexpr F farthest = static_cast<F>(detail::farthest_countable<F>);
        const F u = (detail::widen_to<F>(p.x) - origin_.x) * per_metre_.x,
                v = (detail::widen_to<F>(p.y) - origin_.y) * per_metre_.y;
        return -farthest < u && u < farthest && -farthest < v && v < farthest;
    }

private:
    vec2<F> origin_{F(0)};
    vec2<F> spacing_{F(1)};
    vec2<F> per_metre_{F(1)};
};

using Lattice = BasicLattice<double>;
using FloatLattice = BasicLattice<float>;

} // namespace hfh

#endif // HFH_GEOMETRY_LATTICE_HPP
