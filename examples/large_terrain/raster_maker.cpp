#include "raster_maker.hpp"

#include <bad_input.hpp>
#include <numbers.hpp>
#include <output_file.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <unistd.h>

namespace large_terrain {
namespace {

constexpr std::uint64_t longest = 4096;       // cells
constexpr std::int32_t unit = 64;             // of heights as they are added up, to the metre
constexpr std::int32_t tallest = 1400 * unit; // of the longest bumps, up and down
constexpr int weight_bits = 13;

/// A whole number from −size to size, the same for the same arguments.
std::int32_t knot(std::uint64_t seed, std::uint64_t wavelength, std::uint64_t i, std::uint64_t j,
                  std::int32_t size) {
    std::uint64_t x = seed * 0x9e37'79b9'7f4a'7c15u + wavelength;
    for (const std::uint64_t part : {i, j}) {
        x = (x ^ (x >> 30) ^ part) * 0xbf58'476d'1ce4'e5b9u;
        x = (x ^ (x >> 27)) * 0x94d0'49bb'1331'11ebu;
    }
    x ^= x >> 31;
    return static_cast<std::int32_t>((x >> 32) * (2 * static_cast<std::uint64_t>(size) + 1) >> 32) - size;
}

/// Weights of the next knot over one wavelength, from 0 at one knot to 2¹³ at the other, level at both ends.
std::vector<std::int32_t> weights(std::uint64_t wavelength) {
    std::vector<std::int32_t> ease;
    for (std::uint64_t k = 0; k < wavelength; ++k) {
        const std::uint64_t w = wavelength;
        ease.push_back(static_cast<std::int32_t>((k * k * (3 * w - 2 * k) << weight_bits) / (w * w * w)));
    }
    return ease;
}

/// Two heights differ by less than 2 · 89,600: times a weight that is below 2³¹.
std::int32_t between(std::int32_t from, std::int32_t to, std::int32_t weight) {
    return from + ((to - from) * weight >> weight_bits);
}

} // namespace

GroundRows::GroundRows(std::uint64_t columns, std::uint64_t seed)
    : columns_{columns}, seed_{seed}, sums_(columns) {}

void GroundRows::row(std::uint64_t j, std::vector<std::int16_t>& samples) {
    static const auto ease = [] {
        std::array<std::vector<std::int32_t>, std::bit_width(longest)> all;
        for (std::uint64_t w = longest; w >= 2; w /= 2)
            all[static_cast<std::size_t>(std::countr_zero(w))] = weights(w);
        return all;
    }();

    std::ranges::fill(sums_, 0);
    std::int32_t size = tallest;
    for (std::uint64_t w = longest; w >= 2; w /= 2, size = size * 15 / 32) {
        const std::vector<std::int32_t>& weight = ease[static_cast<std::size_t>(std::countr_zero(w))];
        // The knots north and south of the row make one row of knots; between those it goes from west to east.
        const std::uint64_t count = columns_ / w + 2;
        knots_.resize(count);
        for (std::uint64_t i = 0; i < count; ++i) {
            knots_[i] =
                between(knot(seed_, w, i, j / w, size), knot(seed_, w, i, j / w + 1, size), weight[j % w]);
        }
        for (std::uint64_t i = 0, from = 0; from < columns_; ++i, from += w) {
            const std::uint64_t length = std::min(w, columns_ - from);
            for (std::uint64_t k = 0; k < length; ++k) {
                sums_[from + k] += between(knots_[i], knots_[i + 1], weight[k]);
            }
        }
    }
    samples.resize(columns_);
    for (std::uint64_t i = 0; i < columns_; ++i) {
        samples[i] = static_cast<std::int16_t>((sums_[i] + 4000 * unit) / unit - 1000);
    }
}

void make_raster(const std::filesystem::path& file, std::uint64_t columns, std::uint64_t rows,
                 std::uint64_t seed) {
    const auto refuse = [&](const std::string& why) {
        throw demo::BadInput{file.string() + " cannot be written: " + why + "."};
    };
    if (file.extension() != ".bil") {
        throw demo::BadInput{file.string() + " must end in .bil: that is what is written."};
    }
    std::filesystem::path header = file;
    header.replace_extension(".hdr");
    demo::OutputFile raster{file}, text{header};

    // Room is taken before the first row is made. A file system that cannot do this is tried all the same.
    const std::uint64_t bytes = rows * columns * sizeof(std::int16_t);
    if (::fallocate(raster.descriptor(), 0, 0, static_cast<off_t>(bytes)) != 0 && errno != EOPNOTSUPP) {
        const int why = errno;
        std::error_code unknown;
        const auto space = std::filesystem::space(std::filesystem::absolute(file).parent_path(), unknown);
        refuse("it needs " + demo::grouped(bytes) + " bytes, but " + std::strerror(why) +
               (unknown ? "" : " (" + demo::grouped(space.available) + " bytes are free)"));
    }

    GroundRows ground{columns, seed};
    std::vector<std::int16_t> samples;
    for (std::uint64_t j = 0; j < rows; ++j) {
        ground.row(j, samples);
        raster.write({reinterpret_cast<const char*>(samples.data()), samples.size() * sizeof samples[0]});
    }
    constexpr bool little = std::endian::native == std::endian::little;
    text.write("NROWS " + std::to_string(rows) + "\nNCOLS " + std::to_string(columns) +
               "\nNBANDS 1\nNBITS 16\nLAYOUT BIL\nPIXELTYPE SIGNEDINT\nBYTEORDER " + (little ? "I" : "M") +
               "\nXDIM 10\nYDIM 10\n");
    for (const demo::OutputFile* written : {&raster, &text}) {
        if (::fdatasync(written->descriptor()) != 0) refuse(std::strerror(errno));
    }
    raster.keep();
    text.keep();
}

} // namespace large_terrain
