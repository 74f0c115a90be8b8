#ifndef HFH_TRAVERSAL_FIRST_HIT_HPP
#define HFH_TRAVERSAL_FIRST_HIT_HPP

#include <hfh/geometry/surface_point.hpp>
#include <hfh/traversal/cell_crossing.hpp>
#include <hfh/traversal/empty_space_skipping.hpp>

#include <cmath>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.1. The paper takes the first candidate patch as
// the place to start; here the first crossing itself is found, so that contact begins where the stylus met the
// surface (Figure 8 [P] shows what happens otherwise).
//
// The side of the surface on which the segment is goes from cell to cell and is never decided twice. So a segment that
// begins above and ends below cannot slip through an edge or a vertex, whatever the rounding.

namespace hfh {

enum class HitStatus : unsigned char {
    hit,       ///< the segment crosses the surface at `t`
    miss,      ///< it does not
    cell_limit ///< neither up to `t`, where the allowed number of cells was used up
};

[[nodiscard]] constexpr const char* to_string(HitStatus status) noexcept {
    switch (status) {
    case HitStatus::hit: return "hit";
    case HitStatus::miss: return "miss";
    case HitStatus::cell_limit: return "cell_limit";
    }
    return "unknown";
}

/// F is what the lattice of the field computes in.
template <Real T, Real F = double>
struct FirstHit {
    HitStatus status = HitStatus::miss;
    F t = 1;                 ///< how far along a → b: the crossing, or the end of what was searched
    SurfacePoint<T> point{}; ///< the crossing, if there is one
    Side side = Side::none; ///< hit: the side the segment came from; else: the side on which the search ended
    Index cells = 0;        ///< cells looked at; of a field with bounds, cells and blocks
    /// cell_limit: by `leaves_within`, the segment has not got off the surface on which a lies.
    bool leaving = false;
};

template <Real F>
struct BasicFirstHitOptions {
    SurfaceKind surface = SurfaceKind::solid;
    /// The side on which the segment begins, if that is known from before; `none` to decide by a's height. A known
    /// side wins over the sign of a height that is zero but for rounding, or that an edit has changed.
    Side side = Side::none;
    /// ≥ 0: the segment leaves a surface on which a was computed to lie, to `side`, and this many metres are the rounding
    /// of a.z (that of a.x and a.y is added to it). As long as it is no farther off than that, nothing is a crossing, and
    /// where patches are missing for less than a sixteenth of a cell there is no hole; where a cell begins or ends with the
    /// segment farther off, it has left. Where the segment comes to be farther off on the other side, or ends there without
    /// having left, it hits where it entered the last cell. < 0: no.
    F leaves_within = -1;
    /// The search stops before the next cell, but not before it has got on by a sixteenth of a cell from where it began,
    /// where up to four cells meet, and not between cells into which the segment comes at the same t.
    Index max_cells = std::numeric_limits<Index>::max();
    /// Where on a → b, from 0 to 1, the search begins: the `t` of a search of the same segment that was cut short. With
    /// the `side` of its result, and `leaves_within` if that was still `leaving`, it comes to the end of one search, to
    /// the bit.
    F begin_at = 0;
};
using FirstHitOptions = BasicFirstHitOptions<double>;

/// The point of a → b at t: from there a search that was cut short goes on to another end. It is rounded, so a search to
/// the same end goes on with `begin_at` instead.
template <Real F>
[[nodiscard]] inline vec3<F> point_on_segment(const vec3<F>& a, const vec3<F>& b, F t) noexcept {
    return a + t * (b - a);
}

/// What a cast on such a field finds.
template <HeightField Field>
using HitOn = FirstHit<typename Field::Scalar, FrameScalar<Field>>;

/// The first crossing of the segment a → b with the surface.
///
/// Solid: the first point after which the segment is below, having been above. A segment that begins below must
/// come out first. Sheet: the first point at which it changes sides. Each patch is exact (one quadratic); the traversal
/// and the quadratics are computed in what the lattice computes in: in double, but for a `FloatLattice`. Where there is no patch there is no side: behind
/// a hole, or on entering from outside, the side is decided afresh. A segment that begins on a solid's surface and
/// goes down hits at t = 0; one that begins on a sheet is on the side to which it goes.
///
/// What lies far below the segment is passed over without a crossing test (`empty_space_skipping.hpp`); of a
/// `BoundedHeightField` whole blocks of it, and of what lies far above. The answer is the same to the bit.
///
/// Precondition: a, b finite and within reach of the lattice. Does not allocate; O(cells passed) ≤ max(max_cells, 4) + 3.
template <HeightField Field>
[[nodiscard]] HitOn<Field> first_hit(const Field& field, const vec3<FrameScalar<Field>>& a,
                                     const vec3<FrameScalar<Field>>& b,
                                     const BasicFirstHitOptions<FrameScalar<Field>>& options = {}) noexcept;

namespace detail {

/// The crossing test of a segment a → b: looks at one cell after the other in the order of the segment, and keeps the side
/// of the surface on which the segment is. Writes what it finds into `result`.
template <HeightField Field>
struct CrossingTest {
    using T = typename Field::Scalar;
    using F = FrameScalar<Field>;

