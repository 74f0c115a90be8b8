#include "catch.hpp"
#include "support/real_terrains.hpp"
#include "support/reference.hpp"
#include "support/scenes.hpp"

#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/force_evaluator.hpp>

using namespace hfh;
using namespace hfh::test;

namespace {

struct WideSlopes {
    Wide x = 0, y = 0;
};

Point scaled(Wide by, const Point& p) { return {by * p.x, by * p.y, by * p.z}; }

/// The slopes at vertex (i, j) straight from the definition: the mean over the patches that meet there of the slopes
/// of their edges that end there.
template <Real T>
std::optional<WideSlopes> vertex_slopes(const Surface<T>& surface, Index i, Index j) {
    WideSlopes sum;
    int patches = 0;
    for (const Index n : {j - 1, j}) {
        for (const Index m : {i - 1, i}) {
            const auto p = surface.patch(m, n);
            if (!p) continue;
            ++patches;
            sum.x += p->along_u(n == j ? Wide(0) : Wide(1)) / p->dx;
            sum.y += p->along_v(m == i ? Wide(0) : Wide(1)) / p->dy;
        }
    }
    if (patches == 0) return {};
    return WideSlopes{sum.x / patches, sum.y / patches};
}

template <Real T>
WideSlopes wide_slopes(const Surface<T>& surface, const WideSurfacePoint& at) {
    WideSlopes sum;
    for (const Index b : {0, 1}) {
        for (const Index a : {0, 1}) {
            const auto vertex = vertex_slopes(surface, at.i + a, at.j + b);
            const Wide weight = (a == 1 ? at.u : 1 - at.u) * (b == 1 ? at.v : 1 - at.v);
            sum.x += weight * vertex->x, sum.y += weight * vertex->y;
        }
    }
    return sum;
}

/// The steepest edge of the cells around, which bounds what a rounding can do.
template <Real T>
Wide steepest(const Surface<T>& surface, Index i, Index j) {
    Wide most = 0;
    for (Index n = j - 1; n <= j + 1; ++n) {
        for (Index m = i - 1; m <= i + 1; ++m) {
            if (const auto p = surface.patch(m, n)) {
                const Wide height = std::max(std::abs(p->lowest()), std::abs(p->highest()));
                most = std::max(most, height / std::min(p->dx, p->dy));
            }
        }
    }
    return most;
}

/// The largest change of the slopes over one cell, in the cells around two that are near each other.
template <Real T>
double spread(const Surface<T>& surface, Cell a, Cell b) {
    Wide most = 0;
    for (Index j = std::min(a.j, b.j); j <= std::max(a.j, b.j) + 1; ++j) {
        for (Index i = std::min(a.i, b.i); i <= std::max(a.i, b.i) + 1; ++i) {
            const auto here = vertex_slopes(surface, i, j);
            for (const auto& there : {vertex_slopes(surface, i + 1, j), vertex_slopes(surface, i, j + 1)}) {
                if (here && there) most = std::max(most, std::hypot(there->x - here->x, there->y - here->y));
            }
        }
    }
    return static_cast<double>(2 * most); // along u and along v together
}

} // namespace

TEMPLATE_TEST_CASE("shaded_slopes: are the means at the vertices, interpolated", "[force_shading][law]",
                   float, double) {
    using T = TestType;
    Random random{81};
    for (const bool holes : {false, true}) {
        for (auto& scene : scenes<T>()) {
            if (holes) punch_holes(scene.terrain, 12, 82);
            const Surface<T> surface{scene.terrain};
            const auto grid = scene.terrain.grid();
            int there = 0;
            for (int n = 0; n < 2000; ++n) {
                const SurfacePoint<T> at{
                    {random.whole(-1, scene.terrain.columns), random.whole(-1, scene.terrain.rows)},
                    static_cast<T>(random.one_in(4) ? double(random.whole(0, 1)) : random.unit()),
                    static_cast<T>(random.one_in(4) ? double(random.whole(0, 1)) : random.unit())};
                const auto slopes = shaded_slopes(grid, at);
                CAPTURE(scene.name, holes, at.cell.i, at.cell.j);
                REQUIRE(slopes.has_value() == surface.patch(at.cell.i, at.cell.j).has_value());
                if (!slopes) continue;
                ++there;
                const auto wanted = wide_slopes(surface, wide(at));
                const Wide tolerance =
                    16 * static_cast<Wide>(epsilon<T>) * steepest(surface, at.cell.i, at.cell.j);
                CHECK(std::abs(static_cast<Wide>(slopes->x) - wanted.x) <= tolerance);
                CHECK(std::abs(static_cast<Wide>(slopes->y) - wanted.y) <= tolerance);
            }
            CHECK(there > 100);
        }
    }
}

