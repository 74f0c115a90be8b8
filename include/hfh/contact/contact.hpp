#ifndef HFH_CONTACT_CONTACT_HPP
#define HFH_CONTACT_CONTACT_HPP

#include <hfh/geometry/surface_point.hpp>

// What one update found, as a value. The tracker finds it and the force evaluator turns it into newtons; both know this
// header and not each other.

namespace hfh {

/// How an update ended. The stylus is in contact with `contact` and `descent_limit` only.
enum class ContactStatus : unsigned char {
    free,    ///< above the surface (sheet: on either side), or on it
    contact, ///< the stylus is inside the surface, and the proxy is the local closest point
    /// In contact, but slide or search used up their work, or the proxy glides (proxy_glide.hpp); they go on from here at the
    /// next update.
    descent_limit,
    sweep_limit, ///< free so far, but the search used up its work; it goes on from there at the next update
    buried, ///< solid: below the surface without having crossed it from above; no contact until it was outside
    off_surface,    ///< no patch above or below: outside the grid or over a hole
    left_at_border, ///< was in contact and slid off the rim of the grid in this update
    left_at_hole, ///< was in contact and slid off the rim of a hole, or the surface under the proxy was removed
    bad_input ///< NaN, infinity, or too far away to number its cell or square its height: refused, state unchanged
};

[[nodiscard]] constexpr const char* to_string(ContactStatus status) noexcept {
    switch (status) {
    case ContactStatus::free: return "free";
    case ContactStatus::contact: return "contact";
    case ContactStatus::descent_limit: return "descent_limit";
    case ContactStatus::sweep_limit: return "sweep_limit";
    case ContactStatus::buried: return "buried";
    case ContactStatus::off_surface: return "off_surface";
    case ContactStatus::left_at_border: return "left_at_border";
    case ContactStatus::left_at_hole: return "left_at_hole";
    case ContactStatus::bad_input: return "bad_input";
    }
    return "unknown";
}

/// What an update found; lengths in metres. Without contact: proxy = stylus, normal = +z, penetration and depth are zero.
/// After bad_input the proxy is zero as well.
template <Real T>
struct Contact {
    ContactStatus status = ContactStatus::free;
    Side side = Side::none; ///< in contact: the side from which the surface is felt; else where the stylus is
    bool shaded = false;    ///< normal and penetration are those of shading (force_shading.hpp)
    int patches = 0;        ///< patches looked at in this update
    vec3<T> proxy{T(0)};    ///< the point that the user feels to be at: on the surface when in contact
    vec3<T> normal{0, 0, 1}; ///< unit, away from the surface on the side where it is felt; averaged over the
                             ///< patches that meet at the proxy (§4.3.3 [P])
    vec3<T> penetration{T(0)}; ///< proxy − stylus, computed before rounding to world coordinates
    T depth{};                 ///< penetration depth: |penetration|
    SurfacePoint<T> point{};   ///< in contact: the proxy's cell and where in it

    [[nodiscard]] constexpr bool touching() const noexcept {
        return status == ContactStatus::contact || status == ContactStatus::descent_limit;
    }
};

} // namespace hfh

#endif // HFH_CONTACT_CONTACT_HPP
