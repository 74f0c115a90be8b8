#include "catch.hpp"
#include "support/level_oracle.hpp"
#include "support/numbers.hpp"
#include "support/random.hpp"
#include "support/terrains.hpp"

#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/level_change.hpp>
#include <hfh/device/workspace.hpp>
#include <hfh/force/force_evaluator.hpp>
#include <hfh/terrain/blended_field.hpp>
#include <hfh/terrain/extended_field.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace hfh;
using namespace hfh::test;

namespace {

constexpr Index columns = 130, rows = 111;

/// Ground without holes that has relief on every level, and its definition.
template <Real T>
struct Ground {
    Terrain<T> terrain;
    GridFrame frame{.origin = {-300, 200}, .spacing = {2, 1.5}};
    using Field = BlendedField<T, StridedLevels<HeightView<T>>>;

    explicit Ground(std::uint64_t seed, double relief = 3)
        : terrain{hfh::test::terrain<T>(columns, rows, [&, random = Random{seed}](Index i, Index j) mutable {
              const double x = static_cast<double>(i), y = static_cast<double>(j);
              return relief * (random.between(-0.3, 0.3) + std::sin(x / 2.3) * std::cos(y / 3.1) +
                               4 * std::sin(x / 11) * std::cos(y / 13));
          })} {}

    [[nodiscard]] Field field() const {
        return Field{StridedLevels{HeightView<T>{terrain.heights.data(), columns, rows}}, frame};
    }
    [[nodiscard]] LevelOracle oracle() const {
        return {[this](int k, Index i, Index j) -> std::optional<Metres> {
                    const T z = terrain.at(i << k, j << k);
                    if (!holds_number(z)) return {};
                    return static_cast<Metres>(z);
                },
                columns, rows};
    }
    /// The height of the ground on a level at a place in metres, from the vertices of the definition.
    [[nodiscard]] std::optional<double> height(double level, double x, double y) const {
        const auto k = static_cast<int>(level);
        const auto alpha = static_cast<Metres>(level) - static_cast<Metres>(k);
        const double width = static_cast<double>(1 << k);
        const double a = (x - frame.origin.x) / frame.spacing.x / width,
                     b = (y - frame.origin.y) / frame.spacing.y / width;
        const auto i = static_cast<Index>(std::floor(a)), j = static_cast<Index>(std::floor(b));
        const LevelOracle levels = oracle();
        Metres sum = 0;
        for (Index q = 0; q < 2; ++q) {
            for (Index p = 0; p < 2; ++p) {
                const auto z = levels.vertex(k, alpha, i + p, j + q);
                if (!z) return {};
                const auto u = static_cast<Metres>(a - static_cast<double>(i)),
                           v = static_cast<Metres>(b - static_cast<double>(j));
                sum += (p ? u : 1 - u) * (q ? v : 1 - v) * *z;
            }
        }
        return static_cast<double>(sum);
    }
    /// Somewhere that no level's rim is near.
    [[nodiscard]] glm::dvec2 place(Random& random) const {
        return frame.origin + frame.spacing * glm::dvec2{random.between(20, 90), random.between(20, 80)};
    }
};

/// Where a surface point of level k is, in cells of level 0 from a sample of level 0: near that one, exactly.
template <Real T>
glm::vec<2, Metres> in_cells(const SurfacePoint<T>& p, int k, Cell from = {0, 0}) {
    const auto width = static_cast<Metres>(1 << k);
    return {static_cast<Metres>((p.cell.i << k) - from.i) + static_cast<Metres>(p.u) * width,
            static_cast<Metres>((p.cell.j << k) - from.j) + static_cast<Metres>(p.v) * width};
}

template <Real T>
bool same(const Contact<T>& a, const Contact<T>& b) {
    return a.status == b.status && a.proxy == b.proxy && a.normal == b.normal && a.depth == b.depth &&
           a.penetration == b.penetration && a.point.cell == b.point.cell && a.point.u == b.point.u &&
           a.point.v == b.point.v;
}

/// Rounding of positions on this ground, in metres.
template <Real T>
constexpr double rounding = 2000 * static_cast<double>(epsilon<T>);

} // namespace

