#ifndef HFH_TESTS_SUPPORT_DEVICE_STREAMS_HPP
#define HFH_TESTS_SUPPORT_DEVICE_STREAMS_HPP

#include "random.hpp"

#include <hfh/device/device.hpp>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

// Samples as devices, drivers and operating systems deliver them: polled faster or slower than the device samples, late,
// in bursts, with the stamps of coarse clocks, twice, out of order. All of one hand that is where it should be.

namespace hfh::test {

/// How samples come, and whose stamps they carry.
enum class Delivery {
    stalled_polls, ///< polled, stamped by the host, with a stall before some polls
    late_arrival,  ///< polled, stamped by the host; each sample arrives later than it was taken
    device_stamps, ///< polled, stamped by the device
    late_stamps,   ///< one update a sample, stamped by the host when it came to it, in order
    stamp_after,   ///< polled; between the reading of the place and that of the clock the host may stall
    burst, ///< one update a sample; what came during a stall is handed out at once, stamped by the host
    burst_at_once,     ///< the same, all with one stamp
    millisecond_clock, ///< polled, stamped by a clock that tells whole milliseconds
    coarse_clock,      ///< one update a sample, stamped by a clock that ticks 64 times a second
    out_of_order       ///< one update a sample, stamped late at random, and not in order
};
inline constexpr Delivery all_deliveries[] = {
    Delivery::stalled_polls, Delivery::late_arrival, Delivery::device_stamps, Delivery::late_stamps,
    Delivery::stamp_after,   Delivery::burst,        Delivery::burst_at_once, Delivery::millisecond_clock,
    Delivery::coarse_clock,  Delivery::out_of_order};

[[nodiscard]] constexpr const char* to_string(Delivery delivery) {
    switch (delivery) {
    case Delivery::stalled_polls: return "stalled_polls";
    case Delivery::late_arrival: return "late_arrival";
    case Delivery::device_stamps: return "device_stamps";
    case Delivery::late_stamps: return "late_stamps";
    case Delivery::stamp_after: return "stamp_after";
    case Delivery::burst: return "burst";
    case Delivery::burst_at_once: return "burst_at_once";
    case Delivery::millisecond_clock: return "millisecond_clock";
    case Delivery::coarse_clock: return "coarse_clock";
    case Delivery::out_of_order: return "out_of_order";
    }
    return "unknown";
}

struct StreamOptions {
    Delivery delivery = Delivery::stalled_polls;
    double rate = 1000;  ///< Hz: of the device
    double polls = 8000; ///< Hz: of the host
    double jitter = 0;   ///< s, at most
    double speed = 3;    ///< m/s, to and fro over 20 cm
    /// In place of that: over 40 cm and back, as hands reach (least jerk), with rests between; `speed` is the fastest.
    bool reaches = false;
    double resolution = 0.055e-3; ///< m; 0: none
    double seconds = 2;
    double start = 100; ///< s: of the stamps
    int stall_in = 50;  ///< one poll or sample in so many is delayed
    std::uint64_t seed = 1;
};

/// The samples of a run, in the order in which a tick sees them.
class DeviceStream {
public:
    explicit DeviceStream(const StreamOptions& options)
        : o_{options}, random_{options.seed}, period_{1 / options.rate}, phase_{random_.unit() * period_},
          samples_{static_cast<long>(options.seconds * options.rate)} {}

