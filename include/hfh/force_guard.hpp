#ifndef HFH_FORCE_GUARD_HPP
#define HFH_FORCE_GUARD_HPP

#include <hfh/device.hpp>

#include <bit>
#include <cmath>
#include <cstdint>

// Stands between what a scene wants a hand to feel and the motors. Whatever goes wrong before it, what leaves it is
// finite, no longer than a limit, and rises no faster than another.

namespace hfh {

/// Why a guard let the force go to zero, gravest first.
enum class GuardTrip : unsigned char {
    none,
    bad_limits,   ///< a limit is no number to go by: no force, ever
    bad_sample,   ///< time or position: NaN, ±∞ or beyond 2⁶⁴
    bad_force,    ///< the force asked for: NaN, ±∞ or beyond 2⁶⁴ N
    device_fault, ///< the device says that it refused a force (`DeviceSample::force_refused`)
    stale,        ///< time fell, or went on by more than `max_gap`: the last force was felt for too long
    repeated,     ///< the same time for more than `max_repeats` updates, or the same place for `max_still`
    jump,         ///< farther from the last sample than a hand gets
    buried        ///< the caller says that the stylus is below the surface without having met it
};
inline constexpr int guard_trip_count = 9;

[[nodiscard]] constexpr const char* to_string(GuardTrip trip) noexcept {
    switch (trip) {
    case GuardTrip::none: return "none";
    case GuardTrip::bad_limits: return "bad_limits";
    case GuardTrip::bad_sample: return "bad_sample";
    case GuardTrip::bad_force: return "bad_force";
    case GuardTrip::device_fault: return "device_fault";
    case GuardTrip::stale: return "stale";
    case GuardTrip::repeated: return "repeated";
    case GuardTrip::jump: return "jump";
    case GuardTrip::buried: return "buried";
    }
    return "unknown";
}

/// The user's thresholds. Each has to be a number from 0 to 2⁶⁴; `max_force`, `max_slew`, `max_gap` and `max_speed`
/// above 0.
struct GuardLimits {
    double max_force = 3.3; ///< N: what the device can give (Touch: 3.3)
    /// N/ms. Has to be above stiffness × speed of the hand, or walls go soft: 500 N/m met at 0.5 m/s is 0.25 N/ms.
    double max_slew = 1;
    double ramp = 0.5;     ///< s from no force to the full one, at the start and after every trip; 0: at once
    double max_gap = 0.01; ///< s between two samples: ten updates of a 1 kHz device
    int max_repeats =
        20; ///< updates in a row in which time stands still, as when polling faster than it samples
    double max_still = 0; ///< s at the same place to the last bit; 0: for ever, as a device that was put down
    double max_speed = 5; ///< m/s; a fast reach peaks at 2 to 3
    double max_step = 1e-3; ///< m that is always allowed, for encoder steps and times that come unevenly
    bool latch = false;     ///< after a trip stay at zero until `rearm`, also when the cause is gone
};

/// What a guard has done so far.
struct GuardCounts {
    unsigned
        trips[guard_trip_count]{}; ///< by GuardTrip: how often the cause came up; while it stays, it is one
    unsigned zeroed = 0;           ///< updates that ended at zero because of a trip or the latch
    unsigned clamped = 0, slewed = 0, ramped = 0; ///< updates in which that limit acted
};

/// What to send to the device, and what acted. After a trip no other limit is told.
struct GuardedForce {
    glm::dvec3 newtons{0.0};
    GuardTrip trip = GuardTrip::none; ///< the gravest cause that stands; the force is zero
    bool latched = false;             ///< no cause stands, but the guard waits for `rearm`; the force is zero
    bool clamped = false;             ///< was longer than max_force
    bool ramped = false;              ///< made shorter by the ramp
    bool slewed = false;              ///< is not yet where it should be
};

namespace detail {

/// Whether x is a number below 2⁶⁴ in size, told from its bits. Through volatile: what the compiler does not see it
/// cannot fold, and under -ffast-math it may fold a test of bits that came from a double (Clang 19 does). Below 2⁶⁴
/// no sum, product or square in this header overflows, so that no ∞ or NaN arises later on either.
[[nodiscard]] inline bool is_tame(const double& x) noexcept {
    const volatile std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
    return ((bits >> 52) & 0x7ffu) < 1023 + 64;
}
[[nodiscard]] inline bool is_tame(const glm::dvec3& p) noexcept {
    const bool x = is_tame(p.x), y = is_tame(p.y), z = is_tame(p.z);
    return x && y && z;
}

/// Tame and not below 0.
[[nodiscard]] inline bool is_limit(const double& x) noexcept { return is_tame(x) && !(x < 0); }

[[nodiscard]] inline double norm(const glm::dvec3& p) noexcept {
    return std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
}

} // namespace detail

/// Limits a force, in this order: length (max_force), ramp, slew. With F the force asked for and F′ the last one sent,
///
///     target = g · F · min(1, max_force/|F|)        g: 0 at the start and after a trip, then + Δt/ramp, up to 1
///     sent   = F′ + (target − F′) · min(1, max_slew·Δt/|target − F′|)      Δt: from the last good sample's time
///
/// so |sent| ≤ max_force and |sent − F′| ≤ max_slew·Δt. A trip overrides both: its update sends zero, at once.
///
/// What arms it again: the first update in which no cause stands. From there the force comes up by the ramp (with
/// `latch`, from the first such update after `rearm`). A bad sample is not remembered; the first good one after it is
/// compared with the last good one. Any other sample is what the next one is compared with.
///
/// Holds under -ffast-math: no comparison with a NaN decides. Does not throw and does not allocate.
class ForceGuard {
public:
    ForceGuard() noexcept : ForceGuard{GuardLimits{}} {}
    explicit ForceGuard(const GuardLimits& limits) noexcept : limits_{limits}, usable_{usable(limits)} {}

