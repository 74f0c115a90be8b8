#include "catch.hpp"
#include "support/reference.hpp"
#include "support/scenes.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/force_evaluator.hpp>
#include <hfh/terrain/extended_field.hpp>

#include <algorithm>
#include <type_traits>

using namespace hfh;
using namespace hfh::test;

namespace {

/// The surface as it is defined: the terrain's height over (x, y) clamped to the terrain.
template <Real T>
std::optional<Wide> level_height(const Terrain<T>& ground, const Surface<T>& surface, double x, double y) {
    const glm::dvec2 low = ground.low(), high = ground.high();
    return surface.height(static_cast<Wide>(std::clamp(x, low.x, high.x)),
                          static_cast<Wide>(std::clamp(y, low.y, high.y)));
}

template <HeightField Field>
void check_corners(const Field& field, Cell c) {
    const auto here = field.patch(c);
    if (!here) return;
    if (const auto east = field.patch({c.i + 1, c.j})) {
        CHECK(here->p10 == east->p00);
        CHECK(here->p11 == east->p01);
    }
    if (const auto north = field.patch({c.i, c.j + 1})) {
        CHECK(here->p01 == north->p00);
        CHECK(here->p11 == north->p10);
    }
    if (const auto beyond = field.patch({c.i + 1, c.j + 1})) CHECK(here->p11 == beyond->p00);
    if (const auto beyond = field.patch({c.i - 1, c.j + 1})) CHECK(here->p01 == beyond->p10);
}

} // namespace

TEMPLATE_TEST_CASE(
    "ExtendedField: is the field inside, to the bit, and the height of the nearest rim outside",
    "[extended_field][law]", float, double) {
    using T = TestType;
    Random random{71};
    for (const auto& scene : scenes<T>()) {
        const auto grid = scene.terrain.grid();
        const Surface<T> surface{scene.terrain};
        const ExtendedField field{grid};
        static_assert(HeightField<ExtendedField<decltype(scene.terrain.grid())>>);
        CAPTURE(scene.name);
        for (int n = 0; n < 2000; ++n) {
            const Cell c{random.whole(-8, scene.terrain.columns + 8),
                         random.whole(-8, scene.terrain.rows + 8)};
            const auto patch = field.patch(c);
            REQUIRE(patch);
            if (const auto inside = grid.patch(c)) {
                CHECK((patch->p00 == inside->p00 && patch->p10 == inside->p10 && patch->p01 == inside->p01 &&
                       patch->p11 == inside->p11));
            }
            const T u = static_cast<T>(random.unit()), v = static_cast<T>(random.unit());
            const glm::dvec2 at =
                scene.terrain.frame.origin +
                scene.terrain.frame.spacing * glm::dvec2{double(c.i) + double(u), double(c.j) + double(v)};
            const auto wanted = level_height(scene.terrain, surface, at.x, at.y);
            REQUIRE(wanted);
            // Rounding of the height, and of (x, y) by which the reference finds its cell.
            const Wide relief = static_cast<Wide>(patch->highest() - patch->lowest()) + std::abs(*wanted);
            CHECK(std::abs(static_cast<Wide>(patch->height(u, v)) - *wanted) <=
                  8 * static_cast<Wide>(epsilon<T>) * relief + Wide(1e-11L));
            CHECK(patch->spacing == vec2<T>{grid.lattice().spacing()});
            check_corners(field, c);
        }
    }
}

TEMPLATE_TEST_CASE("ExtendedField: a hole at the rim goes on outwards, one inside stays what it is",
                   "[extended_field]", float, double) {
    using T = TestType;
    auto ground = plane<T>(8, 6, 1);
    ground.remove(0, 2); // takes cells (0, 1) and (0, 2)
    ground.remove(4, 3); // inside
    ground.remove(7, 5); // the last cell, (6, 4)
    const auto grid = ground.grid();
    const ExtendedField field{grid};
    for (Index j = -5; j < 12; ++j) {
        for (Index i = -5; i < 14; ++i) {
            const bool west_gap = i <= 0 && (j == 1 || j == 2), corner_gap = i >= 6 && j >= 4;
            const bool inside = (i == 3 || i == 4) && (j == 2 || j == 3);
            CAPTURE(i, j);
            CHECK(field.patch({i, j}).has_value() == !(west_gap || corner_gap || inside));
            check_corners(field, {i, j});
        }
    }
}

