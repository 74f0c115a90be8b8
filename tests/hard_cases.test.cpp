#include "support/hard_cases.hpp"
#include "catch.hpp"
#include "support/brute_force_hit.hpp"
#include "support/hard_patches.hpp"
#include "support/witness.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/geometry/closest_point.hpp>
#include <hfh/geometry/global_closest_point.hpp>
#include <hfh/traversal/candidate_walker.hpp>
#include <hfh/traversal/descent.hpp>
#include <hfh/traversal/first_hit.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

using namespace hfh;
using namespace hfh::test;

// Every hard case through every algorithm, judged by the oracles. A failure names its case.

namespace {

/// Of what the lattice computes in.
template <Real T>
constexpr Wide eps_place = static_cast<Wide>(epsilon<PlaceScalar<T>>);
constexpr int plenty = 1 << 20; // patches: no limit for these terrains

template <Real T, class Each>
void each_case(Each&& each) {
    static const auto cases = hard_cases<T>();
    for (const auto& c : cases) {
        DYNAMIC_SECTION(c.name) {
            INFO(c.why);
            each(c);
        }
    }
}

/// At most `most` of the path's positions, spread evenly, the last one among them.
template <Real T>
std::vector<vec3<T>> some_of(const std::vector<vec3<T>>& path, std::size_t most) {
    const std::size_t stride = path.size() / most + 1;
    std::vector<vec3<T>> some;
    for (std::size_t n = (path.size() - 1) % stride; n < path.size(); n += stride) some.push_back(path[n]);
    return some;
}

struct Segment {
    glm::dvec3 a, b;
};

/// The path's segments, of one step and of several, and each the other way round.
template <Real T>
std::vector<Segment> segments(const HardCase<T>& c) {
    std::vector<Segment> all;
    for (const std::size_t leap : {1u, 2u, 7u}) {
        for (std::size_t n = leap; n < c.path.size(); n += leap) {
            const glm::dvec3 a{c.path[n - leap]}, b{c.path[n]};
            all.push_back({a, b});
            all.push_back({b, a});
        }
    }
    return all;
}

/// A segment in metres from the grid's origin, without rounding, and how much the lattice may lose of it.
struct Projection {
    Wide ax, ay, bx, by, dx, dy;
    Wide blur;  ///< metres: the rounding of ends and of lines
    bool exact; ///< all numbers are so short that a double loses nothing

    template <Real T>
    Projection(const Terrain<T>& terrain, const Segment& s)
        : ax{of(s.a.x, terrain.frame.origin.x)}, ay{of(s.a.y, terrain.frame.origin.y)},
          bx{of(s.b.x, terrain.frame.origin.x)}, by{of(s.b.y, terrain.frame.origin.y)},
          dx{static_cast<Wide>(terrain.frame.spacing.x)}, dy{static_cast<Wide>(terrain.frame.spacing.y)} {
        const Wide extent =
            std::max({std::abs(ax), std::abs(ay), std::abs(bx), std::abs(by),
                      dx * static_cast<Wide>(terrain.columns), dy * static_cast<Wide>(terrain.rows)});
        blur = 16 * eps_place<T> * extent;
        exact = std::is_same_v<PlaceScalar<T>, double>;
        for (const Wide x : {ax, ay, bx, by, dx, dy})
            exact = exact && std::abs(x) < 0x1p20L && x * 1024 == std::floor(x * 1024);
    }
    [[nodiscard]] Wide length() const { return std::hypot(bx - ax, by - ay); }

