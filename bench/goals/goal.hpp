#ifndef HFH_BENCH_GOALS_GOAL_HPP
#define HFH_BENCH_GOALS_GOAL_HPP

#include <stdexcept>
#include <string>
#include <vector>

// What the parts of hfh_goals find. Which goal a number is held against, and how it is shown, is not theirs to say: that
// is in goals.toml and bench.py.

namespace hfh::bench {

/// One number that has a goal.
struct Measured {
    std::string goal;   ///< its id in goals.toml
    std::string figure; ///< which of the goal's numbers: a step, a length, a ground
    double value = 0;
    /// What a ratio is made of, nanoseconds: the reference's time, ours.
    std::vector<double> times{};
    std::string note{}; ///< a peer's errors, where the worst was
};

/// What one update costs in a workload that has no goal.
struct Workload {
    std::string name;
    std::string ground, source; ///< source: bundled, generated or shared
    double cells = 0;
    double mean_ns = 0, worst_ns = 0;
};

struct Skipped {
    std::string what, why;
};

/// What a part of the goals returns.
struct Findings {
    std::vector<Measured> numbers;
    std::vector<Workload> workloads{};
    std::vector<Skipped> skipped{};
    std::vector<std::string> too_slow{}; ///< updates that took 1 ms: a haptic loop runs at 1 kHz

    void note_update(double nanoseconds, const std::string& what) {
        if (nanoseconds >= 1e6) too_slow.push_back(what + ": an update took 1 ms or more");
    }
};

/// An answer is wrong: the program ends.
struct Fault : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct Settings {
    bool vast = false;       ///< with what needs gigabytes
    std::string scratch;     ///< where the raster of a billion samples may lie
    std::string compiler;    ///< as it is called
    std::string include;     ///< the library's headers
    std::string glm_include; ///< empty: found by the compiler itself
};

// The parts, one a file.
[[nodiscard]] Findings sliding(const Settings&);
[[nodiscard]] Findings closest_peers(const Settings&);
[[nodiscard]] Findings crossing(const Settings&);
[[nodiscard]] Findings bounds(const Settings&);
[[nodiscard]] Findings worst_updates(const Settings&);
[[nodiscard]] Findings vast(const Settings&);
[[nodiscard]] Findings scalars(const Settings&);
[[nodiscard]] Findings beside_heights(const Settings&);
[[nodiscard]] Findings compile_time(const Settings&);
[[nodiscard]] Findings blended_levels(const Settings&);
[[nodiscard]] Findings zoom(const Settings&);
[[nodiscard]] Findings nearest(const Settings&);
[[nodiscard]] Findings ball(const Settings&);

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_GOAL_HPP
