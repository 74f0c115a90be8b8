#ifndef HFH_CONTACT_BALL_GLIDE_HPP
#define HFH_CONTACT_BALL_GLIDE_HPP

#include <hfh/contact/ball_touches.hpp>
#include <hfh/contact/proxy_glide.hpp>
#include <hfh/traversal/ball_slide.hpp>

#include <glm/geometric.hpp>

#include <limits>

namespace hfh {

/// Everything that the glide of a ball remembers: a trivially copyable value.
template <Real T>
struct BallGlideState {
    glm::dvec3 centre{0.0};    ///< in contact: where the ball is felt to be
    glm::dvec3 stylus{0.0};    ///< in contact: of the last update
    Side side = Side::none;    ///< in contact: the side on which the surface is felt; else none
    bool is_under_way = false; ///< the ball that is felt has not come to the tracker's
    GlideState<T> point{};     ///< with radius 0: all that there is
};

/// Lets the ball of a contact glide, in metres an update, where the tracker's jumps: `ProxyGlide` for a ball.
///
/// In an update the centre moves speed + |the stylus's move| at the most, but for what pushes it clear. Where the tracker's
/// is nearer than that, the contact is returned as it is. Else the ball slides from where it was as the tracker's does, never
/// farther from the stylus and penetrating nothing, and the contact is that of its place, with the status `descent_limit`. It
/// jumps to the tracker's where its own slide ends elsewhere, at a rim, on ground that was raised, and where the contact changes
/// sides. With radius 0 it is a `ProxyGlide`, to the bit.
template <Real T>
class BallGlide {
public:
    constexpr explicit BallGlide(double speed = std::numeric_limits<double>::max()) noexcept
        : point_{speed}, speed_{speed} {}

    /// The tracker's contact for the stylus at `stylus` (metres), with the ball where it has come to. Precondition: the stylus
    /// is finite if the contact touches.
    template <HeightField Field>
    [[nodiscard]] BallContact<T> follow(const Field& field, const BallContact<T>& contact,
                                        const vec3<T>& stylus) noexcept;

    /// Another speed, from the next update on.
    constexpr void set_speed(double metres_per_update) noexcept {
        speed_ = metres_per_update;
        point_.set_speed(metres_per_update);
    }
    /// Forgets the ball, as after a release.
    constexpr void reset() noexcept { state_ = {}; }
    [[nodiscard]] constexpr const BallGlideState<T>& state() const noexcept { return state_; }
    constexpr void restore(const BallGlideState<T>& state) noexcept { state_ = state; }

private:
    ProxyGlide<T> point_;
    double speed_;
    BallGlideState<T> state_{};
};

template <Real T>
template <HeightField Field>
BallContact<T> BallGlide<T>::follow(const Field& field, const BallContact<T>& contact,
                                    const vec3<T>& stylus) noexcept {
    static_assert(std::same_as<typename Field::Scalar, T>, "glide and field have one scalar");
    if (contact.status == ContactStatus::bad_input) return contact;
    BallContact<T> gliding = contact;
    if (!(contact.radius > 0)) {
        point_.restore(state_.point);
        static_cast<Contact<T>&>(gliding) = point_.follow(field, contact, stylus);
        state_ = {.is_under_way = point_.state().is_under_way, .point = point_.state()};
        return gliding;
    }
    const bool usable = speed_ > 0 && speed_ < std::numeric_limits<double>::max();
    if (!contact.touching() || !usable) {
        reset();
        return contact;
    }
    state_.point = {};
    const glm::dvec3 to = widen(stylus);
    const bool follows = state_.side == contact.side && contact.depth > 0;
    const double most = speed_ + glm::distance(to, state_.stylus);
    state_.stylus = to;
    state_.side = contact.side;
    state_.is_under_way = false;
    if (follows && glm::distance(state_.centre, contact.centre) > most) {
        const SurfaceKind surface = contact.side == Side::below ? SurfaceKind::sheet : SurfaceKind::solid;
        detail::BallSlide<Field> slide{field,
                                       {widen(contact.radius), surface, contact.side},
                                       state_.centre,
                                       std::numeric_limits<Index>::max()};
        state_.is_under_way = slide.glide(to, most);
        if (state_.is_under_way) {
            detail::list_touches(slide, gliding);
            gliding.status = ContactStatus::descent_limit;
            gliding.penetration = vec3<T>{slide.centre() - to};
            gliding.depth = glm::length(gliding.penetration);
            if (gliding.depth > 0) gliding.normal = gliding.penetration / gliding.depth;
            state_.centre = slide.centre();
            return gliding;
        }
    }
    state_.centre = contact.centre;
    return contact;
}

} // namespace hfh

#endif // HFH_CONTACT_BALL_GLIDE_HPP
