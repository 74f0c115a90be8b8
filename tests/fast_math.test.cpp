#include "catch.hpp"
#include "support/numbers.hpp"
#include "support/terrains.hpp"

#include <hfh/contact/ball_tracker.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/device/limit_cycle_filter.hpp>
#include <hfh/force/damping.hpp>
#include <hfh/force/force_evaluator.hpp>
#include <hfh/geometry/lattice.hpp>
#include <hfh/terrain/min_max_pyramid.hpp>

#include <array>
#include <vector>

// What comes from outside and is no number: positions, samples, parameters. Run twice, as the other tests are and, with
// those of the tracker and the guard, under -ffast-math, where Clang 19 once took every number for one. The numbers are
// made where no compiler sees them.

using namespace hfh;
using namespace hfh::test;

namespace {

template <Real T>
std::array<T, 5> no_numbers() {
    const T nan = hidden_nan<T>(), inf = hidden_infinity<T>();
    return {nan, made_of<T>(bits_of_infinity<T> | 1), made_of<T>(sign_bit<T> | bits_of_infinity<T> | 1), inf,
            made_of<T>(sign_bit<T> | bits_of_infinity<T>)};
}

template <Real T>
bool is_zero(const vec3<T>& p) {
    return p.x == 0 && p.y == 0 && p.z == 0;
}

} // namespace

TEMPLATE_TEST_CASE("fast_math: what is no number is told from what is one", "[fast_math][hard]", float,
                   double) {
    using T = TestType;
    int limits = 0;
    for (const T bad : no_numbers<T>()) {
        CHECK_FALSE(is_finite(bad));
        CHECK_FALSE(is_finite(vec3<T>{1, bad, 1}));
        CHECK_FALSE(is_at_least_zero(bad));
        limits += is_upper_limit(bad);
        CHECK_FALSE(Lattice{{0, 0}, {1, widen(bad)}}.valid());
        CHECK_FALSE(Lattice{{widen(bad), 0}, {1, 1}}.valid());
    }
    for (const T good : {made_of<T>(0), made_of<T>(sign_bit<T>), std::numeric_limits<T>::max(), T(-1)}) {
        CHECK(is_finite(good));
    }
}

TEMPLATE_TEST_CASE("fast_math: a sample that is no number is a hole, in a grid and in its bounds",
                   "[fast_math][hard]", float, double) {
    using T = TestType;
    constexpr Index side = 70;
    for (const T bad : no_numbers<T>()) {
        for (const Index i : {Index{0}, Index{5}, Index{33}, side - 1}) {
            auto ground = plane<T>(side, side);
            ground.at(i, 40) = bad;
            const auto grid = ground.grid();
            for (Index j = 38; j < 42; ++j) {
                for (Index k = glm::max<Index>(i - 2, 0); k < glm::min<Index>(i + 2, side - 1); ++k) {
                    const bool touches = (k == i || k == i - 1) && (j == 40 || j == 39);
                    CHECK(grid.patch({k, j}).has_value() == !touches);
                }
            }
            std::vector<SampleRange<T>> storage(static_cast<std::size_t>(MinMaxPyramid<T>::size(side, side)));
            BoundedGrid bounded{grid, storage.data(), std::ssize(storage)};
            REQUIRE(bounded.build() == PyramidStatus::ok);
            const Block block{glm::min(i, side - 2) >> MinMaxPyramid<T>::block_bits,
                              Index{40} >> MinMaxPyramid<T>::block_bits};
            CHECK(bounded.bounds().range(0, block).holed());
            CHECK_FALSE(bounded.bounds().range(0, {1, 0}).holed());
            ProxyTracker tracker{grid};
            const T x = static_cast<T>(i) + (i == 0 ? T(0.5) : T(-0.5));
            CHECK(tracker.update({x, T(39.5), T(1)}).status == ContactStatus::off_surface);
            CHECK(tracker.update({x, T(39.5), T(-1)}).status == ContactStatus::off_surface);
            CHECK(tracker.update({T(20), T(20), T(1)}).status == ContactStatus::free);
            CHECK(tracker.update({T(20), T(20), T(-1)}).status == ContactStatus::contact);
        }
    }
}

TEMPLATE_TEST_CASE("fast_math: good positions are felt after bad ones", "[fast_math][hard]", float, double) {
    using T = TestType;
    const auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    const ForceEvaluator<T> force{};
    for (const T bad : no_numbers<T>()) {
        for (int axis = 0; axis < 3; ++axis) {
            vec3<T> p{T(4.5), T(4.5), T(0.5)};
            p[axis] = bad;
            ProxyTracker tracker{grid};
            CHECK(tracker.update(p).status == ContactStatus::bad_input);
            CHECK(tracker.update({T(4.5), T(4.5), T(0.5)}).status == ContactStatus::free);
            CHECK(tracker.update(p).status == ContactStatus::bad_input);
            CHECK(tracker.update({T(4.5), T(4.5), T(-0.5)}).status == ContactStatus::contact);
            CHECK(is_zero(force(tracker.update(p)).newtons));
            CHECK(force(tracker.update({T(4.5), T(4.5), T(-0.5)})).newtons.z == T(250));
        }
    }
}

TEMPLATE_TEST_CASE("fast_math: parameters that are no numbers give no force", "[fast_math][hard]", float,
                   double) {
    using T = TestType;
    const auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid};
    (void)tracker.update({T(4.5), T(4.5), T(0.5)});
    const vec3<T> stylus{T(4.5), T(4.5), T(-0.5)};
    const auto contact = tracker.update(stylus);
    REQUIRE(contact.touching());
    for (const T bad : no_numbers<T>()) {
        CHECK(is_zero(ForceEvaluator<T>{.stiffness = bad}(contact).newtons));
        if (!is_upper_limit(bad)) {
            CHECK(is_zero(ForceEvaluator<T>{.stiffness = T(500), .max_force = bad}(contact).newtons));
        }
        const ForceEvaluator<T> force{};
        CHECK(Damping<T>{bad, T(1)}(force, contact, {1, 1, 1}).newtons.z == T(250));
        CHECK(Damping<T>{T(1), T(1)}(force, contact, {1, bad, 1}).newtons.z == T(250));
        Friction<T> friction{{bad, T(0.5)}};
        CHECK(friction.hold(grid, contact, stylus).penetration == contact.penetration);
        CHECK(BallTracker{grid, bad}.radius() == 0);
        const GridFrame frames[]{{.origin = {widen(bad), 0}},
                                 {.spacing = {1, widen(bad)}},
                                 {.height_scale = widen(bad)},
                                 {.height_offset = widen(bad)}};
        for (const GridFrame& frame : frames) {
            CHECK(BilinearGrid<T, HeightView<T>>{HeightView<T>{ground.heights.data(), 9, 9}, frame}
                      .cells()
                      .empty());
        }
        LimitCycleFilter steady{widen(bad)};
        bool passed = true;
        for (int k = 0; k < 9; ++k) passed = passed && steady({k % 2 * 1.0, 0, 0}).x == k % 2;
        CHECK(passed);
    }
}
