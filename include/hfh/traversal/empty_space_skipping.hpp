#ifndef HFH_TRAVERSAL_EMPTY_SPACE_SKIPPING_HPP
#define HFH_TRAVERSAL_EMPTY_SPACE_SKIPPING_HPP

#include <hfh/geometry/surface_point.hpp>
#include <hfh/traversal/candidate_walker.hpp>

#include <glm/common.hpp>

#include <cmath>

// How far along a segment nothing can be met, found by comparing heights alone: no crossing times, no quadratics. Only the
// rest is traversed cell by cell.
//
// Based on: Tevs, Ihrke, Seidel, Maximum Mipmaps for Fast, Accurate, and Scalable Dynamic Height Field Rendering (2008):
// a ray descends and ascends the levels of a pyramid of bounds. Here it advances by slabs, and looks at cells too.
//
// The *major axis* is the one along which the segment is longer, counted in cells; the *minor axis* is the other one. A
// *slab* is a column or row of cells across the major axis. The segment passes one or two cells of a slab (three at a
// vertex), and where it crosses a slab's border depends linearly on the number of the grid line: no division in the loop,
// and no slab waits for the one before. Every estimate is widened by a bound of its rounding, and of the rounding of the
// exact traversal, so that a slab is only called empty if the exact traversal would find nothing in its cells either.

namespace hfh::detail {

/// The numbers begin ≤ n < end.
struct IndexRange {
    Index begin, end;
    [[nodiscard]] constexpr bool contains(Index n) const noexcept { return begin <= n && n < end; }
};
/// The part of a range of cells along the major and along the minor axis.
template <bool x_major>
[[nodiscard]] IndexRange major_range(const CellRange& cells) noexcept {
    return x_major ? IndexRange{cells.begin.i, cells.end.i} : IndexRange{cells.begin.j, cells.end.j};
}
template <bool x_major>
[[nodiscard]] IndexRange minor_range(const CellRange& cells) noexcept {
    return major_range<!x_major>(cells);
}
/// The cell with these numbers along both axes.
template <bool x_major>
[[nodiscard]] constexpr Cell cell_at(Index major, Index minor) noexcept {
    return x_major ? Cell{major, minor} : Cell{minor, major};
}
/// The vertex with these numbers along both axes.
template <bool x_major>
[[nodiscard]] constexpr Vertex vertex_at(Index major, Index minor) noexcept {
    return x_major ? Vertex{major, minor} : Vertex{minor, major};
}
/// The block with these numbers along both axes.
template <bool x_major>
[[nodiscard]] constexpr Block block_at(Index major, Index minor) noexcept {
    return x_major ? Block{major, minor} : Block{minor, major};
}

/// A segment seen along its major axis. Lines and slabs are counted in the direction of the segment: line k is grid line
/// `base` ± k of that axis, `base` being the cell in which the segment begins, and slab k lies between lines k and k + 1.
template <Real F>
class SegmentProfile {
public:
    /// Where the segment is on a line: in cells along the minor axis, and in metres of height.
    struct LinePoint {
        F minor, z;
    };
    /// What the segment may touch between two lines: the cells begin ≤ n < end along the minor axis, and heights in metres.
    struct SlabPart {
        Index begin, end;
        F lowest, highest;

        [[nodiscard]] bool is_in(const IndexRange& range) const noexcept {
            return range.begin <= begin && end - 1 < range.end;
        }
    };

