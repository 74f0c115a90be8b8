#include "catch.hpp"
#include "support/device_streams.hpp"
#include "support/guard_oracle.hpp"
#include "support/guards.hpp"

#include <functional>
#include <string>
#include <vector>

using namespace hfh;
using namespace hfh::test;

namespace {

constexpr glm::dvec3 asked{0, 0, 1};

unsigned trips(const Guard& guard) {
    unsigned all = 0;
    for (const unsigned times : guard.counts().trips) all += times;
    return all;
}

/// Trips of a guard that sees a whole stream.
unsigned trips_of(const StreamOptions& options, const GuardLimits& limits = {}) {
    Guard guard{limits};
    for (const DeviceSample& sample : deliver(options)) (void)guard.update(sample, asked);
    return trips(guard);
}

} // namespace

TEST_CASE("SampleCheck: what was seen to trip in ordinary use does not", "[sample_check][regression]") {
    // A device that is polled faster than it samples.
    CHECK(trips_of({.rate = 1000, .polls = 4000, .speed = 3}) == 0);
    CHECK(trips_of({.rate = 1000, .polls = 8000, .speed = 2}) == 0);
    CHECK(trips_of({.rate = 500, .polls = 4000, .speed = 1.5}) == 0);
    CHECK(trips_of({.rate = 200, .polls = 4000, .speed = 0.5}) == 0);
    // A device of 100 Hz.
    CHECK(trips_of({.delivery = Delivery::late_stamps, .rate = 100, .speed = 3, .seconds = 20}) == 0);
    CHECK(trips_of({.delivery = Delivery::late_stamps, .rate = 100, .seconds = 20}, {.max_gap = 0.01}) == 0);

    // A stall of 5 ms that ends in a burst.
    for (const double apart : {0.0, 1e-6, 1e-4}) {
        Guard guard;
        DeviceSample sample{.time = 3};
        for (int n = 0; n < 2000; ++n) {
            const int in_stall = n % 500 - 400;
            sample.time = 3 + 0.001 * n;
            if (in_stall >= 0 && in_stall < 5) sample.time += 0.001 * (5 - in_stall) + apart * in_stall;
            sample.position.x = 0.0012 * n;
            (void)guard.update(sample, asked);
        }
        CHECK(trips(guard) == 0);
    }

    // A stamp that is a tenth of a microsecond early.
    Guard guard;
    DeviceSample sample{.time = 3};
    for (int n = 0; n < 1000; ++n) {
        sample.time = 3 + 0.001 * n;
        (void)guard.update(sample, {0, 0, 2});
    }
    sample.time -= 1e-7;
    CHECK(guard.update(sample, {0, 0, 2}).newtons.z == 2);
}

namespace {

void check_no_trips(const StreamOptions& o) {
    const unsigned own = trips_of(o);
    // The device's limits are narrower. They hold for any polling where stamps are as due, and else for a device that is
    // polled no slower than it samples, by a clock that ticks within max_gap.
    const GuardLimits limits = guard_limits({.rate = o.rate});
    const bool steady = o.delivery == Delivery::stalled_polls || o.delivery == Delivery::burst ||
                        o.delivery == Delivery::late_stamps;
    const bool ticks = o.delivery != Delivery::coarse_clock || limits.max_gap > 1.0 / 64;
    const bool meant = steady || (o.polls >= o.rate && ticks);
    const unsigned device = meant ? trips_of(o, limits) : 0;
    if (own == 0 && device == 0) return;
    CAPTURE(to_string(o.delivery), o.rate, o.polls, o.jitter, o.speed, o.reaches, o.stall_in);
    CHECK(own == 0);
    CHECK(device == 0);
}

/// Any jitter, speed and stall, of a hand that moves evenly, and of one that reaches.
void check_hands(StreamOptions options) {
    for (const double jitter : {0.0, 0.003, 0.005, 0.01}) {
        for (const double speed : {0.002, 0.3, 3.0}) {
            for (const int stall_in : {3, 50}) {
                options.jitter = jitter, options.speed = speed, options.stall_in = stall_in;
                options.reaches = false;
                check_no_trips(options);
                options.reaches = true;
                if (speed >= 0.1) check_no_trips(options);
            }
        }
    }
}

} // namespace

TEST_CASE("SampleCheck: nothing trips at 3 m/s, whatever device, polling, jitter and stamps",
          "[sample_check][law]") {
    for (const Delivery delivery : all_deliveries) {
        for (const double rate : {100.0, 125.0, 200.0, 333.0, 500.0, 1000.0}) {
            for (const double polls : {500.0, 1000.0, 4000.0, 8000.0}) {
                check_hands({.delivery = delivery, .rate = rate, .polls = polls, .seconds = 0.5, .seed = 3});
            }
        }
    }
}