    /// How far apart the segment and the closed cell are along the axis that parts them most; not positive: they meet.
    /// Of the sign alone if exact.
    [[nodiscard]] Wide gap(Cell c) const {
        const Wide x0 = static_cast<Wide>(c.i) * dx, y0 = static_cast<Wide>(c.j) * dy;
        const Wide beside = std::max({x0 - std::max(ax, bx), std::min(ax, bx) - (x0 + dx),
                                      y0 - std::max(ay, by), std::min(ay, by) - (y0 + dy)});
        Wide low = std::numeric_limits<Wide>::max(), high = -low;
        for (const Wide x : {x0, x0 + dx}) {
            for (const Wide y : {y0, y0 + dy}) {
                const Wide side = (bx - ax) * (y - ay) - (by - ay) * (x - ax);
                low = std::min(low, side), high = std::max(high, side);
            }
        }
        const Wide across = std::max(low, -high),
                   by_length = exact || length() == 0 ? across : across / length();
        return std::max(beside, by_length);
    }
    /// When the segment is in the cell.
    [[nodiscard]] std::pair<Wide, Wide> times(Cell c) const {
        Wide in = 0, out = 1;
        const auto clip = [&](Wide a, Wide d, Wide low, Wide high) {
            if (d == 0) return;
            in = std::max(in, std::min((low - a) / d, (high - a) / d));
            out = std::min(out, std::max((low - a) / d, (high - a) / d));
        };
        const Wide x0 = static_cast<Wide>(c.i) * dx, y0 = static_cast<Wide>(c.j) * dy;
        clip(ax, bx - ax, x0, x0 + dx);
        clip(ay, by - ay, y0, y0 + dy);
        return {std::clamp(in, Wide(0), Wide(1)), std::clamp(out, Wide(0), Wide(1))};
    }

private:
    [[nodiscard]] static Wide of(double x, double origin) {
        return static_cast<Wide>(x) - static_cast<Wide>(origin);
    }
};

/// What is wrong with spans in their order along the segment; empty if nothing is.
template <Real F>
std::string span_fault(const std::vector<BasicCellSpan<F>>& spans) {
    F reached = spans.empty() ? 0 : spans.front().t_in;
    for (const auto& span : spans) {
        if (!(0 <= span.t_in && span.t_in <= span.t_out && span.t_out <= 1))
            return "not a span of the segment";
        if (span.t_in > reached) return "leaves a gap";
        for (const F w : {span.in.x, span.in.y, span.out.x, span.out.y})
            if (!(0 <= w && w <= 1)) return "enters or leaves outside the cell";
        reached = std::max(reached, span.t_out);
    }
    return {};
}

/// What is wrong with how often a cell was visited, and offered as a candidate; empty if nothing is.
template <Real T>
std::string cell_fault(const Surface<T>& surface, const Projection& p, const Segment& s, Cell cell,
                       std::ptrdiff_t visits, std::ptrdiff_t offers) {
    const Wide gap = p.gap(cell), blur = p.exact ? 0 : p.blur;
    const bool meets = p.exact ? gap <= 0 : gap <= -blur;
    if (visits > 1 || offers > 1) return "comes twice";
    if (meets && visits == 0) return "is missed";
    if (gap > blur && visits != 0) return "is invented";
    if (offers > visits) return "is a candidate off the walk";
    const auto patch = surface.patch(cell.i, cell.j);
    if (!patch && offers != 0) return "has no patch and is a candidate";
    if (!patch || !meets || visits == 0) return {};
    // The height of the part over the cell: its times err by the blur over the length.
    const auto [in, out] = p.times(cell);
    const Wide az = static_cast<Wide>(s.a.z), bz = static_cast<Wide>(s.b.z);
    const Wide lowest = std::min(az + in * (bz - az), az + out * (bz - az));
    const Wide shortest = std::max(p.length(), Wide(1e-30L));
    const Wide unsure = 8 * eps_place<T> * (std::abs(az) + std::abs(bz) + std::abs(patch->highest())) +
                        std::abs(bz - az) * std::min(p.length() == 0 ? Wide(0) : p.blur / shortest, Wide(1));
    if (lowest < patch->highest() - unsure && offers == 0) return "is no candidate";
    if (lowest > patch->highest() + unsure && offers != 0) return "is a candidate, far below";
    return {};
}

/// What is wrong with a walk; empty if nothing is.
template <Real T>
std::string walk_fault(const Terrain<T>& terrain, const Segment& s) {
    const auto grid = terrain.grid();
    const Projection p{terrain, s};
    using Place = vec3<PlaceScalar<T>>;
    using Span = BasicCellSpan<PlaceScalar<T>>;
    const Place a{s.a}, b{s.b};
    std::vector<Span> spans;
    walk_cells(grid.lattice(), grid.cells(), {a.x, a.y}, {b.x, b.y}, [&](const Span& span) {
        spans.push_back(span);
        return spans.size() < 10000; // so that a walk that never ends fails instead
    });
    if (std::string fault = span_fault(spans); !fault.empty()) return fault;
    std::vector<Cell> candidates;
    walk_candidates(grid, a, b, [&](const Span& span, const auto&) {
        candidates.push_back(span.cell);
        return candidates.size() < 10000;
    });
    const Surface<T> surface{terrain};
    for (Index j = 0; j + 1 < terrain.rows; ++j) {
        for (Index i = 0; i + 1 < terrain.columns; ++i) {
            const Cell cell{i, j};
            const auto visits = std::count_if(spans.begin(), spans.end(),
                                              [&](const Span& span) { return span.cell == cell; });
            const auto offers = std::count(candidates.begin(), candidates.end(), cell);
            const std::string fault = cell_fault(surface, p, s, cell, visits, offers);
            if (!fault.empty()) return "cell " + std::to_string(i) + ' ' + std::to_string(j) + ' ' + fault;
        }
    }
    return {};
}

/// What is wrong with a crossing; empty if nothing is. `judged` counts those that a rounding of the heights does not
/// turn round.
template <Real T>
std::string crossing_fault(const Terrain<T>& terrain, const Segment& s, SurfaceKind kind, Side side,
                           int& judged) {
    const auto grid = terrain.grid();
    const Surface<T> surface{terrain};
    const Projection p{terrain, s};
    Wide top = std::max(std::abs(static_cast<Wide>(s.a.z)), std::abs(static_cast<Wide>(s.b.z)));
    for (const T h : terrain.heights)
        if (std::isfinite(h))
            top =
                std::max(top, std::abs(static_cast<Wide>(h) * static_cast<Wide>(terrain.frame.height_scale)));
    // A rounding of the place, in cells, times the relief; and of the heights.
    const Wide lift = 4 * (eps_place<T> + p.blur / std::min(p.dx, p.dy)) * top;

    const auto found = first_hit(grid, vec3<PlaceScalar<T>>{s.a}, vec3<PlaceScalar<T>>{s.b},
                                 {.surface = kind, .side = side});
    const bool hit = found.status == HitStatus::hit;
    if (found.status == HitStatus::cell_limit) return "a limit where none was set";
    if (!(found.t >= 0 && found.t <= 1)) return "beside the segment";
    if (hit) {
        const auto at = wide(found.point);
        if (!(at.u >= 0 && at.u <= 1 && at.v >= 0 && at.v <= 1)) return "outside its cell";
        if (!surface.patch(at.i, at.j)) return "no patch there";
        const Wide t = static_cast<Wide>(found.t);
        const Wide x = p.ax + t * (p.bx - p.ax), y = p.ay + t * (p.by - p.ay);
        const Wide z = static_cast<Wide>(s.a.z) + t * (static_cast<Wide>(s.b.z) - static_cast<Wide>(s.a.z));
        const Wide off = 2 * p.blur + static_cast<Wide>(epsilon<T>) * (p.dx + p.dy);
        if (std::abs((static_cast<Wide>(at.i) + at.u) * p.dx - x) > off) return "x is not the segment's";
        if (std::abs((static_cast<Wide>(at.j) + at.v) * p.dy - y) > off) return "y is not the segment's";
        // u and v are rounded to T; the time is judged below.
        const auto patch = surface.patch(at.i, at.j);
        const Wide steep = std::abs(static_cast<Wide>(s.b.z) - static_cast<Wide>(s.a.z));
        const Wide rise = lift +
                          2 * static_cast<Wide>(epsilon<T>) * (top + patch->highest() - patch->lowest()) +
                          8 * eps_place<T> * steep;
        if (std::abs(patch->height(at.u, at.v) - z) > rise) return "off the surface";
    }
    const auto pieces = hit_pieces(terrain, s.a, s.b);
    const auto exact = brute_force_hit(pieces, kind, side);
    const auto raised = brute_force_hit(pieces, kind, side, lift);
    const auto lowered = brute_force_hit(pieces, kind, side, -lift);
    if (exact.hit != raised.hit || exact.hit != lowered.hit || exact.side != raised.side ||
        exact.side != lowered.side || std::abs(raised.t - lowered.t) > 1e-3L)
        return {};
    ++judged;
    if (hit && !exact.hit) return "invented";
    if (!hit && exact.hit) return "missed";
    if (found.side != exact.side) return "on the other side";
    const Wide t = static_cast<Wide>(found.t), slack = 16 * eps_place<T>;
    if (hit && (t < std::min({exact.t, raised.t, lowered.t}) - slack ||
                t > std::max({exact.t, raised.t, lowered.t}) + slack))
        return "at another time";
    return {};
}

/// Calls each(PatchCase, cell) for the patches around some positions of the path, and for the focus from all of them.
template <Real T, class Each>
void each_patch_query(const HardCase<T>& c, Each&& each) {
    const auto grid = c.terrain.grid();
    for (const auto& stylus : some_of(c.path, 24)) {
        const auto ask = [&](Cell cell) {
            if (const auto patch = grid.patch(cell))
                each(PatchCase<T>{*patch, grid.lattice().locate(stylus, cell)});
        };
        const auto here = [&](double x, double line, double spacing) {
            return static_cast<Index>(std::floor((x - line) / spacing));
        };
        const auto& f = c.terrain.frame;
        const Cell under{here(static_cast<double>(stylus.x), f.origin.x, f.spacing.x),
                         here(static_cast<double>(stylus.y), f.origin.y, f.spacing.y)};
        for (Index dj = -1; dj <= 1; ++dj)
            for (Index di = -1; di <= 1; ++di) ask({under.i + di, under.j + dj});
        ask(c.focus);
    }
}

template <Real T>
std::string describe(const PatchCase<T>& c) {
    std::string text = "corners";
    for (const T x : {c.patch.p00, c.patch.p10, c.patch.p01, c.patch.p11}) text += ' ' + digits(x);
    return text + ", spacing " + digits(c.patch.spacing.x) + ' ' + digits(c.patch.spacing.y) + ", query " +
           digits(c.query.u) + ' ' + digits(c.query.v) + ' ' + digits(c.query.z);
}

template <Real T>
WidePatch widened(const BilinearPatch<T>& p) {
    return {static_cast<Wide>(p.p00), static_cast<Wide>(p.p10),       static_cast<Wide>(p.p01),
            static_cast<Wide>(p.p11), static_cast<Wide>(p.spacing.x), static_cast<Wide>(p.spacing.y)};
}

/// What is wrong with Newton's answer from a start; empty if nothing is.
template <Real T>
std::string newton_fault(const PatchCase<T>& c, const vec2<T>& start, Wide nearest) {
    const auto foot = newton_closest_point(c.patch, c.query, start);
    if (!(foot.u >= 0 && foot.u <= 1 && foot.v >= 0 && foot.v <= 1)) return "outside the patch";
    if (foot.status != NewtonStatus::converged) return "not converged";
    const WidePatch p = widened(c.patch);
    const Point q{static_cast<Wide>(c.query.u) * p.dx, static_cast<Wide>(c.query.v) * p.dy,
                  static_cast<Wide>(c.query.z)};
    const Wide u = static_cast<Wide>(foot.u), v = static_cast<Wide>(foot.v),
               eps = static_cast<Wide>(epsilon<T>);
    // A step is taken on the strength of a computed change, which is wrong by no more than the ulp-scale.
    const Slopes s = slopes(p, u, v, q);
    if (p.half_square(u, v, q) > p.half_square(static_cast<Wide>(start.x), static_cast<Wide>(start.y), q) +
                                     16 * eps * (s.scale_u + s.scale_v))
        return "farther than the start";
    if (fall_into<T>(p, u, v, q) > 64) return "not at a minimum";
    if (std::abs(static_cast<Wide>(foot.gap) - (p.height(u, v) - q.z)) > 8 * eps * p.reach(q))
        return "gap is not of the foot";
    if (length(p.position(u, v) - q) < nearest - 1e-15L * p.reach(q)) return "nearer than the scan";
    const auto again = newton_closest_point(c.patch, c.query, {foot.u, foot.v});
    if (again.u != foot.u || again.v != foot.v) return "moves on from its own answer";
    return {};
}

/// What is wrong with a descent; empty if nothing is.
template <Real T>
std::string descent_fault(const Terrain<T>& terrain, const SurfacePoint<T>& start, const vec3<T>& query) {
    const Surface<T> surface{terrain};
    const auto grid = terrain.grid();
    const auto end = descend(grid, query, start, plenty);
    const WideSurfacePoint at = wide(end.point);
    const Point q = wide(query);
    if (!(at.u >= 0 && at.u <= 1 && at.v >= 0 && at.v <= 1)) return "outside the cell";
    if (!surface.patch(at.i, at.j)) return "on no patch";
    if (end.status == DescentStatus::work_limit) return "ran out of work";
    if (end.patches > 4000) return "hops without end";
    // A computed change of F errs by no more than its derivatives do over one cell; this over all patches passed.
    const Wide eps = static_cast<Wide>(epsilon<T>);
    Wide scale = 0;
    for (const auto& s : {wide(start), at}) {
        const auto k = slopes(*surface.patch(s.i, s.j), s.u, s.v, surface.seen_from(q, s.i, s.j));
        scale = std::max(scale, k.scale_u + k.scale_v);
    }
    if (surface.half_square(at, q) > surface.half_square(wide(start), q) + 16 * eps * scale) return "went up";
    const Wide fall = surface.template fall<T>(at, q);
    if (fall > 64) return "a patch leads down: " + std::to_string(static_cast<double>(fall)) + " ulp-scales";
    if (length(wide(end.offset) - (surface.position(at) - q)) > 16 * surface.blur(at, q, eps))
        return "offset is not of the point";
    if (length(wide(end.normal) - surface.normal(at)) > 32 * eps) return "normal is not the average";
    const auto again = descend(grid, query, end.point, plenty);
    if (!(again.point.cell == end.point.cell) || again.point.u != end.point.u || again.point.v != end.point.v)
        return "moves on from its own end";
    return {};
}

template <Real T>
bool same(const Contact<T>& a, const Contact<T>& b) {
    return a.status == b.status && a.side == b.side && a.proxy == b.proxy && a.normal == b.normal &&
           a.penetration == b.penetration && a.depth == b.depth && a.point.cell == b.point.cell &&
           a.point.u == b.point.u && a.point.v == b.point.v;
}

constexpr TrackerOptions solid{};
constexpr TrackerOptions sheet{.surface = SurfaceKind::sheet};

/// A witness that also watches the force: from one contact to the next the depth grows by no more than the stylus
/// moved, for the old proxy is that near and the new one is nearer.
template <Real T>
class ForceWitness {
public:
    ForceWitness(const Terrain<T>& terrain, const TrackerOptions& options) : witness{terrain, options} {}

