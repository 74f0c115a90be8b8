#ifndef HFH_CONTACT_FRICTION_HPP
#define HFH_CONTACT_FRICTION_HPP

#include <hfh/contact/contact.hpp>
#include <hfh/contact/friction_cone.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

// Based on: Harwin and Melder, Improved Haptic Rendering for Multi-Finger Manipulation Using Friction Cone Based
// God-Objects (2002): the proxy stays where it is as long as the stylus is inside the friction cone under it. The
// frictionless proxy is the tracker's; friction only holds it back.

namespace hfh {

/// Everything that friction remembers: a trivially copyable value.
template <Real T>
struct FrictionState {
    SurfacePoint<T>
        anchor{}; ///< touching: the proxy that is held back; moves with its ground when that is edited
    Side side = Side::none; ///< touching: the side that is felt; else none
    bool slipping = false;  ///< the anchor moved in the last update
};

/// Coulomb friction: holds the proxy of a contact back inside the friction cone.
///
///     const auto contact = friction.hold(grid, tracker.update(position), position);
///     device.send(force(contact).newtons);
///
/// The anchor is a surface point. While the stylus is inside the cone of the static coefficient under it,
/// |tangential part of (anchor − stylus)| ≤ at_rest·(normal part), it stays, to the bit. When it is not, the
/// anchor slips: along the surface over the straight way in plan to the tracker's proxy, to the first point that has
/// the stylus inside the cone of the dynamic coefficient (within 8 roundings); as far as the proxy itself if none
/// has, where only the frictionless force is left. While it slips the dynamic coefficient goes on to hold, until the
/// stylus is found inside its cone. So a hand at rest feels no drift and one that slides feels
/// |tangential force| = sliding·(normal force).
///
/// Where patches meet, on an edge or a vertex, every normal between theirs is the ground's, so a cone hangs from
/// each: in a valley only the part along the valley is tangential, and it slips at the same angle however steep the
/// sides are; in a pit nothing is. A way to a proxy in a valley therefore first follows the face down into it.
///
/// First contact sets the anchor to the proxy, release clears it, bad_input leaves it alone. It is also set to the
/// proxy (no hold for this update) where the way to it leads over a hole or the rim, is longer than max_cells cells,
/// if the ground under the anchor is gone, and on a change of sides. Of a cell on the way both ends and the point
/// nearest to the stylus are looked at; a cone that is entered and left between these is passed over.
///
/// The result has proxy and point of the anchor, and penetration + (anchor − proxy); normal stays. So a contact that
/// was shaded (force_shading.hpp) before keeps its shading. Without contact, depth or friction the contact is
/// returned as it is. Does not throw, does not allocate; costs O(cells between anchor and proxy) ≤ max_cells.
template <Real T>
class Friction {
public:
    using State = FrictionState<T>;

    /// Coefficients of Coulomb friction, ≥ 0 and finite; otherwise there is no friction. A static coefficient below
    /// the dynamic one counts as equal to it.
    struct Coefficients {
        T at_rest = T(0.5);
        T sliding = T(0.4);
    };

    constexpr explicit Friction(const Coefficients& coefficients = {}, int max_cells = 64) noexcept
        : coefficients_{coefficients}, max_cells_{max_cells} {}

    /// The contact that the tracker found for the stylus at `stylus`, held back. The stylus is finite if it touches.
    template <HeightField Field>
    [[nodiscard]] Contact<T> hold(const Field& field, const Contact<T>& contact,
                                  const vec3<T>& stylus) noexcept {
        static_assert(std::same_as<typename Field::Scalar, T>, "friction and field have one scalar");
        if (contact.status == ContactStatus::bad_input) return contact;
        const bool usable =
            is_at_least_zero(coefficients_.at_rest) && is_at_least_zero(coefficients_.sliding);
        if (!contact.touching() || !usable) {
            reset();
            return contact;
        }
        const bool first = state_.side != contact.side || !(contact.depth > 0);
        state_.side = contact.side;
        if (first || !stays(field, stylus)) {
            state_.slipping = !first;
            state_.anchor = first ? contact.point : slip(field, contact.point, stylus);
        } else {
            state_.slipping = false;
        }
        return held(field, contact, stylus);
    }

    /// Lets go of the ground.
    constexpr void reset() noexcept { state_ = {}; }

