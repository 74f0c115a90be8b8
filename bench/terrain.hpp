#ifndef HFH_BENCH_TERRAIN_HPP
#define HFH_BENCH_TERRAIN_HPP

#include <hfh/terrain/bilinear_grid.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

// The ground of the benchmarks: real terrain of the sizes of Table 1 [P] where it is at hand, else made up.

namespace hfh::bench {

struct TerrainKind {
    const char* name; ///< in the benchmark's name
    const char* file; ///< <file>.bil in the data directory
    Index columns, rows;
    glm::dvec2 spacing;
    double lowest, highest; ///< metres
    double roughness;       ///< made-up ground: amplitude of each octave over that of the next longer one
};

// clang-format off
inline constexpr TerrainKind sugarhouse{"sugarhouse", "sugarhouse_standin",  541,  511, {30.0,   30.0  },  533, 2014, 0.50};
inline constexpr TerrainKind moab      {"moab",       "moab_standin",       1405, 1112, {73.596, 92.491}, 1676, 4322, 0.42};
inline constexpr TerrainKind devilshole{"devilshole", "devilshole_standin", 1393, 1089, {73.596, 92.491}, 1410, 4206, 0.42};
/// Moab at the paper's own spacing, which makes the same ground 7 to 9 times steeper.
inline constexpr TerrainKind moab10    {"moab10",     "moab_standin",       1405, 1112, {10.0,   10.0  }, 1676, 4322, 0.42};
// clang-format on
inline constexpr TerrainKind all_terrains[] = {sugarhouse, moab, devilshole, moab10};

/// Height of the bilinear surface over (x, y), straight from `ground.sample(i, j)`. Shares no code with the library, for
/// answers to be checked against it.
template <class G>
[[nodiscard]] double bilinear_height(const G& ground, double x, double y) noexcept {
    const auto& kind = ground.kind;
    const double a = x / kind.spacing.x, b = y / kind.spacing.y;
    const Index i = std::clamp<Index>(static_cast<Index>(a), 0, kind.columns - 2);
    const Index j = std::clamp<Index>(static_cast<Index>(b), 0, kind.rows - 2);
    const double u = a - static_cast<double>(i), v = b - static_cast<double>(j);
    return ground.sample(i, j) * (1 - u) * (1 - v) + ground.sample(i + 1, j) * u * (1 - v) +
           ground.sample(i, j + 1) * (1 - u) * v + ground.sample(i + 1, j + 1) * u * v;
}

struct Terrain {
    TerrainKind kind;
    std::vector<std::int16_t> samples; ///< whole metres, north row first
    bool real = false;                 ///< from a file
    double steepest = 0;               ///< largest slope between neighbouring samples

    template <Real T>
    [[nodiscard]] auto grid() const noexcept {
        const HeightView heights =
            HeightView{samples.data(), kind.columns, kind.rows, 1, kind.columns}.flipped_rows();
        return BilinearGrid<T, HeightView<std::int16_t>>{heights, {.spacing = kind.spacing}};
    }
    template <Real T>
    using Grid = BilinearGrid<T, HeightView<std::int16_t>>;

    [[nodiscard]] const char* label() const noexcept { return real ? "stand-in" : "synthetic"; }
    /// The size of a cell where one number has to do.
    [[nodiscard]] double cell() const noexcept { return std::sqrt(kind.spacing.x * kind.spacing.y); }

