#ifndef HFH_SIMULATION_ENCODERS_HPP
#define HFH_SIMULATION_ENCODERS_HPP

#include <hfh/geometry/scalar.hpp>

#include <algorithm>
#include <cmath>

// A position as a device's encoders tell it.

namespace hfh {

/// x, y and z, each rounded to the nearest multiple of a step.
struct AxisEncoders {
    double step = 0; ///< metres, ≥ 0; 0: told as it is

    [[nodiscard]] bool valid() const noexcept { return is_at_least_zero(step); }
    [[nodiscard]] glm::dvec3 operator()(const glm::dvec3& position) const noexcept {
        if (!(step > 0)) return position;
        return {std::round(position.x / step) * step, std::round(position.y / step) * step,
                std::round(position.z / step) * step};
    }
};

/// Three joints, each rounded to the nearest multiple of a step: a shoulder that turns about the vertical and lifts the
/// first of two links, and an elbow between the two, as in a Phantom. A step of a joint is no step of x, y or z: it
/// moves the told position along a circle, by `step` times the distance from the joint.
struct JointEncoders {
    double upper = 0.135;     ///< metres, > 0: the link from the shoulder to the elbow
    double lower = 0.135;     ///< metres, > 0: from the elbow to the end effector
    glm::dvec3 shoulder{0.0}; ///< metres
    double step = 0;          ///< radians, ≥ 0; 0: told as it is

    [[nodiscard]] bool valid() const noexcept {
        return is_at_least_zero(upper) && upper > 0 && is_at_least_zero(lower) && lower > 0 &&
               is_finite(shoulder) && is_at_least_zero(step);
    }
    /// A position out of reach is told as the nearest one within reach on the ray from the shoulder.
    [[nodiscard]] glm::dvec3 operator()(const glm::dvec3& position) const noexcept {
        if (!(step > 0)) return position;
        const glm::dvec3 from = position - shoulder;
        const double out = std::hypot(from.x, from.y), distance = std::hypot(out, from.z);
        // By the law of cosines: the angle at the elbow, less a straight arm, and the shoulder's part of it.
        const double bend = (distance * distance - upper * upper - lower * lower) / (2 * upper * lower);
        const double elbow = std::acos(std::clamp(bend, -1.0, 1.0));
        const double lift =
            std::atan2(from.z, out) + std::atan2(lower * std::sin(elbow), upper + lower * std::cos(elbow));
        const double yaw = rounded(std::atan2(from.y, from.x)), raised = rounded(lift), bent = rounded(elbow);
        const double reach = upper * std::cos(raised) + lower * std::cos(raised - bent);
        return shoulder + glm::dvec3{reach * std::cos(yaw), reach * std::sin(yaw),
                                     upper * std::sin(raised) + lower * std::sin(raised - bent)};
    }

private:
    [[nodiscard]] double rounded(double angle) const noexcept { return std::round(angle / step) * step; }
};

} // namespace hfh

#endif // HFH_SIMULATION_ENCODERS_HPP