    /// Of a segment whose height goes from az to bz. Precondition: it goes a cell along the major axis or more, and not
    /// less than along the minor one.
    SegmentProfile(const AxisWalk<F>& major, const AxisWalk<F>& minor, F az, F bz) noexcept
        : major_base_{major.base}, mirror_{major.exit_side - 1} {
        base_along_ = (major.base ^ mirror_) - mirror_;
        // t = (k − start)/length; the place along the minor axis and the height are linear in t.
        const F length = std::abs(major.d * major.cells_per_metre), per_line = 1 / length;
        const F start = major.a * major.cells_per_metre * static_cast<F>(major.step);
        minor_step_ = minor.d * minor.cells_per_metre * per_line;
        z_step_ = (bz - az) * per_line;
        // Counted from below all cells that the segment passes, so that no number is negative: to round towards zero, which
        // is one instruction, is then to round down.
        const auto below = static_cast<Index>(length) + 4;
        minor_base_ = minor.base - below;
        minor_ = minor.a * minor.cells_per_metre - start * minor_step_ + static_cast<F>(below);
        z_ = az - start * z_step_;
        // Some ulps of the largest numbers that go in. Lines k are at most two cells beyond the ends. `major.a` and
        // `minor.a` have the rounding of the number of the cell.
        minor_bound_ =
            32 * epsilon<F> *
            (std::abs(static_cast<F>(major.base)) + std::abs(static_cast<F>(minor.base)) + length + 4);
        // Denormal heights have a rounding of their own size.
        z_bound_ = 32 * epsilon<F> * (std::abs(az) + std::abs(bz)) + minor_bound_ * std::abs(z_step_) +
                   std::numeric_limits<F>::min();
        z_lowest_ = glm::min(az, bz) - z_bound_;
        z_highest_ = glm::max(az, bz) + z_bound_;
    }

    /// Whether the numbers of the cells are known well enough to be of use.
    [[nodiscard]] bool usable() const noexcept { return minor_bound_ < F(0.125); }

    // n ^ 0 = n and n ^ −1 = −1 − n: both directions without a branch, which a processor would often predict wrong.
    /// The number of a slab's cells along the major axis.
    [[nodiscard]] Index major_cell(Index slab) const noexcept { return major_base_ + (slab ^ mirror_); }
    [[nodiscard]] Index slab_of(Index major_cell) const noexcept {
        return (major_cell - major_base_) ^ mirror_;
    }
    /// The number of line k in the grid.
    [[nodiscard]] Index grid_line(Index k) const noexcept { return major_cell(k) - mirror_; }
    /// From a slab to the next, in cells along the major axis: 1 or −1.
    [[nodiscard]] Index step() const noexcept { return 1 + 2 * mirror_; }
    /// How many slabs of its block the segment has passed before a slab, if blocks are 2ⁿ cells wide.
    [[nodiscard]] Index slabs_before(Index slab, Index width) const noexcept {
        return (base_along_ + slab) & (width - 1);
    }

    [[nodiscard]] LinePoint on_line(F k) const noexcept {
        return {minor_ + k * minor_step_, z_ + k * z_step_};
    }
    [[nodiscard]] SlabPart between(const LinePoint& a, const LinePoint& b) const noexcept {
        return {minor_base_ + static_cast<Index>(glm::min(a.minor, b.minor) - minor_bound_),
                minor_base_ + static_cast<Index>(glm::max(a.minor, b.minor) + minor_bound_) + 1,
                glm::max(glm::min(a.z, b.z) - z_bound_, z_lowest_),
                glm::min(glm::max(a.z, b.z) + z_bound_, z_highest_)};
    }

    /// How many cells there are in `count` slabs from slab `begin` on, where the segment passes no vertex.
    [[nodiscard]] Index cells_in(Index begin, Index count) const noexcept {
        return count + std::abs(first_cell_on(begin + count) - first_cell_on(begin));
    }

private:
    [[nodiscard]] Index first_cell_on(Index k) const noexcept {
        const LinePoint point = on_line(static_cast<F>(k));
        return between(point, point).begin;
    }

