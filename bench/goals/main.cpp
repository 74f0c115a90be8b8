#include "../machine.hpp"
#include "goal.hpp"
#include "json_line.hpp"
#include "self_check.hpp"

#include <cstdio>
#include <cstring>
#include <iterator>

// Measures what has a goal: hfh_goals [--vast] [--only PART]. Writes JSON lines: the machine, then one line a number, a
// workload or something skipped. bench.py runs it and compares.
//
// --vast measures what needs gigabytes as well: 16385² samples, and a file of 32768² in the build tree.
//
// Ends with 1 if an answer is wrong or an update took 1 ms.

namespace {

using namespace hfh::bench;

struct Part {
    const char* name;
    Findings (*measure)(const Settings&);
};
constexpr Part parts[] = {
    {"sliding", sliding},
    {"closest", closest_peers},
    {"crossing", crossing},
    {"bounds", bounds},
    {"worst", worst_updates},
    {"vast", vast},
    {"scalars", scalars},
    {"beside", beside_heights},
    {"compile", compile_time},
    {"levels", blended_levels},
    {"zoom", zoom},
    {"nearest", nearest},
    {"ball", ball},
};

void print(const Findings& found) {
    for (const auto& m : found.numbers) {
        JsonLine line;
        line.add("goal", m.goal).add("figure", m.figure).add("value", m.value);
        if (!m.times.empty()) line.add("times_ns", m.times);
        if (!m.note.empty()) line.add("note", m.note);
        line.print();
    }
    for (const auto& w : found.workloads) {
        JsonLine{}
            .add("workload", w.name)
            .add("ground", w.ground)
            .add("source", w.source)
            .add("cells", w.cells)
            .add("mean_ns", w.mean_ns)
            .add("worst_ns", w.worst_ns)
            .print();
    }
    for (const auto& s : found.skipped) {
        JsonLine{}.add("skipped", s.what).add("why", s.why).print();
    }
    std::fflush(stdout);
}

int usage() {
    std::fputs("hfh_goals [--vast] [--only PART]; parts:", stderr);
    for (const auto& part : parts) std::fprintf(stderr, " %s", part.name);
    std::fputs("\n", stderr);
    return 2;
}

} // namespace

int main(int argc, char** argv) {
    Settings settings{.scratch = HFH_SCRATCH_DIR,
                      .compiler = HFH_COMPILER,
                      .include = HFH_SOURCE_DIR "/include",
                      .glm_include = HFH_GLM_INCLUDE};
    std::string only;
    for (int k = 1; k < argc; ++k) {
        if (std::strcmp(argv[k], "--vast") == 0) {
            settings.vast = true;
        } else if (std::strcmp(argv[k], "--only") == 0 && k + 1 < argc) {
            only = argv[++k];
        } else {
            return usage();
        }
    }

    JsonLine{}
        .add("cpu", cpu_name())
        .add("last_cache", last_cache())
        .add("compiler", std::string{compiler_name})
        .add("flags", std::string{HFH_BENCH_FLAGS})
        .print();
    bool ran = false, slow = false;
    try {
        check_the_checks();
        for (const auto& part : parts) {
            if (!only.empty() && only != part.name) continue;
            const Findings found = part.measure(settings);
            print(found);
            for (const auto& update : found.too_slow) std::fprintf(stderr, "%s\n", update.c_str());
            slow = slow || !found.too_slow.empty();
            ran = true;
        }
    } catch (const std::exception& fault) {
        std::fprintf(stderr, "%s\n", fault.what());
        return 1;
    }
    if (!ran) return usage();
    return slow ? 1 : 0;
}
