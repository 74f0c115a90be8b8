#include "catch.hpp"
#include "support/reference.hpp"
#include "support/terrains.hpp"
#include "support/watchdog.hpp"
#if defined(HFH_TOUCH_TERRAIN)
#include "apps/touch_terrain_files.hpp"
#endif

#include <hfh/hfh.hpp>

#include <array>
#include <cmath>
#include <limits>

// What fuzzing and other attacks from outside found, each with its digits.

using namespace hfh;
using namespace hfh::test;

TEST_CASE("proxy_tracker: a stylus that rests on a steep edge does not use up the work",
          "[proxy_tracker][regression]") {
    // Contact, release and a new contact at the same point: once without end.
    auto made = plane<double>(4, 3, 0, {.spacing = {0.1, 0.1}});
    made.at(2, 0) = made.at(3, 1) = 12.8;
    const auto grid = made.grid();
    ProxyTracker tracker{grid};
    (void)tracker.update({0.2, 0.075000000000000011, 3.1999999999999993});
    const auto contact = tracker.update({0.20000000000000009, 0.075000000000000011, 3.1999999999999993});
    CHECK(contact.patches < 100);
    CHECK((contact.status == ContactStatus::contact || contact.status == ContactStatus::free));
}

TEST_CASE("proxy_tracker: a cast over a peak does not use up the work", "[proxy_tracker][regression]") {
    auto made = plane<float>(12, 6, 0, {.spacing = {0.1, 0.1}});
    made.at(4, 3) = made.at(3, 4) = 0.800000012F;
    made.at(4, 4) = 1.20000005F;
    const auto grid = made.grid();
    ProxyTracker tracker{grid};
    (void)tracker.update({0.041601561F, 0.600000024F, 0.454187006F});
    const auto contact = tracker.update({0.989170849F, 0.103515625F, 1.84870648F});
    CHECK(contact.patches < 100);
    CHECK(contact.status == ContactStatus::free);
}

TEMPLATE_TEST_CASE("proxy_tracker: pressed level into a cliff it pushes back", "[proxy_tracker][regression]",
                   float, double) {
    // 256 cells up per cell. In float the slide along the cliff was below the resolution of the gradient, the offset
    // stayed level, and its z told no side: in contact without a force.
    const auto made = terrain<TestType>(4, 4, [](Index i, Index j) { return (i + j) % 2 == 0 ? 256000 : 0; },
                                        {.spacing = {1000, 1000}});
    const auto grid = made.grid();
    ProxyTracker tracker{grid};
    (void)tracker.update({TestType(1105.46875), TestType(339.84375), TestType(142867.188)});
    const auto contact = tracker.update({TestType(1738.28125), TestType(339.84375), TestType(142867.188)});
    REQUIRE(contact.status == ContactStatus::contact);
    CHECK(contact.depth > 33); // metres; the nearest point is 33.56 away
}

TEMPLATE_TEST_CASE("force_evaluator: a force beyond all numbers is clamped to a finite one",
                   "[force_evaluator][regression]", float, double) {
    // 25 · (max / 25) and 3 · (max / 3) round to infinity.
    const auto depth = static_cast<TestType>(sizeof(TestType) == 4 ? 25 : 3);
    Contact<TestType> contact;
    contact.status = ContactStatus::contact;
    contact.penetration = {TestType(0), TestType(0), depth};
    contact.depth = depth;
    const ForceEvaluator<TestType> force{.stiffness = std::numeric_limits<TestType>::max()};
    CHECK(is_finite(force(contact).newtons));
}

