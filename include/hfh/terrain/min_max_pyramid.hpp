#ifndef HFH_TERRAIN_MIN_MAX_PYRAMID_HPP
#define HFH_TERRAIN_MIN_MAX_PYRAMID_HPP

#include <hfh/terrain/bilinear_grid.hpp>
#include <hfh/terrain/height_field.hpp>
#include <hfh/terrain/height_view.hpp>

#include <algorithm>
#include <bit>
#include <type_traits>
#include <utility>

// Based on: Tevs, Ihrke, Seidel, Maximum Mipmaps for Fast, Accurate, and Scalable Dynamic Height Field Rendering (2008).
// Optional bounds on heights for long casts: the lowest and the highest samples of blocks, beside the grid.

namespace hfh {

/// The lowest and the highest of some samples; lowest > highest where one is missing, which bounds nothing.
template <Sample S>
struct SampleRange {
    S lowest = std::numeric_limits<S>::max();
    S highest = std::numeric_limits<S>::lowest();

    [[nodiscard]] constexpr bool holed() const noexcept { return highest < lowest; }
};

/// Why a pyramid bounds nothing, or `ok`.
enum class PyramidStatus : unsigned char {
    ok,
    too_few_samples,    ///< fewer than 2 columns or 2 rows, or the grid's own status is not ok
    too_little_storage, ///< less than `size()` ranges, or none
    other_size          ///< these heights have not the columns and rows that the pyramid is made for
};

[[nodiscard]] constexpr const char* to_string(PyramidStatus status) noexcept {
    switch (status) {
    case PyramidStatus::ok: return "ok";
    case PyramidStatus::too_few_samples: return "too_few_samples";
    case PyramidStatus::too_little_storage: return "too_little_storage";
    case PyramidStatus::other_size: return "other_size";
    }
    return "unknown";
}

namespace detail {

/// log₂ of the cells along a side of a block of level 0: as small as a tenth of a byte a sample allows.
template <Sample S>
inline constexpr int block_bits = sizeof(S) <= 2 ? 3 : 4;
template <Sample S>
inline constexpr Index block_side = Index{1} << block_bits<S>;

/// Whether a sample is a number at all. What is not makes no patch, whatever its source says.
template <Sample S>
[[nodiscard]] constexpr bool is_number(S sample) noexcept {
    if constexpr (Real<S>) return is_finite(sample);
    if constexpr (std::is_floating_point_v<S>) return is_finite(static_cast<double>(sample));
    return true;
}

/// Reads rows of samples that lie side by side: through pointers, and without a branch.
template <Sample S, class Missing>
struct PointerRows {
    static constexpr bool may_have_holes =
        std::is_floating_point_v<S> || !std::same_as<Missing, NeverMissing>;

    const S* data;
    Index stride;
    Missing rule;

    [[nodiscard]] constexpr const S* row(Index j) const noexcept { return data + j * stride; }
    [[nodiscard]] constexpr bool hole(S sample) const noexcept {
        // Both are asked, always: what may be skipped keeps a compiler from vector code.
        const bool marked = rule(sample), number = is_number(sample);
        return marked || !number;
    }
};

/// Reads rows of any other heights.
template <HeightSource Heights>
struct SourceRows {
    using S = typename Heights::SampleType;
    static constexpr bool may_have_holes = true;

    struct Row {
        const Heights* heights;
        Index i, j;
        [[nodiscard]] constexpr S operator[](Index c) const noexcept { return (*heights)(i + c, j); }
    };

    const Heights* heights;
    Index i;

    [[nodiscard]] constexpr Row row(Index j) const noexcept { return {heights, i, j}; }
    [[nodiscard]] constexpr bool hole(S sample) const noexcept {
        return !is_number(sample) || heights->missing(sample);
    }
};

/// Column by column over some rows: the lowest sample, the highest, and whether one is missing. Loops without a branch
/// over arrays of equally wide numbers, so that a compiler makes vector code of them.
template <Sample S>
class ColumnStrip {
public:
    static constexpr Index side = block_side<S>;
    /// Three arrays of 4 KiB: they stay in the first-level cache, and on any stack.
    static constexpr Index most_blocks = 4096 / (side * Index{sizeof(S)});
    static constexpr std::size_t length = static_cast<std::size_t>(most_blocks * side + 1);

