#ifndef HFH_TRAVERSAL_CANDIDATE_WALKER_HPP
#define HFH_TRAVERSAL_CANDIDATE_WALKER_HPP

#include <hfh/terrain/height_field.hpp>

#include <glm/common.hpp>

#include <cmath>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.1: the haptic ray is projected into the grid,
// an incremental line algorithm finds the patches under it, and each is tested by height. The walk itself is that
// of Amanatides and Woo, A Fast Voxel Traversal Algorithm for Ray Tracing (1987), with crossing times computed
// afresh from integers instead of accumulated, so that a walk of any length does not drift.

namespace hfh {

/// The part of a segment a → b over one cell.
struct CellSpan {
    Cell cell;
    double t_in, t_out; ///< 0 ≤ t_in ≤ t_out ≤ 1 along a → b
    glm::dvec2 in, out; ///< (u, v) there, in [0, 1]; exactly 0 or 1 on the grid line that is crossed
};

namespace detail {

/// A coordinate as a cell number and the rest in metres: 0 ≤ rest < spacing, but for the rounding of the rest.
struct Split {
    Index cell;
    double rest;
};

[[nodiscard]] inline Split split(double x, double origin, double spacing, double per_metre) noexcept {
    // The product may round across a line, 49·(1/49) < 1; the lines themselves tell.
    const double offset = x - origin, number = std::floor(offset * per_metre);
    const auto cell = static_cast<Index>(number);
    if (offset < number * spacing) return {cell - 1, offset - (number - 1) * spacing};
    if (offset >= (number + 1) * spacing) return {cell + 1, offset - (number + 1) * spacing};
    return {cell, offset - number * spacing};
}

/// One axis of a walk: which cells it passes and when it crosses the line into the next.
///
/// A time is one quotient of lengths in metres. Where these are exact, it is the exact time, correctly rounded, and
/// the two axes agree to the bit on when a vertex is passed.
struct AxisWalk {
    static constexpr double never = 2; ///< later than any t of a segment

    Index base, first, cell, last; ///< cell of a; cells where the walk begins, is and ends
    Index step;                    ///< +1, −1, or 0 for a segment that does not move along this axis
    Index ahead;                   ///< cell i is left on line i + ahead: 1 if the segment goes up, else 0
    double spacing, per_metre;
    double a, d;          ///< start and displacement, in metres from line `base`
    double start, end;    ///< a and b in cells from lines `first` and `last`
    bool on_line;         ///< the whole segment lies on the line between `cell − 1` and `cell`
    Index end_line;       ///< the grid line that b is on, if any
    double leave = never; ///< when the segment goes on from `cell` into the next one
    bool beyond = false;  ///< after `skip_to`: the line on which `cell` is entered was met before t

    /// From `begin` to `goal`, `displacement` metres further.
    AxisWalk(const Split& begin, const Split& goal, double displacement, double dx,
             double cells_per_metre) noexcept
        : spacing{dx}, per_metre{cells_per_metre}, d{displacement} {
        base = cell = begin.cell;
        last = goal.cell;
        a = begin.rest;
        start = in_cells(begin.rest);
        end = in_cells(goal.rest);
        // Nobody can foresee the direction: what depends on it is computed, here and below, not branched on.
        ahead = static_cast<Index>(d > 0);
        step = ahead - static_cast<Index>(d < 0);
        on_line = step == 0 && a == 0;
        end_line = goal.rest == 0 ? goal.cell : std::numeric_limits<Index>::max();
        // Cells are closed: a segment that leaves a line touches the cell behind it, and one that ends on a line
        // touches the cell beyond it.
        if (a == 0 && step > 0) --cell, start = 1;
        if (goal.rest == 0 && step < 0) --last, end = 1;
        last = cell + (last - cell) * static_cast<Index>((last - cell) * step > 0);
        first = cell;
    }

    /// A length within a cell, in cells.
    [[nodiscard]] double in_cells(double metres) const noexcept {
        return glm::clamp(metres * per_metre, 0.0, 1.0);
    }
    /// When the segment is on grid line i. Precondition: step ≠ 0.
    [[nodiscard]] double time_at(Index i) const noexcept {
        if (i == end_line) return 1; // to the bit, also where a and d are rounded
        return glm::clamp((static_cast<double>(i - base) * spacing - a) / d, 0.0, 1.0);
    }
    /// When the segment enters the next cell.
    [[nodiscard]] double next() const noexcept { return cell == last ? never : time_at(cell + ahead); }
    /// Position at t in the current cell.
    [[nodiscard]] double at(double t) const noexcept {
        if (t == 0 && cell == first) return start;
        if (t == 1 && cell == last) return end;
        return in_cells((a - static_cast<double>(cell - base) * spacing) + t * d);
    }
    /// Position at t, where the walk begins in the current cell: to the bit on a line that is met at t.
    [[nodiscard]] double entry(double t) noexcept {
        if (t == 0) leave = next(); // no skip_to has told
        if (cell != first && !beyond && time_at(cell + 1 - ahead) >= t) return 1 - leaving();
        return leave <= t ? leaving() : at(t);
    }
    void advance() noexcept {
        cell += step;
        leave = next();
    }
    /// Goes to a cell further on, to the line on which it is entered.
    void enter(Index further) noexcept {
        cell = further;
        beyond = false;
        leave = next();
    }
    /// The line on which the current cell is left (1 or 0).
    [[nodiscard]] double leaving() const noexcept { return static_cast<double>(ahead); }

