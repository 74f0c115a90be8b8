#ifndef HFH_BENCH_COST_REPLAYS_HPP
#define HFH_BENCH_COST_REPLAYS_HPP

#include "traces.hpp"

namespace hfh::cost {

template <Real T>
using Grid = BilinearGrid<T, HeightView<std::int16_t>>;

/// Makes the trace of a ball and replays it, counted as the others are.
[[nodiscard]] Felt roll_ball(const Ground& ground, const TraceKind& kind);

} // namespace hfh::cost

// Counting is switched on where these begin and off where they end, by the pattern hfh_cost_replay_*: set-up is out of it.
extern "C" {
void hfh_cost_replay_double(const hfh::cost::Grid<double>& grid, const hfh::cost::Trace<double>& trace,
                            hfh::cost::Felt& felt) noexcept;
void hfh_cost_replay_float(const hfh::cost::Grid<float>& grid, const hfh::cost::Trace<float>& trace,
                           hfh::cost::Felt& felt) noexcept;
void hfh_cost_replay_friction(const hfh::cost::Grid<double>& grid, const hfh::cost::Trace<double>& trace,
                              hfh::cost::Felt& felt) noexcept;
void hfh_cost_replay_casts(const hfh::cost::Grid<double>& grid, const hfh::cost::Trace<double>& trace,
                           hfh::cost::Felt& felt) noexcept;
}

#endif // HFH_BENCH_COST_REPLAYS_HPP
