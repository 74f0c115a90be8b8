#ifndef HFH_DEVICE_FORCE_GUARD_HPP
#define HFH_DEVICE_FORCE_GUARD_HPP

#include <hfh/device/guard_limits.hpp>
#include <hfh/device/sample_check.hpp>

#include <algorithm>
#include <cmath>

// The guard stands between the forces that a scene asks for and the motors. Whatever goes wrong before it, the force that
// leaves it is finite, at most max_force long, and rises no faster than max_slew.

namespace hfh {

/// What a guard has done so far.
struct GuardCounts {
    /// By GuardTrip: how often the cause began. A cause that stays for several updates counts once.
    unsigned trips[guard_trip_count]{};
    unsigned zeroed = 0; ///< updates that ended at zero because of a trip or the latch
    /// Updates in which that limit acted.
    unsigned clamped = 0, slewed = 0, ramped = 0, held_back = 0;
};

/// What to send to the device, and which limits acted. After a trip the other limits are not reported.
template <Real F>
struct BasicGuardedForce {
    vec3<F> newtons{F(0)};
    GuardTrip trip = GuardTrip::none; ///< the gravest cause in this update; if any, the force is zero
    bool latched = false;             ///< no cause now, but the guard waits for `rearm`; the force is zero
    bool clamped = false;             ///< was longer than max_force
    bool ramped = false;              ///< made shorter by the ramp, up or down
    bool held_back = false;           ///< part of a sudden rise is still to come
    bool slewed = false;              ///< max_slew keeps it from the target
    bool released = false;            ///< `DeviceSample::release` is asked for, and the force is zero
};
using GuardedForce = BasicGuardedForce<double>;

/// Limits a force, in this order: length, sudden rises, ramp, slew. With F the force asked for and F′ the force that the
/// motors got last,
///
///     clamped = F · min(1, max_force/|F|)
///     target  = g · clamped · max(0, 1 − held/|clamped|)     g: 0 at the start and after a trip, then + Δt/ramp, up to 1
///     sent    = F′ + (target − F′) · min(1, max_slew·Δt/|target − F′|)
///
/// so |sent| ≤ max_force and |sent − F′| ≤ max_slew·Δt. A trip overrides all of this: its update sends zero, at once.
///
/// Sudden rises: a scene that changes under the hand (other ground, another scale) may ask for all the force at once. The
/// part of a rise that the hand's motion does not explain comes at the ramp's pace. With d how far the hand has moved in
/// this update, plus what of the update before has not yet made the force rise (a tracker that limits its work may be one
/// update late),
///
///     owed ← max(0, owed − Δt·max_force/ramp) + (rise of |clamped|, above 0 less stiffness·d), from 0 to |clamped|
///     held = max(0, owed − max_sudden)
///
/// A falling force reduces what is owed, so a force that only trembles owes nothing.
///
/// Turns: a force that turns without growing is either a change of the scene or a hand that slid over a ridge. The sample
/// and the force do not tell which, and on rough ground the force turns by newtons from one update to the next: if such
/// turns were held back, the ground would go soft. So a turn comes at once, by the slew, with one exception. While the
/// place has been the same, to the bit, for max_gap, no hand turns the force. Then, if the force before had in the
/// direction of this one more than max_sudden less than its length, it counts as rising from there:
///
///     rise = |clamped| − max(0, the clamped force before · the direction of this one)
///
/// A scene that turns the ground under a moving hand should bring the force down first: by `DeviceSample::release` until
/// `released`, or by `restart` at once.
///
/// A spring on the tracker's contact is not held back, at any speed and also where a ridge releases the proxy: after an
/// update the proxy is no farther from the stylus than before it plus the hand's motion. Now and then it is farther, on
/// ground that is rough from cell to cell, with friction, or with limited work where the proxy glides past a face on which
/// nothing is felt for an update. Only max_slew limits how fast a force falls.
///
/// At the motor. The guard may be followed by links that change the force (a passivity controller, a driver's clamp) and by
/// updates in which nothing is sent. It starts from what the motors got, which `DeviceSample::sent` or a call of `sent`
/// tells, and counts Δt from when they got it. As long as what follows only shortens forces, for every update
///
///     |at the motor| ≤ |at the motor, one update before| + max_slew·Δt
///
/// while what follows may make it fall at once. Where nothing is told, F′ is what the guard gave out, and Δt counts from the
/// time of the last good sample.
///
/// The order of the chain: scene, virtual coupling, guard, energy tank, driver. A link that makes forces of its own stands
/// before the guard, which limits them. A link that shortens forces to keep an account of energy stands behind it, because
/// the account has to be of the force that is sent: the guard limits falls as well, so behind a tank it would keep up a
/// force that the tank took away, and give energy. With the guard told what was sent, the slew and the account both hold.
///
/// While `DeviceSample::release` is set, g goes down by Δt/ramp instead. Once the force is zero no sample is compared with
/// the one before it, because a calibration takes time and shifts the position. Afterwards the force comes up by the ramp.
///
/// After a trip the force comes back by the ramp from the first update without a cause (with `latch`, from the first such
/// update after `rearm`). A bad sample is not remembered: the first good one after it is compared with the last good one.
/// Any other sample is what the next one is compared with (`SampleCheck`).
///
/// F is what it computes in: double (`ForceGuard`), or float where the processor has no double. In float, times are whole
/// numbers (`Nanoseconds`), so they are as exact after days as in the first second, and what is said above holds to some
/// roundings: the force to 10⁻⁶ of max_force, a jump to 10⁻⁶ of the move and a rounding of the position, 0.1 µm at a metre. A
/// rest is one of positions as a float has them. A ramp of more than 10⁷ updates would never end.
///
/// Holds under -ffast-math: nothing depends on a comparison with a NaN. Does not throw and does not allocate.
template <Real F>
class BasicForceGuard {
public:
    using Scalar = F;
    using Sample = BasicDeviceSample<F>;
    using Limits = BasicGuardLimits<F>;