    Witness<T> witness;
    std::string jump; ///< the first one

    Contact<T> update(const vec3<T>& stylus) {
        const auto c = witness.update(stylus);
        if (c.touching() && last_.touching() && jump.empty()) {
            const Point moved = wide(stylus) - wide(at_);
            const auto s = wide(c.point), before = wide(last_.point);
            const Wide eps = static_cast<Wide>(epsilon<T>);
            const Wide blur =
                witness.surface.blur(s, wide(stylus), eps) + witness.surface.blur(before, wide(at_), eps);
            const Wide more = static_cast<Wide>(c.depth) - static_cast<Wide>(last_.depth);
            if (more > length(moved) + 16 * blur)
                jump = "depth " + digits(last_.depth) + " at " + digits(at_) + " became " + digits(c.depth) +
                       " at " + digits(stylus);
        }
        last_ = c;
        at_ = stylus;
        return c;
    }

private:
    Contact<T> last_{};
    vec3<T> at_{T(0)};
};

/// Stands at `stylus` for `updates` updates. The number of those that are not like the first, bit by bit. (Where the
/// first one left the surface, the next one says where the stylus is; that holds then.)
template <Real T>
int restless(ProxyTracker<typename Terrain<T>::Grid>& tracker, const vec3<T>& stylus, int updates) {
    auto first = tracker.update(stylus);
    if (!first.touching()) first = tracker.update(stylus);
    int moved = 0;
    for (int n = 0; n < updates; ++n) moved += !same(tracker.update(stylus), first);
    return moved;
}

template <Real T>
bool leans(const vec3<T>& penetration, const std::array<int, 3>& signs) {
    const T p[]{penetration.x, penetration.y, penetration.z};
    for (std::size_t k = 0; k < 3; ++k)
        if (signs[k] != 0 && !(static_cast<T>(signs[k]) * p[k] > 0)) return false;
    return true;
}

} // namespace

