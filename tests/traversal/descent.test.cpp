#include "catch.hpp"
#include "support/reference.hpp"
#include "support/scenes.hpp"

#include <hfh/traversal/descent.hpp>

using namespace hfh;
using namespace hfh::test;

namespace {

constexpr int plenty = 1 << 20; // patches: no limit for these terrains

template <Real T>
std::string describe(const SurfacePoint<T>& s, const vec3<T>& q) {
    return "from cell " + std::to_string(s.cell.i) + ' ' + std::to_string(s.cell.j) + " at " + digits(s.u) +
           ' ' + digits(s.v) + ", query " + digits(q.x) + ' ' + digits(q.y) + ' ' + digits(q.z);
}

/// What is wrong with the end of a descent, seen from outside; empty if nothing is.
template <Real T>
std::string fault(const Surface<T>& surface, const SurfacePoint<T>& start, const vec3<T>& query,
                  const DescentResult<T>& end) {
    const WideSurfacePoint at = wide(end.point);
    const Point q = wide(query);
    if (!(at.u >= 0 && at.u <= 1 && at.v >= 0 && at.v <= 1)) return "outside the cell";
    if (!surface.patch(at.i, at.j)) return "on no patch";
    // A computed change of F errs by no more than its derivatives do over one cell; this over all patches passed.
    Wide scale = 0;
    for (const auto& s : {wide(start), at}) {
        const auto k = slopes(*surface.patch(s.i, s.j), s.u, s.v, surface.seen_from(q, s.i, s.j));
        scale = std::max(scale, k.scale_u + k.scale_v);
    }
    const Wide eps = static_cast<Wide>(epsilon<T>);
    if (surface.half_square(at, q) > surface.half_square(wide(start), q) + 16 * eps * scale) return "went up";
    if (end.status == DescentStatus::work_limit) return "ran out of work";
    const Wide fall = surface.template fall<T>(at, q);
    if (fall > 64) return "a patch leads down: " + std::to_string(static_cast<double>(fall)) + " ulp-scales";
    // Offset and normal belong to that point: a few roundings of position, height and slopes.
    const Point offset = surface.position(at) - q;
    if (length(wide(end.offset) - offset) > 16 * surface.blur(at, q, eps))
        return "offset is not of the point";
    const Point n = surface.normal(at);
    if (length(wide(end.normal) - n) > 32 * eps) return "normal is not the average";
    return {};
}

/// A surface point anywhere on the grid, often on an edge or at a vertex.
template <Real T>
SurfacePoint<T> any_point(Random& random, const Terrain<T>& t) {
    const auto parameter = [&] {
        return random.one_in(4) ? T(random.whole(0, 1)) : static_cast<T>(random.unit());
    };
    SurfacePoint<T> s;
    s.cell = {random.whole(0, t.columns - 2), random.whole(0, t.rows - 2)};
    s.u = parameter();
    s.v = parameter();
    return s;
}

/// A query near (x, y) of the surface point, `far` cells away to the side and `deep` cells up or down.
template <Real T>
vec3<T> query_near(Random& random, const Surface<T>& surface, const SurfacePoint<T>& s, double far,
                   double deep) {
    const Point p = surface.position(wide(s));
    const double cell = std::sqrt(static_cast<double>(surface.dx() * surface.dy()));
    const double angle = random.between(0, 6.283185307);
    return {static_cast<T>(double(p.x) + far * cell * std::cos(angle)),
            static_cast<T>(double(p.y) + far * cell * std::sin(angle)),
            static_cast<T>(double(p.z) + deep * cell)};
}

} // namespace

TEMPLATE_TEST_CASE("descend: the distance never rises and no patch at its end leads further down",
                   "[descent][law][eq:10]", float, double) {
    using T = TestType;
    Random random{21};
    int most = 0;
    for (const auto& scene : scenes<T>()) {
        const auto grid = scene.terrain.grid();
        const Surface<T> surface{scene.terrain};
        int wrong = 0;
        for (int n = 0; n < 4000 && wrong < 3; ++n) {
            const auto start = any_point(random, scene.terrain);
            const double far = random.one_in(3) ? 0.5 * random.unit() : 8 * random.unit();
            const double deep = 0.01 * std::pow(2000, random.unit()) * (random.one_in(4) ? 1 : -1);
            const auto query = query_near(random, surface, start, far, deep);
            const auto end = descend(grid, query, start, plenty);
            most = std::max(most, end.patches);
            const std::string what = fault(surface, start, query, end);
            if (!what.empty()) {
                ++wrong;
                INFO(scene.name << ", " << describe(start, query) << ": end in cell " << end.point.cell.i
                                << ' ' << end.point.cell.j << " at " << digits(end.point.u) << ' '
                                << digits(end.point.v) << ", status " << int(end.status) << ", patches "
                                << end.patches);
                CHECK(what == "");
            }
        }
    }
    CAPTURE(most);
    CHECK(most < 2000); // a descent over the whole diagonal, three neighbours a step, is 200
}

