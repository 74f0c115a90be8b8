#ifndef HFH_TESTS_SUPPORT_REAL_TERRAINS_HPP
#define HFH_TESTS_SUPPORT_REAL_TERRAINS_HPP

#include "skip.hpp"
#include "terrains.hpp"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <vector>

// Real terrains from HFH_SHARED_DATA_DIR, where that is present: ESRI .bil with .hdr, little-endian, row 0 north.

namespace hfh::test {

/// Samples as T (int16 and float32 are exact in float), south row first, holes as NaN. Empty if the file is absent.
template <Real T>
[[nodiscard]] std::optional<Terrain<T>> real_terrain(const std::string& name) {
    const std::string path = HFH_SHARED_DATA_DIR "/" + name;
    std::ifstream header{path + ".hdr"};
    std::ifstream file{path + ".bil", std::ios::binary};
    if (!header || !file) return {};
    std::map<std::string, std::string> keys;
    for (std::string key, value; header >> key >> value;) keys[key] = value;
    const std::vector<char> bytes{std::istreambuf_iterator<char>{file}, {}};

    Terrain<T> made;
    made.columns = std::stol(keys["NCOLS"]);
    made.rows = std::stol(keys["NROWS"]);
    made.frame.spacing = {std::stod(keys["XDIM"]), std::stod(keys["YDIM"])};
    made.frame = rounded<T>(made.frame);
    const bool real = keys["PIXELTYPE"] == "FLOAT";
    const std::size_t size = real ? 4 : 2;
    if (bytes.size() != size * static_cast<std::size_t>(made.columns * made.rows)) return {};
    const bool holes = keys.count("NODATA") > 0;
    const T missing = holes ? static_cast<T>(std::stof(keys["NODATA"])) : T(0);
    made.heights.resize(static_cast<std::size_t>(made.columns * made.rows));
    for (Index j = 0; j < made.rows; ++j) {
        for (Index i = 0; i < made.columns; ++i) {
            const auto at = size * static_cast<std::size_t>(i + (made.rows - 1 - j) * made.columns);
            float value = 0;
            std::int16_t whole = 0;
            if (real) {
                std::memcpy(&value, bytes.data() + at, sizeof value);
            } else {
                std::memcpy(&whole, bytes.data() + at, sizeof whole);
                value = whole;
            }
            made.at(i, j) = static_cast<T>(value);
            if (holes && made.at(i, j) == missing) made.remove(i, j);
        }
    }
    return made;
}

inline const std::vector<std::string> real_terrains_without_holes{
    "spanish_peaks", "sugarhouse_standin", "moab_standin", "devilshole_standin", "enoriver"};
inline const std::vector<std::string> real_terrains_with_holes{"swissalps_voids", "mshelens_crater",
                                                               "bullet_scan", "kinect_boxes"};

/// Calls each(name, terrain) for those of `names` that are there, and says that the test is skipped if none is.
template <Real T, class Each>
void on_real_terrains_or_skip(const std::vector<std::string>& names, Each each) {
    bool any = false;
    for (const auto& name : names) {
        const auto ground = real_terrain<T>(name);
        if (ground) each(name, *ground);
        any = any || ground;
    }
    if (!any) skip("no terrain of " HFH_SHARED_DATA_DIR " is there");
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_REAL_TERRAINS_HPP
