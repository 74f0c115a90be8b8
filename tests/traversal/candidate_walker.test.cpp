#include "catch.hpp"
#include "support/exact_walk.hpp"
#include "support/terrains.hpp"

#include <hfh/traversal/candidate_walker.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

using hfh::Cell;
using hfh::CellRange;
using hfh::CellSpan;
using hfh::Index;
using hfh::Lattice;
using hfh::test::ExactSpan;
using hfh::test::Fraction;
using hfh::test::Random;
using hfh::test::WholeLattice;
using hfh::test::WholePoint;

namespace {

constexpr double eps = hfh::epsilon<double>;

std::vector<CellSpan> walked(const Lattice& lattice, const CellRange& range, glm::dvec2 a, glm::dvec2 b) {
    std::vector<CellSpan> spans;
    hfh::walk_cells(lattice, range, a, b, [&](const CellSpan& span) {
        spans.push_back(span);
        return spans.size() < 100'000; // so that a walk that never ends fails instead
    });
    return spans;
}

bool before(Cell a, Cell b) { return a.j != b.j ? a.j < b.j : a.i < b.i; }

/// What every walk keeps, whatever the numbers. Empty if it does, else what is wrong.
std::string out_of_order(const std::vector<CellSpan>& spans, const CellRange& range) {
    std::ostringstream wrong;
    double reached = spans.empty() ? 0 : spans.front().t_in;
    for (std::size_t n = 0; n < spans.size(); ++n) {
        const CellSpan& s = spans[n];
        const auto fails = [&](const char* what) {
            if (wrong.tellp() == 0)
                wrong << "visit " << n << " of (" << s.cell.i << ", " << s.cell.j << "): " << what;
        };
        if (!range.contains(s.cell)) fails("outside the range");
        if (!(0 <= s.t_in && s.t_in <= s.t_out && s.t_out <= 1)) fails("not a span of the segment");
        for (const double w : {s.in.x, s.in.y, s.out.x, s.out.y}) {
            if (!(0 <= w && w <= 1)) fails("enters or leaves outside the cell");
        }
        // In order of entry; joined: each begins where the surface was left, or beside the one before it.
        if (n > 0 && s.t_in < spans[n - 1].t_in) fails("before the one before");
        if (s.t_in != reached && (n == 0 || s.t_in != spans[n - 1].t_in)) fails("does not join");
        if (s.t_in > reached) fails("leaves a gap");
        reached = std::max(reached, s.t_out);
        if (n > 0 &&
            (std::abs(s.cell.i - spans[n - 1].cell.i) > 1 || std::abs(s.cell.j - spans[n - 1].cell.j) > 1)) {
            fails("is no neighbour of the one before");
        }
    }
    std::vector<Cell> cells;
    for (const auto& s : spans) cells.push_back(s.cell);
    std::sort(cells.begin(), cells.end(), before);
    if (std::adjacent_find(cells.begin(), cells.end()) != cells.end()) wrong << "; a cell comes twice";
    return wrong.str();
}

/// Compares a walk with the exact one. Empty if they agree, else what is wrong.
std::string differs(std::vector<CellSpan> spans, std::vector<ExactSpan> exact, const WholeLattice& w,
                    WholePoint a, WholePoint b) {
    std::ostringstream wrong;
    const auto fails = [&](Cell c, const char* what) {
        if (wrong.tellp() == 0) wrong << "(" << c.i << ", " << c.j << "): " << what;
    };
    std::sort(spans.begin(), spans.end(),
              [](const auto& l, const auto& r) { return before(l.cell, r.cell); });
    std::sort(exact.begin(), exact.end(),
              [](const auto& l, const auto& r) { return before(l.cell, r.cell); });
    std::size_t n = 0;
    for (const ExactSpan& e : exact) {
        if (n < spans.size() && before(spans[n].cell, e.cell)) fails(spans[n].cell, "invented");
        if (n == spans.size() || !(spans[n].cell == e.cell)) {
            fails(e.cell, "missed");
            break;
        }
        const CellSpan& s = spans[n++];
        // A time is one quotient: ε/2 of at most 1; the exact value here is rounded as well.
        if (std::abs(s.t_in - e.t_in.value()) > eps) fails(e.cell, "entered at another time");
        if (std::abs(s.t_out - e.t_out.value()) > eps) fails(e.cell, "left at another time");
        for (std::size_t axis = 0; axis < 2; ++axis) {
            const auto at = [&](Fraction t) { // in cells from the cell's own corner
                const std::int64_t low = (axis == 0 ? e.cell.i : e.cell.j) * w.step[axis];
                return Fraction{(a[axis] - low) * t.d + t.n * (b[axis] - a[axis]), t.d * w.step[axis]};
            };
            const auto is_off = [&](double found, Fraction expected) {
                // On a grid line to the bit. Elsewhere the start, 1/spacing, the displacement and the time, each
                // rounded by ε/2, times how far the segment goes in cells.
                if (expected.n == 0 || expected.n == expected.d) return found != expected.value();
                const double cells =
                    static_cast<double>(std::abs(b[axis] - a[axis])) / static_cast<double>(w.step[axis]);
                return std::abs(found - expected.value()) > 2 * eps * (1 + cells);
            };
            const auto component = [&](const glm::dvec2& p) { return axis == 0 ? p.x : p.y; };
            if (is_off(component(s.in), at(e.t_in))) fails(e.cell, "entered at another place");
            if (is_off(component(s.out), at(e.t_out))) fails(e.cell, "left at another place");
        }
    }
    if (n < spans.size()) fails(spans[n].cell, "invented");
    return wrong.str();
}

/// Walks a → b and back on an exact lattice and compares with the oracle; counts the cells it compared.
struct ExactCheck {
    WholeLattice whole;
    CellRange range;
    std::size_t cells = 0;
    int failures = 0;

