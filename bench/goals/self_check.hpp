#ifndef HFH_BENCH_GOALS_SELF_CHECK_HPP
#define HFH_BENCH_GOALS_SELF_CHECK_HPP

namespace hfh::bench {

/// Throws a Fault if one of the checks takes a wrong answer for a right one.
void check_the_checks();

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_SELF_CHECK_HPP
