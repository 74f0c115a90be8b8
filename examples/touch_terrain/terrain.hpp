#ifndef TOUCH_TERRAIN_TERRAIN_HPP
#define TOUCH_TERRAIN_TERRAIN_HPP

#include <hfh/terrain/bilinear_grid.hpp>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace demo {

/// Tells the samples of a raster that are no heights: those equal to its "no data" value, if it has one.
template <hfh::Sample S>
struct NoData {
    std::optional<S> value;
    [[nodiscard]] bool operator()(S sample) const noexcept { return value && sample == *value; }
};

template <hfh::Sample S>
using Heights = hfh::HeightView<S, NoData<S>>;

/// Samples as they lie in the file or in the decoded image, whatever their type.
using AnyHeights = std::variant<Heights<std::uint8_t>, Heights<std::uint16_t>, Heights<std::int16_t>,
                                Heights<std::int32_t>, Heights<float>, Heights<double>>;

/// How a height is packed into the red, green and blue of 8 bits, v = 65536·red + 256·green + blue.
enum class Encoding : unsigned char {
    none,
    terrarium, ///< v/256 − 32768 metres (Tilezen)
    mapbox     ///< v/10 − 10000 metres (Mapbox Terrain-RGB)
};

/// What the user says of a file; it goes before what the file says of itself.
struct ReadOptions {
    std::optional<glm::dvec2> spacing = std::nullopt; ///< metres from sample to sample
    /// Metres in the unit of the samples, and in that of the spacing where the file names no map.
    std::optional<double> unit = std::nullopt;
    /// Grey, red, green, blue, alpha, or a number from 1; empty: the one that holds heights.
    std::string channel = {};
    Encoding encoding = Encoding::none;
    /// The samples may be written to afterwards, through `editable`: in memory, never in the file.
    bool for_editing = false;
};

/// A terrain from a file: a view on samples, south row first, and whatever keeps those samples alive. A sample s lies at
/// height_offset + height_scale·s metres.
struct Terrain {
    std::string name;
    std::shared_ptr<const void> storage; ///< decoded pixels or a mapped file
    AnyHeights heights;
    std::optional<glm::dvec2> spacing; ///< metres from sample to sample, if anybody says
    double height_scale = 1;
    double height_offset = 0;
    /// What the file leaves open and was decided here: each a sentence without its full stop, for people.
    std::vector<std::string> assumed;
};

/// The samples of a terrain that was read with `ReadOptions::for_editing`. They are in memory that is nobody's constant.
template <hfh::Sample S>
[[nodiscard]] S* editable(const Heights<S>& heights) noexcept {
    return const_cast<S*>(heights.data());
}

/// Reads `file` by the end of its name: .png, .bil and .flt, and with GDAL anything that GDAL opens, its names of
/// subdatasets and paths in /vsi… included. Pipes and devices are refused. Throws BadInput.
[[nodiscard]] Terrain read_terrain(const std::filesystem::path& file, const ReadOptions& options = {});

/// An 8 or 16 bit PNG image. Heights are in its only channel, or in its alpha channel; or else in its grey, where alpha is
/// the same everywhere, or says no more than which pixels are there. A pixel that tRNS makes transparent is a hole.
[[nodiscard]] Terrain read_png(const std::filesystem::path& file, const ReadOptions& options);

/// An ESRI .bil or .flt raster beside its .hdr, and its .prj if it has one. Memory-mapped: no sample is read before it is
/// touched, unless it has to be turned round (big-endian) or widened (32 bit unsigned).
[[nodiscard]] Terrain read_raster(const std::filesystem::path& file, const ReadOptions& options);

/// Whatever GDAL opens, as GDAL says it is meant: scale and offset, units, "no data", mask and alpha, map.
[[nodiscard]] Terrain read_with_gdal(const std::filesystem::path& file, const ReadOptions& options);

/// True if GDAL knows what to do with `file`.
[[nodiscard]] bool opens_with_gdal(const std::filesystem::path& file);

/// As `set_height_unit` with the scale, offset and unit that GDAL knows of band `band` of `file`, beside which they may stand
/// in an .aux.xml. False where GDAL cannot open it.
[[nodiscard]] bool set_heights_with_gdal(Terrain& terrain, const std::filesystem::path& file,
                                         const ReadOptions& options, int band);

/// Sets the spacing of an image, north row first, from its world file or its metadata, if GDAL finds any; turns it the
/// right way up where they say that the south row is first.
void place_with_gdal(Terrain& terrain, const std::filesystem::path& file, const ReadOptions& options);

/// A height field needs one patch. Throws BadInput.
void require_a_patch(const std::filesystem::path& file, hfh::Index columns, hfh::Index rows);

/// Makes `terrain` one whose samples are scale·s + offset units of height: of those of the user, else `unit` metres as the
/// file says, else metres, which is assumed. Throws BadInput where scale or offset are none.
void set_height_unit(Terrain& terrain, const std::filesystem::path& file, const ReadOptions& options,
                     std::optional<double> unit, double scale = 1, double offset = 0);

/// Turns over the heights of `terrain`, which are depths by its vertical system, and says so.
void turn_depths(Terrain& terrain);

} // namespace demo

#endif // TOUCH_TERRAIN_TERRAIN_HPP