TEMPLATE_TEST_CASE("hard cases: a walk visits the cells that the segment meets", "[hard][walker]", float,
                   double) {
    each_case<TestType>([](const auto& c) {
        for (const auto& s : segments(c)) {
            const std::string what = walk_fault(c.terrain, s);
            if (what.empty()) continue;
            INFO(digits(s.a) << " -> " << digits(s.b));
            CHECK(what == "");
            break;
        }
    });
}

TEMPLATE_TEST_CASE("hard cases: a segment crosses where brute force says", "[hard][first_hit]", float,
                   double) {
    each_case<TestType>([](const auto& c) {
        int judged = 0;
        for (const auto& s : segments(c)) {
            const auto start = hit_pieces(c.terrain, s.a, s.b);
            const Side known = start.empty()              ? Side::none
                               : start.front().at(0) >= 0 ? Side::above
                                                          : Side::below;
            for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
                for (const Side side : {Side::none, known}) {
                    const std::string what = crossing_fault(c.terrain, s, kind, side, judged);
                    if (what.empty()) continue;
                    INFO(digits(s.a) << " -> " << digits(s.b) << ", kind " << int(kind) << ", side "
                                     << int(side));
                    CHECK(what == "");
                    return;
                }
            }
        }
        CHECK(judged > 0);
    });
}

