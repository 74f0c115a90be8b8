#ifndef HFH_BENCH_GOALS_TEXT_HPP
#define HFH_BENCH_GOALS_TEXT_HPP

#include <cmath>
#include <cstdio>
#include <string>

namespace hfh::bench {

/// Digits that are worth reading.
[[nodiscard]] inline std::string text(double number, int digits = 3) {
    char buffer[40];
    if (number != 0 && std::abs(number) < 1e6 && std::abs(number) >= 100) {
        std::snprintf(buffer, sizeof buffer, "%.0f", number);
    } else {
        std::snprintf(buffer, sizeof buffer, "%.*g", digits, number);
    }
    return buffer;
}

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_TEXT_HPP
