#ifndef HFH_TRAVERSAL_CANDIDATE_WALKER_HPP
#define HFH_TRAVERSAL_CANDIDATE_WALKER_HPP

#include <hfh/terrain/height_field.hpp>

#include <glm/common.hpp>

#include <cmath>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.1: the haptic ray is projected into the grid,
// an incremental line algorithm finds the patches under it, and each is tested by height. The traversal itself is that
// of Amanatides and Woo, A Fast Voxel Traversal Algorithm for Ray Tracing (1987), with crossing times computed
// afresh from integers instead of accumulated, so that a traversal of any length does not drift.

namespace hfh {

/// The part of a segment a → b over one cell. F is what the lattice computes in.
template <Real F>
struct BasicCellSpan {
    Cell cell;
    F t_in, t_out;   ///< 0 ≤ t_in ≤ t_out ≤ 1 along a → b
    vec2<F> in, out; ///< (u, v) there, in [0, 1]; exactly 0 or 1 on the grid line that is crossed
};
using CellSpan = BasicCellSpan<double>;

/// Visits the cells under the segment a → b (its supercover), in the order of the segment, each exactly once, and none is
/// missed: every cell of `range` whose closed rectangle the projection meets. A segment along a grid line visits the
/// cells on both sides of it, one through a vertex all four around it, a vertical one (or one of zero length) the
/// cells around its foot. Spans join: each begins where the one before ended, and the first at the border if a lies
/// outside. The only rounding is that of the crossing times, an ulp or so of t.
///
/// `visit(const BasicCellSpan<F>&)` returns true to go on, false to stop.
/// a and b must be finite and within reach of the lattice (`Lattice::reaches`). O(cells passed); no allocation.
template <Real F, class Visitor>
void walk_cells(const BasicLattice<F>& lattice, const CellRange& range, const vec2<F>& a, const vec2<F>& b,
                Visitor&& visit) noexcept;

/// Visits the candidate patches of §4.3.1 [P]: of the cells under a → b those that hold a patch which the part of
/// the segment over it may touch, that is, whose highest corner is not below the lowest point of that part.
///
/// `visit(const BasicCellSpan<F>&, const BilinearPatch<Scalar>&)` returns true to go on, false to stop.
template <HeightField Field, Real T, class Visitor>
void walk_candidates(const Field& field, const vec3<T>& a, const vec3<T>& b, Visitor&& visit) noexcept;

namespace detail {

/// One coordinate of a point, as the number of a cell and the rest in metres: 0 ≤ rest < spacing, but for the rounding of
/// the rest.
template <Real F>
struct CellCoordinate {
    Index cell;
    F rest;
};

template <Real F>
[[nodiscard]] inline CellCoordinate<F> cell_coordinate(F x, F origin, F spacing, F cells_per_metre) noexcept {
    // The product may round across a grid line, as 49·(1/49) < 1 does. So the result is compared with the lines.
    const F offset = x - origin;
    if constexpr (std::same_as<F, float>) {
        // Rounded towards zero, which is one instruction and at the most one cell too far.
        const auto cell = static_cast<Index>(offset * cells_per_metre);
        const auto rest_from = [&](Index line) { return from_line(offset, static_cast<F>(line), spacing); };
        const F rest = rest_from(cell);
        if (rest < 0) return {cell - 1, rest_from(cell - 1)};
        const F beyond = rest_from(cell + 1);
        if (beyond >= 0) return {cell + 1, beyond};
        return {cell, rest};
    }
    const F number = std::floor(offset * cells_per_metre);
    const auto cell = static_cast<Index>(number);
    if (offset < number * spacing) return {cell - 1, offset - (number - 1) * spacing};
    if (offset >= (number + 1) * spacing) return {cell + 1, offset - (number + 1) * spacing};
    return {cell, offset - number * spacing};
}

/// The coordinate nearest to x that lies in a cell, its border included, as `cell_coordinate` tells it.
template <Real F>
[[nodiscard]] inline F into_cell(F x, Index cell, F origin, F spacing, F cells_per_metre) noexcept {
    const auto in_cell = [&] {
        const CellCoordinate<F> at = cell_coordinate(x, origin, spacing, cells_per_metre);
        return at.cell == cell || (at.cell == cell + 1 && at.rest == 0);
    };
    if (in_cell()) return x;
    const F lower = static_cast<F>(cell) * spacing, upper = static_cast<F>(cell + 1) * spacing;
    const bool from_above = x - origin > upper;
    x = origin + (from_above ? upper : lower);
    // The line itself is rounded, too.
    for (int ulps = 0; ulps < 4 && !in_cell(); ++ulps)
        x += (from_above ? -epsilon<F> : epsilon<F>)*std::abs(x);
    return x;
}

/// One axis of a traversal: the cells that the segment passes along it, and when it crosses the line into the next.
///
/// A time is one quotient of lengths in metres. Where these are exact, it is the exact time, correctly rounded, and
/// the two axes agree to the bit on when a vertex is passed. A *parameter* is a place in a cell, u or v, from 0 to 1.
///
/// The sign of the direction enters as a number, 0 or 1, and not as a branch, which a processor would often predict wrong.
template <Real F>
struct AxisWalk {
    static constexpr F never = 2; ///< later than any t of a segment