/// At three points of its east edge and its north edge, and at the vertex between, cell (i, j) has the slopes of its
/// neighbours.
template <class Grid, Real T>
void check_seams(const Grid& grid, Index i, Index j, T s) {
    const bool has_east = grid.patch({i + 1, j}).has_value(), has_north = grid.patch({i, j + 1}).has_value();
    for (const T along : {T(0), s, T(1)}) {
        const auto east = shaded_slopes(grid, {{i, j}, T(1), along});
        const auto north = shaded_slopes(grid, {{i, j}, along, T(1)});
        if (has_east) CHECK(*east == *shaded_slopes(grid, {{i + 1, j}, T(0), along}));
        if (has_north) CHECK(*north == *shaded_slopes(grid, {{i, j + 1}, along, T(0)}));
    }
    const auto corner = shaded_slopes(grid, {{i, j}, T(1), T(1)});
    if (grid.patch({i + 1, j + 1})) CHECK(*corner == *shaded_slopes(grid, {{i + 1, j + 1}, T(0), T(0)}));
}

TEMPLATE_TEST_CASE("shaded_slopes: agree to the bit wherever patches meet", "[force_shading][law]", float,
                   double) {
    using T = TestType;
    Random random{83};
    for (const bool holes : {false, true}) {
        for (auto& scene : scenes<T>()) {
            if (holes) punch_holes(scene.terrain, 12, 84);
            const auto grid = scene.terrain.grid();
            CAPTURE(scene.name, holes);
            for (Index j = 0; j + 1 < scene.terrain.rows; ++j) {
                for (Index i = 0; i + 1 < scene.terrain.columns; ++i) {
                    if (grid.patch({i, j})) check_seams(grid, i, j, static_cast<T>(random.unit()));
                }
            }
        }
    }
}

TEMPLATE_TEST_CASE("shade_force: on a plane nothing changes but roundings, on level ground nothing at all",
                   "[force_shading]", float, double) {
    using T = TestType;
    Random random{85};
    const auto level = plane<T>(9, 9, 2), tilted = tilted_plane<T>(9, 9, 0.5, -1.5);
    const auto level_grid = level.grid(), tilted_grid = tilted.grid();
    for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
        ProxyTracker on_level{level_grid, {.surface = kind}}, on_tilted{tilted_grid, {.surface = kind}};
        static_cast<void>(on_level.update({T(4), T(4), T(20)}));
        static_cast<void>(on_tilted.update({T(4), T(4), T(20)}));
        for (int n = 0; n < 500; ++n) {
            const T x = static_cast<T>(random.between(2, 6)), y = static_cast<T>(random.between(2, 6));
            const auto a = on_level.update({x, y, T(1.75)});
            const auto shaded_a = shade_force(level_grid, a);
            CHECK(shaded_a.penetration == a.penetration);
            CHECK(shaded_a.normal == a.normal);
            const auto b = on_tilted.update({x, y, T(0.5) * x - T(1.5) * y - T(0.25)});
            const auto shaded_b = shade_force(tilted_grid, b);
            REQUIRE(b.touching());
            CHECK(glm::length(shaded_b.penetration - b.penetration) <= 64 * epsilon<T>);
            CHECK(glm::length(shaded_b.normal - b.normal) <= 8 * epsilon<T>);
        }
    }
}

