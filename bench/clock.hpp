#ifndef HFH_BENCH_CLOCK_HPP
#define HFH_BENCH_CLOCK_HPP

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>

#if defined(__x86_64__)
#include <x86intrin.h>
#endif

namespace hfh::bench {

/// A reading of the cheapest clock there is. Everything before it has finished and nothing after it has begun, so
/// that the time between two readings belongs to what stands between them.
[[nodiscard]] inline std::uint64_t ticks() noexcept {
#if defined(__x86_64__)
    unsigned core;
    const std::uint64_t now = __rdtscp(&core);
    _mm_lfence();
    return now;
#else
    return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

/// Nanoseconds a tick, against the system's clock.
[[nodiscard]] inline double nanoseconds_per_tick() {
    using Clock = std::chrono::steady_clock;
    static const double once = [] {
        const auto begin = Clock::now();
        const std::uint64_t first = ticks();
        while (Clock::now() - begin < std::chrono::milliseconds{50}) {
        }
        const auto end = Clock::now();
        const std::uint64_t last = ticks();
        return std::chrono::duration<double, std::nano>(end - begin).count() /
               static_cast<double>(last - first);
    }();
    return once;
}

/// What one reading costs, in nanoseconds: the median of many with nothing in between.
[[nodiscard]] inline double clock_cost() {
    static const double once = [] {
        std::vector<std::uint64_t> cost(10'001);
        std::uint64_t last = ticks();
        for (auto& c : cost) {
            const std::uint64_t now = ticks();
            c = now - last;
            last = now;
        }
        std::nth_element(cost.begin(), cost.begin() + 5'000, cost.end());
        return static_cast<double>(cost[5'000]) * nanoseconds_per_tick();
    }();
    return once;
}

} // namespace hfh::bench

#endif // HFH_BENCH_CLOCK_HPP