    Index major_base_;
    Index mirror_;                       ///< −1 if the segment goes down along the major axis, else 0
    Index minor_base_;                   ///< the cell from which `minor_` is counted
    Index base_along_;                   ///< `major_base_`, counted in the direction of the segment
    F minor_, minor_step_, minor_bound_; ///< in cells: on line 0, per line, and a bound of the rounding
    F z_, z_step_, z_bound_;             ///< in metres: the same of the height
    F z_lowest_, z_highest_;             ///< bounds of both ends
};

/// Whether there is a patch over the cell, and all of it is below z.
template <HeightField Field, Real F>
[[nodiscard]] bool lies_below(const Field& field, const Cell& cell, F z) noexcept {
    const auto patch = field.patch(cell);
    if (!patch) return false;
    // Corner by corner, not `highest`: GCC would put them into a vector and take them out again.
    return widen_to<F>(patch->p00) < z && widen_to<F>(patch->p10) < z && widen_to<F>(patch->p01) < z &&
           widen_to<F>(patch->p11) < z;
}

/// Whether all cells of a slab that the segment may touch have patches, which lie below it. `major` is their number along
/// the major axis. Precondition: there are cells with that number.
template <bool x_major, HeightField Field>
[[nodiscard, HFH_ALWAYS_INLINED]] inline bool
slab_lies_below(const Field& field, Index major,
                const typename SegmentProfile<FrameScalar<Field>>::SlabPart& part) noexcept {
    if constexpr (CorneredHeightField<Field>) {
        const Index first = part.begin, last = part.end - 1;
        if (last - first <= 1) {
            if (!part.is_in(minor_range<x_major>(field.cells()))) return false;
            // Two cells or one, which is hard to predict. So six corners, two of them twice where there is one.
            // Rounding keeps the order: what is not below z is not below z in T either.
            const Index next = major + 1;
            return field.corners_below({vertex_at<x_major>(major, first), vertex_at<x_major>(next, first),
                                        vertex_at<x_major>(major, last), vertex_at<x_major>(next, last),
                                        vertex_at<x_major>(major, part.end),
                                        vertex_at<x_major>(next, part.end)},
                                       static_cast<typename Field::Scalar>(part.lowest));
        }
    }
    if constexpr (QuickHeightField<Field>) {
        const Index first = part.begin, last = part.end - 1;
        if (last - first <= 1 &&
            field.surely_below(cell_at<x_major>(major, first), cell_at<x_major>(major, last),
                               static_cast<typename Field::Scalar>(part.lowest))) {
            return true;
        }
    }
    for (Index minor = part.begin; minor < part.end; ++minor) {
        if (!lies_below(field, cell_at<x_major>(major, minor), part.lowest)) return false;
    }
    return true;
}

/// Slabs of which the segment touches no cell, but passes all of them on one side.
struct EmptySlabs {
    Index count = 0;
    Side side = Side::above;
    Index looked_at = 0; ///< cells and blocks that this took, about
};

/// Finds empty slabs along a segment, one group after the other.
template <bool x_major, HeightField Field>
class EmptySpace {
public:
    using F = FrameScalar<Field>;

    EmptySpace(const Field& field, const SegmentProfile<F>& profile) noexcept
        : field_{field}, profile_{profile} {
        if constexpr (BoundedHeightField<Field>) {
            levels_ = field.levels();
            if (levels_ == 0) by_cells_until_ = std::numeric_limits<Index>::max() / 2; // beyond every slab
        }
    }

    /// How many slabs are empty from slab `begin` on, of the next `count`. `side` is that of the segment, if it is known.
    /// Looks at `budget` cells at the most, and up to three more.
    [[nodiscard]] EmptySlabs find(Index begin, Index count, Index budget, Side side) noexcept {
        // No slab has more than three cells.
        if (side == Side::below) return {};
        const Index empty = slabs_below(begin, glm::min(count, budget / 3));
        return {empty, Side::above, empty > 0 ? profile_.cells_in(begin, empty) : 0};
    }

    /// The same for a field with bounds, by blocks: larger ones where there is much room, smaller ones where there is
    /// little, and cells in blocks of the lowest level that may be touched.
    [[nodiscard]] EmptySlabs find(Index begin, Index count, Index budget,
                                  Side side) noexcept requires BoundedHeightField<Field> {
        EmptySlabs found{0, side, 0};
        while (found.count < count && found.looked_at < budget) {
            const Index slab = begin + found.count, left = count - found.count;
            if (slab >= by_cells_until_) {
                add_by_blocks(found, slab, left);
            } else if (!add_by_cells(found, slab, left, budget - found.looked_at)) {
                break;
            }
        }
        return found;
    }

private:
    /// How many slabs from slab `begin` on, of the next `count`, lie below the segment: every cell of them that it may
    /// touch has a patch that does.
    [[nodiscard]] Index slabs_below(Index begin, Index count) const noexcept {
        F line = static_cast<F>(begin);
        auto here = profile_.on_line(line);
        for (Index n = 0; n < count; ++n) {
            const auto there = profile_.on_line(++line);
            if (!slab_lies_below<x_major>(field_, profile_.major_cell(begin + n),
                                          profile_.between(here, there))) {
                return n;
            }
            here = there;
        }
        return count;
    }

