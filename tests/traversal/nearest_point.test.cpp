#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/counting_field.hpp"
#include "support/hard_ground.hpp"
#include "support/nearest_judge.hpp"
#include "support/real_terrains.hpp"
#include "support/scenes.hpp"

#include <hfh/terrain/extended_field.hpp>
#include <hfh/terrain/min_max_pyramid.hpp>
#include <hfh/traversal/nearest_point.hpp>

#include <vector>

using namespace hfh;
using namespace hfh::test;

namespace {

constexpr Index no_limit = Index{1} << 40;

/// A terrain with bounds.
template <Real T>
struct WithBounds {
    explicit WithBounds(const Terrain<T>& ground)
        : storage(static_cast<std::size_t>(MinMaxPyramid<T>::size(ground.columns, ground.rows))),
          field{ground.grid(), storage.data(), static_cast<Index>(storage.size())} {
        field.build();
    }
    std::vector<SampleRange<T>> storage;
    BoundedGrid<T, HeightView<T>> field;
};

/// Queries of all kinds, with bounds and without, with a limit to the distance and without.
template <Real T>
void judge(const char* name, const Terrain<T>& ground, Random& random, int count, double farthest = 100) {
    const auto grid = ground.grid();
    const WithBounds<T> bounded{ground};
    const NearestJudge<T> judge{ground};
    for (int n = 0; n < count; ++n) {
        const auto query = nearest_query(random, ground, farthest);
        NearestOptions<T> options{.max_work = no_limit};
        if (random.one_in(4))
            options.max_distance =
                static_cast<T>(ground.frame.spacing.x * std::pow(10, random.between(-6, 2)));
        for (const bool with_bounds : {false, true}) {
            const auto found = with_bounds ? nearest_point(bounded.field, query, options)
                                           : nearest_point(grid, query, options);
            const auto verdict = judge(query, static_cast<Wide>(options.max_distance), found);
            INFO(name << ": query " << digits(query) << ", within " << digits(options.max_distance)
                      << (with_bounds ? ", with bounds" : ""));
            CHECK(verdict.fault == "");
        }
    }
}

} // namespace

TEMPLATE_TEST_CASE("nearest_point: nothing on any patch is nearer, on every kind of terrain",
                   "[nearest_point]", float, double) {
    Random random{201};
    for (const auto& scene : scenes<TestType>()) {
        judge(scene.name, scene.terrain, random, 60);
        auto holed = scene.terrain;
        punch_holes(holed, 8, 202);
        judge(scene.name, holed, random, 60);
    }
}

TEMPLATE_TEST_CASE("nearest_point: nothing on any patch is nearer, on hard ground", "[nearest_point]", float,
                   double) {
    Random random{203};
    for (int n = 0; n < 440; ++n) {
        // All kinds but heights of every size, which are too far from one another to be told by distances.
        const auto kind = static_cast<HardGround>(n % (hard_grounds - 1));
        judge("hard", hard_ground<TestType>(kind, random), random, 10);
    }
}

TEMPLATE_TEST_CASE("nearest_point: nothing on any patch is nearer, on real terrains", "[nearest_point]",
                   float, double) {
    Random random{204};
    auto names = real_terrains_without_holes;
    names.insert(names.end(), real_terrains_with_holes.begin(), real_terrains_with_holes.end());
    on_real_terrains_or_skip<TestType>(names, [&](const std::string& name, const Terrain<TestType>& ground) {
        judge(name.c_str(), ground, random, 40, 50);
    });
}

TEMPLATE_TEST_CASE("nearest_point: over a plane it is the foot of the perpendicular", "[nearest_point]",
                   float, double) {
    using T = TestType;
    const auto ground = tilted_plane<T>(20, 20, 0.75, 0); // normal (−0.6, 0, 0.8)
    for (const T deep : {T(-2), T(-0.5), T(0.5), T(2)}) {
        // From the surface point (8, 10.25, 6) along the normal.
        const vec3<T> query{T(8) + deep * T(0.6), T(10.25), T(6) - deep * T(0.8)};
        const auto found = nearest_point(ground.grid(), query);
        REQUIRE(found.status == NearestStatus::found);
        CHECK(found.distance == Approx(std::abs(deep)));
        CHECK(*found.signed_distance() == Approx(-deep));
        CHECK(found.side == (deep > 0 ? Side::below : Side::above));
        CHECK(found.position.x == Approx(8));
        CHECK(found.position.y == Approx(10.25));
        CHECK(found.position.z == Approx(6));
        CHECK(found.normal.x == Approx(-0.6));
        CHECK(found.normal.z == Approx(0.8));
    }
}