TEST_CASE("global_closest_point: on a cliff of a million cells it is the closest",
          "[global_closest_point][regression]") {
    // Newton's resolution of the gradient on such a cliff is coarser than that of the distance: it was taken for converged,
    // and certified.
    struct {
        WidePatch patch;
        Wide u, v; // a closer point
    } const cases[] = {
        {{-1, 0, 0.080000000000000002L, 80000, 0.031622776601683791L, 0.1333521432163324L},
         0.0072371078346925403L,
         0.0017115396389039337L},
        {{480000, -480000, -480000, 0, 1, 1}, 0.33334680445966186L, 0.33331986166112226L},
        {{10.20703125L, 0, -107, -400000000, 1, 1}, 0.00015939848580130882L, 0.00015976753664221656L},
    };
    for (const auto& [p, u, v] : cases) {
        const auto d = [](Wide x) { return static_cast<double>(x); };
        const BilinearPatch<double> patch{d(p.p00), d(p.p10), d(p.p01), d(p.p11), {d(p.dx), d(p.dy)}};
        const auto found = global_closest_point(patch, CellPoint<double>{0, 0, 0});
        const auto distance = [&, &q = p](Wide at_u, Wide at_v) { return length(q.position(at_u, at_v)); };
        CHECK(distance(static_cast<Wide>(found.u), static_cast<Wide>(found.v)) <=
              distance(u, v) + 1e-12L * p.reach(Point{}));
    }
}

TEST_CASE(
    "global_closest_point: on a cliff whose valley is all but level it is found before intervals run out",
    "[global_closest_point][regression]") {
    // Seen from the corner itself, F has a second and a third derivative of zero along the valley, at (½, ½).
    const BilinearPatch<double> patch{-78000000, 0, 0, 0, {60, 60}};
    const auto found = global_closest_point(patch, CellPoint<double>{0, -0.0001, -19500000});
    CHECK(found.status == GlobalStatus::searched);
    CHECK(found.intervals < 500);
    const WidePatch seen{-78000000 + 19500000, 19500000, 19500000, 19500000, 60, 60};
    const Point offset =
        seen.position(static_cast<Wide>(found.u), static_cast<Wide>(found.v)) - Point{0, -0.006L, 0};
    CHECK(static_cast<double>(length(offset)) <= 42.4304973477);
}

TEMPLATE_TEST_CASE("proxy_tracker: on its way to a stylus on the rim of a hole it is felt",
                   "[proxy_tracker][regression]", float, double) {
    // The hole is on the right of the line on which the stylus is, the surface on the left.
    auto made = terrain<TestType>(8, 4, [](Index i, Index) { return i < 5 ? 3 : i; });
    auto grid = made.grid();
    ProxyTracker tracker{grid, {.max_patches = 1}};
    (void)tracker.update({TestType(5.75), TestType(1.5), TestType(7)});
    REQUIRE(tracker.update({TestType(5.75), TestType(1.5), TestType(2)}).touching());
    made.at(3, 1) = std::numeric_limits<TestType>::quiet_NaN();
    const auto contact = tracker.update({TestType(2), TestType(1), TestType(2)});
    REQUIRE(contact.status == ContactStatus::descent_limit);
    CHECK(contact.depth > 0);
}

TEST_CASE("newton_closest_point: goes to a border that is a denormal away", "[closest_point][regression]") {
    // What such a step gains is no number of float, and it was not taken.
    const BilinearPatch<float> flat{};
    const CellPoint<float> query{0, -0.0109863281F, -0.0109863281F};
    const auto foot = newton_closest_point(flat, query, {2.80259693e-45F, 5.60519386e-45F});
    CHECK(foot.u == 0);
    CHECK(foot.v == 0);
}

TEMPLATE_TEST_CASE("newton_closest_point: a level edge of a steep patch is level",
                   "[closest_point][regression]", float, double) {
    // Along u = 1 nothing rises, so v is the query's. The slope there was the one at u = 0 plus the twist, which had been
    // rounded to the steepness along u.
    const BilinearPatch<TestType> patch{0, -256, TestType(2.25067139e-4), -256, {10, 1}};
    const CellPoint<TestType> query{TestType(-1.8828125), TestType(0.3828125), TestType(-482)};
    const auto foot = newton_closest_point(patch, query, {TestType(1), TestType(0.5)});
    CHECK(foot.u == 1);
    CHECK(std::abs(foot.v - query.v) < 64 * epsilon<TestType>);
}

