#ifndef HFH_SIMULATED_DEVICE_HPP
#define HFH_SIMULATED_DEVICE_HPP

#include <hfh/device.hpp>
#include <hfh/moving_mass.hpp>

#include <glm/geometric.hpp>

#include <concepts>
#include <utility>

// Based on: Colgate, Schenkel, Passivity of a class of sampled-data systems, 1997 (a mass with friction under a held
// force); Abbott, Okamura, Effects of position quantization and sampling rate on virtual-wall passivity, 2005; Diolaiti,
// Niemeyer, Barbagli, Salisbury, Stability of haptic rendering, 2006 (quantisation, dry friction, delay).

namespace hfh {

/// What a device is made of. The same along x, y and z, each axis with its own friction.
struct DeviceModel {
    double mass = 0.1;               ///< kg, > 0, felt at the end effector
    double viscous = 0;              ///< N·s/m
    double dry = 0;                  ///< N
    DeviceCapabilities capabilities; ///< rate > 0; a maximum force or resolution of 0 is none; 0 ≤ delay ≤ 8
};

/// The 3D Systems Touch (Phantom Omni). Force, resolution, stiffness and workspace are the maker's. Mass (45 g) and
/// friction (0.26 N) are those of the maker's data sheet for the Omni, quoted from memory; the viscous friction is
/// assumed.
inline constexpr DeviceModel simulated_touch{.mass = 0.045,
                                             .viscous = 0.005,
                                             .dry = 0.26,
                                             .capabilities = {.max_force = 3.3,
                                                              .max_stiffness = 500,
                                                              .rate = 1000,
                                                              .resolution = 0.055e-3,
                                                              .workspace = {0.160, 0.070, 0.120}}};

/// The Phantom Premium 1.5. The stiffness is what CHAI3D renders on it in closed loop (m_maxLinearStiffness of its
/// Premium 1.5, 800 N/m); Choi and Tan (Effect of update rate on perceived instability of virtual haptic texture, 2004)
/// found 325 to 904 N/m to feel clean on a Phantom 1.0 at 250 Hz to 40 kHz. The maker's 3.5 N/mm is the stiffness of the
/// mechanism, by which its linkage gives, and no gain for a loop. All else but the viscous
/// friction, which is assumed, are the maker's nominal figures, quoted from memory; no free source of them was at hand.
inline constexpr DeviceModel simulated_premium{.mass = 0.075,
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

/// A device in a hand, for those who have none: a `Device`, in SI units, the same on every run.
///
/// Between two updates the motors hold one force, shortened to the maximum; the hand moves on a straight line from
/// path(t) to path(t + T); and the mass moves as `MovingMass` solves it, exactly. The sample is the position rounded to
/// the resolution, without velocity. A force is held `delay` updates later than it was given. The workspace has no
/// walls.
///
/// `run` ends as `stopped` when the tick says so or `seconds` have passed, as `force_fault` at a force that is no
/// number. Allocates nothing, does not throw (if the path and the tick do not).
template <HandPath Path>
class SimulatedDevice {
public:
    static constexpr int max_delay = 8;

    /// Starts at rest at path(0).
    constexpr SimulatedDevice(const DeviceModel& model, const HandGrip& grip, Path path, double seconds)
        : model_{model}, axis_{model.mass, model.viscous, model.dry, grip.stiffness, grip.damping},
          path_{std::move(path)}, seconds_{seconds}, hand_{path_(0.0)}, position_{hand_} {}

    [[nodiscard]] bool valid() const noexcept {
        const DeviceCapabilities& c = model_.capabilities;
        return is_finite(c.rate) && c.rate > 0 && axis_.valid(period()) && c.max_force >= 0 &&
               c.resolution >= 0 && 0 <= c.delay && c.delay <= max_delay && is_finite(hand_) && seconds_ >= 0;
    }
    [[nodiscard]] DeviceCapabilities capabilities() const noexcept { return model_.capabilities; }
    [[nodiscard]] double period() const noexcept { return 1 / model_.capabilities.rate; }
    [[nodiscard]] double time() const noexcept {
        return static_cast<double>(updates_) / model_.capabilities.rate;
    }

    /// What the device tells: the position as the encoders have it.
    [[nodiscard]] DeviceSample sample() const noexcept {
        return {.time = time(),
                .position = {rounded(position_.x), rounded(position_.y), rounded(position_.z)}};
    }
    /// What it does not tell: where it is, how fast, where the hand wants it, and the force it held last.
    [[nodiscard]] const glm::dvec3& position() const noexcept { return position_; }
    [[nodiscard]] const glm::dvec3& velocity() const noexcept { return velocity_; }
    [[nodiscard]] const glm::dvec3& hand() const noexcept { return hand_; }
    [[nodiscard]] const glm::dvec3& held() const noexcept { return held_; }

    /// Gives the device its motion by hand, so to speak: for tests that start with a velocity.
    void place(const glm::dvec3& position, const glm::dvec3& velocity) noexcept {
        position_ = position;
        velocity_ = velocity;
    }

    /// One update: takes the force for the present sample and gives the next one. Precondition: valid(), a finite force.
    DeviceSample step(const glm::dvec3& newtons) {
        held_ = delayed(limited(newtons));
        ++updates_;
        const glm::dvec3 to = path_(time());
        for (int k = 0; k < 3; ++k) {
            const auto moved =
                axis_.advance({position_[k], velocity_[k]}, period(), held_[k], hand_[k], to[k]);
            position_[k] = moved.x;
            velocity_[k] = moved.v;
        }
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
    [[nodiscard]] double rounded(double metres) const noexcept {
        const double step = model_.capabilities.resolution;
        return step > 0 ? std::round(metres / step) * step : metres;
    }

    [[nodiscard]] glm::dvec3 limited(const glm::dvec3& newtons) const noexcept {
        const double most = model_.capabilities.max_force, length = glm::length(newtons);
        return most > 0 && length > most ? newtons * (most / length) : newtons;
    }

    /// The force that was given `delay` updates ago; `newtons` waits in its place.
    [[nodiscard]] glm::dvec3 delayed(const glm::dvec3& newtons) noexcept {
        const int delay = model_.capabilities.delay;
        return delay > 0 ? std::exchange(waiting_[updates_ % static_cast<unsigned long long>(delay)], newtons)
                         : newtons;
    }

    DeviceModel model_;
    MovingMass axis_;
    Path path_;
    double seconds_;
    glm::dvec3 hand_;
    glm::dvec3 position_;
    glm::dvec3 velocity_{0.0};
    glm::dvec3 held_{0.0};
    glm::dvec3 waiting_[max_delay]{};
    unsigned long long updates_ = 0;
};

} // namespace hfh

#endif // HFH_SIMULATED_DEVICE_HPP
