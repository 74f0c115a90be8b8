#include "replays.hpp"

#include <hfh/contact/friction.hpp>
#include <hfh/traversal/first_hit.hpp>

// Apart from the plain updates, so that what they cost cannot hang on how a compiler inlines these.

using hfh::cost::Grid;
using hfh::cost::Trace;

namespace {

/// Every cast of the trace. `contacts` counts the hits, `work` adds up the shares of the way.
template <class Grid, hfh::Real T>
[[nodiscard]] hfh::cost::Felt replay_casts(const Grid& grid, const Trace<T>& trace) noexcept {
    hfh::cost::Felt felt;
    for (std::size_t k = 0; k + 1 < trace.stylus.size(); k += 2) {
        const auto hit = hfh::first_hit(grid, trace.stylus[k], trace.stylus[k + 1]);
        hfh::cost::want(hit);
        felt.contacts += hit.status == hfh::HitStatus::hit;
        felt.work += static_cast<double>(hit.t);
    }
    return felt;
}

} // namespace

[[gnu::noinline]] void hfh_cost_replay_friction(const Grid<double>& grid, const Trace<double>& trace,
                                                hfh::cost::Felt& felt) noexcept {
    hfh::Friction<double> friction{{.at_rest = 0.5, .sliding = 0.4}};
    felt = hfh::cost::replay(grid, trace, [&](auto& tracker, const auto& stylus) {
        return friction.hold(grid, tracker.update(stylus), stylus);
    });
}
[[gnu::noinline]] void hfh_cost_replay_casts(const Grid<double>& grid, const Trace<double>& trace,
                                             hfh::cost::Felt& felt) noexcept {
    felt = replay_casts(grid, trace);
}