TEMPLATE_TEST_CASE("change_level: a point keeps its place in cells of any size", "[level_change][law][ieee]",
                   float, double) {
    using T = TestType;
    Random random{201};
    for (int n = 0; n < 20000; ++n) {
        const int from = static_cast<int>(random.whole(0, 12)), to = static_cast<int>(random.whole(0, 12));
        SurfacePoint<T> p{{random.whole(-40, 9000), random.whole(-40, 9000)},
                          static_cast<T>(random.unit()),
                          static_cast<T>(random.unit())};
        if (random.one_in(4)) p.u = static_cast<T>(random.whole(0, 1));
        if (random.one_in(4)) p.v = static_cast<T>(random.fraction(0, 1, 64));
        const auto q = renumbered(p, to - from);
        REQUIRE((q.u >= 0 && q.u <= 1 && q.v >= 0 && q.v <= 1));
        // Going finer is exact, going coarser rounds u and v.
        const Cell near{p.cell.i << from, p.cell.j << from};
        const auto off = glm::abs(in_cells(q, to, near) - in_cells(p, from, near));
        const Metres ulps = to > from ? static_cast<Metres>(epsilon<T>) * static_cast<Metres>(1 << to) : 0;
        REQUIRE((off.x <= ulps && off.y <= ulps));
        // Cells of the finer level lie in the coarser level's cell, also where u or v is 1.
        const Cell fine = to > from ? p.cell : q.cell, coarse = to > from ? q.cell : p.cell;
        const int by = std::abs(to - from);
        REQUIRE((fine.i >> by == coarse.i && fine.j >> by == coarse.j));
        if (to < from) {
            const auto back = renumbered(q, from - to);
            REQUIRE(back.cell == p.cell);
            REQUIRE((back.u == p.u && back.v == p.v));
        }
    }
}

TEMPLATE_TEST_CASE("change_level: a contact keeps its place and gets the new height", "[level_change][law]",
                   float, double) {
    using T = TestType;
    Random random{202};
    for (const SurfaceKind surface : {SurfaceKind::solid, SurfaceKind::sheet}) {
        for (int n = 0; n < 150; ++n) {
            const Ground<T> ground{static_cast<std::uint64_t>(n)};
            auto field = ground.field();
            double level = field.set_level(random.between(0, 4));
            ProxyTracker tracker{field, {.surface = surface}};
            const bool below = surface == SurfaceKind::sheet && random.one_in(2);
            const auto at = ground.place(random);
            const double side = below ? -1 : 1, z = *ground.height(level, at.x, at.y);
            (void)tracker.update(vec3<T>{glm::dvec3{at, z + side * 20}});
            vec3<T> stylus{glm::dvec3{at, z - side * random.between(0.01, 0.5)}};
            auto contact = tracker.update(stylus);
            REQUIRE(contact.touching());
            for (int m = 0; m < 20; ++m) {
                const double before_level = level;
                const int k = field.finer_level();
                const glm::dvec3 proxy{contact.proxy};
                const auto place = in_cells(tracker.state().proxy, k);
                // As it is while zooming, across a whole number, or far.
                level = random.one_in(3)   ? random.between(0, 4)
                        : random.one_in(3) ? std::round(level)
                                           : std::clamp(level + random.between(-0.3, 0.3), 0.0, 4.0);
                const double rise = change_level(field, level, tracker);
                REQUIRE(field.level() == level);
                const auto kept = in_cells(tracker.state().proxy, field.finer_level());
                CHECK(glm::distance(place, kept) <= 64 * static_cast<Metres>(epsilon<T>));
                CHECK(tracker.state().touching());
                const double wanted =
                    *ground.height(level, proxy.x, proxy.y) - *ground.height(before_level, proxy.x, proxy.y);
                CHECK(std::abs(rise - wanted) <= 10 * rounding<T>);

                stylus.z += static_cast<T>(rise);
                // The proxy is over the stylus as it was, so the next update touches.
                contact = tracker.update(stylus);
                CHECK(contact.touching());
                CHECK(contact.side == (below ? Side::below : Side::above));
                CHECK(static_cast<double>(contact.depth) <=
                      glm::length(proxy + glm::dvec3{0, 0, rise} - glm::dvec3{stylus}) + 10 * rounding<T>);
            }
        }
    }
}

