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
    /// The drawn cell, as a patch, in which a cell of the finest level lies. At the far rims it may be narrower than others.
    [[nodiscard]] std::optional<hfh::BilinearPatch<double>> drawn_cell(hfh::Cell c) const noexcept {
        const int level = level_at(c);
        const hfh::Cell cell = cell_of(c, level);
        const double p00 = corner(level, cell.i, cell.j), p10 = corner(level, cell.i + 1, cell.j),
                     p01 = corner(level, cell.i, cell.j + 1), p11 = corner(level, cell.i + 1, cell.j + 1);
        if (std::isnan(p00 + p10 + p01 + p11)) return std::nullopt;
        const glm::dvec2 samples{place(cell.i + 1, level, terrain_->columns) - (cell.i << level),
                                 place(cell.j + 1, level, terrain_->rows) - (cell.j << level)};
        return hfh::BilinearPatch<double>{p00, p10, p01, p11, terrain_->spacing * samples};
    }
    [[nodiscard]] std::optional<hfh::BilinearPatch<double>> patch(hfh::Cell c) const noexcept {
        if (!cells_.contains(c)) return std::nullopt;
        const auto whole = drawn_cell(c);
        const int level = level_at(c);
        if (!whole || level == finest_) return whole;
        const hfh::Cell cell = cell_of(c, level);
        const glm::dvec2 part = lattice_.spacing() / whole->spacing;
        const double u = part.x * static_cast<double>(c.i - (cell.i << (level - finest_))),
                     v = part.y * static_cast<double>(c.j - (cell.j << (level - finest_)));
        return hfh::BilinearPatch<double>{whole->height(u, v), whole->height(u + part.x, v),
                                          whole->height(u, v + part.y), whole->height(u + part.x, v + part.y),
                                          lattice_.spacing()};
    }

private:
    [[nodiscard]] hfh::Cell cell_of(hfh::Cell finest, int level) const noexcept {
        return {finest.i >> (level - finest_), finest.j >> (level - finest_)};
    }
    /// The sample that a vertex lies on: the last one for those beyond it.
    [[nodiscard]] static hfh::Index place(hfh::Index vertex, int level, hfh::Index count) noexcept {
        return std::min(vertex << level, count - 1);
    }
    [[nodiscard]] double sample(int level, hfh::Index i, hfh::Index j) const {
        if (i < 0 || j < 0) return std::numeric_limits<double>::quiet_NaN();
        return terrain_->sample(place(i, level, terrain_->columns), place(j, level, terrain_->rows));
    }
    [[nodiscard]] double corner(int level, hfh::Index i, hfh::Index j) const {
        const double fine = sample(level, i, j);
        // How far vertices of the coarser level are: none for those on one, and for those beyond the rim, which all lie on it.
        const auto step = [&](hfh::Index vertex, hfh::Index count) {
            return vertex << level < count ? vertex & 1 : 0;
        };
        const hfh::Index di = step(i, terrain_->columns), dj = step(j, terrain_->rows);
        // The coarser level ends before the rim.
        if ((di != 0 && (i + 1) << level >= terrain_->columns) ||
            (dj != 0 && (j + 1) << level >= terrain_->rows))
            return fine;
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
