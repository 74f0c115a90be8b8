#ifndef HFH_TERRAIN_HEIGHT_LEVELS_HPP
#define HFH_TERRAIN_HEIGHT_LEVELS_HPP

#include <hfh/terrain/height_view.hpp>

#include <bit>
#include <utility>

// The levels of detail of a terrain, as sources of heights. `BlendedField` makes a height field of them.

namespace hfh {

/// The levels of detail of a terrain, finest first: level k has the samples
///
///     sample (i, j) of level k  =  a height at the place of sample (i·2ᵏ, j·2ᵏ) of level 0
///
/// so it has ⌊(columns − 1)/2ᵏ⌋ + 1 columns, and as many rows. `count()` ≥ 1 levels, numbered from 0.
// clang-format off
template <class L>
concept LevelSource = HeightSource<typename L::Heights> && std::copyable<typename L::Heights> && std::copyable<L>
    && requires(const L& levels, int k) {
        { levels.count() } noexcept -> std::same_as<int>;
        { levels.heights(k) } noexcept -> std::same_as<typename L::Heights>;
    };
// clang-format on

/// Columns, or rows, of level k of a terrain that has so many on level 0.
[[nodiscard]] constexpr Index samples_on_level(Index samples, int k) noexcept {
    return samples < 1 ? 0 : ((samples - 1) >> k) + 1;
}

/// How many levels have a cell; at least 1.
[[nodiscard]] constexpr int count_levels(Index columns, Index rows) noexcept {
    const Index cells = (columns < rows ? columns : rows) - 1;
    return cells < 1 ? 1 : static_cast<int>(std::bit_width(static_cast<std::size_t>(cells)));
}

/// Every 2ᵏ-th sample of any source of heights.
template <HeightSource Source>
class SubsampledHeights {
public:
    using SampleType = typename Source::SampleType;

    constexpr SubsampledHeights(const Source& source, int k) noexcept : source_{source}, level_{k} {}

    [[nodiscard]] constexpr Index columns() const noexcept {
        return samples_on_level(source_.columns(), level_);
    }
    [[nodiscard]] constexpr Index rows() const noexcept { return samples_on_level(source_.rows(), level_); }
    [[nodiscard]] constexpr SampleType operator()(Index i, Index j) const noexcept {
        return source_(i << level_, j << level_);
    }
    [[nodiscard]] constexpr bool missing(SampleType sample) const noexcept { return source_.missing(sample); }

private:
    Source source_;
    int level_;
};

/// Every 2ᵏ-th sample of `source`.
template <HeightSource Source>
[[nodiscard]] constexpr SubsampledHeights<Source> subsampled(const Source& source, int k) noexcept {
    return {source, k};
}
/// Of a view that is a view with larger strides.
template <Sample S, class Missing>
[[nodiscard]] constexpr HeightView<S, Missing> subsampled(const HeightView<S, Missing>& view,
                                                          int k) noexcept {
    const Index step = Index{1} << k;
    return {view.data(),
            samples_on_level(view.columns(), k),
            samples_on_level(view.rows(), k),
            view.column_stride() * step,
            view.row_stride() * step,
            view.rule()};
}

/// All levels from the samples of level 0: level k reads every 2ᵏ-th of them. Nothing is stored and nothing prepared, and
/// an edited sample is edited on every level that has it.
template <HeightSource Source>
class StridedLevels {
public:
    using Heights = decltype(subsampled(std::declval<const Source&>(), 0));

    constexpr explicit StridedLevels(const Source& source) noexcept
        : source_{source}, count_{count_levels(source.columns(), source.rows())} {}

    [[nodiscard]] constexpr int count() const noexcept { return count_; }
    [[nodiscard]] constexpr Heights heights(int k) const noexcept { return subsampled(source_, k); }

private:
    Source source_;
    int count_;
};

/// Levels that the user has: `overviews[k]` holds the samples of level k. They have one type, and lie outside of this view,
/// which must not outlive the array.
///
/// The samples have to be *vertex-centred*: those of level k belong to the places of every 2ᵏ-th sample of level 0. They may
/// be means of what lies around these places, or every 2ᵏ-th sample itself. The overviews that GDAL makes by averaging are
/// not: it averages 2 × 2 samples, so the mean belongs to a place half a cell of the finer level off, and the ground would
/// move sideways while the level changes. Their sizes are the same, so that cannot be told here; resample them.
template <HeightSource Source>
class OverviewLevels {
public:
    using Heights = Source;

    /// Precondition: count ≥ 1. Levels are used as far as their sizes fit: `count()` tells how many.
    constexpr OverviewLevels(const Source* overviews, int count) noexcept : overviews_{overviews} {
        const Source& finest = overviews[0];
        const int most = count_levels(finest.columns(), finest.rows());
        while (count_ < count && count_ < most &&
               overviews[count_].columns() == samples_on_level(finest.columns(), count_) &&
               overviews[count_].rows() == samples_on_level(finest.rows(), count_)) {
            ++count_;
        }
    }

    [[nodiscard]] constexpr int count() const noexcept { return count_; }
    [[nodiscard]] constexpr Heights heights(int k) const noexcept { return overviews_[k]; }

private:
    const Source* overviews_;
    int count_ = 1;
};

} // namespace hfh

#endif // HFH_TERRAIN_HEIGHT_LEVELS_HPP