    BasicForceGuard() noexcept : BasicForceGuard{Limits{}} {}
    explicit BasicForceGuard(const Limits& limits) noexcept : limits_{limits}, usable_{is_usable(limits)} {}

    /// One update: `newtons` is the force that the scene asks for at this sample; `buried`: the contact's status is buried.
    [[nodiscard]] BasicGuardedForce<F> update(const Sample& sample, const vec3<F>& newtons,
                                              bool buried = false) noexcept {
        Step step;
        const unsigned causes = find_causes(sample, newtons, buried, step);
        BasicGuardedForce<F> result;
        for (int k = guard_trip_count; k-- > 1;) {
            if ((causes >> k & 1u) == 0) continue;
            result.trip = static_cast<GuardTrip>(k);
            if ((causes_ >> k & 1u) == 0) ++counts_.trips[k];
        }
        causes_ = causes;
        latched_ = limits_.latch && (latched_ || causes != 0);
        if (causes != 0 || latched_) {
            result.latched = causes == 0;
            ++counts_.zeroed;
            restart();
        } else {
            limit(newtons, step, sample.release, result);
        }
        if (sample.release && is_zero(sent_)) {
            result.released = true;
            restart();
            check_.forget();
        }
        return result;
    }

    /// What the motors got in place of the last force, in the update at `time`, whether `update` was called in it or
    /// not. A force that is no number counts as zero. After a time that is no number, or later than the next sample, the
    /// force may not rise in that sample's update. Not needed where the driver fills `DeviceSample::sent`.
    void sent(const vec3<F>& newtons, DeviceTime<F> time) noexcept {
        sent_ = detail::is_tame(newtons) ? newtons : vec3<F>{0};
        const F length = detail::norm(sent_);
        if (length > limits_.max_force) sent_ *= limits_.max_force / length;
        sent_at_ = detail::is_tame(time) ? std::max(sent_at_, time) : detail::latest_time<F>();
    }

    /// After a trip with `latch`: lets the force come back, by the ramp, once there is no cause.
    void rearm() noexcept { latched_ = false; }

    /// Starts from zero force and the ramp, as at the beginning: after a clutch, or when the scene is replaced.
    void restart() noexcept {
        sent_ = vec3<F>{0};
        gain_ = 0;
        fresh_ = true;
    }

    [[nodiscard]] const Limits& limits() const noexcept { return limits_; }
    [[nodiscard]] const GuardCounts& counts() const noexcept { return counts_; }

private:
    /// What happened between two updates.
    struct Step {
        F passed = 0;        ///< s since the sample before
        F held = 0;          ///< s for which the motors have had the last force
        F moved = 0;         ///< m
        bool rested = false; ///< the place has been the same for max_gap
    };

    static constexpr unsigned bit(GuardTrip trip) noexcept { return 1u << static_cast<unsigned>(trip); }
    [[nodiscard]] static bool is_zero(const vec3<F>& p) noexcept { return p == vec3<F>{0}; }

    /// All causes in this update, as bits; remembers the sample if it is good.
    [[nodiscard]] unsigned find_causes(const Sample& sample, const vec3<F>& newtons, bool buried,
                                       Step& step) noexcept {
        unsigned causes = 0;
        if (!usable_) causes |= bit(GuardTrip::bad_limits);
        if (!detail::is_tame(newtons)) causes |= bit(GuardTrip::bad_force);
        if (sample.force_refused) causes |= bit(GuardTrip::device_fault);
        if (buried) causes |= bit(GuardTrip::buried);
        const bool good_time = detail::is_tame(sample.time), good_place = detail::is_tame(sample.position);
        if (!good_time || !good_place) {
            sent_at_ = detail::latest_time<F>(); // the motors get zero, and no sample tells since when
            return causes | bit(GuardTrip::bad_sample);
        }
        if (!usable_) return causes;

        if (sample.has_sent) sent(sample.sent, sample.sent_at);
        const BasicCheckedSample<F> told = check_.update(limits_, sample.time, sample.position);
        if (told.stale) causes |= bit(GuardTrip::stale);
        if (told.repeated) causes |= bit(GuardTrip::repeated);
        if (told.jump) causes |= bit(GuardTrip::jump);
        step.passed = told.passed;
        const DeviceTime<F> now = check_.time();
        step.held = std::clamp(detail::seconds_between(sent_at_, now), F(0), told.passed);
        step.moved = told.moved;
        step.rested = told.rested >= limits_.max_gap;
        // A told time later than this sample's is kept if a stamp out of order explains it; else it was for this update only.
        const F max_back = limits_.max_gap;
        sent_at_ = sent_at_ > now && detail::seconds_between(now, sent_at_) <= max_back ? sent_at_ : now;
        return causes;
    }

