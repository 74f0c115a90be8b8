#ifndef TOUCH_TERRAIN_PACKED_HEIGHTS_HPP
#define TOUCH_TERRAIN_PACKED_HEIGHTS_HPP

#include "terrain.hpp"

#include <cstddef>
#include <memory>

// Heights packed into the red, green and blue of 8 bits. Based on: Tilezen, "Terrarium"; Mapbox, "Terrain-RGB".

namespace demo {

/// height = offset + scale·(65536·red + 256·green + blue), metres.
struct PackedScale {
    double scale, offset;
};
[[nodiscard]] constexpr PackedScale scale_of(Encoding encoding) noexcept {
    return encoding == Encoding::terrarium ? PackedScale{1.0 / 256, -32768} : PackedScale{0.1, -10000};
}

/// Pixel k of three channels as one sample. `channels`: from pixel to pixel.
[[nodiscard]] inline std::int32_t packed_sample(const std::uint8_t* pixels, std::size_t channels,
                                                std::size_t k) noexcept {
    const std::uint8_t* const rgb = pixels + k * channels;
    return rgb[0] << 16 | rgb[1] << 8 | rgb[2];
}

/// What stands where there is no height.
constexpr std::int32_t no_packed_sample = -1;

} // namespace demo

#endif // TOUCH_TERRAIN_PACKED_HEIGHTS_HPP