TEMPLATE_TEST_CASE("descend: ends in the minimum that a gradient flow in small steps ends in",
                   "[descent][law]", float, double) {
    // Like a hand: the query wanders by up to half a cell per update, 0.01 to 2 cells below the surface; each descent
    // starts where the last one ended, and so does the flow.
    using T = TestType;
    Random random{22};
    int updates = 0, other = 0;             // relief up to a few cells
    int updates_rough = 0, other_rough = 0; // relief of 16 cells: the hand jumps over peaks at every update
    for (const auto& scene : scenes<T>()) {
        const bool roughest = std::string{"roughest"} == scene.name;
        const auto grid = scene.terrain.grid();
        const Surface<T> surface{scene.terrain};
        int shown = 0;
        for (int stroke = 0; stroke < 20; ++stroke) {
            auto at = any_point(random, scene.terrain);
            const double deep = -0.01 * std::pow(200, random.unit());
            double heading = random.between(0, 6.283185307);
            Point ground = surface.position(wide(at));
            for (int n = 0; n < 40; ++n) {
                heading += random.between(-0.5, 0.5);
                const double step = 0.5 * random.unit();
                ground.x += static_cast<Wide>(step * std::cos(heading)) * surface.dx();
                ground.y += static_cast<Wide>(step * std::sin(heading)) * surface.dy();
                const auto z = surface.height(ground.x, ground.y);
                if (!z) break;
                const vec3<T> query{static_cast<T>(ground.x), static_cast<T>(ground.y),
                                    static_cast<T>(double(*z) + deep)};
                const auto end = descend(grid, query, at, plenty);
                if (end.status != DescentStatus::minimum) break;
                const auto flowed = surface.flow(wide(at), wide(query));
                ++(roughest ? updates_rough : updates);
                if (!surface.same_basin(wide(end.point), flowed, wide(query))) {
                    ++(roughest ? other_rough : other);
                    if (!roughest && shown++ < 3) {
                        UNSCOPED_INFO(scene.name
                                      << ", " << describe(at, query) << ": descent to " << end.point.cell.i
                                      << ' ' << end.point.cell.j << " at " << digits(end.point.u) << ' '
                                      << digits(end.point.v) << ", flow to " << flowed.i << ' ' << flowed.j
                                      << " at " << double(flowed.u) << ' ' << double(flowed.v)
                                      << "; half squares "
                                      << double(surface.half_square(wide(end.point), wide(query))) << ' '
                                      << double(surface.half_square(flowed, wide(query))));
                    }
                }
                at = end.point;
            }
        }
    }
    CAPTURE(updates, other, updates_rough, other_rough);
    CHECK(other * 1000 <= updates);
    CHECK(other_rough * 25 <= updates_rough);
    CHECK(updates > 4000);
}

TEMPLATE_TEST_CASE("descend: from a vertex it takes the way that leads down most steeply", "[descent]", float,
                   double) {
    // Where several of the patches at a vertex lead down, the flow goes the steepest way; so does the descent. The two
    // measure steepness differently (along the patch's edges, and in any direction), so a few differ.
    using T = TestType;
    Random random{26};
    int starts = 0, other = 0;
    for (const auto& scene : scenes<T>()) {
        const auto grid = scene.terrain.grid();
        const Surface<T> surface{scene.terrain};
        for (int n = 0; n < 300; ++n) {
            SurfacePoint<T> start;
            start.cell = {random.whole(1, scene.terrain.columns - 3),
                          random.whole(1, scene.terrain.rows - 3)};
            start.u = T(random.whole(0, 1));
            start.v = T(random.whole(0, 1));
            const auto query =
                query_near(random, surface, start, 0.25 * random.unit(), 0.25 * random.between(-1, 1));
            const auto end = descend(grid, query, start, plenty);
            const auto flowed = surface.flow(wide(start), wide(query));
            ++starts;
            other += !surface.same_basin(wide(end.point), flowed, wide(query));
        }
    }
    CAPTURE(starts, other);
    CHECK(other * 80 <= starts);
}