TEMPLATE_TEST_CASE("ExtendedField: a field without cells stays without, one cell is enough",
                   "[extended_field]", float, double) {
    using T = TestType;
    const auto nothing = plane<T>(1, 5);
    const auto nothing_grid = nothing.grid();
    const ExtendedField empty{nothing_grid};
    CHECK(empty.cells().empty());
    CHECK_FALSE(empty.patch({0, 0}));
    CHECK_FALSE(empty.patch({-3, 7}));
    const auto one = terrain<T>(2, 2, [](Index i, Index j) { return double(i + 2 * j); });
    const auto one_grid = one.grid();
    const ExtendedField field{one_grid};
    CHECK(field.patch({-4, -4})->highest() == 0);
    CHECK(field.patch({4, 4})->lowest() == 3);
    CHECK(field.patch({4, -4})->lowest() == 1);
    CHECK(field.patch({0, 9})->p10 == 3);
    CHECK(field.patch({-9, 0})->p01 == 2);
}

TEMPLATE_TEST_CASE("ExtendedField: reaches as far as cells can be numbered and refuses what is farther",
                   "[extended_field]", float, double) {
    using T = TestType;
    const auto ground = terrain<T>(5, 5, [](Index i, Index j) { return double(i + 8 * j); });
    const auto grid = ground.grid();
    const ExtendedField field{grid};
    const CellRange all = field.cells();
    CHECK(field.patch(all.begin)->p11 == 0);
    CHECK(field.patch({all.end.i - 1, all.end.j - 1})->p00 == 36);
    CHECK_FALSE(field.patch(all.end));
    CHECK_FALSE(field.patch({all.begin.i - 1, 0}));
    constexpr Index most = std::numeric_limits<Index>::max(), least = std::numeric_limits<Index>::min();
    CHECK_FALSE(field.patch({most, most}));
    CHECK_FALSE(field.patch({least, 2}));

    // A touch a thousand kilometres off; at the end of numbers the stylus is refused.
    ProxyTracker tracker{field};
    CHECK(tracker.update({T(1e6), T(2), T(21)}).status == ContactStatus::free);
    const auto contact = tracker.update({T(1e6), T(2), T(19.5)});
    REQUIRE(contact.status == ContactStatus::contact);
    // Half a metre below ground that rises 8 in y: the foot is half a metre along (0, -8, 1)/65.
    CHECK(contact.penetration.y == Approx(-4.0 / 65).margin(1e-5));
    CHECK(contact.penetration.z == Approx(0.5 / 65).margin(1e-5));
    tracker.reset();
    CHECK(tracker.update({T(1e17), T(2), T(19.5)}).status == ContactStatus::bad_input);
}

/// N: by how much a force changed at most in one update, over an extended field, and by how much it fell without extension.
struct Steps {
    double largest = 0, drop = 0;
};

/// A stroke `deep` metres under the ground out over the rim along `way` and back, `step` times that an update.
template <Real T>
Steps stroke_over_rim(const Terrain<T>& ground, SurfaceKind kind, const glm::dvec2& way, double stiffness,
                      double deep, double step, bool is_plane) {
    const Surface<T> surface{ground};
    const auto grid = ground.grid();
    const ExtendedField field{grid};
    ProxyTracker tracker{field, {.surface = kind}};
    ProxyTracker released{grid, {.surface = kind}};
    const ForceEvaluator<T> force{.stiffness = T(stiffness)};
    vec3<T> before{T(0)};
    Steps steps;
    double last_released = 0;
    const int there = 1200;
    for (int n = -100; n <= 2 * there; ++n) {
        // n < 0: down from above; then out and back.
        const double s = step * (n < 0 ? 0 : n <= there ? n : 2 * there - n);
        const double x = 5.3 + s * way.x, y = 4.4 + s * way.y;
        const double z =
            static_cast<double>(*level_height(ground, surface, x, y)) - deep * (n < 0 ? 1 + n / 50.0 : 1.0);
        const vec3<T> at{static_cast<T>(x), static_cast<T>(y), static_cast<T>(z)};
        const auto contact = tracker.update(at);
        const double before_release = last_released;
        last_released = static_cast<double>(glm::length(force(released.update(at)).newtons));
        steps.drop = std::max(steps.drop, before_release - last_released);
        const vec3<T> now = force(contact).newtons;
        if (n >= 0) {
            REQUIRE(contact.status == ContactStatus::contact);
            if (is_plane) CHECK(now == vec3<T>{T(0), T(0), now.z});
            if (n > 0)
                steps.largest = std::max(steps.largest, static_cast<double>(glm::length(now - before)));
        }
        before = now;
    }
    return steps;
}

