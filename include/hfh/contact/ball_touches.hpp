#ifndef HFH_CONTACT_BALL_TOUCHES_HPP
#define HFH_CONTACT_BALL_TOUCHES_HPP

#include <hfh/contact/ball_contact.hpp>
#include <hfh/traversal/ball_slide.hpp>

namespace hfh::detail {

/// Writes down what holds a ball where a slide has come to: centre, touches and the main one's point. Without any the point
/// stays as it was.
template <HeightField Field>
void list_touches(const BallSlide<Field>& slide, BallContact<typename Field::Scalar>& contact) noexcept {
    using T = typename Field::Scalar;
    contact.centre = slide.centre();
    contact.proxy = vec3<T>{slide.centre()};
    contact.count = 0;
    const PolyhedronPoint& held = slide.held();
    for (int k = 0; k < held.count; ++k) {
        const BallObstacle& obstacle = slide.around()[held.faces[k]];
        // On its way the ball may be about to touch.
        if (!(held.shares[k] > 0) || obstacle.gap > widen(contact.radius) / 1024) continue;
        const auto& point = obstacle.point;
        const BallTouch<T> touch{{point.cell, static_cast<T>(point.u), static_cast<T>(point.v)},
                                 vec3<T>{obstacle.normal},
                                 static_cast<T>(held.shares[k])};
        int at = contact.count++;
        for (; at > 0 && contact.touches[at - 1].share < touch.share; --at)
            contact.touches[at] = contact.touches[at - 1];
        contact.touches[at] = touch;
    }
    if (contact.count > 0) contact.point = contact.touches[0].point;
}

} // namespace hfh::detail

#endif // HFH_CONTACT_BALL_TOUCHES_HPP
