#ifndef TOUCH_TERRAIN_TOUCH_HPP
#define TOUCH_TERRAIN_TOUCH_HPP

#include <glm/ext/vector_double3.hpp>

namespace demo {

/// What one update felt, as the record has it. Metres and newtons, in double whatever the tracker computed in.
struct Touch {
    double t = 0;
    glm::dvec3 stylus{0.0}; ///< as the tracker saw it: with --float, rounded to float
    bool contact = false;
    glm::dvec3 proxy{0.0}; ///< of a ball its centre
    glm::dvec3 normal{0.0};
    glm::dvec3 force{0.0}; ///< as felt: with a device at the hand, after the guard
    int patches = 0;
    const char* status = ""; ///< of the contact
    const char* guard =
        ""; ///< what of it acted on the force: a trip, slewed, ramped, held_back or clamped, else none
};

} // namespace demo

#endif // TOUCH_TERRAIN_TOUCH_HPP
