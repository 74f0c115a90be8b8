#include "bad_input.hpp"
#include "gdal_dataset.hpp"
#include "map_units.hpp"
#include "no_data.hpp"
#include "numbers.hpp"
#include "packed_heights.hpp"
#include "terrain.hpp"
#include "units.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include <unistd.h>

namespace demo {
namespace {

/// GDAL's last complaint, for the end of a sentence.
std::string complaint() {
    const std::string text = CPLGetLastErrorMsg();
    return text.empty() ? "." : ": GDAL says " + shown(text) + ".";
}

/// The names by which GDAL opens the rasters that a file holds beside its first, or instead of it.
std::vector<std::string> subdatasets_of(GDALDatasetH dataset) {
    std::vector<std::string> names;
    char** const list = GDALGetMetadata(dataset, "SUBDATASETS");
    for (int n = 1;; ++n) {
        const std::string key = "SUBDATASET_" + std::to_string(n) + "_NAME";
        const char* const name = CSLFetchNameValue(list, key.c_str());
        if (name == nullptr) return names;
        names.emplace_back(name);
    }
}

std::string listed(const std::vector<std::string>& names) {
    constexpr std::size_t most = 20;
    std::string out;
    for (std::size_t k = 0; k < std::min(most, names.size()); ++k) {
        out += k == 0 ? "" : ", ";
        for (const char c : names[k]) out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
    }
    return out + (names.size() > most ? " and " + std::to_string(names.size() - most) + " more" : "");
}

/// The raster that `name` means. A file of one raster under a longer name is that raster; one of several is refused.
Dataset open_one(const std::string& name, std::vector<std::string>& assumed) {
    Dataset dataset = open_with_gdal(name);
    if (!dataset) throw BadInput{name + " is not a terrain file that can be read" + complaint()};
    const std::vector<std::string> inside = subdatasets_of(dataset.get());
    if (GDALGetRasterCount(dataset.get()) > 0) {
        if (inside.size() > 1)
            assumed.push_back("the first of " + std::to_string(inside.size()) +
                              " rasters in the file is the terrain (" + listed(inside) + ")");
        return dataset;
    }
    if (inside.empty()) throw BadInput{name + " holds no raster."};
    if (inside.size() > 1) {
        throw BadInput{
            name + " holds " + std::to_string(inside.size()) +
            " rasters, of which a terrain is one; take one of these names for it: " + listed(inside) + "."};
    }
    Dataset only = open_with_gdal(inside.front());
    if (!only || GDALGetRasterCount(only.get()) == 0)
        throw BadInput{inside.front() + " is not a terrain that can be read" + complaint()};
    return only;
}

std::string lower(std::string text) {
    for (char& c : text) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    return text;
}

std::string colour_of(GDALRasterBandH band) {
    const std::string name = lower(GDALGetColorInterpretationName(GDALGetRasterColorInterpretation(band)));
    return name == "gray" ? "grey" : name;
}

/// The band that `channel` names, by its number or its colour; null if there is none.
GDALRasterBandH band_named(GDALDatasetH dataset, const std::string& channel) {
    const int count = GDALGetRasterCount(dataset);
    if (const auto number = parse_number<int>(channel))
        return *number >= 1 && *number <= count ? GDALGetRasterBand(dataset, *number) : nullptr;
    for (int n = 1; n <= count; ++n) {
        const GDALRasterBandH band = GDALGetRasterBand(dataset, n);
        if (colour_of(band) == channel) return band;
    }
    return nullptr;
}

/// "1 (red), 2 (depth)": what there is to choose from.
std::string bands_of(GDALDatasetH dataset) {
    std::vector<std::string> names;
    for (int n = 1; n <= GDALGetRasterCount(dataset); ++n) {
        const GDALRasterBandH band = GDALGetRasterBand(dataset, n);
        std::string what = GDALGetDescription(band);
        if (what.empty()) what = colour_of(band);
        names.push_back(std::to_string(n) + (what == "undefined" ? "" : " (" + what + ")"));
    }
    return listed(names);
}

/// The one band with heights.
GDALRasterBandH band_of_heights(const std::string& name, GDALDatasetH dataset, const ReadOptions& options,
                                std::vector<std::string>& assumed) {
    const int count = GDALGetRasterCount(dataset);
    if (!options.channel.empty()) {
        const GDALRasterBandH band = band_named(dataset, options.channel);
        if (band == nullptr) {
            throw BadInput{"--channel is " + shown(options.channel) + ", but " + name + " has the bands " +
                           bands_of(dataset) + "."};
        }
        return band;
    }
    std::vector<GDALRasterBandH> candidates;
    for (int n = 1; n <= count; ++n) {
        const GDALRasterBandH band = GDALGetRasterBand(dataset, n);
        if (GDALGetRasterColorInterpretation(band) != GCI_AlphaBand) candidates.push_back(band);
    }
    if (candidates.size() != 1) {
        throw BadInput{name + " has " + std::to_string(count) +
                       " bands, but a terrain has one height at each place; --channel takes one of " +
                       bands_of(dataset) +
                       (candidates.size() == 3 ? ", and --encoding unpacks three." : ".")};
    }
    if (count > 1) assumed.emplace_back("heights are in the band that is not alpha (see --channel)");
    if (GDALGetRasterColorInterpretation(candidates.front()) == GCI_PaletteIndex)
        assumed.emplace_back("the numbers of the colour table are heights");
    return candidates.front();
}

/// An array for the samples of a raster. Throws BadInput where they would be more than the machine's memory.
template <class S>
std::shared_ptr<std::vector<S>> room_for(const std::string& name, int columns, int rows) {
    const double bytes = sizeof(S) * static_cast<double>(columns) * static_cast<double>(rows);
    const double memory =
        static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGE_SIZE));
    if (memory > 0 && bytes > memory) {
        throw BadInput{name + " has " + std::to_string(columns) + " x " + std::to_string(rows) +
                       " samples, which are more than this machine's memory of " + rounded(1e-9 * memory) +
                       " GB holds; as .bil it could be touched where it lies."};
    }
    return std::make_shared<std::vector<S>>(static_cast<std::size_t>(columns) *
                                            static_cast<std::size_t>(rows));
}