    /// Reads rows begin ≤ j < end, at most side + 1, of `columns` samples, at most side·most_blocks + 1.
    template <class Rows>
    constexpr void read(const Rows& rows, Index columns, Index begin, Index end) noexcept {
        take(rows, std::make_index_sequence<std::size_t{side + 1}>{}, columns, begin, end, lowest_, highest_,
             hole_);
        // The last block may be cut off by the border: its last column again in those it lacks.
        for (Index c = columns; c % side != 1; ++c) {
            lowest_[c] = lowest_[columns - 1];
            highest_[c] = highest_[columns - 1];
            if constexpr (Rows::may_have_holes) hole_[c] = hole_[columns - 1];
        }
    }

    /// The range of block b: its columns, and the one behind them, which the next block has as well.
    template <class Rows>
    [[nodiscard]] constexpr SampleRange<S> block(Index b) const noexcept {
        const Index begin = b * side, end = begin + side;
        S low = lowest_[end], high = highest_[end];
        for (Index c = begin; c < end; ++c) low = std::min(low, lowest_[c]);
        for (Index c = begin; c < end; ++c) high = std::max(high, highest_[c]);
        // Behind the other loops, of which a return before them would keep the compiler from making vector code.
        if constexpr (Rows::may_have_holes) {
            Flag hole = hole_[end];
            for (Index c = begin; c < end; ++c) hole = static_cast<Flag>(hole | hole_[c]);
            if (hole != 0) return {};
        }
        return {low, high};
    }

private:
    // clang-format off
    using Flag = std::conditional_t<sizeof(S) == 2, std::uint16_t,
                 std::conditional_t<sizeof(S) == 4, std::uint32_t,
                 std::conditional_t<sizeof(S) == 8, std::uint64_t, std::uint8_t>>>;
    // clang-format on

    /// All rows at once, the last one again where there are fewer: nothing is stored between rows, and many lines of
    /// memory are fetched at a time. `__restrict`, for a compiler would assume that the arrays may overlap the rows.
    template <class Rows, std::size_t... k>
    static constexpr void take(const Rows rows, std::index_sequence<k...>, Index columns, Index begin,
                               Index end, S* __restrict lowest, S* __restrict highest,
                               Flag* __restrict holes) noexcept {
        const decltype(rows.row(0)) row[]{rows.row(std::min(begin + Index{k}, end - 1))...};
        for (Index c = 0; c < columns; ++c) {
            S low = row[0][c], high = low, sample = low;
            ((sample = row[k][c], low = sample < low ? sample : low, high = high < sample ? sample : high),
             ...);
            Flag hole = 0;
            ((hole = static_cast<Flag>(hole | (rows.hole(row[k][c]) ? Flag{1} : Flag{0}))), ...);
            lowest[c] = low;
            highest[c] = high;
            if constexpr (Rows::may_have_holes) holes[c] = hole;
        }
    }

    S lowest_[length];
    S highest_[length];
    Flag hole_[length];
};

} // namespace detail

/// The lowest and highest samples over blocks of cells, levels and blocks as in `BoundedHeightField`: level l has blocks
/// of 2ᵇ × 2ᵇ cells, b = block_bits + 2 l, and the highest level has one, which holds all cells. n × n cells touch
/// (n+1) × (n+1) samples. A view on the user's own storage, level by level, each row by row:
///
///     std::vector<SampleRange<S>> storage(MinMaxPyramid<S>::size(columns, rows));
///     MinMaxPyramid<S> bounds{storage.data(), std::ssize(storage), columns, rows};
///     bounds.build(heights);
///
/// Copies look at the same storage, which must outlive them. Ranges as they are made bound nothing, so neither does a
/// pyramid before `build`. Nothing here throws or allocates.
template <Sample S>
class MinMaxPyramid {
public:
    using SampleType = S;
    using Range = SampleRange<S>;

