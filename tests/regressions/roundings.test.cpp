#include "catch.hpp"
#include "support/random.hpp"
#include "support/reference.hpp"
#include "support/terrains.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/traversal/descent.hpp>
#include <hfh/traversal/first_hit.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

// Where one number more than is needed to tell two places apart is lost: what fuzzing found.

using namespace hfh;
using namespace hfh::test;

namespace {

/// How steeply F falls at the end of a descent, in roundings.
template <Real T>
[[nodiscard]] Wide fall_at(const Terrain<T>& ground, const SurfacePoint<T>& end, const vec3<T>& query) {
    return Surface<T>{ground}.template fall<T>(wide(end), wide(query));
}

} // namespace

TEMPLATE_TEST_CASE("descend: far above or below level ground it goes on until no patch leads down",
                   "[descent][regression]", float, double) {
    using T = TestType;
    // The square of the distance is all height there, and a step of a cell less than its rounding. After eight of them the
    // point had arrived, wherever it was.
    Random random{9};
    const double deepest = sizeof(T) == 4 ? 3e5 : 3e11;
    int arrived = 0;
    for (int n = 0; n < 600; ++n) {
        // Level, tilted by next to nothing, or with bumps.
        const double tilt = n % 3 == 1 ? 15 / deepest : 0;
        auto ground = tilted_plane<T>(40, 40, tilt * random.between(-1, 1), tilt * random.between(-1, 1));
        if (n % 3 == 2) {
            for (int bump = 0; bump < 9; ++bump) {
                ground.at(static_cast<Index>(random.whole(1, 38)), static_cast<Index>(random.whole(1, 38))) =
                    static_cast<T>(random.between(-1, 1));
            }
        }
        const auto grid = ground.grid();
        const double away = deepest * std::exp(random.between(-6, 0)) * (random.one_in(2) ? 1 : -1);
        const vec3<T> query{static_cast<T>(random.between(1, 38)), static_cast<T>(random.between(1, 38)),
                            static_cast<T>(away)};
        const SurfacePoint<T> start{
            {static_cast<Index>(random.whole(0, 38)), static_cast<Index>(random.whole(0, 38))},
            static_cast<T>(random.unit()),
            static_cast<T>(random.unit())};
        const auto found = descend(grid, query, start, 8192);
        if (found.status != DescentStatus::minimum) continue;
        ++arrived;
        CAPTURE(n, query.x, query.y, query.z, found.point.cell.i, found.point.cell.j);
        CHECK(fall_at(ground, found.point, query) <= 64);
        // In pieces it comes to the same.
        DescentProgress<T> progress;
        SurfacePoint<T> at = start;
        auto piece = hfh::detail::descend_on(grid, query, at, 1, progress);
        for (int pieces = 0; piece.status == DescentStatus::work_limit && pieces < 8192; ++pieces)
            piece = hfh::detail::descend_on(grid, query, at = piece.point, 1, progress);
        CHECK(piece.status == DescentStatus::minimum);
        CHECK(fall_at(ground, piece.point, query) <= 64);
    }
    CHECK(arrived > 300);
}

TEMPLATE_TEST_CASE("descend: a start that is a denormal length from a grid line is no minimum",
                   "[descent][regression]", float, double) {
    using T = TestType;
    // What a step to the line gains is no number, and none was taken.
    Random random{10};
    int arrived = 0;
    for (int n = 0; n < 2000; ++n) {
        const double relief = std::exp(random.between(-6, 5));
        auto ground = rough<T>(8, 8, relief, static_cast<std::uint64_t>(n + 1));
        if (random.one_in(2)) { // or squares of saddles
            for (Index j = 0; j < 8; ++j) {
                for (Index i = 0; i < 8; ++i) ground.at(i, j) = static_cast<T>((i + j) % 2 == 0 ? relief : 0);
            }
        }
        const auto grid = ground.grid();
        const auto hair = [&] {
            return static_cast<T>(random.whole(1, 3)) * std::numeric_limits<T>::denorm_min();
        };
        const auto share = [&] { return static_cast<T>(random.unit()); };
        const bool along_u = random.one_in(2);
        const SurfacePoint<T> start{
            {static_cast<Index>(random.whole(0, 6)), static_cast<Index>(random.whole(0, 6))},
            along_u ? hair() : share(),
            along_u ? share() : hair()};
        const vec3<T> query{static_cast<T>(random.between(0, 7)), static_cast<T>(random.between(0, 7)),
                            static_cast<T>(relief * random.between(-0.5, 1.5))};
        const auto found = descend(grid, query, start, 8192);
        if (found.status != DescentStatus::minimum) continue;
        ++arrived;
        CAPTURE(n, found.point.u, found.point.v);
        CHECK(fall_at(ground, found.point, query) <= 64);
    }
    CHECK(arrived > 1500);
}