TEMPLATE_TEST_CASE("newton_closest_point: does not creep up to a grid line along which the patch is level",
                   "[closest_point][regression]", float, double) {
    // A stylus that an encoder put right on a grid line of a ridge: v came nearer to 0 by sixteen digits a step, down to
    // the denormals, and the iterations ran out.
    Random random{5};
    for (int n = 0; n < 20000; ++n) {
        const auto cell = TestType(1e-3);
        const TestType a = TestType(random.between(-1, 1)) * cell, b = TestType(random.between(-1, 1)) * cell;
        const auto across = static_cast<TestType>(random.between(0.1, 0.9)),
                   along = random.one_in(2) ? TestType(0) : static_cast<TestType>(random.unit()),
                   depth = static_cast<TestType>(random.between(0, 3)) * cell;
        const vec2<TestType> start{static_cast<TestType>(random.unit()),
                                   static_cast<TestType>(random.unit())};
        const auto level_v = newton_closest_point(BilinearPatch<TestType>{a, b, a, b, {cell, cell}},
                                                  {across, along, a - depth}, start);
        const auto level_u = newton_closest_point(BilinearPatch<TestType>{a, a, b, b, {cell, cell}},
                                                  {along, across, a - depth}, start);
        if (level_v.v != along || level_u.u != along) FAIL("not over the query in case " << n);
        if (std::max(level_v.iterations, level_u.iterations) > 4) FAIL("too many iterations in case " << n);
    }
}

TEMPLATE_TEST_CASE("descend: does not creep up to a grid line along which the ground is level",
                   "[descent][regression]", float, double) {
    // The same in the loop of its own that descend has.
    Random random{6};
    const auto cell = TestType(1e-3);
    for (int n = 0; n < 20000; ++n) {
        const bool along_x = random.one_in(2);
        TestType samples[3][3];
        for (int k = 0; k < 3; ++k) {
            const TestType height = TestType(random.between(-1, 1)) * cell;
            for (int m = 0; m < 3; ++m) (along_x ? samples[m][k] : samples[k][m]) = height;
        }
        const BilinearGrid<TestType, HeightView<TestType>> grid{HeightView{&samples[0][0], 3, 3},
                                                                {.spacing = {cell, cell}}};
        const auto across = static_cast<TestType>(random.between(0.1, 1.9)) * cell,
                   depth = static_cast<TestType>(random.between(0, 3)) * cell;
        const TestType z = samples[1][1] - depth;
        const SurfacePoint<TestType> start{
            {1, 1}, static_cast<TestType>(random.unit()), static_cast<TestType>(random.unit())};
        const auto end = descend(
            grid, along_x ? vec3<TestType>{across, cell, z} : vec3<TestType>{cell, across, z}, start, 64);
        if (end.status != DescentStatus::minimum) FAIL("no minimum in case " << n);
        if ((along_x ? end.offset.y : end.offset.x) != 0) FAIL("not over the query in case " << n);
    }
}

// Limited work, and numbers at the end of their range.

TEST_CASE("proxy_tracker: a stylus at rest below level ground is felt with max_contact_patches 8",
          "[proxy_tracker][limited][regression]") {
    // The cast from the proxy shared the allowance of the slide and was cut short in every update: no force for ever.
    auto made = plane<double>(26, 49, 0, {.spacing = {0.037022154992908451, 0.037022154992908451}});
    made.at(16, 22) = -0.1;
    made.at(18, 25) = made.at(23, 29) = 1;
    made.at(22, 30) = -0.074;
    made.at(23, 30) = -0.4;
    made.at(22, 31) = -2;
    const double cell = made.frame.spacing.x;
    const auto grid = made.grid();
    for (const int slide : {1, 2, 4, 8, 8192}) {
        CAPTURE(slide);
        ProxyTracker tracker{grid, {.max_contact_patches = slide}};
        (void)tracker.update({0, 0, 0});
        (void)tracker.update({0.56, 0.8, 0});
        REQUIRE(tracker.update({0.8, 1, -2}).touching());
        const vec3<double> rest{0.9, 1.25, -0.05}; // 1.35 cells below level ground
        int unfelt = 0;
        Contact<double> contact;
        for (int k = 0; k < 300; ++k) {
            contact = tracker.update(rest);
            unfelt += !(contact.touching() && contact.depth > 0);
        }
        CHECK(unfelt == 0);
        REQUIRE(contact.status == ContactStatus::contact);
        CHECK(contact.depth / cell > 1);
        CHECK(contact.depth / cell < 2.5);
    }
}

