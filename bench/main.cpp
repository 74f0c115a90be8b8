#include "run.hpp"

#include "machine.hpp"

#include <cstdio>

namespace {

bool failed = false;

} // namespace

namespace hfh::bench {

void fail(benchmark::State& state, const std::string& why) {
    failed = true;
    state.SkipWithError(why.c_str());
}

} // namespace hfh::bench

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::AddCustomContext("cpu", hfh::bench::cpu_name());
    benchmark::AddCustomContext("last_cache", hfh::bench::last_cache());
    benchmark::AddCustomContext("compiler", hfh::bench::compiler_name);
    benchmark::AddCustomContext("flags", HFH_BENCH_FLAGS);
    hfh::bench::register_benchmarks();
    const std::size_t ran = benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    if (failed) std::fputs("a benchmark's answers were wrong, or an update took 1 ms\n", stderr);
    return ran == 0 || failed ? 1 : 0;
}