    [[nodiscard]] constexpr const State& state() const noexcept { return state_; }
    constexpr void restore(const State& state) noexcept { state_ = state; }

private:
    template <HeightField Field>
    [[nodiscard]] bool stays(const Field& field, const vec3<T>& stylus) const noexcept {
        const auto patch = field.patch(state_.anchor.cell);
        if (!patch) return false;
        const T coefficient =
            state_.slipping ? coefficients_.sliding : std::max(coefficients_.at_rest, coefficients_.sliding);
        const CellPoint<T> below = field.lattice().locate(stylus, state_.anchor.cell);
        return friction_cone(field, *patch, below, state_.anchor, state_.side).outside(coefficient) <= 0;
    }

    /// The first point that holds the stylus on the way from the anchor to `to`, or `to`.
    template <HeightField Field>
    [[nodiscard]] SurfacePoint<T> slip(const Field& field, const SurfacePoint<T>& to,
                                       const vec3<T>& stylus) const noexcept {
        int cells = max_cells_;
        SurfacePoint<T> at = state_.anchor;
        const SurfacePoint<T> corner = meets_crease(field, to, stylus);
        if (walk(field, corner, stylus, at, cells) || walk(field, to, stylus, at = corner, cells)) return at;
        return to;
    }

    /// Where the way bends: `to` if that is within a cell. If it is on a crease, the anchor is drawn down the face that
    /// it is on, to where the stylus has its foot on the plane of that, and meets the crease between the point
    /// beside the anchor and `to`.
    template <HeightField Field>
    [[nodiscard]] SurfacePoint<T> meets_crease(const Field& field, const SurfacePoint<T>& to,
                                               const vec3<T>& stylus) const noexcept {
        const SurfacePoint<T>& from = state_.anchor;
        const bool on_x = !(to.u > 0 && to.u < 1), on_y = !(to.v > 0 && to.v < 1);
        if (!on_x && !on_y) return to;
        const auto patch = field.patch(from.cell);
        if (!patch) return to;
        const FrictionCone<T> cone{*patch, field.lattice().locate(stylus, from.cell), from.u, from.v};
        const vec3<T> drawn = glm::dot(cone.offset, cone.normal) * cone.normal - cone.offset;
        if (!is_finite(drawn)) return to;
        const vec2<T> by{drawn.x / patch->spacing.x, drawn.y / patch->spacing.y}; // in cells
        const vec2<T> way{static_cast<T>(to.cell.i - from.cell.i) + (to.u - from.u),
                          static_cast<T>(to.cell.j - from.cell.j) + (to.v - from.v)};
        const T never = std::numeric_limits<T>::max();
        const T at_x = on_x && by.x * way.x > 0 ? way.x / by.x : never;
        const T at_y = on_y && by.y * way.y > 0 ? way.y / by.y : never;
        const auto between = [](T x, T end) {
            return std::clamp(x, std::min(T(0), end), std::max(T(0), end));
        };
        SurfacePoint<T> corner = to;
        if (at_x < never && at_x <= at_y) {
            const T v = from.v + between(by.y * at_x, way.y), whole = std::floor(v);
            corner = {{to.cell.i, from.cell.j + static_cast<Index>(whole)}, to.u, v - whole};
        } else if (at_y < never) {
            const T u = from.u + between(by.x * at_y, way.x), whole = std::floor(u);
            corner = {{from.cell.i + static_cast<Index>(whole), to.cell.j}, u - whole, to.v};
        }
        return field.patch(corner.cell) ? corner : to;
    }

    /// Moves `at` straight to `to`, cell by cell, as far as the first point that holds the stylus. False if none does,
    /// or if the way leads where there is no ground, or the cells are used up: then none are left.
    template <HeightField Field>
    [[nodiscard]] bool walk(const Field& field, const SurfacePoint<T>& to, const vec3<T>& stylus,
                            SurfacePoint<T>& at, int& cells) const noexcept {
        for (; cells > 0; --cells) {
            const auto patch = field.patch(at.cell);
            if (!patch) break;
            // What is left of the way, in cells, and how much of it this cell has.
            const T du = static_cast<T>(to.cell.i - at.cell.i) + (to.u - at.u);
            const T dv = static_cast<T>(to.cell.j - at.cell.j) + (to.v - at.v);
            const T part_u = du > 0 ? (T(1) - at.u) / du : du < 0 ? at.u / -du : T(2);
            const T part_v = dv > 0 ? (T(1) - at.v) / dv : dv < 0 ? at.v / -dv : T(2);
            const bool last = at.cell == to.cell || std::min(part_u, part_v) >= 1;
            const T part = last ? T(1) : std::min(part_u, part_v);
            if (search(field, *patch, field.lattice().locate(stylus, at.cell), {part * du, part * dv}, at))
                return true;
            if (last) {
                --cells;
                return false;
            }
            at.u = std::clamp(at.u + part * du, T(0), T(1));
            at.v = std::clamp(at.v + part * dv, T(0), T(1));
            if (part == part_u) at.cell.i += du > 0 ? 1 : -1, at.u = du > 0 ? T(0) : T(1);
            if (part == part_v) at.cell.j += dv > 0 ? 1 : -1, at.v = dv > 0 ? T(0) : T(1);
        }
        cells = 0;
        return false;
    }

