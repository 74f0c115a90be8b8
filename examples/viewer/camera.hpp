#ifndef VIEWER_CAMERA_HPP
#define VIEWER_CAMERA_HPP

#include "hand_input.hpp"

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_double4x4.hpp>
#include <glm/ext/matrix_float4x4.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/ext/vector_int2.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace viewer {

/// The eye, which looks at a point in the hand's space: metres there, z up. Zooming is not the camera's: it makes the terrain
/// larger in the hand, and so before the eye.
struct Camera {
    glm::dvec3 target{0.0};
    double azimuth = 0;      ///< radians: to where the eye looks, clockwise from north
    double elevation = 0.8;  ///< radians above the horizon
    double distance = 0.235; ///< m
    double exaggeration = 1; ///< of heights, about the target's

    static constexpr double field_of_view = 0.6; ///< radians, from top to bottom

    void turn(double radians_right, double radians_up) noexcept {
        azimuth = std::remainder(azimuth + radians_right, 2 * std::numbers::pi);
        elevation = std::clamp(elevation + radians_up, 0.15, 0.5 * std::numbers::pi - 0.01);
    }

    /// Unit vectors in the hand's space: where the eye looks over the ground, and to its right.
    [[nodiscard]] glm::dvec2 ahead() const noexcept { return {std::sin(azimuth), std::cos(azimuth)}; }
    [[nodiscard]] glm::dvec2 right() const noexcept { return {std::cos(azimuth), -std::sin(azimuth)}; }

    [[nodiscard]] glm::dvec3 eye() const noexcept {
        return glm::dvec3{-ahead() * std::cos(elevation), std::sin(elevation)} * distance + target;
    }
    /// From the hand's space, heights exaggerated, to clip space.
    [[nodiscard]] glm::dmat4 matrix(const glm::ivec2& size) const noexcept {
        const double aspect = static_cast<double>(size.x) / static_cast<double>(std::max(1, size.y));
        const glm::dmat4 projection = glm::perspective(field_of_view, aspect, near(), far());
        const glm::dmat4 view = glm::lookAt(eye(), target, glm::dvec3{0, 0, 1});
        glm::dmat4 stretch = glm::translate(glm::dmat4{1.0}, target);
        stretch = glm::scale(stretch, {1, 1, exaggeration});
        stretch = glm::translate(stretch, -target);
        return projection * view * stretch;
    }
    [[nodiscard]] double near() const noexcept { return 0.08 * distance; }
    [[nodiscard]] double far() const noexcept { return 100 * distance; }

    /// The ray that is seen as the pixel at `pixel`, from the top left; in the hand's space.
    [[nodiscard]] PointerRay ray(const glm::dvec2& pixel, const glm::ivec2& size) const noexcept {
        const glm::dmat4 back = glm::inverse(matrix(size));
        const glm::dvec2 at{2 * pixel.x / size.x - 1, 1 - 2 * pixel.y / size.y};
        const glm::dvec4 a = back * glm::dvec4{at, -1, 1}, b = back * glm::dvec4{at, 1, 1};
        const glm::dvec3 from = glm::dvec3{a} / a.w, to = glm::dvec3{b} / b.w;
        return {from, glm::normalize(to - from)};
    }
    /// Where a point of the hand's space is seen, in pixels from the top left; and z from 0 to 1.
    [[nodiscard]] glm::dvec3 pixel(const glm::dvec3& point, const glm::ivec2& size) const noexcept {
        const glm::dvec4 at = matrix(size) * glm::dvec4{point, 1};
        return {(at.x / at.w + 1) / 2 * size.x, (1 - at.y / at.w) / 2 * size.y, (at.z / at.w + 1) / 2};
    }
    /// Metres of the hand that a pixel at the target's distance is wide.
    [[nodiscard]] double pixel_size(const glm::ivec2& size) const noexcept {
        return 2 * distance * std::tan(field_of_view / 2) / std::max(1, size.y);
    }
};

} // namespace viewer

#endif // VIEWER_CAMERA_HPP
