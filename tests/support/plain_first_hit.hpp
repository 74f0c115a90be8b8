#ifndef HFH_TESTS_SUPPORT_PLAIN_FIRST_HIT_HPP
#define HFH_TESTS_SUPPORT_PLAIN_FIRST_HIT_HPP

#include <hfh/traversal/first_hit.hpp>

// first_hit without any haste: the exact walk over every cell under the segment, as the library had it before it learnt
// to skip what is clear. Answers of the library are compared with its answers to the bit.

namespace hfh::test::plain {

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
    double spacing, per_metre;
    double a, d;       ///< start and displacement, in metres from line `base`
    double start, end; ///< a and b in cells from lines `first` and `last`
    bool on_line;      ///< the whole segment lies on the line between `cell − 1` and `cell`
    Index end_line;    ///< the grid line that b is on, if any

    AxisWalk(double from, double to, double origin, double dx, double cells_per_metre) noexcept
        : spacing{dx}, per_metre{cells_per_metre} {
        const Split begin = split(from, origin, dx, per_metre), goal = split(to, origin, dx, per_metre);
        base = cell = begin.cell;
        last = goal.cell;
        a = begin.rest;
        start = in_cells(begin.rest);
        end = in_cells(goal.rest);
        d = to - from;
        step = d > 0 ? 1 : d < 0 ? -1 : 0;
        on_line = step == 0 && a == 0;
        end_line = goal.rest == 0 ? goal.cell : std::numeric_limits<Index>::max();
        // Cells are closed: a segment that leaves a line touches the cell behind it, and one that ends on a line
        // touches the cell beyond it.
        if (step > 0 && a == 0) --cell, start = 1;
        if (step < 0 && goal.rest == 0) --last, end = 1;
        if ((last - cell) * step <= 0) last = cell;
        first = cell;
    }

    /// A length within a cell, in cells.
    [[nodiscard]] double in_cells(double metres) const noexcept {
        return std::clamp(metres * per_metre, 0.0, 1.0);
    }
    /// When the segment is on grid line i. Precondition: step ≠ 0.
    [[nodiscard]] double time_at(Index i) const noexcept {
        if (i == end_line) return 1; // to the bit, also where a and d are rounded
        return std::clamp((static_cast<double>(i - base) * spacing - a) / d, 0.0, 1.0);
    }
    /// When the segment enters the next cell.
    [[nodiscard]] double next() const noexcept {
        return cell == last ? never : time_at(step > 0 ? cell + 1 : cell);
    }
    /// Position at t in the current cell.
    [[nodiscard]] double at(double t) const noexcept {
        if (t == 0 && cell == first) return start;
        if (t == 1 && cell == last) return end;
        return in_cells((a - static_cast<double>(cell - base) * spacing) + t * d);
    }
    /// Position at t, where the walk begins in the current cell: to the bit on a line that is met at t.
    [[nodiscard]] double entry(double t) const noexcept {
        if (cell != first && time_at(step > 0 ? cell : cell + 1) >= t) return 1 - leaving();
        return next() <= t ? leaving() : at(t);
    }
    /// The line on which the current cell is left (1 or 0).
    [[nodiscard]] double leaving() const noexcept { return step > 0 ? 1 : 0; }

