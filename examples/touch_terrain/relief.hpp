#ifndef TOUCH_TERRAIN_RELIEF_HPP
#define TOUCH_TERRAIN_RELIEF_HPP

#include "ground.hpp"

#include <cstdint>
#include <vector>

namespace demo {

/// A rectangle of the terrain, metres.
struct Region {
    glm::dvec2 low{0.0};  ///< south-west
    glm::dvec2 high{1.0}; ///< north-east
    [[nodiscard]] glm::dvec2 size() const { return high - low; }
};

/// A picture in RGB bytes, south row first.
struct Raster {
    int columns = 0;
    int rows = 0;
    std::vector<std::uint8_t> rgb;
    double lowest = 0; ///< heights seen, metres; both 0 if there are none
    double highest = 0;
};

/// Shaded relief: height as tint, light from the north-west. Looks at a few heights a pixel, however large the
/// terrain is. Slopes are exaggerated, more where the ground is gentle, so that every terrain shows its forms.
[[nodiscard]] Raster shaded_relief(const Ground& ground, const Region& region, int columns, int rows);

} // namespace demo

#endif // TOUCH_TERRAIN_RELIEF_HPP
