#ifndef HFH_CONTACT_FRICTION_HPP
#define HFH_CONTACT_FRICTION_HPP

#include <hfh/contact/contact.hpp>
#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/friction_cone.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

// Based on: Harwin and Melder, Improved Haptic Rendering for Multi-Finger Manipulation Using Friction Cone Based
// God-Objects (2002): the proxy stays where it is as long as the stylus is inside the friction cone under it. The
// frictionless proxy is the tracker's; friction only holds it back.

namespace hfh {

/// Everything that friction remembers: a trivially copyable value.
template <Real T>
struct FrictionState {
    /// In contact: the surface point that holds the proxy back. It moves with its patch when heights are edited.
    SurfacePoint<T> anchor{};
    /// In contact: the side on which the surface is felt; else none.
    Side side = Side::none;
    /// The anchor moved in the last update.
    bool slipping = false;
};

/// Coulomb friction: holds the proxy of a contact back inside the friction cone.
///
///     const auto contact = friction.hold(grid, tracker.update(position), position);
///     device.send(force(contact).newtons);
///
/// The anchor is a surface point. It sticks, to the bit, while the stylus is inside the cone of the static coefficient
/// that hangs from it: |tangential part of (anchor − stylus)| ≤ at_rest·(normal part). When the stylus is outside, the
/// anchor slips: on the surface, straight in plan towards the tracker's proxy, to the first point whose cone of the dynamic
/// coefficient has the stylus inside (to within 8 roundings). If no point has, it slips to the proxy, and only the
/// frictionless force is left. After a slip the dynamic coefficient decides until the stylus is found inside its cone. So
/// a hand at rest feels no drift, and one that slides feels |tangential force| = sliding·(normal force).
///
/// Where patches meet, on an edge or a vertex, every normal between theirs counts as the ground's, and a cone hangs from
/// each. In a valley only the part of the force along the valley is then tangential, so the anchor slips at the same angle
/// however steep the sides are; in a pit no part is. The way to a proxy in a valley therefore leads down the face
/// into the valley first, and then along it.
///
/// First contact sets the anchor to the proxy, release clears it, bad_input leaves it alone. It is also set to the proxy
/// (no hold for this update) where the way leads over a hole or the rim or is longer than max_cells cells, where the patch
/// under the anchor is gone, and where the contact changes sides. In each cell of the way three points are tested: both
/// ends and the point nearest to the stylus. Where the stylus is inside the cone only between these, the anchor slips
/// past.
///
/// A contact that was shaded before (`shade_force`) is held by the shaded normals in place of those of the patches: one
/// normal decides where friction slips and where the force points. Its cones hold no stylus that is above the face at their
/// point. With two normals the force would jump twice: where the anchor slips from patch to patch, and where the proxy,
/// which is elsewhere, is shaded.
///
/// The result has proxy and point of the anchor; its penetration is anchor − stylus, and its normal that of the cone which
/// holds the stylus. Where no point holds it, so that the anchor is in the proxy, a contact that is not shaded is returned as
/// it is, and the penetration of a shaded one is turned the shortest way into the cone. So penetration·normal ≥ 0, and a
/// shaded force does not push into the face at the anchor, unless anchor − stylus does, as it may on the way of a proxy that
/// glides. A contact without touch, depth or friction is returned as it is. Does not throw, does not allocate; costs
/// O(cells between anchor and proxy) ≤ max_cells.
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

    /// The tracker's contact for the stylus at `stylus` (metres), held back. Precondition: the stylus is finite if the
    /// contact touches.
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
        if (contact.shaded) return hold_back<Normals::shaded>(field, contact, stylus);
        return hold_back<Normals::of_patches>(field, contact, stylus);
    }

    /// Forgets the anchor, as after a release.
    constexpr void reset() noexcept { state_ = {}; }

    [[nodiscard]] constexpr const State& state() const noexcept { return state_; }
    constexpr void restore(const State& state) noexcept { state_ = state; }

