#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/random.hpp"

#include <hfh/device/limit_cycle_filter.hpp>
#include <hfh/force/virtual_coupling.hpp>
#include <hfh/simulation/simulated_device.hpp>

#include <cmath>
#include <limits>
#include <vector>

using namespace hfh;
using namespace hfh::test;

namespace {

constexpr double step = 0.03e-3;

/// Counts on one axis, as positions; what comes out, in counts.
std::vector<double> steadied(const std::vector<int>& counts, int axis = 2) {
    LimitCycleFilter steady{step};
    std::vector<double> out;
    for (const int count : counts) {
        glm::dvec3 position{0.0};
        position[axis] = count * step;
        out.push_back(steady(position)[axis] / step);
    }
    return out;
}

bool same(const std::vector<double>& got, const std::vector<double>& expected) {
    if (got.size() != expected.size()) return false;
    for (std::size_t k = 0; k < got.size(); ++k) {
        if (std::abs(got[k] - expected[k]) > 1e-9) return false;
    }
    return true;
}

/// A hand that goes 2 mm + `depth` down within 0.3 s and keeps still.
struct Press {
    double depth;
    glm::dvec3 operator()(double t) const noexcept {
        return {0, 0, 2e-3 - (2e-3 + depth) * std::min(1.0, t / 0.3)};
    }
};

/// Of 200 presses of a wall, on how many the device does not come to rest.
int trembling(double stiffness, bool steadies) {
    int trembling = 0;
    for (int n = 0; n < 200; ++n) {
        SimulatedDevice device{simulated_premium, {}, Press{(0.5 + n * 0.0125) / 300}, 2};
        LimitCycleFilter steady{simulated_premium.capabilities.resolution};
        bool moves = false;
        auto sample = device.sample();
        for (int k = 0; k < 2000; ++k) {
            const glm::dvec3 at = steadies ? steady(sample.position) : sample.position;
            sample = device.step({0, 0, at.z < 0 ? -stiffness * at.z : 0});
            moves = moves || (k >= 1500 && device.velocity() != glm::dvec3{0.0});
        }
        trembling += moves;
    }
    return trembling;
}

} // namespace

TEST_CASE("LimitCycleFilter: two neighbouring steps in turn become their middle", "[limit_cycle_filter]") {
    for (int axis = 0; axis < 3; ++axis) {
        CHECK(same(steadied({7, 8, 7, 8, 7, 7, 8, 8, 7}, axis), {7, 8, 7, 8, 7.5, 7.5, 7.5, 7.5, 7.5}));
        CHECK(same(steadied({0, -1, -1, 0, 0, -1, 0, -1}, axis), {0, -1, -1, 0, 0, -1, -0.5, -0.5}));
    }
    // It leaves upwards or downwards, and is steadied again where it stops.
    CHECK(same(steadied({7, 8, 7, 8, 7, 8, 9, 10}), {7, 8, 7, 8, 7.5, 7.5, 9, 10}));
    CHECK(same(steadied({7, 8, 7, 8, 7, 6, 7, 6, 7, 6}), {7, 8, 7, 8, 7.5, 6, 7, 6, 6.5, 6.5}));
    // A swing over three steps, and one between steps that are no neighbours, are motions.
    CHECK(same(steadied({7, 8, 9, 8, 7, 8, 9, 8, 7}), {7, 8, 9, 8, 7, 8, 9, 8, 7}));
    CHECK(same(steadied({7, 9, 7, 9, 7, 9}), {7, 9, 7, 9, 7, 9}));
    CHECK(same(steadied({0, 1, -1, 0, 1, -1, 0}), {0, 1, -1, 0, 1, -1, 0}));
}

TEST_CASE("LimitCycleFilter: is never off by more than half a step, and not at all on a way with fewer than "
          "three turns",
          "[limit_cycle_filter][law]") {
    Random random{81};
    for (int walk = 0; walk < 200; ++walk) {
        LimitCycleFilter steady{step};
        double count[3] = {0, 0, 0};
        int turned[3] = {0, 0, 0}, way[3] = {0, 0, 0};
        const bool turns = walk % 2 == 0;
        for (int k = 0; k < 500; ++k) {
            glm::dvec3 position;
            for (int axis = 0; axis < 3; ++axis) {
                const auto d = static_cast<int>(turns ? random.whole(-1, 1) : random.whole(0, 3));
                count[axis] += d;
                turned[axis] += d * way[axis] < 0;
                if (d != 0) way[axis] = d;
                position[axis] = count[axis] * step;
            }
            const glm::dvec3 out = steady(position);
            for (int axis = 0; axis < 3; ++axis) {
                if (turned[axis] < 3) CHECK(out[axis] == position[axis]); // to the bit
                CHECK(std::abs(out[axis] - position[axis]) <= 0.5 * step * (1 + 1e-9));
            }
        }
    }
}