TEMPLATE_TEST_CASE("descend: from a minimum it goes nowhere", "[descent][regression]", float, double) {
    using T = TestType;
    // How far a slope changes along a step is rounded as the steeper of the two slopes, and counts as often as the query is
    // deep. A step that seemed to lead to a minimum along the gentle slope ended beside it, and at rest the proxy moved on.
    Random random{12};
    int arrived = 0;
    for (int n = 0; n < 40'000; ++n) {
        const double steep = random.between(0.3, 3), gentle = steep * std::exp2(-random.between(2, 9)),
                     deep = std::exp2(random.between(2, 9));
        const bool along_x = random.one_in(2);
        const auto ground = tilted_plane<T>(3, 3, along_x ? steep : gentle, along_x ? gentle : steep);
        const auto grid = ground.grid();
        const auto share = [&] { return static_cast<T>(random.between(0.1, 0.9)); };
        // Below a point of the cell, along the normal but for an angle.
        const Cell cell{random.whole(0, 1), random.whole(0, 1)};
        const auto patch = *grid.patch(cell);
        const T u = share(), v = share();
        const vec3<T> query =
            vec3<T>{static_cast<T>(cell.i) + u, static_cast<T>(cell.j) + v, patch.height(u, v)} -
            static_cast<T>(deep) * patch.normal(u, v);
        const auto found = descend(grid, query, {cell, share(), share()}, 8192);
        if (found.status != DescentStatus::minimum) continue;
        ++arrived;
        const auto again = descend(grid, query, found.point, 8192);
        CAPTURE(n, steep, gentle, deep, found.point.u, found.point.v);
        CHECK(again.status == DescentStatus::minimum);
        CHECK(again.point.cell == found.point.cell);
        CHECK(again.point.u == found.point.u);
        CHECK(again.point.v == found.point.v);
    }
    CHECK(arrived > 20'000);
}

TEMPLATE_TEST_CASE("proxy_tracker: on its way to a stylus on the rim of a hole it is felt at any spacing",
                   "[proxy_tracker][limited][regression]", float, double) {
    using T = TestType;
    // The grid line on which the stylus is, times the inverse of the spacing, was not a whole number of cells, and the cell
    // on that side was the hole.
    Random random{11};
    int on_the_way = 0, unfelt = 0;
    for (int n = 0; n < 4000; ++n) {
        const auto spacing = widen(static_cast<T>(std::exp(random.between(-6, 3))));
        const Index line = static_cast<Index>(random.whole(18, 40));
        const auto x = static_cast<T>(static_cast<double>(line) * spacing);
        // A valley with steep sides, whose faces do not hold the stylus.
        auto made = terrain<T>(60, 4,
                               [&](Index i, Index) {
                                   return 2 * spacing *
                                          static_cast<double>(std::max<Index>(std::abs(i - line) - 3, 0));
                               },
                               {.spacing = {spacing, spacing}});
        if (static_cast<double>(x) != static_cast<double>(line) * spacing)
            continue; // not on it in this scalar
        const auto grid = made.grid();
        const T y = static_cast<T>(1.5 * spacing), up = static_cast<T>(40 * spacing),
                down = static_cast<T>(-spacing / 2);
        const double side = n % 2 == 0 ? 1 : -1;
        const T far = static_cast<T>((static_cast<double>(line) + 16.5 * side) * spacing);
        ProxyTracker tracker{grid, {.max_patches = 1}};
        (void)tracker.update({far, y, up});
        (void)tracker.update({far, y, static_cast<T>(20 * spacing)});
        // The hole is on the other side of the line.
        made.at(n % 2 == 0 ? line - 1 : line + 1, 1) = std::numeric_limits<T>::quiet_NaN();
        const auto contact = tracker.update({x, y, down});
        if (contact.status != ContactStatus::descent_limit) continue;
        ++on_the_way;
        unfelt += !(contact.depth > 0);
    }
    CHECK(on_the_way > 100);
    CHECK(unfelt == 0);
}

TEMPLATE_TEST_CASE("first_hit: a segment that does not get off a cliff hits it where it left it",
                   "[first_hit][regression]", float, double) {
    using T = TestType;
    // From a cliff to the edge at its top: the hit was at the edge, far above the end of the segment, and a proxy at rest
    // went away from its stylus.
    auto ground = plane<T>(5, 5, 204);
    ground.at(1, 0) = -216;
    ground.at(1, 1) = 108;
    const auto grid = ground.grid();
    for (const double reach : {1e-5, 1e-4, 1e-3, 1e-2}) {
        for (const double y : {0.0, 0.25, 0.5}) {
            CAPTURE(reach, y);
            const double top = 204, below = reach * widen(grid.patch({1, 0})->slope_u(static_cast<T>(y)));
            using F = PlaceScalar<T>;
            const vec3<F> from{glm::dvec3{2 - reach, y, top - below}}, to{glm::dvec3{2, y, top - below}};
            const auto hit = first_hit(grid, from, to,
                                       {.surface = SurfaceKind::sheet,
                                        .side = Side::above,
                                        .leaves_within = static_cast<F>(below / 8)});
            REQUIRE(hit.status == HitStatus::hit);
            const auto patch = widen(*grid.patch(hit.point.cell));
            const glm::dvec3 met{static_cast<double>(hit.point.cell.i) + widen(hit.point.u),
                                 static_cast<double>(hit.point.cell.j) + widen(hit.point.v),
                                 patch.height(widen(hit.point.u), widen(hit.point.v))};
            CHECK(glm::distance(met, widen(to)) <= glm::distance(widen(from), widen(to)) + below / 8);
        }
    }
}

TEMPLATE_TEST_CASE(
    "proxy_tracker: a search that is cut short where its way grazes a crest ends as one search does",
    "[proxy_tracker][limited][regression]", float, double) {
    using T = TestType;
    // It went on from where it had come to, rounded, and so met a crest that the whole way touches and does not cross: in
    // contact for good, where one search finds nothing.
    Random random{11};
    int cut_short = 0;
    for (int n = 0; n < 3000; ++n) {
        const auto ground = terrain<T>(12, 6, [&](Index, Index) {
            return random.one_in(4) ? static_cast<double>(random.whole(0, 3)) : 0.0;
        });
        const auto grid = ground.grid();
        const auto place = [&](std::int64_t lowest, std::int64_t highest) {
            return vec3<T>{static_cast<T>(random.fraction(1, 10, 3)),
                           static_cast<T>(random.fraction(1, 4, 3)),
                           static_cast<T>(random.whole(lowest, highest))};
        };
        const vec3<T> start = place(1, 5), end = place(0, 3);
        ProxyTracker unlimited{grid};
        (void)unlimited.update(start);
        (void)unlimited.update(end);
        const auto whole = unlimited.update(end);
        for (int patches = 1; patches <= 6; ++patches) {
            CAPTURE(n, patches, start.x, start.y, start.z, end.x, end.y, end.z);
            ProxyTracker tracker{grid, {.max_patches = patches}};
            (void)tracker.update(start);
            auto contact = tracker.update(end);
            for (int k = 0; k < 100; ++k) {
                cut_short += contact.status == ContactStatus::sweep_limit;
                contact = tracker.update(end);
            }
            CHECK(contact.status == whole.status);
            CHECK(static_cast<double>(glm::distance(contact.proxy, whole.proxy)) < 1e-5);
        }
    }
    CHECK(cut_short > 5'000);
}

TEST_CASE("descend: from a hair off a border it comes to the border, not nearer by parts",
          "[descent][regression]") {
    // What a step of 10⁻¹⁷ cells gains is below the rounding of what any other promises: those along the valley took it a
    // third of the way each time, 64 steps an update for some thirty updates.
    constexpr double heights[3][3]{{0.07597195014210528, 0.04693455238971965, -0.046216091437395364},
                                   {-0.15103413519584083, 0.09308933634872203, -0.12787781108361365},
                                   {-0.05714792016245612, 0.0753574957167502, 0.05900291715981051}};
    const auto made = terrain<double>(3, 3, [&](Index i, Index j) { return heights[j][i]; },
                                      {.spacing = {1, 0.11180009221317322}});
    const auto grid = made.grid();
    const auto end = descend(grid, glm::dvec3{0.4140625, 0.86645071465209245, 0.93039936728735051},
                             SurfacePoint<double>{{0, 0}, 0.4140625, 8.2366170350916584e-18}, 100);
    CHECK(end.status != DescentStatus::work_limit);
    CHECK(end.patches < 20);
}

TEST_CASE("first_hit: a segment that runs along the border outside of the grid has left the surface",
          "[first_hit][regression]") {
    // Its start on the border was rounded to outside, where there is no patch to get off. At its end on the corner it still
    // counted as leaving, on the side of ten cells before, and so hit what is far below it.
    const auto ground = plane<double>(7, 14, 0);
    const auto grid = ground.grid();
    const glm::dvec3 start{std::nextafter(6.0, 7.0), 2.25, 0}, end{6, 13, 15};
    for (const SurfaceKind surface : {SurfaceKind::solid, SurfaceKind::sheet}) {
        const auto hit =
            first_hit(grid, start, end, {.surface = surface, .side = Side::below, .leaves_within = 1e-12});
        CHECK(hit.status == HitStatus::miss);
        CHECK(hit.side == Side::above);
    }
}

TEST_CASE("descend_no_farther: along a bent valley it comes no farther from the query",
          "[descent][regression]") {
    // Not the step along the valley's floor was shortened but the straight line to its end, which leads up the valley's side.
    constexpr double heights[2][2]{{8.2794544916243975, 3.3831581515455433e-05},
                                   {3.2232977153773299e-06, 3.0393333330548119e-06}};
    const glm::dvec2 spacing{0.0042765592005626083};
    const auto ground = terrain<double>(
        2, 2, [&](Index i, Index j) { return heights[j][i]; },
        {.origin = glm::dvec2{3.5220814028318586, -2.2141446155334319} + spacing, .spacing = spacing});
    const auto grid = ground.grid();
    const glm::dvec3 stylus{3.5281788407545358, -2.2080471776107546, 2.7299713283348042};
    SurfacePoint<double> at{{0, 0}, 0.26723039912780333, 0.55002534470182041};
    double last = glm::length(descend(grid, stylus, at, 0).offset);
    const double first = last;
    for (int n = 0; n < 400; ++n) {
        const auto found = hfh::detail::descend_no_farther(grid, stylus, at, 64, 0.0005393112015390862);
        const double distance = glm::length(found.offset);
        CAPTURE(n);
        CHECK(distance <= last);
        last = distance;
        at = found.point;
    }
    CHECK(last < first / 2);
}

TEMPLATE_TEST_CASE("proxy_tracker: a proxy on the border is searched from in its own cell",
                   "[proxy_tracker][regression]", float, double) {
    using T = TestType;
    // Rounded to outside, the way to a stylus on the border led along the surface and not over it: the side was decided
    // afresh at its end, and a stylus below the corner was buried.
    Random random{13};
    int released = 0;
    for (int n = 0; n < 4000; ++n) {
        const double dx = random.between(0.001, 0.1);
        const auto ground = terrain<T>(6, 5, [&](Index, Index) { return dx * random.between(-4, 4); },
                                       {.spacing = glm::dvec2{dx}});
        const auto grid = ground.grid();
        const glm::dvec2 corner = dx * glm::dvec2{5, 4};
        const double below = static_cast<double>(ground.at(5, 4)) - dx * random.between(0.1, 3);
        ProxyTracker tracker{grid};
        (void)tracker.update({static_cast<T>(dx * random.between(3, 5)),
                              static_cast<T>(dx * random.between(1, 3)), static_cast<T>(5 * dx)});
        const auto at = [&](double row) {
            return vec3<T>{static_cast<T>(corner.x), static_cast<T>(row), static_cast<T>(below)};
        };
        // Down beside the border, and along it to the corner.
        (void)tracker.update({static_cast<T>(corner.x * 0.97), static_cast<T>(dx * random.between(1, 3)),
                              static_cast<T>(below)});
        if (!tracker.state().touching()) continue;
        // Rounded to outside, as a place or seen from the cell.
        const auto lattice = grid.lattice();
        const vec3<PlaceScalar<T>> end{at(corner.y)};
        const auto seen = lattice.locate(at(corner.y), {4, 3});
        if (lattice.u_of(end.x, 4) > 1 || lattice.v_of(end.y, 3) > 1 || seen.u > 1 || seen.v > 1) continue;
        const auto contact = tracker.update(at(corner.y));
        ++released;
        CAPTURE(n, dx, to_string(contact.status));
        CHECK(contact.touching());
    }
    CHECK(released > 500);
}
