#include "run.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <new>

namespace {

std::size_t allocated = 0;
bool failed = false;

/// The processor's own name, where the system tells it.
std::string cpu_name() {
    std::ifstream info{"/proc/cpuinfo"};
    for (std::string line; std::getline(info, line);) {
        if (const auto colon = line.find(": "); line.starts_with("model name") && colon != line.npos) {
            return line.substr(colon + 2);
        }
    }
    return "unknown";
}

#if defined(__clang__)
constexpr const char* compiler = "Clang " __clang_version__;
#elif defined(__GNUC__)
constexpr const char* compiler = "GCC " __VERSION__;
#else
constexpr const char* compiler = "unknown";
#endif

} // namespace

// Counts what is allocated. Array and nothrow forms come here too.
void* operator new(std::size_t bytes) {
    allocated += bytes;
    if (void* const memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
    throw std::bad_alloc{};
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace hfh::bench {

void fail(benchmark::State& state, const std::string& why) {
    failed = true;
    state.SkipWithError(why.c_str());
}

std::size_t bytes_allocated() noexcept { return allocated; }

} // namespace hfh::bench

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::AddCustomContext("cpu", cpu_name());
    benchmark::AddCustomContext("compiler", compiler);
    benchmark::AddCustomContext("flags", HFH_BENCH_FLAGS);
    hfh::bench::register_benchmarks();
    const std::size_t ran = benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    if (failed) std::fputs("a benchmark's answers were wrong, or an update took 1 ms\n", stderr);
    return ran == 0 || failed ? 1 : 0;
}
