#ifndef HFH_CONTACT_BALL_SHADING_HPP
#define HFH_CONTACT_BALL_SHADING_HPP

#include <hfh/contact/ball_contact.hpp>
#include <hfh/contact/force_shading.hpp>

#include <glm/geometric.hpp>

#include <optional>

namespace hfh {

namespace detail {

/// The unit normal of shading for a ball: the sum of those of its touching points, by their shares. Empty where there is none.
template <HeightField Field>
[[nodiscard]] std::optional<vec3<typename Field::Scalar>>
shaded_normal(const Field& field, const BallContact<typename Field::Scalar>& contact) noexcept {
    using T = typename Field::Scalar;
    vec3<T> sum{T(0)};
    for (int k = 0; k < contact.count; ++k) {
        const BallTouch<T>& touch = contact.touches[k];
        const auto slopes = shaded_slopes(field, touch.point);
        const auto normal = slopes ? shaded_normal(*slopes, contact.side, touch.normal) : std::nullopt;
        sum += touch.share * normal.value_or(touch.normal);
    }
    const T length = glm::length(sum);
    if (!(length > 0) || !is_finite(length)) return std::nullopt;
    return sum / length;
}

} // namespace detail

/// A ball's contact with the shaded normal:
///
///     normal = Σ share·shadedᵢ / |…|,   penetration = depth·normal,   depth, proxy, touches and point as they were
///
/// where shadedᵢ is the normal that `shade_force` of a point gives the i-th touch. It pushes into none of the faces that the ball
/// touches, and the ball is where it is, so it penetrates nothing. With radius 0 it is the shading of a point.
template <HeightField Field>
[[nodiscard]] BallContact<typename Field::Scalar>
shade_force(const Field& field, const BallContact<typename Field::Scalar>& contact) noexcept {
    using T = typename Field::Scalar;
    BallContact<T> shaded = contact;
    if (!(contact.radius > 0)) {
        static_cast<Contact<T>&>(shaded) = shade_force(field, static_cast<const Contact<T>&>(contact));
        return shaded;
    }
    if (!contact.touching() || contact.shaded) return contact;
    const auto normal = detail::shaded_normal(field, contact);
    if (!normal) return contact;
    shaded.shaded = true;
    shaded.normal = *normal;
    shaded.penetration = contact.depth * shaded.normal;
    return shaded;
}

} // namespace hfh

#endif // HFH_CONTACT_BALL_SHADING_HPP
