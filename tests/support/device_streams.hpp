#ifndef HFH_TESTS_SUPPORT_DEVICE_STREAMS_HPP
#define HFH_TESTS_SUPPORT_DEVICE_STREAMS_HPP

#include "random.hpp"

#include <hfh/device/device.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
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
    double rate = 1000;           ///< Hz: of the device
    double polls = 8000;          ///< Hz: of the host
    double jitter = 0;            ///< s, at most
    double speed = 3;             ///< m/s, to and fro over 20 cm
    double resolution = 0.055e-3; ///< m; 0: none
    double seconds = 2;
    double start = 100; ///< s: of the stamps
    int stall_in = 50;  ///< one poll or sample in so many is delayed
    std::uint64_t seed = 1;
};

/// The samples of a run, in the order in which a tick sees them.
[[nodiscard]] inline std::vector<DeviceSample> deliver(const StreamOptions& o) {
    Random random{o.seed};
    const double period = 1 / o.rate, phase = random.unit() * period;
    const auto hand = [&](double t) {
        constexpr double half = 0.1; // m
        const double way = std::fmod(o.speed * t, 4 * half);
        const double z = way < 2 * half ? way - half : 3 * half - way;
        return o.resolution > 0 ? std::round(z / o.resolution) * o.resolution : z;
    };
    // The k-th sample of the device.
    const auto taken_at = [&](long k) { return static_cast<double>(k) * period + phase; };
    const auto place = [&](long k) { return glm::dvec3{0.01, -0.02, hand(taken_at(k))}; };
    const auto at = [&](double time, long k) {
        return DeviceSample{.time = o.start + time, .position = place(k)};
    };
    const auto newest = [&](double t) { return static_cast<long>(std::floor((t - phase) / period)); };
    const auto delay = [&] { return random.one_in(o.stall_in) ? random.unit() * o.jitter : 0.0; };
    const long samples = static_cast<long>(o.seconds * o.rate);

    std::vector<DeviceSample> out;
    switch (o.delivery) {
    case Delivery::stalled_polls:
        for (double t = 2 * period; t < o.seconds; t += 1 / o.polls + delay())
            out.push_back(at(t, newest(t)));
        break;
    case Delivery::late_arrival: {
        std::vector<double> arrives;
        for (long k = 0; k < samples; ++k) {
            const double when = taken_at(k) + random.unit() * o.jitter;
            arrives.push_back(k > 0 ? std::max(arrives.back(), when) : when);
        }
        long k = 0;
        for (double t = arrives[0]; t < o.seconds; t += 1 / o.polls) {
            while (k + 1 < samples && arrives[static_cast<std::size_t>(k + 1)] <= t) ++k;
            out.push_back(at(t, k));
        }
        break;
    }
    case Delivery::device_stamps:
        for (double t = 2 * period; t < o.seconds; t += 1 / o.polls + delay())
            out.push_back(at(taken_at(newest(t)), newest(t)));
        break;
    case Delivery::late_stamps: {
        double last = 0;
        for (long k = 0; k < samples; ++k) {
            last = std::max(last, taken_at(k) + random.unit() * o.jitter);
            out.push_back(at(last, k));
        }
        break;
    }
    case Delivery::stamp_after:
        for (double t = 2 * period; t < o.seconds; t += 1 / o.polls) {
            const long k = newest(t);
            t += delay();
            out.push_back(at(t, k));
        }
        break;
    case Delivery::burst:
    case Delivery::burst_at_once: {
        const double apart = o.delivery == Delivery::burst ? 1e-5 : 0.0;
        double free_at = 0; // s: until then nothing is handed out
        for (long k = 0; k < samples; ++k) {
            const double now = taken_at(k);
            if (random.one_in(o.stall_in)) free_at = std::max(free_at, now + random.unit() * o.jitter);
            const double stamp = std::max(now, free_at);
            out.push_back(at(stamp, k));
            free_at = std::max(free_at, stamp + apart);
        }
        break;
    }
    case Delivery::millisecond_clock:
        for (double t = 2 * period; t < o.seconds; t += 1 / o.polls + delay())
            out.push_back(at(std::floor(1000 * t) / 1000, newest(t)));
        break;
    case Delivery::coarse_clock:
        for (long k = 0; k < samples; ++k) out.push_back(at(std::floor(64 * taken_at(k)) / 64, k));
        break;
    case Delivery::out_of_order:
        for (long k = 0; k < samples; ++k) out.push_back(at(taken_at(k) + random.unit() * o.jitter, k));
        break;
    }
    return out;
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_DEVICE_STREAMS_HPP