TEMPLATE_TEST_CASE(
    "proxy_tracker: a stylus dragged below a spur of the Spanish Peaks is felt with max_contact_patches 8",
    "[proxy_tracker][limited][regression]", float, double) {
    // 28 samples of examples/data/spanish_peaks.png as if 10 m apart. Moved to 50 m below the ground, the stylus lost its
    // force for an update, and got it back with a jump.
    const std::array<short, 28> samples{2693, 2705, 2743, 2715, 2716, 2682, 2715, 2743, 2759, 2699,
                                        2692, 2712, 2833, 2745, 2682, 2758, 2865, 2795, 2786, 2804,
                                        2870, 2850, 2821, 2804, 2893, 2865, 2846, 2826};
    const HeightView view{samples.data(), 4, 7};
    const BilinearGrid<TestType, HeightView<short>> grid{view, {.spacing = {10, 10}}};
    for (const int slide : {1, 2, 4, 8, 8192}) {
        CAPTURE(slide);
        ProxyTracker tracker{grid, {.max_contact_patches = slide}};
        (void)tracker.update({TestType(16), TestType(11), TestType(2706)});
        REQUIRE(tracker.update({TestType(15.75), TestType(28.5), TestType(2657)}).touching());
        for (int k = 0; k < 100; ++k) {
            const auto contact = tracker.update({TestType(16.5), TestType(46), TestType(2764.25)});
            REQUIRE(contact.touching());
            REQUIRE(contact.depth > 0);
        }
    }
}

TEST_CASE("proxy_tracker: a search that is cut short remembers that it was leaving the released face",
          "[proxy_tracker][limited][regression]") {
    // It began again on that face, took it for what lies beyond, and came to a force where unlimited work comes to none.
    struct Case {
        SurfaceKind surface;
        int max_contact_patches;
        std::array<float, 16> samples;
        std::vector<vec3<float>> way;
    };
    const std::array<Case, 3> cases{
        Case{SurfaceKind::sheet,
             2,
             {0, 0, -2048, 0, 0, 0, 0, 0, 0, 0, 8192, 0, 0, 256, 0, 0},
             {{1.734375F, 1.703125F, 9000}, {0.3125F, 2.59375F, 34.125F}, {1.859375F, 0.578125F, 37.75F}}},
        Case{SurfaceKind::solid,
             1,
             {0, 64, 0, 0, 0, -256, 0, 0, 0, 4096, 0, 0, -4096, 0, 0, 0},
             {{0.09375F, 0.453125F, 9000},
              {1.203125F, 1.046875F, -41},
              {2.96875F, 0.328125F, 18.75F},
              {0.734375F, 2.8125F, -15.375F}}},
        Case{SurfaceKind::solid,
             2,
             {0, 0, 0, 0, 0, 0, 2048, 0, 0, -1024, 0, 0, 0, 0, -128, 0},
             {{2.453125F, 1.703125F, 9000},
              {0.421875F, 0.71875F, 20.125F},
              {1.828125F, 0.71875F, -35.25F},
              {2.28125F, 2.3125F, -8.25F}}}};
    for (const auto& [surface, limit, samples, way] : cases) {
        CAPTURE(surface, limit);
        const HeightView view{samples.data(), 4, 4};
        const BilinearGrid<float, HeightView<float>> grid{view, {.spacing = {1, 1}}};
        ProxyTracker unlimited{grid, {.surface = surface}};
        ProxyTracker limited{grid, {.surface = surface, .max_contact_patches = limit}};
        Contact<float> free, held;
        for (const auto& stylus : way) {
            for (int n = 0; n < 200; ++n) free = unlimited.update(stylus), held = limited.update(stylus);
        }
        CHECK(held.status == free.status);
        CHECK(held.depth == Approx(free.depth));
    }
}