    /// Blocks of 8 × 8 cells for samples of one byte or two, of 16 × 16 for larger ones: the smaller they are, the fewer
    /// cells a cast looks at, and the more storage they need.
    static constexpr int block_bits = detail::block_bits<S>;

    /// The ranges of storage that columns × rows samples need, 0 if they make no cell: one for each block of level 0 and
    /// a fifteenth of that above. At most a tenth of a byte a sample, and a little for blocks cut off at the border.
    [[nodiscard]] static constexpr Index size(Index columns, Index rows) noexcept {
        return MinMaxPyramid{}.lay_out(columns, rows);
    }

    constexpr MinMaxPyramid() noexcept = default;
    constexpr MinMaxPyramid(Range* storage, Index count, Index columns, Index rows) noexcept {
        const Index wanted = lay_out(columns, rows);
        if (wanted == 0) return;
        const bool enough = storage != nullptr && count >= wanted;
        if (enough) ranges_ = storage;
        status_ = enough ? PyramidStatus::ok : PyramidStatus::too_little_storage;
    }

    [[nodiscard]] constexpr PyramidStatus status() const noexcept { return status_; }
    /// 0 if there is no cell; the same whether there is storage or not.
    [[nodiscard]] constexpr int levels() const noexcept { return levels_; }
    /// Bounds nothing where there is no such block, and if the status is not ok.
    [[nodiscard]] constexpr Range range(int level, Block block) const noexcept {
        if (status_ != PyramidStatus::ok || level < 0 || level >= levels_) return {};
        const bool exists =
            0 <= block.i && block.i < level_[level].columns && 0 <= block.j && block.j < level_[level].rows;
        return exists ? at(level, block) : Range{};
    }

    /// Of two blocks together. Precondition: there are both, and the status is ok.
    [[nodiscard, HFH_ALWAYS_INLINED]] constexpr Range range(int level, Block one,
                                                            Block other) const noexcept {
        return join(at(level, one), at(level, other));
    }

    /// Makes all ranges, in one pass over the samples, a row of blocks at a time and each from left to right. A row that
    /// two rows of blocks share is read again while a cache has it. Vector code where a row's samples lie side by side (a
    /// `HeightView` with a column stride of 1), which is at least half as fast as memory can be read; 5 to 20 times
    /// slower for other strides and sources.
    template <HeightSource Heights>
        requires std::same_as<typename Heights::SampleType, S>
    constexpr PyramidStatus build(const Heights& heights) noexcept {
        return update(heights, {{0, 0}, {columns_, rows_}});
    }

    /// Makes the ranges anew that these samples touch, as far as there are such: after an edit of them. Reads the blocks of
    /// these samples and no others: up to 4 for a brush no wider than a block, then at most 16 ranges for each of as many
    /// or fewer blocks on every level.
    template <HeightSource Heights>
        requires std::same_as<typename Heights::SampleType, S>
    constexpr PyramidStatus update(const Heights& heights, const VertexRange& samples) noexcept {
        if (status_ != PyramidStatus::ok) return status_;
        if (heights.columns() != columns_ || heights.rows() != rows_) return PyramidStatus::other_size;
        // Sample i is a corner of the cells i − 1 and i.
        const CellRange cells{
            {std::max<Index>(samples.begin.i, 1) - 1, std::max<Index>(samples.begin.j, 1) - 1},
            {std::min(samples.end.i, columns_ - 1), std::min(samples.end.j, rows_ - 1)}};
        if (samples.empty() || cells.empty()) return status_;
        BlockRange touched{{cells.begin.i >> block_bits, cells.begin.j >> block_bits},
                           {((cells.end.i - 1) >> block_bits) + 1, ((cells.end.j - 1) >> block_bits) + 1}};
        read_blocks(heights, touched);
        for (int level = 1; level < levels_; ++level) {
            touched = {{touched.begin.i / 4, touched.begin.j / 4},
                       {(touched.end.i + 3) / 4, (touched.end.j + 3) / 4}};
            for (Index j = touched.begin.j; j < touched.end.j; ++j) {
                for (Index i = touched.begin.i; i < touched.end.i; ++i) join_below(level, {i, j});
            }
        }
        return status_;
    }

private:
    /// The blocks begin.i ≤ i < end.i, begin.j ≤ j < end.j of a level.
    struct BlockRange {
        Block begin, end;
    };