    /// One update: `newtons` is what the scene asks for at this sample; `buried`: the contact's status is buried.
    [[nodiscard]] GuardedForce update(const DeviceSample& sample, const glm::dvec3& newtons,
                                      bool buried = false) noexcept {
        double step = 0;
        const unsigned causes = find_causes(sample, newtons, buried, step);
        GuardedForce result;
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
            return result;
        }
        limit(newtons, step, result);
        return result;
    }

    /// After a trip with `latch`: the force may come back, by the ramp, once no cause stands.
    void rearm() noexcept { latched_ = false; }

    /// No force now, then the ramp, as at the start: after a clutch, or when the scene is another one.
    void restart() noexcept {
        sent_ = glm::dvec3{0.0};
        gain_ = 0;
    }

    [[nodiscard]] const GuardLimits& limits() const noexcept { return limits_; }
    [[nodiscard]] const GuardCounts& counts() const noexcept { return counts_; }

private:
    static constexpr unsigned bit(GuardTrip trip) noexcept { return 1u << static_cast<unsigned>(trip); }

    [[nodiscard]] static bool usable(const GuardLimits& l) noexcept {
        using detail::is_limit;
        return is_limit(l.max_force) && is_limit(l.max_slew) && is_limit(l.max_gap) &&
               is_limit(l.max_speed) && is_limit(l.ramp) && is_limit(l.max_still) && is_limit(l.max_step) &&
               l.max_repeats >= 0 && l.max_force > 0 && l.max_slew > 0 && l.max_gap > 0 && l.max_speed > 0;
    }

    /// All causes that stand, as bits, and the seconds since the last good sample; remembers the sample if it is good.
    [[nodiscard]] unsigned find_causes(const DeviceSample& sample, const glm::dvec3& newtons, bool buried,
                                       double& step) noexcept {
        unsigned causes = 0;
        if (!usable_) causes |= bit(GuardTrip::bad_limits);
        if (!detail::is_tame(newtons)) causes |= bit(GuardTrip::bad_force);
        if (sample.force_refused) causes |= bit(GuardTrip::device_fault);
        if (buried) causes |= bit(GuardTrip::buried);
        const bool good_time = detail::is_tame(sample.time), good_place = detail::is_tame(sample.position);
        if (!good_time || !good_place) return causes | bit(GuardTrip::bad_sample);

        if (!started_) {
            started_ = true;
            still_since_ = sample.time;
        } else {
            const double passed = sample.time - time_;
            step = passed > 0 ? passed : 0;
            if (passed < 0 || passed > limits_.max_gap) causes |= bit(GuardTrip::stale);

            // One more would do; counting on could overflow.
            if (passed > 0)
                repeats_ = 0;
            else if (repeats_ <= limits_.max_repeats)
                ++repeats_;
            const double moved = detail::norm(sample.position - position_);
            if (sample.position != position_ || passed < 0) still_since_ = sample.time;
            const bool still = limits_.max_still > 0 && sample.time - still_since_ > limits_.max_still;
            if (repeats_ > limits_.max_repeats || still) causes |= bit(GuardTrip::repeated);

            if (moved > limits_.max_step + limits_.max_speed * step) causes |= bit(GuardTrip::jump);
        }
        time_ = sample.time;
        position_ = sample.position;
        return causes;
    }

    void limit(const glm::dvec3& newtons, double step, GuardedForce& result) noexcept {
        gain_ += limits_.ramp > step ? step / limits_.ramp : 1 - gain_;
        if (gain_ > 1) gain_ = 1;
        const double length = detail::norm(newtons);
        result.clamped = length > limits_.max_force;
        const glm::dvec3 clamped = newtons * (result.clamped ? limits_.max_force / length : 1.0);
        result.ramped = gain_ < 1 && length > 0;
        const glm::dvec3 change = clamped * gain_ - sent_;
        const double wanted = detail::norm(change), allowed = 1000 * limits_.max_slew * step;
        result.slewed = wanted > allowed;
        sent_ = result.slewed ? sent_ + change * (allowed / wanted) : clamped * gain_;
        result.newtons = sent_;
        counts_.clamped += result.clamped;
        counts_.ramped += result.ramped;
        counts_.slewed += result.slewed;
    }

    GuardLimits limits_;
    GuardCounts counts_{};
    double time_ = 0, still_since_ = 0; ///< s: of the last good sample; since when it has been where it is
    glm::dvec3 position_{0.0};          ///< of the last good sample
    glm::dvec3 sent_{0.0};              ///< N, the last force
    double gain_ = 0;                   ///< of the ramp, 0 to 1
    unsigned causes_ = 0;               ///< of the last update, as bits
    int repeats_ = 0;                   ///< updates since time last went on
    bool usable_, started_ = false, latched_ = false;
};
static_assert(sizeof(ForceGuard) <= 256, "limits, counts and state: four cache lines");

} // namespace hfh

#endif // HFH_FORCE_GUARD_HPP
