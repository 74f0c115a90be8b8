#ifndef TOUCH_TERRAIN_DISTRIBUTION_HPP
#define TOUCH_TERRAIN_DISTRIBUTION_HPP

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace demo {

/// Counts of whole numbers in buckets that are exact up to 127 and 1.6 % wide above, so that ten million updates
/// take no more room than ten. Based on: Tene, HdrHistogram, 2012.
class Distribution {
public:
    void add(std::uint64_t value) noexcept {
        ++counts_[bucket(value)];
        ++total_;
        worst_ = std::max(worst_, value);
    }

    [[nodiscard]] std::uint64_t total() const noexcept { return total_; }
    [[nodiscard]] std::uint64_t worst() const noexcept { return worst_; }

    /// The smallest value that `share` of all do not exceed (the upper end of its bucket).
    [[nodiscard]] std::uint64_t quantile(double share) const noexcept {
        const auto wanted = static_cast<std::uint64_t>(share * static_cast<double>(total_));
        std::uint64_t seen = 0;
        for (std::size_t b = 0; b < counts_.size(); ++b) {
            seen += counts_[b];
            if (seen > wanted) return std::min(highest_in(b), worst_);
        }
        return worst_;
    }

private:
    static constexpr int precision = 6; // 64 buckets to each doubling

    static std::size_t bucket(std::uint64_t value) noexcept {
        const int shift = std::max(0, static_cast<int>(std::bit_width(value)) - precision - 1);
        return (static_cast<std::size_t>(shift) << precision) + static_cast<std::size_t>(value >> shift);
    }
    static std::uint64_t highest_in(std::size_t b) noexcept {
        const std::size_t shift = b < 2u << precision ? 0 : (b >> precision) - 1;
        const std::uint64_t lead = b - (shift << precision);
        return ((lead + 1) << shift) - 1;
    }

    std::array<std::uint64_t, (65 - precision) << precision> counts_{};
    std::uint64_t total_ = 0;
    std::uint64_t worst_ = 0;
};

} // namespace demo

#endif // TOUCH_TERRAIN_DISTRIBUTION_HPP
