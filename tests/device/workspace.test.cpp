#include "catch.hpp"
#include "support/guard_oracle.hpp"
#include "support/numbers.hpp"
#include "support/random.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/device/workspace.hpp>
#include <hfh/force/force_evaluator.hpp>
#include <hfh/terrain/bilinear_grid.hpp>

#include <string>
#include <vector>

using namespace hfh;
using namespace hfh::test;

namespace {

/// A rotation by a random angle about a random axis (Rodrigues, written out in long double).
glm::dmat3 random_rotation(Random& random) {
    long double a[3], length = 0;
    for (auto& x : a) {
        x = wide(random.between(-1, 1));
        length += x * x;
    }
    length = std::sqrt(length);
    const long double angle = wide(random.between(-3.2, 3.2)), c = std::cos(angle), s = std::sin(angle);
    for (auto& x : a) x /= length;
    glm::dmat3 r{0.0};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const int k = 3 - i - j;
            const long double cross = i == j ? 0 : ((j - i + 3) % 3 == 1 ? -a[k] : a[k]);
            r[j][i] = static_cast<double>((i == j ? c : 0) + (1 - c) * a[i] * a[j] + s * cross); // column j
        }
    }
    return r;
}

glm::dvec3 random_point(Random& random, double size) {
    return {random.between(-size, size), random.between(-size, size), random.between(-size, size)};
}

template <class T>
double tolerance(double size) {
    return 16 * static_cast<double>(epsilon<T>) * size;
}

} // namespace

TEMPLATE_TEST_CASE("Workspace: a position is turned, scaled and moved, and comes back", "[workspace][law]",
                   float, double) {
    using T = TestType;
    Random random{7};
    for (int n = 0; n < 1000; ++n) {
        const WorkspaceFrame frame{.scale = std::exp(random.between(-5, 12)),
                                   .rotation = random_rotation(random),
                                   .offset = random_point(random, 1e6)};
        Workspace<T> workspace{frame};
        REQUIRE(workspace.status() == WorkspaceStatus::ok);
        const auto hand = random_point(random, 0.1);
        const auto terrain = workspace.update(hand);
        for (int i = 0; i < 3; ++i) {
            long double sum = 0;
            for (int j = 0; j < 3; ++j) sum += wide(frame.rotation[j][i]) * wide(hand[j]);
            const auto expected = static_cast<double>(wide(frame.offset[i]) + wide(frame.scale) * sum);
            CHECK(static_cast<double>(terrain[i]) ==
                  Approx(expected).margin(tolerance<T>(1e6 + frame.scale)).epsilon(0));
        }
        const auto back = workspace.to_hand(workspace.to_terrain(hand));
        // An offset up to 10⁶ m has cost the hand a few roundings of it, seen through the scale.
        CHECK(glm::distance(back, hand) < tolerance<double>(1e6 / frame.scale + 1));
    }
}

TEMPLATE_TEST_CASE("Workspace: the hand does the work that is done on the terrain", "[workspace][law]", float,
                   double) {
    using T = TestType;
    Random random{8};
    for (int n = 0; n < 1000; ++n) {
        const Workspace<T> workspace{
            {.scale = std::exp(random.between(-5, 12)), .rotation = random_rotation(random)}};
        const auto velocity = random_point(random, 1);
        const auto force = vec3<T>{random_point(random, 3)};
        const auto on_terrain = glm::dvec3{workspace.velocity_on_terrain(velocity)};
        const auto at_hand = workspace.force_at_hand(force);
        const double power_terrain = glm::dot(glm::dvec3{force}, on_terrain);
        const double power_hand = glm::dot(at_hand, velocity);
        CHECK(power_hand ==
              Approx(power_terrain).margin(tolerance<T>(10 * workspace.frame().scale)).epsilon(0));
    }
}

