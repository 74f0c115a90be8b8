#ifndef HFH_BENCH_ACCURACY_PLOT_HPP
#define HFH_BENCH_ACCURACY_PLOT_HPP

#include "report.hpp"

#include <string>

namespace accuracy {

/// A gnuplot script that draws `file`: a panel a set in double, time across, distance error up.
[[nodiscard]] std::string plot_script(const Run& run, const std::string& file);

} // namespace accuracy

#endif // HFH_BENCH_ACCURACY_PLOT_HPP
