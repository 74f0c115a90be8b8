#ifndef HFH_LOOP_HAPTIC_LOOP_HPP
#define HFH_LOOP_HAPTIC_LOOP_HPP

#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/contact/proxy_glide.hpp>
#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/device/force_guard.hpp>
#include <hfh/device/workspace.hpp>
#include <hfh/force/damping.hpp>
#include <hfh/force/force_evaluator.hpp>
#include <hfh/force/virtual_coupling.hpp>

#include <limits>

namespace hfh {

/// How the ground feels in the hand, whatever the scale of the workspace.
struct Material {
    double stiffness = 400; ///< N/m at the hand, ≥ 0
    double static_friction =
        0; ///< Coulomb's coefficient at rest, ≥ 0; below the dynamic one it counts as equal to it
    double dynamic_friction = 0; ///< Coulomb's coefficient while sliding, ≥ 0. Both 0: no friction
    double damping = 0;          ///< N·s/m at the hand, along the normal, ≥ 0; 0: none
    bool shading = false;        ///< the force's direction is continuous across the edges of patches
};

struct HapticLoopOptions {
    WorkspaceFrame workspace{}; ///< from the hand to the terrain
    Material material{};
    GuardLimits limits{}; ///< those of the device: `guard_limits(device, stiffness, lag)`
    /// Of the tracker. A proxy that a ridge releases far from the stylus glides there over several updates.
    TrackerOptions tracker{.max_contact_patches = 8};
    /// How fast a proxy glides that a ridge lets go, in metres at the hand an update, whatever the scale of the workspace is.
    /// 0.5e-3 lets the force step by 5·stiffness·|step of the hand| or less in 99 of 100 updates in the roughest mountains, and
    /// 25 mm take 50 updates. The largest number: it does not glide. With it the tracker needs no `max_contact_patches` for a smooth force.
    double release_speed = std::numeric_limits<double>::max();
    /// Updates by which a force comes late, for the `VirtualCoupling`; each update of delay in the device adds 1. 0: no
    /// coupling.
    double lag = 0.5;
    /// Bit k: while button k is down the clutch is held. 0: there is no clutch.
    unsigned clutch_buttons = 0;
};

/// What touches the ground in a `HapticLoop`: a point. `BallTip` (ball_tip.hpp) is a ball.
struct PointTip {
    template <HeightField Field>
    using Tracker = ProxyTracker<Field>;
    template <Real T>
    using Friction = hfh::Friction<T>;
    template <Real T>
    using Glide = ProxyGlide<T>;
    template <Real T>
    using Contact = hfh::Contact<T>;
};

/// One haptic update from a device's sample to the force on the hand: every piece of the library that stands between the
/// two, put together in the right order, with a material that can be changed at run time.
///
///     hfh::HapticLoop loop{grid, {.workspace = frame, .material = {.stiffness = 400}, .limits = limits}};
///     device.run([&](const hfh::DeviceSample& sample) { return loop.update(sample); });
///
/// It has no logic of its own. An update is, to the bit,
///
///     sample.force_refused         → the tracker forgets the contact
///     sample.position, clutch      → Workspace        → stylus, in metres of terrain
///     stylus                       → ProxyTracker     → contact
///     release speed, if there is   → ProxyGlide
///     material.shading             → shade_force
///     friction, if there is any    → Friction::hold
///     spring, damping if any       → ForceEvaluator, Damping → newtons on the terrain → Workspace → newtons at the hand
///     position, newtons            → VirtualCoupling  → `asked()`
///     sample, asked, buried        → ForceGuard       → the command
///
/// Ground beyond the rim and levels of detail are fields (`ExtendedField`, `BlendedField`): the field's type is all that
/// changes. A round tip is a `HapticLoop<Field, BallTip>` with the tracker's radius set. What stands behind the guard
/// (`EnergyTank`) stays outside.
///
/// Units: the hand's side, which is the sample, the command, `Material` and `GuardLimits`, is in metres and newtons at
/// the hand; `stylus()` and `contact()` are in metres of terrain. The scale of the workspace changes what the terrain's
/// stiffness is, not the one at the hand. Damping takes the sample's velocity if it has one, and otherwise that of a
/// `VelocityFilter` of 50 Hz on the hand's positions and the sample's times, which runs only while the material damps.
///
/// How an update ends: `contact().status` says what the tracker found, `force()` what the guard made of it.
///
/// | `contact().status` | force asked for | the command |
/// |---|---|---|
/// | contact, descent_limit | the material's | the same within the guard's limits |
/// | free, sweep_limit, off_surface, left_at_border, left_at_hole | 0 | falls to zero by `max_slew` |
/// | buried | 0 | zero at once (`GuardTrip::buried`) |
/// | bad_input, the sample is no number | 0 | zero at once (`GuardTrip::bad_sample`) |
/// | bad_input, the stylus is beyond what the terrain can number | 0 | falls to zero by `max_slew` |
///
/// and zero at once on every other trip: stale, repeated and jumping samples, a refused force, limits out of range. After a
/// bad sample contact and friction go on from where they were.
///
/// - A refused force (`DeviceSample::force_refused`): zero, and the next contact has to be made from above.
/// - The clutch: zero while it is held, the terrain position stays, and the force comes up by the guard's ramp.
/// - A material that changes while the ground is touched acts in the next update. The contact and friction's anchor stay.
///   What of a rise of the force no motion explains comes at the pace of the guard's ramp, a fall by `max_slew`. A value that
///   is out of range or no number switches its piece off: no force, no friction, no damping. Keep
///   `GuardLimits::stiffness` at (1 + 1.5·lag) times the stiffest material, for the guard does not learn of it.
/// - `reset` forgets stylus, contact, velocity and force: the next sample counts as the first, the force comes up by the
///   ramp. What the guard has counted stays.
/// - A workspace out of range (`workspace().status()`): no force.
///
/// Keeps a pointer to the field, which must outlive it; its heights may change between updates. Does not throw and does
/// not allocate. Use it from one thread at a time.
template <HeightField Field, class Tip = PointTip>
class HapticLoop {
public:
    using Scalar = typename Field::Scalar;
    using Tracker = typename Tip::template Tracker<Field>;
    using TipFriction = typename Tip::template Friction<Scalar>;
    using TipGlide = typename Tip::template Glide<Scalar>;
    using TipContact = typename Tip::template Contact<Scalar>;

