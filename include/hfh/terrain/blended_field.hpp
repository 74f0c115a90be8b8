#ifndef HFH_TERRAIN_BLENDED_FIELD_HPP
#define HFH_TERRAIN_BLENDED_FIELD_HPP

#include <hfh/terrain/bilinear_grid.hpp>
#include <hfh/terrain/height_levels.hpp>
#include <hfh/terrain/min_max_pyramid.hpp>

#include <algorithm>
#include <bit>

// Based on: Losasso and Hoppe, Geometry Clipmaps (2004), which blend neighbouring levels so for the eye.

namespace hfh {

namespace detail {

/// The corners of a cell that is a quarter of one of the next coarser level, as means of that one's corners. Corners are
/// numbered as 00, 10, 01, 11, and so are the quarters.
template <Real T>
struct QuarterMeans {
    T weights[4][4][4]{}; ///< [quarter][corner of the whole][corner of the quarter]: 0, ¼, ½ or 1

    constexpr QuarterMeans() noexcept {
        for (int n = 0; n < 64; ++n) {
            const int quarter = n / 16, whole = n / 4 % 4, corner = n % 4;
            const int twice_u = quarter % 2 + corner % 2, twice_v = quarter / 2 + corner / 2;
            const int share =
                (whole % 2 == 0 ? 2 - twice_u : twice_u) * (whole / 2 == 0 ? 2 - twice_v : twice_v);
            weights[quarter][whole][corner] = T(0.25) * static_cast<T>(share);
        }
    }
};
template <Real T>
inline constexpr QuarterMeans<T> quarter_means;

} // namespace detail

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
/// by the same roundings, to the bit.
///
/// A patch costs eight samples in place of four, and with α = 0 four. The level is set between updates, not during one.
/// Does not throw, does not allocate.
template <Real T, LevelSource Levels>
class BlendedField {
    using Heights = typename Levels::Heights;
    using SampleType = typename Heights::SampleType;

public:
    using Scalar = T;
    using Level = BilinearGrid<T, Heights>; ///< one level, not blended

    /// The frame is that of level 0.
    constexpr BlendedField(const Levels& levels, const GridFrame& frame) noexcept
        : levels_{levels}, frame_{frame}, fine_{grid(0)}, coarse_{grid(std::min(1, levels.count() - 1))} {
        if constexpr (std::is_integral_v<SampleType>) {
            using Limits = std::numeric_limits<SampleType>;
            turn_ = frame.height_scale < 0 ? static_cast<SampleType>(-1) : SampleType(0);
            all_are_heights_ = fine_.in_range(fine_.heights_between(Limits::lowest(), Limits::max()));
        }
    }

    /// That of level 0.
    [[nodiscard]] constexpr GridStatus status() const noexcept { return grid(0).status(); }
    [[nodiscard]] constexpr int level_count() const noexcept { return levels_.count(); }

    /// The samples of level 0.
    [[nodiscard]] constexpr Heights source() const noexcept { return levels_.heights(0); }

