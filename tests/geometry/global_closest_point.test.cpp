#include "catch.hpp"
#include "support/hard_patches.hpp"

#include <hfh/geometry/global_closest_point.hpp>

#include <algorithm>

using namespace hfh::test;
using hfh::BilinearPatch;
using hfh::CellPoint;
using hfh::global_closest_point;
using hfh::GlobalStatus;

TEMPLATE_TEST_CASE("global_closest_point: is as near as a search finds, on every kind of patch",
                   "[global_closest_point][law][eq:8]", float, double) {
    using T = TestType;
    // The promise: not farther than the search by more than 1e-12 (float: 4e-6) of the largest length there is.
    const Wide promise = std::is_same_v<T, float> ? 4e-6L : 1e-12L;
    Random random{81};
    int certified = 0, searched = 0;
    for (int n = 0; n < 50000; ++n) {
        const auto c = hard_patch_case<T>(random);
        const auto found = global_closest_point(c.patch, c.query);
        const SeenPatch seen{c};
        const Wide distance = seen.distance(static_cast<Wide>(found.u), static_cast<Wide>(found.v));
        const Wide nearest = scanned_distance(seen), size = seen.size(nearest);
        certified += found.status == GlobalStatus::certified;
        searched += found.status == GlobalStatus::searched;
        if (distance - nearest > promise * size ||
            !(found.u >= 0 && found.u <= 1 && found.v >= 0 && found.v <= 1)) {
            CAPTURE(c.patch.p00, c.patch.p10, c.patch.p01, c.patch.p11, c.patch.spacing.x, c.patch.spacing.y);
            CAPTURE(c.query.u, c.query.v, c.query.z, found.u, found.v, int(found.status));
            REQUIRE(static_cast<double>((distance - nearest) / size) <= static_cast<double>(promise));
            REQUIRE((found.u >= 0 && found.u <= 1 && found.v >= 0 && found.v <= 1));
        }
    }
    CHECK(certified > 1000);
    CHECK(searched > 1000);
}

TEMPLATE_TEST_CASE("global_closest_point: on cliffs of up to a billion cells it is as near as a search finds",
                   "[global_closest_point][hard]", float, double) {
    // The gradient's own rounding hides far more there than that of the distance.
    using T = TestType;
    const Wide promise = 16 * static_cast<Wide>(std::numeric_limits<T>::epsilon());
    Random random{83};
    for (int n = 0; n < 10000; ++n) {
        const double top = power(random, 3, 9);
        const auto corner = [&] {
            return static_cast<T>(random.one_in(3)   ? 0
                                  : random.one_in(2) ? top * random.between(-1, 1)
                                                     : random.between(-1, 1) * power(random, 0, 9));
        };
        const PatchCase<T> c{
            {corner(), corner(), corner(), corner(), {T(random.one_in(2) ? 1 : power(random, -3, 3)), T(1)}},
            {T(random.one_in(3) ? 0 : random.between(-0.5, 1.5)),
             T(random.one_in(3) ? 0 : random.between(-0.5, 1.5)),
             random.one_in(3) ? corner() : T(random.between(-2, 2))}};
        const auto found = global_closest_point(c.patch, c.query);
        const SeenPatch seen{c};
        const Wide distance = seen.distance(static_cast<Wide>(found.u), static_cast<Wide>(found.v));
        const Wide nearest = scanned_distance(seen), size = seen.size(nearest);
        if (distance - nearest > promise * size) {
            CAPTURE(c.patch.p00, c.patch.p10, c.patch.p01, c.patch.p11, c.patch.spacing.x);
            CAPTURE(c.query.u, c.query.v, c.query.z, found.u, found.v, int(found.status));
            CAPTURE(static_cast<double>(distance), static_cast<double>(nearest));
            REQUIRE(static_cast<double>((distance - nearest) / size) <= static_cast<double>(promise));
        }
    }
}

TEMPLATE_TEST_CASE("global_closest_point: on the axis of a saddle either of two points will do",
                   "[global_closest_point][hard]", float, double) {
    // z = 8 (u − ½)(v − ½) − 2 …: four cells high over one cell, seen from its own axis beyond the focal length.
    using T = TestType;
    const BilinearPatch<T> saddle{T(2), T(-2), T(-2), T(2), {T(1), T(1)}};
    for (const T z : {T(0.01), T(0.125), T(1), T(10)}) {
        const PatchCase<T> c{saddle, {T(0.5), T(0.5), z}};
        const auto above = global_closest_point(saddle, c.query);
        const auto below = global_closest_point(saddle, CellPoint<T>{T(0.5), T(0.5), -z});
        const SeenPatch seen{c};
        const Wide there = seen.distance(static_cast<Wide>(above.u), static_cast<Wide>(above.v));
        CHECK(static_cast<double>(there) == Approx(static_cast<double>(scanned_distance(seen))));
        CHECK(std::abs(above.gap) == Approx(static_cast<double>(std::abs(below.gap))));
    }
}

TEMPLATE_TEST_CASE(
    "global_closest_point: certifies a shallow contact and never calls a saddle's far side nearest",
    "[global_closest_point]", float, double) {
    using T = TestType;
    const BilinearPatch<T> patch{T(0), T(0.5), T(0.25), T(1), {T(1), T(1)}};
    const auto shallow = global_closest_point(patch, CellPoint<T>{T(0.5), T(0.5), T(0.4)});
    CHECK(shallow.status == GlobalStatus::certified);
    CHECK(shallow.intervals == 0);
    const auto outside = global_closest_point(patch, CellPoint<T>{T(3), T(0.5), T(0.4)});
    CHECK(outside.status == GlobalStatus::searched);
    CHECK(outside.u == 1);
}