    void operator()(WholePoint a, WholePoint b) {
        both(a, b);
        both(b, a);
    }

private:
    void both(WholePoint a, WholePoint b) {
        const auto spans = walked(whole.lattice(), range, place(whole, a), place(whole, b));
        const auto exact = hfh::test::exact_cells(whole, range, a, b);
        const std::string order = out_of_order(spans, range), difference = differs(spans, exact, whole, a, b);
        cells += exact.size();
        if (order.empty() && difference.empty()) return;
        CAPTURE(whole.origin.x, whole.unit, whole.step[0], whole.step[1]);
        CAPTURE(range.begin.i, range.begin.j, range.end.i, range.end.j, a[0], a[1], b[0], b[1]);
        CHECK(order == "");
        CHECK(difference == "");
        if (++failures == 5) FAIL("and so on");
    }
};

/// Lattices with powers of two, whole and broken spacings, near and far from the origin of the world.
std::vector<WholeLattice> lattices() {
    return {
        {{0, 0}, 0.125, {8, 8}},              // 1 m
        {{0, 0}, 0.125, {80, 80}},            // 10 m
        {{-3.5, 2.25}, 0.25, {4, 1}},         // 1 m × 0.25 m
        {{100, -50}, 0.125, {8 * 49, 8 * 3}}, // 1/49 × 49 is not 1 in double
        {{5, 5}, 0x1p-10, {1001, 770}},
        {{1e7, -1e7}, 0.5, {20, 61}},
    };
}

std::vector<CellRange> ranges() {
    return {
        {{0, 0}, {6, 5}}, {{-3, -2}, {4, 4}}, {{2, 3}, {3, 4}},
        {{0, 0}, {1, 7}}, {{-4, 1}, {5, 2}},  {{1, 1}, {1, 5}},
    };
}

template <class Each>
void for_each_lattice_and_range(Each&& each) {
    for (const auto& whole : lattices()) {
        for (const auto& range : ranges()) {
            ExactCheck check{whole, range};
            each(check);
            CHECK((range.empty() ? check.cells == 0 : check.cells > 0));
        }
    }
}

/// Points in and two cells around the range.
WholePoint somewhere(Random& random, const ExactCheck& check) {
    return {random.whole((check.range.begin.i - 2) * check.whole.step[0],
                         (check.range.end.i + 2) * check.whole.step[0]),
            random.whole((check.range.begin.j - 2) * check.whole.step[1],
                         (check.range.end.j + 2) * check.whole.step[1])};
}

WholePoint vertex(Random& random, const ExactCheck& check) {
    return {random.whole(check.range.begin.i - 2, check.range.end.i + 2) * check.whole.step[0],
            random.whole(check.range.begin.j - 2, check.range.end.j + 2) * check.whole.step[1]};
}

} // namespace

