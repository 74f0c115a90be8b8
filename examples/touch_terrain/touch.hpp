#ifndef TOUCH_TERRAIN_TOUCH_HPP
#define TOUCH_TERRAIN_TOUCH_HPP

#include <glm/ext/vector_double3.hpp>

namespace demo {

/// What one update felt, as the record has it. Metres and newtons, in double whatever the tracker computed in.
struct Touch {
    double t = 0;
    glm::dvec3 stylus{0.0}; ///< as the tracker saw it: with --float, rounded to float
    bool contact = false;
    glm::dvec3 proxy{0.0};
    glm::dvec3 normal{0.0};
    glm::dvec3 force{0.0}; ///< stiffness × (proxy − stylus), cut to what the device can give, if there is one
    int patches = 0;
    const char* status = "";
};

} // namespace demo

#endif // TOUCH_TERRAIN_TOUCH_HPP