TEMPLATE_TEST_CASE("change_level: the level that is set already changes nothing", "[level_change][ieee]",
                   float, double) {
    using T = TestType;
    Random random{203};
    for (int n = 0; n < 50; ++n) {
        const Ground<T> ground{static_cast<std::uint64_t>(n)};
        auto field = ground.field();
        const double level = field.set_level(random.between(0, 4));
        // With little work a slide takes many updates, and goes on all the same.
        const TrackerOptions options{.max_contact_patches = random.one_in(2) ? 1 : 8192};
        ProxyTracker tracker{field, options}, still{field, options};
        const auto at = ground.place(random);
        const double z = *ground.height(level, at.x, at.y);
        CHECK(change_level(field, level, tracker) == 0); // nothing was seen yet
        CHECK(tracker.state().phase == TrackerPhase::unseen);
        for (const double over : {5.0, 0.5, -0.1, -0.3, -9.0, -9.0, -9.0, -9.0, -9.0, -9.0, 0.2}) {
            const vec3<T> stylus{glm::dvec3{at, z + over}};
            CHECK(change_level(field, level, tracker) == 0);
            CHECK(same(tracker.update(stylus), still.update(stylus)));
        }
    }
}

TEMPLATE_TEST_CASE("change_level: a free stylus keeps its height over the ground", "[level_change][law]",
                   float, double) {
    using T = TestType;
    Random random{204};
    for (const SurfaceKind surface : {SurfaceKind::solid, SurfaceKind::sheet}) {
        for (int n = 0; n < 150; ++n) {
            const Ground<T> ground{static_cast<std::uint64_t>(n)};
            auto field = ground.field();
            double level = field.set_level(random.between(0, 4));
            ProxyTracker tracker{field, {.surface = surface}};
            const bool below = surface == SurfaceKind::sheet && random.one_in(2);
            const auto at = ground.place(random);
            // Right above it, or far.
            const double over = (below ? -1 : 1) * std::exp(random.between(std::log(8 * rounding<T>), 5));
            vec3<T> stylus{glm::dvec3{at, *ground.height(level, at.x, at.y) + over}};
            REQUIRE(tracker.update(stylus).status == ContactStatus::free);
            for (int m = 0; m < 20; ++m) {
                const double before =
                    *ground.height(level, static_cast<double>(stylus.x), static_cast<double>(stylus.y));
                level = random.between(0, 4);
                const double rise = change_level(field, level, tracker);
                const double after =
                    *ground.height(level, static_cast<double>(stylus.x), static_cast<double>(stylus.y));
                CHECK(std::abs(rise - (after - before)) <= rounding<T>);
                stylus.z += static_cast<T>(rise);
                const auto contact = tracker.update(stylus);
                // Nearer than roundings it may touch, but it is not buried.
                if (std::abs(over) > 100 * rounding<T>) {
                    CHECK(contact.status == ContactStatus::free);
                } else {
                    CHECK((contact.status == ContactStatus::free || contact.touching()));
                }
                CHECK(contact.side == (below ? Side::below : Side::above));
            }
        }
    }
}

TEMPLATE_TEST_CASE("change_level: a stylus that flies on meets no ground that rose with it", "[level_change]",
                   float, double) {
    using T = TestType;
    // With a trench across the way, into which a stylus that was left below would come up and meet the far wall.
    const auto high = terrain<T>(33, 33, [](Index i, Index) { return 7 <= i && i <= 9 ? 0.0 : 100.0; });
    const auto low = plane<T>(17, 17, 0);
    const HeightView<T> views[]{{high.heights.data(), 33, 33}, {low.heights.data(), 17, 17}};
    BlendedField<T, OverviewLevels<HeightView<T>>> field{OverviewLevels{views, 2}, {}};
    field.set_level(1);
    for (const SurfaceKind surface : {SurfaceKind::solid, SurfaceKind::sheet}) {
        ProxyTracker tracker{field, {.surface = surface}};
        (void)change_level(field, 1, tracker);
        REQUIRE(tracker.update({T(4.5), T(5.5), T(1)}).status == ContactStatus::free);
        CHECK(change_level(field, 0, tracker) == 100);
        CHECK(tracker.state().swept_to() == glm::dvec3{4.5, 5.5, 101}); // what was searched to moves along
        CHECK(tracker.update({T(14.5), T(5.5), T(101)}).status == ContactStatus::free);
        CHECK(change_level(field, 1, tracker) == -100);
        CHECK(tracker.update({T(4.5), T(15.5), T(1)}).status == ContactStatus::free);
        CHECK(tracker.update({T(4.5), T(15.5), T(-1)}).touching());
    }
}

