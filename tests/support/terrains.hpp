#ifndef HFH_TESTS_SUPPORT_TERRAINS_HPP
#define HFH_TESTS_SUPPORT_TERRAINS_HPP

#include "numbers.hpp"
#include "random.hpp"

#include <hfh/terrain/bilinear_grid.hpp>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

// Small synthetic terrains with a closed form, to test on.

namespace hfh::test {

/// What the lattices of the tests' grids compute places in: double; where HFH_TEST_FLOAT_LATTICE is defined, T.
#if defined(HFH_TEST_FLOAT_LATTICE)
template <Real T>
using PlaceScalar = T;
#else
template <Real T>
using PlaceScalar = double;
#endif

/// The frame as the lattice of a grid has it: origin and spacing rounded to what it computes in.
template <Real T>
[[nodiscard]] GridFrame rounded(GridFrame frame) {
    for (double* x : {&frame.origin.x, &frame.origin.y, &frame.spacing.x, &frame.spacing.y})
        *x = widen(static_cast<PlaceScalar<T>>(*x));
    return frame;
}

/// Samples of type T with the frame they lie in. The grid looks at them, so the terrain has to outlive it, and an
/// edit of `heights` is seen through it.
template <Real T>
struct Terrain {
    Index columns = 0, rows = 0;
    std::vector<T> heights; // row by row, south row first
    GridFrame frame{};

    using Grid = BilinearGrid<T, HeightView<T>, PlaceScalar<T>>;

    [[nodiscard]] Grid grid() const { return {HeightView<T>{heights.data(), columns, rows}, frame}; }
    [[nodiscard]] T& at(Index i, Index j) { return heights[static_cast<std::size_t>(i + j * columns)]; }
    [[nodiscard]] T at(Index i, Index j) const { return heights[static_cast<std::size_t>(i + j * columns)]; }
    /// Takes sample (i, j) out: the up to four patches around it become a hole.
    void remove(Index i, Index j) { at(i, j) = hidden_nan<T>(); }

