#ifndef HFH_TERRAIN_BLENDED_FIELD_HPP
#define HFH_TERRAIN_BLENDED_FIELD_HPP

#include <hfh/terrain/bilinear_grid.hpp>
#include <hfh/terrain/height_levels.hpp>
#include <hfh/terrain/min_max_pyramid.hpp>

#include <algorithm>
#include <bit>

// Based on: Losasso and Hoppe, Geometry Clipmaps (2004), which blend neighbouring levels so for the eye.

namespace hfh {

/// A height field at any level of detail: (1 − α)·S_k + α·S_{k+1}, with S_k the bilinear surface over the samples of level k.
///
/// It lies on the lattice of level k. There S_{k+1} is bilinear too, because a cell of level k is a quarter of one of level
/// k+1. So the blend is a bilinear patch on every cell, without error: each corner is a height of level k blended with the
/// mean of the 1, 2 or 4 of level k+1 around it. With every α it keeps all promises that are made for height fields. With
/// α = 0 it is a `BilinearGrid` over level k, to the bit; with α = 1 it is the surface that level k+1 has with α = 0, in
/// cells of half the size.
///
///     BlendedField ground{StridedLevels{HeightView{heights, columns, rows}}, frame};
///     ProxyTracker tracker{ground};
///     ground.set_level(2.3);                   // before any stylus; from then on `change_level` of contact/level_change.hpp
///
/// Holes and rims, decided vertex by vertex so that no cracks open: a cell has a patch where its four samples of level k
/// are there. Where one of the samples of level k+1 is missing of which a corner wants the mean, the corner keeps its height
/// of level k. So does the far rim where the cells of level k are odd in number. Neighbouring patches compute a shared corner
/// by the same exact products and one rounding of each sum, whether or not a compiler fuses them.
///
/// A patch costs eight samples in place of four, and with α = 0 four. The level is set between updates, not during one.
/// Does not throw, does not allocate.
template <Real T, LevelSource Levels>
class BlendedField {
public:
    using Scalar = T;
    using Level = BilinearGrid<T, typename Levels::Heights>; ///< one level, not blended

    /// The frame is that of level 0.
    constexpr BlendedField(const Levels& levels, const GridFrame& frame) noexcept
        : levels_{levels}, frame_{frame}, fine_{grid(0)}, coarse_{grid(std::min(1, levels.count() - 1))} {}

    /// That of level 0.
    [[nodiscard]] constexpr GridStatus status() const noexcept { return grid(0).status(); }
    [[nodiscard]] constexpr int level_count() const noexcept { return levels_.count(); }

    /// The samples of level 0.
    [[nodiscard]] constexpr typename Levels::Heights source() const noexcept { return levels_.heights(0); }

    /// Sets the level to any number from 0 to level_count() − 1: k is its whole part and α the rest. Takes the nearest
    /// where there is no such level, and leaves the level as it is if that is NaN. Returns the level that is set.
    constexpr double set_level(double level) noexcept {
        if (!is_finite(level)) return this->level();
        level = std::clamp(level, 0.0, static_cast<double>(level_count() - 1));
        const int k = static_cast<int>(level);
        return blend(k, level - k);
    }
    /// The same with k and α by themselves, so that α may be 1. Takes the nearest that there is; with the coarsest level k
    /// α is 0. Returns the level that is set.
    constexpr double blend(int k, double alpha) noexcept {
        const int last = level_count() - 1;
        k = std::clamp(k, 0, last);
        alpha_ = k == last ? 0.0 : alpha > 0 ? std::min(alpha, 1.0) : 0.0;
        if (k != k_) {
            fine_ = grid(k);
            coarse_ = grid(std::min(k + 1, last));
            k_ = k;
        }
        from_coarse_ = alpha_ > 0.5;
        weight_ = static_cast<T>(from_coarse_ ? 1 - alpha_ : alpha_);
        return level();
    }

    [[nodiscard]] constexpr double level() const noexcept { return k_ + alpha_; } ///< k + α
    [[nodiscard]] constexpr int finer_level() const noexcept { return k_; }       ///< k: that of the lattice
    [[nodiscard]] constexpr double alpha() const noexcept { return alpha_; }
    [[nodiscard]] constexpr const Level& finer() const noexcept { return fine_; } ///< S_k
    [[nodiscard]] constexpr const Level& coarser() const noexcept {
        return coarse_;
    } ///< S_{k+1}, or S_k at the last