    Index base;                        ///< the cell of a; lengths are measured from its lower line
    Index start_cell, cell, goal_cell; ///< where the traversal begins, is, and ends
    Index step;                        ///< +1, −1, or 0 for a segment that does not move along this axis
    Index exit_side; ///< cell i is left over line i + exit_side: 1 if the segment goes up, else 0
    F spacing, cells_per_metre;
    F a, d;                            ///< start and displacement, in metres from line `base`
    F start_parameter, goal_parameter; ///< of a in `start_cell`, and of b in `goal_cell`
    bool on_line;                      ///< the whole segment lies on the line between `cell − 1` and `cell`
    Index goal_line;                   ///< the grid line that b is on, if any
    F t_exit = never;                  ///< when the segment goes on from `cell` into the next one
    bool entered_before =
        false; ///< after `skip_to(t, …)`: the line over which `cell` is entered was crossed before t

    /// From `from` to `goal`, `displacement` metres further.
    AxisWalk(const CellCoordinate<F>& from, const CellCoordinate<F>& goal, F displacement, F dx,
             F per_metre) noexcept
        : spacing{dx}, cells_per_metre{per_metre}, d{displacement} {
        base = cell = from.cell;
        goal_cell = goal.cell;
        a = from.rest;
        start_parameter = parameter(from.rest);
        goal_parameter = parameter(goal.rest);
        exit_side = static_cast<Index>(d > 0);
        step = exit_side - static_cast<Index>(d < 0);
        on_line = step == 0 && a == 0;
        goal_line = goal.rest == 0 ? goal.cell : std::numeric_limits<Index>::max();
        // Cells are closed: a segment that leaves a line touches the cell behind it, and one that ends on a line
        // touches the cell beyond it.
        if (a == 0 && step > 0) --cell, start_parameter = 1;
        if (goal.rest == 0 && step < 0) --goal_cell, goal_parameter = 1;
        goal_cell = cell + (goal_cell - cell) * static_cast<Index>((goal_cell - cell) * step > 0);
        start_cell = cell;
    }

    /// The parameter of a place so far from the lower line of its cell.
    [[nodiscard]] F parameter(F metres) const noexcept {
        return glm::clamp(metres * cells_per_metre, F(0), F(1));
    }
    /// The parameter at t in the current cell.
    [[nodiscard]] F parameter_at(F t) const noexcept {
        if (t == 0 && cell == start_cell) return start_parameter;
        if (t == 1 && cell == goal_cell) return goal_parameter;
        return parameter(from_line(a, static_cast<F>(cell - base), spacing) + t * d);
    }
    /// The parameter of the line over which the current cell is left: 1 or 0.
    [[nodiscard]] F exit_parameter() const noexcept { return static_cast<F>(exit_side); }
    /// The parameter at t, where the traversal begins in the current cell: exact on a line that is crossed at t.
    [[nodiscard]] F entry_parameter(F t) const noexcept {
        if (cell != start_cell && !entered_before && line_time(cell + 1 - exit_side) >= t)
            return 1 - exit_parameter();
        return t_exit <= t ? exit_parameter() : parameter_at(t);
    }

