#ifndef TOUCH_TERRAIN_TERRAIN_HPP
#define TOUCH_TERRAIN_TERRAIN_HPP

#include <hfh/height_view.hpp>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>

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

/// A terrain from a file: a view on samples, south row first, and whatever keeps those samples alive.
struct Terrain {
    std::string name;
    std::shared_ptr<const void> storage; ///< decoded pixels or a mapped file
    AnyHeights heights;
    std::optional<glm::dvec2> spacing; ///< metres from sample to sample, if the file says
};

/// Reads `file` by the end of its name: .png, .bil and .flt, and with GDAL anything that GDAL opens.
/// Throws BadInput.
[[nodiscard]] Terrain read_terrain(const std::filesystem::path& file);

/// An 8 or 16 bit PNG image: the alpha channel is the height if there is one, else grey is.
[[nodiscard]] Terrain read_png(const std::filesystem::path& file);

/// An ESRI .bil or .flt raster beside its .hdr. Memory-mapped: no sample is read before it is touched.
[[nodiscard]] Terrain read_raster(const std::filesystem::path& file);

/// Whatever GDAL opens; its first band, if it has only one.
[[nodiscard]] Terrain read_with_gdal(const std::filesystem::path& file);

/// A height field needs one patch. Throws BadInput.
void require_a_patch(const std::filesystem::path& file, hfh::Index columns, hfh::Index rows);

} // namespace demo

#endif // TOUCH_TERRAIN_TERRAIN_HPP
