#ifndef HFH_TRAVERSAL_EMPTY_SPACE_SKIPPING_HPP
#define HFH_TRAVERSAL_EMPTY_SPACE_SKIPPING_HPP

#include <hfh/geometry/surface_point.hpp>
#include <hfh/traversal/candidate_walker.hpp>

#include <glm/common.hpp>

#include <cmath>

// How far along a segment nothing can be met, told by comparing heights alone: no crossing times, no quadratics. What
// is left over is for `first_hit` to judge.
//
// The cells are looked at in columns across the longer axis of the segment (in cells). Over a column the segment
// passes one cell or two, and its height is linear in the number of the grid line: no division in the loop, and no
// column waits for the one before. Every estimate is widened by a bound of its rounding, and of the rounding of the
// exact walk, so that a column is only called clear if each of its cells would be passed by the exact walk as well.

namespace hfh::detail {

/// A segment seen along its longer axis. Lines and columns are counted in the direction of the segment: line k is grid
/// line `along.base` ± k of that axis, and column k lies between lines k and k + 1.
class Profile {
public:
    /// Where the segment is on a line: in cells across, and its height.
    struct Crossing {
        double cell, z;
    };
    /// Cells across which the segment may touch between two lines, and heights that it stays between there.
    struct Part {
        Index first, last;
        double lowest, highest;
    };

    /// `along` and `across` are the axes of the segment, from az to bz. Precondition: it goes a cell along or more, and
    /// not less than across.
    Profile(const AxisWalk& along, const AxisWalk& across, double az, double bz) noexcept
        : along_base_{along.base}, backwards_{along.ahead - 1} {
        ahead_ = (along.base ^ backwards_) - backwards_;
        // t = (k − start)/length; cell and height are linear in t.
        const double length = std::abs(along.d * along.per_metre), per_line = 1 / length;
        const double start = along.a * along.per_metre * static_cast<double>(along.step);
        cell_step_ = across.d * across.per_metre * per_line;
        z_step_ = (bz - az) * per_line;
        // Counted from below all that the segment passes: to round towards zero is to round down, which is one
        // instruction (a cast of 30 or 300 cells takes 6 to 8 % less time).
        const auto below = static_cast<Index>(length) + 4;
        across_base_ = across.base - below;
        cell_ = across.a * across.per_metre - start * cell_step_ + static_cast<double>(below);
        z_ = az - start * z_step_;
        // Some ulps of the largest numbers that go in; lines k are at most two cells beyond the ends. The rests in
        // `along` and `across` have the rounding of the number of the cell.
        cell_blur_ = 32 * epsilon<double> *
                     (std::abs(static_cast<double>(along.base)) + std::abs(static_cast<double>(across.base)) +
                      length + 4);
        // Denormal heights have a rounding of their own size.
        z_blur_ = 32 * epsilon<double> * (std::abs(az) + std::abs(bz)) + cell_blur_ * std::abs(z_step_) +
                  std::numeric_limits<double>::min();
        z_low_ = glm::min(az, bz) - z_blur_;
        z_high_ = glm::max(az, bz) + z_blur_;
    }

    /// Whether the numbers of the cells are known well enough to be of use.
    [[nodiscard]] bool usable() const noexcept { return cell_blur_ < 0.125; }

    // ~k = −1 − k, without a branch on the direction, which nobody can foresee.
    /// The cells along of column k, and back.
    [[nodiscard]] Index cell_along(Index column) const noexcept {
        return along_base_ + (column ^ backwards_);
    }
    [[nodiscard]] Index column_of(Index cell) const noexcept { return (cell - along_base_) ^ backwards_; }
    /// The number of line k in the grid.
    [[nodiscard]] Index grid_line(Index k) const noexcept { return cell_along(k) - backwards_; }

    /// From a column to the next, in cells along.
    [[nodiscard]] Index step() const noexcept { return 1 + 2 * backwards_; }

    /// How many columns of its block lie before a column, if blocks are 2ⁿ columns wide.
    [[nodiscard]] Index columns_before(Index column, Index width) const noexcept {
        return (ahead_ + column) & (width - 1);
    }

    [[nodiscard]] Crossing crossing(double line) const noexcept {
        return {cell_ + line * cell_step_, z_ + line * z_step_};
    }
    [[nodiscard]] Part between(const Crossing& a, const Crossing& b) const noexcept {
        return {cell(glm::min(a.cell, b.cell) - cell_blur_), cell(glm::max(a.cell, b.cell) + cell_blur_),
                glm::max(glm::min(a.z, b.z) - z_blur_, z_low_),
                glm::min(glm::max(a.z, b.z) + z_blur_, z_high_)};
    }
    /// Between lines k and m.
    [[nodiscard]] Part between(Index k, Index m) const noexcept {
        return between(crossing(static_cast<double>(k)), crossing(static_cast<double>(m)));
    }

