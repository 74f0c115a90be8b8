#ifndef HFH_BENCH_GOALS_RECORD_HPP
#define HFH_BENCH_GOALS_RECORD_HPP

#include "goal.hpp"

#include <iosfwd>
#include <set>
#include <string>

namespace hfh::bench {

/// A row's name and a number's.
using FigureName = std::pair<std::string, std::string>;

/// The numbers that goals.json says were met; none if there is no such file.
[[nodiscard]] std::set<FigureName> met_at_last_recording(const std::string& path);

struct Machine {
    std::string cpu, compiler, flags, date;
};

void write_json(std::ostream&, const Machine&, const Findings&);
/// The tables of README.
void write_markdown(std::ostream&, const Machine&, const Findings&);
/// One row, for people who wait.
void print(const Row&);

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_RECORD_HPP
