#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/guard_oracle.hpp"
#include "support/guards.hpp"

#include <cmath>
#include <set>
#include <string>
#include <type_traits>
#include <utility>

using namespace hfh;
using namespace hfh::test;

namespace {

constexpr GuardTrip all[] = {GuardTrip::none,      GuardTrip::bad_limits,   GuardTrip::bad_sample,
                             GuardTrip::bad_force, GuardTrip::device_fault, GuardTrip::stale,
                             GuardTrip::repeated,  GuardTrip::jump,         GuardTrip::buried};

/// A guard under a hand that moves by 0.1 mm a millisecond and asks for 2 N upwards.
struct Bench {
    explicit Bench(const GuardLimits& limits = {}) : guard{limits} {}

    GuardedForce step(int updates = 1) {
        GuardedForce result;
        for (int n = 0; n < updates; ++n) {
            sample.time += 0.001;
            sample.position.x += 0.0001;
            result = guard.update(sample, asked);
        }
        return result;
    }
    unsigned trips(GuardTrip trip) const { return guard.counts().trips[static_cast<int>(trip)]; }

    Guard guard;
    DeviceSample sample{.time = 100};
    glm::dvec3 asked{0, 0, 2};
};

/// Warm: the ramp is over.
Bench warm(const GuardLimits& limits = {}) {
    Bench bench{limits};
    bench.step(1000);
    REQUIRE(bench.step().newtons.z == Approx(2));
    return bench;
}

/// After a trip that has gone: half the ramp gives half the force, all of it the whole.
void check_comes_back_by_the_ramp(Bench& bench) {
    CHECK(bench.step(250).newtons.z == Approx(1).epsilon(0.02));
    CHECK(bench.step(260).newtons.z == Approx(2));
}

} // namespace

TEST_CASE("GuardTrip: every trip has a name of its own", "[force_guard]") {
    static_assert(std::size(all) == guard_trip_count);
    std::set<std::string> names;
    for (const auto trip : all) names.insert(to_string(trip));
    CHECK(names.size() == std::size(all));
    CHECK(names.count("unknown") == 0);
    CHECK(to_string(GuardTrip::jump) == std::string{"jump"});
    CHECK(to_string(static_cast<GuardTrip>(guard_trip_count)) ==
          std::string{"unknown"}); // and there are no more
}

TEST_CASE("ForceGuard: the force comes up by the ramp at the start and is then passed on", "[force_guard]") {
    Bench bench;
    const auto first = bench.step();
    CHECK(is_zero(first.newtons));
    CHECK(first.ramped);
    CHECK(bench.step(250).newtons.z == Approx(1).epsilon(0.02));
    const auto late = bench.step(260);
    CHECK(late.newtons == glm::dvec3{0, 0, 2}); // to the bit
    CHECK_FALSE((late.ramped || late.clamped || late.slewed || late.latched));
    CHECK(late.trip == GuardTrip::none);
    CHECK(bench.guard.counts().ramped > 490);
    CHECK(bench.guard.counts().zeroed == 0);

    Bench idle; // nothing to shorten
    idle.asked = {};
    CHECK_FALSE(idle.step(100).ramped);
    CHECK(idle.guard.counts().ramped == 0);
}

TEST_CASE("ForceGuard: clamps by length, keeps the direction, and says so", "[force_guard]") {
    auto bench = warm({.max_sudden = 4});
    bench.asked = {30, 0, 40};
    const auto result = bench.step(100);
    CHECK(result.clamped);
    CHECK(result.newtons.x == Approx(3.3 * 0.6));
    CHECK(result.newtons.z == Approx(3.3 * 0.8));
    CHECK(bench.guard.counts().clamped == 100);
}

TEST_CASE("ForceGuard: the force changes by no more than the slew times the time step", "[force_guard]") {
    auto bench = warm({.max_slew = 0.25});
    bench.asked = {0, 0, -2};
    auto result = bench.step();
    CHECK(result.slewed);
    CHECK(result.newtons.z == Approx(1.75));
    bench.sample.time += 0.003; // and 0.001 more: four milliseconds
    result = bench.step();
    CHECK(result.newtons.z == Approx(0.75));
    CHECK(bench.step(12).newtons.z == Approx(-2));
    CHECK_FALSE(bench.step().slewed);
    // In float the last of these steps may end a rounding before -2.
    CHECK(bench.guard.counts().slewed - 12 <= (std::same_as<GuardScalar, float> ? 1u : 0u));
}

