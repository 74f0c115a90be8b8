#include "catch.hpp"
#include "support/random.hpp"
#include "support/terrains.hpp"

#include <hfh/contact/ball_friction.hpp>
#include <hfh/contact/ball_glide.hpp>
#include <hfh/contact/ball_shading.hpp>
#include <hfh/contact/ball_tracker.hpp>
#include <hfh/loop/ball_tip.hpp>
#include <hfh/traversal/nearest_point.hpp>

#include <glm/geometric.hpp>

using namespace hfh;
using namespace hfh::test;

namespace {

using Grid = Terrain<double>::Grid;

/// How much nearer than its radius the surface comes to a ball, of the radius.
[[nodiscard]] double penetration(const Grid& grid, const BallContact<double>& contact) {
    const auto nearest = nearest_point(grid, contact.centre, {.max_distance = 1.1 * contact.radius});
    if (!nearest.has_point()) return 0;
    return nearest.side == Side::below ? 1 : (contact.radius - nearest.distance) / contact.radius;
}

/// A stylus that wanders over hills, some way under the place of a free ball.
class Wandering {
public:
    Wandering(std::uint64_t seed, double step, double deep) : random_{seed}, step_{step}, deep_{deep} {}
    [[nodiscard]] glm::dvec3 next(const Grid& grid, double radius) {
        at_.x = glm::clamp(at_.x + random_.between(-step_, step_), 3.0, 20.0);
        at_.y = glm::clamp(at_.y + random_.between(-step_, step_), 3.0, 16.0);
        const auto ground = surface_at(grid, at_);
        return {at_, (ground ? ground->height : 0) + radius - random_.between(0, deep_)};
    }

private:
    Random random_;
    double step_, deep_;
    glm::dvec2 at_{11, 9};
};

/// |force across| / |force against| of what holds a ball.
[[nodiscard]] double slip_ratio(const BallContact<double>& contact) {
    glm::dvec3 against{0.0};
    for (int k = 0; k < contact.count; ++k) against += contact.touches[k].share * contact.touches[k].normal;
    return glm::length(contact.penetration - against) / glm::length(against);
}

} // namespace

TEST_CASE("ball friction: sticks and slips at its angles, on a slope and along a valley",
          "[ball][ball_friction]") {
    const auto slope =
        test::terrain<double>(24, 20, [](Index i, Index) { return static_cast<double>(i) / 2; });
    const auto valley = test::terrain<double>(
        24, 20, [](Index i, Index) { return 2 * std::abs(static_cast<double>(i) - 12); });
    for (const auto* terrain : {&slope, &valley}) {
        const auto grid = terrain->grid();
        BallTracker tracker{grid, 1.0};
        BallFriction<double> friction{{.at_rest = 0.5, .sliding = 0.4}};
        glm::dvec3 held{0.0};
        bool slipped = false;
        for (int n = 0; n < 40; ++n) {
            const glm::dvec3 stylus{12, 6 + 0.1 * n, n == 0 ? 12.0 : 4.0 - (terrain == &valley ? 3 : 0)};
            const auto contact = friction.hold(grid, tracker.update(stylus), stylus);
            if (n == 0) continue;
            REQUIRE(contact.touching());
            CHECK(contact.count == (terrain == &valley ? 2 : 1));
            CHECK(penetration(grid, contact) < 1e-9);
            CHECK(glm::distance(contact.centre - stylus, contact.penetration) < 1e-12);
            slipped = slipped || friction.state().slipping;
            if (friction.state().slipping) {
                CHECK(slip_ratio(contact) == Approx(0.4).epsilon(1e-6));
            } else {
                CHECK(slip_ratio(contact) <= 0.5 * (1 + 1e-9));
                if (n > 1 && !slipped) CHECK(contact.centre == held); // to the bit
            }
            held = contact.centre;
        }
        CHECK(slipped);
    }
}

TEST_CASE("ball friction: with shading or without, a ball that is held penetrates nothing",
          "[ball][ball_friction]") {
    const auto terrain = hills<double>(24, 20, 5, 3);
    const auto grid = terrain.grid();
    for (const double radius : {0.3, 1.0, 2.5}) {
        BallTracker tracker{grid, radius};
        BallFriction<double> friction{{.at_rest = 0.6, .sliding = 0.5}};
        Wandering hand{static_cast<std::uint64_t>(10 * radius), 0.4, 1.5};
        (void)tracker.update({11, 9, 30});
        int held = 0, shaded = 0;
        for (int n = 0; n < 400; ++n) {
            const glm::dvec3 stylus = hand.next(grid, radius);
            auto contact = tracker.update(stylus);
            if (n % 2 == 0) contact = shade_force(grid, contact);
            contact = friction.hold(grid, contact, stylus);
            if (!contact.touching()) continue;
            CHECK(penetration(grid, contact) < 1e-9);
            CHECK(glm::dot(contact.penetration, contact.normal) >= -1e-12);
            held += glm::distance(contact.centre, tracker.centre()) > 1e-6;
            shaded += contact.shaded;
        }
        CHECK(held > 20);
        CHECK(shaded > 50);
    }
}