    [[nodiscard]] double sample(Index i, Index j) const noexcept {
        return samples[static_cast<std::size_t>((kind.rows - 1 - j) * kind.columns + i)];
    }
    [[nodiscard]] double surface(double x, double y) const noexcept { return bilinear_height(*this, x, y); }
};

namespace detail {

/// The same number in [−1, 1] for the same arguments, everywhere.
inline double lattice_noise(std::uint64_t octave, Index i, Index j) noexcept {
    std::uint64_t x = octave * 0x9e37'79b9'7f4a'7c15u +
                      static_cast<std::uint64_t>(i) * 0xbf58'476d'1ce4'e5b9u +
                      static_cast<std::uint64_t>(j) * 0x94d0'49bb'1331'11ebu;
    x = (x ^ (x >> 30)) * 0xbf58'476d'1ce4'e5b9u;
    x = (x ^ (x >> 27)) * 0x94d0'49bb'1331'11ebu;
    return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-52 - 1;
}

inline double smooth_noise(std::uint64_t octave, double x, double y) noexcept {
    const double i = std::floor(x), j = std::floor(y);
    const auto ease = [](double t) { return t * t * (3 - 2 * t); };
    const double u = ease(x - i), v = ease(y - j);
    const auto at = [&](Index di, Index dj) {
        return lattice_noise(octave, static_cast<Index>(i) + di, static_cast<Index>(j) + dj);
    };
    return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
}

/// Hills of wavelengths from 512 samples down to 2, stretched to the real ground's lowest and highest point.
inline std::vector<std::int16_t> made_up(const TerrainKind& kind) {
    std::vector<double> heights;
    for (Index j = 0; j < kind.rows; ++j) {
        for (Index i = 0; i < kind.columns; ++i) {
            double sum = 0, amplitude = 1, wavelength = 512;
            for (std::uint64_t octave = 0; octave < 9; ++octave) {
                sum += amplitude * smooth_noise(octave, static_cast<double>(i) / wavelength,
                                                static_cast<double>(j) / wavelength);
                amplitude *= kind.roughness;
                wavelength /= 2;
            }
            heights.push_back(sum);
        }
    }
    const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
    const double from = *low, scale = (kind.highest - kind.lowest) / (*high - *low);
    std::vector<std::int16_t> samples;
    for (const double h : heights) {
        samples.push_back(static_cast<std::int16_t>(std::lround(kind.lowest + scale * (h - from))));
    }
    return samples;
}

/// The samples of a .bil file, 16 bit little-endian; empty if there is none of the right size.
inline std::vector<std::int16_t> read_bil(const std::string& path, std::size_t count) {
    std::ifstream file{path, std::ios::binary};
    std::vector<std::int16_t> samples(count);
    const auto bytes = static_cast<std::streamsize>(2 * count);
    if (!file.read(reinterpret_cast<char*>(samples.data()), bytes) || file.get() != EOF) return {};
    if constexpr (std::endian::native == std::endian::big) {
        for (auto& s : samples) {
            const auto bits = static_cast<std::uint16_t>(s);
            s = static_cast<std::int16_t>(static_cast<std::uint16_t>(bits << 8 | bits >> 8));
        }
    }
    return samples;
}

inline Terrain load(const TerrainKind& kind) {
    Terrain terrain{kind, {}};
    terrain.samples = read_bil(HFH_SHARED_DATA_DIR "/" + std::string{kind.file} + ".bil",
                               static_cast<std::size_t>(kind.columns * kind.rows));
    terrain.real = !terrain.samples.empty();
    if (!terrain.real) terrain.samples = made_up(kind);
    for (Index j = 0; j + 1 < kind.rows; ++j) {
        for (Index i = 0; i + 1 < kind.columns; ++i) {
            const double here = terrain.sample(i, j);
            terrain.steepest =
                std::max({terrain.steepest, std::abs(terrain.sample(i + 1, j) - here) / kind.spacing.x,
                          std::abs(terrain.sample(i, j + 1) - here) / kind.spacing.y});
        }
    }
    return terrain;
}

} // namespace detail

/// One of `all_terrains`, read on first use.
[[nodiscard]] inline const Terrain& terrain(std::size_t number) {
    static Terrain loaded[std::size(all_terrains)];
    Terrain& wanted = loaded[number];
    if (wanted.samples.empty()) wanted = detail::load(all_terrains[number]);
    return wanted;
}

} // namespace hfh::bench

#endif // HFH_BENCH_TERRAIN_HPP
