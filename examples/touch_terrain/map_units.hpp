#ifndef TOUCH_TERRAIN_MAP_UNITS_HPP
#define TOUCH_TERRAIN_MAP_UNITS_HPP

#include <glm/ext/vector_double2.hpp>

#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// What the coordinates of a map are, and what a raster on it measures. Based on: OGC 01-009 and 18-010 (well-known text of
// coordinate reference systems); Snyder, Map Projections, USGS 1395, 1987, Eq. (4-18) and (4-20), radii of the ellipsoid.

namespace demo {

/// A map on which all parallels are as long as the equator: its metres are more than those on the ground, by about 1/cos φ.
struct CylindricalMap {
    enum class Kind : unsigned char {
        mercator,    ///< stretched as much to the north; Web Mercator too
        equidistant, ///< true to the north (plate carrée)
        equal_area   ///< shrunk as much to the north
    };
    Kind kind = Kind::mercator;
    double scale = 1; ///< k₀, of lengths on the equator
    /// e² of what is projected: 0 for a sphere, as which all but Mercator's are taken, right to 1 %.
    double eccentricity_squared = 0;
    double false_northing = 0; ///< of the equator, metres
};

/// The units of a coordinate reference system.
struct MapUnits {
    bool arbitrary = false;        ///< of a local system, whose units may only be there by default
    bool angular = false;          ///< coordinates are longitude and latitude
    double size = 1;               ///< of a unit: metres, or radians where angular
    double semi_major = 6'378'137; ///< of the ellipsoid, metres; WGS 84 unless the map says otherwise
    double flattening = 1 / 298.257'223'563; ///< of the ellipsoid
    std::optional<double> height; ///< metres in a unit of height, where the map has a vertical part
    bool depths = false;          ///< heights count downwards there
    std::optional<CylindricalMap> cylindrical;

    /// True if a length on the map is known in metres only together with a latitude.
    [[nodiscard]] bool needs_latitude() const noexcept { return angular || cylindrical; }
};

/// The units of a .prj file: well-known text of either version, ESRI's included, or the older lines "Projection GEOGRAPHIC",
/// "Units DD", "Zunits METERS". Nothing where `text` is neither or does not tell
/// what a unit is on the ground.
[[nodiscard]] std::optional<MapUnits> read_map_units(std::string_view text);

/// A raster on its map, in the map's units: its cells, all above 0, and its southernmost and northernmost samples.
struct MapExtent {
    glm::dvec2 cell{1.0};
    double south = 0;
    double north = 0;
};

/// Metres from sample to sample. On an angular map they are those at the middle latitude φ,
///
///     east  N·cos φ·Δλ,  north  M·Δφ,   N = a/√(1 − e²·sin²φ),  M = a·(1 − e²)/(1 − e²·sin²φ)^(3/2),
///
/// and on a cylindrical one, where φ follows from the northing (Snyder, chapters 7, 10 and 12),
///
///     east  f·Δx,  north  f·Δy (Mercator), Δy (equidistant), Δy/f (equal area),   f = cos φ/(k₀·√(1 − e²·sin²φ)),
///
/// and a sentence about that goes to `assumed`. Throws BadInput, in the name of `file`, where the cells or the latitude are
/// none that a terrain can have.
[[nodiscard]] glm::dvec2 spacing_on_map(const MapUnits& units, const MapExtent& extent,
                                        const std::string& file, std::vector<std::string>& assumed);

/// `spacing` if both are from 1e-12 to 1e12 metres, as a grid needs them; throws BadInput otherwise.
glm::dvec2 checked_spacing(glm::dvec2 spacing, const std::string& file);

} // namespace demo

#endif // TOUCH_TERRAIN_MAP_UNITS_HPP
