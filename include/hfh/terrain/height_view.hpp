#ifndef HFH_TERRAIN_HEIGHT_VIEW_HPP
#define HFH_TERRAIN_HEIGHT_VIEW_HPP

#include <hfh/geometry/scalar.hpp>

#include <concepts>
#include <type_traits>
#include <utility>

// The height field data of §4.1, "images with depth values", read from the user's memory.
// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.1; the strided views of std::mdspan (P0009).

namespace hfh {

/// Any arithmetic sample: 8 to 64 bit integers, float, double.
template <class S>
concept Sample = std::is_arithmetic_v<S> && !std::same_as<S, bool>;

/// Where a grid's heights come from: `HeightView`, or a user's own storage (tiles, a compressed raster) that has
/// the same five members. Read only at 0 ≤ i < columns(), 0 ≤ j < rows().
// clang-format off
template <class H>
concept HeightSource = Sample<typename H::SampleType>
    && requires(const H& heights, Index i, typename H::SampleType sample) {
        { heights.columns() } noexcept -> std::convertible_to<Index>;
        { heights.rows() } noexcept -> std::convertible_to<Index>;
        { heights(i, i) } noexcept -> std::same_as<typename H::SampleType>;
        { heights.missing(sample) } noexcept -> std::convertible_to<bool>;
    };
// clang-format on

/// Every sample is a height.
struct NeverMissing {
    template <Sample S>
    [[nodiscard]] constexpr bool operator()(S) const noexcept {
        return false;
    }
};

/// Samples equal to `value` are holes: the "no data" value of a raster. The value has the samples' own type, or both are
/// integers, which are compared as numbers; anything else does not compile, because a comparison of converted numbers goes
/// wrong: as an int the float 0.5 equals 0, and no float equals the double −3.4·10³⁸. So for float samples write
/// `MissingValue{-9999.0f}`.
template <Sample S>
struct MissingValue {
    S value;

    template <class Other>
    [[nodiscard]] constexpr bool operator()(Other sample) const noexcept requires std::same_as<Other, S> ||
        (std::integral<Other>&& std::integral<S>) {
        if constexpr (std::same_as<Other, S>) {
            return sample == value;
        } else {
            using Wide = unsigned long long;
            return (sample < 0) == (value < 0) && static_cast<Wide>(sample) == static_cast<Wide>(value);
        }
    }
};
template <class S>
MissingValue(S) -> MissingValue<S>;

/// A predicate that tells holes among samples of type S. A `MissingValue` of a type that does not fit is none.
template <class Missing, class S>
concept TellsHoles = std::predicate<const Missing&, S>;

namespace detail {

/// n as an Index; 0 if an Index cannot hold it.
template <std::integral N>
[[nodiscard]] constexpr Index to_index(N n) noexcept {
    return std::in_range<Index>(n) ? static_cast<Index>(n) : 0;
}

} // namespace detail

/// A strided view on `columns` × `rows` samples of the user's own storage.
///
/// Sample (i, j), 0 ≤ i < columns, 0 ≤ j < rows, is `data[i * column_stride + j * row_stride]`. Strides count
/// samples (not bytes) and are signed; column i runs along +x and row j along +y of the terrain.
///
///     HeightView{heights, w, h}                       one height a sample, south row first
///     HeightView{pixels + 3, w, h, 4, 4 * w}          the alpha channel of RGBA pixels
///     HeightView{heights, w, h}.flipped_rows()        a raster stored north row first, seen right way up
///
/// Numbers and strides may be integers of any type, `std::size_t` too. One that an Index cannot hold counts as 0.
///
/// `Missing` is a predicate, true for a sample that marks a hole. The view owns nothing, copies no samples and keeps no more
/// than the numbers above; the storage must outlive it and may change between updates.
template <Sample S, TellsHoles<S> Missing = NeverMissing>
class HeightView {
public:
    using SampleType = S;

    constexpr HeightView(const S* data, std::integral auto columns, std::integral auto rows,
                         std::integral auto column_stride, std::integral auto row_stride,
                         Missing missing = {}) noexcept
        : data_{data}, columns_{detail::to_index(columns)}, rows_{detail::to_index(rows)},
          column_stride_{detail::to_index(column_stride)},
          row_stride_{detail::to_index(row_stride)}, missing_{missing} {}

    constexpr HeightView(const S* data, std::integral auto columns, std::integral auto rows,
                         Missing missing = {}) noexcept
        : HeightView{data, columns, rows, 1, columns, missing} {}

    [[nodiscard]] constexpr Index columns() const noexcept { return columns_; }
    [[nodiscard]] constexpr Index rows() const noexcept { return rows_; }
    [[nodiscard]] constexpr const S* data() const noexcept { return data_; }
    [[nodiscard]] constexpr Index column_stride() const noexcept { return column_stride_; }
    [[nodiscard]] constexpr Index row_stride() const noexcept { return row_stride_; }
    [[nodiscard]] constexpr const Missing& rule() const noexcept { return missing_; }

    /// Sample (i, j). Precondition: 0 ≤ i < columns, 0 ≤ j < rows.
    [[nodiscard]] constexpr S operator()(Index i, Index j) const noexcept {
        return data_[i * column_stride_ + j * row_stride_];
    }

    /// True if `sample` marks a hole. A floating sample that is not finite always does.
    [[nodiscard]] constexpr bool missing(S sample) const noexcept {
        if constexpr (Real<S>) {
            if (!is_finite(sample)) return true;
        }
        return missing_(sample);
    }

    /// The same samples with the last row first.
    [[nodiscard]] constexpr HeightView flipped_rows() const noexcept {
        return {data_ + (rows_ > 0 ? (rows_ - 1) * row_stride_ : 0),
                columns_,
                rows_,
                column_stride_,
                -row_stride_,
                missing_};
    }

private:
    const S* data_;
    Index columns_;
    Index rows_;
    Index column_stride_;
    Index row_stride_;
    [[no_unique_address]] Missing missing_;
};

template <class S, std::integral N, std::integral M, std::integral A, std::integral B>
HeightView(S*, N, M, A, B) -> HeightView<std::remove_cv_t<S>>;
template <class S, std::integral N, std::integral M>
HeightView(S*, N, M) -> HeightView<std::remove_cv_t<S>>;
template <class S, std::integral N, std::integral M, std::integral A, std::integral B,
          TellsHoles<std::remove_cv_t<S>> Missing>
HeightView(S*, N, M, A, B, Missing) -> HeightView<std::remove_cv_t<S>, Missing>;
template <class S, std::integral N, std::integral M, TellsHoles<std::remove_cv_t<S>> Missing>
HeightView(S*, N, M, Missing) -> HeightView<std::remove_cv_t<S>, Missing>;

} // namespace hfh

#endif // HFH_TERRAIN_HEIGHT_VIEW_HPP
