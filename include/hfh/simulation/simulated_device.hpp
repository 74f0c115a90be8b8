#ifndef HFH_SIMULATION_SIMULATED_DEVICE_HPP
#define HFH_SIMULATION_SIMULATED_DEVICE_HPP

#include <hfh/device/device.hpp>
#include <hfh/simulation/encoders.hpp>
#include <hfh/simulation/stick_slip_mass.hpp>

#include <glm/geometric.hpp>

#include <concepts>
#include <utility>

// Based on: Colgate, Schenkel, Passivity of a class of sampled-data systems, 1997 (a mass with friction under a held
// force); Abbott, Okamura, Effects of position quantization and sampling rate on virtual-wall passivity, 2005; Diolaiti,
// Niemeyer, Barbagli, Salisbury, Stability of haptic rendering, 2006 (quantisation, dry friction, delay).

namespace hfh {

/// A simple device: one mass, the same along x, y and z, each axis with its own friction.
struct DeviceModel {
    double mass = 0.1;               ///< kg, > 0, felt at the end effector
    double viscous = 0;              ///< N·s/m
    double dry = 0;                  ///< N
    DeviceCapabilities capabilities; ///< rate > 0; a maximum force or resolution of 0 is none; 0 ≤ delay ≤ 8
};

/// The 3D Systems Touch (Phantom Omni). Force, resolution, stiffness and workspace are the maker's. Mass (45 g) and
/// friction (0.26 N) are those of the maker's data sheet for the Omni, quoted from memory; the viscous friction is
/// assumed.
inline const DeviceModel simulated_touch{.mass = 0.045,
                                         .viscous = 0.005,
                                         .dry = 0.26,
                                         .capabilities = {.max_force = 3.3,
                                                          .max_stiffness = 500,
                                                          .rate = 1000,
                                                          .resolution = 0.055e-3,
                                                          .workspace = {0.160, 0.070, 0.120}}};

/// The Phantom Premium 1.5. The stiffness is what CHAI3D renders on it in closed loop (800 N/m, the m_maxLinearStiffness
/// in its block "Premium 1.5 6DOF"); Choi and Tan (Effect of update rate on perceived instability of virtual haptic
/// texture, 2004) found textures of 325 to 904 N/m at most to feel clean, at 250 Hz to 40 kHz. The maker's 3.5 N/mm is
/// the stiffness of the mechanism, by which the linkage gives, and no gain for a loop. All else but the viscous friction,
/// which is assumed, are the maker's nominal figures, quoted from memory; no free source of them was at hand.
inline const DeviceModel simulated_premium{.mass = 0.075,
                                           .viscous = 0.005,
                                           .dry = 0.04,
                                           .capabilities = {.max_force = 8.5,
                                                            .max_stiffness = 800,
                                                            .rate = 1000,
                                                            .resolution = 0.03e-3,
                                                            .workspace = {0.381, 0.191, 0.267}}};

/// How a hand holds the device: by a spring and a damper between the end effector and where the hand wants it to be.
struct HandGrip {
    double stiffness = 300; ///< N/m
    double damping = 4;     ///< N·s/m
};

/// t → position: where the hand wants the end effector to be, seconds and metres.
template <class P>
concept HandPath = requires(const P& path, double t) {
    { path(t) } -> std::convertible_to<glm::dvec3>;
};

/// How a device moves along x, y and z: all alike.
template <class A>
struct SameAxes {
    using Axis = A;
    Axis axis;
    [[nodiscard]] const Axis& operator[](glm::length_t) const noexcept { return axis; }
};

/// Or each in its own way: other inertia along each, weight along z, stops at the walls of the workspace.
template <class A>
struct OwnAxes {
    using Axis = A;
    Axis axes[3];
    [[nodiscard]] const Axis& operator[](glm::length_t k) const noexcept { return axes[k]; }
};

/// A simulated device in a simulated hand: a `Device`, in SI units, with the same motion on every run.
///
/// Between two updates the motors hold one force, shortened to the maximum; the hand moves on a straight line from
/// path(t) to path(t + T); and each axis moves as its `Axis` solves it, exactly. The sample is the position as the
/// encoders tell it, without velocity. A force is held `delay` updates later than it was given.
///
/// Made from a `DeviceModel` it has three equal `StickSlipMass`es, encoders along x, y and z, and no walls. What real
/// devices have beyond that is composed of pieces, and costs nothing where it is left out:
///
///     driven_axis.hpp   amplifier lag, a linkage that gives, weight       in place of StickSlipMass
///     end_stops.hpp     walls of the workspace                            around either
///     OwnAxes           another of them along each of x, y and z
///     encoders.hpp      encoders in the joints of two links
///
///     SimulatedDevice device{capabilities, OwnAxes<DrivenAxis>{{x, y, z}}, JointEncoders{…}, path, seconds};
///
/// `run` ends as `stopped` when the tick says so or `seconds` have passed, as `force_fault` at a force that is no
/// number. Allocates nothing, does not throw (if the path and the tick do not).
template <HandPath Path, class Axes = SameAxes<StickSlipMass>, class Encoders = AxisEncoders>
class SimulatedDevice {
public:
    static constexpr int max_delay = 8;

