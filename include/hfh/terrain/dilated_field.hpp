#ifndef HFH_TERRAIN_DILATED_FIELD_HPP
#define HFH_TERRAIN_DILATED_FIELD_HPP

#include <hfh/terrain/height_field.hpp>

#include <algorithm>
#include <cmath>

// Based on: the dilation of grey-scale morphology, Sternberg, Grayscale Morphology (1986): the centre of a ball that
// rolls over a surface describes the surface dilated by the ball.

namespace hfh {

/// A height field raised by a ball: the ground that the centre of a round tip of radius r feels.
///
///     z_r(x) = max over |y − x| ≤ r of  z(y) + √(r² − |y − x|²)                      x, y horizontal
///
/// at the vertices of a lattice that is `subdivisions` times as fine as the field's, and bilinear between them. It is
/// a height field like any other, so with a tracker on it every promise of the tracker holds, for a proxy that is the
/// tip's centre, on this surface. Nothing is stored: a vertex is computed when it is asked for, from the patches
/// within r (whole patches, not samples alone), so edits are felt at once.
///
/// How far it is from the true offset surface, with n subdivisions: at the vertices no farther than rounding where the
/// patches within r have |twist|·r < dx·dy/2; where they are bent nearly as sharply as the ball, or more, a vertex may be
/// too low. Between the vertices it is too low over convex ground, where the chord runs below the arc, by
/// (dx² + dy²)/(8 r n²) on gentle ground, and too high in creases of the offset surface, by a quarter of the change of
/// slope times dx/n. The tests tagged [tip_error] measure it. A tip smaller than the cells of the fine lattice is not
/// resolved at crests: choose n ≥ 2·dx/r.
///
/// The surface is interpolated because the tracker's guarantees are for bilinear patches: the exact offset surface consists
/// of spheres, cylinders and offsets of bilinear patches that intersect each other. It is for a solid; a sheet would need a
/// second surface, lowered by r, for its other side.
///
/// Around a hole, and beyond the rim, the surface goes on for r, as far as the ball still touches the ground. Holes narrower
/// than the tip close. One vertex costs at most (2r/dx + 3)·(2r/dy + 3) patches of the field, and one patch four vertices.
/// That is microseconds, so limit the tracker's work to a `max_patches` of a hundred or so. Keeps a pointer to the field,
/// which must outlive it; does not throw, does not allocate.
template <HeightField Field>
class DilatedField {
public:
    using Scalar = typename Field::Scalar;

    /// `radius` in metres; not finite or below 0 counts as 0, more than 1000 cells as 1000. `subdivisions` is clamped to 1 …
    /// 1000. If the fine cells are too small to compute with (`spacing_in_range`), the field has no cells.
    constexpr DilatedField(const Field& field, Scalar radius, int subdivisions = 1) noexcept
        : field_{&field}, radius_{is_finite(radius) && radius > 0 ? std::min(radius, widest(field))
                                                                  : Scalar(0)},
          subdivisions_{std::clamp(subdivisions, 1, 1000)} {}
    DilatedField(const Field&&, Scalar, int = 1) = delete; // the field must outlive this one

    [[nodiscard]] constexpr Lattice lattice() const noexcept {
        const Lattice coarse = field_->lattice();
        return {coarse.origin(), coarse.spacing() / static_cast<double>(subdivisions_)};
    }
    [[nodiscard]] constexpr CellRange cells() const noexcept {
        const CellRange inside = field_->cells();
        if (inside.empty() || !spacing_in_range<Scalar>(lattice().spacing())) return {};
        const glm::dvec2 reach =
            widen(radius_) * subdivisions_ * field_->lattice().cells_per_metre() + glm::dvec2{1.0};
        return {{fine_line(inside.begin.i, -reach.x), fine_line(inside.begin.j, -reach.y)},
                {fine_line(inside.end.i, reach.x), fine_line(inside.end.j, reach.y)}};
    }
    [[nodiscard]] std::optional<BilinearPatch<Scalar>> patch(Cell c) const noexcept {
        if (!cells().contains(c)) return std::nullopt;
        const auto z00 = height({c.i, c.j}), z10 = height({c.i + 1, c.j});
        const auto z01 = height({c.i, c.j + 1}), z11 = height({c.i + 1, c.j + 1});
        if (!z00 || !z10 || !z01 || !z11) return std::nullopt;
        return BilinearPatch<Scalar>{*z00, *z10, *z01, *z11, vec2<Scalar>{lattice().spacing()}};
    }

