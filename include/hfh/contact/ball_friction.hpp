#ifndef HFH_CONTACT_BALL_FRICTION_HPP
#define HFH_CONTACT_BALL_FRICTION_HPP

#include <hfh/contact/ball_shading.hpp>
#include <hfh/contact/ball_touches.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/traversal/ball_slide.hpp>

#include <glm/geometric.hpp>

#include <limits>

// Based on: Harwin and Melder, Improved Haptic Rendering for Multi-Finger Manipulation Using Friction Cone Based
// God-Objects (2002), for a ball that touches in several places.

namespace hfh {

/// Everything that a ball's friction remembers: a trivially copyable value.
template <Real T>
struct BallFrictionState {
    glm::dvec3 centre{0.0};   ///< in contact: where friction holds the ball
    Side side = Side::none;   ///< in contact: the side on which the surface is felt; else none
    bool slipping = false;    ///< the centre moved in the last update
    FrictionState<T> point{}; ///< with radius 0: all that there is
};

/// Coulomb friction for a ball: holds it back where it touches the ground.
///
///     const auto contact = friction.hold(grid, tracker.update(position), position);
///
/// The ball is held at a centre c as long as the force c − stylus lies in the friction cone of what it touches there. With the
/// force as the sum of a part against the touching points, Σ share·normal with shares ≥ 0, and a part t across them that is as
/// short as can be, that is
///
///     |t| ≤ coefficient·|Σ share·normal|
///
/// In a valley only the part of the force along the valley is across both sides, so the ball slips at the same angle however
/// steep these are; in a pit no part is. Outside the cone of the static coefficient the ball slips: it slides over the ground
/// from where it was held, as the tracker's does, towards the stylus, until it is inside that of the dynamic one. So it never
/// penetrates. After a slip the dynamic coefficient decides until the stylus is found inside its cone.
///
/// First contact sets the centre to the contact's, release clears it, bad_input leaves it alone. It is set to the contact's (no
/// hold for this update) where the ground was raised under the ball that is held, where the slip comes to no end, where the
/// contact changes sides, and where the radius was 0 or is now.
///
/// The result has proxy, touches and point of the ball that is held; its penetration is centre − stylus, and its normal that of
/// Σ share·normal, so penetration·normal ≥ 0. A contact that was shaded before has the shaded normals of these touches in their
/// place, in Σ share·normal only, where that leaves penetration·normal ≥ 0. A contact without touch, depth or friction is
/// returned as it is. With radius 0, `Friction` holds it. Costs a look around the ball, and one for each step of a slip. Does
/// not throw, does not allocate.
template <Real T>
class BallFriction {
public:
    using Coefficients = typename Friction<T>::Coefficients;

    constexpr explicit BallFriction(const Coefficients& coefficients = {}) noexcept
        : point_{coefficients}, coefficients_{coefficients} {}

    /// The tracker's contact for the stylus at `stylus` (metres), held back. Precondition: the stylus is finite if the
    /// contact touches.
    template <HeightField Field>
    [[nodiscard]] BallContact<T> hold(const Field& field, const BallContact<T>& contact,
                                      const vec3<T>& stylus) noexcept;

    /// Forgets where the ball is held, as after a release.
    constexpr void reset() noexcept { state_ = {}; }
    [[nodiscard]] constexpr const BallFrictionState<T>& state() const noexcept { return state_; }
    constexpr void restore(const BallFrictionState<T>& state) noexcept { state_ = state; }

private:
    /// Where friction holds the ball now, if it does; `slide` is there then.
    template <HeightField Field>
    [[nodiscard]] bool holds(detail::BallSlide<Field>& slide, const BallContact<T>& contact,
                             const glm::dvec3& stylus) noexcept;

    Friction<T> point_;
    Coefficients coefficients_;
    BallFrictionState<T> state_{};
};

template <Real T>
template <HeightField Field>
BallContact<T> BallFriction<T>::hold(const Field& field, const BallContact<T>& contact,
                                     const vec3<T>& stylus) noexcept {
    static_assert(std::same_as<typename Field::Scalar, T>, "friction and field have one scalar");
    if (contact.status == ContactStatus::bad_input) return contact;
    BallContact<T> held = contact;
    if (!(contact.radius > 0)) {
        point_.restore(state_.point);
        static_cast<Contact<T>&>(held) = point_.hold(field, contact, stylus);
        state_ = {.point = point_.state()};
        return held;
    }
    const bool usable = is_at_least_zero(coefficients_.at_rest) && is_at_least_zero(coefficients_.sliding);
    if (!contact.touching() || !usable) {
        reset();
        return contact;
    }
    const bool first = state_.side != contact.side || !(contact.depth > 0);
    state_.side = contact.side;
    state_.point = {};
    // Beside a rim a solid and a sheet differ, and there a slip that leads round it is none.
    const SurfaceKind surface = contact.side == Side::below ? SurfaceKind::sheet : SurfaceKind::solid;
    detail::BallSlide<Field> slide{field,
                                   {widen(contact.radius), surface, contact.side},
                                   state_.centre,
                                   std::numeric_limits<Index>::max()};
    if (first || !holds(slide, contact, widen(stylus))) {
        state_.centre = contact.centre;
        state_.slipping = false;
        return contact;
    }
    state_.centre = slide.centre();
    detail::list_touches(slide, held);
    const vec3<T> force{slide.centre() - widen(stylus)};
    vec3<T> against{T(0)};
    for (int k = 0; k < held.count; ++k) against += held.touches[k].share * held.touches[k].normal;
    const T size = glm::length(against);
    held.penetration = force;
    held.shaded = false;
    if (size > 0) held.normal = against / size;
    if (contact.shaded) {
        const vec3<T> normal = detail::shaded_normal(field, held).value_or(held.normal);
        const vec3<T> shaded = force + size * (normal - held.normal);
        if (glm::dot(shaded, normal) >= 0) {
            held.shaded = true;
            held.normal = normal;
            held.penetration = shaded;
        }
    }
    held.depth = glm::length(held.penetration);
    return held;
}

template <Real T>
template <HeightField Field>
bool BallFriction<T>::holds(detail::BallSlide<Field>& slide, const BallContact<T>& contact,
                            const glm::dvec3& stylus) noexcept {
    constexpr int max_steps = 64;
    const double sliding = widen(coefficients_.sliding),
                 at_rest = glm::max(widen(coefficients_.at_rest), sliding);
    const double margin = glm::distance(slide.centre(), contact.centre) + widen(contact.radius) / 64;
    if (!slide.look(margin) || slide.overlaps()) return false;
    if (at_rest > 0 &&
        slide.run(stylus, true, 0, state_.slipping ? sliding : at_rest) == detail::BallSlideEnd::minimum) {
        state_.slipping = false;
        return true;
    }
    state_.slipping = true;
    return slide.run(stylus, true, max_steps, sliding) == detail::BallSlideEnd::minimum;
}

} // namespace hfh

#endif // HFH_CONTACT_BALL_FRICTION_HPP