    /// Adds the empty slabs before `by_cells_until_`, from slab `slab` on and of the next `left`. False if a slab is not
    /// empty: then the search is over.
    [[nodiscard, HFH_ALWAYS_INLINED]] bool add_by_cells(EmptySlabs& found, Index slab, Index left,
                                                        Index budget) const noexcept {
        if (found.side == Side::below) return false; // cells are compared from above only
        const Index wanted = glm::min(glm::min(by_cells_until_ - slab, left), glm::max<Index>(budget / 3, 1));
        const Index empty = slabs_below(slab, wanted);
        if (empty > 0) {
            found.count += empty;
            found.side = Side::above;
            found.looked_at += profile_.cells_in(slab, empty);
        }
        return empty == wanted;
    }

    /// Adds the empty slabs as far as the next block of the level above, from slab `slab` on and of the next `left`. Goes
    /// one level up where all are empty, else one level down; from the lowest one to cells.
    [[HFH_ALWAYS_INLINED]] void add_by_blocks(EmptySlabs& found, Index slab, Index left) noexcept {
        const bool highest = level_ + 1 == levels_;
        const Index wanted = highest ? left : glm::min(slabs_left(level_ + 1, slab), left);
        const Index empty = empty_slabs(found, slab, wanted);
        found.count += empty;
        if (empty == wanted) {
            if (!highest) ++level_;
        } else if (level_ > 0) {
            --level_;
        } else {
            by_cells_until_ = slab + empty + slabs_left(0, slab + empty);
        }
    }

    /// `slabs_beside_blocks` on the side of what has been found; where that is not known yet, on either side.
    [[nodiscard, HFH_ALWAYS_INLINED]] Index empty_slabs(EmptySlabs& found, Index slab,
                                                        Index wanted) const noexcept {
        Index empty = found.side == Side::below
                          ? slabs_beside_blocks<Side::below>(slab, wanted, found.looked_at)
                          : slabs_beside_blocks<Side::above>(slab, wanted, found.looked_at);
        if (found.side != Side::none) return empty;
        if (empty > 0) {
            found.side = Side::above;
            return empty;
        }
        --found.looked_at; // the same block again
        empty = slabs_beside_blocks<Side::below>(slab, wanted, found.looked_at);
        if (empty > 0) found.side = Side::below;
        return empty;
    }

    /// How many slabs from slab `begin` on, of the next `count`, the segment passes on this side of all blocks of the level
    /// that it may touch over them. Adds the blocks that it looks at to `looked_at`.
    template <Side side>
    [[nodiscard]] Index slabs_beside_blocks(Index begin, Index count, Index& looked_at) const noexcept {
        const int shift = block_bits(level_);
        const IndexRange cells = minor_range<x_major>(field_.cells());
        Index passed = 0, width = glm::min(slabs_left(level_, begin), count);
        Index major = profile_.major_cell(begin) >> shift;
        auto here = profile_.on_line(static_cast<F>(begin));
        // Ends at a block that is not passed, or behind the last slab.
        for (;;) {
            const auto there = profile_.on_line(static_cast<F>(begin + passed + width));
            const auto part = profile_.between(here, there);
            ++looked_at;
            if (!part.is_in(cells)) return passed;
            const auto heights = heights_of_blocks(major, part.begin >> shift, (part.end - 1) >> shift);
            const bool passes = side == Side::above ? widen_to<F>(heights.highest) < part.lowest
                                                    : part.highest < widen_to<F>(heights.lowest);
            if (!passes) return passed;
            passed += width;
            if (passed == count) return passed;
            width = glm::min(block_side(level_), count - passed);
            major += profile_.step();
            here = there;
        }
    }

