#ifndef HFH_BENCH_CLOSED_LOOP_REPORT_HPP
#define HFH_BENCH_CLOSED_LOOP_REPORT_HPP

#include "touching.hpp"

#include <cstdio>
#include <string>
#include <vector>

namespace closed_loop {

/// Numbers by printf's rules.
[[nodiscard]] std::string text(const char* format, auto... values) {
    char line[512];
    std::snprintf(line, sizeof line, format, values...);
    return line;
}

enum class Verdict {
    met,
    not_met,
    known, ///< not met, and the report says why: no failure of the program
    none   ///< a figure without a goal
};
[[nodiscard]] inline Verdict verdict(bool met) { return met ? Verdict::met : Verdict::not_met; }

/// A line of the report: what was asked, the goal, and what came out in one scalar.
struct Row {
    std::string what, goal, measured;
    Verdict verdict = Verdict::none;
};

/// One scalar's figures.
struct Findings {
    std::vector<Row> rows;
    std::vector<std::string> grounds; ///< touched, in order
    /// A figure a ground and kind, for the table by ground.
    struct Detail {
        std::string kind;
        std::vector<std::string> by_ground;
    };
    std::vector<Detail> details;
    /// A table of its own, beside the rows.
    struct Table {
        std::string title;
        std::vector<std::string> head;
        std::vector<std::vector<std::string>> rows;
    };
    std::vector<Table> tables;
    Lag lag;     ///< in everything that was touched
    Lag gliding; ///< of trackers that may slide no farther than a little
};

/// How much is run: 1 for the report, less for a test.
struct Effort {
    double share = 1;
    [[nodiscard]] int counted(int full, int least = 2) const {
        return std::max(least, static_cast<int>(std::lround(share * full)));
    }
};

/// What has no ground but a wall, and so no scalar.
void passivity(Findings& findings);
void grips_and_lags(const Effort& effort, Findings& findings);

template <Real T>
void wall(const Effort& effort, Findings& findings);
template <Real T>
void energy(const Effort& effort, Findings& findings);
template <Real T>
void rest(const Effort& effort, Findings& findings);
template <Real T>
void steps(const Effort& effort, Findings& findings);

/// All of it as Markdown.
[[nodiscard]] std::string markdown(const Findings& in_double, const Findings& in_float);

} // namespace closed_loop

#endif // HFH_BENCH_CLOSED_LOOP_REPORT_HPP
