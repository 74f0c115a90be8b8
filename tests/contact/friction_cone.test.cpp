#include "catch.hpp"
#include "support/scenes.hpp"

#include <hfh/contact/friction_cone.hpp>

#include <initializer_list>
#include <utility>

using namespace hfh;
using namespace hfh::test;

namespace {

/// The smallest of |offset × n| − coefficient·(offset·n) over normals n that lean as the samples say: 400 by 400.
double search(const glm::dvec3& offset, const glm::dvec2& low, const glm::dvec2& high, double coefficient,
              double sign) {
    double least = std::numeric_limits<double>::infinity();
    for (int b = 0; b <= 400; ++b) {
        for (int a = 0; a <= 400; ++a) {
            const glm::dvec2 s = low + (high - low) * glm::dvec2{a / 400.0, b / 400.0};
            const glm::dvec3 n = sign * glm::normalize(glm::dvec3{-s.x, -s.y, 1});
            const double out = glm::dot(offset, n);
            if (out <= 0) continue;
            least = std::min(least, glm::length(glm::cross(offset, n)) - coefficient * out);
        }
    }
    return least;
}

} // namespace

TEMPLATE_TEST_CASE("friction_cone: within a cell it is that of the patch's normal", "[friction_cone]", float,
                   double) {
    using T = TestType;
    const auto ground = tilted_plane<T>(5, 5, 0.75, 0);
    const auto grid = ground.grid();
    const auto patch = *grid.patch({1, 1});
    // At (1.5, 1.5), normal (−3, 0, 4)/5: a stylus 5/8 down the normal and 1/4 across, along y.
    const vec3<T> stylus{T(1.5) + T(0.375), T(1.75), T(1.125) - T(0.5)};
    for (const auto side : {Side::above, Side::below}) {
        const auto cone =
            friction_cone(grid, patch, grid.lattice().locate(stylus, {1, 1}), {{1, 1}, T(0.5), T(0.5)}, side);
        const T sign = side == Side::below ? T(-1) : T(1);
        CHECK(glm::length(cone.offset - vec3<T>{T(-0.375), T(-0.25), T(0.5)}) <= 4 * epsilon<T>);
        CHECK(glm::length(cone.normal - sign * vec3<T>{T(-0.6), T(0), T(0.8)}) <= 4 * epsilon<T>);
        if (side == Side::above) {
            CHECK(cone.outside(T(0.25)) == Approx(0.25 - 0.25 * 0.625).margin(8 * double(epsilon<T>)));
            CHECK(cone.outside(T(0.4375)) < 0);
            CHECK(cone.outside(T(0.375)) > 0);
        } else {
            CHECK(cone.outside(T(100)) > 0); // on the wrong side
        }
    }
}

TEMPLATE_TEST_CASE("friction_cone: a stylus in front of the surface is outside, whatever the coefficient",
                   "[friction_cone]", float, double) {
    using T = TestType;
    const auto ground = plane<T>(3, 3);
    const auto grid = ground.grid();
    const auto patch = *grid.patch({0, 0});
    for (const T coefficient : {T(0), T(0.5)}) {
        for (const auto side : {Side::above, Side::below}) {
            const auto outside = [&](T z) {
                return FrictionCone<T>{patch, {T(0.5), T(0.5), z}, T(0.5), T(0.5), side}.outside(coefficient);
            };
            const T front = side == Side::above ? T(1) : T(-1);
            CHECK(outside(front) == 1); // as far as it is in front
            CHECK(outside(-front) == -coefficient);
        }
    }
}

/// The least and the greatest slopes, along x and along y, of the patches that meet at (u, v) of cell c, from the samples.
template <Real T>
std::pair<glm::dvec2, glm::dvec2> slopes_there(const Terrain<T>& ground, Cell c, T u, T v) {
    glm::dvec2 low{1e9}, high{-1e9};
    for (int dj = -1; dj <= 1; ++dj) {
        for (int di = -1; di <= 1; ++di) {
            const double x = double(u) - di, y = double(v) - dj;
            if (x < 0 || x > 1 || y < 0 || y > 1) continue;
            const auto z = [&](int a, int b) { return double(ground.at(c.i + di + a, c.j + dj + b)); };
            const glm::dvec2 s{(1 - y) * (z(1, 0) - z(0, 0)) + y * (z(1, 1) - z(0, 1)),
                               (1 - x) * (z(0, 1) - z(0, 0)) + x * (z(1, 1) - z(1, 0))};
            low = glm::min(low, s);
            high = glm::max(high, s);
        }
    }
    return {low, high};
}