    /// The heights of the blocks from `minor` to `last` of a slab of blocks. As blocks are as wide as they are long, these
    /// are one or two, which is hard to predict; three where the segment goes through a vertex.
    [[nodiscard, HFH_ALWAYS_INLINED]] auto heights_of_blocks(Index major, Index minor,
                                                             Index last) const noexcept {
        auto heights = heights_of_pair(major, minor, last);
        if (last - minor > 1) [[unlikely]] {
            const auto middle = heights_of_pair(major, minor + 1, minor + 1);
            heights = {glm::min(heights.lowest, middle.lowest), glm::max(heights.highest, middle.highest)};
        }
        return heights;
    }
    [[nodiscard, HFH_ALWAYS_INLINED]] auto heights_of_pair(Index major, Index one,
                                                           Index other) const noexcept {
        return field_.block_range(level_, block_at<x_major>(major, one), block_at<x_major>(major, other));
    }

    /// log₂ of the cells along a side of a block.
    [[nodiscard]] static constexpr int block_bits(int level) noexcept {
        return Field::block_bits + 2 * level;
    }
    [[nodiscard]] static constexpr Index block_side(int level) noexcept {
        return Index{1} << block_bits(level);
    }
    /// How many slabs of its block are left, from a slab on.
    [[nodiscard]] Index slabs_left(int level, Index slab) const noexcept {
        return block_side(level) - profile_.slabs_before(slab, block_side(level));
    }

