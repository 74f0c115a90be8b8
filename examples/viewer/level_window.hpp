#ifndef VIEWER_LEVEL_WINDOW_HPP
#define VIEWER_LEVEL_WINDOW_HPP

#include "hand_input.hpp"

#include <glm/ext/vector_float2.hpp>

#include <cstdint>
#include <functional>
#include <vector>

// Based on: Losasso, Hoppe, Geometry clipmaps: terrain rendering using nested regular grids, 2004; Asirvatham, Hoppe,
// Terrain rendering using GPU-based geometry clipmaps, GPU Gems 2, 2005: nested windows of n × n vertices around one place,
// each twice as coarse as the one inside it.

namespace viewer {

/// One vertex of a window. Heights in metres above the datum, slopes in metres per metre. Of level l at its place, and of level
/// l + 1 there.
struct LevelVertex {
    float height = 0, coarse_height = 0;
    glm::vec2 slope{0.0f}, coarse_slope{0.0f};
};
/// The slope of a vertex whose cell (to the north-east of it) does not exist.
inline constexpr float no_cell = 1e9f;

/// Reads the height of sample (i, j) in metres; NaN in a hole. Called for 0 ≤ i < columns, 0 ≤ j < rows only.
using SampleReader = std::function<double(hfh::Index i, hfh::Index j)>;

/// What a terrain looks like to a display.
struct DisplayedTerrain {
    hfh::Index columns = 0, rows = 0;
    glm::dvec2 spacing{1.0};
    double datum = 0; ///< m: subtracted before heights are rounded to float
    SampleReader sample;
};

/// The vertices of one level in a window of n × n, filled straight from strided samples. Where the window moves, only what it
/// did not hold before is read.
///
/// Vertex (a, b) of the window is sample ((origin + (a, b))·2^level), brought to the nearest one of the terrain: what is
/// beyond its border lies on it, and the last cell may be narrower than the others. (That one is not felt where the level is the
/// hand's, and then not drawn.)
class LevelWindow {
public:
    LevelWindow(const DisplayedTerrain& terrain, int level, int n);

    /// Moves the window, so that `place` (in samples) is in the middle cells of it, on even vertices of the level.
    void move_to(const glm::dvec2& place);
    /// Reads the samples of `changed` again.
    void read_again(const SampleRange& changed);

    [[nodiscard]] hfh::Cell origin() const noexcept { return origin_; }
    [[nodiscard]] int level() const noexcept { return level_; }
    /// Grows whenever a vertex may have changed.
    [[nodiscard]] std::uint64_t version() const noexcept { return version_; }
    [[nodiscard]] std::uint64_t samples_read() const noexcept { return samples_read_; }
    [[nodiscard]] bool has_holes() const noexcept { return holes_ > 0; }

    /// The n × n vertices, row by row from the south-west.
    [[nodiscard]] std::vector<LevelVertex> vertices() const;
    /// Where a window of this level has its origin for a place: shared by all windows, so that they fit into each other.
    [[nodiscard]] static hfh::Cell origin_for(const glm::dvec2& place, int level, int n) noexcept;

private:
    static constexpr int margin = 2; ///< vertices around the window, for slopes

    [[nodiscard]] float read(hfh::Index a, hfh::Index b) noexcept;
    [[nodiscard]] float at(int a, int b) const noexcept {
        return heights_[static_cast<std::size_t>(b + margin) * static_cast<std::size_t>(n_ + 2 * margin) +
                        static_cast<std::size_t>(a + margin)];
    }

    const DisplayedTerrain* terrain_;
    int level_, n_;
    hfh::Cell origin_{0, 0};
    bool filled_ = false;
    std::vector<float> heights_; ///< (n + 2·margin)²; NaN in holes
    std::uint64_t version_ = 0, samples_read_ = 0;
    long holes_ = 0;
};

} // namespace viewer

#endif // VIEWER_LEVEL_WINDOW_HPP
