#ifndef HFH_TERRAIN_HEIGHT_FIELD_HPP
#define HFH_TERRAIN_HEIGHT_FIELD_HPP

#include <hfh/geometry/bilinear_patch.hpp>
#include <hfh/geometry/lattice.hpp>

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
/// `patch(c)` is empty where there is no surface: outside cells(), or where a corner is missing. Its heights are numbers
/// below `longest` in size (`is_height`) and its spacing is the lattice's. Patches of neighbouring cells agree on their
/// shared corners to the bit; the surface is then continuous and the library's guarantees hold. Heights may change between
/// updates, not during one.
// clang-format off
template <class F>
concept HeightField = Real<typename F::Scalar>
    && requires(const F& field, Cell cell) {
        { field.lattice() } noexcept -> std::convertible_to<Lattice>;
        { field.cells() } noexcept -> std::same_as<CellRange>;
        { field.patch(cell) } noexcept -> std::same_as<std::optional<BilinearPatch<typename F::Scalar>>>;
    };
// clang-format on

/// A height field that compares corners with a height without making patches of them, for a search to pass over: worth it
/// where samples are at hand, and not where each has to be computed. `corners_below(corners, z)` tells whether all six
/// are corners of patches and below z, to the bit. They are those of two cells that share an edge, or of one, two of them
/// twice; a cell of cells() has a patch exactly where its four corners have heights. Precondition: the cells are in
/// cells().
// clang-format off
template <class F>
concept CorneredHeightField = HeightField<F>
    && requires(const F& field, const Cell (&corners)[6], typename F::Scalar z) {
        { field.corners_below(corners, z) } noexcept -> std::same_as<bool>;
    };
// clang-format on

/// Heights in metres between which a piece of surface lies.
template <Real T>
struct HeightRange {
    T lowest, highest;
};

/// A height field that can bound its heights over blocks of cells, so that a long search skips what lies far below or
/// above it. The cells of such a field are numbered from {0, 0}. Block (I, J) of level l holds the cells
///
///     I·2ᵇ ≤ i < (I+1)·2ᵇ,  J·2ᵇ ≤ j < (J+1)·2ᵇ,  b = block_bits + 2 l,  0 ≤ l < levels()
///
/// as far as they are in cells(), and has at least one of them; at the highest level it holds all. `block_range(l, a, b)`
/// bounds two blocks that share a side, or one twice: every cell of them holds a patch, and the range bounds them all;
/// where one is missing the range is [lowest, max] of Scalar, which bounds nothing. Precondition: there are such blocks.
/// 0 levels bound nothing.
// clang-format off
template <class F>
concept BoundedHeightField = HeightField<F>
    && requires(const F& field, int level, Cell block) {
        { F::block_bits } -> std::convertible_to<int>;
        { field.levels() } noexcept -> std::same_as<int>;
        { field.block_range(level, block, block) } noexcept -> std::same_as<HeightRange<typename F::Scalar>>;
    };
// clang-format on

} // namespace hfh

#endif // HFH_TERRAIN_HEIGHT_FIELD_HPP
