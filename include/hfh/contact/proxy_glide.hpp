#ifndef HFH_CONTACT_PROXY_GLIDE_HPP
#define HFH_CONTACT_PROXY_GLIDE_HPP

#include <hfh/contact/proxy_tracker.hpp>

#include <glm/geometric.hpp>

#include <limits>

// When a ridge or a hollow lets go of a proxy, the tracker's proxy is in the next minimum in the same update, and the force
// jumps. Here the proxy that is felt takes the same way at a speed that the hand can follow.

namespace hfh {

/// Everything that a glide remembers: a trivially copyable value.
template <Real T>
struct GlideState {
    SurfacePoint<T> proxy{};   ///< in contact: the proxy that is felt
    vec3<T> stylus{T(0)};      ///< in contact: of the last update
    Side side = Side::none;    ///< in contact: the side on which the surface is felt; else none
    bool is_under_way = false; ///< the proxy that is felt has not come to the tracker's
};

/// Lets the proxy of a contact glide, in metres an update, where the tracker's jumps.
///
///     const auto contact = glide.follow(grid, tracker.update(position), position);
///
/// In an update the proxy moves speed + |the stylus's move| at the most, so that the force steps by no more than
/// stiffness·(speed + 2·|the stylus's move|), however large the cells are. Where the tracker's proxy is nearer than that, the
/// contact is returned as it is. Else the proxy slides downhill from where it was, as the tracker's does and never farther
/// from the stylus, and the contact has its place, normal, penetration and depth there, with the status `descent_limit`:
/// shading, friction, damping and guard take it as they take a proxy on its way under limited work.
///
/// It is felt when the tracker's is: never without contact, never without a force where the tracker has one, and never longer
/// than that. While it glides, the force may point into the face that the proxy is on, as under limited work, but only if the
/// stylus has the surface over it. When the hand rests, the proxy gets to the tracker's after (length of the way)/speed
/// updates, and the contact is the tracker's from then on, to the bit.
///
/// It jumps to the tracker's proxy, as there would be no glide, where its own slide ends elsewhere: in a minimum that the
/// tracker has released, because there is air on the way to the next face, or that it does not know; at a rim or on ground
/// that is gone; where the contact changes sides; and where neither the face on the way holds the stylus nor the surface is over
/// it. First contact begins at
/// the tracker's proxy, release ends it, bad_input leaves it alone.
///
/// Comes right behind the tracker: tracker, glide, shading, friction, then damping with the force. Costs some instructions
/// where the proxy does not glide, and an update of limited work where it does. Does not throw, does not allocate.
template <Real T>
class ProxyGlide {
public:
    using State = GlideState<T>;

    /// So many metres an update, > 0, or 2⁻¹² cells if that is more. Anything else, and ∞: no glide. A proxy that glides looks
    /// at `max_patches` + 16 patches in an update, and goes on in the next.
    constexpr explicit ProxyGlide(double speed = std::numeric_limits<double>::infinity(),
                                  int max_patches = 1024) noexcept
        : speed_{speed}, max_patches_{max_patches} {}

    /// The tracker's contact for the stylus at `stylus` (metres), with the proxy where it has come to. Precondition: the
    /// stylus is finite if the contact touches.
    template <HeightField Field>
    [[nodiscard]] Contact<T> follow(const Field& field, const Contact<T>& contact,
                                    const vec3<T>& stylus) noexcept {
        static_assert(std::same_as<typename Field::Scalar, T>, "glide and field have one scalar");
        if (contact.status == ContactStatus::bad_input) return contact;
        const bool usable = speed_ > 0 && speed_ < std::numeric_limits<double>::infinity();
        if (!contact.touching() || !usable) {
            reset();
            return contact;
        }
        const bool follows = state_.side == contact.side && contact.depth > 0;
        const T most = static_cast<T>(speed_) + glm::length(stylus - state_.stylus);
        state_.stylus = stylus;
        state_.side = contact.side;
        if (follows && !is_within(field, contact.point, most)) {
            const auto found = detail::descend_no_farther(field, stylus, state_.proxy, max_patches_, most);
            state_.is_under_way =
                found.status == DescentStatus::work_limit && is_felt_at(field, found, stylus);
            if (state_.is_under_way) return at_proxy(contact, stylus, found);
        }
        state_.is_under_way = false;
        state_.proxy = contact.point;
        return contact;
    }

    /// Another speed, from the next update on.
    constexpr void set_speed(double metres_per_update) noexcept { speed_ = metres_per_update; }

    /// Forgets the proxy, as after a release.
    constexpr void reset() noexcept { state_ = {}; }

    [[nodiscard]] constexpr const State& state() const noexcept { return state_; }
    constexpr void restore(const State& state) noexcept { state_ = state; }

private:
    /// Whether the proxy that was felt is so near to another surface point.
    template <HeightField Field>
    [[nodiscard]] bool is_within(const Field& field, const SurfacePoint<T>& to, T metres) const noexcept {
        const SurfacePoint<T>& at = state_.proxy;
        const auto from_patch = field.patch(at.cell), to_patch = field.patch(to.cell);
        if (!from_patch || !to_patch) return true;
        const vec3<T> way{to_patch->spacing.x * (static_cast<T>(to.cell.i - at.cell.i) + (to.u - at.u)),
                          to_patch->spacing.y * (static_cast<T>(to.cell.j - at.cell.j) + (to.v - at.v)),
                          to_patch->height(to.u, to.v) - from_patch->height(at.u, at.v)};
        return glm::dot(way, way) <= metres * metres;
    }

    /// Whether a stylus whose contact is felt is so at a point on the way too.
    template <HeightField Field>
    [[nodiscard]] bool is_felt_at(const Field& field, const DescentResult<T>& found,
                                  const vec3<T>& stylus) const noexcept {
        const bool holds = state_.side == Side::below ? found.signed_depth < 0 : found.signed_depth > 0;
        return holds || detail::has_surface_over(field, stylus, state_.side);
    }

    /// The contact with its proxy where the slide has come to.
    [[nodiscard]] Contact<T> at_proxy(const Contact<T>& contact, const vec3<T>& stylus,
                                      const DescentResult<T>& found) noexcept {
        state_.proxy = found.point;
        Contact<T> gliding = contact;
        gliding.status = ContactStatus::descent_limit;
        gliding.patches += found.patches;
        gliding.point = found.point;
        gliding.proxy = stylus + found.offset;
        gliding.normal = contact.side == Side::below ? -found.normal : found.normal;
        gliding.penetration = found.offset;
        gliding.depth = glm::length(found.offset);
        return gliding;
    }

    double speed_;
    int max_patches_;
    State state_{};
};

} // namespace hfh

#endif // HFH_CONTACT_PROXY_GLIDE_HPP
