#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/random.hpp"

#include <hfh/force/energy_tank.hpp>

#include <glm/geometric.hpp>

#include <cmath>
#include <limits>

using namespace hfh;
using namespace hfh::test;

namespace {

constexpr double step = 1e-3; // the farthest the hands below go in one update

glm::dvec3 direction(Random& random) {
    for (;;) {
        const glm::dvec3 d{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
        const double length = glm::length(d);
        if (length > 0.1 && length < 1) return d / length;
    }
}

/// What a scene wants to render where the hand is: from tame to as bad as can be.
glm::dvec3 wanted(int scene, const glm::dvec3& at, Random& random) {
    switch (scene) {
    case 0: return {0, 0, at.z < 0 ? -500 * at.z : 0};                  // a wall
    case 1: return {0, 0, at.z < 0 ? -3500 * at.z : 0};                 // a hard wall
    case 2: return {-40 * at.y, 40 * at.x, at.z < 0 ? -500 * at.z : 0}; // drives round in circles
    case 3: return 300.0 * at;                                          // pushes away from a point
    default: return random.between(0, 8) * direction(random);           // anything
    }
}

/// The next step of a hand that wants energy, or of one that does not care.
glm::dvec3 hand(int kind, const glm::dvec3& force, const glm::dvec3& at, int k, Random& random) {
    const double length = glm::length(force);
    const glm::dvec3 along = length > 0 ? force / length : direction(random);
    switch (kind) {
    case 0: return step * along;                                    // takes all it can at once
    case 1: return (k / 40 % 2 == 0 ? -0.3 : 1.0) * step * along;   // fills, then empties
    case 2: return {0, 0, (k / 25 % 2 == 0 ? -1 : 1) * 0.4 * step}; // presses and leaves
    case 3: return random.between(0, step) * direction(random);     // trembles
    case 4: return (random.one_in(3) ? 1.0 : -0.5) * step * along;  // now and then
    default: return glm::dvec3{0, 0, -0.02 * step} + (at.z < -2 * step ? step : 0) * along; // lies in wait
    }
}

/// The least energy, in long double, that the forces had taken from the hand at any time.
struct Fight {
    long double lowest = 0, last = 0;
    double given = 0, wished = 0;
};
template <class Shorten>
Fight fight(int scene, int kind, int updates, std::uint64_t seed, Shorten&& shorten) {
    Random random{seed};
    Fight out;
    glm::dvec3 at{0.0};
    for (int k = 0; k < updates; ++k) {
        const glm::dvec3 want = wanted(scene, at, random);
        const glm::dvec3 force = shorten(at, want);
        out.given += glm::length(force);
        out.wished += glm::length(want);
        glm::dvec3 to = at + hand(kind, force, at, k, random);
        if (glm::length(to) > 0.05)
            to *= 0.98; // stays on the table: towards the middle, never a step too far
        if (glm::length(to - at) > step) to = at + (to - at) * (step * (1 - 1e-12) / glm::length(to - at));
        for (int axis = 0; axis < 3; ++axis) {
            out.last -= static_cast<long double>(force[axis]) *
                        (static_cast<long double>(to[axis]) - static_cast<long double>(at[axis]));
        }
        out.lowest = std::min(out.lowest, out.last);
        at = to;
    }
    return out;
}

} // namespace

TEST_CASE("EnergyTank: no hand gets more out of a force than it put in", "[energy_tank][law]") {
    double worst_without = 0;
    for (int scene = 0; scene < 5; ++scene) {
        for (int kind = 0; kind < 6; ++kind) {
            for (std::uint64_t seed = 1; seed <= 5; ++seed) {
                EnergyTank tank{{.largest_step = step * (1 + 1e-9)}};
                const auto with = fight(scene, kind, 20000, seed, [&](const auto& at, const auto& want) {
                    const auto got = tank(at, want);
                    CHECK(glm::length(got.newtons) <= glm::length(want) * (1 + 1e-15));
                    CHECK(glm::dot(got.newtons, want) >= 0);
                    CHECK(glm::length(glm::cross(got.newtons, want)) <=
                          1e-15 * glm::length(want) * glm::length(want));
                    return got.newtons;
                });
                CHECK(static_cast<double>(with.lowest) >= -1e-9);
                CHECK(tank.exceeded() == 0);
                CHECK(tank.level() <= static_cast<double>(with.last) + 1e-12); // less where it overflowed
                const auto without =
                    fight(scene, kind, 20000, seed, [](const auto&, const auto& want) { return want; });
                worst_without = std::min(worst_without, static_cast<double>(without.lowest));
            }
        }
    }
    CHECK(worst_without < -1); // joules: these hands do get something where nothing stops them
}

TEST_CASE("EnergyTank: the same with a bound on how fast a hand turns", "[energy_tank][law]") {
    constexpr double turn = 0.2e-3;
    for (int scene = 0; scene < 5; ++scene) {
        for (std::uint64_t seed = 1; seed <= 10; ++seed) {
            Random random{seed};
            EnergyTank tank{{.largest_step = step * (1 + 1e-9), .largest_turn = turn * (1 + 1e-9)}};
            glm::dvec3 at{0.0}, going{0.0};
            long double taken = 0, lowest = 0;
            int whole = 0, touched = 0;
            for (int k = 0; k < 20000; ++k) {
                const auto want = wanted(scene, at, random);
                const auto got = tank(at, want);
                const double length = glm::length(got.newtons);
                touched += glm::length(want) > 0;
                whole += glm::length(want) > 0 && !got.shortened;
                // Turns as hard as it can: with the force to draw, against it to lure, or anywhere.
                const glm::dvec3 along = length > 0 ? got.newtons / length : direction(random);
                const double mood = random.unit();
                glm::dvec3 turned = mood < 0.5 ? along : mood < 0.8 ? -along : direction(random);
                if (glm::length(at) > 0.05) turned = -at / glm::length(at);
                glm::dvec3 next = going + turn * turned;
                if (glm::length(next) > step) next = going * (1 - turn / step);
                for (int axis = 0; axis < 3; ++axis)
                    taken -=
                        static_cast<long double>(got.newtons[axis]) * static_cast<long double>(next[axis]);
                lowest = std::min(lowest, taken);
                at += next;
                going = next;
            }
            CHECK(static_cast<double>(lowest) >= -1e-9);
            CHECK(tank.exceeded() == 0);
            CHECK(whole > 0);
            CHECK(touched > 0);
        }
    }
}

TEST_CASE(
    "EnergyTank: a force is whole once enough has been taken, and at once for a hand that comes in fast",
    "[energy_tank]") {
    const auto press = [](const EnergyTankOptions& options, double speed) {
        EnergyTank tank{options};
        double at = 1e-3; // the depth from which on the force is whole
        for (double z = 0.5e-3; z > -0.03; z -= speed) {
            const auto got = tank({0, 0, z}, {0, 0, z < 0 ? -500 * z : 0});
            if (z < 0 && got.shortened) at = -z;
        }
        return at;
    };
    const double slow = press({.largest_step = 1e-3}, 1e-4);
    CHECK(slow > 5e-3); // e-fold by e-fold from the allowance: ln(10⁶) steps or so
    CHECK(slow < 25e-3);
    CHECK(press({.largest_step = 0.2e-3}, 1e-4) < 5e-3);
    CHECK(press({.largest_step = 1e-3, .allowance = 1e-3}, 1e-4) < 3e-3);
    // Faster in than it can turn: the next step cannot be outward.
    CHECK(press({.largest_step = 1e-3, .largest_turn = 0.9e-4}, 1e-4) == 1e-3);

    EnergyTank tank{{.largest_step = 1e-4}};
    for (double z = 0; z > -0.01; z -= 1e-4) (void)tank({0, 0, z}, {0, 0, 2});
    const glm::dvec3 want{0.1, 0.2, 0.3};
    const auto got = tank({0, 0, -0.01}, want);
    CHECK(got.newtons == want); // to the bit
    CHECK_FALSE(got.shortened);
}

TEST_CASE("EnergyTank: gives no force for what is no number, and charges the worst", "[energy_tank]") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EnergyTank tank{{.largest_step = 1e-3}};
    for (int k = 0; k < 300; ++k) (void)tank({0, 0, -1e-4 * k}, {0, 0, 1});
    const double before = tank.level();
    CHECK(before > 2e-3);
    auto got = tank({0, 0, nan}, {0, 0, 1});
    CHECK(got.newtons == glm::dvec3{0.0});
    CHECK(got.shortened);
    CHECK(tank.level() == Approx(before - 1e-3 * 1).margin(1e-12)); // 1 N over the largest step
    got = tank({0, 0, 5}, {0, nan, 0}); // far away: nobody knows how it came there
    CHECK(got.newtons == glm::dvec3{0.0});
    CHECK(tank.exceeded() == 0);
    got = tank({0, 0, 5}, {0, HUGE_VAL, 0});
    CHECK(got.newtons == glm::dvec3{0.0});
    got = tank({0, 0, 5}, {0, 1e200, 0});
    CHECK(is_finite(got.newtons));
    CHECK(glm::length(got.newtons) * 1e-3 <= tank.level() + 1e-9);
}

