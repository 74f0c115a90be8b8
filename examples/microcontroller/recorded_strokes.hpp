#ifndef HFH_EXAMPLE_RECORDED_STROKES_HPP
#define HFH_EXAMPLE_RECORDED_STROKES_HPP

#include <hfh/geometry/scalar.hpp>

#include <array>
#include <cstdint>

// The ground, which lies in flash, and strokes of a stylus over it. Both are made of whole numbers alone, so they are the same
// on every processor, to the bit.

namespace microcontroller {

inline constexpr int cells = 64, samples = cells + 1; // along x and along y
inline constexpr double cell_size = 0.001;            // metres
inline constexpr double height_unit = 0.00001;        // metres per unit of a sample

// A step of the stylus's encoders is 2⁻²⁰ m, about a micrometre.
inline constexpr double encoder_step = 0x1p-20;
inline constexpr std::int32_t steps_per_cell = 1049, steps_per_unit = 10;

/// Pseudo-random, from −256 to 255, at a knot of a coarser lattice.
constexpr int knot(unsigned i, unsigned j, unsigned octave) {
    std::uint32_t bits = i * 0x9e3779b9u + j * 0x85ebca6bu + octave * 0xc2b2ae35u;
    bits = (bits ^ bits >> 15) * 0x2c1b3c6du;
    bits = (bits ^ bits >> 12) * 0x297a2d39u;
    return static_cast<int>(bits >> 23) - 256;
}

/// Hills between knots that are `width` samples apart: −256 to 255.
constexpr int hills(int i, int j, int width, unsigned octave) {
    const auto smooth = [width](int x) {
        return x * x * (3 * width - 2 * x) * 256 / (width * width * width);
    };
    const auto column = static_cast<unsigned>(i / width), row = static_cast<unsigned>(j / width);
    const int u = smooth(i % width), v = smooth(j % width);
    const int south = knot(column, row, octave) * (256 - u) + knot(column + 1, row, octave) * u;
    const int north = knot(column, row + 1, octave) * (256 - u) + knot(column + 1, row + 1, octave) * u;
    return (south / 256 * (256 - v) + north / 256 * v) / 256;
}

/// Hills of 4 mm, and rough ground of half a millimetre on them.
constexpr std::array<std::int16_t, samples * samples> make_ground() {
    std::array<std::int16_t, samples * samples> heights{};
    for (int j = 0; j < samples; ++j) {
        for (int i = 0; i < samples; ++i) {
            const int height = hills(i, j, 8, 0) * 4 / 5 + hills(i, j, 2, 1) / 10;
            heights[static_cast<std::size_t>(j * samples + i)] = static_cast<std::int16_t>(height);
        }
    }
    return heights;
}

/// In flash: 8450 bytes.
inline constexpr std::array<std::int16_t, samples* samples> ground = make_ground();

/// A place of the stylus as the encoders tell it: steps from the south-western corner of the ground and from height 0.
struct EncoderCounts {
    std::int32_t x, y, z;
};

struct Stroke {
    const char* name;
    std::int32_t dx, dy; ///< steps an update
    std::int32_t depth;  ///< steps below the surface
    int updates;
    bool taps; ///< goes up and down through the surface all the time, else stays below it
};

/// Named by how far the stylus moves in an update, in cells. Each begins above the ground and pushes into it in 64 updates.
inline constexpr Stroke strokes[] = {
    {"still", 0, 0, 300, 500, false},
    {"slide_0.1", 93, 48, 300, 2000, false},
    {"slide_0.5", 467, 239, 300, 2000, false},
    {"slide_2", 1868, 956, 300, 2000, false},
    {"slide_2_deep", 1868, 956, 2100, 2000, false},
    {"tap_0.5", 467, 239, 500, 2000, true},
    {"tap_2", 1868, 956, 500, 2000, true},
};

/// From 2 cells inside of the border to as far from the other one and back.
constexpr std::int32_t back_and_forth(std::int32_t way) {
    constexpr std::int32_t room = (cells - 4) * steps_per_cell;
    const std::int32_t place = way % (2 * room);
    return 2 * steps_per_cell + (place < room ? place : 2 * room - place);
}

/// The ground's height in encoder steps.
constexpr std::int32_t ground_steps(std::int32_t x, std::int32_t y) {
    const std::int32_t i = x / steps_per_cell, j = y / steps_per_cell, u = x % steps_per_cell,
                       v = y % steps_per_cell, at = j * samples + i;
    const auto height = [](std::int32_t n) {
        return std::int32_t{ground[static_cast<std::size_t>(n)]} * steps_per_unit;
    };
    const std::int32_t south = (height(at) * (steps_per_cell - u) + height(at + 1) * u) / steps_per_cell;
    const std::int32_t north =
        (height(at + samples) * (steps_per_cell - u) + height(at + samples + 1) * u) / steps_per_cell;
    return (south * (steps_per_cell - v) + north * v) / steps_per_cell;
}

/// Where the stylus is in the n-th update.
constexpr EncoderCounts stylus_of(const Stroke& stroke, int n) {
    const std::int32_t x = back_and_forth(20 * steps_per_cell + 500 + n * stroke.dx),
                       y = back_and_forth(30 * steps_per_cell + 300 + n * stroke.dy);
    // From −depth to depth in 64 updates; on a tap, back again.
    const int part = n % 128 < 64 ? n % 128 : 128 - n % 128;
    const std::int32_t depth = n < 64 || stroke.taps ? stroke.depth * part / 32 - stroke.depth : stroke.depth;
    return {x, y, ground_steps(x, y) - depth};
}

} // namespace microcontroller

#endif // HFH_EXAMPLE_RECORDED_STROKES_HPP
