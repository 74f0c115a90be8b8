#include "catch.hpp"

#include <camera.hpp>
#include <quantities.hpp>

#include <glm/geometric.hpp>

TEST_CASE("a ray through the pixel of a point goes through the point", "[camera]") {
    viewer::Camera camera;
    camera.target = {0.01, -0.02, 0.005};
    const glm::ivec2 size{800, 500};
    for (const double exaggeration : {1.0, 2.5}) {
        camera.exaggeration = exaggeration;
        camera.turn(0.4, -0.2);
        for (const glm::dvec3& point : {glm::dvec3{0, 0, 0}, {0.05, 0.03, 0.01}, {-0.04, 0.02, -0.02}}) {
            const glm::dvec3 at = camera.pixel(point, size);
            const viewer::PointerRay ray = camera.ray({at.x, at.y}, size);
            CHECK(glm::length(glm::cross(point - ray.from, ray.direction)) < 1e-9);
        }
    }
}

TEST_CASE("lengths are told with their units", "[camera]") {
    CHECK(viewer::length_text(1234.5, false, 5) == "1234.5 m");
    CHECK(viewer::length_text(12345, false) == "12.3 km");
    CHECK(viewer::length_text(0.0021, false) == "2.1 mm");
    CHECK(viewer::length_text(1000, true) == "3281 ft");
    CHECK(viewer::length_text(0, false) == "0 m");
    CHECK(viewer::round_number(0.0073) == Approx(0.005));
    CHECK(viewer::round_number(2100) == Approx(2000));
}