TEMPLATE_TEST_CASE(
    "hard cases: Newton ends at a local minimum of each patch, the search at the closest point",
    "[hard][closest_point][global_closest_point]", float, double) {
    using T = TestType;
    each_case<T>([](const auto& c) {
        int asked = 0;
        each_patch_query(c, [&](const PatchCase<T>& q) {
            ++asked;
            const SeenPatch seen{q};
            const Wide nearest = scanned_distance(seen);
            const auto global = global_closest_point(q.patch, q.query);
            INFO(describe(q));
            const Wide promise = std::is_same_v<T, float> ? 4e-6L : 1e-12L;
            const Wide there = seen.distance(static_cast<Wide>(global.u), static_cast<Wide>(global.v));
            if (!(there - nearest <= promise * seen.size(nearest)) || !(global.u >= 0 && global.u <= 1) ||
                !(global.v >= 0 && global.v <= 1) || global.status == GlobalStatus::interval_limit) {
                CAPTURE(double(there), double(nearest), int(global.status));
                CHECK(std::string{"not the closest point"} == "");
            }
            for (const vec2<T>& start : {vec2<T>{T(0.5), T(0.5)}, vec2<T>{0, 0}, vec2<T>{1, 0}, vec2<T>{0, 1},
                                         vec2<T>{1, 1}, vec2<T>{0, T(0.25)}, vec2<T>{T(0.75), 1}}) {
                const std::string what = newton_fault(q, start, nearest);
                if (what.empty()) continue;
                INFO("start " << digits(start.x) << ' ' << digits(start.y));
                CHECK(what == "");
            }
        });
        CHECK(asked > 0);
    });
}

TEMPLATE_TEST_CASE("hard cases: a descent never rises and ends where no patch leads down", "[hard][descent]",
                   float, double) {
    using T = TestType;
    each_case<T>([](const auto& c) {
        const auto grid = c.terrain.grid();
        const Surface<T> surface{c.terrain};
        for (const auto& query : some_of(c.path, 40)) {
            const auto under = surface.under(static_cast<Wide>(query.x), static_cast<Wide>(query.y));
            std::vector<Cell> cells{c.focus, {c.terrain.columns - 2, c.terrain.rows - 2}};
            if (under) cells.push_back({under->i, under->j});
            for (const Cell cell : cells) {
                if (!grid.patch(cell)) continue;
                for (const vec2<T>& at :
                     {vec2<T>{T(0.5), T(0.5)}, vec2<T>{0, 0}, vec2<T>{1, 0}, vec2<T>{0, 1}, vec2<T>{1, 1},
                      vec2<T>{T(0.375), 0}, vec2<T>{1, T(0.625)}}) {
                    const std::string what = descent_fault<T>(c.terrain, {cell, at.x, at.y}, query);
                    if (what.empty()) continue;
                    INFO("query " << digits(query) << ", from cell " << cell.i << ' ' << cell.j << " at "
                                  << digits(at.x) << ' ' << digits(at.y));
                    CHECK(what == "");
                }
            }
        }
    });
}