    /// The share of the ramp, 0 to 1, that passes in these seconds.
    [[nodiscard]] F ramp_in(F seconds) const noexcept {
        return limits_.ramp > seconds ? seconds / limits_.ramp : F(1);
    }

    void limit(const vec3<F>& newtons, const Step& step, bool release,
               BasicGuardedForce<F>& result) noexcept {
        const F length = detail::norm(newtons);
        result.clamped = length > limits_.max_force;
        const F clamped = result.clamped ? limits_.max_force : length;
        const F shortened = result.clamped ? clamped / length : F(1);
        const F held = hold_back(newtons * shortened, clamped, step);
        result.held_back = held > 0;

        const F change = ramp_in(step.passed);
        gain_ = std::clamp(gain_ + (release ? -change : change), F(0), F(1));
        result.ramped = gain_ < 1 && length > 0;

        // Divided only where something is shortened, so that any other force is passed on to the bit.
        const bool shorter = result.clamped || result.held_back;
        const vec3<F> target = newtons * (shorter ? (clamped - held) / length : F(1)) * gain_;
        const vec3<F> way = target - sent_;
        const F wanted = detail::norm(way), allowed = 1000 * limits_.max_slew * step.held;
        result.slewed = wanted > allowed;
        sent_ = result.slewed ? sent_ + way * (allowed / wanted) : target;
        result.newtons = sent_;
        counts_.clamped += result.clamped;
        counts_.held_back += result.held_back;
        counts_.ramped += result.ramped;
        counts_.slewed += result.slewed;
    }

    /// N by which this force, of `length` N, has to be shorter in this update for its sudden rises.
    [[nodiscard]] F hold_back(const vec3<F>& newtons, F length, const Step& step) noexcept {
        if (fresh_ || !(limits_.ramp > 0)) {
            owed_ = unused_ = 0; // the ramp's factor limits the rise, or nothing does
        } else {
            const F paid = limits_.max_force * ramp_in(step.passed);
            const F rise = length - asked_before(newtons, length, step.rested);
            const F made = limits_.stiffness * step.moved;
            const F sudden = rise < 0 ? rise : std::max(F(0), rise - made - unused_);
            owed_ = std::clamp(std::max(F(0), owed_ - paid) + sudden, F(0), length);
            unused_ = std::clamp(made - rise, F(0), made);
        }
        fresh_ = false;
        asked_ = newtons;
        asked_length_ = length;
        return std::max(F(0), owed_ - limits_.max_sudden);
    }

    /// N from which this force rises: the length of the one before, or where no hand turned it, what that had along this one.
    [[nodiscard]] F asked_before(const vec3<F>& newtons, F length, bool rested) const noexcept {
        if (!rested || !(length > 0)) return asked_length_;
        const vec3<F> products = asked_ * newtons;
        const F along = std::max(F(0), (products.x + products.y + products.z) / length);
        return asked_length_ - along > limits_.max_sudden ? along : asked_length_;
    }

    Limits limits_;
    GuardCounts counts_{};
    BasicSampleCheck<F> check_{};
    vec3<F> sent_{F(0)};      ///< N: what the motors got last
    DeviceTime<F> sent_at_{}; ///< the time of the update in which they did
    F gain_ = 0;              ///< of the ramp, 0 to 1
    vec3<F> asked_{F(0)};     ///< N: asked for last, shortened to max_force
    F asked_length_ = 0;      ///< N: its length
    F unused_ = 0;            ///< N: rise that the hand's last motion explains and that did not come
    /// N: of what was asked for, rise that no motion explains and the ramp has not yet brought
    F owed_ = 0;
    unsigned causes_ = 0; ///< of the last update, as bits
    bool usable_, latched_ = false;
    bool fresh_ = true; ///< nothing was asked for before
};
using ForceGuard = BasicForceGuard<double>;
static_assert(sizeof(ForceGuard) <= 320 || sizeof(glm::dvec3) > 3 * sizeof(double),
              "limits, counts and state: five cache lines");

} // namespace hfh

#endif // HFH_DEVICE_FORCE_GUARD_HPP
