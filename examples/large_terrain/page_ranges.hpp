#ifndef LARGE_TERRAIN_PAGE_RANGES_HPP
#define LARGE_TERRAIN_PAGE_RANGES_HPP

#include <hfh/geometry/lattice.hpp>
#include <hfh/terrain/height_view.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>

// Which pages of memory hold the samples around a place. Rows lie far apart in a large raster, 64 KiB in one of
// 32768 columns: what is near on the ground is one short range of pages a row.

namespace large_terrain {

/// Where samples lie: (i, j) at address first + i·column_bytes + j·row_bytes. Those of one row lie together: they are
/// less than a page apart.
struct SampleLayout {
    std::uintptr_t first = 0;
    hfh::Index columns = 0, rows = 0;
    std::ptrdiff_t column_bytes = 0, row_bytes = 0; ///< either sign
    std::size_t sample_bytes = 0;
};

template <class Sample, class Missing>
[[nodiscard]] SampleLayout layout_of(const hfh::HeightView<Sample, Missing>& heights) noexcept {
    constexpr auto bytes = static_cast<std::ptrdiff_t>(sizeof(Sample));
    return {reinterpret_cast<std::uintptr_t>(heights.data()),
            heights.columns(),
            heights.rows(),
            heights.column_stride() * bytes,
            heights.row_stride() * bytes,
            sizeof(Sample)};
}

/// What a stylus may touch that is at cell `here` and will be at `there`: the box around both, `margin` cells wider on
/// every side, as far as there are samples.
[[nodiscard]] inline hfh::VertexRange neighbourhood(const SampleLayout& layout, hfh::Cell here,
                                                    hfh::Cell there, hfh::Index margin) noexcept {
    return {{std::max<hfh::Index>(0, std::min(here.i, there.i) - margin),
             std::max<hfh::Index>(0, std::min(here.j, there.j) - margin)},
            {std::min(layout.columns, std::max(here.i, there.i) + 2 + margin),
             std::min(layout.rows, std::max(here.j, there.j) + 2 + margin)}};
}

/// Whole pages.
struct PageRange {
    std::uintptr_t begin = 0, end = 0;
};

/// The pages of the samples of `box` in row j. `page` is the size of one, a power of two.
[[nodiscard]] inline PageRange pages_of_row(const SampleLayout& layout, const hfh::VertexRange& box,
                                            hfh::Index j, std::uintptr_t page) noexcept {
    const auto at = [&](hfh::Index i) {
        return layout.first + static_cast<std::uintptr_t>(i * layout.column_bytes + j * layout.row_bytes);
    };
    const std::uintptr_t west = at(box.begin.i), east = at(box.end.i - 1);
    const std::uintptr_t from = std::min(west, east), to = std::max(west, east);
    return {from & ~(page - 1), (to + layout.sample_bytes + page - 1) & ~(page - 1)};
}

/// Hands the pages of `box` to `visit`, row by row: from row `first` on upwards and then from there downwards, or the
/// other way round. Leaves out a row whose pages are those of the row before.
template <class Visitor>
void for_each_page_range(const SampleLayout& layout, const hfh::VertexRange& box, hfh::Index first,
                         bool upwards, std::uintptr_t page, Visitor&& visit) {
    if (box.empty()) return;
    first = std::clamp(first, box.begin.j, box.end.j - 1);
    const PageRange nearest = pages_of_row(layout, box, first, page);
    visit(nearest);
    for (const hfh::Index step : {upwards ? 1 : -1, upwards ? -1 : 1}) {
        PageRange last = nearest;
        for (hfh::Index j = first + step; box.begin.j <= j && j < box.end.j; j += step) {
            const PageRange range = pages_of_row(layout, box, j, page);
            if (last.begin <= range.begin && range.end <= last.end) continue;
            visit(range);
            last = range;
        }
    }
}

} // namespace large_terrain

#endif // LARGE_TERRAIN_PAGE_RANGES_HPP