TEST_CASE("nearest_point: it is the nearest of all, not the one that a proxy would slide to",
          "[nearest_point]") {
    // Level ground with a peak beside a query that hovers: the way down from below the query leads away from the peak.
    auto ground = plane<double>(20, 20);
    ground.at(10, 10) = 8;
    const glm::dvec3 query{8.5, 10, 4};
    const auto found = nearest_point(ground.grid(), query);
    REQUIRE(found.status == NearestStatus::found);
    CHECK(found.distance < 1.1);
    CHECK(found.position.z > 3);
}

TEST_CASE(
    "nearest_point: a patch bent more sharply than the query is far has two equal answers and gives one",
    "[nearest_point]") {
    // One patch, z = 4·(x − ½)(y − ½), and a query over its middle: the surface rises towards it to both sides.
    const auto ground = terrain<double>(2, 2, [](Index i, Index j) { return i == j ? 1.0 : -1.0; });
    const glm::dvec3 query{0.5, 0.5, 0.75};
    const auto found = nearest_point(ground.grid(), query);
    REQUIRE(found.status == NearestStatus::found);
    const NearestJudge<double> judge{ground};
    CHECK(judge(query, std::numeric_limits<Wide>::infinity(), found).fault == "");
    // x² + y² + (4xy − ¾)² with x = y: 16 s² = 4·¾ − 1.
    CHECK(std::abs(found.position.x - 0.5) == Approx(std::sqrt(2.0 / 16)));
    CHECK(found.position.x == Approx(found.position.y));
}

TEST_CASE("nearest_point: very near to the medial axis, where Newton's method stops early, it is right all "
          "the same",
          "[nearest_point][hard]") {
    // Three corners of a terrace and one below it, and a query beside the axis, which stands on the corner opposite.
    const auto ground = terrain<double>(2, 2, [](Index i, Index j) { return i + j == 0 ? 0 : 0.75; },
                                        {.spacing = {1, 0.125}});
    const NearestJudge<double> judge{ground};
    for (const double z : {0.58125, 0.5765625, 0.571875, 0.5671875}) {
        for (const double beside : {0.0, 1e-12, 1e-9, 1e-8}) {
            const glm::dvec3 query{1 - beside, 0.125, z};
            const auto found = nearest_point(ground.grid(), query);
            CHECK(judge(query, std::numeric_limits<Wide>::infinity(), found).fault == "");
        }
    }
}

TEST_CASE("nearest_point: beside the grid and over a hole a rim is nearest and leaves no side",
          "[nearest_point]") {
    auto ground = plane<double>(20, 20, 1);
    ground.remove(10, 10);
    const auto grid = ground.grid();
    for (const glm::dvec3 query :
         {glm::dvec3{-2, 5.5, 3}, glm::dvec3{9.5, 10, 1.5}, glm::dvec3{25, 25, -4}}) {
        const auto found = nearest_point(grid, query);
        REQUIRE(found.status == NearestStatus::found);
        CHECK(found.side == Side::none);
        CHECK_FALSE(found.signed_distance());
    }
    CHECK(nearest_point(grid, {-2, 5.5, 3}).distance == Approx(std::sqrt(8.0)));
    CHECK(nearest_point(grid, {9.5, 10, 1.5}).distance == Approx(std::sqrt(0.5)));
    // Beside the rim, but over the ground: it has a side.
    CHECK(*nearest_point(grid, {0, 5.5, 3}).signed_distance() == Approx(2));
    CHECK(*nearest_point(grid, {19, 19, 0}).signed_distance() == Approx(-1));
}

