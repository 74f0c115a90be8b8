#include "touched_terrain.hpp"

#include "edits.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace viewer {
namespace {

HapticsSettings sized(HapticsSettings settings, const DisplayedTerrain& terrain) {
    settings.size = terrain.spacing * glm::dvec2{static_cast<double>(terrain.columns - 1),
                                                 static_cast<double>(terrain.rows - 1)};
    settings.cell = std::sqrt(terrain.spacing.x * terrain.spacing.y);
    return settings;
}

} // namespace

DisplayedTerrain displayed_terrain(const demo::Terrain& terrain, const hfh::GridFrame& frame) {
    return std::visit(
        [&]<class S>(const demo::Heights<S>& heights) -> DisplayedTerrain {
            const auto sample = [heights, frame](hfh::Index i, hfh::Index j) -> double {
                const S value =
                    load_sample(heights.data()[i * heights.column_stride() + j * heights.row_stride()]);
                const double height = frame.height_offset + frame.height_scale * static_cast<double>(value);
                const bool hole = heights.missing(value) || !hfh::is_height(height);
                return hole ? std::numeric_limits<double>::quiet_NaN() : height;
            };
            const double middle = sample(heights.columns() / 2, heights.rows() / 2);
            return {heights.columns(), heights.rows(), frame.spacing, std::isnan(middle) ? 0.0 : middle,
                    sample};
        },
        terrain.heights);
}

TouchedTerrain::TouchedTerrain(demo::Terrain read, const hfh::GridFrame& its_frame, HapticsSettings settings)
    : terrain{std::move(read)}, frame{its_frame}, displayed{displayed_terrain(terrain, frame)},
      ground{make_felt_ground(terrain, frame)}, haptics{*ground, sized(std::move(settings), displayed)} {}

} // namespace viewer