    /// Where its blocks are in `ranges_`, and how many there are.
    struct Level {
        Index start, columns, rows;
    };

    /// Sets all members but the storage and the status; the ranges needed, at most as many as an Index can count.
    constexpr Index lay_out(Index columns, Index rows) noexcept {
        if (columns < 2 || rows < 2) return 0;
        columns_ = columns;
        rows_ = rows;
        // Blocks of level 0 along the longer side, but for one. Four of them make one of the next level.
        const auto others = static_cast<std::size_t>((std::max(columns, rows) - 2) >> block_bits);
        levels_ = 1 + (static_cast<int>(std::bit_width(others)) + 1) / 2;
        Index count = 0;
        for (int level = 0; level < levels_; ++level) {
            const int bits = std::min(block_bits + 2 * level, std::numeric_limits<Index>::digits);
            const Index i = ((columns - 2) >> bits) + 1, j = ((rows - 2) >> bits) + 1;
            level_[level] = {count, i, j};
            constexpr Index most = std::numeric_limits<Index>::max();
            if (i > (most - count) / j) return most;
            count += i * j;
        }
        return count;
    }

    [[nodiscard]] constexpr Range& at(int level, Block block) const noexcept {
        return ranges_[level_[level].start + block.j * level_[level].columns + block.i];
    }

    /// Both together; holed if one is.
    [[nodiscard]] static constexpr Range join(const Range& a, const Range& b) noexcept {
        if (a.holed() || b.holed()) return {};
        // Not `std::min`, which GCC makes a branch of.
        return {b.lowest < a.lowest ? b.lowest : a.lowest, a.highest < b.highest ? b.highest : a.highest};
    }
    constexpr void join_below(int level, Block block) noexcept {
        const Level& below = level_[level - 1];
        const Index i = 4 * block.i, j = 4 * block.j, end_i = std::min(i + 4, below.columns),
                    end_j = std::min(j + 4, below.rows);
        Range all = at(level - 1, {i, j});
        for (Index y = j; y < end_j; ++y) {
            for (Index x = i; x < end_i; ++x) all = join(all, at(level - 1, {x, y}));
        }
        at(level, block) = all;
    }

    /// Makes ranges of level 0, row after row of blocks, each in pieces that a strip holds.
    template <HeightSource Heights>
    constexpr void read_blocks(const Heights& heights, const BlockRange& wanted) noexcept {
        constexpr Index most = detail::ColumnStrip<S>::most_blocks;
        for (Index j = wanted.begin.j; j < wanted.end.j; ++j) {
            for (Index i = wanted.begin.i; i < wanted.end.i; i += most) {
                read_piece(heights, {i, j}, std::min(most, wanted.end.i - i));
            }
        }
    }
    template <HeightSource Heights>
    constexpr void read_piece(const Heights& heights, Block first, Index count) noexcept {
        read_rows(detail::SourceRows<Heights>{&heights, first.i * side}, first, count);
    }
    template <class Missing>
    constexpr void read_piece(const HeightView<S, Missing>& heights, Block first, Index count) noexcept {
        if constexpr (std::same_as<Missing, MissingValue<S>>) {
            // Few pieces have holes: read without asking, and again only if the value lies between the bounds.
            read_piece(
                HeightView<S>{heights.data(), columns_, rows_, heights.column_stride(), heights.row_stride()},
                first, count);
            const Range* const ranges = &at(0, first);
            const S value = heights.rule().value;
            if (std::none_of(ranges, ranges + count, [value](const Range& range) {
                    return range.lowest <= value && value <= range.highest;
                })) {
                return;
            }
        }
        const Index i = first.i * side;
        if (heights.column_stride() == 1) {
            read_rows(
                detail::PointerRows<S, Missing>{heights.data() + i, heights.row_stride(), heights.rule()},
                first, count);
        } else {
            read_rows(detail::SourceRows<HeightView<S, Missing>>{&heights, i}, first, count);
        }
    }
    template <class Rows>
    constexpr void read_rows(const Rows& rows, Block first, Index count) noexcept {
        const Index columns = std::min(count * side + 1, columns_ - first.i * side);
        detail::ColumnStrip<S> strip;
        strip.read(rows, columns, first.j * side, std::min((first.j + 1) * side + 1, rows_));
        Range* const ranges = &at(0, first);
        for (Index b = 0; b < count; ++b) ranges[b] = strip.template block<Rows>(b);
    }