TEMPLATE_TEST_CASE(
    "proxy_tracker: a stylus that rests on the surface itself comes to an end with max_patches 1",
    "[proxy_tracker][limited][regression]", float, double) {
    // Where products are fused with sums it was released and caught again for ever: distances that are roundings of u and v
    // were told apart.
    using T = TestType;
    const auto made = terrain<T>(14, 25, [](Index i, Index j) { return (i + j) % 2 == 0 ? 0.0 : 3.23e-5; },
                                 {.spacing = {0.00365, 0.0045}});
    const auto grid = made.grid();
    Random random{151};
    int unsettled = 0;
    for (int n = 0; n < 4000; ++n) {
        ProxyTracker tracker{grid, {.max_patches = 1, .max_contact_patches = 26}};
        const Cell cell{random.whole(2, 10), random.whole(2, 20)};
        const T u = static_cast<T>(random.unit()), v = static_cast<T>(random.unit());
        const vec3<T> on{(static_cast<T>(cell.i) + u) * T(0.00365), (static_cast<T>(cell.j) + v) * T(0.0045),
                         grid.patch(cell)->height(u, v)};
        (void)tracker.update({on.x, on.y, T(1e-3)});
        (void)tracker.update({on.x, on.y, T(-1e-5)});
        Contact<T> rest;
        for (int k = 0; k < 100; ++k) rest = tracker.update(on);
        unsettled += rest.status == ContactStatus::descent_limit || rest.status == ContactStatus::sweep_limit;
    }
    CHECK(unsettled == 0);
}

TEST_CASE("proxy_tracker: drawn away from a steep ridge there is no force", "[proxy_tracker][regression]") {
    // The segment from the released minimum on the ridge began an ulp of its x on the other side, where the ridge is so steep
    // that this counted as outside, and came in again on the ridge: in contact for good, and pulled.
    const double dx = 0.0022107679347780824, dy = 0.013706174951271039;
    auto made = plane<double>(17, 17, 0, {{-1.1807494885709968, 11.285513818940505}, {dx, dy}});
    made.at(0, 13) = 0.021865410915206194, made.at(0, 14) = -0.10229496262569766;
    made.at(1, 13) = -0.063950355686006252, made.at(1, 14) = 0.11290256132083265;
    made.at(2, 13) = 0.02429600176034372, made.at(2, 14) = -0.047416898104964383;
    const auto grid = made.grid();
    ProxyTracker tracker{grid};
    tracker.restore({.stylus = {-1.1785, 11.473, 0.05},
                     .proxy = {{1, 13}, 0.01, 0.7},
                     .side = Side::above,
                     .phase = TrackerPhase::contact});
    for (int k = 0; k < 3; ++k) {
        const auto away = tracker.update({-1.0945295391146521, 11.354042109706899, 0.070218287972116961});
        CHECK_FALSE(away.touching());
        CHECK(away.depth == 0);
    }
}

TEMPLATE_TEST_CASE("proxy_tracker: beside a cliff level ground is level", "[proxy_tracker][regression]",
                   float, double) {
    // The cliff's bounds of rounding held the proxy on the grid line, though the level patch leads on. On level ground a
    // force has no tangential part.
    using T = TestType;
    for (const double cliff : {10.0, 30.0, 100.0, 253.0, 1000.0, 1e4, 1e5}) {
        auto made = plane<T>(5, 3);
        made.at(2, 1) = static_cast<T>(cliff);
        const auto grid = made.grid();
        ProxyTracker tracker{grid};
        (void)tracker.update({T(3), T(0), T(1)});
        (void)tracker.update({T(3), T(0), T(-0.01)});
        T worst = 0;
        for (int k = 1; k < 900; ++k) {
            const auto contact = tracker.update({T(3), static_cast<T>(k * 1e-3), T(-0.01)});
            if (!contact.touching()) FAIL("not touching in step " << k);
            worst = std::max(worst, std::abs(contact.penetration.y));
        }
        CAPTURE(cliff);
        CHECK(worst <= 16 * epsilon<T>);
    }
}

