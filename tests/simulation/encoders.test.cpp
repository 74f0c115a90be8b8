#include "catch.hpp"
#include "support/random.hpp"

#include <hfh/simulation/encoders.hpp>

#include <glm/geometric.hpp>

#include <cmath>
#include <set>

using namespace hfh;
using namespace hfh::test;

namespace {

/// A Phantom's arm behind the workspace, with steps of 0.055 mm at its full reach.
constexpr JointEncoders arm{
    .upper = 0.135, .lower = 0.14, .shoulder = {0, 0.2, 0.02}, .step = 0.055e-3 / 0.275};

} // namespace

TEST_CASE("AxisEncoders: round each axis to its nearest step, without a step to the bit", "[encoders]") {
    const AxisEncoders encoders{1e-4};
    const glm::dvec3 told = encoders({0.00123, -0.00127, 0.00004});
    CHECK(told.x == Approx(0.0012));
    CHECK(told.y == Approx(-0.0013));
    CHECK(told.z == 0);
    const glm::dvec3 at{0.1, 1 / 3.0, -7};
    CHECK(AxisEncoders{}(at) == at);
    CHECK(JointEncoders{}(at) == at);
}

TEST_CASE("JointEncoders: told within half a step of each joint, and by whole counts alone",
          "[encoders][law]") {
    Random random{121};
    JointEncoders fine = arm;
    fine.step = 1e-12;
    for (int n = 0; n < 20000; ++n) {
        const glm::dvec3 at{random.between(-0.08, 0.08), random.between(-0.035, 0.035),
                            random.between(-0.06, 0.06)};
        // Without a step worth the name the kinematics return where they came from.
        CHECK(glm::length(fine(at) - at) < 1e-12);
        const glm::dvec3 told = arm(at);
        const double reach = glm::length(at - arm.shoulder);
        CHECK(glm::length(told - at) <= 0.5 * arm.step * (2 * reach + arm.lower) * 1.001);
        // What is told is told again: it has whole counts.
        CHECK(glm::length(arm(told) - told) < 1e-15);
        // Angles from the told place, by other ways: the elbow from the three sides, the yaw from a tangent.
        const glm::dvec3 from = told - arm.shoulder;
        const double yaw = std::atan2(from.y, from.x) / arm.step;
        const double far = glm::length(from);
        const double elbow =
            2 *
            std::acos(std::sqrt((far * far - (arm.upper - arm.lower) * (arm.upper - arm.lower)) /
                                (4 * arm.upper * arm.lower))) /
            arm.step;
        CHECK(std::abs(yaw - std::round(yaw)) < 1e-6);
        CHECK(std::abs(elbow - std::round(elbow)) < 1e-6);
    }
}

TEST_CASE("JointEncoders: one count of a joint moves every coordinate, and no coordinate has a step",
          "[encoders]") {
    // Straight down by 1 mm: z is told in many different steps, and x and y tremble as well.
    std::set<double> x, y;
    std::set<long> steps_of_z;
    glm::dvec3 before = arm({0.03, 0, 0.01});
    for (int k = 1; k <= 1000; ++k) {
        const glm::dvec3 told = arm({0.03, 0, 0.01 - k * 1e-6});
        x.insert(told.x);
        y.insert(told.y);
        if (told.z != before.z) steps_of_z.insert(std::lround(std::abs(told.z - before.z) * 1e9));
        before = told;
    }
    CHECK(x.size() > 10);
    CHECK(y.size() > 10);
    CHECK(steps_of_z.size() > 4);
}

TEST_CASE("JointEncoders: what the links do not reach is told as far as they do", "[encoders]") {
    const glm::dvec3 away{0, -0.9, 0.3}; // a metre off
    const glm::dvec3 told = arm(arm.shoulder + away) - arm.shoulder;
    CHECK(glm::length(told) == Approx(0.275).epsilon(1e-6));
    CHECK(glm::dot(told, away) / glm::length(told) / glm::length(away) == Approx(1).epsilon(1e-6));
    const glm::dvec3 near{0, -0.001, 0.0005}; // nearer than one link is longer than the other
    const glm::dvec3 close = arm(arm.shoulder + near) - arm.shoulder;
    CHECK(glm::length(close) == Approx(0.005).epsilon(1e-3));
    CHECK(glm::dot(close, near) / glm::length(close) / glm::length(near) == Approx(1).epsilon(1e-3));
}
