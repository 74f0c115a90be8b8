#ifndef HFH_TRAVERSAL_FIRST_HIT_HPP
#define HFH_TRAVERSAL_FIRST_HIT_HPP

#include <hfh/geometry/surface_point.hpp>
#include <hfh/traversal/empty_space_skipping.hpp>

#include <cmath>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.1. The paper takes the first candidate patch as
// the place to start; here the first crossing itself is found, so that contact begins where the stylus met the
// surface (design: Figure 8 [P] is what happens otherwise).
//
// Along a segment u and v are linear in time, so the height of the stylus over one patch is one quadratic:
//
//     f(s) = z_stylus − z_surface = f₀ + (f₁ − f₀ − a) s + a s²,   a = −A Δu Δv,   0 ≤ s ≤ 1
//
// with A the twist of Eq. (2). f₀ and f₁ are heights at the cell's border, and border heights agree between
// neighbours; the side of the surface is handed from cell to cell, never decided twice. So a segment that begins
// above and ends below cannot slip through an edge or a vertex, whatever the rounding.

namespace hfh {

enum class HitStatus : unsigned char {
    hit,       ///< the segment crosses the surface at `t`
    miss,      ///< it does not
    cell_limit ///< neither up to `t`, where the allowed number of cells was used up
};

template <Real T>
struct FirstHit {
    HitStatus status = HitStatus::miss;
    double t = 1;            ///< how far along a → b: the crossing, or the end of what was searched
    SurfacePoint<T> point{}; ///< the crossing, if there is one
    Side side = Side::none; ///< hit: the side the segment came from; else: the side on which the search ended
    Index cells = 0;        ///< cells looked at; of a field with bounds, cells and blocks
};

struct FirstHitOptions {
    SurfaceKind surface = SurfaceKind::solid;
    /// The side on which the segment begins, if that is known from before; `none` to decide by a's height. A known
    /// side wins over the sign of a height that is zero but for rounding, or that an edit has changed.
    Side side = Side::none;
    /// ≥ 0: the segment leaves a surface on which a was computed to lie, to `side`, and this many metres are the rounding
    /// of a. As long as it is no farther off than that, nothing is a crossing, and a missing patch is no hole. If it ends on
    /// the other side without having left, it hits where it entered its last cell. An a that is farther off has left. < 0: no.
    double leaves_within = -1;
    /// The search stops before the next cell, but not before it has left a, where up to four cells meet, by a sixteenth
    /// of a cell: so that going on from `along(a, b, t)` with `side` gets on, and comes to the same end as one search.
    Index max_cells = std::numeric_limits<Index>::max();
};

/// The point of a → b at t, from which a search that was cut short goes on.
[[nodiscard]] inline glm::dvec3 along(const glm::dvec3& a, const glm::dvec3& b, double t) noexcept {
    return a + t * (b - a);
}

namespace detail {

/// Smallest s in [0, 1] after which f(s) = f0 + (f1 − f0 − a) s + a s² is negative, given f0 ≥ 0; > 1 if none.
/// A tangent that only touches is no crossing. Roots in the forms that do not cancel.
[[nodiscard]] inline double first_descent(double f0, double f1, double a) noexcept {
    constexpr double none = 2;
    const double b = f1 - f0 - a;
    const double discriminant = b * b - 4 * a * f0;
    if (f1 >= 0 && !(a > 0 && b < 0 && -b < 2 * a && discriminant > 0)) return none;
    const double root = std::sqrt(glm::max(discriminant, 0.0));
    const double s = b < 0 ? 2 * f0 / (root - b) : (b + root) / (-2 * a);
    return glm::clamp(s, 0.0, 1.0);
}

/// Looks at one cell after the other, exactly, and knows on which side of the surface the segment is.
template <HeightField Field>
struct Judge {
    using T = typename Field::Scalar;

    const Field& field;
    const glm::dvec3 &a, &b;
    const FirstHitOptions& options;
    FirstHit<T>& result;
    Side side = options.side;
    bool sheet = options.surface == SurfaceKind::sheet;
    bool leaving = options.leaves_within >= 0, under = false;
    double covered_to = 0; // up to here there was surface all along

    /// The side of what begins at t, if it is known.
    [[nodiscard]] Side side_at(double t) const noexcept { return t > covered_to ? Side::none : side; }
    /// The segment is on one side of everything up to t.
    void pass(double t, Side on) noexcept {
        side = on;
        covered_to = t;
    }