    /// Starts at rest at path(0).
    template <class Same = Axes>
        requires std::same_as<Same, SameAxes<StickSlipMass>> && std::same_as<Encoders, AxisEncoders>
    constexpr SimulatedDevice(const DeviceModel& model, const HandGrip& grip, Path path, double seconds)
        : SimulatedDevice{model.capabilities,
                          {{model.mass, model.viscous, model.dry, grip.stiffness, grip.damping}},
                          {model.capabilities.resolution},
                          std::move(path),
                          seconds} {}
    /// Of other pieces. The hand's grip is in the axes; the resolution of the capabilities is only what the device says of
    /// itself.
    constexpr SimulatedDevice(const DeviceCapabilities& capabilities, const Axes& axes,
                              const Encoders& encoders, Path path, double seconds)
        : capabilities_{capabilities}, axes_{axes}, encoders_{encoders}, path_{std::move(path)},
          seconds_{seconds}, hand_{path_(0.0)} {
        place(hand_, glm::dvec3{0.0});
    }

    /// Whether model, grip, encoders, path and time are in range: `seconds` ≥ 0, ∞ for until the tick stops it, and what
    /// `DeviceModel` and `valid` of the axes and of the encoders say.
    [[nodiscard]] bool valid() const noexcept {
        const DeviceCapabilities& c = capabilities_;
        return is_at_least_zero(c.rate) && c.rate > 0 && axes_[0].valid(period()) &&
               axes_[1].valid(period()) && axes_[2].valid(period()) && encoders_.valid() &&
               is_upper_limit(c.max_force) && is_at_least_zero(c.resolution) && 0 <= c.delay &&
               c.delay <= max_delay && is_finite(hand_) && is_upper_limit(seconds_);
    }
    [[nodiscard]] DeviceCapabilities capabilities() const noexcept { return capabilities_; }
    [[nodiscard]] double period() const noexcept { return 1 / capabilities_.rate; }
    [[nodiscard]] double time() const noexcept { return static_cast<double>(updates_) / capabilities_.rate; }

    /// What the device tells: the position as the encoders have it, and the force that it took last, shortened to the
    /// maximum but not yet delayed.
    [[nodiscard]] DeviceSample sample() const noexcept {
        DeviceSample told{.time = time(), .position = encoders_(position())};
        if (updates_ > 0) {
            const auto delay = static_cast<unsigned long long>(capabilities_.delay);
            told.has_sent = true;
            told.sent = delay > 0 ? waiting_[(updates_ - 1) % delay] : held_;
            told.sent_at = static_cast<double>(updates_ - 1) / capabilities_.rate;
        }
        return told;
    }
    /// What the device does not tell: its true position (m) and velocity (m/s), the hand's position, and the force (N) that
    /// the motors hold.
    [[nodiscard]] glm::dvec3 position() const noexcept { return {state_[0].x, state_[1].x, state_[2].x}; }
    [[nodiscard]] glm::dvec3 velocity() const noexcept { return {state_[0].v, state_[1].v, state_[2].v}; }
    [[nodiscard]] const glm::dvec3& hand() const noexcept { return hand_; }
    [[nodiscard]] const glm::dvec3& held() const noexcept { return held_; }
    /// The state of an axis (0, 1, 2: x, y, z).
    [[nodiscard]] const typename Axes::Axis::State& state(int axis) const noexcept { return state_[axis]; }

    /// Sets position (m) and velocity (m/s): for tests that start with a velocity.
    constexpr void place(const glm::dvec3& position, const glm::dvec3& velocity) noexcept {
        for (glm::length_t k = 0; k < 3; ++k) state_[k] = Axes::Axis::at(position[k], velocity[k]);
    }

    /// One update: takes the force for the present sample and gives the next one. Precondition: valid(), a finite force.
    DeviceSample step(const glm::dvec3& newtons) {
        held_ = delayed(limited(newtons));
        ++updates_;
        const glm::dvec3 to = path_(time());
        for (glm::length_t k = 0; k < 3; ++k)
            state_[k] = axes_[k].advance(state_[k], period(), held_[k], hand_[k], to[k]);
        hand_ = to;
        return sample();
    }

    template <DeviceTick Tick>
    DeviceEnd run(Tick&& tick) {
        if (!valid()) return DeviceEnd::not_available;
        DeviceEnd end = DeviceEnd::stopped;
        while (time() < seconds_) {
            const DeviceCommand command = tick(sample());
            if (!command.go_on) break;
            if (!is_finite(command.newtons)) {
                end = DeviceEnd::force_fault;
                break;
            }
            step(command.newtons);
        }
        held_ = {};
        for (glm::dvec3& newtons : waiting_) newtons = {};
        return end;
    }

private:
    [[nodiscard]] glm::dvec3 limited(const glm::dvec3& newtons) const noexcept {
        const double most = capabilities_.max_force, length = glm::length(newtons);
        return most > 0 && length > most ? newtons * (most / length) : newtons;
    }

    /// The force that was given `delay` updates ago; `newtons` waits in its place.
    [[nodiscard]] glm::dvec3 delayed(const glm::dvec3& newtons) noexcept {
        const int delay = capabilities_.delay;
        return delay > 0 ? std::exchange(waiting_[updates_ % static_cast<unsigned long long>(delay)], newtons)
                         : newtons;
    }

    DeviceCapabilities capabilities_;
    Axes axes_;
    Encoders encoders_;
    Path path_;
    double seconds_;
    glm::dvec3 hand_;
    typename Axes::Axis::State state_[3]{};
    glm::dvec3 held_{0.0};
    glm::dvec3 waiting_[max_delay]{};
    unsigned long long updates_ = 0;
};

} // namespace hfh

#endif // HFH_SIMULATION_SIMULATED_DEVICE_HPP
