#ifndef HFH_BENCH_GOALS_GOAL_HPP
#define HFH_BENCH_GOALS_GOAL_HPP

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

// What the table of goals is made of.

namespace hfh::bench {

/// One number that has a goal.
struct Figure {
    enum class Goal { at_most, at_least, below, more_than };

    std::string what; ///< which of the row's numbers; empty if it has only one
    Goal goal = Goal::at_most;
    double bound = 0;
    std::optional<double> measured{}; ///< none: not measured, for want of the peer, of memory or of time
    /// Met at this recording or an earlier one, and not given up since: a promise.
    bool held = false;

    [[nodiscard]] bool met_within(double slack) const noexcept {
        if (!measured) return false;
        switch (goal) {
        case Goal::at_most: return *measured <= bound * (1 + slack);
        case Goal::below: return *measured < bound * (1 + slack);
        case Goal::at_least: return *measured >= bound * (1 - slack);
        case Goal::more_than: return *measured > bound * (1 - slack);
        }
        return false;
    }
    [[nodiscard]] bool met() const noexcept { return met_within(0); }
    /// Held and measured, and missed by more than the slack.
    [[nodiscard]] bool lost(double slack) const noexcept { return held && measured && !met_within(slack); }
    /// How good: 1 at the goal, more is better.
    [[nodiscard]] double quality() const noexcept {
        if (!measured) return 0;
        const bool small_is_good = goal == Goal::at_most || goal == Goal::below;
        const double number = std::abs(*measured) + 1e-300, wanted = std::abs(bound) + 1e-300;
        return small_is_good ? wanted / number : number / wanted;
    }
};

/// One line of the table.
struct Row {
    std::string name;
    std::string unit;            ///< of all its numbers: "×", "ns", "bytes"
    std::vector<Figure> figures; ///< measured and bound, in order
    std::string beside{};        ///< the times that a ratio is made of, a peer's errors
    bool timed = true;           ///< false: bytes and counts, in which there is no noise
    std::string date{};          ///< of the measurement

    [[nodiscard]] bool measured() const {
        for (const auto& f : figures) {
            if (!f.measured) return false;
        }
        return true;
    }
    [[nodiscard]] bool met() const {
        for (const auto& f : figures) {
            if (!f.met()) return false;
        }
        return true;
    }
    [[nodiscard]] double quality() const {
        double worst = 1e300;
        for (const auto& f : figures) worst = std::min(worst, f.quality());
        return worst;
    }
    [[nodiscard]] const char* verdict() const {
        return met() ? "met" : "not met"; // what is not measured is not met
    }
};

/// A line without a goal: what one workload costs where.
struct Workload {
    std::string name;
    std::string ground;
    double cells = 0;
    double mean_ns = 0;
    std::optional<double> worst_ns{};
};

/// What a part of the goals returns.
struct Findings {
    std::vector<Row> rows;
    std::vector<Workload> workloads{};
    std::vector<std::string> too_slow{}; ///< updates that took 1 ms: a haptic loop runs at 1 kHz

    void note_update(double nanoseconds, const std::string& what) {
        if (nanoseconds >= 1e6) too_slow.push_back(what + ": an update took 1 ms or more");
    }
};

/// An answer is wrong: nothing is recorded then.
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

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_GOAL_HPP
