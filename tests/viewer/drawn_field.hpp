#ifndef HFH_TESTS_VIEWER_DRAWN_FIELD_HPP
#define HFH_TESTS_VIEWER_DRAWN_FIELD_HPP

#include <viewer.hpp>

#include <hfh/terrain/height_field.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

// What a display of nested windows has to look like, as a height field, computed from the samples alone: of the library's own
// formula for a blend of levels, with the α of each vertex.

namespace viewer_tests {

class DrawnField {
public:
    using Scalar = double;

    DrawnField(const viewer::Viewer& shown, const viewer::DisplayedTerrain& terrain)
        : terrain_{&terrain}, levels_{shown.levels()}, drawer_{&shown.terrain_drawer()},
          hand_level_{shown.view().level}, n_{127} {
        const int wanted = static_cast<int>(std::floor(hand_level_));
        finest_ = std::clamp(wanted, levels_->levels.front()->level, levels_->levels.back()->level);
        const double step = std::exp2(finest_);
        lattice_ = {{0, 0}, terrain.spacing * step};
        cells_.end = {(terrain.columns - 1) >> finest_, (terrain.rows - 1) >> finest_};
    }

    [[nodiscard]] hfh::Lattice lattice() const noexcept { return lattice_; }
    [[nodiscard]] hfh::CellRange cells() const noexcept { return cells_; }

    /// The level of the window in which a cell of the finest one is drawn.
    [[nodiscard]] int level_at(hfh::Cell c) const noexcept {
        for (const auto& window : levels_->levels) {
            if (window->level < finest_) continue;
            const int by = window->level - finest_;
            const hfh::Index i = (c.i >> by) - window->origin.i, j = (c.j >> by) - window->origin.j;
            if (0 <= i && i < n_ - 1 && 0 <= j && j < n_ - 1) return window->level;
        }
        return levels_->levels.back()->level;
    }
    /// The drawn cell, as a patch, in which a cell of the finest level lies; none where it is cut by the terrain's border.
    [[nodiscard]] std::optional<hfh::BilinearPatch<double>> drawn_cell(hfh::Cell c) const noexcept {
        const int level = level_at(c), by = level - finest_;
        const hfh::Cell cell{c.i >> by, c.j >> by};
        if (((cell.i + 1) << level) >= terrain_->columns || ((cell.j + 1) << level) >= terrain_->rows)
            return std::nullopt;
        const double p00 = corner(level, cell.i, cell.j), p10 = corner(level, cell.i + 1, cell.j),
                     p01 = corner(level, cell.i, cell.j + 1), p11 = corner(level, cell.i + 1, cell.j + 1);
        if (std::isnan(p00 + p10 + p01 + p11)) return std::nullopt;
        return hfh::BilinearPatch<double>{p00, p10, p01, p11, terrain_->spacing * std::exp2(level)};
    }
    [[nodiscard]] std::optional<hfh::BilinearPatch<double>> patch(hfh::Cell c) const noexcept {
        if (!cells_.contains(c)) return std::nullopt;
        const auto whole = drawn_cell(c);
        if (!whole) return std::nullopt;
        const int by = level_at(c) - finest_;
        if (by == 0) return whole;
        const double part = std::exp2(-by);
        const double u = part * static_cast<double>(c.i - ((c.i >> by) << by)),
                     v = part * static_cast<double>(c.j - ((c.j >> by) << by));
        return hfh::BilinearPatch<double>{whole->height(u, v), whole->height(u + part, v),
                                          whole->height(u, v + part), whole->height(u + part, v + part),
                                          lattice_.spacing()};
    }
    /// Where a cell is cut by the border of the terrain, and so is drawn narrower than this field has it.
    [[nodiscard]] bool is_at_border(hfh::Cell c) const noexcept {
        const int level = level_at(c), by = level - finest_;
        return (((c.i >> by) + 1) << level) >= terrain_->columns ||
               (((c.j >> by) + 1) << level) >= terrain_->rows;
    }

private:
    [[nodiscard]] double sample(int level, hfh::Index i, hfh::Index j) const {
        i <<= level;
        j <<= level;
        if (i < 0 || j < 0 || i >= terrain_->columns || j >= terrain_->rows)
            return std::numeric_limits<double>::quiet_NaN();
        return terrain_->sample(i, j);
    }
    [[nodiscard]] double corner(int level, hfh::Index i, hfh::Index j) const {
        const double fine = sample(level, i, j);
        const hfh::Index di = i & 1, dj = j & 1;
        const double coarse = (sample(level, i - di, j - dj) + sample(level, i + di, j - dj) +
                               sample(level, i - di, j + dj) + sample(level, i + di, j + dj)) /
                              4;
        if (std::isnan(coarse)) return fine;
        const glm::dvec2 middle = levels_->place / std::exp2(level);
        const double alpha =
            drawer_->blend(*levels_, level,
                           glm::dvec2{static_cast<double>(i), static_cast<double>(j)} - middle, hand_level_);
        return (1 - alpha) * fine + alpha * coarse;
    }

    const viewer::DisplayedTerrain* terrain_;
    std::shared_ptr<const viewer::LoadedLevels> levels_;
    const viewer::TerrainDrawer* drawer_;
    double hand_level_;
    int n_, finest_ = 0;
    hfh::Lattice lattice_;
    hfh::CellRange cells_{};
};

} // namespace viewer_tests

#endif // HFH_TESTS_VIEWER_DRAWN_FIELD_HPP
