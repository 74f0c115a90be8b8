#include "../run.hpp"
#include "strokes.hpp"

// What is stored and allocated.

namespace hfh::bench {

Findings beside_heights(const Settings&) {
    std::size_t made = 0, updating = 0;
    for (const Stroke& stroke :
         {Stroke{"sliding", Way::sliding, 2, 0.5}, Stroke{"tapping", Way::tapping, 5, 0.5},
          Stroke{"swiping", Way::sliding, 100, 3}, Stroke{"flying", Way::flying, 5, 0}}) {
        const auto trace = stroke_trace<double>(terrain(1), stroke, 20'000, 1'000);
        const std::size_t before = bytes_allocated();
        const auto grid = terrain(1).grid<double>();
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

    using State = TrackerState<double>;
    Findings found;
    found.rows.push_back({"bytes stored beside the heights, without bounds",
                          "bytes",
                          {{"", Figure::Goal::at_most, 0, static_cast<double>(made)}},
                          "allocated by making a grid and a tracker for 1.56 M samples",
                          false});
    found.rows.push_back({"allocations per update",
                          "",
                          {{"", Figure::Goal::at_most, 0, static_cast<double>(updating)}},
                          "in 80,000 updates of all kinds",
                          false});
    found.rows.push_back({"state per stylus",
                          "bytes",
                          {{"", Figure::Goal::at_most, 192, static_cast<double>(sizeof(State))}},
                          "float " + text(static_cast<double>(sizeof(TrackerState<float>))),
                          false});
    return found;
}

} // namespace hfh::bench
