#ifndef HFH_CLEAR_STRETCH_HPP
#define HFH_CLEAR_STRETCH_HPP

#include <hfh/candidate_walker.hpp>

#include <algorithm>
#include <cmath>

// How far along a segment nothing can be met, told by comparing heights alone: no crossing times, no quadratics. What
// is left over is for `first_hit` to judge.
//
// The cells are looked at in columns across the longer axis of the segment (in cells). Over a column the segment
// passes two cells as a rule, and its height is linear in the number of the grid line: no division in the loop, and no
// column waits for the one before. Every estimate is widened by a bound of its rounding, and of the rounding of the
// exact walk, so that a column is only called clear if each of its cells would be passed by the exact walk as well.

namespace hfh::detail {

/// A segment seen along its longer axis. Line k is grid line `along.base + k` of that axis.
class Profile {
public:
    /// Cells across which the segment may touch between two lines, and a height that it stays above there.
    struct Part {
        Index first, last;
        double lowest;
    };

    /// `along` and `across` are the axes of the segment, from az to bz. Precondition: it goes a cell along or more, and
    /// not less than across.
    Profile(const AxisWalk& along, const AxisWalk& across, double az, double bz) noexcept
        : base_{across.base} {
        // t = (k − start)/length; cell and height are linear in t.
        const double start = along.a * along.per_metre, per_line = 1 / (along.d * along.per_metre);
        cell_step_ = across.d * across.per_metre * per_line;
        z_step_ = (bz - az) * per_line;
        cell_ = across.a * across.per_metre - start * cell_step_;
        z_ = az - start * z_step_;
        // Some ulps of the largest numbers that go in; lines k are at most two cells beyond the ends. The rests in
        // `along` and `across` have the rounding of the number of the cell.
        const double length = std::abs(along.d * along.per_metre);
        cell_blur_ = 32 * epsilon<double> *
                     (std::abs(static_cast<double>(along.base)) + std::abs(static_cast<double>(across.base)) +
                      length + 4);
        z_blur_ = 32 * epsilon<double> * (std::abs(az) + std::abs(bz)) + cell_blur_ * std::abs(z_step_);
        z_end_ = std::min(az, bz) - z_blur_;
    }

    /// Whether the numbers of the cells are known well enough to be of use.
    [[nodiscard]] bool usable() const noexcept { return cell_blur_ < 0.125; }

    /// Between lines k and m.
    [[nodiscard]] Part between(Index k, Index m) const noexcept {
        const double at_k = static_cast<double>(k), at_m = static_cast<double>(m);
        const double cell_k = cell_ + at_k * cell_step_, cell_m = cell_ + at_m * cell_step_;
        const double z = std::min(z_ + at_k * z_step_, z_ + at_m * z_step_) - z_blur_;
        return {cell(std::min(cell_k, cell_m) - cell_blur_), cell(std::max(cell_k, cell_m) + cell_blur_),
                std::max(z, z_end_)};
    }

    /// How many cells there are between the lines, where the segment passes no vertex.
    [[nodiscard]] Index cells(Index k, Index m) const noexcept {
        return std::abs(m - k) + std::abs(between(m, m).first - between(k, k).first);
    }

private:
    [[nodiscard]] Index cell(double number) const noexcept {
        return base_ + static_cast<Index>(std::floor(number));
    }

    Index base_;
    double cell_, cell_step_,
        cell_blur_; ///< across, in cells from line `base_`: on line 0, per line, how well known
    double z_, z_step_, z_blur_, z_end_; ///< the same of the height, and the lower end
};

/// Whether there is a patch over the cell, and all of it is below z.
template <HeightField Field>
[[nodiscard]] bool lies_below(const Field& field, const Cell& cell, double z) noexcept {
    using T = typename Field::Scalar;
    const auto patch = field.patch(cell);
    if (!patch) return false;
    // `highest`, but of values that stay in registers: a column takes half the time.
    const T p00 = patch->p00, p10 = patch->p10, p01 = patch->p01, p11 = patch->p11;
    const T at_v0 = p00 < p10 ? p10 : p00, at_v1 = p01 < p11 ? p11 : p01;
    return static_cast<double>(at_v0 < at_v1 ? at_v1 : at_v0) < z;
}

/// Of `count` columns from column `from` on, in steps of `step` = ±1, how many the segment passes over: every cell of
/// them that it may touch has a patch that lies below it. Columns are counted from line 0 of the profile.
template <bool along_x, HeightField Field>
[[nodiscard]] Index clear_columns(const Field& field, const Profile& profile, Index base, Index from,
                                  Index step, Index count) noexcept {
    for (Index n = 0; n < count; ++n) {
        const Index column = from + n * step;
        const Profile::Part part = profile.between(column, column + 1);
        const auto passes_over = [&](Index across) {
            return lies_below(field, along_x ? Cell{base + column, across} : Cell{across, base + column},
                              part.lowest);
        };
        if (!passes_over(part.first) || !passes_over(part.last)) return n;
        for (Index across = part.first + 1; across < part.last; ++across) { // through a vertex, or nearly
            if (!passes_over(across)) return n;
        }
    }
    return count;
}

} // namespace hfh::detail

#endif // HFH_CLEAR_STRETCH_HPP
