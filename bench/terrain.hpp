#ifndef HFH_BENCH_TERRAIN_HPP
#define HFH_BENCH_TERRAIN_HPP

#include "hills.hpp"

#include <hfh/terrain/bilinear_grid.hpp>

#include <png.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

// The ground of the benchmarks: what anyone has with a clone, which is the bundled terrain and generated hills, and
// terrains of ../shared/data where they are.

namespace hfh::bench {

enum class Source {
    bundled,   ///< examples/data
    generated, ///< the same everywhere
    shared     ///< ../shared/data, which a clone does not have
};

[[nodiscard]] constexpr const char* to_string(Source source) noexcept {
    switch (source) {
    case Source::bundled: return "bundled";
    case Source::generated: return "generated";
    case Source::shared: return "shared";
    }
    return "";
}

struct TerrainKind {
    const char* name; ///< in the benchmark's name: the place that it shows
    const char* file; ///< <file>.png of examples/data, <file>.bil of ../shared/data; empty if generated
    Source source;
    Index columns, rows;
    glm::dvec2 spacing;
    double lowest = 0, highest = 0; ///< metres; of the samples once they are loaded
};

// clang-format off
inline constexpr TerrainKind spanish_peaks    {"spanish_peaks",     "spanish_peaks", Source::bundled,    300,  300, {73.596, 92.491}};
/// At the paper's own spacing, which makes the same ground 7 to 9 times steeper.
inline constexpr TerrainKind spanish_peaks_10m{"spanish_peaks_10m", "spanish_peaks", Source::bundled,    300,  300, {10, 10}};
/// Of the sizes of Sugarhouse and Moab in Table 1 [P].
inline constexpr TerrainKind small_hills      {"hills_0.28M",       "",              Source::generated,  541,  511, {Hills::spacing, Hills::spacing}};
inline constexpr TerrainKind large_hills      {"hills_1.56M",       "",              Source::generated, 1405, 1112, {Hills::spacing, Hills::spacing}};
inline constexpr TerrainKind terrains_of_a_clone[] = {spanish_peaks, small_hills, large_hills, spanish_peaks_10m};

inline constexpr TerrainKind big_tujunga         {"big_tujunga",          "sugarhouse_standin", Source::shared,  541,  511, {30, 30}};
inline constexpr TerrainKind sangre_de_cristo    {"sangre_de_cristo",     "moab_standin",       Source::shared, 1405, 1112, {73.596, 92.491}};
inline constexpr TerrainKind trinidad            {"trinidad",             "devilshole_standin", Source::shared, 1393, 1089, {73.596, 92.491}};
inline constexpr TerrainKind sangre_de_cristo_10m{"sangre_de_cristo_10m", "moab_standin",       Source::shared, 1405, 1112, {10, 10}};
inline constexpr TerrainKind shared_terrains[] = {big_tujunga, sangre_de_cristo, trinidad, sangre_de_cristo_10m};
// clang-format on

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
    double steepest = 0;               ///< largest slope between neighbouring samples

    template <Real T>
    [[nodiscard]] auto grid() const noexcept {
        const HeightView heights =
            HeightView{samples.data(), kind.columns, kind.rows, 1, kind.columns}.flipped_rows();
        return BilinearGrid<T, HeightView<std::int16_t>>{heights, {.spacing = kind.spacing}};
    }
    template <Real T>
    using Grid = BilinearGrid<T, HeightView<std::int16_t>>;

    [[nodiscard]] const char* label() const noexcept { return to_string(kind.source); }
    /// The size of a cell where one number has to do.
    [[nodiscard]] double cell() const noexcept { return std::sqrt(kind.spacing.x * kind.spacing.y); }

    [[nodiscard]] double sample(Index i, Index j) const noexcept {
        return samples[static_cast<std::size_t>((kind.rows - 1 - j) * kind.columns + i)];
    }
    [[nodiscard]] double surface(double x, double y) const noexcept { return bilinear_height(*this, x, y); }
};

namespace detail {

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

/// The samples of the bundled PNG: its alpha channel holds whole metres. Throws where it is not as it should be.
[[nodiscard]] inline std::vector<std::int16_t> read_bundled(const TerrainKind& kind) {
    const std::string path = HFH_SOURCE_DIR "/examples/data/" + std::string{kind.file} + ".png";
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    const bool found = png_image_begin_read_from_file(&image, path.c_str()) != 0;
    if (!found || image.width != kind.columns || image.height != kind.rows) {
        throw std::runtime_error{"cannot read " + path};
    }
    image.format = PNG_FORMAT_LINEAR_RGB_ALPHA; // alpha is never converted
    std::vector<std::uint16_t> pixels(PNG_IMAGE_SIZE(image) / 2);
    if (png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr) == 0) {
        throw std::runtime_error{"cannot read " + path};
    }
    std::vector<std::int16_t> samples;
    for (std::size_t k = 3; k < pixels.size(); k += 4) {
        samples.push_back(static_cast<std::int16_t>(pixels[k]));
    }
    return samples;
}

[[nodiscard]] inline std::vector<std::int16_t> generate(const TerrainKind& kind) {
    std::vector<std::int16_t> samples(static_cast<std::size_t>(kind.columns * kind.rows));
    const Hills hills;
    for (Index j = 0; j < kind.rows; ++j) {
        hills.row(j, kind.columns, samples.data() + (kind.rows - 1 - j) * kind.columns);
    }
    return samples;
}

[[nodiscard]] inline std::string shared_path(const TerrainKind& kind) {
    return HFH_SHARED_DATA_DIR "/" + std::string{kind.file} + ".bil";
}

[[nodiscard]] inline Terrain load(const TerrainKind& kind) {
    Terrain terrain{kind, {}};
    switch (kind.source) {
    case Source::bundled: terrain.samples = read_bundled(kind); break;
    case Source::generated: terrain.samples = generate(kind); break;
    case Source::shared:
        terrain.samples = read_bil(shared_path(kind), static_cast<std::size_t>(kind.columns * kind.rows));
        if (terrain.samples.empty()) throw std::runtime_error{"cannot read " + shared_path(kind)};
        break;
    }
    const auto [low, high] = std::minmax_element(terrain.samples.begin(), terrain.samples.end());
    terrain.kind.lowest = *low, terrain.kind.highest = *high;
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

/// Read or generated on first use. Throws if a file cannot be read; `is_there` tells before.
[[nodiscard]] inline const Terrain& terrain(const TerrainKind& kind) {
    static std::map<std::string, Terrain> loaded;
    const auto at = loaded.find(kind.name);
    return at != loaded.end() ? at->second : loaded.emplace(kind.name, detail::load(kind)).first->second;
}

[[nodiscard]] inline bool is_there(const TerrainKind& kind) {
    return kind.source != Source::shared || std::ifstream{detail::shared_path(kind)}.good();
}

/// The terrains of a clone, and those of ../shared/data that are there; says which are not.
[[nodiscard]] inline std::vector<TerrainKind> all_terrains() {
    std::vector<TerrainKind> there{std::begin(terrains_of_a_clone), std::end(terrains_of_a_clone)};
    for (const auto& kind : shared_terrains) {
        if (is_there(kind)) {
            there.push_back(kind);
        } else {
            std::fprintf(stderr, "skipped: %s; it needs ../shared/data/%s.bil\n", kind.name, kind.file);
        }
    }
    return there;
}

} // namespace hfh::bench

#endif // HFH_BENCH_TERRAIN_HPP
