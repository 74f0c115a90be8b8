#ifndef HFH_TERRAIN_BILINEAR_GRID_HPP
#define HFH_TERRAIN_BILINEAR_GRID_HPP

#include <hfh/terrain/height_field.hpp>
#include <hfh/terrain/height_view.hpp>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.1: four neighbouring samples make a patch.

namespace hfh {

/// How samples become metres: sample (i, j) with value s lies at
///
///     (origin.x + i·spacing.x,  origin.y + j·spacing.y,  height_offset + height_scale·s)
///
/// in a right-handed frame with z up.
struct GridFrame {
    glm::dvec2 origin{0.0}; ///< metres
    /// Metres, > 0: from 2⁻³¹ to 2³¹ in float, from 2⁻²⁵⁵ to 2²⁵⁵ in double.
    glm::dvec2 spacing{1.0};
    double height_scale = 1.0;  ///< metres per unit of a sample
    double height_offset = 0.0; ///< metres
};

/// Why a grid has no patches, or `ok`.
enum class GridStatus : unsigned char {
    ok,
    too_few_samples, ///< fewer than 2 columns or 2 rows
    bad_spacing,     ///< spacing not a number from 1/`longest` to `longest`; or origin not finite
    bad_height_scale ///< height scale or offset not finite, or too large for the range of an integer sample
};

[[nodiscard]] constexpr const char* to_string(GridStatus status) noexcept {
    switch (status) {
    case GridStatus::ok: return "ok";
    case GridStatus::too_few_samples: return "too_few_samples";
    case GridStatus::bad_spacing: return "bad_spacing";
    case GridStatus::bad_height_scale: return "bad_height_scale";
    }
    return "unknown";
}

/// The library's own height field: samples, usually a `HeightView`, and a frame.
///
/// Prepares nothing and stores nothing per sample; reading a patch is four loads from the user's memory. Does not throw: a
/// grid made from a bad frame has that as its `status()` and no cells, so it is never felt.
///
/// A sample is a hole where its source says so, and where its height is NaN, infinite, or `longest` metres or more in size
/// (2³¹ in float, 2²⁵⁵ in double). So a "no data" value of that size need not be declared.
///
/// Its lattice computes places in F: double, or with T float also float, for a processor without a double (`BasicLattice`).
template <Real T, HeightSource Heights = HeightView<T>, Real F = double>
class BilinearGrid {
public:
    using Scalar = T;
    using SampleType = typename Heights::SampleType;

    constexpr BilinearGrid(Heights heights, const GridFrame& frame) noexcept
        : heights_{heights}, lattice_{vec2<F>{frame.origin}, vec2<F>{frame.spacing}}, spacing_{frame.spacing},
          height_scale_{static_cast<T>(frame.height_scale)}, height_offset_{
                                                                 static_cast<T>(frame.height_offset)} {
        if (heights.columns() < 2 || heights.rows() < 2) {
            status_ = GridStatus::too_few_samples;
        } else if (!lattice_.valid() || !spacing_in_range<T>(frame.spacing)) {
            status_ = GridStatus::bad_spacing;
        } else if (!is_finite(height_scale_) || !is_finite(height_offset_) || !all_integers(is_finite<T>)) {
            status_ = GridStatus::bad_height_scale;
        } else {
            cells_.end = {heights.columns() - 1, heights.rows() - 1};
            integers_exceed_limit_ = !all_integers(is_height<T>);
        }
    }

    [[nodiscard]] constexpr GridStatus status() const noexcept { return status_; }
    [[nodiscard]] constexpr const Heights& heights() const noexcept { return heights_; }
    [[nodiscard]] constexpr const BasicLattice<F>& lattice() const noexcept { return lattice_; }

    [[nodiscard]] constexpr CellRange cells() const noexcept { return cells_; }