TEST_CASE("candidate_walker: random segments pass the cells they meet", "[walker][law]") {
    Random random{40};
    for_each_lattice_and_range([&](ExactCheck& check) {
        for (int n = 0; n < 1500; ++n) check(somewhere(random, check), somewhere(random, check));
    });
}

TEST_CASE("candidate_walker: segments between vertices pass all cells around every vertex on the way",
          "[walker][law][hard]") {
    Random random{41};
    for_each_lattice_and_range([&](ExactCheck& check) {
        for (int n = 0; n < 1500; ++n) check(vertex(random, check), vertex(random, check));
        for (int n = 0; n < 500; ++n) check(vertex(random, check), somewhere(random, check));
    });
}

TEST_CASE("candidate_walker: segments through a vertex between their ends pass the four cells around it",
          "[walker][law][hard]") {
    Random random{42};
    for_each_lattice_and_range([&](ExactCheck& check) {
        for (int n = 0; n < 2000; ++n) {
            const WholePoint v = vertex(random, check);
            const std::int64_t dx = random.whole(-60, 60), dy = random.whole(-60, 60);
            const std::int64_t back = random.whole(0, 7), on = random.whole(0, 7);
            check({v[0] - back * dx, v[1] - back * dy}, {v[0] + on * dx, v[1] + on * dy});
        }
    });
}

TEST_CASE("candidate_walker: segments that miss a vertex by one unit pass three of the four cells around it",
          "[walker][law][hard]") {
    Random random{43};
    for_each_lattice_and_range([&](ExactCheck& check) {
        for (int n = 0; n < 1000; ++n) {
            const WholePoint v = vertex(random, check);
            const std::int64_t dx = random.whole(-60, 60), dy = random.whole(-60, 60);
            const std::int64_t off = random.one_in(2) ? 1 : -1;
            check({v[0] - 3 * dx + off, v[1] - 3 * dy}, {v[0] + 2 * dx + off, v[1] + 2 * dy});
            check({v[0] - 3 * dx, v[1] - 3 * dy + off}, {v[0] + 2 * dx, v[1] + 2 * dy});
        }
    });
}

TEST_CASE("candidate_walker: segments along a grid line pass the cells on both sides",
          "[walker][law][hard]") {
    Random random{44};
    for_each_lattice_and_range([&](ExactCheck& check) {
        for (int n = 0; n < 400; ++n) {
            const WholePoint v = vertex(random, check), p = somewhere(random, check),
                             q = somewhere(random, check);
            check({v[0], p[1]}, {v[0], q[1]});
            check({p[0], v[1]}, {q[0], v[1]});
            // and beside it
            check({v[0] + 1, p[1]}, {v[0] + 1, q[1]});
            check({p[0], v[1] - 1}, {q[0], v[1] - 1});
            // and parallel to an axis anywhere
            check({p[0], p[1]}, {p[0], q[1]});
            check({p[0], p[1]}, {q[0], p[1]});
            // and almost parallel
            check({v[0], p[1]}, {v[0] + 1, q[1]});
        }
    });
}

TEST_CASE("candidate_walker: a segment of zero length meets one or two or four cells",
          "[walker][law][hard]") {
    Random random{45};
    for_each_lattice_and_range([&](ExactCheck& check) {
        for (int n = 0; n < 300; ++n) {
            const WholePoint v = vertex(random, check), p = somewhere(random, check);
            check(p, p);
            check(v, v);
            check({v[0], p[1]}, {v[0], p[1]});
            check({p[0], v[1]}, {p[0], v[1]});
        }
    });
    const CellRange range{{0, 0}, {4, 4}};
    CHECK(walked({}, range, {1.5, 1.5}, {1.5, 1.5}).size() == 1);
    CHECK(walked({}, range, {1, 1.5}, {1, 1.5}).size() == 2);
    CHECK(walked({}, range, {1, 2}, {1, 2}).size() == 4);
    CHECK(walked({}, range, {0, 2}, {0, 2}).size() == 2);
    CHECK(walked({}, range, {4, 4}, {4, 4}).size() == 1);
    CHECK(walked({}, range, {4, 4.0001}, {4, 4.0001}).empty());
}