/// True if a line of the text file `name` begins with `key`, in small letters.
bool has_key(const std::string& name, std::string_view key) {
    bool has_one = false;
    char** const lines = CSLLoad2(name.c_str(), 10'000, 1000, nullptr);
    for (int k = 0; k < CSLCount(lines); ++k) {
        const std::string line = lower(lines[k]);
        const auto text = trimmed(line);
        has_one = has_one || text.substr(0, text.find_first_of(" \t")) == key;
    }
    CSLDestroy(lines);
    return has_one;
}

/// True if the bytes of a band have a sign. No type of GDAL's own says so before its version 3.7; and the bytes of an ESRI
/// raster without PIXELTYPE have none in GDAL, whatever NODATA is, but see read_raster_header.
bool has_signed_bytes(GDALRasterBandH band, std::vector<std::string>& assumed) {
    if (GDALGetRasterDataType(band) != GDT_Byte) return false;
    const char* const pixel_type = GDALGetMetadataItem(band, "PIXELTYPE", "IMAGE_STRUCTURE");
    if (pixel_type != nullptr) return std::string_view{pixel_type} == "SIGNEDBYTE";

    const GDALDatasetH dataset = GDALGetBandDataset(band);
    const GDALDriverH driver = dataset == nullptr ? nullptr : GDALGetDatasetDriver(dataset);
    int has_one = 0;
    const double no_data = GDALGetRasterNoDataValue(band, &has_one);
    if (driver == nullptr || std::string_view{GDALGetDriverShortName(driver)} != "EHdr" || has_one == 0 ||
        !(no_data < 0))
        return false;
    for (const std::string& file : files_of(dataset)) {
        if (lower(CPLGetExtension(file.c_str())) != "hdr") continue;
        if (has_key(file, "pixeltype")) return false;
        assumed.push_back(sign_assumed(CPLGetFilename(file.c_str()), rounded(no_data, 12)));
        return true;
    }
    return false;
}

/// True if a sample of `type` can be `value`.
bool can_be(double value, GDALDataType type, bool signed_bytes) {
    switch (type) {
    case GDT_Byte:
        return signed_bytes ? as_sample<std::int8_t>(value).has_value()
                            : as_sample<std::uint8_t>(value).has_value();
#if GDAL_VERSION_NUM >= GDAL_COMPUTE_VERSION(3, 7, 0)
    case GDT_Int8: return as_sample<std::int8_t>(value).has_value();
#endif
    case GDT_UInt16: return as_sample<std::uint16_t>(value).has_value();
    case GDT_Int16: return as_sample<std::int16_t>(value).has_value();
    case GDT_UInt32: return as_sample<std::uint32_t>(value).has_value();
    case GDT_Int32: return as_sample<std::int32_t>(value).has_value();
    case GDT_Float32: return as_sample<float>(value).has_value();
    default: return true;
    }
}

/// What GDAL knows about the holes of a band: its mask, in which a "no data" value counts as GDAL has it (a float that was
/// written in too few digits is still that float), and that value itself where a mask of its own hides it.
class Holes {
public:
    /// A "no data" value that no sample can be goes to `assumed`.
    Holes(GDALRasterBandH band, bool signed_bytes, const std::string& name, std::vector<std::string>& assumed)
        : band_{band}, row_(static_cast<std::size_t>(GDALGetRasterBandXSize(band))) {
        const GDALDataType type = GDALGetRasterDataType(band);
        int has_one = 0;
        const double value = GDALGetRasterNoDataValue(band, &has_one);
        if (has_one != 0 && can_be(value, type, signed_bytes))
            no_data_ = value;
        else if (has_one != 0)
            assumed.push_back(unused_no_data(
                name, rounded(value, 12),
                "sample of type " + std::string{signed_bytes ? "Int8" : GDALGetDataTypeName(type)}));
        const int flags = GDALGetMaskFlags(band);
        // The alpha band itself has no mask: it may be where the heights are. Of integers the value alone tells more: the
        // mask is made from the value without its fraction, and without the sign of bytes.
        const bool by_value =
            flags == GMF_NODATA && type != GDT_Float32 && GDALGetDataTypeSizeBits(type) <= 32;
        masked_ = (flags & GMF_ALL_VALID) == 0 && !by_value &&
                  GDALGetRasterColorInterpretation(band) != GCI_AlphaBand;
    }
    [[nodiscard]] bool any() const noexcept { return masked_ || no_data_; }

    /// Marks the holes among the samples of row j. False if the mask cannot be read.
    template <class S>
    [[nodiscard]] bool mark(int j, S* samples) {
        const int columns = static_cast<int>(row_.size());
        if (masked_ && GDALRasterIO(GDALGetMaskBand(band_), GF_Read, 0, j, columns, 1, row_.data(), columns,
                                    1, GDT_Byte, 0, 0) != CE_None)
            return false;
        const auto no_data = no_data_ ? as_sample<S>(*no_data_) : std::nullopt;
        for (std::size_t i = 0; i < row_.size(); ++i) {
            if (samples[i] == no_data || (masked_ && row_[i] == 0))
                samples[i] = std::numeric_limits<S>::quiet_NaN();
        }
        return true;
    }

private:
    GDALRasterBandH band_;
    std::vector<std::uint8_t> row_;
    std::optional<double> no_data_;
    bool masked_ = false;
};

/// How a raster lies on its map: which of its corners comes first, and what it measures.
struct Placement {
    bool west_first = true;
    bool north_first = true;
    std::optional<MapExtent> extent; ///< nothing where the file does not say
};

template <class S>
AnyHeights right_way_up(const S* samples, int columns, int rows, const Placement& placement) {
    const hfh::Index width = columns, height = rows;
    const hfh::Index i = placement.west_first ? 0 : width - 1, j = placement.north_first ? height - 1 : 0;
    return Heights<S>{samples + i + j * width,
                      width,
                      height,
                      placement.west_first ? 1 : -1,
                      placement.north_first ? -width : width,
                      NoData<S>{}};
}

/// The band as samples of type S; where there may be holes S has NaN.
template <class S>
AnyHeights read_as(const std::string& name, GDALRasterBandH band, GDALDataType type, bool signed_bytes,
                   Holes& holes, const Placement& placement, std::shared_ptr<const void>& storage) {
    const int columns = GDALGetRasterBandXSize(band), rows = GDALGetRasterBandYSize(band);
    auto samples = room_for<S>(name, columns, rows);
    CPLErrorReset();
    bool whole = GDALRasterIO(band, GF_Read, 0, 0, columns, rows, samples->data(), columns, rows, type, 0,
                              0) == CE_None;
    if (signed_bytes) {
        for (S& sample : *samples) sample = sample > 127 ? static_cast<S>(sample - 256) : sample;
    }
    if constexpr (std::is_floating_point_v<S>) {
        for (int j = 0; whole && holes.any() && j < rows; ++j) {
            const std::size_t first = static_cast<std::size_t>(j) * static_cast<std::size_t>(columns);
            whole = holes.mark(j, samples->data() + first);
        }
    }
    if (!whole) throw BadInput{name + " cannot be read to its end" + complaint()};
    const AnyHeights heights = right_way_up(samples->data(), columns, rows, placement);
    storage = std::move(samples);
    return heights;
}

AnyHeights read_band(const std::string& name, GDALRasterBandH band, const Placement& placement,
                     std::shared_ptr<const void>& storage, std::vector<std::string>& assumed) {
    const bool signed_bytes = has_signed_bytes(band, assumed);
    Holes holes{band, signed_bytes, name, assumed};
    const auto read = [&]<class S>(GDALDataType type, S /*tag*/) {
        return read_as<S>(name, band, type, signed_bytes, holes, placement, storage);
    };
    switch (GDALGetRasterDataType(band)) {
    case GDT_Byte:
    case GDT_UInt16:
    case GDT_Int16:
        if (holes.any()) return read(GDT_Float32, float{});
        if (GDALGetRasterDataType(band) == GDT_UInt16) return read(GDT_UInt16, std::uint16_t{});
        return read(GDT_Int16, std::int16_t{});
    case GDT_Int32:
        if (holes.any()) return read(GDT_Float64, double{});
        return read(GDT_Int32, std::int32_t{});
    case GDT_Float32: return read(GDT_Float32, float{});
    case GDT_CInt16:
    case GDT_CInt32:
    case GDT_CFloat32:
    case GDT_CFloat64: throw BadInput{name + " holds complex numbers, which are no heights."};
    default: return read(GDT_Float64, double{});
    }
}

/// Three bands of bytes as one packed sample.
AnyHeights read_packed(const std::string& name, GDALDatasetH dataset, const Placement& placement,
                       std::shared_ptr<const void>& storage) {
    const int columns = GDALGetRasterXSize(dataset), rows = GDALGetRasterYSize(dataset);
    std::array<GDALRasterBandH, 3> bands{};
    for (int n = 0; n < 3; ++n) {
        constexpr std::array<const char*, 3> names{"red", "green", "blue"};
        GDALRasterBandH& band = bands[static_cast<std::size_t>(n)];
        band = band_named(dataset, names[static_cast<std::size_t>(n)]);
        if (band == nullptr && n < GDALGetRasterCount(dataset)) band = GDALGetRasterBand(dataset, n + 1);
        if (band == nullptr || GDALGetRasterDataType(band) != GDT_Byte) {
            throw BadInput{name + " has the bands " + bands_of(dataset) +
                           ", but --encoding wants red, green and blue of 8 bits, and all of them."};
        }
    }
    auto samples = room_for<std::int32_t>(name, columns, rows);
    const auto width = static_cast<std::size_t>(columns);
    std::vector<std::uint8_t> rgb(3 * width), mask(width);
    const auto read_row = [&](GDALRasterBandH band, int j, std::uint8_t* into, int step) {
        if (GDALRasterIO(band, GF_Read, 0, j, columns, 1, into, columns, 1, GDT_Byte, step, 0) != CE_None)
            throw BadInput{name + " cannot be read to its end" + complaint()};
    };
    for (int j = 0; j < rows; ++j) {
        for (std::size_t n = 0; n < 3; ++n) read_row(bands[n], j, rgb.data() + n, 3);
        read_row(GDALGetMaskBand(bands[0]), j, mask.data(), 1);
        std::int32_t* const row = samples->data() + static_cast<std::size_t>(j) * width;
        for (std::size_t i = 0; i < width; ++i)
            row[i] = mask[i] == 0 ? no_packed_sample : packed_sample(rgb.data(), 3, i);
    }
    const hfh::Index stride = placement.north_first ? -columns : columns;
    const std::size_t west = placement.west_first ? 0 : width - 1;
    const std::size_t south = placement.north_first ? static_cast<std::size_t>(rows - 1) * width : 0;
    const Heights<std::int32_t> heights{samples->data() + south + west, columns, rows,
                                        placement.west_first ? 1 : -1,  stride,  {no_packed_sample}};
    storage = std::move(samples);
    return heights;
}

Placement placement_of(const std::string& name, GDALDatasetH dataset) {
    std::array<double, 6> at{}; // x = at[0] + at[1]·column + at[2]·row, y = at[3] + at[4]·column + at[5]·row
    if (GDALGetGeoTransform(dataset, at.data()) != CE_None) return {};
    const double columns = GDALGetRasterXSize(dataset), rows = GDALGetRasterYSize(dataset);
    const double turned = std::max(std::abs(at[2]) * rows / std::abs(at[1]),
                                   std::abs(at[4]) * columns / std::abs(at[5])); // cells
    constexpr double rounding = 0.01; // cells across the whole raster
    if (!(turned <= rounding)) {
        throw BadInput{name +
                       " is turned on its map, but its columns must run east and its rows north-south."};
    }
    const double first = at[3] + 0.5 * at[5], last = at[3] + (rows - 0.5) * at[5];
    return {at[1] > 0, at[5] < 0,
            MapExtent{{std::abs(at[1]), std::abs(at[5])}, std::min(first, last), std::max(first, last)}};
}

std::optional<MapUnits> units_of(OGRSpatialReferenceH map) {
    if (map == nullptr) return std::nullopt;
    MapUnits units;
    OGRErr known = OGRERR_NONE;
    const double semi_major = OSRGetSemiMajor(map, &known);
    if (known == OGRERR_NONE) {
        units.semi_major = semi_major;
        const double inverse = OSRGetInvFlattening(map, nullptr);
        units.flattening = inverse > 1 ? 1 / inverse : 0;
    }
    units.angular = OSRIsGeographic(map) != 0;
    units.arbitrary = OSRIsLocal(map) != 0;
    units.size = units.angular ? OSRGetAngularUnits(map, nullptr) : OSRGetLinearUnits(map, nullptr);
    if (OSRIsVertical(map) != 0) units.height = OSRGetTargetLinearUnits(map, "VERT_CS", nullptr);

    char* text = nullptr;
    const std::array<const char*, 2> form{"FORMAT=WKT2_2019", nullptr};
    if (OSRExportToWktEx(map, &text, form.data()) == OGRERR_NONE) {
        if (const auto read = read_map_units(text)) {
            units.cylindrical = read->cylindrical;
            units.depths = read->depths;
        }
    }
    CPLFree(text);
    return units;
}

/// Sets the spacing as the map has it, or else in metres or the user's unit.
void place(Terrain& terrain, const std::string& name, const Placement& placement,
           const std::optional<MapUnits>& units, const ReadOptions& options) {
    if (options.spacing || !placement.extent) return;
    if (units) {
        if (units->arbitrary && !units->angular)
            terrain.assumed.push_back(
                "the spacing is in units of " + rounded(units->size, 7) +
                " m, as the file has them, though it lies on no map of the earth (see --spacing)");
        terrain.spacing = spacing_on_map(*units, *placement.extent, name, terrain.assumed);
        return;
    }
    if (!options.unit)
        terrain.assumed.emplace_back(
            "the spacing is in metres, for the file names no map (see --spacing and --unit)");
    terrain.spacing = checked_spacing(options.unit.value_or(1.0) * placement.extent->cell, name);
}

/// Scale, offset and unit of the heights in `band`.
void set_heights(Terrain& terrain, const std::string& name, GDALRasterBandH band,
                 const std::optional<MapUnits>& units, const ReadOptions& options) {
    int has_scale = 0, has_offset = 0;
    const double scale = GDALGetRasterScale(band, &has_scale),
                 offset = GDALGetRasterOffset(band, &has_offset);
    const std::string named = GDALGetRasterUnitType(band);
    std::optional<double> unit = metres_in(named);
    if (!unit && !named.empty() && !options.unit)
        terrain.assumed.push_back("heights are in a unit called " + shown(named) +
                                  ", which is no known length");
    if (!unit && named.empty() && units) unit = units->height;
    set_height_unit(terrain, name, options, unit, has_scale != 0 ? scale : 1, has_offset != 0 ? offset : 0);
    if (units && units->depths) turn_depths(terrain);
}

} // namespace