TEMPLATE_TEST_CASE("change_level: holes do not change the shaded slopes of a plane",
                   "[level_change][force_shading]", float, double) {
    using T = TestType;
    auto ground = tilted_plane<T>(41, 37, 0.5, -0.25);
    punch_holes(ground, 12, 3);
    BlendedField<T, StridedLevels<HeightView<T>>> field{
        StridedLevels{HeightView<T>{ground.heights.data(), 41, 37}}, {}};
    int known = 0;
    for (const double level : {0.0, 0.25, 0.75, 1.0, 1.5, 2.5}) {
        field.set_level(level);
        for (Index j = 0; j < field.cells().end.j; ++j) {
            for (Index i = 0; i < field.cells().end.i; ++i) {
                const auto slopes = shaded_slopes(field, SurfacePoint<T>{{i, j}, T(0.25), T(0.75)});
                CHECK(slopes.has_value() == field.patch({i, j}).has_value());
                if (!slopes) continue;
                ++known;
                CHECK(glm::length(*slopes - vec2<T>{T(0.5), T(-0.25)}) <= 64 * epsilon<T>);
            }
        }
    }
    CHECK(known > 1000);
}

TEMPLATE_TEST_CASE("change_level: both numberings of a whole level give one force", "[level_change][law]",
                   float, double) {
    using T = TestType;
    Random random{205};
    const ForceEvaluator<T> force{.stiffness = 500, .max_force = T(1e6)};
    for (int n = 0; n < 400; ++n) {
        const Ground<T> ground{static_cast<std::uint64_t>(n / 4)};
        auto coarse = ground.field(), fine = ground.field();
        const int k = static_cast<int>(random.whole(1, 4));
        coarse.set_level(k);
        ProxyTracker in_coarse{coarse}, in_fine{fine};
        const auto at = ground.place(random);
        const double z = *ground.height(k, at.x, at.y);
        (void)in_coarse.update(vec3<T>{glm::dvec3{at, z + 20}});
        const vec3<T> stylus{glm::dvec3{at, z - random.between(0.01, 0.5)}};
        REQUIRE(in_coarse.update(stylus).touching());
        // The same level, numbered as the one below it.
        auto state = in_coarse.state();
        fine.blend(k - 1, 1);
        REQUIRE(fine.level() == k);
        REQUIRE(fine.finer_level() == k - 1);
        state.proxy = renumbered(state.proxy, -1);
        in_fine.restore(state);
        const auto one = in_coarse.update(stylus), other = in_fine.update(stylus);
        REQUIRE((one.touching() && other.touching()));
        CHECK(glm::length(force(one).newtons - force(other).newtons) <= T(500 * rounding<T>));
        const auto shaded = shade_force(coarse, one), too = shade_force(fine, other);
        CHECK(glm::length(shaded.normal - too.normal) <= 2000 * epsilon<T>);
    }
}

TEMPLATE_TEST_CASE("change_level: the shaded force does not jump at a whole level", "[level_change]", float,
                   double) {
    using T = TestType;
    Random random{206};
    double worst = 0, unblended = 0;
    for (int n = 0; n < 200; ++n) {
        const Ground<T> ground{static_cast<std::uint64_t>(n / 4)};
        auto field = ground.field();
        const int k = static_cast<int>(random.whole(1, 3));
        const SurfacePoint<T> point{{random.whole(4, 12), random.whole(4, 12)},
                                    static_cast<T>(random.unit()),
                                    static_cast<T>(random.unit())};
        field.set_level(k);
        const auto above = shaded_slopes(field, point);
        field.set_level(k - 1e-4);
        const auto below = shaded_slopes(field, renumbered(point, -1));
        REQUIRE((above && below));
        worst = std::max(worst, static_cast<double>(glm::length(*above - *below)));
        // As slopes are without the two levels' own.
        const ExtendedField plain{field};
        unblended =
            std::max(unblended,
                     static_cast<double>(glm::length(*above - *shaded_slopes(plain, renumbered(point, -1)))));
    }
    CHECK(worst < 3e-3);
    CHECK(unblended > 0.1);
}