TEST_CASE("candidate_walker: segments that begin or end on the border or only touch it are not lost",
          "[walker][law][hard]") {
    Random random{46};
    for_each_lattice_and_range([&](ExactCheck& check) {
        const auto& [first, last] = check.range;
        const std::array<std::int64_t, 2> x{first.i * check.whole.step[0], last.i * check.whole.step[0]};
        const std::array<std::int64_t, 2> y{first.j * check.whole.step[1], last.j * check.whole.step[1]};
        for (int n = 0; n < 300; ++n) {
            const auto side = static_cast<std::size_t>(n % 2), other = static_cast<std::size_t>(n / 2 % 2);
            const WholePoint p = somewhere(random, check), q = somewhere(random, check);
            check({x[side], p[1]}, q);
            check({p[0], y[side]}, q);
            check({x[side], p[1]}, {q[0], y[other]});
            // The corner of the range and nothing else, or a diagonal into it.
            const std::int64_t dx = random.whole(-40, 40), dy = random.whole(-40, 40);
            check({x[side] - dx, y[other] - dy}, {x[side] + dx, y[other] + dy});
            check({x[side], y[other]}, q);
            check({x[side], y[other]}, {x[1 - side], y[1 - other]});
        }
    });
}

TEST_CASE("candidate_walker: an empty range and a segment far away meet nothing", "[walker]") {
    CHECK(walked({}, {}, {-1, -1}, {3, 3}).empty());
    CHECK(walked({}, {{0, 0}, {5, 0}}, {-1, -1}, {3, 3}).empty());
    const CellRange range{{0, 0}, {4, 4}};
    for (const double far : {1e3, 1e9, 1e15}) {
        CHECK(walked({}, range, {far, far}, {far + 1, far - 10}).empty());
        CHECK(walked({}, range, {-far, 2}, {-far, 3}).empty());
        CHECK(walked({}, range, {-far, far}, {far, far}).empty());
        // straight through from far away costs no more than the cells inside
        CHECK(walked({}, range, {-far, 2.5}, {far, 2.5}).size() == 4);
        CHECK(walked({}, range, {2.5, far}, {2.5, -far}).size() == 4);
    }
}

