#ifndef HFH_BENCH_BALL_FEEL_REPORT_HPP
#define HFH_BENCH_BALL_FEEL_REPORT_HPP

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace ball_feel {

/// Numbers by printf's rules.
[[nodiscard]] std::string text(const char* format, auto... values) {
    char line[512];
    std::snprintf(line, sizeof line, format, values...);
    return line;
}

/// A section of the page.
struct Section {
    std::string markdown;
    std::string plot;   ///< a script for gnuplot, without its terminal and output
    bool is_met = true; ///< all its goals
};

/// How much is run: 1 for the page, less for a test.
struct Effort {
    double share = 1;
    [[nodiscard]] int counted(int full, int least) const {
        return std::max(least, static_cast<int>(std::lround(share * full)));
    }
};

// Colours that eyes without red or green tell apart: Okabe and Ito, Color Universal Design (2008).
inline constexpr const char* black = "#000000";
inline constexpr const char* vermilion = "#d55e00";
inline constexpr const char* blue = "#0072b2";

[[nodiscard]] Section force_steps(const Effort& effort);
[[nodiscard]] Section roughness(const Effort& effort);

} // namespace ball_feel

#endif // HFH_BENCH_BALL_FEEL_REPORT_HPP
