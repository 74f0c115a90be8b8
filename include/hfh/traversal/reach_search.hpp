#ifndef HFH_TRAVERSAL_REACH_SEARCH_HPP
#define HFH_TRAVERSAL_REACH_SEARCH_HPP

#include <hfh/geometry/patch_minima.hpp>
#include <hfh/terrain/height_field.hpp>

#include <cmath>

// The patches that may come within a distance of a query, which may shrink meanwhile: ring by ring around the query's cell,
// or, where the field bounds its heights, block by block, the nearest first.
//
// Based on: Roussopoulos, Kelley, Vincent, Nearest Neighbor Queries (1995): branch and bound by the distance of boxes.

namespace hfh::detail {

/// Where a query is in a field, and how far its reach is. In metres and in double.
template <HeightField Field>
class ReachSearch {
public:
    using T = typename Field::Scalar;

    /// Precondition: the query is finite, and the field has cells.
    ReachSearch(const Field& field, const glm::dvec3& query, double reach_squared, Index max_work) noexcept
        : field_{field}, cells_{field.cells()}, reach_squared_{reach_squared}, work_left_{max_work} {
        const Lattice& lattice = field.lattice();
        const auto place = [](double x, double origin, double spacing, double per_metre, Index begin,
                              Index end, Index& cell) {
            const double offset = x - origin;
            const double number = glm::clamp(std::floor(offset * per_metre), static_cast<double>(begin),
                                             static_cast<double>(end - 1));
            cell = static_cast<Index>(number);
            return offset - number * spacing;
        };
        dx_ = lattice.spacing().x, dy_ = lattice.spacing().y;
        a_ = place(query.x, lattice.origin().x, dx_, lattice.cells_per_metre().x, cells_.begin.i,
                   cells_.end.i, base_.i);
        b_ = place(query.y, lattice.origin().y, dy_, lattice.cells_per_metre().y, cells_.begin.j,
                   cells_.end.j, base_.j);
        z_ = query.z;
    }

    /// The cell of the query, or the nearest to it; and the query in metres from its corner.
    [[nodiscard]] Cell base() const noexcept { return base_; }
    /// Corner 00 of that cell, in metres from the query.
    [[nodiscard]] glm::dvec2 corner() const noexcept { return {-a_, -b_}; }
    [[nodiscard]] double reach_squared() const noexcept { return reach_squared_; }
    void set_reach_squared(double reach_squared) noexcept { reach_squared_ = reach_squared; }
    [[nodiscard]] Index work_left() const noexcept { return work_left_; }

    /// The patch over a cell, seen from the query.
    [[nodiscard, HFH_ALWAYS_INLINED]] bool read(Cell cell, RelativePatch& seen) const noexcept {
        const auto patch = field_.patch(cell);
        if (!patch) return false;
        seen = {static_cast<double>(cell.i - base_.i) * dx_ - a_,
                static_cast<double>(cell.j - base_.j) * dy_ - b_,
                dx_,
                dy_,
                widen(patch->p00) - z_,
                widen(patch->p10) - z_,
                widen(patch->p01) - z_,
                widen(patch->p11) - z_};
        return true;
    }

    /// Whether other cells than the base come within reach in plan.
    [[nodiscard]] bool reaches_out() const noexcept {
        const double x = glm::min(glm::max(a_, 0.0), glm::max(dx_ - a_, 0.0)),
                     y = glm::min(glm::max(b_, 0.0), glm::max(dy_ - b_, 0.0)), nearest = glm::min(x, y);
        return nearest * nearest < reach_squared_;
    }

    /// Calls visit(cell, patch) for every patch but that of the base whose box comes within reach, until it returns false.
    /// False if the visitor ended it, or the work ran out: a unit for each cell and block that is looked at.
    template <class Visitor>
    [[nodiscard, gnu::noinline]] bool run(Visitor&& visit) noexcept {
        if constexpr (BoundedHeightField<Field>) {
            if (field_.levels() > 0 && reach_squared_ > 4 * dx_ * dy_) return run_by_blocks(visit);
        }
        return run_by_rings(visit);
    }

private:
    struct Span {
        Index begin, end;
    };
    /// A block and the squared distance of its box.
    struct Entry {
        double squared;
        Block block;
        int level;
    };