TEMPLATE_TEST_CASE("proxy_tracker: heights whose squares overflow are holes, and update returns",
                   "[proxy_tracker][limited][regression]", float, double) {
    // A sample that is a raster's "no data", and that nobody declared. Comparisons with infinity kept a loop going.
    using T = TestType;
    const Watchdog watchdog{"update among heights at the end of the range"};
    const bool single = sizeof(T) == 4;
    const double limit = single ? 0x1p31 : 0x1p255;
    const double top = static_cast<double>(std::numeric_limits<T>::max());
    for (const double size :
         {top, 0.5 * top, 4 * limit, 2 * limit, limit, single ? 1e20 : 1e300, single ? 32768e30 : 1e77}) {
        for (const double sign : {-1.0, 1.0}) {
            CAPTURE(size, sign);
            const auto bad = static_cast<T>(sign * size);
            const std::array<std::array<T, 9>, 2> heights{
                {{2, 0, 2, 0, bad, 2, 2, 0, 1}, {1, 0, 0, 2, bad, 2, 1, 0, 2}}};
            for (const auto& h : heights) {
                const HeightView view{h.data(), 3, 3};
                const BilinearGrid<T, HeightView<T>> grid{view, {}};
                for (Index j = 0; j < 2; ++j) {
                    for (Index i = 0; i < 2; ++i) CHECK_FALSE(grid.patch({i, j}));
                }
                for (const auto surface : {SurfaceKind::solid, SurfaceKind::sheet}) {
                    ProxyTracker tracker{grid, {.surface = surface}};
                    for (const vec3<T>& p : {vec3<T>{T(1.5), T(1.25), 4}, vec3<T>{T(1.75), 2, T(-1.5)},
                                             vec3<T>{T(0.5), T(0.5), 4}, vec3<T>{0, T(0.75), -2}}) {
                        const auto contact = tracker.update(p);
                        CHECK(is_finite(contact.normal));
                        CHECK(is_finite(contact.penetration));
                        CHECK(contact.status == ContactStatus::off_surface);
                    }
                }
            }
        }
    }
    // Just below the limit it is a height like any other.
    const auto high = static_cast<T>(std::nextafter(static_cast<T>(limit), T(0)));
    const std::array<T, 9> mountain{0, 0, 0, 0, high, 0, 0, 0, 0};
    const HeightView view{mountain.data(), 3, 3};
    CHECK(BilinearGrid<T, HeightView<T>>{view, {}}.patch({0, 0}));
}

TEMPLATE_TEST_CASE("proxy_tracker: at rest on level ground with a fold it does not use up the work",
                   "[proxy_tracker][limited][regression]", float, double) {
    // A cast that hit at t = 0, a proxy that moved by one rounding, and that counted as nearer: all of max_patches in
    // every update.
    using T = TestType;
    auto made = plane<T>(20, 20, 0, {.spacing = {0.23822777808514814, 0.23822777808514814}});
    made.at(19, 18) = T(-0.0038471512962132692);
    made.at(18, 19) = T(-0.004);
    const auto grid = made.grid();
    for (const int slide : {1, 8, 8192}) {
        CAPTURE(slide);
        ProxyTracker tracker{grid, {.max_contact_patches = slide}};
        (void)tracker.update({T(4.522), T(4.29), T(0)});
        (void)tracker.update({T(4.52), T(4.29), T(-0.01)});
        const vec3<T> rest{T(4.5218014717102051), T(4.2881002426147461), T(-0.003774052020162344)};
        Contact<T> contact;
        int most = 0;
        for (int k = 0; k < 64; ++k) {
            contact = tracker.update(rest);
            most = std::max(most, contact.patches);
        }
        CHECK(most < 100);
        CHECK((contact.status == ContactStatus::contact || contact.status == ContactStatus::free));
    }
}