TEMPLATE_TEST_CASE(
    "shade_force: turns the force along the shaded normal, not into the face, keeps depth and proxy",
    "[force_shading]", float, double) {
    using T = TestType;
    Random random{86};
    for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
        for (const double sign : {1.0, -1.0}) {
            if (kind == SurfaceKind::solid && sign < 0) continue;
            int touching = 0, leaning = 0;
            for (const auto& scene : scenes<T>()) {
                const Surface<T> surface{scene.terrain};
                const auto grid = scene.terrain.grid();
                ProxyTracker tracker{grid, {.surface = kind}};
                const glm::dvec2 low = scene.terrain.low(), size = scene.terrain.high() - low;
                static_cast<void>(
                    tracker.update({static_cast<T>(low.x + size.x / 2), static_cast<T>(low.y + size.y / 2),
                                    static_cast<T>(1000 * sign)}));
                for (int n = 0; n < 500; ++n) {
                    const T x = static_cast<T>(low.x + size.x * random.between(0.1, 0.9));
                    const T y = static_cast<T>(low.y + size.y * random.between(0.1, 0.9));
                    const auto z = surface.height(static_cast<Wide>(x), static_cast<Wide>(y));
                    const auto contact =
                        tracker.update({x, y, static_cast<T>(*z - Wide(sign * random.between(-0.1, 0.5)))});
                    const auto shaded = shade_force(grid, contact);
                    CHECK(shaded.status == contact.status);
                    CHECK(shaded.depth == contact.depth);
                    CHECK(shaded.proxy == contact.proxy);
                    if (!contact.touching()) {
                        CHECK(shaded.normal == contact.normal);
                        CHECK(shaded.penetration == contact.penetration);
                        continue;
                    }
                    ++touching;
                    const auto slopes = wide_slopes(surface, wide(contact.point));
                    const Wide out = contact.side == Side::below ? -1 : 1;
                    const Wide steepness = out * std::sqrt(1 + slopes.x * slopes.x + slopes.y * slopes.y);
                    const Point mean{-slopes.x / steepness, -slopes.y / steepness, 1 / steepness};
                    const Point face = wide(contact.normal);
                    const Wide off = dot(mean, face);
                    // Not into the face: a mean normal that leans so far lies in the face.
                    const Point along = mean - scaled(off, face);
                    const Point wanted = off < 0 ? scaled(1 / length(along), along) : mean;
                    leaning += off < 0;
                    CHECK(shaded.shaded);
                    CHECK(dot(wide(shaded.penetration), face) >=
                          -8 * static_cast<Wide>(epsilon<T>) * static_cast<Wide>(contact.depth));
                    const Wide tolerance =
                        16 * static_cast<Wide>(epsilon<T>) *
                        (1 + steepest(surface, contact.point.cell.i, contact.point.cell.j));
                    CHECK(length(wide(shaded.normal) - wanted) <= tolerance);
                    const Wide depth = static_cast<Wide>(contact.depth);
                    const Point push{depth * wanted.x, depth * wanted.y, depth * wanted.z};
                    CHECK(length(wide(shaded.penetration) - push) <= tolerance * depth);
                    // The evaluator gives stiffness times depth, as before, in another direction.
                    const ForceEvaluator<T> force{.stiffness = T(100), .max_force = T(20)};
                    CHECK(length(wide(force(shaded).newtons)) ==
                          Approx(static_cast<double>(length(wide(force(contact).newtons))))
                              .epsilon(16 * double(epsilon<T>)));
                    CHECK(force(shaded).clamped == force(contact).clamped);
                }
            }
            CHECK(touching > 1000);
            CHECK(leaning > 10);
        }
    }
}

