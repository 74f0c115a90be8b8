#ifndef HFH_CONTACT_BALL_CONTACT_HPP
#define HFH_CONTACT_BALL_CONTACT_HPP

#include <hfh/contact/contact.hpp>

// What one update of a ball found, as a value.

namespace hfh {

/// A place where a ball touches the surface.
template <Real T>
struct BallTouch {
    SurfacePoint<T> point{};
    vec3<T> normal{0, 0, 1}; ///< unit, from the point to the centre
    T share{};               ///< of the penetration, in metres, ≥ 0: penetration = Σ share·normal
};

/// The contact of a ball: the contact of its centre with the ground raised by the ball, and where the ball touches.
///
/// In contact: `proxy` is the centre, `penetration` is centre − stylus, `normal` its direction, which is that of the force,
/// and `point` the touch with the largest share. So whatever takes a contact takes this one.
template <Real T>
struct BallContact : Contact<T> {
    static constexpr int max_touches = 3;

    BallTouch<T> touches
        [max_touches]{}; ///< with a share above 0, the largest first; on its way (descent_limit) they need not add up
    glm::dvec3 centre{0.0}; ///< in contact: `proxy` before it is rounded to the scalar
    int count = 0;          ///< of `touches`; 0 without contact
    T radius{};             ///< of the ball, in metres
};

} // namespace hfh

#endif // HFH_CONTACT_BALL_CONTACT_HPP