    const Field& field;
    const vec3<F>&a, &b;
    const BasicFirstHitOptions<F>& options;
    FirstHit<T, F>& result;
    Side side = options.side;
    bool sheet = options.surface == SurfaceKind::sheet;
    bool leaving = options.leaves_within >= 0; ///< the segment has not got off the surface on which a lies
    bool under = false; ///< leaving: the segment leaves the last cell on the other side of the surface
    F covered_to = options.begin_at; ///< up to this t there were patches all along
    F last_begin =
        options.begin_at; ///< the t at which the segment comes into the last cell that was looked at

    /// Tests the next cell; false if the search is over. Inlined, so that the span does not go through memory.
    [[HFH_ALWAYS_INLINED]] bool operator()(const BasicCellSpan<F>& span) noexcept {
        if (span.t_in > covered_to && (!leaving || is_apart(covered_to, span.t_in))) { // behind a hole
            side = Side::none;
            leaving = false;
        }
        if (out_of_cells(span.t_in)) return false;
        last_begin = span.t_in;
        ++result.cells;
        const auto found = field.patch(span.cell);
        if (!found) return true;
        const auto& p = *found;
        covered_to = glm::max(covered_to, span.t_out);

        const F z_in = (1 - span.t_in) * a.z + span.t_in * b.z;
        const F z_out = (1 - span.t_out) * a.z + span.t_out * b.z;
        if (!leaving) {
            if (side != Side::below && glm::min(z_in, z_out) > widen_to<F>(p.highest()))
                return stays_on(Side::above);
            if (side != Side::above && glm::max(z_in, z_out) < widen_to<F>(p.lowest()))
                return stays_on(Side::below);
        }

        SegmentOverPatch<F> over{
            {widen_to<F>(p.p00), widen_to<F>(p.p10), widen_to<F>(p.p01), widen_to<F>(p.p11)},
            span,
            z_in,
            z_out};
        if (side == Side::none) {
            side = sheet ? over.side_of_sheet() : over.side_of_solid();
            if (side == Side::none) return true; // along the sheet: nothing to cross
        }
        if (leaving && stays_on_surface(over, span.cell)) return result.status == HitStatus::miss;
        return !crosses(over, span.cell);
    }

    /// Whether cells may be passed over that lie on one side of the segment.
    [[nodiscard]] bool may_skip() const noexcept { return !leaving; }
    [[nodiscard]] Index cells_left() const noexcept { return options.max_cells - result.cells; }
    /// The side of what begins at t, if it is known.
    [[nodiscard]] Side side_at(F t) const noexcept { return t > covered_to ? Side::none : side; }
    /// So many cells were looked at.
    void count(Index cells) noexcept { result.cells += cells; }
    /// Up to t there are patches all along, and the segment is on this side of them.
    void pass(F t, Side on) noexcept {
        side = on;
        covered_to = t;
    }

    /// To be called once, after the last cell: completes the result.
    void finish() noexcept {
        if (leaving && under && covered_to == 1 && result.status == HitStatus::miss) {
            // It did not get off the surface and ends below: it met the next face within the rounding of a.
            result.status = HitStatus::hit;
        }
        if (result.status == HitStatus::miss) {
            result.t = 1;
            result.point = {};
            if (covered_to < 1) {
                side = Side::none;
            } else if (side == Side::none) {
                side = Side::above; // along a sheet from a to b
            }
        }
        result.side = side;
        result.leaving = leaving;
    }

private:
    /// Whether the search has to stop at t, for it has looked at as many cells as it may. Not between two cells at the same
    /// t: it would go on with the first of them again, knowing what it learned in it. Nor within a gap of the surface that
    /// may be no hole.
    [[nodiscard]] bool out_of_cells(F t) noexcept {
        if (result.cells < options.max_cells || t >= 1 || t <= last_begin || (leaving && t > covered_to) ||
            !is_apart(options.begin_at, t)) {
            return false;
        }
        result.status = HitStatus::cell_limit;
        result.t = t;
        return true;
    }
    /// Whether two points of the segment are apart by a sixteenth of a cell, and two places however they are rounded. A piece
    /// of a search that ended nearer to its begin could begin again in the same cell.
    [[nodiscard]] bool is_apart(F from, F to) const noexcept {
        const vec2<F> per_metre = field.lattice().cells_per_metre();
        const vec3<F> begin = point_on_segment(a, b, from);
        const F x = (to - from) * (b.x - a.x), y = (to - from) * (b.y - a.y);
        const bool by_x = std::abs(x) * per_metre.x >= F(0.0625) && begin.x + x / 2 != begin.x,
                   by_y = std::abs(y) * per_metre.y >= F(0.0625) && begin.y + y / 2 != begin.y;
        return by_x || by_y;
    }