TEST_CASE("EnergyTank: lets no force pass with options that are out of range", "[energy_tank]") {
    // A largest step of NaN, 0 or below once let every force pass.
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    std::vector<EnergyTankOptions> all;
    for (const double bad : {nan, -nan, inf, -inf, -1.0, 0.0, -0.0}) all.push_back({.largest_step = bad});
    for (const double bad : {nan, -inf, -1e-3}) {
        all.push_back({.largest_turn = bad});
        all.push_back({.allowance = bad});
        all.push_back({.capacity = bad});
    }
    all.push_back({.allowance = inf});
    for (const auto& options : all) {
        CAPTURE(options.largest_step, options.largest_turn, options.allowance, options.capacity);
        EnergyTank tank{options};
        CHECK_FALSE(tank.usable());
        // Also not when it has taken much.
        for (int k = 0; k < 100; ++k) {
            const auto got = tank({0, 0, -1e-4 * k}, {0, 0, 1000});
            REQUIRE(got.newtons == glm::dvec3{0.0});
            REQUIRE(got.shortened);
        }
        const auto none = tank({0, 0, 0}, {0, 0, 0});
        CHECK(none.newtons == glm::dvec3{0.0});
        CHECK_FALSE(none.shortened);
    }
    CHECK(EnergyTank{}.usable());
    CHECK(EnergyTank{{.largest_turn = 0, .allowance = 0, .capacity = inf}}.usable());
}

