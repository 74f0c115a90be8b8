#ifndef HFH_BENCH_GNUPLOT_HPP
#define HFH_BENCH_GNUPLOT_HPP

#include <cstdio>
#include <string>

namespace hfh::bench {

/// False if there is no gnuplot or it fails.
[[nodiscard]] inline bool run_gnuplot(const std::string& script) {
    std::FILE* const pipe = ::popen("gnuplot", "w");
    if (!pipe) return false;
    const bool written = std::fwrite(script.data(), 1, script.size(), pipe) == script.size();
    return ::pclose(pipe) == 0 && written;
}

} // namespace hfh::bench

#endif // HFH_BENCH_GNUPLOT_HPP