TEST_CASE("nearest_point: beside a slope that faces it a query has the side of the slope",
          "[nearest_point]") {
    // Beside the rim of ground that falls towards it, the nearest point is inside the slope.
    const auto ground = tilted_plane<double>(20, 20, 1, 0);
    const auto above = nearest_point(ground.grid(), {-1, 10.5, 3.5}),
               below = nearest_point(ground.grid(), {20, 10.5, 16.5});
    CHECK(above.side == Side::above);
    CHECK_FALSE(on_border(above.point));
    CHECK_FALSE(on_border(below.point));
    CHECK(below.side == Side::below);
}

TEST_CASE("nearest_point: the side at a crest and in a pit is that of the ground over or under the query",
          "[nearest_point]") {
    const auto crest = ridge<double>(20, 20, 3), trough = valley<double>(20, 20, 3);
    for (const double x : {9.9, 10.0, 10.1}) {
        CHECK(nearest_point(crest.grid(), {x, 5.5, 1}).side == Side::above);
        CHECK(nearest_point(crest.grid(), {x, 5.5, -1}).side == Side::below);
        CHECK(nearest_point(trough.grid(), {x, 5.5, 1}).side == Side::above);
        CHECK(nearest_point(trough.grid(), {x, 5.5, -1}).side == Side::below);
    }
}

TEMPLATE_TEST_CASE("nearest_point: max_distance decides between found and none within", "[nearest_point]",
                   float, double) {
    using T = TestType;
    const auto ground = plane<T>(20, 20, 1);
    const auto grid = ground.grid();
    const vec3<T> query{T(10.25), T(7.5), T(4)};
    CHECK(nearest_point(grid, query, {.max_distance = T(3)}).status == NearestStatus::found);
    CHECK(nearest_point(grid, query, {.max_distance = T(3) * (1 - 8 * epsilon<T>)}).status ==
          NearestStatus::none_within);
    const auto none = nearest_point(grid, query, {.max_distance = T(1)});
    CHECK_FALSE(none.has_point());
    CHECK_FALSE(none.signed_distance());
    CHECK(none.side == Side::none);
    CHECK(nearest_point(grid, {T(10.25), T(7.5), T(1)}, {.max_distance = T(0)}).status ==
          NearestStatus::found);
    CHECK(nearest_point(grid, query, {.max_distance = T(0)}).status == NearestStatus::none_within);
}

TEMPLATE_TEST_CASE("nearest_point: bad input is refused and says so", "[nearest_point]", float, double) {
    using T = TestType;
    const auto ground = plane<T>(20, 20, 1);
    const auto grid = ground.grid();
    const vec3<T> good{T(10), T(10), T(3)};
    for (const T bad : {hidden_nan<T>(), hidden_infinity<T>(), -hidden_infinity<T>(), no_height_from<T>}) {
        for (int axis = 0; axis < 3; ++axis) {
            vec3<T> query = good;
            query[axis] = bad;
            const auto found = nearest_point(grid, query);
            CHECK(found.status == NearestStatus::bad_query);
            CHECK_FALSE(found.has_point());
        }
    }
    CHECK(nearest_point(grid, good, {.max_distance = hidden_nan<T>()}).status == NearestStatus::bad_query);
    CHECK(nearest_point(grid, good, {.max_distance = T(-1)}).status == NearestStatus::bad_query);
    CHECK(nearest_point(grid, good, {.max_distance = -hidden_infinity<T>()}).status ==
          NearestStatus::bad_query);
    // As far as a query can be.
    const T far = std::nextafter(no_height_from<T>, T(0));
    for (const vec3<T> query :
         {vec3<T>{far, T(10), T(3)}, vec3<T>{-far, far, -far}, vec3<T>{T(10), T(10), far}})
        CHECK(nearest_point(grid, query).status == NearestStatus::found);
}