    explicit HapticLoop(const Field& field, const HapticLoopOptions& options = {}) noexcept;
    explicit HapticLoop(const Field&&,
                        const HapticLoopOptions& = {}) = delete; // the field must outlive the loop

    /// One update: the force on the hand until the next sample. `go_on` is always true.
    [[nodiscard]] DeviceCommand update(const DeviceSample& sample) noexcept;

    [[nodiscard]] const Material& material() const noexcept { return material_; }
    void set_material(const Material& material) noexcept;

    /// As `HapticLoopOptions::release_speed`, from the next update on, also while a proxy glides.
    void set_release_speed(double release_speed) noexcept {
        release_speed_ = release_speed;
        if (!has_glide()) glide_.reset();
    }

    /// Starts again: the next sample is taken as the first one.
    void reset() noexcept;

    // Of the last update.

    [[nodiscard]] const vec3<Scalar>& stylus() const noexcept { return stylus_; } ///< metres of terrain
    /// As it is felt: shaded, and held back by friction.
    [[nodiscard]] const TipContact& contact() const noexcept { return contact_; }
    /// Newtons at the hand before the guard: what is felt where there are no motors to guard.
    [[nodiscard]] const glm::dvec3& asked() const noexcept { return asked_; }
    /// What the guard made of it, and why. `newtons` is the command's.
    [[nodiscard]] const GuardedForce& force() const noexcept { return force_; }

    // The pieces, for what can be done to them between updates: to zoom and to move the workspace, `change_level` of the
    // tracker, friction and glide, `rearm` of the guard.

    [[nodiscard]] Workspace<Scalar>& workspace() noexcept { return workspace_; }
    [[nodiscard]] const Workspace<Scalar>& workspace() const noexcept { return workspace_; }
    [[nodiscard]] Tracker& tracker() noexcept { return tracker_; }
    [[nodiscard]] const Tracker& tracker() const noexcept { return tracker_; }
    [[nodiscard]] TipFriction& friction() noexcept { return friction_; }
    [[nodiscard]] const TipFriction& friction() const noexcept { return friction_; }
    [[nodiscard]] TipGlide& glide() noexcept { return glide_; }
    [[nodiscard]] const TipGlide& glide() const noexcept { return glide_; }
    [[nodiscard]] ForceGuard& guard() noexcept { return guard_; }
    [[nodiscard]] const ForceGuard& guard() const noexcept { return guard_; }

private:
    [[nodiscard]] static TipFriction friction_of(const Material& material) noexcept {
        return TipFriction{{.at_rest = static_cast<Scalar>(material.static_friction),
                            .sliding = static_cast<Scalar>(material.dynamic_friction)}};
    }
    [[nodiscard]] VirtualCoupling coupling_of(const Material& material) const noexcept {
        return VirtualCoupling{{.stiffness = material.stiffness, .lag = lag_}};
    }
    [[nodiscard]] bool has_friction() const noexcept {
        return material_.static_friction != 0 || material_.dynamic_friction != 0;
    }
    [[nodiscard]] bool has_glide() const noexcept {
        return release_speed_ < std::numeric_limits<double>::max();
    }
    [[nodiscard]] bool has_damping() const noexcept { return material_.damping != 0; }

