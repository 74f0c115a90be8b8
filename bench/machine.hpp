#ifndef HFH_BENCH_MACHINE_HPP
#define HFH_BENCH_MACHINE_HPP

#include <fstream>
#include <string>

// Where and by what the times were taken.

namespace hfh::bench {

/// The processor's own name, where the system tells it.
[[nodiscard]] inline std::string cpu_name() {
    std::ifstream info{"/proc/cpuinfo"};
    for (std::string line; std::getline(info, line);) {
        if (const auto colon = line.find(": "); line.starts_with("model name") && colon != line.npos) {
            return line.substr(colon + 2);
        }
    }
    return "unknown";
}

#if defined(__clang__)
inline constexpr const char* compiler_name = "Clang " __clang_version__;
#elif defined(__GNUC__)
inline constexpr const char* compiler_name = "GCC " __VERSION__;
#else
inline constexpr const char* compiler_name = "unknown";
#endif

} // namespace hfh::bench

#endif // HFH_BENCH_MACHINE_HPP