    /// When the segment enters and leaves the cells from ≤ i < past; later than `never` if it does not.
    [[nodiscard]] bool clip(Index from, Index past, double& t_enter, double& t_leave) const noexcept {
        if (step == 0) return (from <= first && first < past) || (on_line && first == past);
        const Index lowest = glm::min(first, last), highest = glm::max(first, last);
        if (highest < from || lowest >= past) return false;
        if (lowest >= from && highest < past) return true;
        const Index in = step > 0 ? from : past - 1;
        const Index out = step > 0 ? past - 1 : from;
        if ((in - first) * step > 0) t_enter = glm::max(t_enter, time_at(step > 0 ? from : past));
        if ((last - out) * step > 0) t_leave = glm::min(t_leave, time_at(step > 0 ? past : from));
        return true;
    }
    /// Goes to the earliest cell of from ≤ i < past that holds the position at t > 0.
    void skip_to(double t, Index from, Index past) noexcept {
        if (step == 0) return;
        // A cell that is entered before t, by more than rounding.
        const double number = (a + t * d) * per_metre;
        const double blur = 64 * epsilon<double> * (std::abs(number) + 2);
        const auto near = base + static_cast<Index>(std::floor(number - static_cast<double>(step) * blur));
        cell = glm::clamp(near, glm::min(first, last), glm::max(first, last));
        cell = glm::clamp(cell, from, past - 1);
        beyond = cell == near;
        const Index stop = glm::clamp(last, from, past - 1);
        for (leave = next(); cell != stop && leave < t; advance()) beyond = true;
    }
};

/// Both ends of a segment a → b as cells and rests.
struct SplitEnds {
    Split ax, ay, bx, by;

    SplitEnds(const Lattice& lattice, const glm::dvec2& a, const glm::dvec2& b) noexcept {
        const glm::dvec2 origin = lattice.origin(), spacing = lattice.spacing(),
                         per_metre = lattice.cells_per_metre();
        ax = split(a.x, origin.x, spacing.x, per_metre.x);
        ay = split(a.y, origin.y, spacing.y, per_metre.y);
        bx = split(b.x, origin.x, spacing.x, per_metre.x);
        by = split(b.y, origin.y, spacing.y, per_metre.y);
    }
};

/// The walk of `walk_cells`. It can be stopped and gone on with, and may skip cells: what it finds in a cell is the same
/// to the bit.
struct CellWalk {
    AxisWalk x, y;
    double t = AxisWalk::never; ///< when the segment enters the cell that is visited next
    glm::dvec2 in{};            ///< (u, v) there, once a cell has been visited
    bool entered = false;       ///< none has been since `enter`

    CellWalk(const Lattice& lattice, const SplitEnds& ends, const glm::dvec2& displacement) noexcept
        : x{ends.ax, ends.bx, displacement.x, lattice.spacing().x, lattice.cells_per_metre().x},
          y{ends.ay, ends.by, displacement.y, lattice.spacing().y, lattice.cells_per_metre().y} {}

    /// Goes on from the cell in which both axes were put, where the segment comes in at t.
    void enter_at(double when) noexcept {
        t = when;
        entered = true;
    }

    /// Goes to the first cell of the range. False if the segment never is there.
    [[nodiscard]] bool enter(const CellRange& range) noexcept {
        double t_enter = 0, t_leave = 1;
        if (range.empty() || !x.clip(range.begin.i, range.end.i, t_enter, t_leave) ||
            !y.clip(range.begin.j, range.end.j, t_enter, t_leave) || t_enter > t_leave) {
            return false;
        }
        x.cell = x.first;
        y.cell = y.first;
        if (t_enter > 0) {
            x.skip_to(t_enter, range.begin.i, range.end.i);
            y.skip_to(t_enter, range.begin.j, range.end.j);
        }
        enter_at(t_enter);
        return true;
    }

    /// Whether the next cell is in the range.
    [[nodiscard]] bool inside(const CellRange& range) const noexcept {
        const bool in_x = (range.begin.i <= x.cell) & (x.cell < range.end.i),
                   in_y = (range.begin.j <= y.cell) & (y.cell < range.end.j);
        return (in_x | x.on_line) & (in_y | y.on_line);
    }