TEST_CASE("SampleCheck: samples that each come up to 10 ms late do not trip at 3 m/s",
          "[sample_check][regression]") {
    // Two delays after each other: the place is farther on than the times between its changes tell.
    for (const double polls : {1000.0, 4000.0, 8000.0}) {
        for (const double rate : {500.0, 1000.0}) {
            for (std::uint64_t seed = 1; seed <= 25; ++seed) {
                const StreamOptions late{.delivery = Delivery::late_arrival,
                                         .rate = rate,
                                         .polls = polls,
                                         .jitter = 0.01,
                                         .seconds = 1,
                                         .seed = seed};
                CAPTURE(rate, polls, seed);
                CHECK(trips_of(late) == 0);
                CHECK(trips_of(late, guard_limits({.rate = rate})) == 0);
            }
        }
    }
}

namespace {

struct Fault {
    const char* name;
    GuardTrip trip;
    std::function<void(DeviceSample&, glm::dvec3&, bool&)> put_in;
};
const Fault all_faults[] = {
    {"force NaN", GuardTrip::bad_force, [](auto&, auto& f, auto&) { f.y = make_nan(); }},
    {"force infinite", GuardTrip::bad_force, [](auto&, auto& f, auto&) { f.x = -make_infinity(); }},
    {"place NaN", GuardTrip::bad_sample, [](auto& s, auto&, auto&) { s.position.z = make_nan(); }},
    {"place infinite", GuardTrip::bad_sample, [](auto& s, auto&, auto&) { s.position.x = make_infinity(); }},
    {"time NaN", GuardTrip::bad_sample, [](auto& s, auto&, auto&) { s.time = make_nan(); }},
    {"refused", GuardTrip::device_fault, [](auto& s, auto&, auto&) { s.force_refused = true; }},
    {"buried", GuardTrip::buried, [](auto&, auto&, auto& buried) { buried = true; }},
    {"stall", GuardTrip::stale, [](auto& s, auto&, auto&) { s.time += 0.3; }},
    {"clock set back", GuardTrip::stale, [](auto& s, auto&, auto&) { s.time -= 0.05; }},
    {"clock at 0", GuardTrip::stale, [](auto& s, auto&, auto&) { s.time = 0; }},
    {"jump", GuardTrip::jump, [](auto& s, auto&, auto&) { s.position.y += 0.2; }},
    {"far jump", GuardTrip::jump, [](auto& s, auto&, auto&) { s.position.z -= 1e9; }},
};

/// The fault trips a guard that has seen six sevenths of the stream, in the same update and as what it is.
void check_fault(const Fault& fault, const std::vector<DeviceSample>& stream, const GuardLimits& limits) {
    Guard guard{limits};
    const std::size_t at = stream.size() * 6 / 7;
    for (std::size_t n = 0; n < at; ++n) (void)guard.update(stream[n], asked);
    REQUIRE(trips(guard) == 0);
    auto broken = stream[at];
    auto force = asked;
    bool buried = false;
    fault.put_in(broken, force, buried);
    const auto result = guard.update(broken, force, buried);
    CAPTURE(fault.name);
    CHECK(result.trip == fault.trip);
    CHECK(is_zero(result.newtons));
    CHECK(guard.counts().trips[static_cast<int>(fault.trip)] == 1);
}

/// After the stream: the same sample over and over, and time that goes backwards.
void check_stuck_clocks(const std::vector<DeviceSample>& stream) {
    Guard guard;
    for (const auto& sample : stream) (void)guard.update(sample, asked);
    Guard backwards = guard;
    auto sample = stream.back();
    GuardedForce result;
    for (int n = 0; n <= guard.limits().max_repeats; ++n) result = guard.update(sample, asked);
    CHECK(result.trip == GuardTrip::repeated);
    for (int n = 0; n < 22; ++n) {
        sample.time -= 0.001;
        result = backwards.update(sample, asked);
        if (result.trip == GuardTrip::stale) break;
    }
    CHECK(result.trip == GuardTrip::stale);
}

void check_all_faults(const StreamOptions& options) {
    const auto stream = deliver(options);
    // By the device's own limits, unless the clock's ticks are too far apart for them.
    const bool fitted = options.delivery != Delivery::coarse_clock || options.rate <= 500;
    CAPTURE(to_string(options.delivery), options.rate, options.speed);
    for (const Fault& fault : all_faults) {
        check_fault(fault, stream, {});
        if (fitted) check_fault(fault, stream, guard_limits({.rate = options.rate}));
    }
    check_stuck_clocks(stream);
}

} // namespace