TEMPLATE_TEST_CASE("change_level: shaded slopes are continuous over edges and right on every level",
                   "[level_change][force_shading][law][ieee]", float, double) {
    using T = TestType;
    Random random{207};
    for (int n = 0; n < 40; ++n) {
        Ground<T> ground{static_cast<std::uint64_t>(n)};
        if (n % 2 == 1) punch_holes(ground.terrain, 40, static_cast<std::uint64_t>(n));
        auto field = ground.field();
        field.set_level(random.between(0, 3));
        const int k = field.finer_level();
        for (int m = 0; m < 200; ++m) {
            const Cell c{random.whole(0, field.cells().end.i - 1), random.whole(0, field.cells().end.j - 1)};
            const T t = static_cast<T>(random.unit());
            const auto here = shaded_slopes(field, SurfacePoint<T>{c, 1, t}),
                       east = shaded_slopes(field, SurfacePoint<T>{{c.i + 1, c.j}, 0, t});
            CHECK(here.has_value() == field.patch(c).has_value());
            if (here && east) CHECK((here->x == east->x && here->y == east->y));
            const auto top = shaded_slopes(field, SurfacePoint<T>{c, t, 1}),
                       north = shaded_slopes(field, SurfacePoint<T>{{c.i, c.j + 1}, t, 0});
            if (top && north) CHECK((top->x == north->x && top->y == north->y));
            // At a vertex of both levels, away from holes and rims: central differences, blended.
            const Index i = c.i & ~Index{1}, j = c.j & ~Index{1};
            if (n % 2 == 1 || i < 2 || j < 2 || i + 2 > field.cells().end.i || j + 2 > field.cells().end.j)
                continue;
            const auto oracle = ground.oracle();
            const auto slope = [&](int level, Index a, Index b, bool along_x) {
                const auto high = along_x ? oracle.at(level, a + 1, b) : oracle.at(level, a, b + 1),
                           low = along_x ? oracle.at(level, a - 1, b) : oracle.at(level, a, b - 1);
                const double metres =
                    (along_x ? ground.frame.spacing.x : ground.frame.spacing.y) * (2 << level);
                return static_cast<double>(*high - *low) / metres;
            };
            if (i / 2 + 1 > oracle.cells(k + 1, true) || j / 2 + 1 > oracle.cells(k + 1, false)) continue;
            const auto found = shaded_slopes(field, SurfacePoint<T>{{i, j}, 0, 0});
            REQUIRE(found);
            const double alpha = field.alpha();
            CHECK(static_cast<double>(found->x) ==
                  Approx((1 - alpha) * slope(k, i, j, true) + alpha * slope(k + 1, i / 2, j / 2, true))
                      .margin(100 * static_cast<double>(epsilon<T>)));
            CHECK(static_cast<double>(found->y) ==
                  Approx((1 - alpha) * slope(k, i, j, false) + alpha * slope(k + 1, i / 2, j / 2, false))
                      .margin(100 * static_cast<double>(epsilon<T>)));
        }
    }
}

TEMPLATE_TEST_CASE("change_level: the anchor of friction keeps its place, and its force",
                   "[level_change][friction]", float, double) {
    using T = TestType;
    Random random{208};
    for (int n = 0; n < 100; ++n) {
        const Ground<T> ground{static_cast<std::uint64_t>(n), 0.5};
        auto field = ground.field();
        double level = field.set_level(random.between(0, 4));
        ProxyTracker tracker{field};
        Friction<T> friction{{.at_rest = T(0.8), .sliding = T(0.7)}};
        const auto at = ground.place(random);
        const double z = *ground.height(level, at.x, at.y);
        (void)tracker.update(vec3<T>{glm::dvec3{at, z + 20}});
        vec3<T> stylus{glm::dvec3{at, z - 0.3}};
        (void)friction.hold(field, tracker.update(stylus), stylus);
        stylus.x += T(0.02); // sticks
        auto contact = friction.hold(field, tracker.update(stylus), stylus);
        for (int m = 0; m < 200; ++m) {
            const auto anchor = in_cells(friction.state().anchor, field.finer_level());
            const auto held = contact.penetration;
            level = std::clamp(level + random.between(-0.01, 0.01), 0.0, 4.0);
            if (m % 50 == 49) level = std::round(level);
            const double rise = change_level(field, level, tracker, friction);
            const auto kept = in_cells(friction.state().anchor, field.finer_level());
            CHECK(glm::distance(anchor, kept) <= 64 * static_cast<Metres>(epsilon<T>));
            CHECK(friction.state().side == Side::above);
            stylus.z += static_cast<T>(rise);
            contact = friction.hold(field, tracker.update(stylus), stylus);
            REQUIRE(contact.touching());
            if (!friction.state().slipping && m % 50 != 49)
                CHECK(glm::length(contact.penetration - held) < T(0.05));
        }
    }
}