TEMPLATE_TEST_CASE("descend: on a plane it ends at the foot of the perpendicular, however far",
                   "[descent][eq:10]", float, double) {
    using T = TestType;
    // z = 0.5 x − 0.25 y on 64 × 64 cells of 1 m.
    const auto ground = tilted_plane<T>(65, 65, 0.5, -0.25);
    const auto grid = ground.grid();
    Random random{23};
    const double l2 = 1 + 0.25 + 0.0625;
    for (int n = 0; n < 500; ++n) {
        const double x = random.between(4, 60), y = random.between(4, 60), d = random.between(-3, 0.5);
        const double foot_z = 0.5 * x - 0.25 * y;
        const vec3<T> query{static_cast<T>(x - 0.5 * d), static_cast<T>(y + 0.25 * d),
                            static_cast<T>(foot_z + d)};
        const auto end = descend(grid, query, any_point(random, ground), plenty);
        REQUIRE(end.status == DescentStatus::minimum);
        // Coordinates up to 64 m, rounded a few times each.
        const double tolerance = 64 * 8 * static_cast<double>(epsilon<T>);
        CHECK(std::abs(static_cast<double>(end.point.u) + double(end.point.cell.i) - x) <= tolerance);
        CHECK(std::abs(static_cast<double>(end.point.v) + double(end.point.cell.j) - y) <= tolerance);
        CHECK(std::abs(static_cast<double>(glm::length(end.offset)) - std::abs(d) * std::sqrt(l2)) <=
              tolerance);
    }
}

TEMPLATE_TEST_CASE("descend: in a valley it ends on the crease", "[descent]", float, double) {
    using T = TestType;
    // Walls of slope 1.5 that meet at x = 12. Every query between the walls' perpendiculars there belongs to the crease.
    const auto ground = valley<T>(25, 20, 1.5);
    const auto grid = ground.grid();
    Random random{24};
    for (int n = 0; n < 500; ++n) {
        const double y = random.between(2, 17), z = random.between(-4, -0.5), off = random.between(-0.5, 0.5);
        // Below the crease by −z, aside by less than |z|·1.5.
        const vec3<T> query{static_cast<T>(12 + off * z), static_cast<T>(y), static_cast<T>(z)};
        const auto end = descend(grid, query, any_point(random, ground), plenty);
        REQUIRE(end.status == DescentStatus::minimum);
        CHECK(double(end.point.cell.i) + static_cast<double>(end.point.u) == 12);
        CHECK(std::abs(double(end.point.cell.j) + static_cast<double>(end.point.v) - y) <=
              64 * static_cast<double>(epsilon<T>));
        CHECK(end.normal.x == 0); // the walls' normals average to straight up
        CHECK(end.normal.z == 1);
    }
}

TEMPLATE_TEST_CASE("descend: on a ridge it stays on the side it is on", "[descent]", float, double) {
    using T = TestType;
    // Slopes of 4 to both sides of x = 12. From a query under the west face, below the perpendicular of its edge.
    const auto ground = ridge<T>(25, 20, 4);
    const auto grid = ground.grid();
    // The foot of a query at (x, z) on the west face z = 4 (x − 12): x_foot = (x + 4 (z + 48)) / 17.
    for (const double x : {11.0, 12.0, 12.5, 13.0}) {
        const double z = -12;
        const vec3<T> query{static_cast<T>(x), T(9.25), static_cast<T>(z)};
        const SurfacePoint<T> west{{10, 9}, T(0.5), T(0.25)}, east{{13, 9}, T(0.5), T(0.25)};
        const auto left = descend(grid, query, west, plenty), right = descend(grid, query, east, plenty);
        CAPTURE(x);
        const double foot = (x + 4 * (z + 48)) / 17, mirrored = 24 - (24 - x + 4 * (z + 48)) / 17;
        CHECK(std::abs(double(left.point.cell.i) + static_cast<double>(left.point.u) - foot) <=
              64 * static_cast<double>(epsilon<T>));
        CHECK(std::abs(double(right.point.cell.i) + static_cast<double>(right.point.u) - mirrored) <=
              64 * static_cast<double>(epsilon<T>));
        CHECK(left.normal.x < 0);
        CHECK(right.normal.x > 0);
    }
}

