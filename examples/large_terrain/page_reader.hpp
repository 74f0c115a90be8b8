#ifndef LARGE_TERRAIN_PAGE_READER_HPP
#define LARGE_TERRAIN_PAGE_READER_HPP

#include "page_ranges.hpp"

#include <cstdint>

namespace large_terrain {

/// Has the kernel read and map the pages of memory-mapped samples, and waits for the disk. For one thread.
class PageReader {
public:
    PageReader();

    /// The pages of the samples of `box`, rows from `first` on upwards before those below, or the other way round. Pages
    /// are never locked or given back: the kernel does that.
    void bring_in(const SampleLayout& layout, const hfh::VertexRange& box, hfh::Index first, bool upwards);

    /// Ranges of pages handed to the kernel so far.
    [[nodiscard]] std::uint64_t ranges() const noexcept { return ranges_; }

private:
    std::uintptr_t page_;
    bool can_populate_ = true; ///< until the kernel says no
    std::uint64_t ranges_ = 0;
};

/// Puts the calling thread below everything else of this program.
void run_at_low_priority() noexcept;

/// Pages that the calling thread waited for so far while the disk read them.
[[nodiscard]] long page_reads_of_this_thread() noexcept;

} // namespace large_terrain

#endif // LARGE_TERRAIN_PAGE_READER_HPP