    /// How many cells there are between lines k ≤ m, where the segment passes no vertex.
    [[nodiscard]] Index cells(Index k, Index m) const noexcept {
        return m - k + std::abs(between(m, m).first - between(k, k).first);
    }

private:
    [[nodiscard]] Index cell(double number) const noexcept {
        return across_base_ + static_cast<Index>(number);
    }

    Index along_base_, backwards_, across_base_;
    Index ahead_; ///< `along_base_`, counted in the direction of the segment
    double cell_, cell_step_,
        cell_blur_; ///< across, in cells from `across_base_`: on line 0, per line, how well known
    double z_, z_step_, z_blur_, z_low_, z_high_; ///< the same of the height, and both ends
};

/// Whether there is a patch over the cell, and all of it is below z.
template <HeightField Field>
[[nodiscard]] bool lies_below(const Field& field, const Cell& cell, double z) noexcept {
    const auto patch = field.patch(cell);
    if (!patch) return false;
    // Corner by corner, not `highest`: GCC would put them into a vector and take them out again.
    return widen(patch->p00) < z && widen(patch->p10) < z && widen(patch->p01) < z && widen(patch->p11) < z;
}

/// The cells of a range across the segment.
struct AcrossCells {
    Index first, past;
    [[nodiscard]] bool contain(const Profile::Part& part) const noexcept {
        return first <= part.first && part.last < past;
    }
};
template <bool along_x>
[[nodiscard]] AcrossCells across_cells(const CellRange& cells) noexcept {
    return along_x ? AcrossCells{cells.begin.j, cells.end.j} : AcrossCells{cells.begin.i, cells.end.i};
}

/// Whether all cells of a column that the segment may touch have patches, which lie below it. Column `along` is between
/// grid lines `along` and `along + 1`. Precondition: there are cells that far along.
template <bool along_x, HeightField Field>
[[nodiscard, gnu::always_inline]] inline bool column_lies_below(const Field& field, Index along,
                                                                const Profile::Part& part) noexcept {
    const auto cell = [](Index a, Index b) { return along_x ? Cell{a, b} : Cell{b, a}; };
    if constexpr (CorneredHeightField<Field>) {
        if (part.last - part.first <= 1) {
            if (!across_cells<along_x>(field.cells()).contain(part)) return false;
            // Two cells or one: nobody can foresee where. So six corners, two of them twice where there is one.
            // Rounding keeps the order: what is not below z is not below z in T either.
            const Index past = part.last + 1, next = along + 1;
            return field.corners_below({cell(along, part.first), cell(next, part.first),
                                        cell(along, part.last), cell(next, part.last), cell(along, past),
                                        cell(next, past)},
                                       static_cast<typename Field::Scalar>(part.lowest));
        }
    }
    for (Index across = part.first; across <= part.last; ++across) {
        if (!lies_below(field, cell(along, across), part.lowest)) return false;
    }
    return true;
}

/// Columns of which the segment touches no cell, but passes all of them on one side.
struct Stretch {
    Index columns = 0;
    Side side = Side::above;
    Index looked_at = 0; ///< cells and blocks, about
};

/// Finds one stretch after the other along a segment.
template <bool along_x, HeightField Field>
class Stretches {
public:
    Stretches(const Field& field, const Profile& profile) noexcept : field_{field}, profile_{profile} {
        if constexpr (BoundedHeightField<Field>) {
            levels_ = field.levels();
            if (levels_ == 0) cells_to_ = std::numeric_limits<Index>::max() / 2; // beyond every column
        }
    }

    /// From column `from` on, of the next `count`. On `side`, if it is known. Looks at `budget` cells at the most, and
    /// up to three more.
    [[nodiscard]] Stretch next(Index from, Index count, Index budget, Side side) noexcept {
        // No column has more than three cells.
        if (side == Side::below) return {};
        const Index clear = clear_columns(from, glm::min(count, budget / 3));
        return {clear, Side::above, clear > 0 ? profile_.cells(from, from + clear) : 0};
    }