    /// Visits the cells of `range`, until the next one is not in `part`, which is in `range`: then true. False if the
    /// visitor stopped it, or the segment left `range` or ended.
    template <class Visitor>
    bool visit(const CellRange& range, const CellRange& part, Visitor&& visit) noexcept {
        const auto visit_beside = [&](const CellSpan& span) {
            return !range.contains(span.cell) || visit(span);
        };
        if (entered) in = {x.entry(t), y.entry(t)};
        entered = false;
        for (;;) {
            const bool cross_x = x.leave <= y.leave && x.leave <= 1,
                       cross_y = y.leave <= x.leave && y.leave <= 1;
            const double t_out = glm::max(t, glm::min(glm::min(x.leave, y.leave), 1.0));
            glm::dvec2 out = in;
            if (cross_x) {
                out.x = x.leaving();
            } else if (t_out > t) {
                out.x = x.at(t_out);
            }
            if (cross_y) {
                out.y = y.leaving();
            } else if (t_out > t) {
                out.y = y.at(t_out);
            }
            const CellSpan span{{x.cell, y.cell}, t, t_out, in, out};
            // The cells on the other side of a line, or three others around a vertex, have the span on their border.
            if (x.on_line || y.on_line) {
                for (const auto [left, below] : {Cell{1, 1}, Cell{0, 1}, Cell{1, 0}}) {
                    if ((left > 0 && !x.on_line) || (below > 0 && !y.on_line)) continue;
                    CellSpan beside = span;
                    beside.cell = {x.cell - left, y.cell - below};
                    if (left > 0) beside.in.x = beside.out.x = 1;
                    if (below > 0) beside.in.y = beside.out.y = 1;
                    if (!visit_beside(beside)) return false;
                }
            }
            if (range.contains(span.cell) && !visit(span)) return false;
            if (!cross_x && !cross_y) return false;

            in = out;
            if (cross_x) in.x = 1 - out.x;
            if (cross_y) in.y = 1 - out.y;
            if (cross_x && cross_y) { // through a vertex: it touches the two cells beside the diagonal
                for (const bool by_x : {true, false}) {
                    const glm::dvec2 there{by_x ? in.x : out.x, by_x ? out.y : in.y};
                    const Cell beside = by_x ? Cell{x.cell + x.step, y.cell} : Cell{x.cell, y.cell + y.step};
                    if (!visit_beside({beside, t_out, t_out, there, there})) return false;
                }
            }
            if (cross_x) x.advance();
            if (cross_y) y.advance();
            t = t_out;
            if (!inside(part)) return inside(range);
        }
    }
};

} // namespace detail

/// Visits the cells under the segment a → b, in the order of the segment, each exactly once, and none is missed:
/// every cell of `range` whose closed rectangle the projection meets. A segment along a grid line visits the
/// cells on both sides of it, one through a vertex all four around it, a vertical one (or one of zero length) the
/// cells around its foot. Spans join: each begins where the last ended, and the first at the border if a lies
/// outside. The only rounding is that of the crossing times, an ulp or so of t.
///
/// `visit(const CellSpan&)` returns true to go on, false to stop.
/// a and b must be finite and within reach of the lattice (`Lattice::reaches`). O(cells passed); no allocation.
template <class Visitor>
void walk_cells(const Lattice& lattice, const CellRange& range, const glm::dvec2& a, const glm::dvec2& b,
                Visitor&& visit) noexcept {
    detail::CellWalk walk{lattice, detail::SplitEnds{lattice, a, b}, b - a};
    if (walk.enter(range)) walk.visit(range, range, visit);
}

/// Visits the candidate patches of §4.3.1 [P]: of the cells under a → b those that hold a patch which the part of
/// the segment over it may touch, that is, whose highest corner is not below the lowest point of that part.
///
/// `visit(const CellSpan&, const BilinearPatch<Scalar>&)` returns true to go on, false to stop.
template <HeightField Field, Real T, class Visitor>
void walk_candidates(const Field& field, const vec3<T>& a, const vec3<T>& b, Visitor&& visit) noexcept {
    const glm::dvec3 from = widen(a), to = widen(b);
    walk_cells(field.lattice(), field.cells(), {from.x, from.y}, {to.x, to.y}, [&](const CellSpan& span) {
        const auto patch = field.patch(span.cell);
        if (!patch) return true;
        const double z_in = (1 - span.t_in) * from.z + span.t_in * to.z;
        const double z_out = (1 - span.t_out) * from.z + span.t_out * to.z;
        return glm::min(z_in, z_out) > widen(patch->highest()) || visit(span, *patch);
    });
}

} // namespace hfh

#endif // HFH_TRAVERSAL_CANDIDATE_WALKER_HPP
