#include "replays.hpp"

#include <cstdio>
#include <cstring>

// One trace of the cost guard, for callgrind to count; cost.py calls it so. Without arguments: what there is to count.

namespace {

#if defined(__clang__)
constexpr const char* compiler = "Clang " __clang_version__;
#elif defined(__GNUC__)
constexpr const char* compiler = "GCC " __VERSION__;
#else
constexpr const char* compiler = "unknown";
#endif

using hfh::cost::Grid;
using hfh::cost::Ground;
using hfh::cost::Trace;
using hfh::cost::TraceKind;

/// Valgrind 3.19 does not know an instruction that Clang 14 moves a double by in a ball's update (vmovq, as D6).
[[nodiscard]] constexpr bool can_be_counted([[maybe_unused]] const TraceKind& kind) noexcept {
#if defined(__clang__)
    return kind.doing != hfh::cost::Doing::rolling;
#else
    return true;
#endif
}

} // namespace

[[gnu::noinline]] void hfh_cost_replay_double(const Grid<double>& grid, const Trace<double>& trace,
                                              hfh::cost::Felt& felt) noexcept {
    felt = hfh::cost::replay(grid, trace,
                             [](auto& tracker, const auto& stylus) { return tracker.update(stylus); });
}
[[gnu::noinline]] void hfh_cost_replay_float(const Grid<float>& grid, const Trace<float>& trace,
                                             hfh::cost::Felt& felt) noexcept {
    felt = hfh::cost::replay(grid, trace,
                             [](auto& tracker, const auto& stylus) { return tracker.update(stylus); });
}

namespace {

/// Whether the trace did what it is named after: a count of wrong answers means nothing.
bool run(const TraceKind& kind) {
    const Ground ground{kind.relief};
    hfh::cost::Felt felt;
    if (kind.in_float) {
        hfh_cost_replay_float(ground.grid<float>(), hfh::cost::make_trace<float>(ground, kind), felt);
    } else if (kind.doing == hfh::cost::Doing::rolling) {
        felt = hfh::cost::roll_ball(ground, kind);
    } else {
        const auto trace = hfh::cost::make_trace<double>(ground, kind);
        const auto grid = ground.grid<double>();
        if (kind.doing == hfh::cost::Doing::casting)
            hfh_cost_replay_casts(grid, trace, felt);
        else if (kind.friction)
            hfh_cost_replay_friction(grid, trace, felt);
        else
            hfh_cost_replay_double(grid, trace, felt);
    }
    const std::size_t wanted = kind.doing == hfh::cost::Doing::flying ? 0 : updates_of(kind);
    if (felt.contacts != wanted || (felt.work > 0) != (wanted > 0)) {
        std::fprintf(stderr, "%s: %zu updates in contact, but must be %zu\n", kind.name.data(), felt.contacts,
                     wanted);
        return false;
    }
    return true;
}

} // namespace

int main(int argc, char** argv) {
    if (argc == 1) {
        std::printf("compiler %s\nflags %s\n", compiler, HFH_COST_FLAGS);
        for (const TraceKind& kind : hfh::cost::all_traces) {
            if (can_be_counted(kind)) std::printf("trace %s %zu\n", kind.name.data(), updates_of(kind));
        }
        return 0;
    }
    for (const TraceKind& kind : hfh::cost::all_traces) {
        if (kind.name == argv[1]) return run(kind) ? 0 : 1;
    }
    std::fprintf(stderr, "there is no trace '%s'\n", argv[1]);
    return 2;
}
