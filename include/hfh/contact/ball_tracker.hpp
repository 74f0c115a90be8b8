#ifndef HFH_CONTACT_BALL_TRACKER_HPP
#define HFH_CONTACT_BALL_TRACKER_HPP

#include <hfh/contact/ball_contact.hpp>
#include <hfh/contact/proxy_tracker.hpp>

// Based on: Ruspini, Kolarov and Khatib, The Haptic Display of Complex Graphical Environments (1997): a proxy with a
// radius, moved by half-spaces.

namespace hfh {

/// Follows a stylus with a ball of radius r at its end over a height field. The proxy is the ball's centre c.
///
///     minimise |c − stylus|  subject to  |c − x| ≥ r for every point x of the surface, and c on its own side
///
/// locally: the centre slides there from where it was and never gets farther from the stylus.
template <HeightField Field>
class BallTracker {
public:
    using Scalar = typename Field::Scalar;

    /// `radius` in metres, ≥ 0 and finite; anything else counts as 0.
    constexpr BallTracker(const Field& field, Scalar radius, const TrackerOptions& options = {}) noexcept;
    BallTracker(const Field&&, Scalar, const TrackerOptions& = {}) = delete; // the field must outlive the tracker

    /// One haptic update: the stylus is at `stylus` (world coordinates, metres).
    [[nodiscard]] BallContact<Scalar> update(const vec3<Scalar>& stylus) noexcept;

    /// Between updates, in contact as well: a ball that grows is lifted until it is clear.
    void set_radius(Scalar radius) noexcept;
    [[nodiscard]] constexpr Scalar radius() const noexcept;
    /// The centre of the ball in world coordinates, metres, in double: free: the stylus; in contact: the proxy.
    [[nodiscard]] constexpr glm::dvec3 centre() const noexcept;

    constexpr void reset() noexcept;
    [[nodiscard]] constexpr const Field& field() const noexcept;
};

} // namespace hfh

#endif // HFH_CONTACT_BALL_TRACKER_HPP
