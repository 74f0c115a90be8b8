#include "bad_input.hpp"
#include "terrain.hpp"

#include <cpl_error.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

namespace demo {
namespace {

struct Closer {
    void operator()(GDALDatasetH dataset) const noexcept { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<std::remove_pointer_t<GDALDatasetH>, Closer>;

/// GDAL's last complaint, for the end of a sentence.
std::string complaint() {
    const std::string text = CPLGetLastErrorMsg();
    return text.empty() ? "." : ": GDAL says " + shown(text) + ".";
}

template <class S>
AnyHeights read_band(const std::filesystem::path& file, GDALRasterBandH band, GDALDataType type,
                     std::shared_ptr<const void>& storage) {
    const int columns = GDALGetRasterBandXSize(band), rows = GDALGetRasterBandYSize(band);
    auto samples =
        std::make_shared<std::vector<S>>(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    if (GDALRasterIO(band, GF_Read, 0, 0, columns, rows, samples->data(), columns, rows, type, 0, 0) !=
        CE_None) {
        throw BadInput{file.string() + " cannot be read to its end" + complaint()};
    }
    NoData<S> missing;
    int has_no_data = 0;
    const double no_data = GDALGetRasterNoDataValue(band, &has_no_data);
    const bool fits = no_data >= static_cast<double>(std::numeric_limits<S>::lowest()) &&
                      no_data <= static_cast<double>(std::numeric_limits<S>::max());
    if (has_no_data != 0 && fits) missing.value = static_cast<S>(no_data);

    const Heights<S> heights{samples->data(), columns, rows, missing};
    storage = std::move(samples);
    return heights;
}

AnyHeights read_band(const std::filesystem::path& file, GDALRasterBandH band,
                     std::shared_ptr<const void>& storage) {
    switch (GDALGetRasterDataType(band)) {
    case GDT_Byte: return read_band<std::uint8_t>(file, band, GDT_Byte, storage);
    case GDT_UInt16: return read_band<std::uint16_t>(file, band, GDT_UInt16, storage);
    case GDT_Int16: return read_band<std::int16_t>(file, band, GDT_Int16, storage);
    case GDT_Int32: return read_band<std::int32_t>(file, band, GDT_Int32, storage);
    case GDT_Float32: return read_band<float>(file, band, GDT_Float32, storage);
    case GDT_CInt16:
    case GDT_CInt32:
    case GDT_CFloat32:
    case GDT_CFloat64: throw BadInput{file.string() + " holds complex numbers, which are no heights."};
    default: return read_band<double>(file, band, GDT_Float64, storage);
    }
}

/// How the raster lies on its map.
struct Placement {
    std::optional<glm::dvec2> spacing; ///< metres from sample to sample, if the file says
    bool north_first = true;
};

Placement placement_of(const std::filesystem::path& file, GDALDatasetH dataset) {
    double transform[6] = {};
    if (GDALGetGeoTransform(dataset, transform) != CE_None) return {};
    if (transform[2] != 0 || transform[4] != 0 || transform[1] <= 0) {
        throw BadInput{file.string() +
                       " is turned on its map, but its columns must run east and its rows north-south."};
    }
    Placement placement;
    placement.north_first = transform[5] < 0;
    const OGRSpatialReferenceH map = GDALGetSpatialRef(dataset);
    const bool in_degrees = map != nullptr && OSRIsGeographic(map) != 0;
    if (!in_degrees) placement.spacing = glm::dvec2{transform[1], std::abs(transform[5])};
    return placement;
}

} // namespace

Terrain read_with_gdal(const std::filesystem::path& file) {
    GDALAllRegister();
    CPLSetErrorHandler(CPLQuietErrorHandler);
    const Dataset dataset{GDALOpen(file.c_str(), GA_ReadOnly)};
    if (!dataset) throw BadInput{file.string() + " is not a terrain file that can be read" + complaint()};

    const int bands = GDALGetRasterCount(dataset.get());
    if (bands != 1) {
        throw BadInput{file.string() + " has " + std::to_string(bands) +
                       " bands, but a terrain has one height at each place."};
    }
    require_a_patch(file, GDALGetRasterXSize(dataset.get()), GDALGetRasterYSize(dataset.get()));

    std::shared_ptr<const void> storage;
    AnyHeights heights = read_band(file, GDALGetRasterBand(dataset.get(), 1), storage);

    const Placement placement = placement_of(file, dataset.get());
    if (placement.north_first) {
        heights = std::visit([](const auto& view) -> AnyHeights { return view.flipped_rows(); }, heights);
    }
    return {file.filename().string(), std::move(storage), std::move(heights), placement.spacing};
}

} // namespace demo
