#include "../run.hpp"
#include "strokes.hpp"

// What is stored and allocated.

namespace hfh::bench {

Findings beside_heights(const Settings&) {
    std::size_t made = 0, updating = 0;
    for (const Stroke& stroke :
         {Stroke{"sliding", Way::sliding, 2, 0.5}, Stroke{"tapping", Way::tapping, 5, 0.5},
          Stroke{"swiping", Way::sliding, 100, 3}, Stroke{"flying", Way::flying, 5, 0}}) {
        const auto trace = stroke_trace<double>(terrain(large_hills), stroke, 20'000, 1'000);
        const std::size_t before = bytes_allocated();
        const auto grid = terrain(large_hills).grid<double>();
        ProxyTracker tracker{grid};
        made = std::max(made, bytes_allocated() - before);
        const std::size_t begin = allocations();
        replay(grid, trace, [](const auto& contact) { benchmark::DoNotOptimize(contact); });
        updating += allocations() - begin;
    }
    // That the counters count.
    const std::size_t before = bytes_allocated(), begin = allocations();
    benchmark::DoNotOptimize(std::make_unique<int>(1));
    if (bytes_allocated() == before || allocations() == begin) throw Fault{"allocations are not counted"};

    Findings found;
    found.numbers = {
        {"bytes_beside_heights", "", static_cast<double>(made)},
        {"allocations", "", static_cast<double>(updating), {}, "in 80,000 updates of all kinds"},
        {"state", "double", static_cast<double>(sizeof(TrackerState<double>))},
        {"state", "float", static_cast<double>(sizeof(TrackerState<float>))},
    };
    return found;
}

} // namespace hfh::bench
