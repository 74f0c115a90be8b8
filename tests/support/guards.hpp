#ifndef HFH_TESTS_SUPPORT_GUARDS_HPP
#define HFH_TESTS_SUPPORT_GUARDS_HPP

#include <hfh/device/force_guard.hpp>

#include <cmath>
#include <cstdint>
#include <limits>

// The guard that the tests of guards are about: `ForceGuard`; where HFH_TEST_FLOAT_GUARD is defined, the one in float, which
// takes and gives the same numbers, rounded.

namespace hfh::test {

/// The nearest nanosecond; one that no guard takes if the time is no number, or so far off that it cannot be counted.
[[nodiscard]] inline Nanoseconds to_nanoseconds(double seconds) {
    if (!detail::is_tame(seconds) || std::abs(seconds) > 4e9)
        return {std::numeric_limits<std::int64_t>::max()};
    return {std::llround(1e9 * seconds)};
}
[[nodiscard]] inline double to_seconds(Nanoseconds time) { return 1e-9 * static_cast<double>(time.count); }

[[nodiscard]] inline BasicDeviceSample<float> to_float(const DeviceSample& sample) {
    return {.time = to_nanoseconds(sample.time),
            .position = vec3<float>{sample.position},
            .velocity = vec3<float>{sample.velocity},
            .has_velocity = sample.has_velocity,
            .buttons = sample.buttons,
            .force_refused = sample.force_refused,
            .release = sample.release,
            .has_sent = sample.has_sent,
            .sent = vec3<float>{sample.sent},
            .sent_at = to_nanoseconds(sample.sent_at)};
}
[[nodiscard]] inline BasicGuardLimits<float> to_float(const GuardLimits& limits) {
    return {.max_force = static_cast<float>(limits.max_force),
            .max_slew = static_cast<float>(limits.max_slew),
            .ramp = static_cast<float>(limits.ramp),
            .stiffness = static_cast<float>(limits.stiffness),
            .max_sudden = static_cast<float>(limits.max_sudden),
            .max_gap = static_cast<float>(limits.max_gap),
            .period = static_cast<float>(limits.period),
            .max_repeats = limits.max_repeats,
            .max_still = static_cast<float>(limits.max_still),
            .max_speed = static_cast<float>(limits.max_speed),
            .max_step = static_cast<float>(limits.max_step),
            .latch = limits.latch};
}

/// A guard in float, asked and answering in double.
class FloatGuard {
public:
    FloatGuard() : FloatGuard{GuardLimits{}} {}
    explicit FloatGuard(const GuardLimits& limits) : guard_{to_float(limits)}, limits_{limits} {}

    [[nodiscard]] GuardedForce update(const DeviceSample& sample, const glm::dvec3& newtons,
                                      bool buried = false) noexcept {
        const auto given = guard_.update(to_float(sample), vec3<float>{newtons}, buried);
        return {.newtons = widen(given.newtons),
                .trip = given.trip,
                .latched = given.latched,
                .clamped = given.clamped,
                .ramped = given.ramped,
                .held_back = given.held_back,
                .slewed = given.slewed,
                .released = given.released};
    }
    void sent(const glm::dvec3& newtons, double time) noexcept {
        guard_.sent(vec3<float>{newtons}, to_nanoseconds(time));
    }
    void rearm() noexcept { guard_.rearm(); }
    void restart() noexcept { guard_.restart(); }
    [[nodiscard]] const GuardLimits& limits() const noexcept { return limits_; }
    [[nodiscard]] const GuardCounts& counts() const noexcept { return guard_.counts(); }

private:
    BasicForceGuard<float> guard_;
    GuardLimits limits_;
};

/// The same of a check of samples.
class FloatSampleCheck {
public:
    [[nodiscard]] CheckedSample update(const GuardLimits& limits, double time, const glm::dvec3& position) {
        const auto told = check_.update(to_float(limits), to_nanoseconds(time), vec3<float>{position});
        return {.stale = told.stale,
                .repeated = told.repeated,
                .jump = told.jump,
                .passed = widen(told.passed),
                .moved = widen(told.moved),
                .rested = widen(told.rested)};
    }
    void forget() { check_.forget(); }
    [[nodiscard]] double time() const { return to_seconds(check_.time()); }

private:
    BasicSampleCheck<float> check_;
};

#if defined(HFH_TEST_FLOAT_GUARD)
using Guard = FloatGuard;
using Check = FloatSampleCheck;
using GuardScalar = float;

/// What the guard sees of a number, a sample, its limits.
[[nodiscard]] inline double as_seen(double x) { return widen(static_cast<float>(x)); }
[[nodiscard]] inline glm::dvec3 as_seen(const glm::dvec3& p) {
    return {as_seen(p.x), as_seen(p.y), as_seen(p.z)};
}
[[nodiscard]] inline double time_as_seen(double seconds) {
    return detail::is_tame(seconds) ? to_seconds(to_nanoseconds(seconds)) : seconds;
}
[[nodiscard]] inline DeviceSample as_seen(DeviceSample sample) {
    sample.time = time_as_seen(sample.time);
    sample.position = as_seen(sample.position);
    sample.sent = as_seen(sample.sent);
    sample.sent_at = time_as_seen(sample.sent_at);
    return sample;
}
[[nodiscard]] inline GuardLimits as_seen(GuardLimits limits) {
    for (double GuardLimits::*limit :
         {&GuardLimits::max_force, &GuardLimits::max_slew, &GuardLimits::ramp, &GuardLimits::max_gap,
          &GuardLimits::max_still, &GuardLimits::max_speed, &GuardLimits::max_step, &GuardLimits::stiffness,
          &GuardLimits::max_sudden, &GuardLimits::period})
        limits.*limit = as_seen(limits.*limit);
    return limits;
}
#else
using Guard = ForceGuard;
using Check = SampleCheck;
using GuardScalar = double;

template <class T>
[[nodiscard]] const T& as_seen(const T& what) {
    return what;
}
#endif

/// A bound that holds in double, or in float one of so many roundings.
[[nodiscard]] constexpr double guard_rounding(double in_double, double roundings_in_float) {
    return sizeof(GuardScalar) == sizeof(double) ? in_double
                                                 : roundings_in_float * static_cast<double>(epsilon<float>);
}

/// s by which the time between two stamps may be off: in float each is rounded to a nanosecond.
inline constexpr double guard_stamp_rounding = sizeof(GuardScalar) == sizeof(double) ? 0 : 1e-9;

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_GUARDS_HPP
