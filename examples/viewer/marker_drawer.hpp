#ifndef VIEWER_MARKER_DRAWER_HPP
#define VIEWER_MARKER_DRAWER_HPP

#include "camera.hpp"
#include "gl_objects.hpp"

#include <array>
#include <vector>

namespace viewer {

/// Colours of Okabe and Ito, which colour-blind eyes tell apart. Shapes differ too.
namespace colours {
inline constexpr glm::vec3 stylus{0.00f, 0.45f, 0.70f};
inline constexpr glm::vec3 proxy{0.94f, 0.89f, 0.26f};
inline constexpr glm::vec3 force{0.84f, 0.37f, 0.00f};
inline constexpr glm::vec3 wanted{0.95f, 0.95f, 0.95f};
} // namespace colours

/// What is drawn of a touch; m in the hand's space.
struct TouchMarkers {
    glm::dvec3 stylus{0.0};
    glm::dvec3 proxy{0.0};
    glm::dvec3 normal{0, 0, 1};
    glm::dvec3 wanted{0.0}; ///< where the hand wants to be
    glm::dvec3 newtons{0.0};
    bool touching = false;
    bool over_ground = false;
    double pixel =
        1; ///< how many pixels of the framebuffer a pixel of the markers is: more in large pictures
};

/// Draws the stylus as a pen whose tip is the device's point, the proxy as a ball, the penetration as a thin line between
/// them, and the force as an arrow of 14 mm a newton. All have the same size on the screen at any zoom. What is below the ground is seen through it,
/// paler.
class MarkerDrawer {
public:
    MarkerDrawer();
    void draw(const TouchMarkers& touch, const Camera& camera, const glm::ivec2& size);

    static constexpr double metres_per_newton = 14e-3; ///< m at the hand
    static constexpr double proxy_radius = 6;          ///< pixels

private:
    /// A surface of revolution about z.
    struct Shape {
        GlVertexArray array;
        GlBuffer vertices;
        GLsizei count = 0;
    };
    struct Item {
        const Shape* shape;
        glm::dvec3 at;        ///< m in the hand's space, heights not exaggerated
        glm::dvec3 direction; ///< of its z, unit
        double radius;        ///< m
        double length;        ///< m
        glm::vec3 colour;
        bool through_ground;
    };

    static Shape lathe(const std::vector<glm::dvec2>& profile);
    void draw_items(const std::vector<Item>& items, const Camera& camera, const glm::ivec2& size,
                    float outline, float alpha);

    GlProgram program_;
    Shape ball_, cylinder_, cone_, pen_, ring_;
};

} // namespace viewer

#endif // VIEWER_MARKER_DRAWER_HPP
