#include "catch.hpp"
#include "touch_terrain_files.hpp"

#include <device_in_hand.hpp>
#include <distribution.hpp>
#include <numbers.hpp>
#include <relief.hpp>
#include <stroke.hpp>
#include <stylus_path.hpp>
#include <trace.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

using namespace touch_terrain_tests;

namespace {

demo::Ground flat(double height) {
    return {{1000, 500}, {10, 10}, [=](glm::dvec2) { return height; }};
}

} // namespace

TEST_CASE("touch_terrain distribution: quantiles are those of the sorted values, to a bucket",
          "[touch_terrain]") {
    std::mt19937_64 random{1};
    for (const int bits : {3, 7, 12, 40, 64}) {
        demo::Distribution distribution;
        std::vector<std::uint64_t> values;
        for (int k = 0; k < 5000; ++k) {
            values.push_back(random() >> (64 - bits));
            distribution.add(values.back());
        }
        std::ranges::sort(values);
        CHECK(distribution.total() == values.size());
        CHECK(distribution.worst() == values.back());
        for (const double share : {0.0, 0.5, 0.999, 1.0}) {
            const auto place = std::min(values.size() - 1, static_cast<std::size_t>(share * 5000.0));
            const double exact = static_cast<double>(values[place]);
            const double got = static_cast<double>(distribution.quantile(share));
            CHECK(got >= exact);
            CHECK(got <= exact * (exact < 128 ? 1 : 1 + 1.0 / 64));
        }
    }
}

TEST_CASE("touch_terrain numbers: digits read back as the same number", "[touch_terrain]") {
    std::mt19937_64 random{2};
    std::uniform_real_distribution<double> mantissa{-1, 1};
    std::uniform_int_distribution<int> exponent{-300, 300};
    for (int k = 0; k < 1000; ++k) {
        const double value = std::ldexp(mantissa(random), exponent(random));
        std::string text;
        demo::append_number(text, value);
        CHECK(demo::parse_finite(text) == value);
    }
    CHECK(demo::grouped(0) == "0");
    CHECK(demo::grouped(999) == "999");
    CHECK(demo::grouped(1234567) == "1,234,567");
    CHECK_FALSE(demo::parse_finite("nan"));
    CHECK_FALSE(demo::parse_finite("1 "));
    CHECK_FALSE(demo::parse_finite(""));
}

TEST_CASE("touch_terrain trace: stays small and keeps the firmest update", "[touch_terrain]") {
    demo::ForceTrace trace;
    constexpr int updates = 300'000, firmest = 123'457;
    for (int k = 0; k < updates; ++k) {
        demo::TracePoint point;
        point.t = k;
        point.force = k == firmest ? 2.0 : 1.0;
        trace.add(point);
    }
    const auto& points = trace.points();
    CHECK(points.size() <= 8192);
    CHECK(points.size() > 4000);
    CHECK(std::ranges::max(points, {}, &demo::TracePoint::force).t == firmest);
    CHECK(std::ranges::is_sorted(points, {}, &demo::TracePoint::t));
    CHECK(points.front().t == 0);
}

