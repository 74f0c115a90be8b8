#ifndef VIEWER_EDITS_HPP
#define VIEWER_EDITS_HPP

#include "felt_ground.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace viewer {

/// Reads and writes of samples that other threads read meanwhile: they see the old sample or the new one.
template <class S>
[[nodiscard]] S load_sample(const S& sample) noexcept {
    return std::atomic_ref<S>{const_cast<S&>(sample)}.load(std::memory_order_relaxed);
}
template <class S>
void store_sample(S& sample, S value) noexcept {
    std::atomic_ref<S>{sample}.store(value, std::memory_order_relaxed);
}

/// Digs and heaps in the samples of a terrain, and remembers what was there before. Has all its memory from the start; when
/// it is full, the oldest stroke can no longer be undone.
template <hfh::Sample S>
class Edits {
public:
    Edits(const demo::Heights<S>& heights, const hfh::GridFrame& frame)
        : heights_{heights}, frame_{frame}, log_(remembered), strokes_(max_strokes) {}

    void begin_stroke() noexcept {
        if (stroke_count_ == max_strokes) {
            std::move(strokes_.begin() + 1, strokes_.end(), strokes_.begin());
            --stroke_count_;
        }
        strokes_[stroke_count_++] = written_;
    }

    /// As `FeltGround::paint`.
    bool paint(const Spot& spot, hfh::Index& row, SampleRange& changed) noexcept {
        const glm::dvec2 at = (spot.middle - frame_.origin) / frame_.spacing;
        const glm::dvec2 reach = spot.radius / frame_.spacing;
        const auto clamped = [](double x, hfh::Index end) {
            return static_cast<hfh::Index>(std::clamp(x, 0.0, static_cast<double>(end)));
        };
        const SampleRange box{{clamped(std::ceil(at.x - reach.x), heights_.columns()),
                               clamped(std::ceil(at.y - reach.y), heights_.rows())},
                              {clamped(std::floor(at.x + reach.x) + 1, heights_.columns()),
                               clamped(std::floor(at.y + reach.y) + 1, heights_.rows())}};
        row = std::max(row, box.begin.j);
        int left = most_at_once;
        for (; row < box.end.j && left > 0; ++row) {
            for (hfh::Index i = box.begin.i; i < box.end.i; ++i, --left) {
                const glm::dvec2 off =
                    (glm::dvec2{static_cast<double>(i), static_cast<double>(row)} - at) / reach;
                const double far = off.x * off.x + off.y * off.y;
                if (far < 1) change({i, row}, spot.amount * (1 - far) * (1 - far), changed);
            }
        }
        return row >= box.end.j;
    }

    /// As `FeltGround::undo`.
    bool undo(SampleRange& changed) noexcept {
        if (stroke_count_ == 0) return true;
        const std::uint64_t begin = oldest_in(strokes_[stroke_count_ - 1]);
        for (int left = most_at_once; left > 0 && written_ > begin; --left) {
            const Entry& entry = log_[--written_ % remembered];
            store_sample(sample_at(entry.cell), entry.before);
            include(changed, entry.cell);
        }
        if (written_ > begin) return false;
        --stroke_count_;
        return true;
    }

    [[nodiscard]] unsigned undoable_strokes() const noexcept {
        unsigned count = 0;
        for (std::size_t k = 0; k < stroke_count_; ++k) count += oldest_in(strokes_[k]) == strokes_[k];
        return count;
    }
    [[nodiscard]] double smallest_change() const noexcept {
        return std::is_integral_v<S> ? std::abs(frame_.height_scale) : 0.0;
    }
    [[nodiscard]] double largest_radius() const noexcept {
        return max_reach * std::min(frame_.spacing.x, frame_.spacing.y);
    }

private:
    static constexpr std::size_t remembered = std::size_t{1} << 20; ///< samples
    static constexpr std::size_t max_strokes = 256;
    static constexpr int most_at_once = 4096; ///< samples in one update
    static constexpr double max_reach = 256;  ///< samples

    struct Entry {
        hfh::Cell cell;
        S before;
    };

    [[nodiscard]] S& sample_at(hfh::Cell c) const noexcept {
        return demo::editable(heights_)[c.i * heights_.column_stride() + c.j * heights_.row_stride()];
    }
    [[nodiscard]] std::uint64_t oldest_in(std::uint64_t begin) const noexcept {
        return std::max(begin, lost_);
    }
    static void include(SampleRange& range, hfh::Cell c) noexcept {
        range = united(range, {c, {c.i + 1, c.j + 1}});
    }

    /// Holes stay holes, and no sample becomes one.
    void change(hfh::Cell c, double metres, SampleRange& changed) noexcept {
        S& sample = sample_at(c);
        if (heights_.missing(sample)) return;
        double value = static_cast<double>(sample) + metres / frame_.height_scale;
        if constexpr (std::is_integral_v<S>) {
            constexpr double least = static_cast<double>(std::numeric_limits<S>::lowest()),
                             most = static_cast<double>(std::numeric_limits<S>::max());
            value = std::clamp(std::round(value), least, most);
        }
        const S changed_to = static_cast<S>(value);
        if (changed_to == sample || heights_.missing(changed_to)) return;
        log_[written_++ % remembered] = {c, sample};
        if (written_ > remembered) lost_ = std::max(lost_, written_ - remembered);
        store_sample(sample, changed_to);
        include(changed, c);
    }

    demo::Heights<S> heights_;
    hfh::GridFrame frame_;
    std::vector<Entry> log_;
    std::uint64_t written_ = 0;          ///< entries
    std::uint64_t lost_ = 0;             ///< entries before this one were written over
    std::vector<std::uint64_t> strokes_; ///< where each begins, in entries
    std::size_t stroke_count_ = 0;
};

} // namespace viewer

#endif // VIEWER_EDITS_HPP