    /// Whether the point at t is off a by a sixteenth of a cell, and a place of its own however it is rounded. A piece of a
    /// search that ended nearer could begin again in the cell where this one began.
    [[nodiscard]] bool has_left(double t) const noexcept {
        const glm::dvec2 per_metre = field.lattice().cells_per_metre();
        const double x = t * (b.x - a.x), y = t * (b.y - a.y);
        const bool by_x = std::abs(x) * per_metre.x >= 0.0625 && a.x + x / 2 != a.x,
                   by_y = std::abs(y) * per_metre.y >= 0.0625 && a.y + y / 2 != a.y;
        return by_x || by_y;
    }

    /// The next cell of a walk; false if the search is over. Inlined, for a span that goes through memory costs 4 % of a
    /// cast.
    [[gnu::always_inline]] bool operator()(const CellSpan& span) noexcept {
        if (span.t_in > covered_to && !leaving) side = Side::none;
        // Along a grid line the cell before this one may have settled part of the span, or all of it.
        const double searched_to = glm::max(span.t_in, covered_to);
        if (result.cells >= options.max_cells && searched_to < 1 && has_left(searched_to)) {
            result.status = HitStatus::cell_limit;
            result.t = searched_to;
            return false;
        }
        ++result.cells;
        const auto found = field.patch(span.cell);
        if (!found) return true;
        const auto& p = *found;
        covered_to = glm::max(covered_to, span.t_out);

        const double z_in = (1 - span.t_in) * a.z + span.t_in * b.z;
        const double z_out = (1 - span.t_out) * a.z + span.t_out * b.z;
        if (side != Side::below && glm::min(z_in, z_out) > widen(p.highest())) {
            side = Side::above;
            leaving = false;
            return true;
        }
        if (side != Side::above && glm::max(z_in, z_out) < widen(p.lowest())) {
            side = Side::below;
            leaving = false;
            return true;
        }

        const BilinearPatch<double> patch{widen(p.p00), widen(p.p10), widen(p.p01), widen(p.p11)};
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
            const bool off = t == 0 && (side == Side::above ? f0 : -f0) > options.leaves_within;
            const double rise = f1 + patch.twist() * step.x * step.y; // f'(0) from f₀ = 0
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
            const double s = detail::first_descent(glm::max(sign * f0, 0.0), sign * f1, sign * bend);
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
    }