TEST_CASE("candidate_walker: a segment of thousands of cells drifts nowhere", "[walker][law]") {
    Random random{47};
    std::size_t longest = 0;
    for (const auto& whole : lattices()) {
        // Fractions of the oracle stay below 2³¹.
        const std::int64_t far =
            std::min<std::int64_t>(2500 * std::min(whole.step[0], whole.step[1]), 20'000);
        for (int n = 0; n < 60; ++n) {
            WholePoint a{random.whole(-far, far), random.whole(-far, far)};
            WholePoint b{random.whole(-far, far), random.whole(-far, far)};
            if (n % 3 == 0) { // through many vertices
                const std::int64_t k = random.whole(1, 5), l = random.whole(-5, 5),
                                   m = far / (whole.step[0] * 5);
                a = {0, 0};
                b = {m * k * whole.step[0], m * l * whole.step[1]};
            }
            if (n % 3 == 1) a[0] = b[0] = a[0] / whole.step[0] * whole.step[0];
            const auto spans =
                walked(whole.lattice(), CellRange::endless(), place(whole, a), place(whole, b));
            const auto exact = hfh::test::exact_cells_by_column(whole, a, b);
            longest = std::max(longest, exact.size());
            CAPTURE(whole.unit, whole.step[0], whole.step[1], a[0], a[1], b[0], b[1]);
            REQUIRE(out_of_order(spans, CellRange::endless()) == "");
            REQUIRE(differs(spans, exact, whole, a, b) == "");
        }
    }
    CHECK(longest > 5000);
}

/// Whether the segment from a to b meets cell c grown by `margin` cells on every side.
bool meets_grown(const glm::dvec2& origin, const glm::dvec2& spacing, const glm::dvec2& a,
                 const glm::dvec2& b, Cell c, long double margin) {
    using Exact = long double;
    Exact t_in = 0, t_out = 1;
    for (int axis = 0; axis < 2; ++axis) {
        const auto along = [&](const glm::dvec2& p) { return static_cast<Exact>(axis == 0 ? p.x : p.y); };
        const Exact from = (along(a) - along(origin)) / along(spacing);
        const Exact to = (along(b) - along(origin)) / along(spacing);
        const auto line = static_cast<Exact>(axis == 0 ? c.i : c.j);
        const Exact low = line - margin, high = line + 1 + margin;
        if (from == to) {
            if (from < low || from > high) return false;
            continue;
        }
        t_in = std::max(t_in, std::min((low - from) / (to - from), (high - from) / (to - from)));
        t_out = std::min(t_out, std::max((low - from) / (to - from), (high - from) / (to - from)));
    }
    return t_in <= t_out;
}

TEST_CASE("candidate_walker: on numbers that are not exact it errs by less than a billionth of a cell",
          "[walker][law]") {
    using Exact = long double;
    Random random{48};
    std::size_t visited = 0;
    for (int n = 0; n < 20'000; ++n) {
        const double far = n % 4 == 0 ? 1e7 : 0;
        const glm::dvec2 origin{far + random.between(-100, 100), far + random.between(-100, 100)};
        const glm::dvec2 spacing{random.between(0.1, 30), random.between(0.1, 30)};
        const Lattice lattice{origin, spacing};
        const CellRange range{{random.whole(-5, 0), random.whole(-5, 0)},
                              {random.whole(1, 8), random.whole(1, 8)}};
        const auto point = [&] {
            double u = random.between(-8, 10), v = random.between(-8, 10);
            if (random.one_in(6)) u = std::floor(u); // on a line, as far as numbers go
            if (random.one_in(6)) v = std::floor(v);
            return glm::dvec2{origin.x + u * spacing.x, origin.y + v * spacing.y};
        };
        const glm::dvec2 a = point();
        glm::dvec2 b = point();
        if (random.one_in(8)) b.x = a.x;
        if (random.one_in(8)) b.y = a.y;

        const auto spans = walked(lattice, range, a, b);
        visited += spans.size();
        CAPTURE(n, a.x, a.y, b.x, b.y, origin.x, origin.y, spacing.x, spacing.y);
        REQUIRE(out_of_order(spans, range) == "");

        const auto meets = [&](Cell c, Exact margin) {
            return meets_grown(origin, spacing, a, b, c, margin);
        };
        // Positions of 1e7 m are known to 2e-9 m; grid lines are asked for to no better.
        const Exact margin =
            far > 0 ? 1e-9L + 4e-9L / static_cast<Exact>(std::min(spacing.x, spacing.y)) : 1e-9L;
        for (Index j = range.begin.j; j < range.end.j; ++j) {
            for (Index i = range.begin.i; i < range.end.i; ++i) {
                const bool found = std::any_of(spans.begin(), spans.end(), [&](const CellSpan& s) {
                    return s.cell == Cell{i, j};
                });
                CAPTURE(i, j);
                if (found ? !meets({i, j}, margin) : meets({i, j}, -margin)) {
                    FAIL((found ? "invented" : "missed"));
                }
            }
        }
    }
    CHECK(visited > 50'000);
}

TEST_CASE("candidate_walker: lines computed as origin plus a multiple of the spacing are lines",
          "[walker][hard]") {
    // 0.1 and 1/3 are no doubles and neither are most of their multiples; the product rounds the same here and there.
    for (const double spacing : {0.1, 1.0 / 3, 0.7, 49.0, 1e-3, 30.48}) {
        const Lattice lattice{{0, 0}, {spacing, spacing}};
        for (Index n = -3000; n <= 3000; n += 7) {
            const double line = static_cast<double>(n) * spacing;
            const auto spans =
                walked(lattice, CellRange::endless(), {line, 0.25 * spacing}, {line, 0.75 * spacing});
            CAPTURE(spacing, n);
            REQUIRE(spans.size() == 2);
            CHECK(spans[0].cell == Cell{n - 1, 0});
            CHECK(spans[1].cell == Cell{n, 0});
        }
    }
}

TEST_CASE("candidate_walker: a segment that ends on the border is inside to its end",
          "[walker][regression]") {
    // From 0.3 and the like the last crossing was found at 1 − 2⁻⁵³, and the end of the segment off the grid.
    Random random{50};
    const Lattice lattice{{-30, 12.5}, {10, 2.5}};
    const CellRange range{{0, 0}, {7, 6}};
    for (int n = 0; n < 20'000; ++n) {
        // Digits below those of x + 30, which is therefore rounded.
        const glm::dvec2 a{random.between(-1, 1), random.between(12.5, 27.5)};
        const double x = n % 2 == 0 ? 40 : -30, y = n % 3 == 0   ? 27.5
                                                    : n % 3 == 1 ? 12.5
                                                                 : random.between(12.5, 27.5);
        const auto spans = walked(lattice, range, a, {x, y});
        REQUIRE_FALSE(spans.empty());
        REQUIRE(spans.back().t_out == 1);
        REQUIRE(spans.back().out.x == (n % 2 == 0 ? 1 : 0));
        const auto in = walked(lattice, range, {x, y}, a);
        REQUIRE(in.front().t_in == 0);
        REQUIRE(in.front().in.x == (n % 2 == 0 ? 1 : 0));
    }
}

TEST_CASE("candidate_walker: displacements too small to invert are walked all the same", "[walker][hard]") {
    constexpr double tiny = 1e-310; // 1/tiny is infinite
    const CellRange range{{-2, -2}, {3, 3}};
    CHECK(walked({}, range, {0, 0.5}, {tiny, 0.5}).size() == 2);
    CHECK(walked({}, range, {tiny, 0.5}, {0, 0.5}).size() == 2);
    CHECK(walked({}, range, {-tiny, 0.5}, {tiny, 0.5}).size() == 2);
    CHECK(walked({}, range, {0, 0.5}, {tiny, 1.5}).size() == 3); // (−1, 0) is touched at the start only
    CHECK(out_of_order(walked({}, range, {0, 0}, {tiny, tiny}), range) == "");
    CHECK(walked({}, range, {0, 0}, {tiny, tiny}).size() == 4);
    CHECK(out_of_order(walked({}, range, {-tiny, tiny}, {tiny, -tiny}), range) == "");
}

TEST_CASE("candidate_walker: the visitor stops the walk", "[walker]") {
    const CellRange range{{0, 0}, {9, 9}};
    for (const auto& [a, b] : {std::pair<glm::dvec2, glm::dvec2>{{0.5, 0.25}, {8.5, 8.25}},
                               {{0, 0}, {9, 9}},
                               {{3, 0}, {3, 9}},
                               {{3, 3}, {3, 3}},
                               {{9, 2}, {0, 2}}}) {
        const std::size_t all = walked({}, range, a, b).size();
        for (std::size_t stop = 1; stop <= all; ++stop) {
            std::size_t visits = 0;
            hfh::walk_cells({}, range, a, b, [&](const CellSpan&) { return ++visits < stop; });
            CHECK(visits == stop);
        }
    }
}

/// NaN where a corner is a hole.
template <hfh::Real T>
double highest_corner(const hfh::test::Terrain<T>& terrain, Cell cell) {
    double highest = -1e9;
    for (const Index i : {cell.i, cell.i + 1}) {
        for (const Index j : {cell.j, cell.j + 1}) {
            const auto corner = static_cast<double>(terrain.at(i, j));
            highest =
                std::isnan(corner) || std::isnan(highest) ? corner + highest : std::max(highest, corner);
        }
    }
    return highest;
}

TEMPLATE_TEST_CASE(
    "candidate_walker: candidates are the patches whose highest corner the segment does not stay above",
    "[walker][law]", float, double) {
    using T = TestType;
    Random random{49};
    std::size_t passed = 0, refused = 0, holes = 0;
    for (int n = 0; n < 6000; ++n) {
        const WholeLattice whole{{100, -20}, 0.125, {n % 2 == 0 ? 8 : 20, 12}};
        auto terrain = hfh::test::rough_in_steps<T>(9, 8, 16, static_cast<std::uint64_t>(n / 20),
                                                    {whole.origin, whole.lattice().spacing()});
        if (n % 3 == 0) hfh::test::punch_holes(terrain, 6, 5);
        const auto grid = terrain.grid();
        const auto point = [&]() -> WholePoint {
            return {random.whole(-2 * whole.step[0], 10 * whole.step[0]),
                    random.whole(-2 * whole.step[1], 9 * whole.step[1])};
        };
        const WholePoint a = point(), b = n % 10 == 0 ? a : point();
        const double az = random.fraction(-2, 20, 8), bz = n % 4 == 0 ? az : random.fraction(-2, 20, 8);
        const auto p = place(whole, a), q = place(whole, b);
        std::vector<CellSpan> spans;
        bool patches_agree = true;
        hfh::walk_candidates(grid, hfh::vec3<T>{hfh::vec2<T>{p}, T(az)}, hfh::vec3<T>{hfh::vec2<T>{q}, T(bz)},
                             [&](const CellSpan& span, const hfh::BilinearPatch<T>& patch) {
                                 spans.push_back(span);
                                 patches_agree &= patch.p00 == terrain.at(span.cell.i, span.cell.j) &&
                                                  patch.p11 == terrain.at(span.cell.i + 1, span.cell.j + 1);
                                 return true;
                             });
        CHECK(patches_agree);
        for (const ExactSpan& e : hfh::test::exact_cells(whole, grid.cells(), a, b)) {
            CAPTURE(n, e.cell.i, e.cell.j);
            const auto found = std::count_if(spans.begin(), spans.end(),
                                             [&](const CellSpan& s) { return s.cell == e.cell; });
            const double highest = highest_corner(terrain, e.cell);
            if (std::isnan(highest)) {
                ++holes;
                REQUIRE(found == 0);
                continue;
            }
            // z·d in multiples of 1/8, all exact.
            const auto above = [&](Fraction t) {
                return az * static_cast<double>(t.d) + (bz - az) * static_cast<double>(t.n) -
                       highest * static_cast<double>(t.d);
            };
            const double least = std::min(above(e.t_in) / static_cast<double>(e.t_in.d),
                                          above(e.t_out) / static_cast<double>(e.t_out.d));
            // The library's two products and their sum round by 1.5ε of at most 20 m, and the time by ε/2 of 22 m.
            if (std::abs(least) <= 45 * eps && least != 0) continue;
            if (least == 0 && az == bz) continue; // at the height of the corner but for that rounding
            passed += least <= 0;
            refused += least > 0;
            if (least != 0) REQUIRE(found == (least < 0));
        }
    }
    CHECK(passed > 5'000);
    CHECK(refused > 5'000);
    CHECK(holes > 1'000);
}

TEMPLATE_TEST_CASE("candidate_walker: both rays of Figure 5 pass the height test and a higher one does not",
                   "[walker]", float, double) {
    using T = TestType;
    using Point = hfh::vec3<T>;
    const auto terrain = hfh::test::peak<T>(5, 5, 4);
    const auto grid = terrain.grid();
    const auto candidates = [&](Point a, Point b) {
        std::vector<Cell> cells;
        hfh::walk_candidates(grid, a, b, [&](const CellSpan& span, const auto&) {
            cells.push_back(span.cell);
            return true;
        });
        return cells;
    };
    CHECK(candidates(Point{T(1.5), T(1.5), 3}, Point{T(1.5), T(1.5), 0}) == std::vector<Cell>{{1, 1}});
    CHECK(candidates(Point{T(1.25), T(1.25), 3}, Point{T(1.25), T(1.25), 2}) == std::vector<Cell>{{1, 1}});
    CHECK(candidates(Point{T(1.5), T(1.5), 5}, Point{T(1.5), T(1.5), 4.5}).empty());
    // Only the part over the patch counts, not the ends: (0, 1) is flat and 3.1 m below the segment at its lowest.
    CHECK(candidates(Point{T(0.25), T(1.5), 5}, Point{T(1.75), T(1.5), 1}) == std::vector<Cell>{{1, 1}});
    int visits = 0;
    hfh::walk_candidates(grid, Point{0, T(0.5), 0}, Point{4, T(0.5), 0}, [&](const CellSpan&, const auto&) {
        ++visits;
        return visits < 2;
    });
    CHECK(visits == 2);
}