    [[nodiscard]] constexpr const Lattice& lattice() const noexcept { return fine_.lattice(); }
    [[nodiscard]] constexpr CellRange cells() const noexcept { return fine_.cells(); }

    [[nodiscard, gnu::always_inline]] constexpr std::optional<BilinearPatch<T>> patch(Cell c) const noexcept {
        auto found = fine_.patch(c);
        if (!found || alpha_ == 0) return found;
        if (const auto coarse = coarse_.patch(cell_above(c))) [[likely]] {
            blend_with(*found, *coarse, c);
        } else {
            blend_where_known(*found, c);
        }
        return found;
    }

    /// See `QuickHeightField`. Compares the samples of both levels, without blending them: the blend lies between them.
    [[nodiscard, gnu::always_inline]] constexpr bool surely_below(Cell one, Cell other, T z) const noexcept {
        return corners_below(fine_, one, other, z) &&
               (alpha_ == 0 || corners_below(coarse_, cell_above(one), cell_above(other), z));
    }

private:
    [[nodiscard]] constexpr Level grid(int k) const noexcept {
        GridFrame frame = frame_;
        frame.spacing *= static_cast<double>(Index{1} << k);
        return {levels_.heights(k), frame};
    }

    /// The cell of level k+1 of which this one of level k is a quarter.
    [[nodiscard]] static constexpr Cell cell_above(Cell c) noexcept { return {c.i >> 1, c.j >> 1}; }

    /// Whether two cells of a level that share a side have patches below z; or one cell given twice.
    [[nodiscard, gnu::always_inline]] static constexpr bool corners_below(const Level& level, Cell one,
                                                                          Cell other, T z) noexcept {
        const CellRange cells = level.cells();
        if (!cells.contains(one) || !cells.contains(other)) return false;
        const Cell low{std::min(one.i, other.i), std::min(one.j, other.j)},
            high{std::max(one.i, other.i), std::max(one.j, other.j)};
        return level.corners_below({low,
                                    {low.i + 1, low.j + 1},
                                    high,
                                    {high.i + 1, high.j + 1},
                                    {high.i + 1, low.j},
                                    {low.i, high.j + 1}},
                                   z);
    }

    /// The blend of a height of level k with one of level k+1: exact at α = 0 and α = 1, never beyond either, and one product
    /// and one sum, so that no two compilations of it differ.
    [[nodiscard, gnu::always_inline]] constexpr T blend_of(T fine, T coarse) const noexcept {
        const T base = from_coarse_ ? coarse : fine, other = from_coarse_ ? fine : coarse;
        return base + weight_ * (other - base);
    }

    [[gnu::always_inline]] constexpr void blend_with(BilinearPatch<T>& fine, const BilinearPatch<T>& coarse,
                                                     Cell c) const noexcept {
        // Halves, so the products in `height` are exact.
        const T u0 = T(0.5) * static_cast<T>(c.i & 1), v0 = T(0.5) * static_cast<T>(c.j & 1);
        const T u1 = u0 + T(0.5), v1 = v0 + T(0.5);
        fine.p00 = blend_of(fine.p00, coarse.height(u0, v0));
        fine.p10 = blend_of(fine.p10, coarse.height(u1, v0));
        fine.p01 = blend_of(fine.p01, coarse.height(u0, v1));
        fine.p11 = blend_of(fine.p11, coarse.height(u1, v1));
    }

    /// The same where the cell of level k+1 has no patch: the corners for which all samples are there.
    [[gnu::noinline]] constexpr void blend_where_known(BilinearPatch<T>& fine, Cell c) const noexcept {
        const Cell above = cell_above(c);
        const auto q00 = coarse_height(above.i, above.j), q10 = coarse_height(above.i + 1, above.j);
        const auto q01 = coarse_height(above.i, above.j + 1), q11 = coarse_height(above.i + 1, above.j + 1);
        // What is missing counts nothing where it has the weight 0.
        const BilinearPatch<T> coarse{q00.value_or(T(0)), q10.value_or(T(0)), q01.value_or(T(0)),
                                      q11.value_or(T(0)), fine.spacing};
        const auto blend_corner = [&](T& corner, Index i, Index j) {
            const bool on_left = i<2, on_right = i> 0, on_bottom = j<2, on_top = j> 0; // in halves
            if ((q00 || !on_left || !on_bottom) && (q10 || !on_right || !on_bottom) &&
                (q01 || !on_left || !on_top) && (q11 || !on_right || !on_top)) {
                corner =
                    blend_of(corner, coarse.height(T(0.5) * static_cast<T>(i), T(0.5) * static_cast<T>(j)));
            }
        };
        const Index i = c.i & 1, j = c.j & 1;
        blend_corner(fine.p00, i, j);
        blend_corner(fine.p10, i + 1, j);
        blend_corner(fine.p01, i, j + 1);
        blend_corner(fine.p11, i + 1, j + 1);
    }