    /// How far a range of columns or rows is from the query in plan, metres; 0 if it is over it.
    [[nodiscard]] double off_columns(Index begin, Index end) const noexcept {
        const double from = static_cast<double>(begin - base_.i) * dx_ - a_,
                     to = static_cast<double>(end - base_.i) * dx_ - a_;
        return glm::max(glm::max(from, -to), 0.0);
    }
    [[nodiscard]] double off_rows(Index begin, Index end) const noexcept {
        const double from = static_cast<double>(begin - base_.j) * dy_ - b_,
                     to = static_cast<double>(end - base_.j) * dy_ - b_;
        return glm::max(glm::max(from, -to), 0.0);
    }
    /// The part begin … end of a row of columns that comes within reach where the row is so far off.
    [[nodiscard]] Span columns_within(double off_squared, Index begin, Index end) const noexcept {
        const double half = std::sqrt(reach_squared_ - off_squared), per = 1 / dx_;
        const double from = std::floor((a_ - half) * per) - 1, to = std::floor((a_ + half) * per) + 2;
        const double first = static_cast<double>(begin - base_.i), last = static_cast<double>(end - base_.i);
        return {base_.i + static_cast<Index>(glm::clamp(from, first, last)),
                base_.i + static_cast<Index>(glm::clamp(to, first, last))};
    }

    /// Whether another cell or block may be looked at.
    [[nodiscard]] bool spend() noexcept {
        if (work_left_ <= 0) return false;
        --work_left_;
        return true;
    }
    template <class Visitor>
    [[nodiscard, HFH_ALWAYS_INLINED]] bool look_at(Cell cell, Visitor& visit) noexcept {
        if (!spend()) return false;
        RelativePatch seen;
        if (!read(cell, seen) || !(seen.box_squared() < reach_squared_)) return true;
        return visit(cell, seen);
    }
    /// The cells of a row, from one column on.
    template <class Visitor>
    [[nodiscard]] bool look_along(Index j, Index begin, Index end, Visitor& visit) noexcept {
        if (j < cells_.begin.j || j >= cells_.end.j) return true;
        const double off = off_rows(j, j + 1);
        if (!(off * off < reach_squared_)) return true;
        const Span within = columns_within(off * off, begin, end);
        for (Index i = within.begin; i < within.end; ++i) {
            if (!(i == base_.i && j == base_.j) && !look_at({i, j}, visit)) return false;
        }
        return true;
    }
    /// The cells of a column, from one row on.
    template <class Visitor>
    [[nodiscard]] bool look_up(Index i, Index begin, Index end, Visitor& visit) noexcept {
        if (i < cells_.begin.i || i >= cells_.end.i) return true;
        const double off = off_columns(i, i + 1);
        if (!(off * off < reach_squared_)) return true;
        for (Index j = begin; j < end; ++j) {
            const double off_row = off_rows(j, j + 1);
            if (off * off + off_row * off_row < reach_squared_ && !look_at({i, j}, visit)) return false;
        }
        return true;
    }

    /// Whether rows or columns n rings out are there and within reach, on one side at least.
    [[nodiscard]] bool has_ring(Index n) const noexcept {
        const auto within = [&](double off) { return off * off < reach_squared_; };
        const Index left = base_.i - n, right = base_.i + n, down = base_.j - n, up = base_.j + n;
        return (left >= cells_.begin.i && within(off_columns(left, left + 1))) ||
               (right < cells_.end.i && within(off_columns(right, right + 1))) ||
               (down >= cells_.begin.j && within(off_rows(down, down + 1))) ||
               (up < cells_.end.j && within(off_rows(up, up + 1)));
    }
    template <class Visitor>
    [[nodiscard]] bool run_by_rings(Visitor& visit) noexcept {
        // Ends: a ring that is wider than the field is not there.
        for (Index n = 1; has_ring(n); ++n) {
            const Index left = base_.i - n, right = base_.i + n, down = base_.j - n, up = base_.j + n;
            const Index begin = glm::max(left, cells_.begin.i), end = glm::min(right + 1, cells_.end.i);
            const Index begin_j = glm::max(down + 1, cells_.begin.j), end_j = glm::min(up, cells_.end.j);
            if (!look_along(down, begin, end, visit) || !look_along(up, begin, end, visit) ||
                !look_up(left, begin_j, end_j, visit) || !look_up(right, begin_j, end_j, visit)) {
                return false;
            }
        }
        return true;
    }