TEMPLATE_TEST_CASE("descend: in a pit and on a peak it ends at the vertex", "[descent]", float, double) {
    using T = TestType;
    const auto hole = pit<T>(9, 9, 2);
    // Straight below a pit, the vertex is the closest point; its four normals average to straight up.
    const vec3<T> below{T(4), T(4), T(-5)};
    for (const SurfacePoint<T>& start :
         {SurfacePoint<T>{{3, 3}, T(0.5), T(0.5)}, SurfacePoint<T>{{4, 4}, T(0.1), T(0.7)},
          SurfacePoint<T>{{4, 3}, T(0), T(1)}, SurfacePoint<T>{{3, 4}, T(1), T(0)}}) {
        const auto end = descend(hole.grid(), below, start, plenty);
        CHECK(end.status == DescentStatus::minimum);
        CHECK(double(end.point.cell.i) + static_cast<double>(end.point.u) == 4);
        CHECK(double(end.point.cell.j) + static_cast<double>(end.point.v) == 4);
        CHECK(end.offset == vec3<T>{0, 0, 3});
        CHECK(std::abs(end.normal.x) <= 2 * epsilon<T>);
        CHECK(std::abs(end.normal.y) <= 2 * epsilon<T>);
    }
    // Above a peak, within the cone of its perpendiculars.
    const auto spike = peak<T>(9, 9, 2);
    const vec3<T> above{T(4.125), T(3.875), T(4)};
    const auto end = descend(spike.grid(), above, {{2, 5}, T(0.5), T(0.5)}, plenty);
    CHECK(end.status == DescentStatus::minimum);
    CHECK(double(end.point.cell.i) + static_cast<double>(end.point.u) == 4);
    CHECK(double(end.point.cell.j) + static_cast<double>(end.point.v) == 4);
    CHECK(end.offset == vec3<T>{T(-0.125), T(0.125), T(-2)});
}

TEMPLATE_TEST_CASE("descend: at the rim of the grid says off_border only if the query is beyond", "[descent]",
                   float, double) {
    using T = TestType;
    const auto flat = plane<T>(9, 9);
    const auto grid = flat.grid();
    const SurfacePoint<T> start{{4, 4}, T(0.5), T(0.5)};
    for (const vec3<T>& beyond :
         {vec3<T>{T(8.25), T(3), T(-1)}, vec3<T>{T(-0.25), T(3), T(-1)}, vec3<T>{T(3), T(9), T(-1)},
          vec3<T>{T(3), T(-1), T(-1)}, vec3<T>{T(12), T(12), T(-1)}, vec3<T>{T(-3), T(10), T(-1)}}) {
        const auto end = descend(grid, beyond, start, plenty);
        CAPTURE(beyond.x, beyond.y);
        CHECK(end.status == DescentStatus::off_border);
        CHECK(double(end.point.cell.i) + static_cast<double>(end.point.u) ==
              std::clamp(double(beyond.x), 0.0, 8.0));
        CHECK(double(end.point.cell.j) + static_cast<double>(end.point.v) ==
              std::clamp(double(beyond.y), 0.0, 8.0));
    }
    for (const vec3<T>& within :
         {vec3<T>{T(8), T(3), T(-1)}, vec3<T>{T(0), T(0), T(-1)}, vec3<T>{T(8), T(8), T(-1)}}) {
        CHECK(descend(grid, within, start, plenty).status == DescentStatus::minimum);
    }
    // On a slope that falls inwards the foot lies beyond the rim while the query does not: pinned, not off.
    const auto slope = tilted_plane<T>(9, 9, 1, 0);
    const auto pinned = descend(slope.grid(), vec3<T>{T(0.5), T(4), T(-2)}, start, plenty);
    CHECK(pinned.status == DescentStatus::minimum);
    CHECK(pinned.point.cell.i == 0);
    CHECK(pinned.point.u == 0);
}

