#ifndef HFH_TERRAIN_HEIGHT_FIELD_HPP
#define HFH_TERRAIN_HEIGHT_FIELD_HPP

#include <hfh/geometry/bilinear_patch.hpp>
#include <hfh/geometry/lattice.hpp>

#include <concepts>
#include <optional>
#include <type_traits>
#include <utility>

namespace hfh {

/// What places on a field are computed in, by the type of its lattice: double, or float for a `FloatLattice`.
template <class Field>
using FrameScalar = std::conditional_t<
    std::same_as<std::remove_cvref_t<decltype(std::declval<const Field&>().lattice())>, FloatLattice>, float,
    double>;

/// What every algorithm of the library asks of a terrain. `BilinearGrid` is a height field; a formula, a tiled store or a
/// terrain engine becomes one by having
///
///     using Scalar = float or double;
///     Lattice   lattice() const noexcept;       the grid lines; `FloatLattice` for a processor without a double
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
        { field.lattice() } noexcept -> std::convertible_to<BasicLattice<FrameScalar<F>>>;
        requires sizeof(FrameScalar<F>) >= sizeof(typename F::Scalar);
        { field.cells() } noexcept -> std::same_as<CellRange>;
        { field.patch(cell) } noexcept -> std::same_as<std::optional<BilinearPatch<typename F::Scalar>>>;
    };
// clang-format on

/// A height field that compares corners with a height without making patches of them, so that a search passes over
/// cells that lie below it. That pays where samples are stored, and not where each has to be computed.
/// `corners_below(corners, z)` is whether all six vertices are corners of patches and below z, to the bit. The six are
/// the corners of two cells that share an edge, or of one cell with two of them twice. A cell of cells() has a patch
/// exactly where its four corners have heights. Precondition: the cells are in cells().
// clang-format off
template <class F>
concept CorneredHeightField = HeightField<F>
    && requires(const F& field, const Vertex (&corners)[6], typename F::Scalar z) {
        { field.corners_below(corners, z) } noexcept -> std::same_as<bool>;
    };
// clang-format on

/// A height field that tells at little cost of most cells that lie far below a height that they do. If
/// `surely_below(one, other, z)` is true, both cells have patches and these lie below z, to the bit; if it is false, they may
/// all the same. That pays where a patch is computed from samples that bound it. Precondition: `other` is the neighbour of
/// `one` to the right or above, or the same cell.
// clang-format off
template <class F>
concept QuickHeightField = HeightField<F>
    && requires(const F& field, Cell cell, typename F::Scalar z) {
        { field.surely_below(cell, cell, z) } noexcept -> std::same_as<bool>;
    };
// clang-format on

/// A height field whose level of detail is set between updates: any real number. Its lattice is that of the level with the
/// whole number finer_level(), with every 2ᵏ-th grid line of level 0. See `BlendedField`.
// clang-format off
template <class F>
concept LeveledHeightField = HeightField<F>
    && requires(F& field, const F& same, double level) {
        { field.set_level(level) } noexcept;
        { same.finer_level() } noexcept -> std::same_as<int>;
    };
// clang-format on

/// A height field that is the blend (1 − α)·finer() + α·coarser() of two levels of detail, with cells twice as wide in
/// coarser(). See `BlendedField`.
// clang-format off
template <class F>
concept BlendedHeightField = HeightField<F>
    && requires(const F& field) {
        requires HeightField<std::remove_cvref_t<decltype(field.finer())>>;
        requires HeightField<std::remove_cvref_t<decltype(field.coarser())>>;
        { field.alpha() } noexcept -> std::same_as<double>;
    };
// clang-format on

/// Block (i, j) of a level: a square of cells. See `BoundedHeightField`, which says which cells it holds.
struct Block {
    Index i = 0;
    Index j = 0;
    friend constexpr bool operator==(const Block&, const Block&) noexcept = default;
};

/// Heights in metres between which a piece of surface lies.
template <Real T>
struct HeightRange {
    T lowest, highest;
};

/// A height field that bounds its heights over blocks of cells, so that a long search skips blocks that lie far below or
/// above it. The cells of such a field are numbered from {0, 0}. Block (I, J) of level l holds the cells
///
///     I·2ᵇ ≤ i < (I+1)·2ᵇ,  J·2ᵇ ≤ j < (J+1)·2ᵇ,  b = block_bits + 2 l,  0 ≤ l < levels()
///
/// that are in cells(), and there is at least one; the one block of the highest level holds all. `block_range(l, a, b)`
/// bounds the patches of two `Block`s that share a side, or of one block given twice. Where a cell of them has no patch
/// the range is [lowest, max] of Scalar, which bounds nothing. Precondition: the blocks exist. With levels() = 0
/// nothing is bounded.
// clang-format off
template <class F>
concept BoundedHeightField = HeightField<F>
    && requires(const F& field, int level, Block block) {
        { F::block_bits } -> std::convertible_to<int>;
        { field.levels() } noexcept -> std::same_as<int>;
        { field.block_range(level, block, block) } noexcept -> std::same_as<HeightRange<typename F::Scalar>>;
    };
// clang-format on

} // namespace hfh

#endif // HFH_TERRAIN_HEIGHT_FIELD_HPP