    /// Metres from a to the line with this number, counted from `base`.
    [[nodiscard]] F to_line(F line) const noexcept {
        if constexpr (std::same_as<F, float>) {
            return std::fma(line, spacing, -a);
        } else {
            return line * spacing - a;
        }
    }
    /// When the segment is on grid line i. Precondition: step ≠ 0.
    [[nodiscard]] F line_time(Index i) const noexcept {
        if (i == goal_line) return 1; // to the bit, also where a and d are rounded
        return glm::clamp(to_line(static_cast<F>(i - base)) / d, F(0), F(1));
    }
    /// When the segment leaves the current cell for the next one.
    [[nodiscard]] F exit_time() const noexcept {
        return cell == goal_cell ? never : line_time(cell + exit_side);
    }

    /// Takes the current cell for the one in which the traversal begins.
    void begin() noexcept { t_exit = exit_time(); }
    /// Goes to the next cell.
    void advance() noexcept {
        cell += step;
        t_exit = exit_time();
    }
    /// Goes to a cell further on, to the line over which it is entered.
    void enter(Index further) noexcept {
        cell = further;
        entered_before = false;
        t_exit = exit_time();
    }

    /// Narrows the times [t_enter, t_leave] to those in the cells begin ≤ i < end. False if the segment is never there.
    [[nodiscard]] bool clip(Index begin, Index end, F& t_enter, F& t_leave) const noexcept {
        if (step == 0) return (begin <= start_cell && start_cell < end) || (on_line && start_cell == end);
        const Index lowest = glm::min(start_cell, goal_cell), highest = glm::max(start_cell, goal_cell);
        if (highest < begin || lowest >= end) return false;
        if (lowest >= begin && highest < end) return true;
        const Index in = step > 0 ? begin : end - 1;
        const Index out = step > 0 ? end - 1 : begin;
        if ((in - start_cell) * step > 0) t_enter = glm::max(t_enter, line_time(step > 0 ? begin : end));
        if ((goal_cell - out) * step > 0) t_leave = glm::min(t_leave, line_time(step > 0 ? end : begin));
        return true;
    }
    /// Goes to the earliest cell of begin ≤ i < end that holds the position at t > 0.
    void skip_to(F t, Index begin, Index end) noexcept {
        if (step == 0) return;
        // Begins in a cell that is entered before t, whatever the rounding, and ends at the latest in the last of both
        // the segment and the range.
        const F number = (a + t * d) * cells_per_metre;
        const F rounding_bound = 64 * epsilon<F> * (std::abs(number) + 2);
        const auto earliest =
            base + static_cast<Index>(std::floor(number - static_cast<F>(step) * rounding_bound));
        cell = glm::clamp(earliest, glm::min(start_cell, goal_cell), glm::max(start_cell, goal_cell));
        cell = glm::clamp(cell, begin, end - 1);
        entered_before = cell == earliest;
        const Index stop = glm::clamp(goal_cell, begin, end - 1);
        for (t_exit = exit_time(); cell != stop && t_exit < t; advance()) entered_before = true;
    }
};

/// How a segment leaves a cell: over a line of x, over one of y, over both at a vertex, or over none where it ends.
template <Real F>
struct CellExit {
    F t;
    vec2<F> at; ///< (u, v) there, in the cell that is left
    bool over_x, over_y;