    /// z_r at a vertex of the fine lattice, in metres; empty if the ball touches nothing there.
    [[nodiscard]] std::optional<Scalar> height(Vertex v) const noexcept {
        const Cell home{coarse_line(v.i), coarse_line(v.j)};
        const vec2<Scalar> cell{field_->lattice().spacing()};
        // The ball's centre, in metres from the corner of the cell it is over.
        const vec2<Scalar> centre{
            cell.x * static_cast<Scalar>(v.i - home.i * subdivisions_) / static_cast<Scalar>(subdivisions_),
            cell.y * static_cast<Scalar>(v.j - home.j * subdivisions_) / static_cast<Scalar>(subdivisions_)};
        // Cells that end or begin at the very end of the ball's reach are touched as well.
        const Cell begin{-cells_in((radius_ - centre.x) / cell.x) - 1,
                         -cells_in((radius_ - centre.y) / cell.y) - 1};
        const Cell end{cells_in((centre.x + radius_) / cell.x) + 1,
                       cells_in((centre.y + radius_) / cell.y) + 1};
        std::optional<Scalar> top;
        const auto offer = [&](Index i_off, Index j_off) {
            const vec2<Scalar> corner{static_cast<Scalar>(i_off) * cell.x - centre.x,
                                      static_cast<Scalar>(j_off) * cell.y - centre.y};
            const vec2<Scalar> nearest{std::clamp(Scalar(0), corner.x, corner.x + cell.x),
                                       std::clamp(Scalar(0), corner.y, corner.y + cell.y)};
            const Scalar left = radius_ * radius_ - nearest.x * nearest.x - nearest.y * nearest.y;
            if (left < 0) return;
            const auto found = field_->patch({home.i + i_off, home.j + j_off});
            if (!found || (top && found->highest() + std::sqrt(left) <= *top)) return;
            const Scalar here = highest_centre(*found, corner, nearest);
            if (is_finite(here) && (!top || here > *top)) top = here;
        };
        offer(0, 0); // first, so that patches that are lower everywhere are skipped
        for (Index b = begin.j; b < end.j; ++b) {
            for (Index a = begin.i; a < end.i; ++a) offer(a, b);
        }
        return top;
    }

    [[nodiscard]] constexpr const Field& field() const noexcept { return *field_; }
    [[nodiscard]] constexpr Scalar radius() const noexcept { return radius_; }

private:
    /// The greatest z(y) + √(r² − |y|²) over a patch whose corner 00 lies at `corner` from the ball's centre; `nearest`
    /// is its point nearest to the centre. Along a line the sum is greatest in closed form, at R·s/√(1 + s²) for a
    /// slope s and R² = r² − (distance of the line)²; so it climbs along x and y in turn, from the point where the
    /// mean plane of the patch would touch. The sum is concave where |twist|·r < dx·dy; there the climb leads to the
    /// top, by a factor of (|twist|·r/(dx·dy))² nearer each turn on level ground; elsewhere perhaps to a lower one.
    [[nodiscard]] Scalar highest_centre(const BilinearPatch<Scalar>& patch, const vec2<Scalar>& corner,
                                        const vec2<Scalar>& nearest) const noexcept {
        const vec2<Scalar> cell = patch.spacing, opposite = corner + cell;
        const auto u_of = [&](Scalar x) { return std::clamp((x - corner.x) / cell.x, Scalar(0), Scalar(1)); };
        const auto v_of = [&](Scalar y) { return std::clamp((y - corner.y) / cell.y, Scalar(0), Scalar(1)); };
        const Scalar square = radius_ * radius_;
        const auto touching_at = [](Scalar slope, Scalar left) {
            return std::sqrt(std::max(left, Scalar(0)) / (Scalar(1) + slope * slope)) * slope;
        };

        const Scalar sx = patch.slope_u(Scalar(0.5)) / cell.x, sy = patch.slope_v(Scalar(0.5)) / cell.y;
        const Scalar steep = radius_ / std::sqrt(Scalar(1) + sx * sx + sy * sy);
        Scalar x = std::clamp(sx * steep, corner.x, opposite.x),
               y = std::clamp(sy * steep, corner.y, opposite.y);
        if (!(x * x + y * y <= square)) x = nearest.x, y = nearest.y;

        const auto centre_at = [&](Scalar px, Scalar py) {
            return patch.height(u_of(px), v_of(py)) +
                   std::sqrt(std::max(square - px * px - py * py, Scalar(0)));
        };
        Scalar top = centre_at(x, y);
        for (int turn = 0; turn < 24; ++turn) {
            const Scalar slope_x = patch.slope_u(v_of(y)) / cell.x;
            x = std::clamp(touching_at(slope_x, square - y * y), corner.x, opposite.x);
            const Scalar slope_y = patch.slope_v(u_of(x)) / cell.y;
            y = std::clamp(touching_at(slope_y, square - x * x), corner.y, opposite.y);
            const Scalar here = centre_at(x, y);
            const bool climbs = here > top + epsilon<Scalar> * radius_;
            top = std::max(top, here);
            if (!climbs) break;
        }
        return top;
    }

    [[nodiscard]] static constexpr Scalar widest(const Field& field) noexcept {
        const glm::dvec2 cell = field.lattice().spacing();
        return static_cast<Scalar>(1000 * std::min(cell.x, cell.y));
    }
    /// Floor, of a number of cells that an Index holds.
    [[nodiscard]] static Index cells_in(Scalar x) noexcept { return static_cast<Index>(std::floor(x)); }
    /// The coarse line at or below fine line i.
    [[nodiscard]] constexpr Index coarse_line(Index i) const noexcept {
        const Index n = subdivisions_;
        return i >= 0 ? i / n : -((n - 1 - i) / n);
    }
    /// Fine line over coarse line i and `by` fine cells more, as far as cells can be numbered.
    [[nodiscard]] constexpr Index fine_line(Index i, double by) const noexcept {
        constexpr Index farthest = CellRange::endless().end.i;
        const double line = static_cast<double>(i) * subdivisions_ + by;
        return line < static_cast<double>(-farthest)  ? -farthest
               : line > static_cast<double>(farthest) ? farthest
                                                      : static_cast<Index>(std::floor(line));
    }

    const Field* field_;
    Scalar radius_;
    int subdivisions_;
};

} // namespace hfh

#endif // HFH_TERRAIN_DILATED_FIELD_HPP
