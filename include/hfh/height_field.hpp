#ifndef HFH_HEIGHT_FIELD_HPP
#define HFH_HEIGHT_FIELD_HPP

#include <hfh/bilinear_patch.hpp>
#include <hfh/lattice.hpp>

#include <optional>

namespace hfh {

/// What every algorithm of the library asks of a terrain. `BilinearGrid` is one; a formula, a tiled store or
/// somebody else's engine becomes one by having
///
///     using Scalar = float or double;
///     Lattice   lattice() const noexcept;       the grid lines
///     CellRange cells()   const noexcept;       the cells that may hold a patch
///     std::optional<BilinearPatch<Scalar>> patch(Cell) const noexcept;
///
/// `patch(c)` is empty where there is no surface: outside cells(), or where a corner is missing. Its heights are
/// finite and its spacing is the lattice's. Patches of neighbouring cells agree on their shared corners to the
/// bit; the surface is then continuous and the library's guarantees hold. Heights may change between updates,
/// not during one.
// clang-format off
template <class F>
concept HeightField = Real<typename F::Scalar>
    && requires(const F& field, Cell cell) {
        { field.lattice() } noexcept -> std::convertible_to<Lattice>;
        { field.cells() } noexcept -> std::same_as<CellRange>;
        { field.patch(cell) } noexcept -> std::same_as<std::optional<BilinearPatch<typename F::Scalar>>>;
    };
// clang-format on

} // namespace hfh

#endif // HFH_HEIGHT_FIELD_HPP
