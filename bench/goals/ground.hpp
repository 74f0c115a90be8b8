#ifndef HFH_BENCH_GOALS_GROUND_HPP
#define HFH_BENCH_GOALS_GROUND_HPP

#include "../terrain.hpp"
#include "peers.hpp"

#include <limits>
#include <map>
#include <memory>
#include <optional>

// The ground of the goals that is not in terrain.hpp: rasters with holes, in float, and hills of any size.

namespace hfh::bench {

/// Samples, south row first; what a Terrain has, for any sample type. Heights in the unit of the spacing.
template <Sample S, class Missing = NeverMissing>
struct Ground {
    TerrainKind kind;
    std::shared_ptr<const S> samples;
    Missing missing{};
    double steepest = 0;

    template <Real T>
    using Grid = BilinearGrid<T, HeightView<S, Missing>>;
    template <Real T>
    [[nodiscard]] Grid<T> grid() const noexcept {
        return {HeightView<S, Missing>{samples.get(), kind.columns, kind.rows, missing},
                {.spacing = kind.spacing}};
    }
    [[nodiscard]] double cell() const noexcept { return std::sqrt(kind.spacing.x * kind.spacing.y); }
    [[nodiscard]] double sample(Index i, Index j) const noexcept {
        const S s = samples.get()[i + j * kind.columns];
        return missing(s) ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(s);
    }
    /// NaN over a hole.
    [[nodiscard]] double surface(double x, double y) const noexcept { return bilinear_height(*this, x, y); }
};

/// Whether there is ground at (x, y), and no hole.
template <class G>
[[nodiscard]] bool over_surface(const G& ground, const glm::dvec2& at) noexcept {
    return !std::isnan(ground.surface(at.x, at.y));
}

[[nodiscard]] inline PeerHeights for_peers(const Terrain& t) noexcept {
    const auto& k = t.kind;
    return {t.samples.data() + (k.rows - 1) * k.columns, k.columns, k.rows, -k.columns, k.spacing};
}
[[nodiscard]] inline PeerHeights for_peers(const Ground<std::int16_t>& g) noexcept {
    return {g.samples.get(), g.kind.columns, g.kind.rows, g.kind.columns, g.kind.spacing};
}

namespace detail {

template <class G>
void find_steepest(G& ground) {
    for (Index j = 0; j + 1 < ground.kind.rows; ++j) {
        for (Index i = 0; i + 1 < ground.kind.columns; ++i) {
            const double here = ground.sample(i, j);
            const double x = std::abs(ground.sample(i + 1, j) - here) / ground.kind.spacing.x,
                         y = std::abs(ground.sample(i, j + 1) - here) / ground.kind.spacing.y;
            if (x > ground.steepest) ground.steepest = x; // false for NaN
            if (y > ground.steepest) ground.steepest = y;
        }
    }
}

} // namespace detail

/// <name>.bil of the data directory, its size, spacing and missing value from <name>.hdr; none if it is not there or
/// not of this sample type.
template <Sample S>
[[nodiscard]] std::optional<Ground<S, MissingValue<S>>> real_ground(const char* name) {
    const std::string path = HFH_SHARED_DATA_DIR "/" + std::string{name};
    std::ifstream header{path + ".hdr"}, file{path + ".bil", std::ios::binary};
    if (!header || !file) return {};
    std::map<std::string, std::string> keys;
    for (std::string key, value; header >> key >> value;) keys[key] = value;
    if ((keys["PIXELTYPE"] == "FLOAT") != std::is_floating_point_v<S>) return {};

    const Index columns = std::stol(keys["NCOLS"]), rows = std::stol(keys["NROWS"]);
    const std::shared_ptr<S[]> samples{new S[static_cast<std::size_t>(columns * rows)]};
    for (Index j = rows - 1; j >= 0; --j) {
        const auto bytes = static_cast<std::streamsize>(sizeof(S)) * columns;
        if (!file.read(reinterpret_cast<char*>(samples.get() + j * columns), bytes)) return {};
    }
    const S missing = keys.count("NODATA") > 0 ? static_cast<S>(std::stod(keys["NODATA"]))
                                               : std::numeric_limits<S>::lowest();
    Ground<S, MissingValue<S>> ground{
        {name, name, Source::shared, columns, rows, {std::stod(keys["XDIM"]), std::stod(keys["YDIM"])}},
        {samples, samples.get()},
        {missing}};
    ground.kind.lowest = std::numeric_limits<double>::max();
    ground.kind.highest = std::numeric_limits<double>::lowest();
    for (Index k = 0; k < columns * rows; ++k) {
        if (samples[k] == missing) continue;
        ground.kind.lowest = std::min(ground.kind.lowest, static_cast<double>(samples[k]));
        ground.kind.highest = std::max(ground.kind.highest, static_cast<double>(samples[k]));
    }
    detail::find_steepest(ground);
    return ground;
}

/// `columns` × `rows` samples of the hills, in memory.
[[nodiscard]] inline Ground<std::int16_t> hills_in_memory(const char* name, Index columns, Index rows) {
    const std::shared_ptr<std::int16_t[]> samples{new std::int16_t[static_cast<std::size_t>(columns * rows)]};
    const Hills hills;
    for (Index j = 0; j < rows; ++j) hills.row(j, columns, samples.get() + j * columns);
    Ground<std::int16_t> ground{{name,
                                 "",
                                 Source::generated,
                                 columns,
                                 rows,
                                 {Hills::spacing, Hills::spacing},
                                 Hills::lowest,
                                 Hills::highest},
                                {samples, samples.get()}};
    ground.steepest = Hills::steepest;
    return ground;
}

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_GROUND_HPP