TEST_CASE("SampleCheck: in every one of these streams a fault trips in its update", "[sample_check][law]") {
    for (const Delivery delivery : all_deliveries) {
        for (const double rate : {100.0, 1000.0}) {
            for (const double speed : {0.0, 0.002, 3.0}) {
                check_all_faults({.delivery = delivery,
                                  .rate = rate,
                                  .jitter = 0.01,
                                  .speed = speed,
                                  .seconds = 0.7,
                                  .stall_in = 5,
                                  .seed = 4});
            }
        }
    }
}

TEST_CASE("SampleCheck: a device at steady intervals is held to its own speed soon", "[sample_check]") {
    for (const double rate : {1000.0, 250.0}) {
        GuardLimits limits = guard_limits({.rate = rate});
        limits.max_step = 0.0005;
        for (const double excess : {-1e-5, 1e-5}) {
            Check check;
            glm::dvec3 place{0.0};
            CheckedSample told;
            const int rest = static_cast<int>(20 * rate); // 20 s; then a first move of 2 mm
            for (int n = -rest; n < 700; ++n) {
                if (n >= 0) place.x += n == 0 ? 2e-3 : 1e-4;
                told = check.update(limits, n / rate, place);
                REQUIRE_FALSE((told.jump || told.stale || told.repeated));
            }
            // The scatter of the beginning has faded to less than a micrometre by now.
            place.y += 0.0005 + 5 / rate + excess;
            told = check.update(limits, 700 / rate, place);
            CHECK(told.jump == (excess > 0));
            CHECK(told.passed == Approx(1 / rate));
            CHECK(told.moved == Approx(0.0005 + 5 / rate + excess));
        }
    }
}

TEST_CASE("SampleCheck: an encoder in slow motion and a hand at rest do not make a jump a hand's",
          "[sample_check]") {
    // One step of 0.055 mm in 55 ms; then a jump that would be slow since then.
    for (const bool at_rest : {false, true}) {
        Check check;
        const GuardLimits limits;
        glm::dvec3 place{0.0};
        for (int n = 0; n < 5000; ++n) {
            if (!at_rest) place.x = 0.055e-3 * (n / 55);
            REQUIRE_FALSE(check.update(limits, 0.001 * n, place).jump);
        }
        place.z = limits.max_step + limits.max_speed * limits.max_gap + 1e-4; // 10 cm
        CHECK(check.update(limits, 5, place).jump);
    }
}

namespace {

/// m: the longest move that is no jump, after two seconds of a hand at `speed`, which this changes.
double longest_move(const GuardLimits& limits, const StreamOptions& options) {
    const auto stream = deliver(options);
    Check check;
    std::size_t n = 0;
    for (; n + 1 < stream.size(); ++n) (void)check.update(limits, stream[n].time, stream[n].position);
    double shortest = 0, longest = 1;
    for (int k = 0; k < 30; ++k) {
        const double middle = (shortest + longest) / 2;
        Check copy = check;
        const glm::dvec3 place = stream[n].position + glm::dvec3{0, middle, 0};
        (copy.update(limits, stream[n].time, place).jump ? longest : shortest) = middle;
    }
    return longest;
}

} // namespace

TEST_CASE("SampleCheck: a jump from rest is one of the device's own period, however often it is asked",
          "[sample_check][regression]") {
    // After a rest all the time since the place changed last was the hand's to move in: at 1 kHz up to 61 mm in an update, at
    // 100 Hz 151 mm.
    for (const double rate : {100.0, 200.0, 500.0, 1000.0}) {
        for (const double polls : {rate, 4000.0, 8000.0}) {
            const StreamOptions at_rest{.rate = rate, .polls = polls, .speed = 0};
            CAPTURE(rate, polls);
            CHECK(longest_move(guard_limits({.rate = rate}), at_rest) ==
                  Approx(0.001 + 5 / rate).epsilon(1e-3));
            // A period that nobody tells, and that no move teaches, may be as long as max_gap.
            CHECK(longest_move({}, at_rest) == Approx(0.101).epsilon(1e-3));
        }
    }
    // A slow hand on a device that is asked eight times a sample teaches no more than a rest does.
    const StreamOptions slow{.rate = 1000, .polls = 8000, .speed = 0.05};
    CHECK(longest_move(guard_limits({.rate = 1000}), slow) == Approx(0.006).epsilon(1e-3));
    CHECK(longest_move({}, slow) == Approx(0.101).epsilon(1e-3));
}