    /// The segment is on this side of the whole patch: on to the next cell.
    bool stays_on(Side on) noexcept {
        side = on;
        return true;
    }

    /// How many metres of height over this patch the rounding of a.x and a.y makes. Beside a grid line it can put a on the
    /// patch next to the one it lies on, and that may be far steeper.
    [[nodiscard]] F rounding_in_plan(const BilinearPatch<F>& p) const noexcept {
        const vec2<F> per_metre = field.lattice().cells_per_metre();
        const F rise_u = glm::max(std::abs(p.p10 - p.p00), std::abs(p.p11 - p.p01)),
                rise_v = glm::max(std::abs(p.p01 - p.p00), std::abs(p.p11 - p.p10));
        return epsilon<F> * (std::abs(a.x) * per_metre.x * rise_u + std::abs(a.y) * per_metre.y * rise_v);
    }

    /// While the segment leaves the surface: whether it is still on it, but for the rounding of a.
    [[nodiscard]] bool stays_on_surface(SegmentOverPatch<F>& over, const Cell& cell) noexcept {
        const F sign = sign_of<F>(side), rounding = options.leaves_within + rounding_in_plan(over.patch);
        const bool off = sign * over.f_in > rounding,
                   went_under = sign * over.f_out < glm::min(sign * over.f_in, -rounding);
        if (!off) {
            over.f_in = 0;
            const F rise = over.f_out - over.quadratic(); // f'(0) from f₀ = 0
            if (sign * rise <= rounding) {
                leaving = sign * over.f_out <= rounding;
                under = sign * over.f_out < 0;
                result.t = over.t_in;
                result.point = {cell, static_cast<T>(over.in.x), static_cast<T>(over.in.y)};
                if (went_under) result.status = HitStatus::hit;
                return true;
            }
        }
        leaving = false;
        return false;
    }

    /// Whether the segment hits the patch. One that comes out of a solid may go back in before the cell ends.
    [[nodiscard]] bool crosses(SegmentOverPatch<F>& over, const Cell& cell) noexcept {
        // Ends: the second crossing at the latest is one from above.
        while (over.go_to_crossing(side)) {
            if (sheet || side == Side::above) {
                result.status = HitStatus::hit;
                result.t = over.t_in;
                result.point = {cell, static_cast<T>(over.in.x), static_cast<T>(over.in.y)};
                return true;
            }
            side = Side::above;
        }
        return false;
    }
};

/// `first_hit` without its quick look at a short segment, for a caller that has done this or expects something in the way.
template <HeightField Field>
[[nodiscard]] HitOn<Field> cast(const Field& field, const vec3<FrameScalar<Field>>& a,
                                const vec3<FrameScalar<Field>>& b,
                                const BasicFirstHitOptions<FrameScalar<Field>>& options) noexcept {
    using F = FrameScalar<Field>;
    HitOn<Field> result;
    CrossingTest<Field> test{field, a, b, options, result};
    CellWalk<F> walk{field.lattice(), {a.x, a.y}, {b.x, b.y}};
    const CellRange range = field.cells();
    const vec2<F> length = length_in_cells<F>(field.lattice(), a, b);
    // What skipping takes is half of a cast's code.
    if (small_code || glm::max(length.x, length.y) < 2) {
        if (walk.enter(range, options.begin_at)) walk.visit(range, range, test);
    } else if (length.x >= length.y) {
        walk_with_skipping<true>(field, range, walk, options.begin_at, a.z, b.z, test);
    } else {
        walk_with_skipping<false>(field, range, walk, options.begin_at, a.z, b.z, test);
    }
    test.finish();
    return result;
}

} // namespace detail

template <HeightField Field>
HitOn<Field> first_hit(const Field& field, const vec3<FrameScalar<Field>>& a,
                       const vec3<FrameScalar<Field>>& b,
                       const BasicFirstHitOptions<FrameScalar<Field>>& options) noexcept {
    using F = FrameScalar<Field>;
    // A segment of two cells or more is seldom in two by two: it does not ask.
    const vec2<F> length = detail::length_in_cells<F>(field.lattice(), a, b);
    if (glm::max(length.x, length.y) < 2 && options.side != Side::below && options.max_cells >= 4 &&
        options.begin_at == 0) {
        const Index cells = detail::cells_below_short_segment(field, a, b);
        if (cells > 0) return {.side = Side::above, .cells = cells};
    }
    return detail::cast(field, a, b, options);
}

} // namespace hfh

#endif // HFH_TRAVERSAL_FIRST_HIT_HPP
