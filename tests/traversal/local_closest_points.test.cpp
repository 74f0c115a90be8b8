#include "catch.hpp"
#include "support/hard_ground.hpp"
#include "support/nearest_judge.hpp"
#include "support/scanned_minima.hpp"
#include "support/scenes.hpp"

#include <hfh/terrain/min_max_pyramid.hpp>
#include <hfh/traversal/local_closest_points.hpp>

using namespace hfh;
using namespace hfh::test;

namespace {

constexpr Index no_limit = Index{1} << 40;

template <Real T>
using Points = std::vector<LocalClosestPoint<T>>;

template <HeightField Field, Real T>
Points<T> all_within(const Field& field, const vec3<T>& query, T within) {
    Points<T> points;
    const auto end = visit_local_closest_points(
        field, query, within,
        [&](const LocalClosestPoint<T>& point) {
            points.push_back(point);
            return true;
        },
        no_limit);
    CHECK(end.status == LocalPointsStatus::complete);
    CHECK(end.count == static_cast<Index>(points.size()));
    return points;
}

/// Each visited point is a local closest point of its patch, and none that a scan finds is left out.
template <Real T>
void judge(const Terrain<T>& ground, const vec3<T>& query, T within) {
    const Surface<T> surface{ground};
    const auto points = all_within(ground.grid(), query, within);
    const Point q = wide(query);
    const Wide reach = static_cast<Wide>(within);
    INFO("query " << digits(query) << " within " << digits(within) << " on " << ground.columns << " x "
                  << ground.rows);
    for (const auto& point : points) {
        const Index i = point.point.cell.i, j = point.point.cell.j;
        const Wide u = static_cast<Wide>(point.point.u), v = static_cast<Wide>(point.point.v);
        const Point seen = surface.seen_from(q, i, j);
        CHECK(fall_into<T>(*surface.patch(i, j), u, v, seen) <= 64);
        const Wide size = std::max(surface.patch(i, j)->reach(seen), reach);
        const Wide distance = length(surface.patch(i, j)->position(u, v) - seen);
        CHECK(std::abs(distance - static_cast<Wide>(point.distance)) <= nearest_promise<T> * size);
        CHECK(distance <= reach + nearest_promise<T> * size);
    }
    for (Index j = 0; j + 1 < ground.rows; ++j) {
        for (Index i = 0; i + 1 < ground.columns; ++i) {
            const auto patch = surface.patch(i, j);
            const Point seen = surface.seen_from(q, i, j);
            if (!patch || std::max(-seen.x, seen.x - patch->dx) > reach ||
                std::max(-seen.y, seen.y - patch->dy) > reach)
                continue;
            for (const Foot& foot : scanned_minima(*patch, seen)) {
                if (foot.distance > reach * (1 - 1e-5L) || fall_into<T>(*patch, foot.u, foot.v, seen) > 1e6L)
                    continue;
                bool visited = false;
                for (const auto& point : points) {
                    const Wide du = static_cast<Wide>(point.point.u) - foot.u,
                               dv = static_cast<Wide>(point.point.v) - foot.v;
                    const bool same_place = std::hypot(du, dv) < 1e-4L;
                    const bool as_far = std::abs(static_cast<Wide>(point.distance) - foot.distance) <
                                        100 * nearest_promise<T> * patch->reach(seen);
                    visited = visited || (point.point.cell == Cell{i, j} && (same_place || as_far));
                }
                INFO("cell " << i << ' ' << j << " at " << static_cast<double>(foot.u) << ' '
                             << static_cast<double>(foot.v));
                CHECK(visited);
            }
        }
    }
}

} // namespace

TEMPLATE_TEST_CASE("local_closest_points: all of them and no others", "[local_closest_points]", float,
                   double) {
    using T = TestType;
    Random random{211};
    for (int n = 0; n < 90; ++n) {
        const auto ground = n % 3 == 0 ? rough_in_steps<T>(8, 8, 4, static_cast<std::uint64_t>(n))
                                       : hard_ground<T>(static_cast<HardGround>(n % 6), random);
        const auto query = nearest_query(random, ground, 5);
        judge(ground, query, static_cast<T>(ground.frame.spacing.x * std::pow(10, random.between(-1, 0.8))));
    }
}