TEMPLATE_TEST_CASE("hard cases: the tracker keeps its promises along the path, there and back",
                   "[hard][proxy_tracker]", float, double) {
    using T = TestType;
    each_case<T>([](const auto& c) {
        for (const auto& options : {solid, sheet}) {
            CAPTURE(int(options.surface));
            ForceWitness<T> watch{c.terrain, options};
            Contact<T> last;
            for (const auto& p : c.path) last = watch.update(p);
            if (options.surface == SurfaceKind::solid) {
                CHECK(std::string{to_string(last.status)} == to_string(c.end));
                INFO("penetration " << digits(last.penetration));
                CHECK(leans(last.penetration, c.push));
            }
            for (auto p = c.path.rbegin(); p != c.path.rend(); ++p) watch.update(*p);
            // Every third and every seventh position: longer swipes over the same ground.
            for (const std::size_t leap : {3u, 7u}) {
                watch.witness.reset();
                for (std::size_t n = 0; n < c.path.size(); n += leap) watch.update(c.path[n]);
            }
            if (options.surface == SurfaceKind::sheet) { // from below, through the same places
                watch.witness.reset();
                auto start = c.path.front();
                for (const T h : c.terrain.heights)
                    if (h < start.z) start.z = h;
                start.z -= static_cast<T>(4 * c.terrain.frame.spacing.x);
                watch.update(start);
                for (const auto& p : c.path) watch.update(p);
            }
            CHECK(watch.witness.first_fault == "");
            CHECK(watch.jump == "");
        }
    });
}

TEMPLATE_TEST_CASE("hard cases: a stylus that stands still for 100,000 updates moves nothing by an ulp",
                   "[hard][proxy_tracker]", float, double) {
    using T = TestType;
    each_case<T>([](const auto& c) {
        const auto grid = c.terrain.grid();
        for (const auto& options : {solid, sheet}) {
            ProxyTracker tracker{grid, options};
            for (const auto& p : c.path) {
                INFO("stylus " << digits(p));
                if (const int moved = restless<T>(tracker, p, 20); moved != 0) CHECK(moved == 0);
            }
            // And for long where the path was deepest.
            ProxyTracker other{grid, options};
            auto deepest = other.state();
            vec3<T> there = c.path.front();
            T depth = 0;
            for (const auto& p : c.path) {
                const auto contact = other.update(p);
                if (contact.depth > depth) depth = contact.depth, deepest = other.state(), there = p;
            }
            if (depth > 0) {
                other.restore(deepest);
                INFO("stylus " << digits(there));
                CHECK(restless<T>(other, there, options.surface == SurfaceKind::solid ? 100000 : 1000) == 0);
            }
        }
    });
}

TEMPLATE_TEST_CASE("hard cases: on faces of every steepness a stylus inside is pushed at every update",
                   "[hard][proxy_tracker][regression]", float, double) {
    // On a face of slope s the offset's z is depth/s, so that its sign is lost in rounding where the normal's is not.
    using T = TestType;
    for (const double slope : {30.0, 100.0, 1000.0, 3000.0, 10000.0}) {
        for (const double depth : {0.01, 0.1, 0.5}) {
            CAPTURE(slope, depth);
            const auto wall = terrain<T>(9, 7, [=](Index i, Index) { return i < 4 ? 0.0 : slope; });
            Witness<T> witness{wall};
            const double x = 3.5, z = slope / 2;
            (void)witness.update({T(x - 1), T(3.3), T(z)});
            int lost = 0;
            vec3<T> at{T(x + depth), T(3.3), T(z)};
            for (int n = 0; n < 500; ++n) {
                at.z = std::nextafter(at.z, std::numeric_limits<T>::max());
                lost += !(witness.update(at).depth > 0);
            }
            CHECK(lost == 0);
            CHECK(witness.first_fault == "");
        }
    }
    // A pit of one sample, pressed into from all sides: on its creases two faces almost face each other. Float has no
    // digits left there for a shallow contact from a depth of 200 cells on.
    for (const double depth : {50.0, std::is_same_v<T, float> ? 100.0 : 10000.0}) {
        CAPTURE(depth);
        const auto ground = pit<T>(9, 9, depth);
        Witness<T> witness{ground};
        Random random{90};
        (void)witness.update({T(4), T(4), T(1)});
        for (int n = 0; n < 5000; ++n) {
            (void)witness.update({static_cast<T>(4 + random.between(-0.6, 0.6)),
                                  static_cast<T>(4 + random.between(-0.6, 0.6)),
                                  static_cast<T>(-depth * random.unit())});
        }
        CHECK(witness.first_fault == "");
    }
}

TEMPLATE_TEST_CASE("hard cases: a stylus that creeps by an ulp is never lost and feels no jump",
                   "[hard][proxy_tracker]", float, double) {
    using T = TestType;
    each_case<T>([](const auto& c) {
        for (const auto& options : {solid, sheet}) {
            CAPTURE(int(options.surface));
            ForceWitness<T> watch{c.terrain, options};
            for (const auto& p : some_of(c.path, 30)) {
                watch.update(p);
                vec3<T> at = p;
                for (int axis = 0; axis < 3; ++axis) {
                    for (const T goal : {std::numeric_limits<T>::max(), std::numeric_limits<T>::lowest()}) {
                        for (int n = 0; n < 12; ++n) {
                            at[axis] = std::nextafter(at[axis], goal);
                            watch.update(at);
                        }
                    }
                }
            }
            CHECK(watch.witness.first_fault == "");
            CHECK(watch.jump == "");
        }
    });
}

