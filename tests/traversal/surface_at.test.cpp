#include "catch.hpp"
#include "support/reference.hpp"
#include "support/scenes.hpp"

#include <hfh/traversal/surface_at.hpp>

using namespace hfh;
using namespace hfh::test;

TEMPLATE_TEST_CASE("surface_at: height and normal are those of the bilinear surface", "[surface_at]", float,
                   double) {
    using T = TestType;
    Random random{221};
    for (const auto& scene : scenes<T>()) {
        auto ground = scene.terrain;
        punch_holes(ground, 10, 222);
        const Surface<T> surface{ground};
        const auto grid = ground.grid();
        for (int n = 0; n < 200; ++n) {
            glm::dvec2 cells{random.between(-2, static_cast<double>(ground.columns) + 1),
                             random.between(-2, static_cast<double>(ground.rows) + 1)};
            if (random.one_in(4)) cells.x = std::round(cells.x);
            if (random.one_in(4)) cells.y = std::round(cells.y);
            const vec2<T> at{ground.frame.origin + cells * ground.frame.spacing};
            const Wide x = static_cast<Wide>(at.x), y = static_cast<Wide>(at.y);
            const auto found = surface_at(grid, at);
            const auto under = surface.under(x, y);
            INFO(scene.name << " at " << digits(at.x) << ' ' << digits(at.y));
            REQUIRE(found.has_value() == under.has_value());
            if (!found) continue;
            const Wide slack = 8 * surface.blur(*under, {x, y, 0}, static_cast<Wide>(epsilon<T>));
            CHECK(std::abs(static_cast<Wide>(found->height) - surface.position(*under).z) <= slack);
            CHECK(std::abs(length(wide(found->normal)) - 1) <= 4 * static_cast<Wide>(epsilon<T>));
            CHECK(found->normal.z > 0);
            const bool inside =
                under->u > 1e-3L && under->u < 1 - 1e-3L && under->v > 1e-3L && under->v < 1 - 1e-3L;
            if (inside) {
                CHECK(length(wide(found->normal) - surface.normal(*under)) <=
                      100 * static_cast<Wide>(epsilon<T>));
                CHECK_FALSE(found->on_rim);
            }
        }
    }
}

TEST_CASE("surface_at: there is ground up to the last grid line, however its coordinate was rounded",
          "[surface_at]") {
    for (const double dx : {0.1, 0.3, 1.0 / 49, 73.596}) {
        for (const double x0 : {0.0, -12345.678, 0.7}) {
            const auto ground =
                tilted_plane<double>(50, 30, 2, 1, 5, {.origin = {x0, -x0}, .spacing = {dx, dx}});
            const auto grid = ground.grid();
            for (const double x : {x0 + 49 * dx, x0 + (50 * dx - dx), (x0 / dx + 49) * dx, 49 * dx + x0}) {
                const auto found = surface_at(grid, glm::dvec2{x, -x0 + 3.5 * dx});
                REQUIRE(found);
                CHECK(found->height == Approx(5 + 2 * 49 + 3.5).epsilon(1e-12));
                CHECK(found->on_rim);
            }
            CHECK_FALSE(surface_at(grid, glm::dvec2{x0 + 49.001 * dx, -x0}));
            CHECK_FALSE(surface_at(grid, glm::dvec2{x0 - 0.001 * dx, -x0}));
        }
    }
    // In float the rounding of a coordinate is larger.
    const auto far = plane<float>(50, 30, 3, {.origin = {500000.3, 0}, .spacing = {0.7, 0.7}});
    CHECK(surface_at(far.grid(), glm::vec2{static_cast<float>(500000.3 + 49 * 0.7), 5}));
}

TEST_CASE("surface_at: the rim of a hole is ground, and what lies behind it is not", "[surface_at]") {
    auto ground = tilted_plane<double>(10, 10, 1, 0);
    ground.remove(5, 5); // the patches from 4 to 6
    const auto grid = ground.grid();
    for (const glm::dvec2 at :
         {glm::dvec2{4, 5}, glm::dvec2{6, 4.5}, glm::dvec2{5.25, 6}, glm::dvec2{4, 4}}) {
        const auto found = surface_at(grid, at);
        REQUIRE(found);
        CHECK(found->height == at.x);
        CHECK(found->normal.x == Approx(-std::sqrt(0.5)));
        CHECK(found->on_rim);
    }
    for (const glm::dvec2 at : {glm::dvec2{5, 5}, glm::dvec2{4.001, 5}, glm::dvec2{5.999, 4.5}})
        CHECK_FALSE(surface_at(grid, at));
    for (const double bad : {hidden_nan<double>(), hidden_infinity<double>(), 1e300, -1e300}) {
        CHECK_FALSE(surface_at(grid, glm::dvec2{bad, 3}));
        CHECK_FALSE(surface_at(grid, glm::dvec2{3, bad}));
    }
}

TEST_CASE("surface_at: where patches meet the normal is the mean of theirs, weighted by their angles",
          "[surface_at]") {
    const auto crest = ridge<double>(20, 20, 1);
    for (const glm::dvec2 at : {glm::dvec2{10, 5}, glm::dvec2{10, 5.5}}) {
        const auto found = surface_at(crest.grid(), at);
        REQUIRE(found);
        CHECK(found->normal.x == Approx(0).margin(1e-15));
        CHECK(found->normal.z == Approx(1));
        CHECK_FALSE(found->on_rim);
    }
    // At the middle of four patches, of which the one behind (1, 1) rises along both its edges: these stand at 60° there.
    auto ground = plane<double>(3, 3);
    ground.at(2, 1) = ground.at(1, 2) = 1;
    const auto found = surface_at(ground.grid(), glm::dvec2{1, 1});
    REQUIRE(found);
    const double sharp = 1.0471975511965976 / std::sqrt(3.0), right = 1.5707963267948966;
    glm::dvec3 mean{-sharp - right / std::sqrt(2.0), 0, sharp + 2 * right / std::sqrt(2.0) + right};
    mean.y = mean.x;
    mean = glm::normalize(mean);
    CHECK(found->normal.x == Approx(mean.x));
    CHECK(found->normal.y == Approx(mean.y));
    CHECK(found->normal.z == Approx(mean.z));
}