TEST_CASE("touch_terrain trace: stays small and keeps the shape of the path", "[touch_terrain]") {
    demo::PathTrace trace;
    constexpr int updates = 300'000,
                  each = 3'000; // a hundred times round a circle of 1 m, and a while at rest
    for (int k = 0; k < updates; ++k) {
        const double turn = 2 * 3.14159265358979 * k / each;
        demo::TracePoint point;
        point.at = {std::cos(turn), std::sin(turn)};
        point.force = k == 777 ? 2.0 : 1.0;
        for (int rest = 0; rest < (k == 5 ? 100'000 : 1); ++rest) trace.add(point);
    }
    const auto& points = trace.points();
    CHECK(points.size() <= 65536);
    CHECK(points.size() > 4000);
    CHECK(std::ranges::max(points, {}, &demo::TracePoint::force).force == 2.0);
    double widest = 0; // 628 m in at least 4000 points
    for (std::size_t k = 1; k < points.size(); ++k) {
        widest = std::max(widest, glm::distance(points[k - 1].at, points[k].at));
    }
    CHECK(widest < 0.2);
}

TEST_CASE("touch_terrain path: reads LF, CRLF, blanks and a last row without an end", "[touch_terrain]") {
    const Folder folder;
    for (const std::string end : {"\n", "\r\n"}) {
        folder.text("p.csv", "t,x,y,z" + end + "0,1,2,3" + end + " 0 , -1e-3,\t2.5 ,3" + end + "1,4,5,6");
        demo::StylusPathFile path{folder / "p.csv"};
        CHECK(path.next()->position == glm::dvec3{1, 2, 3});
        CHECK(path.next()->position == glm::dvec3{-1e-3, 2.5, 3});
        const auto last = path.next();
        REQUIRE(last);
        CHECK(last->t == 1);
        CHECK(last->position == glm::dvec3{4, 5, 6});
        CHECK_FALSE(path.next());
        CHECK(path.progress() == 1.0);
    }
}

TEST_CASE("touch_terrain stroke: 20 s at 1 kHz, from the air to the ground and back", "[touch_terrain]") {
    const auto ground = flat(100);
    const auto stroke = demo::built_in_stroke(ground, demo::stroke_depth(ground));
    REQUIRE(stroke.size() == 20000);
    CHECK(stroke.front().position.z > 100);
    CHECK(stroke.back().position.z > 100);
    CHECK(stroke[10000].position.z == Approx(100 - demo::stroke_depth(ground)));
    for (std::size_t k = 0; k < stroke.size(); ++k) {
        CHECK(stroke[k].t == Approx(static_cast<double>(k) / 1000));
        const auto at = stroke[k].position;
        if (!(at.x > 0 && at.x < 1000 && at.y > 0 && at.y < 500)) FAIL("off the terrain at " << k);
    }
    // Presses with 0.5 to 3 N at the default stiffness.
    const double force = demo::default_stiffness(ground) * demo::stroke_depth(ground);
    CHECK(force > 0.5);
    CHECK(force < 3.0);
}

TEST_CASE("touch_terrain stroke: is in the air over holes", "[touch_terrain]") {
    auto ground = flat(100);
    ground.height = [](glm::dvec2 at) {
        return at.x > 400 && at.x < 450 ? std::numeric_limits<double>::quiet_NaN() : 100.0;
    };
    for (const auto& sample : demo::built_in_stroke(ground, demo::stroke_depth(ground))) {
        if (std::isnan(ground.height({sample.position.x, sample.position.y}))) {
            if (!(sample.position.z > 100)) FAIL("below the rim at t = " << sample.t);
        }
    }
    ground.height = [](glm::dvec2) { return std::numeric_limits<double>::quiet_NaN(); };
    for (const auto& sample : demo::built_in_stroke(ground, demo::stroke_depth(ground))) {
        if (!std::isfinite(sample.position.z)) FAIL("no height at t = " << sample.t);
    }
}

TEST_CASE("touch_terrain device: holds what its guard lets through, and no more", "[touch_terrain]") {
    // A hand at rest for a second, 10 m of terrain to a metre, and as much force upwards as the device can.
    const std::vector<demo::StylusSample> rest{{0, {500, 250, 100}}, {1, {500, 250, 100}}};
    const auto after = [&](double seconds, bool buried) {
        demo::DeviceInHand device{hfh::simulated_touch, {.scale = 10, .offset = {500, 250, 100}}, 500, rest};
        hfh::ForceGuard guard{device.loop().limits};
        hfh::Workspace<double> workspace{device.loop().workspace};
        demo::StylusSample sample;
        while (const auto next = device.next()) {
            sample = {next->t, workspace.update(next->sample.position)};
            if (sample.t > seconds) break;
            const auto felt = guard.update(next->sample, workspace.force_at_hand({0, 0, 1e6}), buried);
            device.feel(felt.newtons, buried);
            CHECK(felt.newtons.z <= 3.3 * std::min(1.0, sample.t / 0.5) * (1 + 1e-9));
            CHECK((felt.trip == hfh::GuardTrip::buried) == buried);
            CHECK((!buried || felt.newtons == glm::dvec3{0.0}));
        }
        return (sample.position.z - 100) / 10; // metres in the hand
    };
    CHECK(after(0.001, true) == 0);
    // 3.3 N against a grip of 300 N/m and a friction of 0.26 N, at a quarter of the ramp and after it.
    CHECK(after(0.125, false) < 3.3 / 4 / 300);
    CHECK(after(0.125, false) > 0.2 * 3.3 / 4 / 300);
    CHECK(after(0.9, false) == Approx(3.3 / 300).epsilon(0.1));
}

TEST_CASE("touch_terrain device: below the surface the hand moves up until it is out, then back",
          "[touch_terrain]") {
    // A hand at rest for a second, 10 m of terrain to a metre, 4 mm of hand below the surface.
    const std::vector<demo::StylusSample> rest{{0, {500, 250, 100}}, {1, {500, 250, 100}}};
    demo::DeviceInHand device{hfh::simulated_touch, {.scale = 10, .offset = {500, 250, 100}}, 500, rest};
    constexpr double lag =
        0.26 / 300 + 0.1 * 4 / 300; // m: friction against the grip, and its damping at 0.1 m/s
    double out = 0, highest = 0, last = 0;
    while (const auto next = device.next()) {
        const glm::dvec3 position = device.workspace().to_terrain(next->sample.position);
        CHECK(position.x == 500);
        last = (position.z - 100) / 10; // metres in the hand
        highest = std::max(highest, last);
        if (out == 0 && last > 0.004) out = next->t;
        device.feel({0, 0, 0}, out == 0);
    }
    CHECK(out > 0.004 / 0.1);
    CHECK(out < (0.004 + 2 * lag) / 0.1);
    CHECK(highest < 0.004 + 2 * lag);
    CHECK(std::abs(last) < lag);
}

TEST_CASE("touch_terrain relief: north is in the last row, and north-west slopes are lit",
          "[touch_terrain]") {
    auto ground = flat(0);
    ground.height = [](glm::dvec2 at) { return at.y; }; // rises to the north: snow there
    const auto brightness = [](const demo::Raster& raster, int i, int j) {
        return raster.rgb[3 * static_cast<std::size_t>(j * raster.columns + i) + 2];
    };
    const auto rising = demo::shaded_relief(ground, {{0, 0}, {1000, 500}}, 40, 20);
    CHECK(rising.rgb.size() == 3 * 40 * 20);
    CHECK(rising.lowest < 20);
    CHECK(rising.highest > 480);
    CHECK(brightness(rising, 20, 19) > brightness(rising, 20, 0));

    ground.height = [](glm::dvec2 at) { return -std::abs(at.x - 500); }; // a ridge from south to north
    const auto ridge = demo::shaded_relief(ground, {{0, 0}, {1000, 500}}, 40, 20);
    CHECK(brightness(ridge, 10, 10) > brightness(ridge, 29, 10));
}