    const Field& field_;
    const SegmentProfile<F>& profile_;
    int level_ = 0, levels_ = 0;
    /// Slabs before this one are looked at cell by cell.
    Index by_cells_until_ = std::numeric_limits<Index>::min();
};

/// Visits the cells under a segment that goes a cell along its major axis or more, but for those in empty slabs. What is
/// visited and what is passed over is in the order of the segment, from `begin_at` on.
///
/// `test` is the visitor, and says what may be passed over: `may_skip()`, `cells_left()` that it may still look at, and
/// `side_at(t)` of what begins at t. It is told of what was: `count(cells)` looked at, and `pass(t, side)` for everything
/// up to t, on one side of the surface. `az` and `bz` are the heights of the segment's ends.
template <bool x_major, HeightField Field, class Test>
void walk_with_skipping(const Field& field, const CellRange& range, CellWalk<FrameScalar<Field>>& walk,
                        FrameScalar<Field> begin_at, FrameScalar<Field> az, FrameScalar<Field> bz,
                        Test& test) noexcept {
    using F = FrameScalar<Field>;
    if (!walk.enter(range, begin_at)) return;
    AxisWalk<F>&major = x_major ? walk.x : walk.y, &minor = x_major ? walk.y : walk.x;
    const SegmentProfile<F> profile{major, minor, az, bz};
    const IndexRange majors = major_range<x_major>(range), minors = minor_range<x_major>(range);
    // Where the segment ends, and where it ends or leaves the range.
    const Index goal_end = profile.slab_of(major.goal_cell) + 1;
    const Index end = profile.slab_of(glm::clamp(major.goal_cell, majors.begin, majors.end - 1)) + 1;
    const auto cells_of_slabs = [&](Index slab, Index slab_end) {
        const Index a = profile.major_cell(slab), b = profile.major_cell(slab_end - 1);
        return CellRange{cell_at<x_major>(glm::min(a, b), minors.begin),
                         cell_at<x_major>(glm::max(a, b) + 1, minors.end)};
    };
    EmptySpace<x_major, Field> empty_space{field, profile};
    // Behind a slab that is not empty the next ones mostly are not either. So slabs are traversed in batches before empty
    // ones are looked for again, and each batch is twice as long until some are found.
    constexpr Index first_batch = 3;
    for (Index batch = first_batch;; batch *= 2) {
        Index slab = profile.slab_of(major.cell);
        if (profile.usable() && test.may_skip() && majors.contains(major.cell)) {
            const EmptySlabs empty =
                empty_space.find(slab, end - slab, test.cells_left(), test.side_at(walk.t));
            test.count(empty.looked_at);
            if (empty.count > 0) {
                slab += empty.count;
                const F t = slab == goal_end ? F(1) : major.line_time(profile.grid_line(slab));
                test.pass(t, empty.side);
                if (slab == end) return;
                major.enter(profile.major_cell(slab));
                minor.skip_to(t, minors.begin, minors.end);
                walk.go_on_at(t);
                batch = first_batch;
            }
        }
        if (!walk.visit(range, cells_of_slabs(slab, glm::min(slab + batch, end)), test)) return;
    }
}

/// How long the segment is along x and along y, in cells.
template <Real F>
[[nodiscard]] inline vec2<F> length_in_cells(const BasicLattice<F>& lattice, const vec3<F>& a,
                                             const vec3<F>& b) noexcept {
    const vec2<F> per_metre = lattice.cells_per_metre();
    return {std::abs((b.x - a.x) * per_metre.x), std::abs((b.y - a.y) * per_metre.y)};
}

/// How many cells there are around a short segment, if they are no more than two by two, each has a patch and all of these
/// lie below the segment; else 0. Nearly every update of a stylus in free flight ends here. It needs no exact numbers of
/// cells: these are widened by more than the rounding of the exact traversal.
template <HeightField Field>
[[nodiscard, HFH_ALWAYS_INLINED]] inline Index
cells_below_short_segment(const Field& field, const vec3<FrameScalar<Field>>& a,
                          const vec3<FrameScalar<Field>>& b) noexcept {
    using F = FrameScalar<Field>;
    const BasicLattice<F>& lattice = field.lattice();
    const vec2<F> origin = lattice.origin(), per_metre = lattice.cells_per_metre();
    const F ax = (a.x - origin.x) * per_metre.x, ay = (a.y - origin.y) * per_metre.y,
            bx = (b.x - origin.x) * per_metre.x, by = (b.y - origin.y) * per_metre.y;
    const F bound_x = 8 * epsilon<F> * (std::abs(ax) + std::abs(bx)),
            bound_y = 8 * epsilon<F> * (std::abs(ay) + std::abs(by));
    const auto cell = [](F x, F y) {
        return Cell{static_cast<Index>(std::floor(x)), static_cast<Index>(std::floor(y))};
    };
    const Cell low = cell(glm::min(ax, bx) - bound_x, glm::min(ay, by) - bound_y),
               high = cell(glm::max(ax, bx) + bound_x, glm::max(ay, by) + bound_y);
    const Index columns = 1 + high.i - low.i, rows = 1 + high.j - low.j;
    if (columns > 2 || rows > 2) return 0;
    // Clear of rounding in the exact traversal, which is a few ulps; and rounding to T keeps the order.
    const auto lowest = static_cast<typename Field::Scalar>(
        glm::min(a.z, b.z) - 32 * epsilon<F> * (std::abs(a.z) + std::abs(b.z)));
    if constexpr (QuickHeightField<Field>) {
        const bool surely = columns + rows < 4 ? field.surely_below(low, high, lowest)
                                               : field.surely_below(low, {high.i, low.j}, lowest) &&
                                                     field.surely_below({low.i, high.j}, high, lowest);
        if (surely) return columns * rows;
    }
    const auto below = [lowest](const auto& patch) { return patch && patch->highest() < lowest; };
    // One cell or two, which is hard to predict. To look at one cell twice costs less than a wrong prediction.
    if (!below(field.patch(low)) || !below(field.patch(high))) return 0;
    if (columns + rows == 4 &&
        !(below(field.patch({high.i, low.j})) && below(field.patch({low.i, high.j})))) {
        return 0;
    }
    return columns * rows;
}

} // namespace hfh::detail

#endif // HFH_TRAVERSAL_EMPTY_SPACE_SKIPPING_HPP