Terrain read_with_gdal(const std::filesystem::path& file, const ReadOptions& options) {
    const std::string name = file.string();
    std::vector<std::string> assumed;
    const Dataset dataset = open_one(name, assumed);
    require_a_patch(file, GDALGetRasterXSize(dataset.get()), GDALGetRasterYSize(dataset.get()));
    const bool packed = options.encoding != Encoding::none;
    const GDALRasterBandH band = packed ? nullptr : band_of_heights(name, dataset.get(), options, assumed);
    const Placement placement = placement_of(name, dataset.get());
    const std::optional<MapUnits> units = units_of(GDALGetSpatialRef(dataset.get()));

    std::shared_ptr<const void> storage;
    AnyHeights heights = packed ? read_packed(name, dataset.get(), placement, storage)
                                : read_band(name, band, placement, storage, assumed);
    std::error_code error;
    Terrain terrain{.name = std::filesystem::exists(file, error) ? file.filename().string() : name,
                    .storage = std::move(storage),
                    .heights = std::move(heights),
                    .spacing = std::nullopt,
                    .assumed = std::move(assumed)};
    if (packed) {
        const auto [scale, offset] = scale_of(options.encoding);
        set_height_unit(terrain, file, options, 1.0, scale, offset);
    } else {
        set_heights(terrain, name, band, units, options);
    }
    place(terrain, name, placement, units, options);
    return terrain;
}

bool opens_with_gdal(const std::filesystem::path& file) { return open_with_gdal(file.string()) != nullptr; }

bool set_heights_with_gdal(Terrain& terrain, const std::filesystem::path& file, const ReadOptions& options,
                           int band) {
    const Dataset dataset = open_with_gdal(file.string());
    if (!dataset || GDALGetRasterCount(dataset.get()) < band) return false;
    set_heights(terrain, file.string(), GDALGetRasterBand(dataset.get(), band),
                units_of(GDALGetSpatialRef(dataset.get())), options);
    return true;
}

void place_with_gdal(Terrain& terrain, const std::filesystem::path& file, const ReadOptions& options) {
    if (options.spacing) return;
    const Dataset dataset = open_with_gdal(file.string());
    if (!dataset) return;
    const Placement placement = placement_of(file.string(), dataset.get());
    if (!placement.north_first) {
        terrain.heights =
            std::visit([](const auto& view) -> AnyHeights { return view.flipped_rows(); }, terrain.heights);
    }
    place(terrain, file.string(), placement, units_of(GDALGetSpatialRef(dataset.get())), options);
}

} // namespace demo
