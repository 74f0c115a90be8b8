#include "bad_input.hpp"
#include "map_units.hpp"
#include "memory_map.hpp"
#include "no_data.hpp"
#include "numbers.hpp"
#include "raster_header.hpp"
#include "terrain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace demo {
namespace {

/// "int16" and the like.
std::string type_of(const RasterHeader& header) {
    using enum SampleKind;
    const char* const kind = header.kind == floating         ? "float"
                             : header.kind == signed_integer ? "int"
                                                             : "uint";
    return kind + std::to_string(header.bits);
}

/// A view on `samples`, the first of the north row, that lie in the file as `Stored`. Where NODATA is a number that none of
/// them can be, `header` says so.
template <class Stored, class S>
AnyHeights view(const S* samples, hfh::Index row_stride, RasterHeader& header) {
    NoData<S> missing;
    if (const auto value = parse_number<double>(header.no_data)) {
        missing.value = as_sample<Stored>(*value);
        if (!missing.value) {
            header.assumed.push_back(unused_no_data(header.file.filename().string(), header.no_data,
                                                    "sample of type " + type_of(header)));
        }
    }
    const Heights<S> north_first{
        samples, static_cast<hfh::Index>(header.columns), static_cast<hfh::Index>(header.rows), 1, row_stride,
        missing};
    return north_first.flipped_rows();
}

/// The samples of the file as they lie there, the other way round if the file has the other byte order.
template <class Stored, class S>
AnyHeights copied(RasterHeader& header, std::span<const std::byte> bytes,
                  std::shared_ptr<const void>& storage) {
    auto samples = std::make_shared<std::vector<S>>();
    samples->reserve(header.columns * header.rows);
    for (std::uint64_t j = 0; j < header.rows; ++j) {
        const std::byte* at = bytes.data() + header.skip + j * header.row_bytes;
        for (std::uint64_t i = 0; i < header.columns; ++i, at += sizeof(Stored)) {
            std::array<std::byte, sizeof(Stored)> sample{};
            std::memcpy(sample.data(), at, sizeof(Stored));
            if (header.swapped) std::ranges::reverse(sample);
            samples->push_back(static_cast<S>(std::bit_cast<Stored>(sample)));
        }
    }
    const AnyHeights heights = view<Stored>(samples->data(), static_cast<hfh::Index>(header.columns), header);
    storage = std::move(samples);
    return heights;
}

template <class S>
AnyHeights in_place(RasterHeader& header, const std::shared_ptr<const MemoryMap>& map,
                    std::shared_ptr<const void>& storage) {
    if (header.swapped) return copied<S, S>(header, map->bytes(), storage);
    storage = map;
    return view<S>(reinterpret_cast<const S*>(map->bytes().data() + header.skip),
                   static_cast<hfh::Index>(header.row_bytes / sizeof(S)), header);
}

AnyHeights heights_in(RasterHeader& header, const std::shared_ptr<const MemoryMap>& map,
                      std::shared_ptr<const void>& storage) {
    switch (header.kind) {
    case SampleKind::unsigned_integer:
        if (header.bits == 8) return in_place<std::uint8_t>(header, map, storage);
        if (header.bits == 16) return in_place<std::uint16_t>(header, map, storage);
        return copied<std::uint32_t, double>(header, map->bytes(), storage); // no terrain has such samples
    case SampleKind::signed_integer:
        if (header.bits == 8) return copied<std::int8_t, std::int16_t>(header, map->bytes(), storage);
        if (header.bits == 16) return in_place<std::int16_t>(header, map, storage);
        return in_place<std::int32_t>(header, map, storage);
    case SampleKind::floating: break;
    }
    return header.bits == 32 ? in_place<float>(header, map, storage) : in_place<double>(header, map, storage);
}

/// The .prj beside `raster`, if there is one that says anything.
std::optional<std::string> map_text_beside(std::filesystem::path raster) {
    std::error_code error;
    for (const char* extension : {".prj", ".PRJ"}) {
        raster.replace_extension(extension);
        if (!std::filesystem::exists(raster, error)) continue;
        const MemoryMap map{raster};
        const std::string_view bytes{reinterpret_cast<const char*>(map.bytes().data()), map.bytes().size()};
        const std::string_view text = without_byte_order_mark(bytes.substr(0, 65536));
        if (text.find_first_not_of(" \t\r\n") != std::string_view::npos) return std::string{text};
    }
    return std::nullopt;
}

/// The metres between samples and in a unit of height, as the header and the map beside `file` say them.
void place(Terrain& terrain, const std::filesystem::path& file, const RasterHeader& header,
           const ReadOptions& options) {
    const auto text = map_text_beside(file);
    const std::optional<MapUnits> units = text ? read_map_units(*text) : std::nullopt;
    bool heights_known = false;
#ifdef TOUCH_TERRAIN_HAS_GDAL
    // What GDAL has added to a raster that cannot hold it itself.
    std::error_code error;
    if (std::filesystem::exists(file.string() + ".aux.xml", error)) {
        heights_known = set_heights_with_gdal(terrain, file, options, 1);
        if (!text) place_with_gdal(terrain, file, options);
    }
#endif
    if (!heights_known) {
        set_height_unit(terrain, file, options, units ? units->height : std::nullopt);
        if (units && units->depths) turn_depths(terrain);
    }
    if (options.spacing || terrain.spacing || !header.cell) return;
    if (text && !units) {
        throw BadInput{file.string() + " has a .prj that does not tell metres on the ground, " +
                       shown(*text) + "; --spacing gives the metres from sample to sample."};
    }
    if (!units) {
        if (!options.unit)
            terrain.assumed.emplace_back("the spacing in " + header.file.filename().string() +
                                         " is in metres, for there is no .prj (see --spacing and --unit)");
        terrain.spacing = checked_spacing(options.unit.value_or(1.0) * *header.cell, file.string());
        return;
    }
    if (units->needs_latitude() && !header.north) {
        throw BadInput{file.string() + (units->angular ? " is in degrees" : " is on a cylindrical map") +
                       ", but " + header.file.filename().string() +
                       " has no ULYMAP or YLLCORNER to say at which latitude; --spacing gives the metres."};
    }
    const double north = header.north.value_or(0.0);
    const double south = north - static_cast<double>(header.rows - 1) * header.cell->y;
    terrain.spacing = spacing_on_map(*units, {*header.cell, south, north}, file.string(), terrain.assumed);
}

} // namespace

