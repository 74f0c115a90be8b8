#include "terrain.hpp"

#include "bad_input.hpp"

#include <cctype>

namespace demo {

Terrain read_terrain(const std::filesystem::path& file) {
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (!std::filesystem::exists(status))
        throw BadInput{file.string() + " does not exist or cannot be reached."};
    if (std::filesystem::is_directory(status))
        throw BadInput{file.string() + " is a directory, not a terrain file."};

    std::string kind = file.extension().string();
    for (char& c : kind) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (kind == ".png") return read_png(file);
    if (kind == ".bil" || kind == ".flt") return read_raster(file);
#ifdef TOUCH_TERRAIN_HAS_GDAL
    return read_with_gdal(file);
#else
    throw BadInput{file.string() + " ends in " + shown(kind) +
                   ", but only .png, .bil and .flt are read (this build is without GDAL)."};
#endif
}

void require_a_patch(const std::filesystem::path& file, hfh::Index columns, hfh::Index rows) {
    if (columns >= 2 && rows >= 2) return;
    throw BadInput{file.string() + " has " + std::to_string(columns) + " x " + std::to_string(rows) +
                   " samples, but a surface needs at least 2 x 2."};
}

} // namespace demo