    static constexpr Index side = detail::block_side<S>;

    Range* ranges_ = nullptr;
    Index columns_ = 0; // of samples
    Index rows_ = 0;
    Level level_[std::size_t{(std::numeric_limits<Index>::digits - block_bits) / 2 + 2}] = {};
    int levels_ = 0;
    PyramidStatus status_ = PyramidStatus::too_few_samples;
};

/// A `BilinearGrid` with bounds: use it in the grid's place. Copies the grid, which is a view, and looks at the user's
/// storage for the bounds, `MinMaxPyramid<S>::size(columns, rows)` ranges of which S is the grid's sample type.
///
///     BoundedGrid field{grid, storage.data(), std::ssize(storage)};
///     field.build();
///     ProxyTracker tracker{field};
///
/// If its status is not ok it has no blocks, and before `build` these bound nothing: it is the same surface.
template <Real T, HeightSource Heights>
class BoundedGrid {
public:
    using Scalar = T;
    using Grid = BilinearGrid<T, Heights>;
    using Bounds = MinMaxPyramid<typename Grid::SampleType>;

    constexpr BoundedGrid(const Grid& grid, typename Bounds::Range* storage, Index count) noexcept
        : grid_{grid}, bounds_{storage, count, grid.cells().end.i + 1, grid.cells().end.j + 1} {}

    [[nodiscard]] constexpr PyramidStatus status() const noexcept { return bounds_.status(); }
    [[nodiscard]] constexpr const Grid& grid() const noexcept { return grid_; }
    [[nodiscard]] constexpr const Bounds& bounds() const noexcept { return bounds_; }

    /// See `MinMaxPyramid`; to be called before the first search and, with the samples that changed, after each edit.
    constexpr PyramidStatus build() noexcept { return bounds_.build(grid_.heights()); }
    constexpr PyramidStatus update(const VertexRange& samples) noexcept {
        return bounds_.update(grid_.heights(), samples);
    }

    [[nodiscard]] constexpr const Lattice& lattice() const noexcept { return grid_.lattice(); }
    [[nodiscard]] constexpr CellRange cells() const noexcept { return grid_.cells(); }
    [[nodiscard, HFH_ALWAYS_INLINED]] constexpr std::optional<BilinearPatch<T>> patch(Cell c) const noexcept {
        return grid_.patch(c);
    }
    [[nodiscard, HFH_ALWAYS_INLINED]] constexpr bool corners_below(const Vertex (&corners)[6],
                                                                   T z) const noexcept {
        return grid_.corners_below(corners, z);
    }

    static constexpr int block_bits = Bounds::block_bits;
    /// 0 if the status is not ok.
    [[nodiscard]] constexpr int levels() const noexcept {
        return status() == PyramidStatus::ok ? bounds_.levels() : 0;
    }
    /// The lowest and the highest corner of the patches of two blocks, or of one twice, to the bit. Precondition: there are
    /// such blocks.
    [[nodiscard, HFH_ALWAYS_INLINED]] constexpr HeightRange<T> block_range(int level, Block one,
                                                                           Block other) const noexcept {
        constexpr HeightRange<T> nothing{std::numeric_limits<T>::lowest(), std::numeric_limits<T>::max()};
        const auto range = bounds_.range(level, one, other);
        if (range.holed()) return nothing;
        const HeightRange<T> heights = grid_.heights_between(range.lowest, range.highest);
        return grid_.in_range(heights) ? heights : nothing; // one of its patches may be missing
    }

private:
    Grid grid_;
    Bounds bounds_;
};

} // namespace hfh

#endif // HFH_TERRAIN_MIN_MAX_PYRAMID_HPP