    /// The patch over cell c; empty outside the grid and where a corner is a hole.
    [[nodiscard, HFH_ALWAYS_INLINED]] constexpr std::optional<BilinearPatch<T>> patch(Cell c) const noexcept {
        // One object for every return, so that it is made in place: a copy of an optional goes through memory.
        std::optional<BilinearPatch<T>> found;
        if (!cells_.contains(c)) return found;
        const auto s00 = heights_(c.i, c.j), s10 = heights_(c.i + 1, c.j);
        const auto s01 = heights_(c.i, c.j + 1), s11 = heights_(c.i + 1, c.j + 1);
        if (heights_.missing(s00) || heights_.missing(s10) || heights_.missing(s01) ||
            heights_.missing(s11)) {
            return found;
        }
        const T p00 = metres(s00), p10 = metres(s10), p01 = metres(s01), p11 = metres(s11);
        if (may_exceed_limit() &&
            (!is_height(p00) || !is_height(p10) || !is_height(p01) || !is_height(p11))) {
            return found;
        }
        found.emplace(BilinearPatch<T>{p00, p10, p01, p11, spacing_});
        return found;
    }

    /// Whether there are heights at all six corners, and all lie below z. See `CorneredHeightField`. Finds the lowest and
    /// the highest sample first and converts only these to metres, without a branch that depends on a sample.
    [[nodiscard, HFH_ALWAYS_INLINED]] constexpr bool corners_below(const Vertex (&corners)[6],
                                                                   T z) const noexcept {
        SampleType low = heights_(corners[0].i, corners[0].j), high = low;
        bool holes = false;
        for (const Vertex corner : corners) {
            const SampleType sample = heights_(corner.i, corner.j);
            holes |= heights_.missing(sample);
            if constexpr (std::is_floating_point_v<SampleType>) holes |= !is_finite(static_cast<T>(sample));
            low = sample < low ? sample : low;
            high = high < sample ? sample : high;
        }
        const HeightRange<T> range = heights_between(low, high);
        return !holes && in_range(range) && range.highest < z;
    }

    /// The lowest and the highest height of corners with samples from `low` to `high`. If the scale is negative, heights
    /// fall where samples rise.
    [[nodiscard]] constexpr HeightRange<T> heights_between(SampleType low, SampleType high) const noexcept {
        const bool falls = height_scale_ < 0;
        return {metres(falls ? high : low), metres(falls ? low : high)};
    }

    /// Whether no sample with a height in such a range is a hole for being too large.
    [[nodiscard]] constexpr bool in_range(const HeightRange<T>& range) const noexcept {
        return !may_exceed_limit() || (is_height(range.lowest) && is_height(range.highest));
    }

private:
    /// Whether a sample's height may be too large to be one. For integers this is known from their type and the scale, so
    /// that a patch need not be tested.
    [[nodiscard]] constexpr bool may_exceed_limit() const noexcept {
        return std::is_floating_point_v<SampleType> || integers_exceed_limit_;
    }

    /// The height of a corner with this sample.
    [[nodiscard]] constexpr T metres(SampleType sample) const noexcept {
        return height_offset_ + height_scale_ * static_cast<T>(sample);
    }

    /// Whether every value of an integer sample passes `test` as a height.
    [[nodiscard]] constexpr bool all_integers(bool (*test)(T)) const noexcept {
        using Limits = std::numeric_limits<SampleType>;
        return std::is_floating_point_v<SampleType> ||
               (test(metres(Limits::lowest())) && test(metres(Limits::max())));
    }

    Heights heights_;
    CellRange cells_{};
    BasicLattice<F> lattice_;
    vec2<T> spacing_;
    T height_scale_;
    T height_offset_;
    GridStatus status_ = GridStatus::ok;
    bool integers_exceed_limit_ = false;
};

/// Computes in double unless told otherwise.
template <HeightSource Heights>
BilinearGrid(Heights, const GridFrame&) -> BilinearGrid<double, Heights>;

/// A grid that computes in T over heights of any type: `make_grid<float>(heights, {.spacing = {10, 10}})`. Where the samples
/// are of type T themselves, `BilinearGrid<T>{heights, frame}` says the same.
template <Real T, HeightSource Heights>
[[nodiscard]] constexpr BilinearGrid<T, Heights> make_grid(Heights heights, const GridFrame& frame) noexcept {
    return {heights, frame};
}

} // namespace hfh

#endif // HFH_TERRAIN_BILINEAR_GRID_HPP