    [[nodiscard]] bool ends() const noexcept { return !over_x && !over_y; }
    [[nodiscard]] bool at_vertex() const noexcept { return over_x && over_y; }
    /// u, as the next cell along x sees it.
    [[nodiscard]] F next_u() const noexcept { return over_x ? 1 - at.x : at.x; }
    [[nodiscard]] F next_v() const noexcept { return over_y ? 1 - at.y : at.y; }
};

/// The traversal of `walk_cells`. It can be stopped and gone on with, and can pass over cells: what it finds in a cell is
/// the same to the bit.
template <Real F>
struct CellWalk {
    AxisWalk<F> x, y;
    F t = AxisWalk<F>::never; ///< when the segment enters the cell that is visited next
    vec2<F> in{};             ///< (u, v) there, if `in_known`
    bool in_known = false;    ///< else it is computed when the cell is visited

    CellWalk(const BasicLattice<F>& lattice, const vec2<F>& a, const vec2<F>& b) noexcept
        : x{cell_coordinate(a.x, lattice.origin().x, lattice.spacing().x, lattice.cells_per_metre().x),
            cell_coordinate(b.x, lattice.origin().x, lattice.spacing().x, lattice.cells_per_metre().x),
            b.x - a.x, lattice.spacing().x, lattice.cells_per_metre().x},
          y{cell_coordinate(a.y, lattice.origin().y, lattice.spacing().y, lattice.cells_per_metre().y),
            cell_coordinate(b.y, lattice.origin().y, lattice.spacing().y, lattice.cells_per_metre().y),
            b.y - a.y, lattice.spacing().y, lattice.cells_per_metre().y} {}

    /// Goes to the first cell of the range, once, before anything else; of those that the segment is in at `begin` or later.
    /// False if the segment is never there.
    [[nodiscard]] bool enter(const CellRange& range, F begin = 0) noexcept {
        F t_enter = begin, t_leave = 1;
        if (range.empty() || !x.clip(range.begin.i, range.end.i, t_enter, t_leave) ||
            !y.clip(range.begin.j, range.end.j, t_enter, t_leave) || t_enter > t_leave) {
            return false;
        }
        if (t_enter > 0) {
            x.skip_to(t_enter, range.begin.i, range.end.i);
            y.skip_to(t_enter, range.begin.j, range.end.j);
        }
        go_on_at(t_enter);
        return true;
    }
    /// Goes on from the cell to which both axes were moved, which the segment enters at `when`.
    void go_on_at(F when) noexcept {
        t = when;
        in_known = false;
    }

    /// Visits the cells of `range`, until the next one is not in `part`, which is in `range`: then true. False if the
    /// visitor stopped it, or the segment left `range` or ended.
    template <class Visitor>
    bool visit(const CellRange& range, const CellRange& part, Visitor&& visitor) noexcept {
        const auto visit_beside = [&](const BasicCellSpan<F>& span) {
            return !range.contains(span.cell) || visitor(span);
        };
        if (!in_known) locate_entry();
        for (;;) {
            const CellExit<F> exit = next_exit();
            const BasicCellSpan<F> span{{x.cell, y.cell}, t, exit.t, in, exit.at};
            if ((x.on_line || y.on_line) && !visit_beside_line(span, visit_beside)) return false;
            if (range.contains(span.cell) && !visitor(span)) return false;
            if (exit.ends()) return false;
            if (exit.at_vertex() && !visit_beside_vertex(exit, visit_beside)) return false;
            cross(exit);
            if (!inside(part)) return inside(range);
        }
    }

private:
    /// Whether the current cell is in the range, or another one on the line along which the segment goes.
    [[nodiscard]] bool inside(const CellRange& range) const noexcept {
        const bool in_x = (range.begin.i <= x.cell) & (x.cell < range.end.i),
                   in_y = (range.begin.j <= y.cell) & (y.cell < range.end.j);
        return (in_x | x.on_line) & (in_y | y.on_line);
    }

    /// Computes where the segment is in the cell with which the traversal begins or goes on.
    [[HFH_ALWAYS_INLINED]] void locate_entry() noexcept {
        if (t == 0) { // no axis has been moved
            x.begin();
            y.begin();
        }
        in = {x.entry_parameter(t), y.entry_parameter(t)};
        in_known = true;
    }