TEST_CASE("ball friction: shading turns the force into none of the faces that a ball touches",
          "[ball][ball_friction]") {
    const auto terrain = rough<double>(24, 20, 3, 5);
    const auto grid = terrain.grid();
    BallTracker tracker{grid, 0.7};
    Wandering hand{4, 0.6, 2};
    (void)tracker.update({11, 9, 30});
    int several = 0;
    for (int n = 0; n < 400; ++n) {
        const auto contact = tracker.update(hand.next(grid, 0.7));
        const auto shaded = shade_force(grid, contact);
        if (!contact.touching()) continue;
        CHECK(shaded.depth == contact.depth);
        CHECK(shaded.centre == contact.centre);
        CHECK(glm::length(shaded.penetration) == Approx(contact.depth).margin(1e-12));
        several += contact.count > 1;
        if (contact.count == 1) CHECK(glm::dot(shaded.normal, contact.touches[0].normal) >= -1e-12);
    }
    CHECK(several > 50);
}

TEST_CASE("ball glide: moves no more than its speed, penetrates nothing, and comes to the tracker's at rest",
          "[ball][ball_friction]") {
    const auto terrain = hills<double>(24, 20, 6, 7);
    const auto grid = terrain.grid();
    const double radius = 0.8, speed = 0.05;
    BallTracker tracker{grid, radius};
    BallGlide<double> glide{speed};
    Wandering hand{9, 0.5, 3};
    (void)tracker.update({11, 9, 30});
    int under_way = 0, arrived = 0;
    glm::dvec3 felt{0.0}, before{0.0}, stylus{0.0};
    for (int n = 0; n < 600; ++n) {
        // Now and then the hand rests.
        if (n % 40 < 10) stylus = hand.next(grid, radius);
        const auto contact = tracker.update(stylus);
        const auto gliding = glide.follow(grid, contact, stylus);
        REQUIRE(gliding.touching() == contact.touching());
        if (gliding.touching()) {
            CHECK(penetration(grid, gliding) < 1e-9);
            if (glide.state().is_under_way) {
                ++under_way;
                CHECK(gliding.status == ContactStatus::descent_limit);
                const double moved = glm::distance(gliding.centre, felt);
                CHECK(moved <= (speed + glm::distance(stylus, before)) * 1.1);
                CHECK(glm::distance(gliding.centre, stylus) <= glm::distance(felt, stylus) * (1 + 1e-9));
            } else if (n % 40 == 39) {
                ++arrived;
                CHECK(gliding.centre == contact.centre);
            }
        }
        felt = gliding.centre;
        before = stylus;
    }
    CHECK(under_way > 20);
    CHECK(arrived > 5);
}

TEMPLATE_TEST_CASE("ball tip: with radius 0 the loop is that of a point, to the bit",
                   "[ball][ball_friction][ieee]", float, double) {
    using T = TestType;
    const auto terrain = hills<T>(24, 20, 5, 3);
    const auto grid = terrain.grid();
    const HapticLoopOptions options{
        .material = {.static_friction = 0.5, .dynamic_friction = 0.3, .damping = 2, .shading = true},
        .release_speed = 0.01};
    HapticLoop point{grid, options};
    HapticLoop<std::remove_cvref_t<decltype(grid)>, BallTip> ball{grid, options};
    Random random{3};
    glm::dvec3 hand{11, 9, 12};
    int felt = 0;
    for (int n = 0; n < 2000; ++n) {
        DeviceSample sample;
        sample.time = n * 1e-3;
        hand += glm::dvec3{random.between(-0.1, 0.1), random.between(-0.1, 0.1),
                           n < 250 ? -0.05 : random.between(-0.05, 0.05)};
        sample.position = hand;
        const auto of_point = point.update(sample), of_ball = ball.update(sample);
        CHECK(of_point.newtons == of_ball.newtons);
        CHECK(point.contact().proxy == ball.contact().proxy);
        felt += ball.contact().touching();
    }
    CHECK(felt > 300);
}