    /// The height of a sample of level k+1, if it is there.
    [[nodiscard]] constexpr std::optional<T> coarse_height(Index i, Index j) const noexcept {
        const auto& heights = coarse_.heights();
        if (i >= heights.columns() || j >= heights.rows()) return std::nullopt;
        const auto sample = heights(i, j);
        const HeightRange<T> range = coarse_.heights_between(sample, sample);
        if (heights.missing(sample) || !coarse_.in_range(range)) return std::nullopt;
        return range.lowest;
    }

    Levels levels_;
    GridFrame frame_;
    Level fine_, coarse_;
    double alpha_ = 0;
    T weight_ = 0;             ///< of the level that counts less
    bool from_coarse_ = false; ///< that is level k
    int k_ = 0;
};

/// Computes in double unless told otherwise.
template <LevelSource Levels>
BlendedField(const Levels&, const GridFrame&) -> BlendedField<double, Levels>;

/// A `BlendedField` over strided levels with bounds, for long casts: use it in the field's place. One pyramid of level 0
/// bounds every level of its samples and every blend of them, because blocks are aligned to the cells of coarser levels. So
/// nothing is built anew when the level changes.
///
///     BoundedBlendedField ground{field, storage.data(), std::ssize(storage)};   // storage as for BoundedGrid
///     ground.build();
///     ProxyTracker tracker{ground};
///
/// Before `build`, and without enough storage, it bounds nothing and is the same surface.
template <Real T, HeightSource Source>
class BoundedBlendedField : public BlendedField<T, StridedLevels<Source>> {
public:
    using Field = BlendedField<T, StridedLevels<Source>>;
    using Bounds = MinMaxPyramid<typename Source::SampleType>;

    constexpr BoundedBlendedField(const Field& field, typename Bounds::Range* storage, Index count) noexcept
        : Field{field}, bounds_{storage, count, field.source().columns(), field.source().rows()} {}

    [[nodiscard]] constexpr const Bounds& bounds() const noexcept { return bounds_; }

    /// See `MinMaxPyramid`; to be called before the first search and, with the samples of level 0 that changed, after each
    /// edit.
    constexpr PyramidStatus build() noexcept { return bounds_.build(this->source()); }
    constexpr PyramidStatus update(const CellRange& samples) noexcept {
        return bounds_.update(this->source(), samples);
    }

    static constexpr int block_bits = Bounds::block_bits;
    /// Those of the lattice's blocks; 0 if there are no bounds.
    [[nodiscard]] constexpr int levels() const noexcept {
        const CellRange cells = this->cells();
        if (bounds_.status() != PyramidStatus::ok || cells.empty()) return 0;
        const auto others = static_cast<std::size_t>((std::max(cells.end.i, cells.end.j) - 1) >> block_bits);
        return 1 + (static_cast<int>(std::bit_width(others)) + 1) / 2;
    }
    /// The lowest and the highest sample of level 0 in the blocks of the pyramid in which these two lie: as large as they on
    /// even levels, twice as wide on odd ones. Precondition: there are such blocks.
    [[nodiscard, gnu::always_inline]] constexpr HeightRange<T> block_range(int level, Cell one,
                                                                           Cell other) const noexcept {
        constexpr HeightRange<T> nothing{std::numeric_limits<T>::lowest(), std::numeric_limits<T>::max()};
        const int k = this->finer_level(), wanted = level + (k + 1) / 2, highest = bounds_.levels() - 1;
        // The highest block holds all.
        const auto block = [&](Cell c) {
            return wanted <= highest ? Cell{c.i >> (k & 1), c.j >> (k & 1)} : Cell{0, 0};
        };
        const auto range = bounds_.range(std::min(wanted, highest), block(one), block(other));
        if (range.holed()) return nothing;
        const HeightRange<T> heights = this->finer().heights_between(range.lowest, range.highest);
        return this->finer().in_range(heights) ? heights : nothing; // one of its patches may be missing
    }

private:
    Bounds bounds_;
};

} // namespace hfh

#endif // HFH_TERRAIN_BLENDED_FIELD_HPP