TEMPLATE_TEST_CASE("hard cases: integer samples are felt as the heights that they stand for",
                   "[hard][height_view][proxy_tracker]", float, double) {
    using T = TestType;
    int cases = 0;
    each_case<T>([&](const auto& c) {
        const auto compare = [&](auto view) {
            ++cases;
            const BilinearGrid<T, decltype(view), PlaceScalar<T>> integers{view, {.height_scale = c.scale}};
            const auto heights = c.terrain.grid();
            REQUIRE(integers.status() == GridStatus::ok);
            for (Index j = -1; j < c.terrain.rows; ++j) {
                for (Index i = -1; i < c.terrain.columns; ++i) {
                    CAPTURE(i, j);
                    const auto a = integers.patch({i, j}), b = heights.patch({i, j});
                    REQUIRE(a.has_value() == b.has_value());
                    if (!a) continue;
                    REQUIRE((a->p00 == b->p00 && a->p10 == b->p10 && a->p01 == b->p01 && a->p11 == b->p11));
                }
            }
            for (const auto& options : {solid, sheet}) {
                ProxyTracker one{integers, options};
                ProxyTracker other{heights, options};
                for (const auto& p : c.path) {
                    INFO("stylus " << digits(p));
                    REQUIRE(same(one.update(p), other.update(p)));
                }
            }
        };
        const Index columns = c.terrain.columns, rows = c.terrain.rows;
        if (!c.bytes.empty()) compare(HeightView{c.bytes.data(), columns, rows});
        if (!c.words.empty()) compare(HeightView{c.words.data(), columns, rows, MissingValue{no_data}});
        if (!c.words.empty()) CHECK(std::count(c.words.begin(), c.words.end(), no_data) == 2);
    });
}

TEMPLATE_TEST_CASE(
    "hard cases: to and fro across an edge, a vertex, a crease the force swings and does not grow",
    "[hard][proxy_tracker]", float, double) {
    using T = TestType;
    struct Swing {
        const char* name;
        Terrain<T> terrain;
        glm::dvec3 above, middle, swing; ///< swings from middle − swing to middle + swing
        int lean;                        ///< the sign of the normal's x throughout; 0: not asked
    };
    const Swing swings[]{
        {"an edge of a plane",
         tilted_plane<T>(9, 9, 0.5, -0.25),
         {4, 4.5, 4},
         {4, 4.5, 0.5},
         {0.0625, 0, 0},
         -1},
        {"an edge of hills", hills<T>(17, 17, 1, 8), {8, 6.3, 3}, {8, 6.3, -1}, {0.1, 0, 0}, 0},
        {"a vertex of hills", hills<T>(17, 17, 1, 8), {8, 6, 3}, {8, 6, -1}, {0.1, 0.07, 0}, 0},
        {"a vertex, up and down", hills<T>(17, 17, 1, 8), {8, 6, 3}, {8, 6, -1}, {0.1, 0.07, 0.2}, 0},
        // Below the crease of a valley the foot is the crease itself, beside it one wall and then the other.
        {"the crease of a valley", valley<T>(9, 7, 1.5), {4, 3.3, 3}, {4, 3.3, -0.25}, {0.75, 0, 0}, 0},
        // The two walls of a ridge: the proxy stays on the one where it is.
        {"under the crest of a ridge", ridge<T>(25, 20, 1.5), {11, 9.3, 3}, {12, 9.3, -2}, {0.1, 0, 0}, -1},
        {"under the crest of a knife ridge",
         terrain<T>(9, 7, [](Index i, Index) { return i == 4 ? 10.0 : 0.0; }),
         {3, 3.3, 4},
         {4, 3.3, 4},
         {0.125, 0, 0},
         -1},
        {"an ulp to each side of an edge",
         hills<T>(17, 17, 1, 8),
         {8, 6.3, 3},
         {8, 6.3, -1},
         {8 * static_cast<double>(epsilon<T>), 0, 0},
         0},
        {"an ulp to each side of a crest",
         ridge<T>(25, 20, 1.5),
         {11, 9.3, 3},
         {12, 9.3, -2},
         {8 * static_cast<double>(epsilon<T>), 0, 0},
         -1},
        {"an ulp to each side of a vertex",
         hills<T>(17, 17, 1, 8),
         {8, 8, 3},
         {8, 8, -1},
         {8 * static_cast<double>(epsilon<T>), 8 * static_cast<double>(epsilon<T>), 0},
         0},
    };
    constexpr int quarter = 4, period = 4 * quarter, periods = 1000;
    for (const auto& s : swings) {
        DYNAMIC_SECTION(s.name) {
            ForceWitness<T> watch{s.terrain, solid};
            const auto stylus = [&](int k) {
                const int phase = (k + quarter) % period; // from the middle out, back, over, and back
                const double w = (phase < period / 2 ? phase : period - phase) / double(quarter) - 1;
                const glm::dvec3 p = s.middle + w * s.swing;
                return vec3<T>{static_cast<T>(p.x), static_cast<T>(p.y), static_cast<T>(p.z)};
            };
            watch.update({static_cast<T>(s.above.x), static_cast<T>(s.above.y), static_cast<T>(s.above.z)});
            // In beside the middle, so that a ridge is met from its side.
            const glm::dvec3 in{s.above.x, s.above.y, s.middle.z};
            watch.update({static_cast<T>(in.x), static_cast<T>(in.y), static_cast<T>(in.z)});
            int lost = 0, leant = 0;
            Wide steepest = 0;
            std::vector<Contact<T>> first, last;
            Contact<T> before = watch.update(stylus(0));
            for (int k = 1; k <= periods * period; ++k) {
                const auto c = watch.update(stylus(k));
                lost += c.status != ContactStatus::contact || !(c.depth > 0);
                leant += s.lean != 0 && !(static_cast<T>(s.lean) * c.normal.x > 0);
                const Wide step = length(wide(stylus(k)) - wide(stylus(k - 1)));
                const Wide blur = watch.witness.surface.blur(test::wide(c.point), wide(stylus(k)),
                                                             static_cast<Wide>(epsilon<T>));
                steepest = std::max(steepest,
                                    std::abs(static_cast<Wide>(c.depth) - static_cast<Wide>(before.depth)) -
                                        step - 16 * blur);
                if (k > period && k <= 2 * period) first.push_back(c);
                if (k > (periods - 1) * period) last.push_back(c);
                before = c;
            }
            CHECK(watch.witness.first_fault == "");
            CHECK(watch.jump == "");
            CHECK(lost == 0);
            CHECK(leant == 0);
            CHECK(double(steepest) <= 0); // the depth changes by no more than the stylus moves, up and down
            // The thousandth swing is the second one, but for the last bits that the way there left in it.
            for (std::size_t k = 0; k < first.size(); ++k) {
                const Wide blur = watch.witness.surface.blur(test::wide(first[k].point), wide(s.above),
                                                             static_cast<Wide>(epsilon<T>));
                CAPTURE(k, digits(first[k].penetration), digits(last[k].penetration));
                CHECK(length(wide(first[k].penetration) - wide(last[k].penetration)) <= 16 * blur);
            }
        }
    }
}