    /// What the ground gives back to the stylus, N on the terrain.
    [[nodiscard]] vec3<Scalar> newtons_on_terrain(const DeviceSample& sample) noexcept;
    /// m/s at the hand.
    [[nodiscard]] glm::dvec3 velocity_of(const DeviceSample& sample) noexcept;

    Tracker tracker_;
    Material material_;
    TipFriction friction_;
    double release_speed_; ///< m at the hand an update
    TipGlide glide_{};
    VelocityFilter<double> velocity_{};
    double time_ = 0; ///< s: of the last sample that the velocity filter saw
    Workspace<Scalar> workspace_;
    double lag_;
    VirtualCoupling coupling_;
    ForceGuard guard_;
    unsigned clutch_buttons_;

    vec3<Scalar> stylus_{Scalar(0)};
    TipContact contact_{};
    glm::dvec3 asked_{0.0};
    GuardedForce force_{};
};

template <HeightField Field, class Tip>
HapticLoop<Field, Tip>::HapticLoop(const Field& field, const HapticLoopOptions& options) noexcept
    : tracker_{field, options.tracker}, material_{options.material}, friction_{friction_of(material_)},
      release_speed_{options.release_speed}, workspace_{options.workspace}, lag_{options.lag},
      coupling_{coupling_of(material_)}, guard_{options.limits}, clutch_buttons_{options.clutch_buttons} {}

template <HeightField Field, class Tip>
DeviceCommand HapticLoop<Field, Tip>::update(const DeviceSample& sample) noexcept {
    if (sample.force_refused) tracker_.reset();
    const bool clutch = (sample.buttons & clutch_buttons_) != 0;
    stylus_ = workspace_.update(sample.position, clutch);
    contact_ = tracker_.update(stylus_);
    if (has_glide()) {
        glide_.set_speed(release_speed_ * workspace_.frame().scale);
        contact_ = glide_.follow(tracker_.field(), contact_, stylus_);
    }
    if (material_.shading) contact_ = shade_force(tracker_.field(), contact_);
    if (has_friction()) contact_ = friction_.hold(tracker_.field(), contact_, stylus_);
    const vec3<Scalar> newtons = newtons_on_terrain(sample);
    const glm::dvec3 at_hand = clutch ? glm::dvec3{0.0} : workspace_.force_at_hand(newtons);
    asked_ = coupling_(sample.position, at_hand).newtons;
    force_ = guard_.update(sample, asked_, contact_.status == ContactStatus::buried);
    if (clutch) {
        force_.newtons = glm::dvec3{0.0};
        guard_.restart();
    }
    return {force_.newtons};
}

template <HeightField Field, class Tip>
auto HapticLoop<Field, Tip>::newtons_on_terrain(const DeviceSample& sample) noexcept -> vec3<Scalar> {
    const ForceEvaluator<Scalar> spring{.stiffness = workspace_.terrain_stiffness(material_.stiffness)};
    if (!has_damping()) return spring(contact_).newtons;
    const Damping<Scalar> damping{.along_normal = workspace_.terrain_stiffness(material_.damping)};
    return damping(spring, contact_, workspace_.velocity_on_terrain(velocity_of(sample))).newtons;
}

template <HeightField Field, class Tip>
glm::dvec3 HapticLoop<Field, Tip>::velocity_of(const DeviceSample& sample) noexcept {
    if (sample.has_velocity) return sample.velocity;
    const double seconds = sample.time - time_;
    time_ = sample.time;
    return velocity_.update(sample.position, seconds);
}

template <HeightField Field, class Tip>
void HapticLoop<Field, Tip>::set_material(const Material& material) noexcept {
    const auto anchor = friction_.state();
    const bool is_as_stiff = material.stiffness == material_.stiffness;
    material_ = material;
    friction_ = friction_of(material);
    if (has_friction()) friction_.restore(anchor);
    if (!is_as_stiff) coupling_ = coupling_of(material);
    if (!has_damping()) velocity_.reset();
}

template <HeightField Field, class Tip>
void HapticLoop<Field, Tip>::reset() noexcept {
    tracker_.reset();
    friction_.reset();
    glide_.reset();
    velocity_.reset();
    coupling_.reset();
    guard_.restart();
}

} // namespace hfh

#endif // HFH_LOOP_HAPTIC_LOOP_HPP