    /// The walk is over.
    void end() noexcept {
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
    }
};

/// How many columns and rows of cells the segment is long.
[[nodiscard]] inline glm::dvec2 length_in_cells(const Lattice& lattice, const glm::dvec3& a,
                                                const glm::dvec3& b) noexcept {
    const glm::dvec2 per_metre = lattice.cells_per_metre();
    return {std::abs((b.x - a.x) * per_metre.x), std::abs((b.y - a.y) * per_metre.y)};
}

/// How many cells there are around the segment, if they are no more than two by two, each has a patch and all of these
/// lie below it; else 0. Nine updates in ten of a stylus in free flight end here, and need no exact numbers of cells:
/// these are widened by more than the rounding of the exact walk.
template <HeightField Field>
[[nodiscard, gnu::always_inline]] inline Index passes_over(const Field& field, const glm::dvec3& a,
                                                           const glm::dvec3& b) noexcept {
    const Lattice& lattice = field.lattice();
    const glm::dvec2 origin = lattice.origin(), per_metre = lattice.cells_per_metre();
    const double ax = (a.x - origin.x) * per_metre.x, ay = (a.y - origin.y) * per_metre.y,
                 bx = (b.x - origin.x) * per_metre.x, by = (b.y - origin.y) * per_metre.y;
    const double blur_x = 8 * epsilon<double> * (std::abs(ax) + std::abs(bx)),
                 blur_y = 8 * epsilon<double> * (std::abs(ay) + std::abs(by));
    const auto cell = [](double x, double y) {
        return Cell{static_cast<Index>(std::floor(x)), static_cast<Index>(std::floor(y))};
    };
    const Cell from = cell(glm::min(ax, bx) - blur_x, glm::min(ay, by) - blur_y),
               to = cell(glm::max(ax, bx) + blur_x, glm::max(ay, by) + blur_y);
    const Index columns = 1 + to.i - from.i, rows = 1 + to.j - from.j;
    if (columns > 2 || rows > 2) return 0;
    // Clear of rounding in the exact walk, which is a few ulps; and rounding to T keeps the order.
    const auto lowest = static_cast<typename Field::Scalar>(
        glm::min(a.z, b.z) - 32 * epsilon<double> * (std::abs(a.z) + std::abs(b.z)));
    const auto below = [lowest](const auto& patch) { return patch && patch->highest() < lowest; };
    // One cell or two: a processor that is asked to guess which is wrong too often. To look at one twice costs less.
    if (!below(field.patch(from)) || !below(field.patch(to))) return 0;
    if (columns + rows == 4 && !(below(field.patch({to.i, from.j})) && below(field.patch({from.i, to.j})))) {
        return 0;
    }
    return columns * rows;
}

/// Judges what is not passed over, in columns across the longer axis.
template <bool along_x, HeightField Field>
void judge_columns(const Field& field, const CellRange& range, CellWalk& walk, Judge<Field>& judge) noexcept {
    if (!walk.enter(range)) return;
    AxisWalk &along = along_x ? walk.x : walk.y, &across = along_x ? walk.y : walk.x;
    const Profile profile{along, across, judge.a.z, judge.b.z};
    // Along is i, across is j.
    const CellRange turned =
        along_x ? range : CellRange{{range.begin.j, range.begin.i}, {range.end.j, range.end.i}};
    const Index end = profile.column_of(along.last) + 1;
    const Index stop = profile.column_of(glm::clamp(along.last, turned.begin.i, turned.end.i - 1)) + 1;
    Stretches<along_x, Field> stretches{field, profile};
    const auto columns = [&](Index from, Index to) {
        const Index a = profile.cell_along(from), b = profile.cell_along(to - 1);
        const Index low = glm::min(a, b), past = glm::max(a, b) + 1;
        return along_x ? CellRange{{low, range.begin.j}, {past, range.end.j}}
                       : CellRange{{range.begin.i, low}, {range.end.i, past}};
    };
    // Behind a column that is not clear the next ones mostly are not: with 3 long casts take 1 to 3 % less than with 1.
    constexpr Index few = 3;
    for (Index block = few;; block *= 2) { // where nothing is clear for long, do not ask at every column
        const Index here = profile.column_of(along.cell);
        Index from = here;
        if (profile.usable() && !judge.leaving && turned.begin.i <= along.cell && along.cell < turned.end.i) {
            const Stretch clear = stretches.next(
                here, stop - here, judge.options.max_cells - judge.result.cells, judge.side_at(walk.t));
            judge.result.cells += clear.looked_at;
            if (clear.columns > 0) {
                from += clear.columns;
                const double t = from == end ? 1 : along.time_at(profile.grid_line(from));
                judge.pass(t, clear.side);
                if (from == stop) return;
                along.enter(profile.cell_along(from));
                across.skip_to(t, turned.begin.j, turned.end.j);
                walk.enter_at(t);
                block = few;
            }
        }
        const Index past = glm::min(from + block, stop);
        if (!walk.visit(range, columns(from, past), judge)) return;
    }
}

template <HeightField Field>
void search(const Field& field, const glm::dvec3& a, const glm::dvec3& b, const FirstHitOptions& options,
            FirstHit<typename Field::Scalar>& result) noexcept {
    Judge<Field> judge{field, a, b, options, result};
    const SplitEnds ends{field.lattice(), {a.x, a.y}, {b.x, b.y}};
    CellWalk walk{field.lattice(), ends, {b.x - a.x, b.y - a.y}};
    const CellRange range = field.cells();
    const glm::dvec2 length = length_in_cells(field.lattice(), a, b);
    if (glm::max(length.x, length.y) < 2) {
        if (walk.enter(range)) walk.visit(range, range, judge);
    } else if (length.x >= length.y) {
        judge_columns<true>(field, range, walk, judge);
    } else {
        judge_columns<false>(field, range, walk, judge);
    }
    judge.end();
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
/// Of a `BoundedHeightField` whole blocks are skipped that lie below the segment or above it: a few looks where there is
/// room, for a segment of any length. The answer is the same to the bit.
///
/// Precondition: a, b finite and within reach of the lattice. Does not allocate; O(cells passed) ≤ max(max_cells, 4) + 3.
template <HeightField Field>
[[nodiscard]] FirstHit<typename Field::Scalar> first_hit(const Field& field, const glm::dvec3& a,
                                                         const glm::dvec3& b,
                                                         const FirstHitOptions& options = {}) noexcept {
    FirstHit<typename Field::Scalar> result;
    // A segment of two cells or more is never in two by two: not to ask saves a cast of 3 or 300 cells 4 %.
    const glm::dvec2 length = detail::length_in_cells(field.lattice(), a, b);
    if (glm::max(length.x, length.y) < 2 && options.side != Side::below && options.max_cells >= 4) {
        result.cells = detail::passes_over(field, a, b);
        if (result.cells > 0) {
            result.side = Side::above;
            return result;
        }
    }
    detail::search(field, a, b, options, result);
    return result;
}

} // namespace hfh

#endif // HFH_TRAVERSAL_FIRST_HIT_HPP