TEMPLATE_TEST_CASE("change_level: however little work is allowed, no contact is dropped",
                   "[level_change][law]", float, double) {
    using T = TestType;
    Random random{209};
    int free_below = 0, touched = 0, phases[6] = {};
    for (int n = 0; n < 120; ++n) {
        const Ground<T> ground{static_cast<std::uint64_t>(n), random.between(0.5, 60)};
        auto field = ground.field();
        double level = field.set_level(random.between(0, 3));
        ProxyTracker tracker{field,
                             {.max_patches = static_cast<int>(random.whole(1, 12)),
                              .max_contact_patches = static_cast<int>(random.whole(1, 8))}};
        glm::dvec2 at = ground.place(random), way{0};
        double over = 3;
        const double deep = random.between(0.5, 20);
        (void)tracker.update(vec3<T>{glm::dvec3{at, *ground.height(level, at.x, at.y) + over}});
        bool was_touching = false;
        for (int m = 0; m < 400; ++m) {
            if (m % 20 == 0) way = {random.between(-0.5, 0.5), random.between(-0.5, 0.5)};
            at = glm::clamp(at + way, ground.frame.origin + ground.frame.spacing * 24.0,
                            ground.frame.origin + ground.frame.spacing * glm::dvec2{88, 78});
            over = deep * (2 * std::sin(0.05 * m) - 1);
            level = std::clamp(level + random.between(-0.2, 0.2), 0.0, 3.0);
            (void)change_level(field, level, tracker); // the hand follows the ground anyway
            ++phases[static_cast<int>(tracker.state().phase)];
            const glm::dvec3 stylus{at, *ground.height(level, at.x, at.y) + over};
            const auto contact = tracker.update(vec3<T>{stylus});
            const bool below = over < -10 * rounding<T>;
            free_below += was_touching && below && !contact.touching();
            was_touching = contact.touching();
            touched += was_touching;
        }
    }
    CHECK(free_below == 0);
    CHECK(touched > 10000);
    for (const auto phase : {TrackerPhase::free, TrackerPhase::searching, TrackerPhase::contact,
                             TrackerPhase::sliding, TrackerPhase::releasing})
        CHECK(phases[static_cast<int>(phase)] > 4);
}

TEMPLATE_TEST_CASE("change_level: a contact ends where the level has no ground", "[level_change]", float,
                   double) {
    using T = TestType;
    auto ground = plane<T>(17, 17, 1);
    ground.remove(8, 8); // four cells of level 0, and four of each coarser one but the last
    BlendedField<T, StridedLevels<HeightView<T>>> field{
        StridedLevels{HeightView<T>{ground.heights.data(), 17, 17}}, {}};
    ProxyTracker tracker{field};
    Friction<T> friction;
    const vec3<T> above{T(5), T(5), T(2)}, below{T(5), T(5), T(0.5)};
    (void)tracker.update(above);
    REQUIRE(friction.hold(field, tracker.update(below), below).touching());
    CHECK(change_level(field, 2, tracker, friction) == 0); // cells 4 to 12 of level 0 are a hole there
    const auto left = friction.hold(field, tracker.update(below), below);
    CHECK(left.status == ContactStatus::left_at_hole);
    CHECK(left.side == Side::none);
    // Ground that appears over a free stylus is not felt until that has been outside.
    CHECK(change_level(field, 0, tracker, friction) == 0);
    CHECK(tracker.update(below).status == ContactStatus::buried);
    CHECK(tracker.update(above).status == ContactStatus::free);
    CHECK(tracker.update(below).touching());

    // Beyond the last complete cell of a level there is none either.
    const auto narrow = plane<T>(7, 17, 1);
    BlendedField<T, StridedLevels<HeightView<T>>> odd{
        StridedLevels{HeightView<T>{narrow.heights.data(), 7, 17}}, {}};
    ProxyTracker at_rim{odd};
    (void)at_rim.update({T(5.5), T(5), T(2)});
    REQUIRE(at_rim.update({T(5.5), T(5), T(0.5)}).touching());
    CHECK(change_level(odd, 2, at_rim) == 0);
    CHECK(at_rim.update({T(5.5), T(5), T(0.5)}).status == ContactStatus::left_at_hole);
}