TEST_CASE("LimitCycleFilter: a device comes to rest up to twice the stiffness that its encoders allow",
          "[limit_cycle_filter]") {
    const double bound = 2 * simulated_premium.dry / simulated_premium.capabilities.resolution; // 2667 N/m
    CHECK(trembling(0.99 * bound, false) == 0);
    CHECK(trembling(simulated_premium.capabilities.max_stiffness, false) == 0); // 800 N/m
    CHECK(trembling(3500, false) > 10);
    CHECK(trembling(3500, true) == 0);
    CHECK(trembling(1.9 * bound, false) > 50);
    CHECK(trembling(1.9 * bound, true) == 0);
}

TEST_CASE("LimitCycleFilter: starts anew after what is no number", "[limit_cycle_filter]") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    LimitCycleFilter steady{step}, fresh{step};
    for (int k = 0; k < 9; ++k) (void)steady({k % 2 * step, 0, 0});
    (void)steady({nan, nan, nan});
    for (int k = 0; k < 9; ++k) {
        const glm::dvec3 at{k % 2 * step, 0, 0};
        CHECK(steady(at) == fresh(at));
    }
    // A position of 0 is one like every other, first or not.
    constexpr double exact = 0x1p-15; // 1 + exact is a double
    LimitCycleFilter at_zero{exact}, elsewhere{exact};
    for (int k = 0; k < 9; ++k) {
        const double x = k % 2 * exact;
        CHECK(at_zero({x, 0, 0}).x == elsewhere({1 + x, 0, 0}).x - 1);
    }
}

TEST_CASE("LimitCycleFilter: does not cure a light grip that swings, a coupling does, or less stiffness",
          "[limit_cycle_filter]") {
    const HandGrip light{100, 0.5};
    /// Of 40 presses, how many still swing by more than a millimetre in the last half second of two.
    const auto swinging = [&](double stiffness, bool steadies, bool couples) {
        int count = 0;
        for (int n = 0; n < 40; ++n) {
            SimulatedDevice device{simulated_premium, light, Press{(0.5 + n * 0.0625) / light.stiffness}, 2};
            LimitCycleFilter steady{steadies ? simulated_premium.capabilities.resolution : 0};
            VirtualCoupling coupling{{.stiffness = couples ? stiffness : 0}};
            double low = 1, high = -1;
            for (int k = 0; k < 2000; ++k) {
                const glm::dvec3 at = steady(device.sample().position);
                device.step(coupling(at, {0, 0, at.z < 0 ? -stiffness * at.z : 0}).newtons);
                if (k < 1500) continue;
                low = std::min(low, device.position().z);
                high = std::max(high, device.position().z);
            }
            count += high - low > 1e-3;
        }
        return count;
    };
    CHECK(swinging(3500, false, false) >= 20);
    CHECK(swinging(3500, true, false) >= 20);
    CHECK(swinging(3500, true, true) == 0);
    CHECK(swinging(3500, false, true) == 0);
    const double bears = (simulated_premium.viscous + light.damping) / 0.5e-3; // 1010 N/m
    CHECK(swinging(0.8 * bears, false, false) == 0);
}

TEST_CASE("LimitCycleFilter: with encoders in the joints it steadies nothing while two of them tremble",
          "[limit_cycle_filter]") {
    const double link = 0.2, count = step / link;
    for (const bool both : {false, true}) {
        LimitCycleFilter steady{step};
        int acted = 0;
        for (int k = 0; k < 4000; ++k) { // by one count, at different beats
            const double q1 = 0.7 + count * (k / 3 % 2), q2 = 1.1 + (both ? count * (k / 4 % 2) : 0);
            const glm::dvec3 told{link * std::cos(q1) + link * std::cos(q1 + q2), 0,
                                  link * std::sin(q1) + link * std::sin(q1 + q2)};
            acted += steady(told) != told;
        }
        if (both)
            CHECK(acted == 0);
        else
            CHECK(acted > 3900); // where one trembles, its two positions come back to the bit
    }
}

TEST_CASE("LimitCycleFilter: passes on what is no number, and allocates nothing", "[limit_cycle_filter]") {
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    const auto before = allocations();
    LimitCycleFilter steady{step};
    (void)steady({0, 0, 0});
    const glm::dvec3 bad = steady({nan, inf, -inf});
    const glm::dvec3 next = steady({step, step, 0});
    bool passed = true;
    for (const double no_step : {0.0, -0.0, -step, nan, -nan, inf, -inf}) {
        LimitCycleFilter none{no_step};
        for (int k = 0; k < 20; ++k) {
            const glm::dvec3 at{k % 2 * step, 0, 0};
            passed = passed && none(at) == at;
        }
    }
    steady.reset();
    (void)steady({0, 0, 0});
    const auto after = allocations();
    CHECK(after == before);
    CHECK(std::isnan(bad.x));
    CHECK(bad.y == inf);
    CHECK(bad.z == -inf);
    CHECK(next == glm::dvec3{step, step, 0});
    CHECK(passed);
}