TEMPLATE_TEST_CASE("ExtendedField: a stroke over the rim neither kicks nor drops", "[extended_field]", float,
                   double) {
    using T = TestType;
    // At a tenth of a cell deep, out over each side and each corner and back in.
    const double k = 500, deep = 0.1, step = 0.01;
    struct Scene {
        const char* name;
        Terrain<T> ground;
        double crease; // the largest change of slope at an edge of a cell, here and at the rim
    };
    const Scene scenes[] = {{"plane", plane<T>(12, 10, 2), 0},
                            {"tilted", tilted_plane<T>(12, 10, 0.25, -0.125), 0.28},
                            {"hills", hills<T>(12, 10, 0.5, 8), 0.4}};
    for (const auto& [name, ground, crease] : scenes) {
        for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
            for (const auto& way :
                 {glm::dvec2{1, 0}, glm::dvec2{-1, 0}, glm::dvec2{0, 1}, glm::dvec2{0, -1}, glm::dvec2{1, 1},
                  glm::dvec2{-1, 1}, glm::dvec2{1, -0.8}, glm::dvec2{-1, -0.8}}) {
                CAPTURE(name, way.x, way.y);
                const auto [largest, drop] = stroke_over_rim(ground, kind, way, k, deep, step, crease == 0);
                // k times the motion, which is no longer than step·(√2 + slope), and where the proxy goes over a
                // crease the change of slope times the depth.
                CHECK(largest <= k * (step * (1.42 + 0.6) + deep * crease));
                CHECK(drop > k * deep * 0.8); // without, the force drops in one update
                if (crease == 0) CHECK(largest < 1e-3);
            }
        }
    }
}

TEMPLATE_TEST_CASE("ExtendedField: never free below the surface, wherever the hand goes",
                   "[extended_field][law]", float, double) {
    using T = TestType;
    Random random{72};
    for (const auto& scene : scenes<T>()) {
        const auto& ground = scene.terrain;
        const Surface<T> surface{ground};
        const auto grid = ground.grid();
        const ExtendedField field{grid};
        ProxyTracker tracker{field};
        const glm::dvec2 low = ground.low(), high = ground.high(), cell = ground.frame.spacing;
        double x = low.x - cell.x, y = low.y, heading = 0;
        int outside = 0, touching = 0, faults = 0;
        static_cast<void>(tracker.update({static_cast<T>(x), static_cast<T>(y), T(1000)}));
        for (int n = 0; n < 20000; ++n) {
            heading += random.between(-0.5, 0.5);
            const double step = random.one_in(50) ? 8 : 0.4;
            x = std::clamp(x + step * cell.x * std::cos(heading), low.x - 6 * cell.x, high.x + 6 * cell.x);
            y = std::clamp(y + step * cell.y * std::sin(heading), low.y - 6 * cell.y, high.y + 6 * cell.y);
            // GCC 12 forgets the rounding in (double)(float)x of a pair of x where it sees it.
            const volatile T tx = static_cast<T>(x), ty = static_cast<T>(y);
            const Wide height =
                *level_height(ground, surface, static_cast<double>(tx), static_cast<double>(ty));
            const vec3<T> at{tx, ty, static_cast<T>(height + Wide(random.between(-0.5, 0.25) * cell.x))};
            const auto contact = tracker.update(at);
            touching += contact.touching();
            outside += !grid.cells().contains(contact.point.cell) && contact.touching();
            const Wide below = height - static_cast<Wide>(at.z);
            const Wide blur = Wide(1e-12L) * (100 + std::abs(height));
            const bool good = contact.touching() || (contact.status == ContactStatus::free && below <= blur);
            if (!good && faults++ == 0)
                FAIL_CHECK(scene.name << " " << n << ": " << to_string(contact.status));
        }
        CAPTURE(scene.name);
        CHECK(faults == 0);
        CHECK(touching > 5000);
        CHECK(outside > 1000);
    }
}

TEST_CASE("ExtendedField: needs the field only", "[extended_field]") {
    using Grid = Terrain<double>::Grid;
    static_assert(sizeof(ExtendedField<Grid>) == sizeof(void*));
    static_assert(!std::is_constructible_v<ExtendedField<Grid>, Grid>); // a temporary would not outlive it
    static_assert(noexcept(std::declval<const ExtendedField<Grid>&>().patch({})));
    // Of a field that is endless already it changes nothing.
    const auto ground = plane<double>(3, 3);
    const auto grid = ground.grid();
    const ExtendedField once{grid};
    const ExtendedField<ExtendedField<Grid>> twice{once};
    CHECK(twice.patch({-7, 9})->p00 == once.patch({-7, 9})->p00);
    CHECK(twice.cells().end == once.cells().end);
}
