#ifndef HFH_DEVICE_GUARD_LIMITS_HPP
#define HFH_DEVICE_GUARD_LIMITS_HPP

#include <hfh/device/device.hpp>

#include <algorithm>
#include <cmath>
#include <initializer_list>

// A guard's thresholds, and the names of what trips it.

namespace hfh {

/// Why a guard set the force to zero, gravest first.
enum class GuardTrip : unsigned char {
    none,
    bad_limits,   ///< a limit is out of range: no force, ever
    bad_sample,   ///< time or position: NaN, ±∞ or beyond 2⁶⁴, in float 2³²
    bad_force,    ///< the force asked for: NaN, ±∞ or beyond 2⁶⁴ N, in float 2³² N
    device_fault, ///< the device says that it refused a force (`DeviceSample::force_refused`)
    stale,        ///< time went on, or fell, by more than `max_gap`: the last force was felt for too long
    repeated, ///< time did not go on for more than `max_repeats` updates, or the same place for `max_still`
    jump,     ///< farther than a hand gets in the time
    buried    ///< the caller says that the stylus is below the surface without contact
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

/// The user's thresholds. Each has to be a number from 0 to 2⁶⁴, in float to 2³²; `max_force`, `max_slew`, `max_gap` and `max_speed`
/// above 0. With any other the guard gives no force and says `bad_limits`.
template <Real F>
struct BasicGuardLimits {
    /// N: what the device can give (Touch: 3.3).
    F max_force = F(3.3);
    /// N/ms. Has to be above stiffness × speed of the hand, or walls go soft: 500 N/m met at 2 m/s is 1 N/ms.
    F max_slew = 1;
    /// s from no force to the full one, at the start and after every trip; 0: at once.
    F ramp = F(0.5);
    /// N/m at the hand: the stiffest that the guard is asked for. A hand that moves by d makes the force rise by
    /// stiffness·d at the most; where what is asked for is stiffer than told here, quick contacts come up by the ramp.
    /// Without a `VirtualCoupling` that is K, the stiffest that the scene renders. Behind one it is (1 + 1.5·lag)·K: a hand
    /// that sets out by d, turns or stops feels K·d of the spring and up to 1.5·lag·K·d of the damper come or go. That is
    /// 1.75·K without delay, 700 N/m of 400. With K told instead, the damper's part counts as sudden: with s the hand's
    /// way in an update, 1.5·lag·K·s, which `max_sudden` lets pass up to 1 m/s at 400 N/m and 1 kHz. As much may count as
    /// sudden even so where a hand on its way out slows down over several updates.
    F stiffness = 1000;
    /// N by which the force may rise at once though the hand did not make it rise: damping × speed, at a first contact.
    /// From `max_force` on any rise may come at once.
    F max_sudden = F(0.3);
    /// s between two samples, above which the later one is `stale`: the period of a 100 Hz device and 10 ms of jitter.
    /// `SampleCheck` derives two more times from it.
    F max_gap = F(0.02);
    /// s between two samples of the device; 0: not told. A first guess, for its pace is learnt from the changes of the
    /// position. Tell it where a device is asked oftener than it samples: there small moves between equal samples teach
    /// nothing, nor does a hand at rest, and until the pace is known a jump is one of max_step + max_speed·max_gap only,
    /// 101 mm as these limits stand. Told 1 ms, a jump from rest is one of 6 mm.
    F period = 0;
    /// Updates in a row in which the sample's time does not go on, where the device stamps its samples and is asked faster
    /// than it samples: `max_gap` at 8 kHz. Stamps of the host's clock always go on: see `max_still`.
    int max_repeats = 160;
    /// s at the same place to the last bit; 0: for ever, as a device that was put down.
    F max_still = 0;
    /// m/s; a fast reach peaks at 2 to 3.
    F max_speed = 5;
    /// m that is always allowed, for encoder steps.
    F max_step = F(1e-3);
    /// After a trip stay at zero until `rearm`, also when the cause is gone.
    bool latch = false;
};
using GuardLimits = BasicGuardLimits<double>;

namespace detail {

/// Numbers that a guard takes are below two to this power in size: then none of its sums, products and squares overflows, and
/// no ∞ or NaN arises later on either.
template <Real F>
inline constexpr int tame_exponent = std::same_as<F, float> ? 32 : 64;

/// Whether x is a number below 2⁶⁴ in size, in float 2³², told from its exponent.
template <Real F>
[[nodiscard]] inline bool is_tame(F x) noexcept {
    constexpr int bias = std::numeric_limits<F>::max_exponent - 1;
    return (bits_of(x) & Bits<F>::exponent) >> Bits<F>::below_exponent < bias + tame_exponent<F>;
}
template <Real F>
[[nodiscard]] inline bool is_tame(const vec3<F>& p) noexcept {
    const bool x = is_tame(p.x), y = is_tame(p.y), z = is_tame(p.z);
    return x && y && z;
}

/// Tame and not below 0.
template <Real F>
[[nodiscard]] inline bool is_limit(F x) noexcept {
    return is_tame(x) && !(x < 0);
}

template <Real F>
[[nodiscard]] inline F norm(const vec3<F>& p) noexcept {
    return std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
}

/// Later than any time that a guard takes. What lies between two whole numbers of this size can still be counted.
template <Real F>
[[nodiscard]] constexpr DeviceTime<F> latest_time() noexcept {
    if constexpr (std::same_as<F, double>)
        return 0x1p64;
    else
        return {std::int64_t{1} << 62};
}

[[nodiscard]] inline bool is_tame(Nanoseconds time) noexcept {
    constexpr std::int64_t most = latest_time<float>().count;
    return -most < time.count && time.count < most;
}

/// s from one time to another.
[[nodiscard]] inline double seconds_between(double from, double to) noexcept { return to - from; }
[[nodiscard, gnu::noinline]] inline float seconds_between(Nanoseconds from, Nanoseconds to) noexcept {
    // By halves: no processor that this is for converts 64 bits.
    const std::int64_t between = to.count - from.count;
    const auto size = static_cast<std::uint64_t>(between < 0 ? -between : between);
    const auto upper = static_cast<std::uint32_t>(size >> 32), lower = static_cast<std::uint32_t>(size);
    const float seconds = 1e-9f * (0x1p32f * static_cast<float>(upper) + static_cast<float>(lower));
    return between < 0 ? -seconds : seconds;
}

/// s that two stamps may seem to be farther apart than `gap`, in seconds, though they are not: two stamps in seconds, each
/// rounded to the nearest double; or two in nanoseconds, each rounded to a whole one, and the six roundings in float of
/// `seconds_between` and of the gap itself.
[[nodiscard]] inline double stamp_rounding(double one, double other, double) noexcept {
    return epsilon<double> * (std::abs(one) + std::abs(other));
}
[[nodiscard]] inline float stamp_rounding(Nanoseconds, Nanoseconds, float gap) noexcept {
    return 1e-9f + 3 * epsilon<float> * gap;
}

} // namespace detail

/// Whether a guard can go by these limits.
template <Real F>
[[nodiscard]] bool is_usable(const BasicGuardLimits<F>& l) noexcept {
    bool numbers = true;
    for (const F limit : {l.max_force, l.max_slew, l.ramp, l.stiffness, l.max_sudden, l.max_gap, l.period,
                          l.max_still, l.max_speed, l.max_step})
        numbers = numbers && detail::is_limit(limit);
    return numbers && l.max_repeats >= 0 && l.max_force > 0 && l.max_slew > 0 && l.max_gap > 0 &&
           l.max_speed > 0;
}

/// Limits that fit a device; what it does not tell (0, or no number above 0) is as in `GuardLimits`.
///
/// max_slew is the device's own limit where that is lower than 1 N/ms, and 1 N/ms for any other device: that is a wall of 500 N/m met
/// at 2 m/s, or one of 3500 N/m at 0.3 m/s; a harder hit is felt softer for some milliseconds, and the full force of
/// a strong device, 8.5 N, is not there before 8.5 ms. Stiffness × speed for the stiffest device would let it be there
/// in one.
///
/// max_gap is two periods of the device and 10 ms of jitter; max_repeats is that at 8 kHz. A rate below 50 Hz counts as not
/// told: taken at its word, a rate in kHz would let a force stand for seconds.
template <Real F = double>
[[nodiscard]] BasicGuardLimits<F> guard_limits(const BasicDeviceCapabilities<F>& device) noexcept {
    const auto told = [](const F& x) { return detail::is_limit(x) && x > 0; };
    BasicGuardLimits<F> limits;
    if (told(device.max_force)) limits.max_force = device.max_force;
    if (told(device.max_slew)) limits.max_slew = std::min(limits.max_slew, device.max_slew);
    if (told(device.max_stiffness)) limits.stiffness = device.max_stiffness;
    if (told(device.rate) && device.rate >= 50) {
        limits.period = 1 / device.rate;
        limits.max_gap = F(0.01) + 2 * limits.period;
        limits.max_repeats = static_cast<int>(8000 * limits.max_gap + F(0.5));
    }
    return limits;
}

/// The same for a scene whose stiffest is `stiffness`, in N/m at the hand, behind a `VirtualCoupling` with this lag: a hand
/// that moves by d makes the force of spring and damper together rise by (1 + 1.5·lag)·stiffness·d at the most.
template <Real F = double>
[[nodiscard]] BasicGuardLimits<F> guard_limits(const BasicDeviceCapabilities<F>& device,
                                               std::type_identity_t<F> stiffness,
                                               std::type_identity_t<F> lag = F(0.5)) noexcept {
    BasicGuardLimits<F> limits = guard_limits(device);
    limits.stiffness = (1 + F(1.5) * lag) * stiffness;
    return limits;
}

} // namespace hfh

#endif // HFH_DEVICE_GUARD_LIMITS_HPP
