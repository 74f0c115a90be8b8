#ifndef HFH_BENCH_ACCURACY_REPORT_HPP
#define HFH_BENCH_ACCURACY_REPORT_HPP

#include "measure.hpp"

#include <string>
#include <vector>

// What was measured, as text: a table to look at, JSON to compute with, Markdown to show.

namespace accuracy {

struct Run {
    std::size_t queries; ///< per set
    int rounds;
    std::vector<Measured> sets; ///< each set in double, then in float
};

/// Everything, a line a method.
[[nodiscard]] std::string table(const Run& run);
[[nodiscard]] std::string json(const Run& run);
/// The sets side by side, and what to choose.
[[nodiscard]] std::string markdown(const Run& run);

/// Processor, compiler and day, for people.
[[nodiscard]] std::string machine();

/// Errors up to this (in cells) are called exact: four roundings of a number of the cell's size.
[[nodiscard]] double rounding_error(const std::string& scalar);

/// Whether the method iterates, so that it can stop too early.
[[nodiscard]] inline bool iterates(Family family) {
    return family != Family::vertical && family != Family::triangles;
}
/// Whether the method says itself when it has stopped too early.
[[nodiscard]] inline bool tells(Family family) {
    return family == Family::ours || family == Family::complete;
}

} // namespace accuracy

#endif // HFH_BENCH_ACCURACY_REPORT_HPP
