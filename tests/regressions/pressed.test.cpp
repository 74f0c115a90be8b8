#include "catch.hpp"
#include "support/terrains.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/device/force_guard.hpp>
#include <hfh/device/workspace.hpp>
#include <hfh/force/force_evaluator.hpp>

#include <algorithm>
#include <cmath>

// Ground that is pressed, as a hand feels it: what attacks from outside found.

using namespace hfh;
using namespace hfh::test;

TEST_CASE("proxy_tracker: pressed on after a rest with limited work, the depth grows as the hand moves",
          "[proxy_tracker][limited][regression]") {
    // The stylus was dropped at rest, and came back with a depth of more than a cell at once.
    auto made = plane<double>(26, 49, 0, {.spacing = {0.037022154992908451, 0.037022154992908451}});
    made.at(16, 22) = -0.1;
    made.at(18, 25) = made.at(23, 29) = 1;
    made.at(22, 30) = -0.074;
    made.at(23, 30) = -0.4;
    made.at(22, 31) = -2;
    const double step = 0.02 * made.frame.spacing.x;
    const auto grid = made.grid();
    for (const int limit : {1, 2, 4, 8, 8192}) {
        CAPTURE(limit);
        ProxyTracker tracker{grid, {.max_contact_patches = limit}};
        for (const vec3<double>& way : {vec3<double>{0, 0, 0}, {0.56, 0.8, 0}, {0.8, 1, -2}})
            (void)tracker.update(way);
        vec3<double> stylus{0.9, 1.25, -0.05};
        for (int k = 0; k < 300; ++k) (void)tracker.update(stylus);
        double before = tracker.update(stylus).depth;
        double steepest = 0;
        int unfelt = 0;
        for (int k = 0; k < 400; ++k) {
            stylus.z -= step;
            const auto contact = tracker.update(stylus);
            unfelt += !(contact.touching() && contact.depth > 0);
            steepest = std::max(steepest, contact.depth - before);
            before = contact.depth;
        }
        CHECK(unfelt == 0);
        CHECK(steepest <= step * (1 + 1e-9));
    }
}

TEST_CASE("workspace: pressed, the clutch takes the force away, and the guard's ramp brings it back",
          "[workspace][force_guard][regression]") {
    const auto ground = plane<double>(64, 64, 100, {.spacing = {10, 10}});
    const auto grid = ground.grid();
    Workspace<double> workspace{{.scale = 4000, .offset = {320, 320, 110}}};
    ProxyTracker tracker{grid, {.max_contact_patches = 8}};
    const ForceEvaluator<double> force{.stiffness = workspace.terrain_stiffness(400)};
    const GuardLimits limits{.max_force = 3.3, .max_slew = 1, .ramp = 0.5};
    ForceGuard guard{limits};
    double last = 0, steepest = 0, pressed = 0;
    for (int n = 0; n < 5000; ++n) {
        const auto part = [n](int begin, int length) {
            return std::clamp(static_cast<double>(n - begin) / length, 0.0, 1.0);
        };
        // Down 12 mm; with the clutch up 3 cm; and at rest there when it is released.
        const glm::dvec3 hand{0, 0, 0.005 - 0.012 * part(1000, 200) + 0.03 * part(2000, 500)};
        const bool clutch = n >= 1900 && n < 3000;
        const auto contact = tracker.update(workspace.update(hand, clutch));
        const auto asked = clutch ? glm::dvec3{0.0} : workspace.force_at_hand(force(contact).newtons);
        const auto sent = guard.update({.time = 0.001 * n, .position = hand}, asked,
                                       contact.status == ContactStatus::buried);
        if (clutch) guard.restart();
        const double now = clutch ? 0.0 : sent.newtons.z;
        if (n == 1899) pressed = now;
        if (n >= 1900) steepest = std::max(steepest, now - last);
        if (clutch) CHECK(now == 0);
        last = now;
    }
    CHECK(pressed > 1);
    CHECK(last == Approx(pressed)); // the terrain position is where it was
    CHECK(steepest <= limits.max_force * 0.001 / limits.ramp * (1 + 1e-9));
}
