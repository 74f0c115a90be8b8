#ifndef HFH_BENCH_RUN_HPP
#define HFH_BENCH_RUN_HPP

#include <benchmark/benchmark.h>

#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>

// What every benchmark program shares; main.cpp and allocations.cpp have the definitions.

namespace hfh::bench {

/// Each *.bench.cpp defines this one; main calls it.
void register_benchmarks();

/// Marks the benchmark as wrong. The program then ends with a non-zero exit code.
void fail(benchmark::State& state, const std::string& why);

/// Bytes that operator new has given out so far, and how often it was called.
[[nodiscard]] std::size_t bytes_allocated() noexcept;
[[nodiscard]] std::size_t allocations() noexcept;

template <class Body>
void add(const std::string& name, Body&& body) {
    benchmark::RegisterBenchmark(name.c_str(), std::forward<Body>(body))->MinTime(0.05);
}

template <class T>
inline constexpr const char* scalar_name = std::is_same_v<T, float> ? "float" : "double";

} // namespace hfh::bench

#endif // HFH_BENCH_RUN_HPP
