#ifndef HFH_BENCH_GOALS_RACE_HPP
#define HFH_BENCH_GOALS_RACE_HPP

#include "../clock.hpp"

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace hfh::bench {

/// Something whose time is taken in slices of some ten thousand to a million nanoseconds, the same ones in each round.
struct Runner {
    std::size_t slices = 1;
    double items = 1; ///< in a slice: updates, queries
    std::function<void(std::size_t slice)> run;
};

/// Nanoseconds an item.
struct Pace {
    double fastest =
        0; ///< each slice at its fastest of all rounds: what the system does meanwhile is not in it
    double median = 0; ///< each slice at its median: what the caches do to it is
};

/// Times of all runners, a slice of each in turn, so that whatever slows the machine slows all of them. A runner with
/// fewer slices than another begins again.
[[nodiscard]] inline std::vector<Pace> race(const std::vector<Runner>& runners, int rounds) {
    std::size_t slices = 0;
    for (const auto& r : runners) slices = std::max(slices, r.slices);
    std::vector<std::vector<std::vector<double>>> times(runners.size());
    for (std::size_t k = 0; k < runners.size(); ++k) times[k].resize(runners[k].slices);
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t slice = 0; slice < slices; ++slice) {
            for (std::size_t k = 0; k < runners.size(); ++k) {
                const std::size_t here = slice % runners[k].slices;
                const std::uint64_t begin = ticks();
                runners[k].run(here);
                times[k][here].push_back(static_cast<double>(ticks() - begin));
            }
        }
    }
    std::vector<Pace> paces;
    for (std::size_t k = 0; k < runners.size(); ++k) {
        Pace pace;
        for (auto& of_slice : times[k]) {
            std::sort(of_slice.begin(), of_slice.end());
            pace.fastest += of_slice.front();
            pace.median += of_slice[of_slice.size() / 2];
        }
        const double per_item =
            nanoseconds_per_tick() / (static_cast<double>(runners[k].slices) * runners[k].items);
        paces.push_back({pace.fastest * per_item, pace.median * per_item});
    }
    return paces;
}

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_RACE_HPP