TEST_CASE("ForceGuard: a force that is no number is zero at once, though the slew is slow", "[force_guard]") {
    for (const double bad :
         {make_nan(), make_signalling_nan(), make_infinity(), -make_infinity(), make_largest()}) {
        for (int axis = 0; axis < 3; ++axis) {
            auto bench = warm({.max_slew = 0.01});
            const auto asked = bench.asked;
            bench.asked[axis] = bad;
            const auto result = bench.step();
            CHECK(result.trip == GuardTrip::bad_force);
            CHECK(is_zero(result.newtons));
            bench.step(9);
            CHECK(bench.trips(GuardTrip::bad_force) == 1); // one cause, however long it stays
            CHECK(bench.guard.counts().zeroed == 10);
            bench.asked = asked;
            check_comes_back_by_the_ramp(bench);
        }
    }
}

TEST_CASE("ForceGuard: a force below 2^64 N is a number, and shortened, one of 2^64 N is none, and in float "
          "of 2^32 N",
          "[force_guard]") {
    auto bench = warm({.max_sudden = 4});
    constexpr GuardScalar least =
        std::same_as<GuardScalar, float> ? GuardScalar(0x1p32) : GuardScalar(0x1p64);
    bench.asked.z = widen(std::nextafter(least, GuardScalar(0)));
    const auto result = bench.step(10);
    CHECK(result.trip == GuardTrip::none);
    CHECK(result.newtons.z == Approx(3.3));
    bench.asked.z = widen(least);
    CHECK(bench.step().trip == GuardTrip::bad_force);
}

TEST_CASE("ForceGuard: a sample that is no number is zero at once and not remembered", "[force_guard]") {
    for (const double bad :
         {make_nan(), make_signalling_nan(), make_infinity(), -make_infinity(), make_largest()}) {
        for (int place = 0; place < 4; ++place) {
            auto bench = warm();
            auto broken = bench.sample;
            broken.time += 0.0005;
            (place < 3 ? broken.position[place] : broken.time) = bad;
            const auto result = bench.guard.update(broken, bench.asked);
            CHECK(result.trip == GuardTrip::bad_sample);
            CHECK(is_zero(result.newtons));
            check_comes_back_by_the_ramp(bench);
            CHECK(bench.trips(GuardTrip::bad_sample) == 1);
            CHECK(bench.trips(GuardTrip::jump) == 0);
        }
    }
}

TEST_CASE("ForceGuard: a gap in time, or time that falls far, is stale", "[force_guard]") {
    const double gap = GENERATE(0.0101, 1.0, -0.0101, -50.0);
    auto bench = warm({.max_gap = 0.01});
    bench.sample.time += gap - 0.001;
    CHECK(bench.step().trip == GuardTrip::stale);
    check_comes_back_by_the_ramp(bench);
    CHECK(bench.trips(GuardTrip::stale) == 1);

    auto spared = warm({.max_gap = 0.01});
    spared.sample.time += 0.0085;
    CHECK(spared.step().trip == GuardTrip::none);
    CHECK(warm().step().trip == GuardTrip::none);
    auto long_ago = warm();
    long_ago.sample.time += 0.0195;
    CHECK(long_ago.step().trip == GuardTrip::stale); // 20.5 ms
}

TEST_CASE("ForceGuard: a gap is judged to the rounding of the stamps", "[force_guard]") {
    Guard dyadic{{.max_gap = 0.25}};
    CHECK(dyadic.update({.time = 1}, {}).trip == GuardTrip::none);
    CHECK(dyadic.update({.time = 1.25}, {}).trip == GuardTrip::none);
    CHECK(dyadic.update({.time = std::nextafter(1.5, 2.0)}, {}).trip == GuardTrip::none);
    CHECK(dyadic.update({.time = 1.75 + guard_rounding(5 * 0x1p-52, 2)}, {}).trip == GuardTrip::stale);
    // A true 100 Hz device, its stamps multiplied or added up.
    Guard product{{.max_gap = 0.01}}, sum{{.max_gap = 0.01}};
    double added = 0;
    for (int n = 0; n < 2000; ++n, added += 0.01) {
        (void)product.update({.time = n * 0.01}, {});
        (void)sum.update({.time = added}, {});
    }
    CHECK(product.counts().trips[static_cast<int>(GuardTrip::stale)] == 0);
    CHECK(sum.counts().trips[static_cast<int>(GuardTrip::stale)] == 0);
}

TEST_CASE("ForceGuard: a stamp out of order is no trip, and gives no time for a rise", "[force_guard]") {
    const double early = GENERATE(1e-7, 1e-6, 0.0007, 0.015);
    auto bench = warm();
    auto late = bench.sample;
    late.time -= early;
    for (const double asked : {2.0, 2.2, 1.9}) {
        const auto result = bench.guard.update(late, {0, 0, asked});
        CHECK(result.trip == GuardTrip::none);
        CHECK(result.newtons.z == 2);
    }
    CHECK(bench.step().newtons.z == Approx(2));
    // The clock is the latest stamp's: what comes after it is as late as it is.
    bench.sample.time += 0.0185;
    CHECK(bench.step().trip == GuardTrip::none);
}