TEMPLATE_TEST_CASE("proxy_tracker: does not pass through a ridge inside one patch",
                   "[proxy_tracker][regression]", float, double) {
    // A step was judged by its end alone: between, the distance rises, and every point of the ridge u = v is farther from
    // the stylus than the proxy was. The force came out sideways reversed.
    using T = TestType;
    const auto made = terrain<T>(5, 5, [](Index i, Index j) { return (i + j) % 2 != 0 ? 3 : 0; });
    const auto grid = made.grid();
    ProxyTracker tracker{grid};
    Contact<T> contact;
    for (const vec3<T>& p :
         {vec3<T>{T(2.7), T(3.5), T(4)}, vec3<T>{T(2.7), T(3.5), T(0.3)}, vec3<T>{T(3.0), T(3.2), T(0.5)},
          vec3<T>{T(3.3), T(2.9), T(0.7)}, vec3<T>{T(3.6), T(2.6), T(0.9)}}) {
        contact = tracker.update(p);
    }
    REQUIRE(contact.status == ContactStatus::contact);
    REQUIRE(contact.point.cell == Cell{3, 2});
    CHECK(contact.point.u == Approx(0.2766).margin(1e-3)); // where a gradient flow ends
    CHECK(contact.point.v == Approx(0.8234).margin(1e-3));
    CHECK(contact.penetration.x < 0);
}

TEST_CASE("first_hit: in pieces it gets on from within a rounding of a grid line",
          "[first_hit][limited][regression]") {
    // Far from the origin t > 0 need not move a position: a + t·(b − a) rounded to a, and the search stayed there.
    const auto made = plane<double>(
        4, 6, 0, {.origin = {3288212.13400849, -2859186.2775840047}, .spacing = {0.11283421412367896, 1}});
    const auto grid = made.grid();
    const glm::dvec3 start{3288212.2468427042, -2859184.2775840047, 1},
        end{3288212.15, -2859184.2775840047, -1};
    for (const Index cells : {1, 2, 3, 4, 100}) {
        CAPTURE(cells);
        glm::dvec3 from = start;
        FirstHitOptions options{.max_cells = cells};
        FirstHit<double> hit;
        int pieces = 0;
        for (; pieces < 100; ++pieces) {
            hit = first_hit(grid, from, end, options);
            if (hit.status != HitStatus::cell_limit) break;
            from += hit.t * (end - from);
            options.side = hit.side;
        }
        CHECK(hit.status == HitStatus::hit);
        CHECK(pieces < 16);
    }
    for (const int patches : {1, 2, 3, 4, 8192}) { // the same through the tracker
        CAPTURE(patches);
        ProxyTracker tracker{grid, {.max_patches = patches}};
        (void)tracker.update(start);
        Contact<double> contact;
        for (int k = 0; k < 100; ++k) contact = tracker.update(end);
        CHECK(contact.status == ContactStatus::contact);
        CHECK(contact.depth == Approx(1));
    }
}

#if defined(HFH_TOUCH_TERRAIN)
TEST_CASE("touch_terrain: refuses a header's spacing that makes no grid", "[touch_terrain][regression]") {
    // Finite and above zero, and yet 1/dx or dx·dy is no number: the demo ran and felt nothing.
    const touch_terrain_tests::Folder folder;
    for (const std::string spacing : {"CELLSIZE 1e-320", "CELLSIZE 1e200", "XDIM 1e-200\nYDIM 1e-200"}) {
        CAPTURE(spacing);
        folder.text("t.hdr", "NROWS 2\nNCOLS 2\n" + spacing + "\n");
        folder.text("t.bil", "abcd");
        folder.text("p.csv", "t,x,y,z\n0,0,0,200\n1,0,0,0\n");
        CHECK(folder.run("t.bil --path p.csv").code == 2);
    }
}
#endif

TEMPLATE_TEST_CASE("proxy_tracker: ground that is lowered under a stylus resting on it lets the stylus go",
                   "[proxy_tracker][edits][regression]", float, double) {
    using T = TestType;
    // A stylus on the surface but for roundings can come to rest at a minimum that holds it on no side. Lowered ground is
    // farther away, and that minimum was still taken for the one that had been reached.
    Random random{416};
    int rested = 0;
    for (int n = 0; n < 2000; ++n) {
        auto ground = rough<T>(6, 4, 10, static_cast<std::uint64_t>(n + 1), {.spacing = {10, 10}});
        const auto grid = ground.grid();
        ProxyTracker tracker{grid};
        const T x = static_cast<T>(random.between(5, 45)), y = static_cast<T>(random.between(5, 25));
        (void)tracker.update({x, y, T(99)});
        const auto touched = tracker.update({x, y, T(-9)});
        const bool within =
            touched.proxy.x > 1 && touched.proxy.x < 49 && touched.proxy.y > 1 && touched.proxy.y < 29;
        if (!touched.touching() || !within) continue; // slid off the rim, or to it
        (void)tracker.update(touched.proxy);
        rested += tracker.update(touched.proxy).touching();
        for (T& height : ground.heights) height -= 1;
        CHECK(tracker.update(touched.proxy).status == ContactStatus::free);
    }
    CHECK(rested > 100);
}