    /// log₂ of the cells along a side of a block. The highest block may be wider than an Index counts, but no field is.
    [[nodiscard]] static int side_bits(int level) noexcept {
        return glm::min(Field::block_bits + 2 * level, std::numeric_limits<Index>::digits - 1);
    }
    /// The cells of a block: begin … end along both axes.
    [[nodiscard]] CellRange cells_of(int level, Block block) const noexcept {
        const int bits = side_bits(level);
        const Cell begin{block.i << bits, block.j << bits};
        const auto end = [bits](Index first, Index last) {
            return last - first < Index{1} << bits ? last : first + (Index{1} << bits);
        };
        return {begin, {end(begin.i, cells_.end.i), end(begin.j, cells_.end.j)}};
    }
    [[nodiscard]] Entry entry(int level, Block block) const noexcept {
        const CellRange cells = cells_of(level, block);
        const double x = off_columns(cells.begin.i, cells.end.i), y = off_rows(cells.begin.j, cells.end.j);
        const double plan = x * x + y * y;
        if (!(plan < reach_squared_)) return {plan, block, level};
        const auto range = field_.block_range(level, block, block);
        const double z = glm::max(glm::max(widen(range.lowest) - z_, z_ - widen(range.highest)), 0.0);
        return {plan + z * z, block, level};
    }
    template <class Visitor>
    [[nodiscard]] bool look_at_cells(const CellRange& cells, Visitor& visit) noexcept {
        for (Index j = cells.begin.j; j < cells.end.j; ++j) {
            if (!look_along(j, cells.begin.i, cells.end.i, visit)) return false;
        }
        return true;
    }
    /// The lowest level of which the disc within reach takes up few blocks: begin … end.
    [[nodiscard]] int first_level(Block& begin, Block& end) const noexcept {
        const double reach = std::sqrt(reach_squared_);
        const auto cells = [&](double from, double to, double per, Index base, Index first, Index last) {
            const double low = static_cast<double>(first - base), high = static_cast<double>(last - 1 - base);
            return Span{base + static_cast<Index>(glm::clamp(std::floor(from * per) - 1, low, high)),
                        base + static_cast<Index>(glm::clamp(std::floor(to * per) + 1, low, high)) + 1};
        };
        const Span i = cells(a_ - reach, a_ + reach, 1 / dx_, base_.i, cells_.begin.i, cells_.end.i),
                   j = cells(b_ - reach, b_ + reach, 1 / dy_, base_.j, cells_.begin.j, cells_.end.j);
        int level = 0;
        for (;; ++level) {
            const int bits = side_bits(level);
            begin = {i.begin >> bits, j.begin >> bits};
            end = {((i.end - 1) >> bits) + 1, ((j.end - 1) >> bits) + 1};
            const bool few = end.i - begin.i <= most_a_side && end.j - begin.j <= most_a_side;
            if (few || level + 1 == field_.levels()) return level;
        }
    }
    /// Looks at blocks of a level and keeps those within reach on the stack, the nearest on top.
    [[nodiscard]] bool push(Entry* stack, int& count, int level, Block begin, Block end) noexcept {
        const int bottom = count;
        for (Index j = begin.j; j < end.j; ++j) {
            for (Index i = begin.i; i < end.i; ++i) {
                if (!spend()) return false;
                const Entry e = entry(level, {i, j});
                if (!(e.squared < reach_squared_)) continue;
                int at = count++;
                for (; at > bottom && stack[at - 1].squared < e.squared; --at) stack[at] = stack[at - 1];
                stack[at] = e;
            }
        }
        return true;
    }
    template <class Visitor>
    [[nodiscard]] bool run_by_blocks(Visitor& visit) noexcept {
        // One block at a time becomes its 16 parts.
        Entry stack[most_a_side * most_a_side + 15 * (std::numeric_limits<Index>::digits / 2 + 1)];
        Block begin, end;
        const int first = first_level(begin, end);
        int count = 0;
        if (!push(stack, count, first, begin, end)) return false;
        while (count > 0) {
            const Entry nearest = stack[--count];
            if (!(nearest.squared < reach_squared_)) continue;
            const CellRange cells = cells_of(nearest.level, nearest.block);
            if (nearest.level == 0) {
                if (!look_at_cells(cells, visit)) return false;
                continue;
            }
            const int bits = side_bits(nearest.level - 1);
            const Block part_begin{nearest.block.i * 4, nearest.block.j * 4},
                part_end{((cells.end.i - 1) >> bits) + 1, ((cells.end.j - 1) >> bits) + 1};
            if (!push(stack, count, nearest.level - 1, part_begin, part_end)) return false;
        }
        return true;
    }

    static constexpr int most_a_side = 4; ///< blocks to begin with

    const Field& field_;
    CellRange cells_;
    Cell base_{};
    double dx_, dy_, a_, b_, z_;
    double reach_squared_;
    Index work_left_;
};

} // namespace hfh::detail

#endif // HFH_TRAVERSAL_REACH_SEARCH_HPP