TEMPLATE_TEST_CASE("descend: at the rim of a hole says off_hole only if the query is over it", "[descent]",
                   float, double) {
    using T = TestType;
    auto ground = plane<T>(13, 13);
    ground.remove(6, 6); // no patch over 5..7 × 5..7
    const auto grid = ground.grid();
    const SurfacePoint<T> start{{2, 6}, T(0.5), T(0.5)};
    const auto over = descend(grid, vec3<T>{T(5.5), T(6.5), T(-1)}, start, plenty);
    CHECK(over.status == DescentStatus::off_hole);
    CHECK(double(over.point.cell.i) + static_cast<double>(over.point.u) == 5);
    CHECK(descend(grid, vec3<T>{T(5), T(6.5), T(-1)}, start, plenty).status == DescentStatus::minimum);
    // Around the hole's corner: beyond it along both axes is over the hole; beyond along one is not.
    const SurfacePoint<T> corner{{4, 4}, T(0.5), T(0.5)};
    CHECK(descend(grid, vec3<T>{T(5.25), T(4.75), T(-1)}, corner, plenty).status == DescentStatus::minimum);
    CHECK(descend(grid, vec3<T>{T(4.75), T(5.25), T(-1)}, corner, plenty).status == DescentStatus::minimum);
    // A start without a patch has nothing to slide on.
    CHECK(descend(grid, vec3<T>{T(5.5), T(5.5), T(-1)}, {{5, 5}, T(0.5), T(0.5)}, plenty).status ==
          DescentStatus::off_hole);
}

TEMPLATE_TEST_CASE("descend: at a vertex it sees a hole beside the patch opposite", "[descent]", float,
                   double) {
    using T = TestType;
    // A step at (7, 6) holds the point at (6, 6); south of it and east of the point's patch the ground is missing.
    auto ground = terrain<T>(13, 13, [](Index i, Index j) { return i == 7 && j == 6 ? 4.0 : 0.0; });
    const SurfacePoint<T> start{{5, 5}, T(1), T(1)};
    const vec3<T> query{T(6.25), T(6), T(-1)};
    CHECK(descend(ground.grid(), query, start, plenty).status == DescentStatus::minimum);
    ground.remove(7, 5); // no patch over 6..8 × 4..6
    const auto end = descend(ground.grid(), query, start, plenty);
    CHECK(end.status == DescentStatus::off_hole);
    CHECK(end.point.u == 1);
    CHECK(end.point.v == 1);
}

TEMPLATE_TEST_CASE("descend: at a vertex it sees that the patch opposite is missing", "[descent]", float,
                   double) {
    using T = TestType;
    // Steps at (7, 6) and (6, 7) hold the point at (6, 6); the query is beyond it.
    auto ground = terrain<T>(
        13, 13, [](Index i, Index j) { return (i == 7 && j == 6) || (i == 6 && j == 7) ? 4.0 : 0.0; });
    const SurfacePoint<T> start{{5, 5}, T(1), T(1)};
    const vec3<T> query{T(6.25), T(6.25), T(-1)};
    CHECK(descend(ground.grid(), query, start, plenty).status == DescentStatus::minimum);
    ground.remove(7, 7);
    CHECK(descend(ground.grid(), query, start, plenty).status == DescentStatus::off_hole);
}

TEMPLATE_TEST_CASE("descend: slides along a rim that the query is not beyond, and on", "[descent]", float,
                   double) {
    using T = TestType;
    auto ground = plane<T>(13, 13);
    ground.remove(6, 6);
    const auto grid = ground.grid();
    // Straight ahead lies the hole; the query is behind it. The rim holds the point: past it is not over it.
    const auto end = descend(grid, vec3<T>{T(9.5), T(5.75), T(-1)}, {{2, 5}, T(0.5), T(0.75)}, plenty);
    CHECK(end.status == DescentStatus::off_hole);
    // With the query nearer to the hole's edge row, the way along the rim leads past.
    const auto past = descend(grid, vec3<T>{T(9.5), T(4.5), T(-1)}, {{2, 5}, T(0.5), T(0.75)}, plenty);
    CHECK(past.status == DescentStatus::minimum);
    CHECK(past.offset.x == 0);
    CHECK(past.offset.y == 0);
}

