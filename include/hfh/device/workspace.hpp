#ifndef HFH_DEVICE_WORKSPACE_HPP
#define HFH_DEVICE_WORKSPACE_HPP

#include <hfh/geometry/scalar.hpp>

#include <glm/ext/matrix_double3x3.hpp>
#include <glm/ext/matrix_float3x3.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <cmath>

// Maps a device's workspace, some centimetres wide, to a terrain, kilometres wide.

namespace hfh {

/// terrain = offset + scale · rotation · hand.
template <Real F>
struct BasicWorkspaceFrame {
    F scale = 1;                      ///< metres of terrain per metre of hand, > 0
    glm::mat<3, 3, F> rotation{F(1)}; ///< proper: RᵀR = I, det R = +1
    vec3<F> offset{F(0)}; ///< metres: where the middle of the device's workspace is on the terrain
};
using WorkspaceFrame = BasicWorkspaceFrame<double>;

enum class WorkspaceStatus : unsigned char {
    ok,
    bad_scale,    ///< not a finite number above 0
    bad_rotation, ///< not finite, or some entry of RᵀR − I beyond 8 ulps of a float at 1, or a reflection
    bad_offset    ///< not finite
};

[[nodiscard]] constexpr const char* to_string(WorkspaceStatus status) noexcept {
    switch (status) {
    case WorkspaceStatus::ok: return "ok";
    case WorkspaceStatus::bad_scale: return "bad_scale";
    case WorkspaceStatus::bad_rotation: return "bad_rotation";
    case WorkspaceStatus::bad_offset: return "bad_offset";
    }
    return "unknown";
}

/// What is wrong with a frame, if anything.
template <Real F = double>
[[nodiscard]] WorkspaceStatus check(const BasicWorkspaceFrame<F>& frame) noexcept {
    if (!is_finite(frame.scale) || !(frame.scale > 0)) return WorkspaceStatus::bad_scale;
    const glm::mat<3, 3, F>& r = frame.rotation;
    for (glm::length_t i = 0; i < 3; ++i) {
        if (!is_finite(r[i])) return WorkspaceStatus::bad_rotation;
        for (glm::length_t j = 0; j < 3; ++j) {
            // A rotation that was worked out in float is good enough.
            const F error = glm::dot(r[i], r[j]) - (i == j ? 1 : 0);
            if (!(std::abs(error) <= 8 * static_cast<F>(epsilon<float>)))
                return WorkspaceStatus::bad_rotation;
        }
    }
    if (!(glm::determinant(r) > 0)) return WorkspaceStatus::bad_rotation;
    return is_finite(frame.offset) ? WorkspaceStatus::ok : WorkspaceStatus::bad_offset;
}

/// The level of detail, any number, on which a cell measures about `cell_in_hand` metres in the hand. `scale` is that of a
/// workspace, `cell` the width in metres of a cell of level 0. Finer cells are noise for a hand, which resolves about half a
/// millimetre. Below 0 where even the finest cells are wider than that; `BlendedField::set_level` takes the nearest level
/// that there is.
///
/// log₂(cell_in_hand·scale/cell) where that is a whole number, and between two of them on the curve 3α² − 2α³ (within 7 % of
/// `cell_in_hand`): the ground stands still for a moment at each whole level. There the blend turns to a neighbour whose
/// heights may be cells away, and slopes change fastest.
[[nodiscard]] inline double suitable_level(double scale, double cell, double cell_in_hand = 0.5e-3) noexcept {
    const double level = std::log2(cell_in_hand * scale / cell), whole = std::floor(level),
                 alpha = level - whole;
    return whole + alpha * alpha * (3 - 2 * alpha);
}

/// Maps a device's workspace to the terrain, and forces back.
///
/// With s the scale and R the rotation, a velocity v of the hand is s·R·v on the terrain. The work at the hand is the work on
/// the terrain, F_hand · v = F · (s·R·v) for every v, hence F_hand = s · Rᵀ · F. A displacement d of the hand is s·R·d on
/// the terrain, so a terrain of stiffness k pushes back with F = −k·s·R·d, which is −s²·k·d at the hand: for k_hand N/m at
/// the hand, whatever the scale, the terrain's stiffness has to be k_hand/s². `terrain_stiffness` gives that, and then
/// F_hand = k_hand · Rᵀ · penetration / s. The same holds for damping. A force limit of F_max at the hand is F_max/s on the
/// terrain.
///
/// The clutch: while it is held, the terrain position stays where it was and the hand goes back to where there is room. The
/// offset takes up the difference, so the terrain position does not jump when the clutch is pressed or released. Give no
/// force while it is held, because the terrain position does not follow the hand, and let the force come up by the guard's
/// ramp afterwards: `ForceGuard::restart`.
///
/// A frame that `check` refuses is not used: the status says so, positions are mapped one to one, forces to zero.
/// T is the tracker's scalar, F what this computes in: double, which resolves nanometres at 10⁷ m; or float, where the
/// processor has no double and the terrain is near the origin, as for a `FloatLattice`. Does not throw, does not allocate.
template <Real T, Real F = double>
    requires std::same_as<F, double> || std::same_as<T, float>
class Workspace {
public:
    using Scalar = T;
    using Frame = BasicWorkspaceFrame<F>;