    /// Moves `at` to the first point of the way at → at + way, in one cell, that has the stylus inside the dynamic
    /// cone. False, and `at` as it was, if there is none. A crease counts at the start and on a way along it; one at
    /// the end is the next cell's.
    template <HeightField Field>
    [[nodiscard]] bool search(const Field& field, const BilinearPatch<T>& patch, const CellPoint<T>& stylus,
                              const vec2<T>& way, SurfacePoint<T>& at) const noexcept {
        const auto u_at = [&](T s) { return std::clamp(at.u + s * way.x, T(0), T(1)); };
        const auto v_at = [&](T s) { return std::clamp(at.v + s * way.y, T(0), T(1)); };
        const auto view_at = [&](T s) {
            return friction_cone(field, patch, stylus, {at.cell, u_at(s), v_at(s)}, state_.side,
                                 {!(s > 0) || way.x == 0, !(s > 0) || way.y == 0});
        };
        const auto outside = [&](const FrictionCone<T>& cone) { return cone.outside(coefficients_.sliding); };
        const auto start = view_at(T(0)), end = view_at(T(1));
        const T f_low = outside(start);
        T low = 0, high = 1, f_high = outside(end);
        if (f_low <= 0) return true;
        if (f_high > 0) { // the cone may lie between: where the chord is nearest to the stylus
            const vec3<T> chord = end.offset - start.offset;
            const T square = glm::dot(chord, chord);
            high = square > 0 ? std::clamp(-glm::dot(start.offset, chord) / square, T(0), T(1)) : T(0);
            f_high = outside(view_at(high));
            if (f_high > 0) return false;
        }
        // Regula falsi in the form of Illinois: on a plane, straight towards the foot, `outside` is linear.
        const T enough = 8 * epsilon<T> * glm::length(start.offset);
        const T finest =
            2 * epsilon<T>; // of the way: of an end that is the zero but for rounding, step off it
        T weight_low = f_low, weight_high = f_high;
        int moved = 0; // the end that moved last; the other one counts half if that moves twice
        for (int step = 0; step < 64 && f_high < -enough; ++step) {
            const T guess = low + (high - low) * (weight_low / (weight_low - weight_high));
            const T middle = std::clamp(guess, low + finest, std::max(low + finest, high - finest));
            if (!(middle < high)) break;
            const T f = outside(view_at(middle));
            if (f > 0) {
                low = middle, weight_low = f;
                if (moved < 0) weight_high /= 2;
                moved = -1;
            } else {
                high = middle, f_high = weight_high = f;
                if (moved > 0) weight_low /= 2;
                moved = 1;
            }
        }
        const T u = u_at(high), v = v_at(high);
        at.u = u, at.v = v;
        return true;
    }

    template <HeightField Field>
    [[nodiscard]] Contact<T> held(const Field& field, const Contact<T>& contact,
                                  const vec3<T>& stylus) noexcept {
        const SurfacePoint<T>&a = state_.anchor, &q = contact.point;
        if (a.cell == q.cell && a.u == q.u && a.v == q.v) return contact;
        const auto patch_a = field.patch(a.cell), patch_q = field.patch(q.cell);
        if (!patch_a || !patch_q) return contact;
        const FrictionCone<T> anchor{*patch_a, field.lattice().locate(stylus, a.cell), a.u, a.v};
        const FrictionCone<T> proxy{*patch_q, field.lattice().locate(stylus, q.cell), q.u, q.v};
        Contact<T> back = contact;
        back.point = a;
        back.proxy = stylus + anchor.offset;
        back.penetration += anchor.offset - proxy.offset;
        back.depth = glm::length(back.penetration);
        return back;
    }

    Coefficients coefficients_;
    int max_cells_;
    State state_{};
};

} // namespace hfh

#endif // HFH_CONTACT_FRICTION_HPP
