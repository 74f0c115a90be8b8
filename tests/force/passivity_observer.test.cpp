#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/presses.hpp"
#include "support/random.hpp"

#include <hfh/force/passivity_observer.hpp>

#include <glm/geometric.hpp>

#include <cmath>
#include <limits>

using namespace hfh;
using namespace hfh::test;

TEST_CASE("PassivityObserver: without encoder steps it is the work of held forces, to rounding",
          "[passivity_observer][law]") {
    Random random{92};
    for (int run = 0; run < 100; ++run) {
        PassivityObserver observer;
        long double taken = 0;
        glm::dvec3 at{0.0}, force{0.0};
        for (int k = 0; k < 1000; ++k) {
            const glm::dvec3 to = at + glm::dvec3{random.between(-1e-3, 1e-3),
                                                  random.one_in(2) ? 0 : random.between(-1e-3, 1e-3),
                                                  random.between(-1e-3, 1e-3)};
            for (int axis = 0; axis < 3 && k > 0; ++axis)
                taken -= static_cast<long double>(force[axis]) *
                         (static_cast<long double>(to[axis]) - static_cast<long double>(at[axis]));
            at = to;
            force = {random.between(-3, 3), random.between(-3, 3), random.between(-3, 3)};
            observer.update(at, force);
        }
        CHECK(observer.balance() == Approx(static_cast<double>(taken)).margin(1e-15));
        CHECK(observer.owed() == std::max(0.0, -observer.balance()));
    }
}

TEST_CASE("PassivityObserver: on the Touch it tells what the hand really got, pressing slowly or fast",
          "[passivity_observer]") {
    const double stiffness = 500, q = simulated_touch.capabilities.resolution;
    for (const double speed : {0.005, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0}) {
        PassivityObserver observer{q}, by_steps;
        const Presses hand{.depth = 0.01, .speed = speed};
        const auto real = press_wall(simulated_touch, {}, hand, 10, stiffness,
                                     [&](const glm::dvec3& at, const glm::dvec3& newtons) {
                                         observer.update(at, newtons);
                                         by_steps.update(at, newtons);
                                         return newtons;
                                     });
        CAPTURE(speed, real.last, observer.balance(), by_steps.balance());
        CHECK(real.last < 0);
        CHECK(std::abs(observer.balance() - real.last) <= 0.1 * -real.last + 1e-4);
        // Going by the steps alone, ½K·q² seems lost with each of them.
        if (speed <= 0.02) CHECK(by_steps.balance() < 3 * real.last);
    }
}

TEST_CASE("PassivityObserver: a tremor between two steps costs nothing", "[passivity_observer]") {
    const double q = 0.055e-3, stiffness = 500;
    PassivityObserver observer{q}, by_steps;
    for (int k = 0; k < 4000; ++k) { // one step and back every 80 updates
        const double z = -(20 + k / 40 % 2) * q;
        observer.update({0, 0, z}, {0, 0, -stiffness * z});
        by_steps.update({0, 0, z}, {0, 0, -stiffness * z});
    }
    const double one_step = stiffness * 21 * q * q; // J: what is still to be given back
    CHECK(std::abs(observer.balance()) <= one_step);
    CHECK(by_steps.balance() < one_step - 49 * stiffness * q * q);
}

TEST_CASE("PassivityObserver: does not count what is no number, and allocates nothing",
          "[passivity_observer]") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto before = allocations();
    PassivityObserver observer{nan};
    observer.update({0, 0, 0}, {0, 0, 2});
    observer.update({0, 0, 1e-3}, {0, 0, 2});
    const double given = observer.balance();
    observer.update({0, nan, 5}, {0, 0, 2});
    observer.update({0, 0, 9}, {0, 0, 2}); // the first again
    const double lost = observer.balance();
    observer.update({0, 0, 9.001}, {0, 0, nan});
    observer.update({0, 0, 8}, {0, 0, 1});
    const double ended = observer.balance();
    observer.reset();
    const auto after = allocations();
    CHECK(after == before);
    CHECK(given == Approx(-2e-3));
    CHECK(lost == given);
    CHECK(ended == given);
    CHECK(observer.balance() == 0);
}
