#include "catch.hpp"
#include "support/guard_oracle.hpp"
#include "support/guards.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

using namespace hfh;
using namespace hfh::test;

// The guard in single precision, against the one in double. Built with HFH_TEST_FLOAT_GUARD, as all tests of guards are once.

namespace {

/// N: how far the forces of the two guards are apart at the most, while both see the same numbers. Fails where one of them
/// trips and the other does not.
double largest_difference(const GuardLimits& limits, int calm, int updates) {
    FloatGuard single{limits};
    ForceGuard reference{as_seen(limits)};
    NastyStream stream{static_cast<std::uint64_t>(calm + 100), calm};
    double largest = 0;
    for (int n = 0; n < updates; ++n) {
        const GuardUpdate update = stream.next();
        const DeviceSample sample = as_seen(update.sample);
        const glm::dvec3 asked = as_seen(update.asked);
        if (update.rearmed) {
            single.rearm();
            reference.rearm();
        }
        const auto one = single.update(sample, asked, update.buried),
                   other = reference.update(sample, asked, update.buried);
        CAPTURE(n, to_string(one.trip), to_string(other.trip));
        REQUIRE(one.trip == other.trip);
        REQUIRE(one.latched == other.latched);
        REQUIRE(one.released == other.released);
        largest = std::max(largest, static_cast<double>(distance(one.newtons, other.newtons)));
    }
    for (int trip = 0; trip < guard_trip_count; ++trip)
        CHECK(single.counts().trips[trip] == reference.counts().trips[trip]);
    CHECK(single.counts().zeroed == reference.counts().zeroed);
    return largest;
}

/// Bits of all that a guard in float gives on a stream that begins `later` nanoseconds later.
std::vector<BasicGuardedForce<float>> run_later(std::int64_t later) {
    BasicForceGuard<float> guard{{.max_repeats = 3}};
    NastyStream stream{7, 40};
    std::vector<BasicGuardedForce<float>> all;
    for (int n = 0; n < 5000; ++n) {
        const GuardUpdate update = stream.next();
        BasicDeviceSample<float> sample = to_float(update.sample);
        for (Nanoseconds* time : {&sample.time, &sample.sent_at})
            if (detail::is_tame(*time)) time->count += later;
        all.push_back(guard.update(sample, vec3<float>{update.asked}, update.buried));
    }
    return all;
}

/// Whether a guard in float takes a second sample, so long after the first and so far from it, for a jump or for stale.
GuardTrip trip_of_second(std::int64_t nanoseconds, float metres, const BasicGuardLimits<float>& limits = {}) {
    BasicForceGuard<float> guard{limits};
    (void)guard.update({.time = {1'000'000'000}}, vec3<float>{0});
    return guard.update({.time = {1'000'000'000 + nanoseconds}, .position = {metres, 0, 0}}, vec3<float>{0})
        .trip;
}

} // namespace

TEST_CASE("BasicForceGuard: in float it trips where the one in double does, and gives the same forces",
          "[float_guard][law]") {
    for (const int calm : {3, 20, 400}) {
        for (const GuardLimits& limits :
             {GuardLimits{}, GuardLimits{.ramp = 0.05, .max_repeats = 3},
              GuardLimits{.max_slew = 0.1, .ramp = 0, .max_repeats = 0},
              GuardLimits{.max_force = 1e-3, .max_slew = 50, .ramp = 0.01, .max_still = 0.003},
              GuardLimits{.ramp = 0.02, .max_repeats = 2, .max_speed = 3, .max_step = 0, .latch = true}}) {
            CAPTURE(calm, limits.ramp);
            // Half a rounding of 1 in each update while the gain goes up, of at most 1000.
            CHECK(largest_difference(limits, calm, 20000) <= guard_rounding(0, 500) * limits.max_force);
        }
    }
}

TEST_CASE("BasicForceGuard: in float days after the start all is as at the start, to the bit",
          "[float_guard]") {
    const auto now = run_later(0);
    for (const std::int64_t days : {1, 30, 3650}) {
        const auto then = run_later(days * 86'400'000'000'000);
        REQUIRE(now.size() == then.size());
        for (std::size_t n = 0; n < now.size(); ++n) {
            CAPTURE(days, n);
            REQUIRE(now[n].trip == then[n].trip);
            REQUIRE(now[n].newtons == then[n].newtons);
        }
    }
}

TEST_CASE("BasicForceGuard: in float a gap and a jump are judged to some roundings", "[float_guard]") {
    CHECK(trip_of_second(20'000'000, 0) == GuardTrip::none);
    CHECK(trip_of_second(20'000'001, 0) == GuardTrip::none); // as two stamps that were rounded may be
    CHECK(trip_of_second(20'000'020, 0) == GuardTrip::stale);
    CHECK(trip_of_second(-20'000'000, 0) == GuardTrip::none);
    CHECK(trip_of_second(-20'000'020, 0) == GuardTrip::stale);
    // 1 mm + 5 m/s · 20 ms
    CHECK(trip_of_second(20'000'000, 0.101f * (1 - 1e-6f)) == GuardTrip::none);
    CHECK(trip_of_second(20'000'000, 0.101f * (1 + 1e-6f)) == GuardTrip::jump);
    // Gaps of seconds and of hours, where the upper half of the nanoseconds counts.
    for (const std::int64_t seconds : {5, 3600, 1'000'000}) {
        const BasicGuardLimits<float> limits{.max_gap = static_cast<float>(seconds)};
        const std::int64_t gap = 1'000'000'000 * seconds;
        CHECK(trip_of_second(gap, 0, limits) == GuardTrip::none);
        CHECK(trip_of_second(gap + gap / 1'000'000, 0, limits) == GuardTrip::stale);
        CHECK(trip_of_second(-gap - gap / 1'000'000, 0, limits) == GuardTrip::stale);
    }
}

TEST_CASE("BasicForceGuard: in float a time beyond 2^62 ns is none, and the earliest and the latest differ "
          "by a number",
          "[float_guard]") {
    constexpr std::int64_t most = std::int64_t{1} << 62;
    for (const std::int64_t bad :
         {most, -most, std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
        BasicForceGuard<float> guard;
        CHECK(guard.update({.time = {bad}}, vec3<float>{0}).trip == GuardTrip::bad_sample);
    }
    BasicForceGuard<float> guard;
    CHECK(guard.update({.time = {1 - most}}, vec3<float>{0}).trip == GuardTrip::none);
    CHECK(guard.update({.time = {most - 1}}, vec3<float>{0}).trip == GuardTrip::stale);
    CHECK(guard.update({.time = {1 - most}}, vec3<float>{0}).trip == GuardTrip::stale);
    CHECK(detail::seconds_between(Nanoseconds{1 - most}, Nanoseconds{most - 1}) == Approx(9.2233720e9));
    CHECK(detail::seconds_between(Nanoseconds{5}, Nanoseconds{-2}) == Approx(-7e-9));
    CHECK(detail::seconds_between(Nanoseconds{0}, Nanoseconds{std::int64_t{1} << 33}) == Approx(8.589934592));
}

TEST_CASE("guard_limits: in float as in double, rounded", "[float_guard]") {
    const BasicDeviceCapabilities<float> device{.max_force = 8.5f, .max_stiffness = 3500, .rate = 1000};
    const auto limits = guard_limits(device);
    static_assert(std::same_as<decltype(limits), const BasicGuardLimits<float>>);
    const GuardLimits reference = guard_limits({.max_force = 8.5, .max_stiffness = 3500, .rate = 1000});
    CHECK(limits.max_force == 8.5f);
    CHECK(limits.stiffness == 3500);
    CHECK(widen(limits.max_gap) == Approx(reference.max_gap));
    CHECK(limits.max_repeats == reference.max_repeats);
    CHECK(guard_limits(device, 400).stiffness == 700);
    CHECK(is_usable(limits));
}

TEST_CASE("BasicForceGuard: in float it is plain bytes, and does not throw", "[float_guard]") {
    static_assert(std::is_trivially_copyable_v<BasicForceGuard<float>>);
    static_assert(noexcept(std::declval<BasicForceGuard<float>&>().update(
        std::declval<const BasicDeviceSample<float>&>(), std::declval<const vec3<float>&>())));
    SUCCEED();
}