// Compares code for two types of field, to the bit; where products are fused, a compiler fuses others in each.
TEMPLATE_TEST_CASE("change_level: works through a field around the levels", "[level_change][ieee][unfused]",
                   float, double) {
    using T = TestType;
    Random random{210};
    const Ground<T> ground{3};
    auto levels = ground.field();
    const ExtendedField field{levels};
    ProxyTracker tracker{field};
    ProxyTracker inner{levels};
    double level = levels.set_level(1.5);
    const auto at = ground.place(random);
    const double z = *ground.height(level, at.x, at.y);
    vec3<T> stylus{glm::dvec3{at, z + 20}};
    (void)tracker.update(stylus);
    (void)inner.update(stylus);
    stylus.z = static_cast<T>(z - 0.2);
    REQUIRE(same(tracker.update(stylus), inner.update(stylus)));
    for (int m = 0; m < 50; ++m) {
        auto again = ground.field();
        again.set_level(level);
        ProxyTracker reference{again};
        reference.restore(tracker.state());
        level = random.between(0, 4);
        const double rise = change_level(levels, level, tracker);
        CHECK(rise == change_level(again, level, reference));
        stylus.z += static_cast<T>(rise);
        CHECK(same(tracker.update(stylus), reference.update(stylus)));
    }
    // On the extension beyond the rim the ground moves as well.
    stylus = {static_cast<T>(ground.frame.origin.x - 40), stylus.y, T(100)};
    tracker.reset();
    (void)tracker.update(stylus);
    CHECK(change_level(levels, 0, tracker) != 0);
}

TEMPLATE_TEST_CASE("change_level: zooming about the proxy keeps the force in the hand",
                   "[level_change][workspace]", float, double) {
    using T = TestType;
    Random random{211};
    for (int n = 0; n < 60; ++n) {
        const Ground<T> ground{static_cast<std::uint64_t>(n), 0.7};
        auto field = ground.field();
        double level = field.set_level(4);
        ProxyTracker tracker{field};
        const auto at = ground.place(random);
        const double z = *ground.height(level, at.x, at.y);
        Workspace<T> workspace{{.scale = 4000, .offset = {at, z}}};
        const auto force = [&](const Contact<T>& contact) {
            const ForceEvaluator<T> spring{.stiffness = workspace.terrain_stiffness(500)};
            return workspace.force_at_hand(spring(contact).newtons);
        };
        (void)tracker.update(workspace.update({0, 0, 0.01}));
        const glm::dvec3 hand{0, 0, -0.002};
        auto contact = tracker.update(workspace.update(hand));
        REQUIRE(contact.touching());
        auto newtons = force(contact);
        double worst = 0;
        for (int m = 0; m < 2000; ++m) {
            level = 4 - 4 * m / 2000.0;
            const double rise = change_level(field, level, tracker);
            REQUIRE(workspace.move({0, 0, rise}) == WorkspaceStatus::ok);
            REQUIRE(workspace.zoom(4000 * std::exp2(level - 4),
                                   glm::dvec3{contact.proxy} + glm::dvec3{0, 0, rise}) ==
                    WorkspaceStatus::ok);
            contact = tracker.update(workspace.update(hand));
            REQUIRE(contact.touching());
            worst = std::max(worst, glm::distance(force(contact), newtons));
            newtons = force(contact);
        }
        CHECK(worst < 0.1);
        CHECK(glm::length(newtons) > 0.1);
    }
}
