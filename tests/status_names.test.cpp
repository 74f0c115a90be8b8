#include "catch.hpp"

#include <hfh/device.hpp>
#include <hfh/hfh.hpp>
#include <hfh/terrain.hpp>
#include <hfh/traversal/local_closest_points.hpp>
#include <hfh/traversal/nearest_point.hpp>

#include <set>
#include <string>

namespace {

/// Whether the `count` values of an enumeration have names, all different, and what lies beyond them has none.
template <class Enum>
bool all_named(int count) {
    std::set<std::string> names{"unknown"};
    for (int k = 0; k < count; ++k) names.insert(to_string(static_cast<Enum>(k)));
    return names.size() == static_cast<std::size_t>(count) + 1 &&
           to_string(static_cast<Enum>(count)) == std::string{"unknown"};
}

} // namespace

TEST_CASE("status_names: every status of the library has a name of its own", "[status_names]") {
    CHECK(all_named<hfh::GridStatus>(4));
    CHECK(all_named<hfh::PyramidStatus>(4));
    CHECK(all_named<hfh::HitStatus>(3));
    CHECK(all_named<hfh::DescentStatus>(4));
    CHECK(all_named<hfh::NearestStatus>(4));
    CHECK(all_named<hfh::LocalPointsStatus>(5));
    CHECK(all_named<hfh::NewtonStatus>(3));
    CHECK(all_named<hfh::GlobalStatus>(3));
    CHECK(all_named<hfh::ContactStatus>(9));
    CHECK(all_named<hfh::DeviceEnd>(5));
    CHECK(all_named<hfh::WorkspaceStatus>(4));
    CHECK(all_named<hfh::GuardTrip>(hfh::guard_trip_count));
    CHECK(to_string(hfh::GridStatus::bad_spacing) == std::string{"bad_spacing"});
}