private:
    /// The part of a straight way that lies in the cell where it starts. Cells, in plan.
    struct CellPart {
        vec2<T> way;       ///< from the start to the end of the whole way
        T share_u;         ///< of the way, up to the grid line that it crosses along u; 2 if it crosses none
        T share_v;         ///< the same along v
        T share;           ///< of the way, that lies in this cell: 0 to 1
        bool ends = false; ///< the way ends in this cell

        [[nodiscard]] vec2<T> in_cell() const noexcept { return {share * way.x, share * way.y}; }
    };

    /// What the cones hang from.
    enum class Normals : unsigned char { of_patches, shaded };

    /// `hold`, for a contact that touches.
    template <Normals normals, HeightField Field>
    [[nodiscard, HFH_ALWAYS_INLINED]] Contact<T> hold_back(const Field& field, const Contact<T>& contact,
                                                           const vec3<T>& stylus) noexcept {
        const bool first = state_.side != contact.side || !(contact.depth > 0);
        state_.side = contact.side;
        std::optional<Cone<normals>> cone;
        if (!first) cone = cone_at_anchor<normals>(field, stylus);
        const bool sticks = cone && cone->outside(coefficient()) <= 0;
        state_.slipping = !first && !sticks;
        if (state_.slipping) cone = slip<normals>(field, contact.point, stylus);
        if (!cone) state_.anchor = contact.point;
        if constexpr (normals == Normals::shaded) {
            if (!cone && contact.depth > 0) cone = cone_at_anchor<normals>(field, stylus);
            return cone ? at_anchor(contact, stylus, *cone, cone->turned_inside(coefficient())) : contact;
        } else {
            const SurfacePoint<T>&a = state_.anchor, &q = contact.point;
            const bool is_held = cone && !(a.cell == q.cell && a.u == q.u && a.v == q.v);
            return is_held ? at_anchor(contact, stylus, *cone, cone->offset) : contact;
        }
    }

    /// The normals of one cell that cones hang from.
    struct PatchNormals {};
    using ShadedNormals = std::optional<detail::ShadedCell<T>>;

    template <Normals normals, HeightField Field>
    [[nodiscard]] static auto normals_of(const Field& field, Cell cell) noexcept {
        if constexpr (normals == Normals::shaded)
            return detail::shaded_cell(field, cell);
        else
            return PatchNormals{};
    }

    /// A cone that hangs from the shaded normal. It holds no stylus that is above the face at the point.
    struct ShadedCone : FrictionCone<T> {
        T above_face; ///< metres

        [[nodiscard]] T outside(T coefficient) const noexcept {
            return std::max(FrictionCone<T>::outside(coefficient), above_face);
        }
    };

    template <Normals normals>
    using Cone = std::conditional_t<normals == Normals::shaded, ShadedCone, FrictionCone<T>>;

    /// The coefficient that applies at the anchor.
    [[nodiscard]] T coefficient() const noexcept {
        return state_.slipping ? coefficients_.sliding
                               : std::max(coefficients_.at_rest, coefficients_.sliding);
    }

    /// At a point of a patch, for a stylus in the coordinates of its cell.
    template <HeightField Field>
    [[nodiscard]] FrictionCone<T> cone(const Field& field, const BilinearPatch<T>& patch, PatchNormals,
                                       const CellPoint<T>& stylus, const SurfacePoint<T>& at,
                                       const glm::bvec2& creases = {true, true}) const noexcept {
        return friction_cone(field, patch, stylus, at, state_.side, creases);
    }
    template <HeightField Field>
    [[nodiscard]] ShadedCone cone(const Field& field, const BilinearPatch<T>& patch,
                                  const ShadedNormals& normals, const CellPoint<T>& stylus,
                                  const SurfacePoint<T>& at,
                                  const glm::bvec2& creases = {true, true}) const noexcept {
        auto cone = friction_cone(field, patch, stylus, at, state_.side, creases);
        const T above_face = -glm::dot(cone.offset, cone.normal);
        if (normals) {
            const auto normal = detail::shaded_normal((*normals)(at.u, at.v), state_.side, cone.normal);
            if (normal) cone.normal = *normal;
        }
        return {cone, above_face};
    }

    /// Empty where there is no patch under the anchor any more.
    template <Normals normals, HeightField Field>
    [[nodiscard]] std::optional<Cone<normals>> cone_at_anchor(const Field& field,
                                                              const vec3<T>& stylus) const noexcept {
        const SurfacePoint<T>& a = state_.anchor;
        const auto patch = field.patch(a.cell);
        if (!patch) return std::nullopt;
        return cone(field, *patch, normals_of<normals>(field, a.cell), field.lattice().locate(stylus, a.cell),
                    a);
    }

    /// Moves the anchor to the first point that holds the stylus on the way to `to`. Empty, and the anchor as it was, if none
    /// does.
    template <Normals normals, HeightField Field>
    [[nodiscard]] std::optional<Cone<normals>> slip(const Field& field, const SurfacePoint<T>& to,
                                                    const vec3<T>& stylus) noexcept {
        int cells = max_cells_;
        const SurfacePoint<T> corner = way_corner(field, to, stylus);
        SurfacePoint<T> at = state_.anchor;
        auto holding = slip_straight<normals>(field, corner, stylus, at, cells);
        if (!holding) {
            at = corner;
            holding = slip_straight<normals>(field, to, stylus, at, cells);
        }
        if (holding) state_.anchor = at;
        return holding;
    }

    /// The corner of the way to `to`, which is `to` itself unless that lies on an edge or a vertex of its cell. There the
    /// frictionless anchor first goes down the face that it is on, towards the foot of the stylus on the face's
    /// tangent plane. The corner is where this line, in plan, reaches the grid line of `to`, but not beyond `to` or
    /// behind the anchor.
    template <HeightField Field>
    [[nodiscard]] SurfacePoint<T> way_corner(const Field& field, const SurfacePoint<T>& to,
                                             const vec3<T>& stylus) const noexcept {
        const SurfacePoint<T>& from = state_.anchor;
        const bool on_x = !(to.u > 0 && to.u < 1), on_y = !(to.v > 0 && to.v < 1);
        if (!on_x && !on_y) return to;
        const auto patch = field.patch(from.cell);
        if (!patch) return to;
        const FrictionCone<T> cone{*patch, field.lattice().locate(stylus, from.cell), from.u, from.v};
        const vec3<T> to_foot = glm::dot(cone.offset, cone.normal) * cone.normal - cone.offset;
        if (!is_finite(to_foot)) return to;
        const vec2<T> down{to_foot.x / patch->spacing.x, to_foot.y / patch->spacing.y}; // in cells
        const vec2<T> way = cells_between(from, to);
        // How many times `down` it takes to the grid line across x, across y.
        const T never = std::numeric_limits<T>::max();
        const T to_x = on_x && down.x * way.x > 0 ? way.x / down.x : never;
        const T to_y = on_y && down.y * way.y > 0 ? way.y / down.y : never;
        const auto between = [](T x, T end) {
            return std::clamp(x, std::min(T(0), end), std::max(T(0), end));
        };
        SurfacePoint<T> corner = to;
        if (to_x < never && to_x <= to_y) {
            const T v = from.v + between(down.y * to_x, way.y), whole = std::floor(v);
            corner = {{to.cell.i, from.cell.j + static_cast<Index>(whole)}, to.u, v - whole};
        } else if (to_y < never) {
            const T u = from.u + between(down.x * to_y, way.x), whole = std::floor(u);
            corner = {{from.cell.i + static_cast<Index>(whole), to.cell.j}, u - whole, to.v};
        }
        return field.patch(corner.cell) ? corner : to;
    }

    /// Moves `at` straight towards `to`, cell by cell, to the first point that holds the stylus. Empty if none does, if
    /// the way leads where there is no patch, or if `cells`, the cells that may still be passed, are used up; in the last
    /// two cases `cells` is then 0.
    template <Normals normals, HeightField Field>
    [[nodiscard]] std::optional<Cone<normals>> slip_straight(const Field& field, const SurfacePoint<T>& to,
                                                             const vec3<T>& stylus, SurfacePoint<T>& at,
                                                             int& cells) const noexcept {
        for (; cells > 0; --cells) {
            const auto patch = field.patch(at.cell);
            if (!patch) break;
            const CellPart part = part_in_cell(at, to);
            const auto holding =
                slip_in_cell<normals>(field, *patch, normals_of<normals>(field, at.cell),
                                      field.lattice().locate(stylus, at.cell), part.in_cell(), at);
            if (holding) return holding;
            if (part.ends) {
                --cells;
                return std::nullopt;
            }
            enter_next_cell(part, at);
        }
        cells = 0;
        return std::nullopt;
    }

    /// From `from` to `to` in plan, in cells.
    [[nodiscard]] static vec2<T> cells_between(const SurfacePoint<T>& from,
                                               const SurfacePoint<T>& to) noexcept {
        return {static_cast<T>(to.cell.i - from.cell.i) + (to.u - from.u),
                static_cast<T>(to.cell.j - from.cell.j) + (to.v - from.v)};
    }

    /// How much of the way from `at` to `to` lies in the cell of `at`.
    [[nodiscard]] static CellPart part_in_cell(const SurfacePoint<T>& at,
                                               const SurfacePoint<T>& to) noexcept {
        const auto share_to_line = [](T start, T way) {
            return way > 0 ? (T(1) - start) / way : way < 0 ? start / -way : T(2);
        };
        const vec2<T> way = cells_between(at, to);
        const T share_u = share_to_line(at.u, way.x), share_v = share_to_line(at.v, way.y);
        const T share = std::min(share_u, share_v);
        const bool ends = at.cell == to.cell || share >= 1;
        return {way, share_u, share_v, ends ? T(1) : share, ends};
    }

    /// Moves `at` to the end of a part and into the next cell, across a vertex if both grid lines are crossed at once.
    static void enter_next_cell(const CellPart& part, SurfacePoint<T>& at) noexcept {
        at.u = std::clamp(at.u + part.share * part.way.x, T(0), T(1));
        at.v = std::clamp(at.v + part.share * part.way.y, T(0), T(1));
        if (part.share == part.share_u) {
            at.cell.i += part.way.x > 0 ? 1 : -1;
            at.u = part.way.x > 0 ? T(0) : T(1);
        }
        if (part.share == part.share_v) {
            at.cell.j += part.way.y > 0 ? 1 : -1;
            at.v = part.way.y > 0 ? T(0) : T(1);
        }
    }

    /// Moves `at` to the first point of the way at → at + way, in one cell, that has the stylus inside the dynamic
    /// cone. Empty, and `at` as it was, if there is none. An edge of the cell counts as a crease at the start and on a
    /// way along it; at the end of the way it is the next cell's.
    template <Normals normals, HeightField Field, class CellNormals>
    [[nodiscard]] std::optional<Cone<normals>>
    slip_in_cell(const Field& field, const BilinearPatch<T>& patch, const CellNormals& cell_normals,
                 const CellPoint<T>& stylus, const vec2<T>& way, SurfacePoint<T>& at) const noexcept {
        const auto u_at = [&](T s) { return std::clamp(at.u + s * way.x, T(0), T(1)); };
        const auto v_at = [&](T s) { return std::clamp(at.v + s * way.y, T(0), T(1)); };
        const auto cone_at = [&](T s) {
            return cone(field, patch, cell_normals, stylus, {at.cell, u_at(s), v_at(s)},
                        {!(s > 0) || way.x == 0, !(s > 0) || way.y == 0});
        };
        const auto outside = [&](const auto& cone) { return cone.outside(coefficients_.sliding); };
        const auto start = cone_at(T(0)), end = cone_at(T(1));
        auto holding = end;
        const T f_low = outside(start);
        T low = 0, high = 1, f_high = outside(end);
        if (f_low <= 0) return start;
        if (f_high > 0) { // the cone may lie between: test where the chord is nearest to the stylus
            const vec3<T> chord = end.offset - start.offset;
            const T square = glm::dot(chord, chord);
            high = square > 0 ? std::clamp(-glm::dot(start.offset, chord) / square, T(0), T(1)) : T(0);
            holding = cone_at(high);
            f_high = outside(holding);
            if (f_high > 0) return std::nullopt;
        }
        // Regula falsi in the form of Illinois: on a plane, straight towards the foot, `outside` is linear.
        const T enough = 8 * epsilon<T> * glm::length(start.offset);
        // Of the way: a guess keeps this far from both ends, so that an end that is the zero but for rounding is left.
        const T finest = 2 * epsilon<T>;
        T weight_low = f_low, weight_high = f_high;
        int moved = 0; // the end that moved last; the other one counts half if that moves twice
        for (int step = 0; step < 64 && f_high < -enough; ++step) {
            const T guess = low + (high - low) * (weight_low / (weight_low - weight_high));
            const T middle = std::clamp(guess, low + finest, std::max(low + finest, high - finest));
            if (!(middle < high)) break;
            const auto cone = cone_at(middle);
            const T f = outside(cone);
            if (f > 0) {
                low = middle, weight_low = f;
                if (moved < 0) weight_high /= 2;
                moved = -1;
            } else {
                high = middle, f_high = weight_high = f;
                holding = cone;
                if (moved > 0) weight_low /= 2;
                moved = 1;
            }
        }
        const T u = u_at(high), v = v_at(high);
        at.u = u, at.v = v;
        return holding;
    }

    /// The contact with its proxy at the anchor, whose cone is `holding`.
    [[nodiscard]] Contact<T> at_anchor(const Contact<T>& contact, const vec3<T>& stylus,
                                       const FrictionCone<T>& holding,
                                       const vec3<T>& penetration) const noexcept {
        Contact<T> held = contact;
        held.point = state_.anchor;
        held.proxy = stylus + holding.offset;
        held.normal = holding.normal;
        held.penetration = penetration;
        held.depth = glm::length(penetration);
        return held;
    }

    Coefficients coefficients_;
    int max_cells_;
    State state_{};
};

} // namespace hfh

#endif // HFH_CONTACT_FRICTION_HPP
