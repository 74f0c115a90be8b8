#ifndef TOUCH_TERRAIN_GROUND_HPP
#define TOUCH_TERRAIN_GROUND_HPP

#include "terrain.hpp"

#include <hfh/terrain/bilinear_grid.hpp>

#include <functional>

namespace demo {

/// The terrain for those who only ask for heights: the built-in stroke and the picture.
struct Ground {
    glm::dvec2 size{0.0};                     ///< metres from the south-west sample to the north-east one
    glm::dvec2 cell{1.0};                     ///< metres between samples
    std::function<double(glm::dvec2)> height; ///< metres; NaN in holes and beyond the border
};

/// `terrain` must outlive what is returned. Holes up to `bridge` cells wide are spanned.
[[nodiscard]] Ground ground_of(const Terrain& terrain, const hfh::GridFrame& frame, hfh::Index bridge = 0);

} // namespace demo

#endif // TOUCH_TERRAIN_GROUND_HPP
