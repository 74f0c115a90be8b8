#ifndef VIEWER_MOUSE_HAND_HPP
#define VIEWER_MOUSE_HAND_HPP

#include "hand_input.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace viewer {

/// A hand that a pointer moves. It wants to be where the pointer's ray meets a level plane at the height of the ground under
/// the stylus. That plane rises and falls with the ground, so the stylus comes to rest at the point that is seen under the
/// pointer, without a jump on the way. (Where ground is seen, the ray falls faster than the ground does, and then the two
/// approach each other.)
///
/// It hovers over the ground until the button is down, and then presses: lightly at first, and more firmly the longer the
/// button stays down. Pressing means wanting to be below the ground, by as much as hand and ground give way.
class MouseHand {
public:
    /// A hand held by a spring of `grip` N/m, which is at `start`.
    MouseHand(double grip, const glm::dvec3& start) noexcept
        : grip_{grip}, wanted_{start}, ground_{start.z} {}

    /// One update of `seconds`. `ground`: m at the hand, the height of the ground under the stylus. `stiffness`: N/m of the
    /// ground at the hand.
    const glm::dvec3& update(const HandInput& input, double ground, double stiffness,
                             double seconds) noexcept {
        ground_ += (ground - ground_) * share(seconds, follow_time);
        pressed_ = input.pressing ? pressed_ + seconds : 0;
        const double aim =
            input.pressing ? -press_newtons(input.firmness) * (1 / grip_ + 1 / stiffness) : hover;
        depth_ += (aim - depth_) * share(seconds, input.pressing ? press_time : lift_time);

        glm::dvec3 goal = wanted_;
        const PointerRay& ray = input.pointer;
        if (input.has_pointer && ray.direction.z < -1e-3) {
            const double t = (ground_ - ray.from.z) / ray.direction.z;
            if (t > 0) goal = ray.from + t * ray.direction;
        }
        // A pointer moves from frame to frame, and the hand evenly.
        glm::dvec2 way = (glm::dvec2{goal} - glm::dvec2{wanted_}) * share(seconds, pointer_time);
        const double far = glm::length(way), most = max_speed * seconds;
        if (far > most) way *= most / far;
        wanted_ = {wanted_.x + way.x, wanted_.y + way.y, ground_ + depth_};
        return wanted_;
    }

    /// The terrain has moved up by `up` metres at the hand, and the hand with it.
    void shift(double up) noexcept { ground_ += up; }

private:
    static constexpr double hover = 4e-3;       ///< m over the ground
    static constexpr double follow_time = 0.04; ///< s in which the hand learns how high the ground is
    static constexpr double press_time = 0.06;  ///< s in which it comes down
    static constexpr double lift_time = 0.04;
    static constexpr double pointer_time = 0.025; ///< s in which it comes to where the pointer is
    static constexpr double max_speed = 0.6;      ///< m/s
    static constexpr double firmer_by = 1.5;      ///< N more after some seconds
    static constexpr double firmer_time = 1.5;    ///< s

    [[nodiscard]] static double share(double seconds, double time) noexcept {
        return -std::expm1(-seconds / time);
    }
    [[nodiscard]] double press_newtons(double firmness) const noexcept {
        return firmness - firmer_by * std::expm1(-pressed_ / firmer_time);
    }

    double grip_;
    glm::dvec3 wanted_;
    double ground_;        ///< m at the hand
    double depth_ = hover; ///< m over the ground
    double pressed_ = 0;   ///< s
};

} // namespace viewer

#endif // VIEWER_MOUSE_HAND_HPP
