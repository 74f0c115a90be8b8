#include "bad_input.hpp"
#include "memory_map.hpp"
#include "numbers.hpp"
#include "raster_header.hpp"
#include "terrain.hpp"

#include <cmath>
#include <limits>
#include <type_traits>

namespace demo {
namespace {

/// The "no data" value as a sample: none if no sample can equal it.
template <class S>
std::optional<S> no_data_as(const std::string& text) {
    if constexpr (std::is_floating_point_v<S>) {
        return parse_number<S>(text);
    } else {
        const auto value = parse_number<double>(text);
        if (!value || std::trunc(*value) != *value || *value < std::numeric_limits<S>::lowest() ||
            *value > std::numeric_limits<S>::max()) {
            return std::nullopt;
        }
        return static_cast<S>(*value);
    }
}

template <class S>
AnyHeights view(const RasterHeader& header, const MemoryMap& map) {
    const auto* const samples = reinterpret_cast<const S*>(map.bytes().data() + header.skip);
    const auto row_stride = static_cast<hfh::Index>(header.row_bytes / sizeof(S));
    const Heights<S> north_first{
        samples,    static_cast<hfh::Index>(header.columns), static_cast<hfh::Index>(header.rows), 1,
        row_stride, NoData<S>{no_data_as<S>(header.no_data)}};
    return north_first.flipped_rows();
}

AnyHeights view(const RasterHeader& header, const MemoryMap& map) {
    switch (header.kind) {
    case SampleKind::unsigned_integer:
        return header.bits == 8 ? view<std::uint8_t>(header, map) : view<std::uint16_t>(header, map);
    case SampleKind::signed_integer:
        return header.bits == 16 ? view<std::int16_t>(header, map) : view<std::int32_t>(header, map);
    case SampleKind::floating: break;
    }
    return header.bits == 32 ? view<float>(header, map) : view<double>(header, map);
}

} // namespace

Terrain read_raster(const std::filesystem::path& file) {
    const RasterHeader header = read_raster_header(file);
    require_a_patch(header.file, static_cast<hfh::Index>(header.columns),
                    static_cast<hfh::Index>(header.rows));

    auto map = std::make_shared<const MemoryMap>(file);
    const std::uint64_t needed = header.skip + header.rows * header.row_bytes; // < 2^31 + 2^62: no overflow
    if (const std::uint64_t there = map->bytes().size(); there != needed) {
        throw BadInput{file.string() + (there < needed ? " is cut short: it" : "") + " has " +
                       std::to_string(there) + " bytes, but " + header.file.filename().string() +
                       " describes " + std::to_string(needed) + "."};
    }
    AnyHeights heights = view(header, *map);
    return {file.filename().string(), std::move(map), std::move(heights), header.spacing};
}

} // namespace demo