TEST_CASE("nearest_point: where there is no patch there is no point", "[nearest_point]") {
    auto ground = plane<double>(9, 9, 1);
    for (auto& height : ground.heights) height = hidden_nan<double>();
    CHECK(nearest_point(ground.grid(), {4, 4, 3}).status == NearestStatus::none_within);
    CHECK(nearest_point(WithBounds<double>{ground}.field, {4, 4, 3}).status == NearestStatus::none_within);
    const auto line = plane<double>(9, 1, 1);
    CHECK(nearest_point(line.grid(), {4, 0, 3}).status == NearestStatus::none_within);
    ground.at(3, 4) = ground.at(4, 4) = ground.at(3, 5) = ground.at(4, 5) = 2;
    const auto found = nearest_point(ground.grid(), {0, 0, 2});
    CHECK(found.status == NearestStatus::found);
    CHECK(found.distance == Approx(5));
    CHECK(found.point.cell == Cell{3, 4});
}

TEST_CASE("nearest_point: it ends after max_work cells and blocks and says so", "[nearest_point]") {
    const auto ground = rough_in_steps<double>(200, 200, 4, 205);
    const auto grid = ground.grid();
    CountingField counting{grid};
    const WithBounds<double> bounded{ground};
    const glm::dvec3 query{100.3, 99.6, 60};
    const auto whole = nearest_point(ground.grid(), query);
    REQUIRE(whole.status == NearestStatus::found);
    for (const Index limit : {Index{-5}, Index{0}, Index{1}, Index{7}, Index{100}, Index{1000}}) {
        counting.forget_looks();
        const auto cut = nearest_point(counting, query, {.max_work = limit});
        CHECK(cut.status == NearestStatus::work_limit);
        CHECK(cut.has_point());
        CHECK(cut.distance >= whole.distance);
        CHECK(counting.looks() <= std::max<Index>(limit, 0) + 10);
        CHECK(cut.work <= std::max<Index>(limit, 0));
    }
    const auto by_blocks = nearest_point(bounded.field, query);
    CHECK(by_blocks.status == NearestStatus::found);
    CHECK(by_blocks.work < whole.work / 4);
    CHECK(nearest_point(bounded.field, query, {.max_work = by_blocks.work}).status == NearestStatus::found);
    CHECK(nearest_point(bounded.field, query, {.max_work = by_blocks.work - 1}).status ==
          NearestStatus::work_limit);
}

TEST_CASE("nearest_point: near the surface it looks at the patch under the query and no other",
          "[nearest_point]") {
    const auto ground = hills<double>(200, 200, 8, 30);
    const auto grid = ground.grid();
    CountingField counting{grid};
    const double z = counting.patch({100, 100})->height(0.5, 0.5);
    counting.forget_looks();
    CHECK(nearest_point(counting, {100.5, 100.5, z + 0.25}).distance == Approx(0.25).epsilon(0.5));
    CHECK(counting.looks() == 1);
}

TEST_CASE("nearest_point: on a field without border, and one whose heights are of every size, it ends",
          "[nearest_point]") {
    const auto ground = hills<double>(30, 30, 2, 10);
    const auto grid = ground.grid();
    const ExtendedField endless{grid};
    const auto found = nearest_point(endless, {-5000.25, 12.5, 3});
    CHECK(found.status == NearestStatus::found);
    CHECK(found.side != Side::none);
    Random random{206};
    for (int n = 0; n < 200; ++n) {
        const auto wild = hard_ground<double>(HardGround::magnitudes, random);
        const auto query = nearest_query(random, wild, 100);
        const auto end = nearest_point(wild.grid(), query);
        CHECK(end.work <= NearestOptions<double>{}.max_work);
    }
}

TEST_CASE("nearest_point: does not allocate", "[nearest_point]") {
    const auto ground = rough_in_steps<double>(64, 64, 4, 207);
    const WithBounds<double> bounded{ground};
    Random random{208};
    const auto before = allocations();
    double sum = 0;
    for (int n = 0; n < 1000; ++n) {
        const glm::dvec3 query{random.between(-10, 80), random.between(-10, 80), random.between(-20, 30)};
        sum += nearest_point(bounded.field, query).distance;
    }
    CHECK(allocations() == before);
    CHECK(sum > 0);
}
