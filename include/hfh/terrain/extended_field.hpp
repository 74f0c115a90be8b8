#ifndef HFH_TERRAIN_EXTENDED_FIELD_HPP
#define HFH_TERRAIN_EXTENDED_FIELD_HPP

#include <hfh/terrain/height_field.hpp>

#include <algorithm>

namespace hfh {

/// A height field with an extension: beyond the rim of another field it goes on without end, at the height of the nearest
/// point of the rim.
///
///     z(x, y) = field's z at (x, y) clamped to field.cells()
///
/// Without the extension a proxy that slides off the rim is released and the force drops to zero. With it the surface is
/// continuous, with a crease along the rim, and so is the force of a stroke over the rim. Inside, the patches are the
/// field's, to the bit. Outside, a patch repeats the heights of the nearest border cell and is missing where that cell has no
/// patch: a hole at the rim goes on outwards as a gap of its own width. Holes inside stay holes. A field without cells has
/// no extension.
///
/// Costs one comparison of the cell with the field's range for each patch. A cast through free space visits the cells beyond
/// the rim too. Keeps a pointer to the field, which must outlive it; does not throw, does not allocate.
template <HeightField Field>
class ExtendedField {
public:
    using Scalar = typename Field::Scalar;

    constexpr explicit ExtendedField(const Field& field) noexcept : field_{&field} {}
    explicit ExtendedField(const Field&&) = delete; // the field must outlive this one

    [[nodiscard]] constexpr auto lattice() const noexcept { return field_->lattice(); }
    [[nodiscard]] constexpr CellRange cells() const noexcept {
        return field_->cells().empty() ? CellRange{} : CellRange::endless();
    }
    [[nodiscard]] constexpr std::optional<BilinearPatch<Scalar>> patch(Cell c) const noexcept {
        const CellRange inside = field_->cells();
        if (inside.contains(c)) return field_->patch(c);
        if (inside.empty() || !CellRange::endless().contains(c)) return std::nullopt;
        const Cell nearest{std::clamp(c.i, inside.begin.i, inside.end.i - 1),
                           std::clamp(c.j, inside.begin.j, inside.end.j - 1)};
        auto found = field_->patch(nearest);
        if (!found) return std::nullopt;
        auto& p = *found;
        if (c.i < nearest.i) p.p10 = p.p00, p.p11 = p.p01;
        if (c.i > nearest.i) p.p00 = p.p10, p.p01 = p.p11;
        if (c.j < nearest.j) p.p01 = p.p00, p.p11 = p.p10;
        if (c.j > nearest.j) p.p00 = p.p01, p.p10 = p.p11;
        return found;
    }

    [[nodiscard]] constexpr const Field& field() const noexcept { return *field_; }

private:
    const Field* field_;
};

} // namespace hfh

#endif // HFH_TERRAIN_EXTENDED_FIELD_HPP