TEST_CASE("ForceGuard: while time stands still the force does too, for max_repeats updates",
          "[force_guard]") {
    auto bench = warm({.max_repeats = 3});
    for (int n = 0; n < 3; ++n) {
        const auto result = bench.guard.update(bench.sample, {0, 0, 0.5 * n});
        CHECK(result.trip == GuardTrip::none);
        CHECK(result.newtons.z == Approx(2));
    }
    for (int n = 0; n < 100; ++n) {
        const auto result = bench.guard.update(bench.sample, bench.asked);
        CHECK(result.trip == GuardTrip::repeated);
        CHECK(is_zero(result.newtons));
    }
    check_comes_back_by_the_ramp(bench);
    CHECK(bench.trips(GuardTrip::repeated) == 1);
}

TEST_CASE("ForceGuard: the same place for longer than max_still is a repeated sample, if the user says so",
          "[force_guard]") {
    auto bench = warm({.max_still = 0.1});
    bench.step();
    GuardedForce result;
    const auto still = [&](int updates) {
        for (int n = 0; n < updates; ++n) {
            bench.sample.time += 0.001;
            result = bench.guard.update(bench.sample, bench.asked);
        }
    };
    still(99);
    CHECK(result.trip == GuardTrip::none);
    still(2);
    CHECK(result.trip == GuardTrip::repeated);
    check_comes_back_by_the_ramp(bench);

    bench = Bench{{.max_still = 0.1}}; // from the very start, at whatever time that is
    still(100);
    CHECK(bench.trips(GuardTrip::repeated) == 0);

    bench = warm();
    still(100000);
    CHECK(result.trip == GuardTrip::none);
    CHECK(result.newtons.z == Approx(2));
}

TEST_CASE("ForceGuard: a jump farther than a hand gets is zero at once, there and back", "[force_guard]") {
    auto bench = warm(); // 5 m/s · 1 ms + 1 mm
    bench.sample.position.y += 0.0058;
    CHECK(bench.step().trip == GuardTrip::none);
    bench.sample.position.y += 0.0061;
    CHECK(bench.step().trip == GuardTrip::jump);
    check_comes_back_by_the_ramp(bench);

    auto glitched = bench.sample; // one sample that is wrong is two jumps, and one cause
    glitched.time += 0.0005;
    glitched.position.z += 1;
    CHECK(bench.guard.update(glitched, bench.asked).trip == GuardTrip::jump);
    CHECK(bench.step().trip == GuardTrip::jump);
    check_comes_back_by_the_ramp(bench);
    CHECK(bench.trips(GuardTrip::jump) == 2);
}

TEST_CASE("ForceGuard: buried gives zero until it is over, then the ramp", "[force_guard]") {
    Bench bench; // from the very start
    for (int n = 0; n < 600; ++n) {
        bench.sample.time += 0.001;
        const auto result = bench.guard.update(bench.sample, bench.asked, true);
        CHECK(result.trip == GuardTrip::buried);
        CHECK(is_zero(result.newtons));
    }
    check_comes_back_by_the_ramp(bench);
    CHECK(bench.trips(GuardTrip::buried) == 1);
}

TEST_CASE("ForceGuard: after a force that the device refused there is none, then the ramp", "[force_guard]") {
    auto bench = warm();
    bench.sample.force_refused = true;
    const auto result = bench.step();
    CHECK(result.trip == GuardTrip::device_fault);
    CHECK(is_zero(result.newtons));
    bench.sample.force_refused = false;
    check_comes_back_by_the_ramp(bench);
    CHECK(bench.trips(GuardTrip::device_fault) == 1);
}

TEST_CASE("ForceGuard: of several causes each is counted and the gravest named", "[force_guard]") {
    auto bench = warm();
    bench.sample.time += 1;
    bench.sample.position.x += 10;
    bench.asked.z = make_nan();
    CHECK(bench.step().trip == GuardTrip::bad_force);
    CHECK(bench.trips(GuardTrip::bad_force) == 1);
    CHECK(bench.trips(GuardTrip::stale) == 1);
    CHECK(bench.trips(GuardTrip::jump) == 1);
}

