#include "ground.hpp"

#include <hfh/terrain/bridged_field.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace demo {

Ground ground_of(const Terrain& terrain, const hfh::GridFrame& frame, hfh::Index bridge) {
    return std::visit(
        [&](const auto& heights) -> Ground {
            const hfh::BilinearGrid<double, std::remove_cvref_t<decltype(heights)>> grid{heights, frame};
            const hfh::Cell last{grid.cells().end.i - 1, grid.cells().end.j - 1};
            const glm::dvec2 cells{static_cast<double>(last.i + 1), static_cast<double>(last.j + 1)};

            const auto height = [grid, last, cells, bridge](glm::dvec2 at) -> double {
                constexpr double none = std::numeric_limits<double>::quiet_NaN();
                const double u = grid.lattice().u_of(at.x, 0), v = grid.lattice().v_of(at.y, 0);
                if (!(u >= 0 && u <= cells.x && v >= 0 && v <= cells.y)) return none;
                const hfh::Cell cell{std::min(static_cast<hfh::Index>(u), last.i),
                                     std::min(static_cast<hfh::Index>(v), last.j)};
                const auto patch = hfh::BridgedField{grid, bridge}.patch(cell);
                if (!patch) return none;
                return patch->height(u - static_cast<double>(cell.i), v - static_cast<double>(cell.j));
            };
            return {cells * frame.spacing, frame.spacing, height};
        },
        terrain.heights);
}

} // namespace demo
