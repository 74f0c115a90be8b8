#ifndef HFH_DEVICE_SAMPLE_CHECK_HPP
#define HFH_DEVICE_SAMPLE_CHECK_HPP

#include <hfh/device/guard_limits.hpp>

#include <algorithm>

// Whether samples can come from a device in a hand, judged by their times and places alone.

namespace hfh {

/// What a sample told.
template <Real F>
struct BasicCheckedSample {
    bool stale = false, repeated = false, jump = false;
    F passed = 0; ///< s since the latest sample before; 0 if its time is not later
    F moved = 0;  ///< m since the sample before
    F rested = 0; ///< s for which the place has been the same, to the bit
};
using CheckedSample = BasicCheckedSample<double>;

/// Checks samples one after the other: `stale`, `repeated`, `jump` as in `GuardTrip`.
///
/// `GuardLimits::max_gap` is the longest time between two samples that is not stale. Two more times are as long, and
/// have names of their own here:
///
///     max_back = max_gap    by which a stamp may be earlier than the latest one
///     window = max_gap      of the past, in which the speed of the hand is measured
///
/// A time that is not later than the latest one, by up to max_back, is a repeated sample or one out of order: no time
/// has passed. A time that is farther back is a clock that was set back: `stale` once, then it is the time. Sums of
/// the rounding of two stamps count for nothing.
///
/// Speed is measured between samples in which the place changes: a device that is polled faster than it samples tells the
/// same place many times, and so does an encoder in slow motion. With s the time since the place changed last,
///
///     jump:  moved > max_step + max_speed · min(max(s, P) + scatter, reserve)
///
/// reserve keeps the sum of all moves to that speed: it grows with time up to window, and a move takes moved/max_speed
/// of it. So no move is longer than max_step + max_speed·window, and none is faster than max_speed for long.
///
/// P is the mean of s, scatter how far s has been from it lately. They are there for stamps that are not the device's own:
/// after a stall samples come in a burst, each farther on by what the hand does in P, and a stamp that was taken late is
/// followed by one that seems early. Where the place changes at steady intervals, P becomes s and scatter 0.
///
///     scatter ← scatter · max(0, 1 − Δt/(6·window))                      with every sample, and after each change
///     scatter ← max(2·|s − P|, scatter),  then  P ← P + (s − P)/16
///
/// Twice, because two delays may follow each other, and only the first makes s longer. At first scatter is window, and P
/// the device's period or, where that is not told, window as well.
///
/// Where samples came that told the same place and s is longer than window, the hand was at rest or slow: then s is the
/// time since the sample before, and a jump from rest is one as well. Such an interval teaches nothing about P. Nor does one in
/// which samples told the same place and which ends with a move of less than max_step, for that is a slow hand, nor a
/// sample that jumps or is stale.
///
/// Precondition: usable limits, tame numbers. Does not throw and does not allocate.
template <Real F>
class BasicSampleCheck {
public:
    [[nodiscard]] BasicCheckedSample<F> update(const BasicGuardLimits<F>& limits, DeviceTime<F> time,
                                               const vec3<F>& position) noexcept {
        BasicCheckedSample<F> told;
        const F window = limits.max_gap;
        if (!started_) {
            started_ = true;
            time_ = changed_at_ = time;
            position_ = position;
            scatter_ = reserve_ = window;
            period_ = limits.period > 0 ? std::min(limits.period, window) : window;
            return told;
        }
        const F passed = detail::seconds_between(time_, time);
        const F max_gap = limits.max_gap + detail::stamp_rounding(time, time_, limits.max_gap);
        const F max_back = max_gap;
        told.stale = passed > max_gap || passed < -max_back;
        told.passed = std::max(F(0), passed);
        told.moved = detail::norm(position - position_);

        if (passed > 0 || told.stale)
            repeats_ = 0;
        else if (repeats_ <= limits.max_repeats) // one more would do; counting on could overflow
            ++repeats_;
        if (passed < -max_back) changed_at_ = time;
        if (passed > 0 || told.stale) time_ = time;

        reserve_ = std::min(window, reserve_ + told.passed);
        scatter_ *= std::max(F(0), 1 - told.passed / (6 * window));
        if (position != position_) {
            const F unchanged = detail::seconds_between(changed_at_, time_);
            const bool rested = waited_ && unchanged > window;
            const F since = std::min(rested ? told.passed : unchanged, window);
            const F seconds = std::min(std::max(since, period_) + scatter_, reserve_);
            told.jump = told.moved > limits.max_step + limits.max_speed * seconds;
            const bool sure = !waited_ || (!rested && told.moved > limits.max_step);
            if (sure && !told.jump && !told.stale) learn(since);
            reserve_ = std::max(F(0), reserve_ - told.moved / limits.max_speed);
            waited_ = false;
            changed_at_ = time_;
            position_ = position;
        } else {
            waited_ = true;
        }
        told.rested = detail::seconds_between(changed_at_, time_);
        const bool still = limits.max_still > 0 && told.rested > limits.max_still;
        told.repeated = repeats_ > limits.max_repeats || still;
        return told;
    }

    /// The next sample is compared with nothing, like the first.
    void forget() noexcept { *this = BasicSampleCheck{}; }

    /// The time of the latest sample.
    [[nodiscard]] DeviceTime<F> time() const noexcept { return time_; }

private:
    void learn(F since) noexcept {
        scatter_ = std::max(2 * std::abs(since - period_), scatter_);
        period_ += (since - period_) / 16;
    }

    DeviceTime<F> time_{};       ///< the latest so far
    DeviceTime<F> changed_at_{}; ///< when the place changed last
    F period_ = 0;               ///< s: P, the mean interval of changes
    F scatter_ = 0;              ///< s
    F reserve_ = 0;              ///< s
    vec3<F> position_{F(0)};
    int repeats_ = 0; ///< updates since time last went on
    bool started_ = false;
    bool waited_ = false; ///< there was a sample since the place changed
};
using SampleCheck = BasicSampleCheck<double>;

} // namespace hfh

#endif // HFH_DEVICE_SAMPLE_CHECK_HPP
