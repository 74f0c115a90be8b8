#include "catch.hpp"
#include "support/numbers.hpp"
#include "support/random.hpp"
#include "support/terrains.hpp"

#include <hfh/contact/ball_level_change.hpp>
#include <hfh/terrain/blended_field.hpp>
#include <hfh/traversal/nearest_point.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace hfh;
using namespace hfh::test;

namespace {

template <Real T>
using Levels = BlendedField<T, StridedLevels<HeightView<T>>>;

/// Hills with relief on every level.
template <Real T>
struct Ground {
    Terrain<T> terrain = hills<T>(130, 111, 3, 23);

    [[nodiscard]] Levels<T> field() const {
        return Levels<T>{StridedLevels{HeightView<T>{terrain.heights.data(), 130, 111}},
                         {.spacing = {2, 1.5}}};
    }
};

/// A stylus that goes about over the ground and into it.
template <Real T>
[[nodiscard]] vec3<T> on_path(int n, double ground) {
    return {static_cast<T>(60 + 20 * std::sin(0.011 * n)), static_cast<T>(70 + 25 * std::cos(0.007 * n)),
            static_cast<T>(ground + 2.5 * std::sin(0.03 * n) + 0.8)};
}

} // namespace

TEMPLATE_TEST_CASE("change_level: under a ball of radius 0 it is that under a point, to the bit",
                   "[level_change][ball][law]", float, double) {
    using T = TestType;
    const Ground<T> ground;
    auto field = ground.field();
    auto same_field = ground.field();
    Random random{301};
    // Little work, so that every phase is gone through.
    const TrackerOptions options{.max_patches = 6, .max_contact_patches = 2};
    ProxyTracker point{field, options};
    BallTracker ball{same_field, options};
    Friction<T> hold{{.at_rest = T(0.5), .sliding = T(0.3)}};
    BallFriction<T> ball_hold{{.at_rest = T(0.5), .sliding = T(0.3)}};
    double rise = 0;
    int different = 0, touching = 0;
    for (int n = 0; n < 5000; ++n) {
        const vec3<T> stylus = on_path<T>(n, rise);
        const auto a = hold.hold(field, point.update(stylus), stylus);
        const auto b = ball_hold.hold(same_field, ball.update(stylus), stylus);
        touching += a.touching();
        different += a.status != b.status || a.proxy != b.proxy || a.penetration != b.penetration ||
                     a.normal != b.normal || a.patches != b.patches || a.point.cell != b.point.cell;
        const double level = std::clamp(field.level() + random.between(-0.2, 0.2), 0.0, 4.0);
        const double by = change_level(field, level, point, hold);
        different += by != change_level(same_field, level, ball, ball_hold);
        if (n % 3 == 0) rise += by;
        if (n % 400 == 0) rise = 0;
    }
    CHECK(different == 0);
    CHECK(touching > 1000);
}

TEMPLATE_TEST_CASE("change_level: a ball stays in contact and clear of the ground while the level changes",
                   "[level_change][ball]", float, double) {
    using T = TestType;
    for (const double radius : {0.4, 3.0, 9.0}) {
        for (const bool friction : {false, true}) {
            const Ground<T> ground;
            auto field = ground.field();
            BallTracker ball{field, static_cast<T>(radius)};
            BallFriction<T> hold{{.at_rest = friction ? T(0.5) : T(0), .sliding = friction ? T(0.4) : T(0)}};
            vec3<T> stylus{T(101.3), T(77.7), T(60)};
            (void)ball.update(stylus);
            for (; stylus.z > -3 && !ball.state().touching(); stylus.z -= T(0.05)) (void)ball.update(stylus);
            REQUIRE(ball.state().touching());
            stylus.z -= T(0.5);
            auto contact = hold.hold(field, ball.update(stylus), stylus);
            REQUIRE(contact.touching());
            const double grain = 1e-4 * radius + 64 * static_cast<double>(epsilon<T>) * 130;
            for (int n = 1; n <= 1500; ++n) {
                const double level = 2 - 2 * std::cos(2 * std::numbers::pi * n / 1500.0);
                stylus.z += static_cast<T>(change_level(field, level, ball, hold));
                const double before = widen(contact.depth);
                contact = hold.hold(field, ball.update(stylus), stylus);
                REQUIRE(contact.touching());
                REQUIRE(std::abs(widen(contact.depth) - before) < 0.1);
                const auto nearest = nearest_point(field, contact.proxy);
                REQUIRE(widen(nearest.distance) >= radius - grain);
            }
        }
    }
}

TEMPLATE_TEST_CASE("change_level: the level that is set already leaves a ball where it is",
                   "[level_change][ball]", float, double) {
    using T = TestType;
    const Ground<T> ground;
    auto field = ground.field();
    BallTracker ball{field, T(2)};
    for (int n = 0; n < 400; ++n) (void)ball.update(on_path<T>(n, 0));
    const auto before = ball.state();
    CHECK(change_level(field, field.level(), ball) == 0);
    CHECK(ball.state().centre == before.centre);
    CHECK(ball.state().foot.cell == before.foot.cell);
}