TEMPLATE_TEST_CASE("Workspace: the stiffness at the hand is what the user set, at any scale and turn",
                   "[workspace][law]", float, double) {
    using T = TestType;
    Random random{9};
    const double stiffness = 500; // N/m at the hand
    for (const double scale : {1e-3, 1.0, 30.0, 1e5}) {
        // Turned about z only, so that up stays up; level ground at height 0.
        const double angle = random.between(-3, 3);
        const glm::dmat3 turn{
            {std::cos(angle), std::sin(angle), 0}, {-std::sin(angle), std::cos(angle), 0}, {0, 0, 1}};
        Workspace<T> workspace{{.scale = scale, .rotation = turn, .offset = {5 * scale, 5 * scale, 0}}};
        const std::vector<float> flat(121, 0.0f);
        const BilinearGrid<T, HeightView<float>> grid{HeightView{flat.data(), 11, 11},
                                                      {.spacing = {scale, scale}}};
        ProxyTracker tracker{grid};
        const ForceEvaluator<T> force{.stiffness = workspace.terrain_stiffness(stiffness),
                                      .max_force = workspace.terrain_force(3.3)};
        for (double depth = -0.01; depth < 0.02; depth += 0.0005) { // metres of the hand, down
            const auto contact = tracker.update(workspace.update({0.01, -0.02, -depth}));
            const auto newtons = workspace.force_at_hand(force(contact).newtons);
            const double expected = depth <= 0 ? 0 : std::min(3.3, stiffness * depth);
            CHECK(newtons.z == Approx(expected).margin(1e-4).epsilon(1e-5));
            CHECK(std::abs(newtons.x) + std::abs(newtons.y) < 1e-4);
        }
    }
}

TEMPLATE_TEST_CASE("Workspace: a clutch holds the terrain position, and nothing jumps", "[workspace]", float,
                   double) {
    using T = TestType;
    Random random{10};
    Workspace<T> workspace{{.scale = 1000, .rotation = random_rotation(random), .offset = {1, 2, 3}}};
    glm::dvec3 hand{0.0};
    auto last = workspace.update(hand);
    bool clutch = false;
    vec3<T> held{};
    for (int n = 0; n < 20000; ++n) {
        const auto before = hand;
        hand = glm::clamp(hand + random_point(random, 1e-4), -0.05, 0.05);
        const bool was = clutch;
        if (random.one_in(100)) clutch = !clutch;
        const auto now = workspace.update(hand, clutch);
        CHECK(workspace.clutched() == clutch);
        CHECK(glm::length(workspace.velocity_on_terrain({0, 1, 0})) ==
              Approx(clutch ? 0 : 1000).epsilon(1e-6));
        if (clutch && was) CHECK(static_cast<double>(glm::length(now - held)) <= tolerance<T>(1000));
        if (clutch && !was) held = now;
        // The update in which the clutch is released is one of free motion again: it goes with the hand.
        const double step = static_cast<double>(glm::length(now - last));
        CHECK(step <= 1000 * glm::length(hand - before) + tolerance<T>(1000));
        last = now;
    }
    // Re-centred by hand: after many clutches the terrain position is far outside of what the workspace spans.
    for (int n = 0; n < 10; ++n) {
        (void)workspace.update({0.05, 0, 0}, true);
        (void)workspace.update({-0.05, 0, 0}, true);
        (void)workspace.update({-0.05, 0, 0}, false);
        last = workspace.update({0.05, 0, 0}, false);
    }
    CHECK(glm::length(last) > 500);
}

TEST_CASE("Workspace: a hand that is no number moves nothing, clutched or not", "[workspace]") {
    Workspace<double> workspace{{.scale = 10, .offset = {1, 2, 3}}};
    const auto at = workspace.update({0.01, 0, 0}, true);
    for (const double bad : {make_nan(), make_infinity()}) {
        CHECK_FALSE(is_finite(workspace.update({0, bad, 0}, true)));
        CHECK_FALSE(is_finite(workspace.update({0, bad, 0}, false)));
        CHECK(workspace.clutched());
        CHECK(workspace.update({0.02, 0, 0}, true) == at);
    }
}