TEMPLATE_TEST_CASE("local_closest_points: two may lie on one patch", "[local_closest_points]", float,
                   double) {
    using T = TestType;
    const auto ground = terrain<T>(2, 2, [](Index i, Index j) { return i == j ? 1.0 : -1.0; });
    const auto grid = ground.grid();
    const vec3<T> query{T(0.5), T(0.5), T(0.75)};
    const auto points = all_within(grid, query, T(2));
    REQUIRE(points.size() == 2);
    CHECK(points[0].distance == Approx(points[1].distance));
    CHECK(points[0].point.u + points[1].point.u == Approx(1));
    judge(ground, query, T(2));
    // A patch that is hardly bent, and a query a little beyond its radius of curvature, which is 5/2.
    const auto shallow = terrain<T>(2, 2, [](Index i, Index j) { return i == j ? 0.1 : -0.1; });
    const vec3<T> far{T(0.5), T(0.5), T(2.55)};
    CHECK(all_within(shallow.grid(), far, T(3)).size() == 2);
    judge(shallow, far, T(3));
}

TEST_CASE("local_closest_points: the nearest of them is the nearest point", "[local_closest_points]") {
    Random random{212};
    for (const auto& scene : scenes<double>()) {
        auto ground = scene.terrain;
        punch_holes(ground, 20, 213);
        std::vector<SampleRange<double>> storage(
            static_cast<std::size_t>(MinMaxPyramid<double>::size(ground.columns, ground.rows)));
        BoundedGrid bounded{ground.grid(), storage.data(), static_cast<Index>(storage.size())};
        bounded.build();
        for (int n = 0; n < 20; ++n) {
            const auto query = nearest_query(random, ground, 10);
            const auto nearest = nearest_point(ground.grid(), query, {.max_work = no_limit});
            const double within = nearest.distance * 1.25;
            const auto plain = all_within(ground.grid(), query, within),
                       pruned = all_within(bounded, query, within);
            CHECK(plain.size() == pruned.size());
            double least = std::numeric_limits<double>::max();
            for (const auto& point : plain) least = std::min(least, point.distance);
            CHECK(least == Approx(nearest.distance).epsilon(1e-12).margin(1e-12));
        }
    }
}

TEST_CASE(
    "local_closest_points: a full span, a visitor that stops, limited work and bad input each have a status",
    "[local_closest_points]") {
    const auto ground = rough_in_steps<double>(40, 40, 4, 214);
    const auto grid = ground.grid();
    const glm::dvec3 query{20.3, 20.6, 2};
    const auto all = all_within(grid, query, 5.0);
    REQUIRE(all.size() > 8);
    Points<double> some(all.size());
    const auto exact = collect_local_closest_points(grid, query, 5.0, std::span{some});
    CHECK(exact.status == LocalPointsStatus::complete);
    CHECK(exact.count == static_cast<Index>(all.size()));
    const auto full = collect_local_closest_points(grid, query, 5.0, std::span{some}.first(all.size() - 1));
    CHECK(full.status == LocalPointsStatus::buffer_full);
    CHECK(full.count == static_cast<Index>(all.size()) - 1);
    CHECK(collect_local_closest_points(grid, query, 5.0, {}).status == LocalPointsStatus::buffer_full);
    CHECK(collect_local_closest_points(grid, query, 1e-9, {}).status == LocalPointsStatus::complete);

    int visits = 0;
    const auto stop = [&](const LocalClosestPoint<double>&) { return ++visits < 3; };
    const auto stopped = visit_local_closest_points(grid, query, 5.0, stop);
    CHECK(stopped.status == LocalPointsStatus::stopped);
    CHECK(stopped.count == 3);
    CHECK(visits == 3);

    const auto on = [](const LocalClosestPoint<double>&) { return true; };
    for (const Index limit : {Index{-1}, Index{0}, Index{10}}) {
        const auto cut = visit_local_closest_points(grid, query, 5.0, on, limit);
        CHECK(cut.status == LocalPointsStatus::work_limit);
        CHECK(cut.work <= std::max<Index>(limit, 0));
    }
    CHECK(visit_local_closest_points(grid, query, -1.0, on).status == LocalPointsStatus::bad_query);
    CHECK(visit_local_closest_points(grid, query, hidden_nan<double>(), on).status ==
          LocalPointsStatus::bad_query);
    CHECK(visit_local_closest_points(grid, {hidden_nan<double>(), 1, 1}, 1.0, on).status ==
          LocalPointsStatus::bad_query);
    CHECK(visit_local_closest_points(grid, query, hidden_infinity<double>(), on).status ==
          LocalPointsStatus::complete);
}
