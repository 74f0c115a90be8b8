#ifndef HFH_BENCH_MACHINE_HPP
#define HFH_BENCH_MACHINE_HPP

#include <benchmark/benchmark.h>

#include <fstream>
#include <string>

// Where and by what the times were taken.

namespace hfh::bench {

/// The processor's own name, where the system tells it. A virtual machine hides much of it.
[[nodiscard]] inline std::string cpu_name() {
    std::ifstream info{"/proc/cpuinfo"};
    for (std::string line; std::getline(info, line);) {
        if (const auto colon = line.find(": "); line.starts_with("model name") && colon != line.npos) {
            return line.substr(colon + 2);
        }
    }
    return "unknown";
}

/// The size of the last cache, "" where it is not known: it tells processors apart that have the same name.
[[nodiscard]] inline std::string last_cache() {
    int level = 0, size = 0;
    for (const auto& cache : benchmark::CPUInfo::Get().caches) {
        if (cache.level >= level) level = cache.level, size = cache.size;
    }
    return size > 0 ? std::to_string(size / 1024) + " KiB" : "";
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