TEST_CASE(
    "Workspace: at scales that a double hardly holds gives no force that is no number, and stays usable",
    "[workspace][hard]") {
    Workspace<double> huge{{.scale = 1e308}};
    CHECK(huge.status() == WorkspaceStatus::ok);
    CHECK(huge.force_at_hand({0, 0, 10}) == glm::dvec3{0.0});
    CHECK(huge.force_at_hand({0, 0, 1e-300}).z > 0);
    // A hand so far away that no offset makes up for it, with the clutch held: it goes on when the hand is back.
    const auto at = huge.update({0, 0, 0}, true);
    CHECK_FALSE(is_finite(huge.update({100, 0, 0}, true)));
    CHECK(huge.update({0, 0, 0}, true) == at);
    const Workspace<float> tiny{{.scale = 1e-300}};
    CHECK_FALSE(is_finite(tiny.terrain_stiffness(500)));
    CHECK(is_finite(tiny.force_at_hand({0, 0, 1})));
}

TEST_CASE("Workspace: refuses what is no scale, no proper rotation, no place", "[workspace]") {
    const auto status = [](const WorkspaceFrame& frame) {
        const Workspace<double> workspace{frame};
        CHECK(workspace.status() == check(frame));
        if (workspace.status() != WorkspaceStatus::ok) {
            CHECK(workspace.to_terrain({1, 2, 3}) == glm::dvec3{1, 2, 3});
            CHECK(workspace.force_at_hand({1, 2, 3}) == glm::dvec3{0.0});
        }
        return workspace.status();
    };
    for (const double bad : {0.0, -1.0, make_nan(), make_infinity()})
        CHECK(status({.scale = bad}) == WorkspaceStatus::bad_scale);
    for (const double bad : {make_nan(), -make_infinity()})
        CHECK(status({.offset = {0, bad, 0}}) == WorkspaceStatus::bad_offset);

    const glm::dmat3 mirror{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}, swap{{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},
        shear{{1, 0, 0}, {1e-5, 1, 0}, {0, 0, 1}}, flat{{1, 0, 0}, {0, 1, 0}, {0, 0, 0}}, twice{2.0};
    for (const auto& bad : {mirror, swap, shear, flat, twice, glm::dmat3{0.0}, glm::dmat3{make_nan()}})
        CHECK(status({.rotation = bad}) == WorkspaceStatus::bad_rotation);
    const glm::dmat3 float_turn{{0.6f, 0.8f, 0}, {-0.8f, 0.6f, 0}, {0, 0, 1}}; // rounded in float
    CHECK(status({.rotation = float_turn}) == WorkspaceStatus::ok);

    CHECK(to_string(WorkspaceStatus::ok) == std::string{"ok"});
    CHECK(to_string(WorkspaceStatus::bad_scale) == std::string{"bad_scale"});
    CHECK(to_string(WorkspaceStatus::bad_rotation) == std::string{"bad_rotation"});
    CHECK(to_string(WorkspaceStatus::bad_offset) == std::string{"bad_offset"});
    CHECK(to_string(static_cast<WorkspaceStatus>(4)) == std::string{"unknown"});
}

TEMPLATE_TEST_CASE("Workspace: zooming about a point keeps the hand and what is over that point",
                   "[workspace][law]", float, double) {
    using T = TestType;
    Random random{31};
    for (int n = 0; n < 500; ++n) {
        const WorkspaceFrame frame{.scale = std::exp(random.between(-2, 12)),
                                   .rotation = random_rotation(random),
                                   .offset = random_point(random, 1e5)};
        Workspace<T> workspace{frame};
        const glm::dvec3 hand = random_point(random, 0.1), proxy = random_point(random, 0.1);
        const glm::dvec3 about = workspace.to_terrain(proxy);
        const glm::dvec3 stylus = workspace.to_terrain(hand);
        const double scale = frame.scale * std::exp(random.between(-8, 8));
        REQUIRE(workspace.zoom(scale, about) == WorkspaceStatus::ok);
        CHECK(workspace.frame().scale == scale);
        CHECK(workspace.frame().rotation == frame.rotation);
        // The same place of the workspace is over the point.
        CHECK(glm::distance(workspace.to_hand(about), proxy) <=
              tolerance<double>(1e5 / scale + 1e5 / frame.scale + 1));
        // about + (stylus − about)·scale/old scale, in long double.
        for (int i = 0; i < 3; ++i) {
            const long double wanted =
                wide(about[i]) + (wide(stylus[i]) - wide(about[i])) * wide(scale) / wide(frame.scale);
            CHECK(std::abs(workspace.to_terrain(hand)[i] - static_cast<double>(wanted)) <=
                  tolerance<double>((1e5 + 0.2 * frame.scale) * (1 + scale / frame.scale)));
        }
        // The force of a spring from the stylus to the point is in the hand what it was.
        const auto force = [&](double at_scale, const glm::dvec3& from) {
            return 500.0 * ((about - from) * frame.rotation) / at_scale;
        };
        const glm::dvec3 before = force(frame.scale, stylus),
                         after = workspace.force_at_hand(
                             vec3<T>{static_cast<double>(workspace.terrain_stiffness(500)) *
                                     (about - workspace.to_terrain(hand))});
        CHECK(glm::distance(before, after) <=
              1e-4 + 500 * tolerance<double>(1e6 / scale + 1e6 / frame.scale));
    }
}

TEST_CASE("Workspace: zooming and moving refuse what is no number, and change nothing", "[workspace]") {
    const WorkspaceFrame frame{.scale = 100, .offset = {1, 2, 3}};
    Workspace<double> workspace{frame};
    const glm::dvec3 hand{0.01, 0.02, 0.03}, before = workspace.to_terrain(hand);
    for (const double scale : {0.0, -1.0, hidden_nan<double>(), hidden_infinity<double>()})
        CHECK(workspace.zoom(scale, {0, 0, 0}) == WorkspaceStatus::bad_scale);
    CHECK(workspace.zoom(50, {0, hidden_nan<double>(), 0}) == WorkspaceStatus::bad_offset);
    CHECK(workspace.zoom(1e300, {1e300, 0, 0}) == WorkspaceStatus::bad_offset);
    CHECK(workspace.move({0, 0, hidden_infinity<double>()}) == WorkspaceStatus::bad_offset);
    CHECK(workspace.frame().scale == 100);
    CHECK(workspace.to_terrain(hand) == before);
    CHECK(workspace.move({0, 0, 7}) == WorkspaceStatus::ok);
    CHECK(glm::distance(workspace.to_terrain(hand), before + glm::dvec3{0, 0, 7}) < 1e-12);

    Workspace<double> refused{{.scale = -1}};
    CHECK(refused.zoom(2, {0, 0, 0}) == WorkspaceStatus::bad_scale);
    CHECK(refused.move({0, 0, 1}) == WorkspaceStatus::bad_scale);
    CHECK(refused.to_terrain(hand) == hand);
}

TEST_CASE("Workspace: a held clutch zooms and moves what it holds", "[workspace]") {
    Workspace<double> workspace{{.scale = 100, .offset = {1, 2, 3}}};
    const glm::dvec3 held = workspace.update({0.01, 0.02, 0.03});
    (void)workspace.update({0.01, 0.02, 0.03}, true);
    CHECK(glm::distance(workspace.update({0.05, 0, 0}, true), held) < 1e-12);
    const glm::dvec3 about{4, 4, 4};
    REQUIRE(workspace.zoom(50, about) == WorkspaceStatus::ok);
    const glm::dvec3 zoomed = about + (held - about) * 0.5;
    CHECK(glm::distance(workspace.update({0.02, 0.01, 0}, true), zoomed) < 1e-12);
    REQUIRE(workspace.move({0, 0, 2}) == WorkspaceStatus::ok);
    CHECK(glm::distance(workspace.update({0, 0, 0}, true), zoomed + glm::dvec3{0, 0, 2}) < 1e-12);
    CHECK(glm::distance(workspace.update({0, 0, 0}), zoomed + glm::dvec3{0, 0, 2}) < 1e-12);
}

TEST_CASE("suitable_level: a cell of that level measures so much in the hand", "[workspace]") {
    // 10 m cells at 20 km a metre: half a millimetre.
    CHECK(suitable_level(20000, 10) == Approx(0).margin(1e-12));
    CHECK(suitable_level(80000, 10) == Approx(2));
    CHECK(suitable_level(10000, 10) == Approx(-1));
    CHECK(suitable_level(20000, 10, 1e-3) == Approx(1));
    Random random{32};
    for (int n = 0; n < 200; ++n) {
        const double cell = std::exp(random.between(-3, 5)), in_hand = std::exp(random.between(-9, -4)),
                     whole = static_cast<double>(random.whole(-3, 12)),
                     scale = cell / in_hand * std::exp2(whole);
        CAPTURE(cell, in_hand, whole);
        const auto level = [&](double octaves) {
            return suitable_level(scale * std::exp2(octaves), cell, in_hand);
        };
        CHECK(level(0) == Approx(whole).margin(1e-12));
        CHECK(level(0.5) == Approx(whole + 0.5));
        // Between whole levels about, never back, and at whole ones next to standing still.
        double last = level(0);
        for (double alpha = 0.01; alpha < 1; last = level(alpha), alpha += 0.01) {
            CHECK(level(alpha) >= last);
            CHECK(cell * std::exp2(level(alpha)) / (scale * std::exp2(alpha)) ==
                  Approx(in_hand).epsilon(0.07));
        }
        for (const double alpha : {-0.001, 0.001}) CHECK(std::abs(level(alpha) - whole) < 4e-6);
    }
}

TEST_CASE("Workspace: in float it maps as in double, to some roundings, and is clutched and zoomed alike",
          "[workspace][law]") {
    Random random{31};
    for (int n = 0; n < 1000; ++n) {
        const double size = std::exp(random.between(-3, 5)); // of the terrain, m
        // Both have the same frame, and the turn is one to the rounding of a float.
        const glm::mat3 turn{random_rotation(random)};
        const auto scale = static_cast<float>(std::exp(random.between(-3, 5)));
        const vec3<float> offset{random_point(random, size)};
        Workspace<float, float> single{{.scale = scale, .rotation = turn, .offset = offset}};
        Workspace<double> reference{
            {.scale = widen(scale), .rotation = glm::dmat3{turn}, .offset = widen(offset)}};
        REQUIRE(single.status() == WorkspaceStatus::ok);
        const double bound = tolerance<float>(size + widen(scale));
        for (int step = 0; step < 20; ++step) {
            const bool clutch = step >= 5 && step < 10;
            const vec3<float> hand{random_point(random, 0.1)};
            const auto one = single.update(hand, clutch);
            const auto other = reference.update(widen(hand), clutch);
            CHECK(glm::distance(widen(one), other) < bound);
            const vec3<float> newtons{random_point(random, 3)};
            CHECK(
                glm::distance(widen(single.force_at_hand(newtons)), reference.force_at_hand(widen(newtons))) <
                tolerance<float>(6 * widen(scale)));
            if (step == 12) {
                CHECK(single.zoom(scale / 2, one) == WorkspaceStatus::ok);
                CHECK(reference.zoom(widen(scale) / 2, other) == WorkspaceStatus::ok);
            }
        }
        CHECK(widen(single.terrain_stiffness(400)) == Approx(reference.terrain_stiffness(400)));
        CHECK(widen(single.terrain_force(3)) == Approx(reference.terrain_force(3)));
    }
    // A reflection, and a turn that is none.
    CHECK(check(BasicWorkspaceFrame<float>{.rotation = glm::mat3{-1.0f}}) == WorkspaceStatus::bad_rotation);
    CHECK(check(BasicWorkspaceFrame<float>{.rotation = glm::mat3{1.001f}}) == WorkspaceStatus::bad_rotation);
}