    /// When the segment enters and leaves the cells from ≤ i < past; later than `never` if it does not.
    [[nodiscard]] bool clip(Index from, Index past, double& t_enter, double& t_leave) const noexcept {
        if (step == 0) return (from <= cell && cell < past) || (on_line && cell == past);
        const Index lowest = std::min(cell, last), highest = std::max(cell, last);
        if (highest < from || lowest >= past) return false;
        const Index in = step > 0 ? from : past - 1;
        const Index out = step > 0 ? past - 1 : from;
        if ((in - cell) * step > 0) t_enter = std::max(t_enter, time_at(step > 0 ? from : past));
        if ((last - out) * step > 0) t_leave = std::min(t_leave, time_at(step > 0 ? past : from));
        return true;
    }
    /// Goes to the earliest cell of from ≤ i < past that holds the position at t.
    void skip_to(double t, Index from, Index past) noexcept {
        if (step == 0) return;
        const auto near = base + static_cast<Index>(std::floor((a + t * d) * per_metre));
        Index there = std::clamp(near - step, std::min(cell, last), std::max(cell, last));
        there = std::clamp(there, from, past - 1);
        const Index stop = std::clamp(last, from, past - 1);
        while (there != stop && time_at(step > 0 ? there + 1 : there) < t) there += step;
        cell = there;
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
    const glm::dvec2 origin = lattice.origin(), spacing = lattice.spacing(),
                     per_metre = lattice.cells_per_metre();
    detail::AxisWalk x{a.x, b.x, origin.x, spacing.x, per_metre.x};
    detail::AxisWalk y{a.y, b.y, origin.y, spacing.y, per_metre.y};

    double t = 0, t_leave = 1;
    if (range.empty() || !x.clip(range.begin.i, range.end.i, t, t_leave) ||
        !y.clip(range.begin.j, range.end.j, t, t_leave) || t > t_leave) {
        return;
    }
    if (t > 0) {
        x.skip_to(t, range.begin.i, range.end.i);
        y.skip_to(t, range.begin.j, range.end.j);
    }

    const auto visit_one = [&](const CellSpan& span) { return !range.contains(span.cell) || visit(span); };
    // Two cells side by side share a segment that runs along the line between them.
    const auto visit_row = [&](CellSpan span) {
        if (x.on_line) {
            CellSpan left = span;
            --left.cell.i;
            left.in.x = left.out.x = 1;
            if (!visit_one(left)) return false;
        }
        return visit_one(span);
    };
    const auto visit_all = [&](const CellSpan& span) {
        if (y.on_line) {
            CellSpan below = span;
            --below.cell.j;
            below.in.y = below.out.y = 1;
            if (!visit_row(below)) return false;
        }
        return visit_row(span);
    };

    glm::dvec2 in{x.entry(t), y.entry(t)};
    double next_x = x.next(), next_y = y.next();
    for (;;) {
        const double t_out = std::max(t, std::min(std::min(next_x, next_y), 1.0));
        const bool cross_x = next_x <= next_y && next_x <= 1, cross_y = next_y <= next_x && next_y <= 1;
        const glm::dvec2 there = t_out == t ? in : glm::dvec2{x.at(t_out), y.at(t_out)};
        const glm::dvec2 out{cross_x ? x.leaving() : there.x, cross_y ? y.leaving() : there.y};
        if (!visit_all({{x.cell, y.cell}, t, t_out, in, out})) return;
        if (!cross_x && !cross_y) return;

        in = out;
        if (cross_x) in.x = 1 - out.x;
        if (cross_y) in.y = 1 - out.y;
        if (cross_x && cross_y) { // through a vertex: it touches the two cells beside the diagonal
            const glm::dvec2 beside_x{in.x, out.y}, beside_y{out.x, in.y};
            if (!visit_one({{x.cell + x.step, y.cell}, t_out, t_out, beside_x, beside_x})) return;
            if (!visit_one({{x.cell, y.cell + y.step}, t_out, t_out, beside_y, beside_y})) return;
        }
        if (cross_x) x.cell += x.step, next_x = x.next();
        if (cross_y) y.cell += y.step, next_y = y.next();
        t = t_out;
        const bool inside_x = (range.begin.i <= x.cell && x.cell < range.end.i) || x.on_line;
        const bool inside_y = (range.begin.j <= y.cell && y.cell < range.end.j) || y.on_line;
        if (!inside_x || !inside_y) return;
    }
}

namespace detail {

/// Smallest s in [0, 1] after which f(s) = f0 + (f1 − f0 − a) s + a s² is negative, given f0 ≥ 0; > 1 if none.
/// A tangent that only touches is no crossing. Roots in the forms that do not cancel.
[[nodiscard]] inline double first_descent(double f0, double f1, double a) noexcept {
    constexpr double none = 2;
    const double b = f1 - f0 - a;
    const double discriminant = b * b - 4 * a * f0;
    if (f1 >= 0 && !(a > 0 && b < 0 && -b < 2 * a && discriminant > 0)) return none;
    const double root = std::sqrt(std::max(discriminant, 0.0));
    const double s = b < 0 ? 2 * f0 / (root - b) : (b + root) / (-2 * a);
    return std::clamp(s, 0.0, 1.0);
}

} // namespace detail

/// The first crossing of the segment a → b with the surface.
///
/// Solid: the first point after which the segment is below, having been above. A segment that begins below must
/// come out first. Sheet: the first point at which it changes sides. Each patch is exact (one quadratic); the walk
/// and the quadratics are computed in double for either scalar. Where there is no patch there is no side: behind
/// a hole, or on entering from outside, the side is decided afresh. A segment that begins on a solid's surface and
/// goes down hits at t = 0; one that begins on a sheet is on the side to which it goes.
///
/// Precondition: a, b finite and within reach of the lattice. Does not allocate; O(cells passed) ≤ max(max_cells, 4).
template <HeightField Field>
[[nodiscard]] FirstHit<typename Field::Scalar> first_hit(const Field& field, const glm::dvec3& a,
                                                         const glm::dvec3& b,
                                                         const FirstHitOptions& options = {}) noexcept {
    using T = typename Field::Scalar;
    FirstHit<T> result;
    const bool sheet = options.surface == SurfaceKind::sheet;
    Side side = options.side;
    bool leaving = options.leaves_within >= 0, under = false;
    double covered_to = 0; // up to here there was surface all along

    plain::walk_cells(field.lattice(), field.cells(), {a.x, a.y}, {b.x, b.y}, [&](const CellSpan& span) {
        if (span.t_in > covered_to && !leaving) side = Side::none;
        // Along a grid line the cell before this one may have settled part of the span, or all of it.
        const double searched_to = std::max(span.t_in, covered_to);
        if (result.cells >= options.max_cells && 0 < searched_to && searched_to < 1) {
            result.status = HitStatus::cell_limit;
            result.t = searched_to;
            return false;
        }
        ++result.cells;
        const auto found = field.patch(span.cell);
        if (!found) return true;
        const auto& p = *found;
        covered_to = std::max(covered_to, span.t_out);

        const double z_in = (1 - span.t_in) * a.z + span.t_in * b.z;
        const double z_out = (1 - span.t_out) * a.z + span.t_out * b.z;
        if (side != Side::below && std::min(z_in, z_out) > static_cast<double>(p.highest())) {
            side = Side::above;
            leaving = false;
            return true;
        }
        if (side != Side::above && std::max(z_in, z_out) < static_cast<double>(p.lowest())) {
            side = Side::below;
            leaving = false;
            return true;
        }

        const BilinearPatch<double> patch{static_cast<double>(p.p00), static_cast<double>(p.p10),
                                          static_cast<double>(p.p01), static_cast<double>(p.p11)};
        glm::dvec2 from = span.in;
        double t = span.t_in;
        double f0 = z_in - patch.height(from.x, from.y);
        const double f1 = z_out - patch.height(span.out.x, span.out.y);
        if (side == Side::none) {
            double way = f0;
            if (sheet && f0 == 0) { // on the sheet: where it goes from there
                const glm::dvec2 step = span.out - span.in;
                const double bend = -patch.twist() * step.x * step.y;
                way = f1 != bend ? f1 - bend : bend;
                if (way == 0) return true; // along the sheet, or over this cell at one point only
            }
            side = way >= 0 ? Side::above : Side::below;
        }

        if (leaving) {
            const glm::dvec2 step = span.out - span.in;
            const double rise = f1 + patch.twist() * step.x * step.y; // f'(0) from f₀ = 0
            const bool off = t == 0 && (side == Side::above ? f0 : -f0) > options.leaves_within;
            if (!off) f0 = 0;
            if (!off && (side == Side::above ? rise : -rise) <= options.leaves_within) {
                under = side == Side::above ? f1 < 0 : f1 > 0;
                result.t = span.t_in;
                result.point = {span.cell, static_cast<T>(span.in.x), static_cast<T>(span.in.y)};
                return true;
            }
            leaving = false;
        }

        for (;;) {
            const double sign = side == Side::above ? 1 : -1;
            const glm::dvec2 step = span.out - from;
            const double bend = -patch.twist() * step.x * step.y;
            const double s = detail::first_descent(std::max(sign * f0, 0.0), sign * f1, sign * bend);
            if (s > 1) return true;
            from += s * step;
            t += s * (span.t_out - t);
            if (sheet || side == Side::above) {
                result.status = HitStatus::hit;
                result.t = t;
                result.point = {span.cell, static_cast<T>(from.x), static_cast<T>(from.y)};
                return false;
            }
            side = Side::above; // came out of the solid; it may go back in before the cell ends
            f0 = 0;
        }
    });
    if (leaving && result.status == HitStatus::miss) {
        // It did not get off the surface: if it ends below, it met the next face within the rounding of a.
        if (under && covered_to == 1) {
            result.status = HitStatus::hit;
        } else {
            result.t = 1;
        }
    }
    if (result.status == HitStatus::miss) {
        if (covered_to < 1) {
            side = Side::none;
        } else if (side == Side::none) {
            side = Side::above; // along a sheet from a to b
        }
    }
    result.side = side;
    return result;
}

} // namespace hfh::test::plain

#endif // HFH_TESTS_SUPPORT_PLAIN_FIRST_HIT_HPP