    /// Extent in metres.
    [[nodiscard]] glm::dvec2 low() const { return frame.origin; }
    [[nodiscard]] glm::dvec2 high() const {
        return frame.origin +
               frame.spacing * glm::dvec2{static_cast<double>(columns - 1), static_cast<double>(rows - 1)};
    }
};

/// From this size on, in metres, a number is no height: the squares that a tracker computes would overflow.
template <Real T>
inline constexpr T no_height_from = sizeof(T) == 4 ? T(0x1p31F) : static_cast<T>(0x1p255);

/// Whether every sample is a height.
template <Real T>
[[nodiscard]] bool without_holes(const Terrain<T>& terrain) {
    for (const T sample : terrain.heights) {
        const double metres =
            terrain.frame.height_offset + terrain.frame.height_scale * static_cast<double>(sample);
        if (!holds_number(sample) || !(std::abs(metres) < static_cast<double>(no_height_from<T>)))
            return false;
    }
    return true;
}

/// columns × rows samples of height(i, j).
template <Real T, class Height>
[[nodiscard]] Terrain<T> terrain(Index columns, Index rows, Height&& height, const GridFrame& frame = {}) {
    Terrain<T> made{columns, rows, {}, rounded<T>(frame)};
    made.heights.reserve(static_cast<std::size_t>(columns * rows));
    for (Index j = 0; j < rows; ++j) {
        for (Index i = 0; i < columns; ++i) made.heights.push_back(static_cast<T>(height(i, j)));
    }
    return made;
}

/// Flat at `height`.
template <Real T>
[[nodiscard]] Terrain<T> plane(Index columns, Index rows, double height = 0, const GridFrame& frame = {}) {
    return terrain<T>(
        columns, rows, [=](Index, Index) { return height; }, frame);
}

/// Rises by `along_i` metres per column and `along_j` per row, from `height` at sample (0, 0).
template <Real T>
[[nodiscard]] Terrain<T> tilted_plane(Index columns, Index rows, double along_i, double along_j,
                                      double height = 0, const GridFrame& frame = {}) {
    return terrain<T>(
        columns, rows,
        [=](Index i, Index j) {
            return height + along_i * static_cast<double>(i) + along_j * static_cast<double>(j);
        },
        frame);
}

namespace detail {

/// Steps from the middle sample, signed.
inline std::pair<double, double> from_middle(Index columns, Index rows, Index i, Index j) {
    return {static_cast<double>(i - columns / 2), static_cast<double>(j - rows / 2)};
}

} // namespace detail

/// z = twist·(i − middle)(j − middle): one saddle that every patch is a piece of.
template <Real T>
[[nodiscard]] Terrain<T> saddle(Index columns, Index rows, double twist = 1, const GridFrame& frame = {}) {
    return terrain<T>(
        columns, rows,
        [=](Index i, Index j) {
            const auto [x, y] = detail::from_middle(columns, rows, i, j);
            return twist * x * y;
        },
        frame);
}

/// A crest along y at the middle column, `fall` metres down per column to both sides; negative: a valley.
template <Real T>
[[nodiscard]] Terrain<T> ridge(Index columns, Index rows, double fall = 1, const GridFrame& frame = {}) {
    return terrain<T>(
        columns, rows,
        [=](Index i, Index j) { return -fall * std::abs(detail::from_middle(columns, rows, i, j).first); },
        frame);
}
template <Real T>
[[nodiscard]] Terrain<T> valley(Index columns, Index rows, double rise = 1, const GridFrame& frame = {}) {
    return ridge<T>(columns, rows, -rise, frame);
}

/// Flat, with the middle sample `depth` metres down; negative: a peak.
template <Real T>
[[nodiscard]] Terrain<T> pit(Index columns, Index rows, double depth = 1, const GridFrame& frame = {}) {
    auto made = plane<T>(columns, rows, 0, frame);
    made.at(columns / 2, rows / 2) = static_cast<T>(-depth);
    return made;
}
template <Real T>
[[nodiscard]] Terrain<T> peak(Index columns, Index rows, double height = 1, const GridFrame& frame = {}) {
    return pit<T>(columns, rows, -height, frame);
}

/// Every sample random between 0 and `relief`, without regard for its neighbours: as rough as a grid can be.
template <Real T>
[[nodiscard]] Terrain<T> rough(Index columns, Index rows, double relief, std::uint64_t seed,
                               const GridFrame& frame = {}) {
    Random random{seed};
    return terrain<T>(
        columns, rows, [&](Index, Index) { return random.between(0, relief); }, frame);
}

/// Rough in steps of relief/64, so that with a dyadic relief every sample is exact in float.
template <Real T>
[[nodiscard]] Terrain<T> rough_in_steps(Index columns, Index rows, double relief, std::uint64_t seed,
                                        const GridFrame& frame = {}) {
    Random random{seed};
    return terrain<T>(
        columns, rows, [&](Index, Index) { return relief * random.fraction(0, 1, 64); }, frame);
}

/// Smooth hills of the given wavelength in samples, from −relief/2 to relief/2.
template <Real T>
[[nodiscard]] Terrain<T> hills(Index columns, Index rows, double relief, double wavelength,
                               const GridFrame& frame = {}) {
    const double k = 2 * 3.14159265358979 / wavelength;
    return terrain<T>(
        columns, rows,
        [=](Index i, Index j) {
            return relief / 2 * std::sin(k * static_cast<double>(i)) * std::cos(k * static_cast<double>(j));
        },
        frame);
}

/// Takes out one sample in `n` at random.
template <Real T>
void punch_holes(Terrain<T>& terrain, std::int64_t n, std::uint64_t seed) {
    Random random{seed};
    for (auto& height : terrain.heights) {
        if (random.one_in(n)) height = hidden_nan<T>();
    }
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_TERRAINS_HPP
