#ifndef TOUCH_TERRAIN_TERRAIN_FILES_HPP
#define TOUCH_TERRAIN_TERRAIN_FILES_HPP

#include <filesystem>
#include <string>
#include <vector>

// The files behind a terrain, which no output may take the place of.

namespace demo {

/// True if both are one file, whatever their names; or will be, where neither is there yet.
[[nodiscard]] bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// Throws BadInput, in the name of `option`, if `output` is there and belongs to the terrain that read_terrain has read from
/// `terrain`: it is one of its files, lies beside it under its name, or in its directory; or with GDAL is a source of it, or
/// holds it.
void refuse_to_replace_terrain(const std::filesystem::path& terrain, const char* option,
                               const std::filesystem::path& output);

/// What GDAL reads for the raster that it knows by `name`, as far as it is in the file system: files beside the raster, all
/// sources of a virtual one and theirs, the archive or database that holds it.
[[nodiscard]] std::vector<std::filesystem::path> files_with_gdal(const std::string& name);

} // namespace demo

#endif // TOUCH_TERRAIN_TERRAIN_FILES_HPP
