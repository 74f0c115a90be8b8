#ifndef HFH_CONTACT_BALL_SHADING_HPP
#define HFH_CONTACT_BALL_SHADING_HPP

#include <hfh/contact/ball_contact.hpp>
#include <hfh/contact/force_shading.hpp>

#include <glm/geometric.hpp>

namespace hfh {

/// A ball's contact with the shaded normal: the sum of those of its touching points, by their shares.
///
///     normal = Σ share·shadedᵢ / |…|,   penetration = depth·normal,   depth, proxy, touches and point as they were
///
/// where shadedᵢ is the normal that `shade_force` gives the i-th point. The ball is where it is, so it penetrates nothing. With
/// one touch, and with radius 0, it is the shading of a point.
template <HeightField Field>
[[nodiscard]] BallContact<typename Field::Scalar>
shade_force(const Field& field, const BallContact<typename Field::Scalar>& contact) noexcept {
    using T = typename Field::Scalar;
    BallContact<T> shaded = contact;
    if (contact.count <= 1) {
        static_cast<Contact<T>&>(shaded) = shade_force(field, static_cast<const Contact<T>&>(contact));
        return shaded;
    }
    vec3<T> sum{T(0)};
    for (int k = 0; k < contact.count; ++k) {
        Contact<T> touch = contact;
        touch.point = contact.touches[k].point;
        touch.normal = contact.touches[k].normal;
        sum += contact.touches[k].share * shade_force(field, touch).normal;
    }
    const T length = glm::length(sum);
    if (!(length > 0) || !is_finite(length)) return contact;
    shaded.normal = sum / length;
    shaded.penetration = contact.depth * shaded.normal;
    return shaded;
}

} // namespace hfh

#endif // HFH_CONTACT_BALL_SHADING_HPP