TEMPLATE_TEST_CASE("proxy_tracker: ground that is edited while a descent is under way is looked at anew",
                   "[proxy_tracker][edits][regression]", float, double) {
    using T = TestType;
    // The descent went on as if the ground were still what it had seen of it, and ended where a patch led down.
    Random random{417};
    int edited = 0, arrived = 0;
    for (int n = 0; n < 3000; ++n) {
        auto ground = rough<T>(12, 11, 30, static_cast<std::uint64_t>(n + 1));
        const auto grid = ground.grid();
        const TrackerOptions little{.max_patches = static_cast<int>(random.whole(1, 6)),
                                    .max_contact_patches = static_cast<int>(random.whole(1, 6))};
        ProxyTracker tracker{grid, little};
        const auto over = [&](double z) {
            return vec3<T>{static_cast<T>(random.between(3, 8)), static_cast<T>(random.between(3, 7)),
                           static_cast<T>(z)};
        };
        (void)tracker.update(over(99));
        const auto inside = over(random.between(-20, 10));
        auto contact = tracker.update(inside);
        for (int k = 0; k < 60; ++k) {
            if (contact.status == ContactStatus::descent_limit) {
                const Cell near = contact.point.cell;
                ground.at(near.i + static_cast<Index>(random.whole(0, 1)),
                          near.j + static_cast<Index>(random.whole(0, 1))) +=
                    static_cast<T>(random.between(-20, 40));
                ++edited;
            }
            contact = tracker.update(inside);
            if (contact.status != ContactStatus::contact) continue;
            ++arrived;
            const Surface<T> surface{ground};
            CHECK(surface.template fall<T>({contact.point.cell.i, contact.point.cell.j,
                                            static_cast<Wide>(contact.point.u),
                                            static_cast<Wide>(contact.point.v)},
                                           wide(inside)) <= 64);
            break;
        }
    }
    CHECK(edited > 500);
    CHECK(arrived > 500);
}

TEMPLATE_TEST_CASE("proxy_tracker: after an edit that takes the ground away a contact is on a patch",
                   "[proxy_tracker][edits][limited][regression]", float, double) {
    using T = TestType;
    // While the way from a released minimum was searched, the contact stayed where there was no patch any more.
    Random random{418};
    int edited = 0;
    for (int n = 0; n < 3000; ++n) {
        auto ground = rough<T>(12, 11, 30, static_cast<std::uint64_t>(n + 1));
        const auto grid = ground.grid();
        const TrackerOptions little{.max_patches = static_cast<int>(random.whole(1, 6)),
                                    .max_contact_patches = static_cast<int>(random.whole(1, 6))};
        ProxyTracker tracker{grid, little};
        const auto over = [&](double z) {
            return vec3<T>{static_cast<T>(random.between(1, 10)), static_cast<T>(random.between(1, 9)),
                           static_cast<T>(z)};
        };
        (void)tracker.update(over(99));
        auto stylus = over(random.between(-20, 20));
        auto contact = tracker.update(stylus);
        for (int k = 0; k < 60; ++k) {
            const bool takes_away = tracker.state().phase == TrackerPhase::releasing;
            if (takes_away) {
                const Cell gone = contact.point.cell;
                ground.at(gone.i, gone.j) = std::numeric_limits<T>::quiet_NaN();
                ++edited;
            }
            if (!takes_away && random.one_in(4)) stylus = over(random.between(-20, 20));
            contact = tracker.update(stylus);
            if (contact.touching()) CHECK(grid.patch(contact.point.cell));
            if (takes_away) break;
        }
    }
    CHECK(edited > 100);
}