    /// The same for a field with bounds, by blocks: larger ones where there is much room, smaller ones where there is
    /// little, and cells in blocks of the lowest level that may be touched.
    [[nodiscard]] Stretch next(Index from, Index count, Index budget,
                               Side side) noexcept requires BoundedHeightField<Field> {
        Stretch found{0, side, 0};
        while (found.columns < count && found.looked_at < budget) {
            const Index here = from + found.columns, left = count - found.columns;
            if (here < cells_to_) {
                if (found.side == Side::below) break; // judged exactly until then
                const Index wanted = glm::min(glm::min(cells_to_ - here, left),
                                              glm::max<Index>((budget - found.looked_at) / 3, 1));
                const Index clear = clear_columns(here, wanted);
                if (clear > 0) {
                    found.columns += clear;
                    found.side = Side::above;
                    found.looked_at += profile_.cells(here, here + clear);
                }
                if (clear < wanted) break;
                continue;
            }
            // As far as the next block of the level above.
            const bool highest = level_ + 1 == levels_;
            const Index wanted = highest ? left : glm::min(columns_left(level_ + 1, here), left);
            Index clear = found.side == Side::below
                              ? clear_blocks<Side::below>(here, wanted, found.looked_at)
                              : clear_blocks<Side::above>(here, wanted, found.looked_at);
            if (found.side == Side::none && clear > 0) found.side = Side::above;
            if (found.side == Side::none) {
                --found.looked_at; // the same block again
                clear = clear_blocks<Side::below>(here, wanted, found.looked_at);
                if (clear > 0) found.side = Side::below;
            }
            found.columns += clear;
            if (clear == wanted) {
                if (!highest) ++level_;
            } else if (level_ > 0) {
                --level_;
            } else {
                cells_to_ = here + clear + columns_left(0, here + clear);
            }
        }
        return found;
    }

private:
    /// Of `count` columns from column `from` on, how many the segment passes over: every cell of them that it may touch
    /// has a patch that lies below it.
    [[nodiscard]] Index clear_columns(Index from, Index count) const noexcept {
        double line = static_cast<double>(from);
        auto here = profile_.crossing(line);
        for (Index n = 0; n < count; ++n) {
            const auto there = profile_.crossing(++line);
            if (!column_lies_below<along_x>(field_, profile_.cell_along(from + n),
                                            profile_.between(here, there))) {
                return n;
            }
            here = there;
        }
        return count;
    }

    /// log₂ of the cells along a side of a block.
    [[nodiscard]] static constexpr int bits(int level) noexcept { return Field::block_bits + 2 * level; }
    [[nodiscard]] static constexpr Index side_length(int level) noexcept { return Index{1} << bits(level); }
    /// From a column to the last one of its block, both counted.
    [[nodiscard]] Index columns_left(int level, Index column) const noexcept {
        return side_length(level) - profile_.columns_before(column, side_length(level));
    }
    /// Of `count` columns from column `from` on, how many the segment passes on one side of all blocks of the level that it
    /// may touch over them. Counts the blocks that it looks at.
    template <Side side>
    [[nodiscard]] Index clear_blocks(Index from, Index count, Index& looked_at) const noexcept {
        const int shift = bits(level_);
        const AcrossCells cells = across_cells<along_x>(field_.cells());
        Index clear = 0, width = glm::min(columns_left(level_, from), count);
        Index along = profile_.cell_along(from) >> shift;
        auto here = profile_.crossing(static_cast<double>(from));
        for (;;) {
            const auto there = profile_.crossing(static_cast<double>(from + clear + width));
            const Profile::Part part = profile_.between(here, there);
            ++looked_at;
            if (!cells.contain(part)) return clear;
            // As wide as they are long, they are one or two, which nobody can foresee; three where the segment goes through a
            // vertex.
            const Index first = part.first >> shift, last = part.last >> shift;
            auto range = block_range(along, first, last);
            if (last - first > 1) [[unlikely]] {
                const auto between = block_range(along, first + 1, first + 1);
                range = {glm::min(range.lowest, between.lowest), glm::max(range.highest, between.highest)};
            }
            const bool passed =
                side == Side::above ? widen(range.highest) < part.lowest : part.highest < widen(range.lowest);
            if (!passed) return clear;
            clear += width;
            if (clear == count) return clear;
            width = glm::min(side_length(level_), count - clear);
            along += profile_.step();
            here = there;
        }
    }
    [[nodiscard]] auto block_range(Index along, Index one, Index other) const noexcept {
        return along_x ? field_.block_range(level_, {along, one}, {along, other})
                       : field_.block_range(level_, {one, along}, {other, along});
    }

    const Field& field_;
    const Profile& profile_;
    int level_ = 0, levels_ = 0;
    Index cells_to_ =
        std::numeric_limits<Index>::min(); ///< columns before this one are looked at cell by cell
};

} // namespace hfh::detail

#endif // HFH_TRAVERSAL_EMPTY_SPACE_SKIPPING_HPP
