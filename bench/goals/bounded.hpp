#ifndef HFH_BENCH_GOALS_BOUNDED_HPP
#define HFH_BENCH_GOALS_BOUNDED_HPP

#include <hfh/terrain/bilinear_grid.hpp>
#include <hfh/terrain/min_max_pyramid.hpp>

#include <cstddef>
#include <vector>

namespace hfh::bench {

/// A grid with bounds and the storage for them.
template <Real T, HeightSource Heights>
class Bounded {
public:
    explicit Bounded(const BilinearGrid<T, Heights>& grid)
        : storage_(static_cast<std::size_t>(
              MinMaxPyramid<S>::size(grid.heights().columns(), grid.heights().rows()))),
          field_{grid, storage_.data(), static_cast<Index>(storage_.size())} {}
    Bounded(const Bounded&) = delete;
    Bounded& operator=(const Bounded&) = delete;

    /// False if it could not be done.
    [[nodiscard]] bool build() noexcept { return field_.build() == PyramidStatus::ok; }
    [[nodiscard]] const BoundedGrid<T, Heights>& field() const noexcept { return field_; }
    [[nodiscard]] std::size_t bytes() const noexcept { return storage_.size() * sizeof(SampleRange<S>); }

private:
    using S = typename Heights::SampleType;
    std::vector<SampleRange<S>> storage_;
    BoundedGrid<T, Heights> field_;
};

static_assert(BoundedHeightField<BoundedGrid<double, HeightView<short>>>);

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_BOUNDED_HPP
