#ifndef HFH_BENCH_GOALS_RECORD_HPP
#define HFH_BENCH_GOALS_RECORD_HPP

#include "goal.hpp"

#include <iosfwd>
#include <map>
#include <string>
#include <utility>

// goals.json: what was measured, and which goals are held.

namespace hfh::bench {

struct Machine {
    std::string cpu, compiler, flags;

    [[nodiscard]] bool operator==(const Machine&) const = default;
};

/// What goals.json says of one number.
struct Recorded {
    std::optional<double> measured;
    bool held = false;
    std::string beside, date; ///< of its row
};

struct Record {
    Machine machine;
    std::map<std::pair<std::string, std::string>, Recorded> numbers; ///< by the row's name and the number's
    std::vector<Workload> workloads;
};

/// Reads what `write_json` wrote; all empty if there is no such file.
[[nodiscard]] Record read_record(const std::string& path);

/// A missed number is lost only if it is missed by more than this: times of one run repeat to a few hundredths.
[[nodiscard]] constexpr double slack(const Row& row) noexcept { return row.timed ? 0.1 : 0; }

/// Marks what is met now, or was held before, as held.
void hold(std::vector<Row>&, const Record& before);

/// Fills rows that were not measured now with what an earlier run on the same machine measured, and adds its workloads.
void take_over(Findings& now, const Record& before, const Machine&);

void write_json(std::ostream&, const Machine&, const Findings&);
/// The tables of README.
void write_markdown(std::ostream&, const Machine&, const Findings&);
/// One row, for people who wait.
void print(const Row&);

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_RECORD_HPP