TEMPLATE_TEST_CASE("friction_cone: in a crease it takes the nearest of all normals between, by search",
                   "[friction_cone][law]", float, double) {
    using T = TestType;
    Random random{97};
    int within = 0, beyond = 0;
    for (const double relief : {0.3, 2.0, 20.0}) {
        const auto ground = rough_in_steps<T>(12, 12, relief, 98);
        const auto grid = ground.grid();
        for (int n = 0; n < 60; ++n) {
            const Cell c{random.whole(1, 9), random.whole(1, 9)};
            const auto patch = *grid.patch(c);
            // A side, or a corner, of the cell; every fourth point is on a side along x, every fourth on one along y.
            const T u = n % 4 == 1 ? static_cast<T>(random.unit()) : T(random.whole(0, 1));
            const T v = n % 4 == 2 ? static_cast<T>(random.unit()) : T(random.whole(0, 1));
            const vec3<T> at{static_cast<T>(c.i) + u, static_cast<T>(c.j) + v, patch.height(u, v)};
            const Side side = n % 3 == 0 ? Side::below : Side::above;
            const double sign = side == Side::below ? -1 : 1;
            const vec3<T> stylus = at - vec3<T>{static_cast<T>(random.between(-1, 1) * relief),
                                                static_cast<T>(random.between(-1, 1) * relief),
                                                static_cast<T>(sign * random.between(0, 1))};
            const auto cone = friction_cone(grid, patch, grid.lattice().locate(stylus, c), {c, u, v}, side);
            const auto [low, high] = slopes_there(ground, c, u, v);
            const glm::dvec3 offset{at - stylus};
            for (const double coefficient : {0.1, 1.0}) {
                const double wanted = search(offset, low, high, coefficient, sign);
                const double found = double(cone.outside(static_cast<T>(coefficient)));
                const double size = glm::length(offset), step = glm::length(high - low) / 400;
                CAPTURE(relief, n, double(u), double(v), coefficient, wanted, found);
                if (!(wanted < size * 1e3)) { // no normal has the stylus behind it
                    CHECK(found > 0);
                    continue;
                }
                ++(found <= 0 ? within : beyond);
                CHECK(found <= wanted + 64 * double(epsilon<T>) * (size + relief));
                CHECK(found >= wanted - (1 + coefficient) * size * step - 64 * double(epsilon<T>) * relief);
            }
        }
    }
    CHECK(within > 40);
    CHECK(beyond > 40);
}

TEMPLATE_TEST_CASE(
    "friction_cone: creases count only where they are asked for, a missing neighbour makes none",
    "[friction_cone]", float, double) {
    using T = TestType;
    auto ground = valley<T>(9, 9, 1);
    const auto grid = ground.grid();
    const auto patch = *grid.patch({4, 4});
    const vec3<T> stylus{T(4), T(4.5), ground.at(4, 4) - T(0.5)};
    const auto cone = [&](const glm::bvec2& creases) {
        return friction_cone(grid, patch, grid.lattice().locate(stylus, {4, 4}), {{4, 4}, T(0), T(0.5)},
                             Side::above, creases);
    };
    REQUIRE(patch.p10 == patch.p00 + T(1)); // the eastern side of a valley along y
    CHECK(cone({true, true}).normal == vec3<T>{T(0), T(0), T(1)});
    CHECK(cone({true, false}).normal == vec3<T>{T(0), T(0), T(1)});
    CHECK(cone({false, true}).normal == patch.normal(T(0), T(0.5)));
    CHECK(cone({true, true}).outside(T(0.01)) < 0);
    ground.remove(3, 4);
    CHECK(cone({true, true}).normal == patch.normal(T(0), T(0.5)));

    const auto across = terrain<T>(9, 9, [](Index, Index j) { return std::abs(double(j) - 4); });
    const auto turned = across.grid(); // by a right angle
    const auto north = *turned.patch({4, 4});
    const auto turned_cone = [&](const glm::bvec2& creases) {
        return friction_cone(turned, north, {T(0.5), T(0), T(-0.5)}, {{4, 4}, T(0.5), T(0)}, Side::above,
                             creases);
    };
    CHECK(turned_cone({false, true}).normal == vec3<T>{T(0), T(0), T(1)});
    CHECK(turned_cone({true, false}).normal == north.normal(T(0.5), T(0)));
}

TEMPLATE_TEST_CASE("friction_cone: beside a slope that has no square the patch's own normal holds",
                   "[friction_cone][hard]", float, double) {
    using T = TestType;
    // The edge of a plateau; the stylus is above it, so in no cone.
    constexpr T most = std::numeric_limits<T>::max();
    for (const T deep : {std::sqrt(most) * 4, most}) {
        auto ground =
            terrain<T>(5, 5, [=](Index i, Index) { return i < 2 ? -static_cast<double>(deep) : 0.0; });
        ground.frame.spacing = {0.5, 0.5};
        const auto grid = ground.grid();
        const auto patch = *grid.patch({2, 2});
        const auto cone =
            friction_cone(grid, patch, {T(0.25), T(0.25), T(1)}, {{2, 2}, T(0), T(0.5)}, Side::above);
        CHECK(cone.normal == vec3<T>{T(0), T(0), T(1)});
        CHECK(cone.outside(T(1)) > 0);
    }
}