    /// Sets the level to any number from 0 to level_count() − 1: k is its whole part and α the rest. Takes the nearest
    /// where there is no such level, and leaves the level as it is for what is no number. Returns the level that is set.
    constexpr double set_level(double level) noexcept {
        if (!is_finite(level)) return this->level();
        level = std::clamp(level, 0.0, static_cast<double>(level_count() - 1));
        const int k = static_cast<int>(level);
        return blend(k, level - k);
    }
    /// The same with k and α by themselves, so that α may be 1. Takes the nearest that there is; with the coarsest level k
    /// α is 0. Returns the level that is set.
    constexpr double blend(int k, double alpha) noexcept {
        if (!is_finite(alpha)) return level();
        const int last = level_count() - 1;
        k = std::clamp(k, 0, last);
        alpha_ = k == last ? 0.0 : std::clamp(alpha, 0.0, 1.0);
        if (k != k_) {
            fine_ = grid(k);
            coarse_ = grid(std::min(k + 1, last));
            k_ = k;
        }
        blends_ = alpha_ != 0;
        nearer_coarse_ = alpha_ > 0.5;
        weight_ = static_cast<T>(nearer_coarse_ ? 1 - alpha_ : alpha_);
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

    [[nodiscard, HFH_ALWAYS_INLINED]] constexpr std::optional<BilinearPatch<T>> patch(Cell c) const noexcept {
        auto found = fine_.patch(c);
        if (!found || !blends_) return found;
        if (const auto coarse = coarse_.patch(cell_above(c))) [[likely]] {
            blend(*found, *coarse, c);
        } else {
            blend_where_known(*found, c);
        }
        return found;
    }

    /// See `QuickHeightField`. Compares the samples of both levels, without blending them: the blend lies between them.
    [[nodiscard, HFH_ALWAYS_INLINED]] constexpr bool surely_below(Cell one, Cell other, T z) const noexcept {
        const Cell above = cell_above(one), other_above = cell_above(other);
        // Four cells of level k lie in each of level k+1.
        const bool there = blends_ ? has_cells(coarse_, above, other_above) : has_cells(fine_, one, other);
        if (!there) return false;
        SampleBounds bounds{in_order(fine_.heights()(one.i, one.j))};
        add_corners(bounds, fine_.heights(), one, other);
        if (blends_) add_corners(bounds, coarse_.heights(), above, other_above);
        if (bounds.holed) return false;
        const SampleType highest = in_order(bounds.highest), lowest = in_order(bounds.lowest);
        if constexpr (std::is_integral_v<SampleType>) {
            return all_are_heights_ && fine_.heights_between(highest, highest).highest < z;
        } else {
            const HeightRange<T> range = fine_.heights_between(lowest, highest);
            return fine_.in_range(range) && range.highest < z;
        }
    }

private:
    [[nodiscard]] constexpr Level grid(int k) const noexcept {
        GridFrame frame = frame_;
        frame.spacing *= static_cast<double>(Index{1} << k);
        return {levels_.heights(k), frame};
    }

    /// The cell of level k+1 of which this one of level k is a quarter.
    [[nodiscard]] static constexpr Cell cell_above(Cell c) noexcept { return {c.i >> 1, c.j >> 1}; }

    /// The lowest and the highest of some samples in order, and whether one of them is a hole.
    struct SampleBounds {
        SampleType lowest, highest = lowest;
        bool holed = false;
    };

    /// Integers in the order of their heights, which the height scale may turn around. Turns them back as well.
    [[nodiscard]] constexpr SampleType in_order(SampleType sample) const noexcept {
        if constexpr (std::is_integral_v<SampleType>) return static_cast<SampleType>(sample ^ turn_);
        return sample;
    }
    [[HFH_ALWAYS_INLINED]] constexpr void add(SampleBounds& bounds, const Heights& heights, Index i,
                                              Index j) const noexcept {
        const SampleType sample = heights(i, j), ordered = in_order(sample);
        bounds.holed |= heights.missing(sample);
        if constexpr (std::is_floating_point_v<SampleType>)
            bounds.holed |= !is_finite(static_cast<T>(sample));
        bounds.lowest = ordered < bounds.lowest ? ordered : bounds.lowest;
        bounds.highest = bounds.highest < ordered ? ordered : bounds.highest;
    }
    /// The corners of a cell and of its neighbour to the right or above, or of one cell given twice: which of these it is
    /// would be hard to predict, so always six.
    [[HFH_ALWAYS_INLINED]] constexpr void add_corners(SampleBounds& bounds, const Heights& heights, Cell one,
                                                      Cell other) const noexcept {
        add(bounds, heights, one.i, one.j);
        add(bounds, heights, one.i + 1, one.j + 1);
        add(bounds, heights, other.i, other.j);
        add(bounds, heights, other.i + 1, other.j + 1);
        add(bounds, heights, other.i + 1, one.j);
        add(bounds, heights, one.i, other.j + 1);
    }

    [[nodiscard]] static constexpr bool has_cells(const Level& level, Cell one, Cell other) noexcept {
        const Cell end = level.cells().end;
        return one.i >= 0 && one.j >= 0 && other.i < end.i && other.j < end.j;
    }

    /// Which quarter of its cell of level k+1 a cell is.
    [[nodiscard]] static constexpr Index quarter(Cell c) noexcept { return (c.i & 1) + 2 * (c.j & 1); }

    /// Blends corner number `corner` of a cell with the mean of the corners of level k+1 around it. The products of the mean
    /// are exact, and the blend is exact at α = 0 and α = 1 and never beyond either height.
    [[nodiscard, HFH_ALWAYS_INLINED]] constexpr T
    blended(T fine, const BilinearPatch<T>& coarse, const T (&weights)[4][4], int corner) const noexcept {
        const T mean = (weights[0][corner] * coarse.p00 + weights[1][corner] * coarse.p10) +
                       (weights[2][corner] * coarse.p01 + weights[3][corner] * coarse.p11);
        const T base = nearer_coarse_ ? mean : fine, other = nearer_coarse_ ? fine : mean;
        return multiply_add(weight_, other - base, base);
    }

    [[HFH_ALWAYS_INLINED]] constexpr void blend(BilinearPatch<T>& fine, const BilinearPatch<T>& coarse,
                                                Cell c) const noexcept {
        const auto& weights = detail::quarter_means<T>.weights[quarter(c)];
        // Side by side, so that a compiler makes vector code of the sums.
        T corners[4]{fine.p00, fine.p10, fine.p01, fine.p11};
        for (int k = 0; k < 4; ++k) corners[k] = blended(corners[k], coarse, weights, k);
        fine.p00 = corners[0], fine.p10 = corners[1], fine.p01 = corners[2], fine.p11 = corners[3];
    }

    /// The same where the cell of level k+1 has no patch: the corners for which all samples are there.
    [[gnu::noinline]] constexpr void blend_where_known(BilinearPatch<T>& fine, Cell c) const noexcept {
        const Cell above = cell_above(c);
        const std::optional<T> known[4]{coarse_height(above.i, above.j), coarse_height(above.i + 1, above.j),
                                        coarse_height(above.i, above.j + 1),
                                        coarse_height(above.i + 1, above.j + 1)};
        const auto or_zero = [](const std::optional<T>& height) { return height ? *height : T(0); };
        const BilinearPatch<T> coarse{or_zero(known[0]), or_zero(known[1]), or_zero(known[2]),
                                      or_zero(known[3]), fine.spacing};
        const auto& weights = detail::quarter_means<T>.weights[quarter(c)];
        T* const corners[4]{&fine.p00, &fine.p10, &fine.p01, &fine.p11};
        for (int k = 0; k < 4; ++k) {
            bool all = true;
            for (int whole = 0; whole < 4; ++whole) all &= known[whole] || weights[whole][k] == 0;
            if (all) *corners[k] = blended(*corners[k], coarse, weights, k);
        }
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
    T weight_ = 0;               ///< of the level that counts less
    bool blends_ = false;        ///< α is not 0
    bool nearer_coarse_ = false; ///< that is level k
    int k_ = 0;
    SampleType turn_ = 0;          ///< integers: what turns their order around if the height scale does
    bool all_are_heights_ = false; ///< integers: none is too large to be a height
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
    constexpr PyramidStatus update(const VertexRange& samples) noexcept {
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
    [[nodiscard, HFH_ALWAYS_INLINED]] constexpr HeightRange<T> block_range(int level, Block one,
                                                                           Block other) const noexcept {
        constexpr HeightRange<T> nothing{std::numeric_limits<T>::lowest(), std::numeric_limits<T>::max()};
        const int k = this->finer_level(), odd = k & 1;
        // Above the highest level of the pyramid there is one block, {0, 0}, which is that of the highest as well.
        const int above = std::min(level + (k + odd) / 2, bounds_.levels() - 1);
        const auto range =
            bounds_.range(above, {one.i >> odd, one.j >> odd}, {other.i >> odd, other.j >> odd});
        if (range.holed()) return nothing;
        const HeightRange<T> heights = this->finer().heights_between(range.lowest, range.highest);
        return this->finer().in_range(heights) ? heights : nothing; // one of its patches may be missing
    }

private:
    Bounds bounds_;
};

} // namespace hfh

#endif // HFH_TERRAIN_BLENDED_FIELD_HPP