TEMPLATE_TEST_CASE("descend: with its work limited it stops early, no farther, and can go on", "[descent]",
                   float, double) {
    using T = TestType;
    const auto ground = hills<T>(65, 65, 2, 16);
    const auto grid = ground.grid();
    const Surface<T> surface{ground};
    const vec3<T> query{T(50.25), T(40.5), T(-3)};
    const SurfacePoint<T> start{{20, 20}, T(0.5), T(0.5)};
    const auto whole = descend(grid, query, start, plenty);
    REQUIRE(whole.status == DescentStatus::minimum);
    for (const int limit : {1, 2, 4, 5, 8, 32}) {
        CAPTURE(limit);
        SurfacePoint<T> at = start;
        Wide last = surface.half_square(wide(at), wide(query));
        int calls = 0;
        for (; calls < 1000; ++calls) {
            const auto end = descend(grid, query, at, limit);
            CHECK(end.patches <= limit + 8); // those that meet at a point are looked at together
            const Wide now = surface.half_square(wide(end.point), wide(query));
            CHECK(now <= last * (1 + 16 * static_cast<Wide>(epsilon<T>)));
            last = now;
            at = end.point;
            if (end.status != DescentStatus::work_limit) break;
        }
        CHECK(calls > 0);
        CHECK(calls < 1000);
        CHECK(at.cell == whole.point.cell);
        CHECK(std::abs(at.u - whole.point.u) <= 64 * epsilon<T>);
        CHECK(std::abs(at.v - whole.point.v) <= 64 * epsilon<T>);
    }
}

TEMPLATE_TEST_CASE("descend: stays put when started at its own end", "[descent][law]", float, double) {
    using T = TestType;
    Random random{25};
    for (const auto& scene : scenes<T>()) {
        const auto grid = scene.terrain.grid();
        const Surface<T> surface{scene.terrain};
        int wrong = 0;
        for (int n = 0; n < 2000 && wrong < 2; ++n) {
            const auto start = any_point(random, scene.terrain);
            const auto query = query_near(random, surface, start, random.unit(), -3 * random.unit());
            const auto end = descend(grid, query, start, plenty);
            const auto again = descend(grid, query, end.point, plenty);
            if (again.point.cell == end.point.cell && again.point.u == end.point.u &&
                again.point.v == end.point.v) {
                continue;
            }
            ++wrong;
            INFO(scene.name << ", " << describe(end.point, query));
            CHECK(again.point.cell == end.point.cell);
            CHECK(again.point.u == end.point.u);
            CHECK(again.point.v == end.point.v);
        }
    }
}

/// From the middle of a cell to under a point 14 cells on, over ground that rises by `slope` along x or y; `across` is
/// where on the other axis.
template <Real T>
void check_level_across(bool along_x, double slope, double across, bool forth) {
    CAPTURE(along_x, slope, across, forth);
    const auto ground = terrain<T>(20, 20, [&](Index i, Index j) { return slope * double(along_x ? i : j); });
    const auto grid = ground.grid();
    const double to = forth ? 16.25 : 3.25, z = slope * to - 1;
    const Index cell = forth ? 2 : 17;
    const T on = across == 3.0 ? T(0) : T(0.5);
    const SurfacePoint<T> start =
        along_x ? SurfacePoint<T>{{cell, 3}, T(0.5), on} : SurfacePoint<T>{{3, cell}, on, T(0.5)};
    const vec3<T> query = along_x ? vec3<T>{static_cast<T>(to), static_cast<T>(across), static_cast<T>(z)}
                                  : vec3<T>{static_cast<T>(across), static_cast<T>(to), static_cast<T>(z)};
    const auto end = descend(grid, query, start, plenty);
    CHECK(end.status == DescentStatus::minimum);
    CHECK((along_x ? end.offset.y : end.offset.x) == 0);
    // 14 cells on level ground; the foot on a slope lies up to a cell further on. On a line both sides are looked at now
    // and then.
    CHECK(end.patches <= (across == 3.0 ? 28 : 18));
}

TEMPLATE_TEST_CASE("descend: no step is refused along ground that is level across the way", "[descent][law]",
                   float, double) {
    // There a step meets no border across: how far that is, is a quotient 0/0 for a step that begins on it. A step refused
    // counts once more as a patch.
    for (const bool along_x : {true, false}) {
        for (const double slope : {0.0, 0.5, -3.0}) {
            for (const double across : {3.0, 3.5}) { // on a grid line, and beside it
                for (const bool forth : {true, false})
                    check_level_across<TestType>(along_x, slope, across, forth);
            }
        }
    }
}
