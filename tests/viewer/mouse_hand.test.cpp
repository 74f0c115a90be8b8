#include "catch.hpp"

#include <camera.hpp>
#include <mouse_hand.hpp>

#include <cmath>

using viewer::HandInput;
using viewer::MouseHand;

TEST_CASE("a hand over level ground goes where the ray meets it, hovers, presses and lifts", "[hand]") {
    MouseHand hand{300, {0, 0, 0.02}};
    HandInput input;
    input.has_pointer = true;
    input.pointer = {{0.03, -0.2, 0.2}, glm::normalize(glm::dvec3{0, 1, -1})};
    glm::dvec3 wanted{0.0};
    for (int k = 0; k < 1000; ++k) wanted = hand.update(input, 0, 400, 1e-3);
    CHECK(wanted.x == Approx(0.03).margin(1e-4));
    CHECK(wanted.y == Approx(0).margin(1e-4));
    CHECK(wanted.z > 1e-3);
    input.pressing = true;
    for (int k = 0; k < 300; ++k) wanted = hand.update(input, 0, 400, 1e-3);
    const double early = wanted.z;
    CHECK(early < -1e-3);
    for (int k = 0; k < 2000; ++k) wanted = hand.update(input, 0, 400, 1e-3);
    CHECK(wanted.z < early);
    CHECK(wanted.z > -0.03);
    input.pressing = false;
    for (int k = 0; k < 500; ++k) wanted = hand.update(input, 0, 400, 1e-3);
    CHECK(wanted.z > 1e-3);
}

TEST_CASE("a hand never moves faster than a hand does, and not without a pointer", "[hand]") {
    MouseHand hand{300, {0, 0, 0}};
    HandInput input;
    input.has_pointer = true;
    input.pointer = {{5, 5, 1}, {0, 0, -1}};
    glm::dvec3 before = hand.update(input, 0, 400, 1e-3);
    for (int k = 0; k < 200; ++k) {
        const glm::dvec3 now = hand.update(input, 0, 400, 1e-3);
        CHECK(std::hypot(now.x - before.x, now.y - before.y) <= 0.6e-3 + 1e-12);
        before = now;
    }
    input.has_pointer = false;
    const glm::dvec3 stays = hand.update(input, 0, 400, 1e-3);
    for (int k = 0; k < 50; ++k) before = hand.update(input, 0, 400, 1e-3);
    CHECK(before.x == stays.x);
    CHECK(before.y == stays.y);
}
