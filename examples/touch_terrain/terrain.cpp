#include "terrain.hpp"

#include "bad_input.hpp"
#include "numbers.hpp"

#include <cctype>
#include <cmath>

namespace demo {
namespace {

/// A name that GDAL understands and the file system does not: NETCDF:"a.nc":depth, /vsizip/a.zip/b.tif.
[[maybe_unused]] bool is_gdal_name(const std::string& name) {
    return name.starts_with("/vsi") || name.find(':') != std::string::npos;
}

Terrain read_as_it_comes(const std::filesystem::path& file, const ReadOptions& options) {
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (!std::filesystem::exists(status)) {
#ifdef TOUCH_TERRAIN_HAS_GDAL
        if (is_gdal_name(file.string())) return read_with_gdal(file, options);
#endif
        throw BadInput{file.string() + " does not exist or cannot be reached."};
    }
#ifdef TOUCH_TERRAIN_HAS_GDAL
    // Some formats are directories.
    if (std::filesystem::is_directory(status) && opens_with_gdal(file)) return read_with_gdal(file, options);
#endif
    if (std::filesystem::is_directory(status))
        throw BadInput{file.string() + " is a directory, not a terrain file."};
    if (!std::filesystem::is_regular_file(status))
        throw BadInput{file.string() + " is a pipe or a device, but a terrain must be a regular file."};

    std::string kind = file.extension().string();
    for (char& c : kind) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (kind == ".png") return read_png(file, options);
    if (kind == ".bil" || kind == ".flt") return read_raster(file, options);
#ifdef TOUCH_TERRAIN_HAS_GDAL
    return read_with_gdal(file, options);
#else
    throw BadInput{file.string() + " ends in " + shown(kind) +
                   ", but only .png, .bil and .flt are read (this build is without GDAL)."};
#endif
}

} // namespace

Terrain read_terrain(const std::filesystem::path& file, const ReadOptions& options) {
    Terrain terrain = read_as_it_comes(file, options);
    if (options.spacing) terrain.spacing = options.spacing;
    return terrain;
}

void require_a_patch(const std::filesystem::path& file, hfh::Index columns, hfh::Index rows) {
    if (columns >= 2 && rows >= 2) return;
    throw BadInput{file.string() + " has " + std::to_string(columns) + " x " + std::to_string(rows) +
                   " samples, but a surface needs at least 2 x 2."};
}

void set_height_unit(Terrain& terrain, const std::filesystem::path& file, const ReadOptions& options,
                     std::optional<double> unit, double scale, double offset) {
    if (!unit && !options.unit) terrain.assumed.emplace_back("heights are in metres (see --unit)");
    const double metres = options.unit.value_or(unit.value_or(1.0));
    terrain.height_scale = metres * scale;
    terrain.height_offset = metres * offset;
    const double size = std::abs(terrain.height_scale);
    if (size >= 1e-30 && size <= 1e30 && std::abs(terrain.height_offset) <= 1e30) return;
    throw BadInput{
        file.string() + " has heights of " + rounded(terrain.height_offset) + " + " +
        rounded(terrain.height_scale) +
        " times the sample metres, but the factor must be from 1e-30 to 1e30 in size and the offset at "
        "most 1e30."};
}

void turn_depths(Terrain& terrain) {
    terrain.height_scale = -terrain.height_scale;
    terrain.height_offset = -terrain.height_offset;
    terrain.assumed.emplace_back("samples are depths, for the vertical system of the map counts downwards");
}

} // namespace demo