TEMPLATE_TEST_CASE("hard cases: at a northing of 10,000 km a contact is the one at the origin, bit by bit",
                   "[hard][lattice][proxy_tracker][far]", float, double) {
    using T = TestType;
    // Positions that both places can write down: multiples of 1/64 m in double; of a whole metre in float, which has no
    // others there. What is computed from the cell's corner is then the same; the proxy's world coordinates alone are
    // rounded to what the scalar can write: half a metre in float, a nanometre in double.
    constexpr bool single = std::is_same_v<T, float>;
    constexpr double unit = single ? 1 : 0x1p-6;
    const glm::dvec2 far{500000.25, 10000000.5}; // float has no such northing
    const auto near_by = rough_in_steps<T>(33, 33, 32, 208, {.spacing = {16, 16}});
    auto far_off = near_by;
    far_off.frame.origin = far;
    for (const auto& options : {solid, sheet}) {
        CAPTURE(int(options.surface));
        Witness<T> here{near_by, options}, there{far_off, options};
        Random random{209};
        glm::dvec3 at{255.75, 255.5, 40}; // on whole metres, over there
        int contacts = 0, differ = 0, misplaced = 0;
        Wide worst = 0;
        for (int n = 0; n < 20000; ++n) {
            if (n % 100 == 0) at.z = 40;
            const auto step = [&](double metres) {
                return unit * static_cast<double>(random.whole(static_cast<std::int64_t>(-metres / unit),
                                                               static_cast<std::int64_t>(metres / unit)));
            };
            at.x = std::clamp(at.x + step(8), 15.75, 495.75);
            at.y = std::clamp(at.y + step(8), 15.5, 495.5);
            if (n % 100 > 0) at.z = std::clamp(at.z + step(12), -24.0, 36.0);
            const vec3<T> p{static_cast<T>(at.x), static_cast<T>(at.y), static_cast<T>(at.z)};
            const vec3<T> q{static_cast<T>(at.x + far.x), static_cast<T>(at.y + far.y), p.z};
            const auto a = here.update(p), b = there.update(q);
            contacts += a.touching();
            differ += !(a.status == b.status && a.side == b.side && a.normal == b.normal &&
                        a.point.cell == b.point.cell && a.point.u == b.point.u && a.point.v == b.point.v &&
                        a.depth == b.depth && a.penetration == b.penetration);
            worst = std::max(worst, length(wide(a.penetration) - wide(b.penetration)));
            const Wide half = single ? 0.5L : 0x1p-30L;
            misplaced += a.touching() && std::abs(static_cast<Wide>(b.proxy.y) - static_cast<Wide>(q.y) -
                                                  static_cast<Wide>(b.penetration.y)) > half;
        }
        CHECK(here.first_fault == "");
        CHECK(there.first_fault == "");
        CHECK(contacts > 10000);
        CAPTURE(double(worst));
        CHECK(differ == 0);
        CHECK(misplaced == 0);
    }
}