TEST_CASE("ForceGuard: with a latch the force stays away until it is armed again", "[force_guard]") {
    auto bench = warm({.latch = true});
    bench.asked.x = make_infinity();
    CHECK(bench.step().trip == GuardTrip::bad_force);
    bench.guard.rearm(); // too early: the cause stands, and latches again
    CHECK(bench.step().trip == GuardTrip::bad_force);
    bench.asked.x = 0;
    const auto waiting = bench.step(2000);
    CHECK(waiting.trip == GuardTrip::none);
    CHECK(waiting.latched);
    CHECK(is_zero(waiting.newtons));
    bench.guard.rearm();
    check_comes_back_by_the_ramp(bench);
}

TEST_CASE("ForceGuard: restart gives the ramp without a trip", "[force_guard]") {
    auto bench = warm();
    bench.guard.restart();
    CHECK(bench.step().newtons.z < 0.01);
    check_comes_back_by_the_ramp(bench);
    CHECK(bench.guard.counts().zeroed == 0);
}

TEST_CASE("ForceGuard: limits that are no numbers to go by give no force, ever", "[force_guard]") {
    for (const double bad : {make_nan(), make_infinity(), -1.0, make_largest()}) {
        for (double GuardLimits::*limit :
             {&GuardLimits::max_force, &GuardLimits::max_slew, &GuardLimits::ramp, &GuardLimits::max_gap,
              &GuardLimits::max_still, &GuardLimits::max_speed, &GuardLimits::max_step,
              &GuardLimits::stiffness, &GuardLimits::max_sudden, &GuardLimits::period}) {
            GuardLimits limits;
            limits.*limit = bad;
            Bench bench{limits};
            const auto result = bench.step(2000);
            CHECK(result.trip == GuardTrip::bad_limits);
            CHECK(is_zero(result.newtons));
            CHECK(bench.trips(GuardTrip::bad_limits) == 1);
        }
    }
    for (double GuardLimits::*limit :
         {&GuardLimits::max_force, &GuardLimits::max_slew, &GuardLimits::max_gap, &GuardLimits::max_speed}) {
        GuardLimits limits;
        limits.*limit = 0;
        CHECK(Bench{limits}.step().trip == GuardTrip::bad_limits);
    }
    CHECK(Bench{{.max_repeats = -1}}.step().trip == GuardTrip::bad_limits);
    CHECK(Bench{{.ramp = 0}}.step().trip == GuardTrip::none);
}

TEST_CASE("ForceGuard: keeps its word on everything that can go wrong at once", "[force_guard][law]") {
    const int calm = GENERATE(3, 20, 400);
    for (const GuardLimits& limits :
         {GuardLimits{.ramp = 0.05, .max_repeats = 3},
          GuardLimits{.max_slew = 0.1, .ramp = 0, .max_repeats = 0},
          GuardLimits{.max_force = 1e-3, .max_slew = 50, .ramp = 0.01, .max_still = 0.003},
          GuardLimits{.ramp = 0.02, .max_repeats = 2, .max_speed = 3, .max_step = 0, .latch = true}}) {
        Guard guard{limits};
        GuardJudge judge{as_seen(limits)};
        NastyStream stream{static_cast<std::uint64_t>(calm), calm};
        int felt = 0, with_force = 0;
        for (int n = 0; n < 20000; ++n) {
            auto update = stream.next();
            update.sample = as_seen(update.sample);
            update.asked = as_seen(update.asked);
            if (update.rearmed) guard.rearm();
            update.result = guard.update(update.sample, update.asked, update.buried);
            const char* broken = judge(update);
            CAPTURE(n, calm);
            REQUIRE(std::string{broken == nullptr ? "" : broken} == "");
            felt += update.result.trip == GuardTrip::none && !update.result.latched;
            with_force += !is_zero(update.result.newtons);
        }
        for (const auto trip : all) {
            CAPTURE(to_string(trip));
            CHECK(guard.counts().trips[static_cast<int>(trip)] == judge.trips(trip));
            if (calm == 20 && trip != GuardTrip::none && trip != GuardTrip::bad_limits)
                CHECK(judge.trips(trip) > 5); // the stream brings about all of them
        }
        CHECK(guard.counts().zeroed == static_cast<unsigned>(20000 - felt));
        if (calm > 3) CHECK(with_force > 100);
    }
}

TEST_CASE("ForceGuard: neither throws nor allocates, and is plain bytes", "[force_guard]") {
    static_assert(noexcept(std::declval<Guard&>().update(std::declval<const DeviceSample&>(),
                                                         std::declval<const glm::dvec3&>())));
    static_assert(std::is_trivially_copyable_v<Guard>);
    Bench bench;
    const auto before = allocations();
    bench.step(1000);
    bench.asked.x = make_nan();
    bench.step(1000);
    CHECK(allocations() == before);
}