namespace {

/// A stroke in steps of 1/512 cell, shallow, so that the proxy goes on about as fast as the hand: the direction of
/// the true force turns at a crease by the crease's angle, the shaded one by (change of slope over a cell) · step.
template <Real T>
void check_that_direction_does_not_jump(const std::string& name, const Terrain<T>& ground) {
    const Surface<T> surface{ground};
    const auto grid = ground.grid();
    const glm::dvec2 middle = (ground.low() + ground.high()) / 2.0, cell = ground.frame.spacing;
    ProxyTracker tracker{grid};
    double largest_true = 0, over = 0;
    vec3<T> before_true{T(0)}, before{T(0)};
    SurfacePoint<T> last{};
    int compared = 0;
    for (int n = -1; n < 6 * 512; ++n) {
        // Through vertices, along edges and across cells.
        const double s = std::max(n, 0) / 512.0;
        const double x = middle.x + cell.x * s, y = middle.y + cell.y * (s < 2   ? s
                                                                         : s < 4 ? 2
                                                                                 : 2 + 0.3 * (s - 4));
        const double z = static_cast<double>(*surface.height(static_cast<Wide>(x), static_cast<Wide>(y)));
        const auto contact = tracker.update(
            {static_cast<T>(x), static_cast<T>(y), static_cast<T>(n < 0 ? z + cell.x : z - 0.02 * cell.x)});
        const auto shaded = shade_force(grid, contact);
        if (contact.touching() && before != vec3<T>{T(0)}) {
            ++compared;
            const double turn = static_cast<double>(glm::length(shaded.normal - before));
            largest_true =
                std::max(largest_true,
                         static_cast<double>(glm::length(contact.penetration / contact.depth - before_true)));
            // |n(a) − n(b)| ≤ |slopes(a) − slopes(b)|, and over a cell these change by the spread of its vertices.
            const double moved = std::hypot(
                double(contact.point.cell.i - last.cell.i) + double(contact.point.u) - double(last.u),
                double(contact.point.cell.j - last.cell.j) + double(contact.point.v) - double(last.v));
            over = std::max(over, turn - spread(surface, contact.point.cell, last.cell) * moved);
        }
        if (contact.touching()) {
            before = shaded.normal, before_true = contact.penetration / contact.depth, last = contact.point;
        }
    }
    CAPTURE(name, largest_true, over);
    CHECK(compared > 3000);
    CHECK(over <=
          64 * double(epsilon<T>) * (1 + static_cast<double>(steepest(surface, last.cell.i, last.cell.j))));
    if (name == "rough") CHECK(largest_true > 0.5); // unshaded it jumps
}

} // namespace

TEMPLATE_TEST_CASE("shade_force: where a stroke crosses an edge or a vertex the direction does not jump",
                   "[force_shading][law]", float, double) {
    using T = TestType;
    check_that_direction_does_not_jump<T>("hills", hills<T>(20, 20, 2, 7));
    check_that_direction_does_not_jump<T>("rough", rough_in_steps<T>(20, 20, 1, 5));
}

TEMPLATE_TEST_CASE("shade_force: nor does it jump on real terrains", "[force_shading][law][real]", float,
                   double) {
    on_real_terrains_or_skip<TestType>(real_terrains_without_holes,
                                       check_that_direction_does_not_jump<TestType>);
}

TEMPLATE_TEST_CASE("shade_force: leaves a contact alone whose ground is gone or too steep for numbers",
                   "[force_shading]", float, double) {
    using T = TestType;
    const T huge = std::numeric_limits<T>::max() / 8;
    auto ground = terrain<T>(4, 4, [=](Index i, Index) { return i == 1 ? static_cast<double>(huge) : 0.0; });
    const auto grid = ground.grid();
    Contact<T> contact;
    contact.status = ContactStatus::contact;
    contact.penetration = {T(0), T(0), T(0.25)};
    contact.depth = T(0.25);
    contact.point = {{1, 1}, T(0.5), T(0.5)};
    CHECK(shade_force(grid, contact).penetration == contact.penetration);
    ground.remove(1, 1);
    CHECK(shade_force(grid, contact).penetration == contact.penetration);
    contact.point.cell = {-5, 99};
    CHECK(shade_force(grid, contact).penetration == contact.penetration);
    static_assert(noexcept(shade_force(grid, contact)));
}
