#ifndef HFH_TESTS_PRESSES_HPP
#define HFH_TESTS_PRESSES_HPP

#include <hfh/simulation/simulated_device.hpp>

#include <algorithm>
#include <cmath>

// A hand that presses a wall of a simulated device and leaves it, again and again; what it feels and gets.

namespace hfh::test {

/// From 2 mm above to `depth` below z = 0, 0.2 s there, back, 0.2 s above; both ways at `speed`.
struct Presses {
    double depth = 0.01, speed = 0.1; ///< m, m/s
    [[nodiscard]] double way() const noexcept { return (depth + 0.002) / speed; }
    [[nodiscard]] double period() const noexcept { return 2 * way() + 0.4; }
    [[nodiscard]] glm::dvec3 operator()(double t) const noexcept {
        const double u = std::fmod(t, period()), down = std::min(u, way()),
                     up = std::clamp(u - way() - 0.2, 0.0, way());
        return {0, 0, 0.002 - speed * (down - up)};
    }
    /// In the last 50 ms of the stay below.
    [[nodiscard]] bool holds(double t) const noexcept {
        const double u = std::fmod(t, period());
        return way() + 0.15 <= u && u < way() + 0.2;
    }
};

/// What came of some presses.
struct Pressed {
    double depth = 0;  ///< m, the deepest while the hand stays below
    double most = 0;   ///< N, the largest force
    double lowest = 0; ///< J, the least that the hand was ahead by: motors' work at the real positions
    double last = 0;   ///< J, the same at the end
    double rise = 0;   ///< N, the largest step of the force from one update to the next
    double beyond = 0; ///< N, by how much a step was larger than K times the step of the position
    long updates = 0;  ///< in which the spring gives a force
    long empty = 0;    ///< of these, without any force
};

/// `control(position, newtons)` gives the force for what a wall of `stiffness` asks.
template <class Control>
[[nodiscard]] Pressed press_wall(const DeviceModel& model, const HandGrip& grip, const Presses& hand,
                                 int times, double stiffness, Control&& control) {
    SimulatedDevice device{model, grip, hand, times * hand.period()};
    Pressed out;
    double force = 0, told = device.sample().position.z;
    while (device.time() < times * hand.period()) {
        const auto sample = device.sample();
        const double z = sample.position.z;
        const double wanted = z < 0 ? -stiffness * z : 0;
        const double newtons = control(sample.position, glm::dvec3{0, 0, wanted}).z;
        out.updates += wanted > 0;
        out.empty += wanted > 0 && newtons == 0;
        out.most = std::max(out.most, newtons);
        out.rise = std::max(out.rise, std::abs(newtons - force));
        out.beyond = std::max(out.beyond, std::abs(newtons - force) - stiffness * std::abs(z - told));
        force = newtons;
        told = z;
        if (hand.holds(device.time())) out.depth = std::max(out.depth, -device.position().z);
        const double from = device.position().z;
        device.step({0, 0, newtons});
        out.last -= device.held().z * (device.position().z - from);
        out.lowest = std::min(out.lowest, out.last);
    }
    return out;
}

} // namespace hfh::test

#endif // HFH_TESTS_PRESSES_HPP