    /// Where the segment leaves the current cell.
    [[nodiscard, HFH_ALWAYS_INLINED]] CellExit<F> next_exit() const noexcept {
        CellExit<F> exit{glm::max(t, glm::min(glm::min(x.t_exit, y.t_exit), F(1))), in,
                         x.t_exit <= y.t_exit && x.t_exit <= 1, y.t_exit <= x.t_exit && y.t_exit <= 1};
        if (exit.over_x) {
            exit.at.x = x.exit_parameter();
        } else if (exit.t > t) {
            exit.at.x = x.parameter_at(exit.t);
        }
        if (exit.over_y) {
            exit.at.y = y.exit_parameter();
        } else if (exit.t > t) {
            exit.at.y = y.parameter_at(exit.t);
        }
        return exit;
    }

    /// Goes over the line, or the vertex, into the next cell.
    [[HFH_ALWAYS_INLINED]] void cross(const CellExit<F>& exit) noexcept {
        in = {exit.next_u(), exit.next_v()};
        if (exit.over_x) x.advance();
        if (exit.over_y) y.advance();
        t = exit.t;
    }

    /// Visits the cell on the other side of the line along which the segment goes; the three others around the vertex over
    /// which it stands. They have the span on their border.
    template <class Visitor>
    bool visit_beside_line(const BasicCellSpan<F>& span, Visitor&& visitor) const noexcept {
        for (const auto [left, below] : {Cell{1, 1}, Cell{0, 1}, Cell{1, 0}}) {
            if ((left > 0 && !x.on_line) || (below > 0 && !y.on_line)) continue;
            BasicCellSpan<F> beside = span;
            beside.cell = {x.cell - left, y.cell - below};
            if (left > 0) beside.in.x = beside.out.x = 1;
            if (below > 0) beside.in.y = beside.out.y = 1;
            if (!visitor(beside)) return false;
        }
        return true;
    }

    /// Visits the two cells that the segment touches at the vertex over which it leaves the current one.
    template <class Visitor>
    bool visit_beside_vertex(const CellExit<F>& exit, Visitor&& visitor) const noexcept {
        for (const bool along_x : {true, false}) {
            const vec2<F> at{along_x ? exit.next_u() : exit.at.x, along_x ? exit.at.y : exit.next_v()};
            const Cell cell = along_x ? Cell{x.cell + x.step, y.cell} : Cell{x.cell, y.cell + y.step};
            if (!visitor(BasicCellSpan<F>{cell, exit.t, exit.t, at, at})) return false;
        }
        return true;
    }
};

} // namespace detail

template <Real F, class Visitor>
void walk_cells(const BasicLattice<F>& lattice, const CellRange& range, const vec2<F>& a, const vec2<F>& b,
                Visitor&& visit) noexcept {
    detail::CellWalk<F> walk{lattice, a, b};
    if (walk.enter(range)) walk.visit(range, range, visit);
}

template <HeightField Field, Real T, class Visitor>
void walk_candidates(const Field& field, const vec3<T>& a, const vec3<T>& b, Visitor&& visit) noexcept {
    using F = FrameScalar<Field>;
    const vec3<F> from = detail::widen_to<F>(a), to = detail::widen_to<F>(b);
    walk_cells<F>(
        field.lattice(), field.cells(), {from.x, from.y}, {to.x, to.y}, [&](const BasicCellSpan<F>& span) {
            const auto patch = field.patch(span.cell);
            if (!patch) return true;
            const F z_in = (1 - span.t_in) * from.z + span.t_in * to.z;
            const F z_out = (1 - span.t_out) * from.z + span.t_out * to.z;
            return glm::min(z_in, z_out) > detail::widen_to<F>(patch->highest()) || visit(span, *patch);
        });
}

} // namespace hfh

#endif // HFH_TRAVERSAL_CANDIDATE_WALKER_HPP