TEST_CASE("EnergyTank: counts a hand that does more than it may, and lets what it owes be paid",
          "[energy_tank]") {
    EnergyTank tank{{.largest_step = 1e-3, .largest_turn = 0.5e-4}};
    for (int k = 0; k < 50; ++k) (void)tank({0, 0, -1e-4 * k}, {0, 0, 1});
    CHECK(tank.exceeded() == 0);
    (void)tank({0, 0, 0.1}, {0, 0, 1}); // torn out
    CHECK(tank.exceeded() == 1);
    CHECK(tank.level() < -0.09);
    const auto refused = tank({0, 0, 0.1}, {0, 0, 1});
    CHECK(refused.newtons == glm::dvec3{0.0});
    CHECK(refused.held_back == 1);
    CHECK(refused.owed == Approx(-tank.level()).epsilon(1e-6)); // less the allowance
    double z = 0.1; // comes in faster than it can turn: such a force can only take
    for (int k = 0; k < 10; ++k) (void)tank({0, 0, z -= 1e-4}, {0, 0, 1});
    CHECK(tank({0, 0, z -= 1e-4}, {0, 0, 1}).newtons.z == 1);
    const double owed = tank.level();
    CHECK(tank({0, 0, z -= 1e-4}, {0, 0, 1}).newtons.z == 1);
    CHECK(tank.level() == Approx(owed + 1e-4));
    tank.reset();
    CHECK(tank.level() == 0);
    CHECK(tank.exceeded() == 0);
}

TEST_CASE("EnergyTank: says that it owes when fast retreats leave no force at all", "[energy_tank]") {
    EnergyTank tank; // the defaults: 1 mm an update at the most
    int contacts = 0, empty = 0, told = 0;
    double held_back = 0;
    for (int k = 0; k < 20000; ++k) {
        const double t = k * 1e-3, u = std::fmod(t, 2.0);
        // Twice out of a depth of 19 mm at 1.5 m/s, then gently in and out by 3 mm.
        double z = u < 0.5 ? 1e-3 - 0.04 * u : u < 0.515 ? -0.019 + 1.5 * (u - 0.5) : 3.5e-3;
        if (t > 4) z = 1e-3 - 4e-3 * std::sin(6.283185307179586 * t);
        const auto got = tank({0, 0, z}, {0, 0, z < 0 ? -500 * z : 0});
        if (!(t > 4 && z < 0)) continue;
        ++contacts;
        empty += got.newtons == glm::dvec3{0.0};
        told += got.owed > 0 && got.shortened;
        held_back = std::max(held_back, got.held_back);
    }
    CHECK(contacts == 6704);
    CHECK(empty == contacts);
    CHECK(told == contacts);
    CHECK(held_back > 1.4);
    CHECK(tank.owed() > 1e-4);
    tank.reset();
    CHECK(tank.owed() == 0);
    CHECK(tank({0, 0, -1e-3}, {0, 0, 0.5}).owed == 0);
}

TEST_CASE("EnergyTank: counts the force that was sent where it is told of one", "[energy_tank]") {
    EnergyTank tank{{.largest_step = 1e-4}};
    double taken = 0;
    for (int k = 0; k < 400; ++k) {
        const auto got = tank({0, 0, -1e-4 * k}, {0, 0, 1});
        const glm::dvec3 sent =
            k % 3 == 0 ? glm::dvec3{0.0} : 0.5 * got.newtons; // a driver that skips and clamps
        tank.sent(sent);
        if (k < 399) taken += sent.z * 1e-4;
    }
    CHECK(tank.level() == Approx(taken).epsilon(1e-9));
    CHECK(taken > 1e-3);
    const double before = tank.level();
    tank.sent({0, 0, 0.2}); // and of one that is charged at the worst when the position is lost
    (void)tank({0, 0, std::numeric_limits<double>::quiet_NaN()}, glm::dvec3{0.0});
    CHECK(tank.level() == Approx(before - 0.2 * 1e-4));
}

TEST_CASE("EnergyTank: holds no more than its capacity, and allocates nothing", "[energy_tank]") {
    const auto before = allocations();
    EnergyTank tank{{.largest_step = 1e-3, .capacity = 0.01}};
    double highest = 0;
    for (int k = 0; k < 100000; ++k) {
        (void)tank({0, 0, -5e-4 * k}, {0, 0, 3});
        highest = std::max(highest, tank.level());
    }
    const auto after = allocations();
    CHECK(after == before);
    CHECK(highest == 0.01);
}