    explicit Workspace(const Frame& frame) noexcept : status_{check(frame)} {
        if (status_ == WorkspaceStatus::ok) frame_ = frame;
    }

    /// One update: the terrain position, in metres, of a hand at `hand`, in metres. A position that is not finite is mapped
    /// to one that is not finite, and changes no state.
    [[nodiscard]] vec3<T> update(const vec3<F>& hand, bool clutch = false) noexcept {
        if (is_finite(hand)) {
            if (clutch && !clutched_) held_ = to_terrain(hand);
            const vec3<F> offset = held_ - turned(hand);
            if (clutch && is_finite(offset)) frame_.offset = offset;
            clutched_ = clutch;
        }
        return vec3<T>{to_terrain(hand)};
    }

    /// Changes the scale about a terrain point. The hand stays, and what of it was over that point stays over it: a terrain
    /// position p becomes about + (p − about)·scale/old scale.
    ///
    /// About the proxy that is felt the force stays as it is, for F_hand = k_hand·Rᵀ·(proxy − stylus)/s: the stylus comes nearer
    /// to the proxy by as much as the terrain becomes stiffer. (Ask for `terrain_stiffness` and `terrain_force` again.) A free
    /// stylus zooms about itself and stays where it is. Refused, with nothing changed, if the scale or the point is no number
    /// or the offset would be none.
    WorkspaceStatus zoom(F scale, const vec3<F>& about) noexcept {
        if (status_ != WorkspaceStatus::ok) return status_;
        if (!is_finite(scale) || !(scale > 0)) return WorkspaceStatus::bad_scale;
        const F by = scale / frame_.scale;
        const vec3<F> offset = about + (frame_.offset - about) * by, held = about + (held_ - about) * by;
        if (!is_finite(offset) || !is_finite(held)) return WorkspaceStatus::bad_offset;
        frame_.scale = scale;
        frame_.offset = offset;
        held_ = held;
        return status_;
    }

    /// Moves the terrain position of every hand by so many metres: as the ground moves under it (`change_level`). Refused if
    /// the offset would be no number.
    WorkspaceStatus move(const vec3<F>& by) noexcept {
        if (status_ != WorkspaceStatus::ok) return status_;
        const vec3<F> offset = frame_.offset + by, held = held_ + by;
        if (!is_finite(offset) || !is_finite(held)) return WorkspaceStatus::bad_offset;
        frame_.offset = offset;
        held_ = held;
        return status_;
    }

    [[nodiscard]] vec3<F> to_terrain(const vec3<F>& hand) const noexcept {
        return frame_.offset + turned(hand);
    }
    [[nodiscard]] vec3<F> to_hand(const vec3<F>& terrain) const noexcept {
        return (terrain - frame_.offset) * frame_.rotation / frame_.scale;
    }
    /// m/s at the hand → m/s on the terrain; none while the clutch is held.
    [[nodiscard]] vec3<T> velocity_on_terrain(const vec3<F>& velocity) const noexcept {
        return clutched_ ? vec3<T>{0} : vec3<T>{turned(velocity)};
    }
    /// N on the terrain → N at the hand: s · Rᵀ · F. None if that is not finite.
    [[nodiscard]] vec3<F> force_at_hand(const vec3<T>& newtons) const noexcept {
        const vec3<F> at_hand = frame_.scale * (detail::widen_to<F>(newtons) * frame_.rotation);
        return status_ == WorkspaceStatus::ok && is_finite(at_hand) ? at_hand : vec3<F>{0};
    }
    /// The terrain's stiffness, N/m (or damping, N·s/m), for this one at the hand: k/s². Where that is more than T holds it
    /// is ∞, for which a `ForceEvaluator` gives no force.
    [[nodiscard]] T terrain_stiffness(F at_hand) const noexcept {
        return static_cast<T>(at_hand / frame_.scale / frame_.scale);
    }
    /// A limit on the force at the hand, in N, as one on the terrain: F/s.
    [[nodiscard]] T terrain_force(F at_hand) const noexcept { return static_cast<T>(at_hand / frame_.scale); }

    [[nodiscard]] WorkspaceStatus status() const noexcept { return status_; }
    [[nodiscard]] const Frame& frame() const noexcept { return frame_; }
    [[nodiscard]] bool clutched() const noexcept { return clutched_; }

private:
    [[nodiscard]] vec3<F> turned(const vec3<F>& hand) const noexcept {
        return frame_.scale * (frame_.rotation * hand);
    }

    Frame frame_{};
    vec3<F> held_{F(0)}; ///< clutched: the terrain position
    WorkspaceStatus status_;
    bool clutched_ = false;
};

} // namespace hfh

#endif // HFH_DEVICE_WORKSPACE_HPP