    [[nodiscard]] std::vector<DeviceSample> deliver() {
        switch (o_.delivery) {
        case Delivery::stalled_polls: stalled_polls(); break;
        case Delivery::late_arrival: late_arrival(); break;
        case Delivery::device_stamps: device_stamps(); break;
        case Delivery::late_stamps: late_stamps(); break;
        case Delivery::stamp_after: stamp_after(); break;
        case Delivery::burst: burst(1e-5); break;
        case Delivery::burst_at_once: burst(0); break;
        case Delivery::millisecond_clock: millisecond_clock(); break;
        case Delivery::coarse_clock: coarse_clock(); break;
        case Delivery::out_of_order: out_of_order(); break;
        }
        return std::move(out_);
    }

private:
    void stalled_polls() {
        for (double t = 2 * period_; t < o_.seconds; t += 1 / o_.polls + delay()) put(t, newest(t));
    }
    void late_arrival() {
        std::vector<double> arrives;
        for (long k = 0; k < samples_; ++k) {
            const double when = taken_at(k) + late();
            arrives.push_back(k > 0 ? std::max(arrives.back(), when) : when);
        }
        long k = 0;
        for (double t = arrives[0]; t < o_.seconds; t += 1 / o_.polls) {
            while (k + 1 < samples_ && arrives[static_cast<std::size_t>(k + 1)] <= t) ++k;
            put(t, k);
        }
    }
    void device_stamps() {
        for (double t = 2 * period_; t < o_.seconds; t += 1 / o_.polls + delay())
            put(taken_at(newest(t)), newest(t));
    }
    void late_stamps() {
        double last = 0;
        for (long k = 0; k < samples_; ++k) {
            last = std::max(last, taken_at(k) + late());
            put(last, k);
        }
    }
    void stamp_after() {
        for (double t = 2 * period_; t < o_.seconds; t += 1 / o_.polls) {
            const long k = newest(t);
            t += delay();
            put(t, k);
        }
    }
    /// `apart`: s between two samples that are handed out after a stall.
    void burst(double apart) {
        double free_at = 0; // s: until then nothing is handed out
        for (long k = 0; k < samples_; ++k) {
            const double now = taken_at(k);
            if (random_.one_in(o_.stall_in)) free_at = std::max(free_at, now + late());
            const double stamp = std::max(now, free_at);
            put(stamp, k);
            free_at = std::max(free_at, stamp + apart);
        }
    }
    void millisecond_clock() {
        for (double t = 2 * period_; t < o_.seconds; t += 1 / o_.polls + delay())
            put(std::floor(1000 * t) / 1000, newest(t));
    }
    void coarse_clock() {
        for (long k = 0; k < samples_; ++k) put(std::floor(64 * taken_at(k)) / 64, k);
    }
    void out_of_order() {
        for (long k = 0; k < samples_; ++k) put(taken_at(k) + late(), k);
    }

    /// The k-th sample of the device, stamped `time` seconds after the start.
    void put(double time, long k) {
        out_.push_back({.time = o_.start + time, .position = {0.01, -0.02, hand(taken_at(k))}});
    }
    [[nodiscard]] double hand(double t) const {
        const double z = o_.reaches ? reach(t) : to_and_fro(t);
        return o_.resolution > 0 ? std::round(z / o_.resolution) * o_.resolution : z;
    }
    [[nodiscard]] double to_and_fro(double t) const {
        constexpr double half = 0.1; // m
        const double way = std::fmod(o_.speed * t, 4 * half);
        return way < 2 * half ? way - half : 3 * half - way;
    }
    [[nodiscard]] double reach(double t) const {
        constexpr double length = 0.4, rest = 0.15;     // m, s
        const double lasts = 1.875 * length / o_.speed; // s: the fastest is 15/8 of the mean
        const double one = rest + lasts, u = std::fmod(t, 2 * one);
        const double s = std::clamp((std::fmod(u, one) - rest) / lasts, 0.0, 1.0);
        const double part = s * s * s * (10 - 15 * s + 6 * s * s);
        return length * (u < one ? part : 1 - part);
    }
    [[nodiscard]] double taken_at(long k) const { return static_cast<double>(k) * period_ + phase_; }
    [[nodiscard]] long newest(double t) const {
        return static_cast<long>(std::floor((t - phase_) / period_));
    }
    [[nodiscard]] double late() { return random_.unit() * o_.jitter; }
    [[nodiscard]] double delay() { return random_.one_in(o_.stall_in) ? late() : 0.0; }

    StreamOptions o_;
    Random random_;
    double period_, phase_; ///< s
    long samples_;
    std::vector<DeviceSample> out_{};
};
[[nodiscard]] inline std::vector<DeviceSample> deliver(const StreamOptions& options) {
    return DeviceStream{options}.deliver();
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_DEVICE_STREAMS_HPP