Terrain read_raster(const std::filesystem::path& file, const ReadOptions& options) {
    const bool one_of_several = options.encoding != Encoding::none || !options.channel.empty();
    if (const auto header = header_beside(file); one_of_several || is_envi_header(header)) {
#ifdef TOUCH_TERRAIN_HAS_GDAL
        return read_with_gdal(file, options);
#else
        throw BadInput{
            one_of_several
                ? file.string() + " is read without --channel and --encoding by this build without GDAL."
                : header.string() + " is an ENVI header, which this build without GDAL does not read."};
#endif
    }
    RasterHeader header = read_raster_header(file);
    require_a_patch(header.file, static_cast<hfh::Index>(header.columns),
                    static_cast<hfh::Index>(header.rows));

    const auto map = std::make_shared<const MemoryMap>(file, options.for_editing ? MapAccess::copy_on_write
                                                                                 : MapAccess::read_only);
    const std::uint64_t needed = header.skip + header.rows * header.row_bytes; // < 2^31 + 2^62: no overflow
    if (const std::uint64_t there = map->bytes().size(); there != needed) {
        throw BadInput{file.string() + (there < needed ? " is cut short: it" : "") + " has " +
                       std::to_string(there) + " bytes, but " + header.file.filename().string() +
                       " describes " + std::to_string(needed) + "."};
    }
    std::shared_ptr<const void> storage;
    AnyHeights heights = heights_in(header, map, storage);
    Terrain terrain{.name = file.filename().string(),
                    .storage = std::move(storage),
                    .heights = std::move(heights),
                    .spacing = std::nullopt,
                    .assumed = std::move(header.assumed)};
    place(terrain, file, header, options);
    return terrain;
}

} // namespace demo