TEST_CASE("SampleCheck: a move that is no jump to the guard reaches the motors by the slew",
          "[sample_check]") {
    // The longest that trips nothing, 100 mm into the ground: what it may do is turn the force up by max_slew.
    Guard guard;
    double before = 0;
    for (int n = 0; n < 1020; ++n) {
        const double z = n < 1000 ? 0.0 : -0.1;
        const auto result = guard.update({.time = 1 + 0.001 * n, .position = {0, 0, z}}, {0, 0, -500 * z});
        CHECK(result.trip == GuardTrip::none);
        CHECK(result.newtons.z <= before + guard.limits().max_slew + 1e-9);
        before = result.newtons.z;
    }
    CHECK(before == Approx(guard.limits().max_force));
}

TEST_CASE("SampleCheck: no hand is faster than max_speed for long, however its first move came about",
          "[sample_check]") {
    for (const bool known : {true, false}) {
        for (const double speed : {4.9, 8.0, 12.0}) {
            const GuardLimits limits = known ? guard_limits({.rate = 1000}) : GuardLimits{};
            Check check;
            glm::dvec3 place{0.0};
            double since = 0;
            int jumps = 0;
            for (int n = 0; n < 1200; ++n) {
                if (n > 1000) place.y += 0.001 * speed; // from rest at once
                const auto told = check.update(limits, 0.001 * n, place);
                jumps += told.jump;
                if (jumps == 0 && n > 1000) since += 0.001;
            }
            CAPTURE(known, speed, since);
            CHECK((jumps > 0) == (speed > 5));
            // What it is ahead of max_speed by is at most max_step and max_gap at that speed.
            if (speed > 5) CHECK((speed - 5) * since <= limits.max_step + 5 * limits.max_gap);
        }
    }
}

TEST_CASE("SampleCheck: forgets", "[sample_check]") {
    Check check;
    const GuardLimits limits;
    (void)check.update(limits, 1, {});
    check.forget();
    const auto told = check.update(limits, -50, {7, 8, 9});
    CHECK_FALSE((told.stale || told.jump || told.repeated));
    CHECK(told.moved == 0);
    CHECK(told.passed == 0);
    CHECK(check.time() == -50);
}

TEST_CASE("guard_limits: what the device tells, else what GuardLimits says", "[sample_check]") {
    const GuardLimits plain, none = guard_limits({});
    CHECK(none.max_force == plain.max_force);
    CHECK(none.max_slew == plain.max_slew);
    CHECK(none.stiffness == plain.stiffness);
    CHECK(none.max_gap == plain.max_gap);
    CHECK(none.max_repeats == plain.max_repeats);
    CHECK(is_usable(none));

    // A Premium 1.5 as its maker describes it: not 8.5 N in 1.2 ms.
    DeviceCapabilities device{.max_force = 8.5, .max_stiffness = 3500, .rate = 1000};
    CHECK(guard_limits(device).max_force == 8.5);
    CHECK(guard_limits(device).stiffness == 3500);
    CHECK(guard_limits(device).max_slew == 1);
    CHECK(guard_limits(device).max_gap == Approx(0.012));
    CHECK(guard_limits(device).max_repeats == 96);
    CHECK(guard_limits(device).period == 0.001);
    device.max_slew = 0.2;
    CHECK(guard_limits(device).max_slew == 0.2);
    device.max_slew = 4; // a driver's own limit may be no protection of a hand
    CHECK(guard_limits(device).max_slew == 1);
    device.rate = 100;
    CHECK(guard_limits(device).max_gap == Approx(0.03));
    CHECK(guard_limits(device).max_repeats == 240);

    for (const double slow : {1.0, 49.0}) { // in kHz, or no device in a hand
        CHECK(guard_limits({.rate = slow}).max_gap == plain.max_gap);
        CHECK(guard_limits({.rate = slow}).period == 0);
    }
    for (const double bad :
         {make_nan(), make_infinity(), -make_infinity(), make_largest(), -1.0, 0.0, make_denormal(), -0.0}) {
        const auto limits =
            guard_limits({.max_force = bad, .max_stiffness = bad, .rate = bad, .max_slew = bad});
        CHECK(is_usable(limits));
        CHECK(limits.max_gap == plain.max_gap);
    }
}
