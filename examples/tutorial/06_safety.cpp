// Step 6: everything from the device's sample to its force in one object, with a guard before the motors.

#include <hfh/hfh.hpp>
#include <hfh/loop/haptic_loop.hpp>
#include <hfh/simulation/simulated_device.hpp>

#include <cstdio>
#include <limits>
#include <vector>

int main() {
    const std::vector<float> level(65 * 65);
    const hfh::BilinearGrid grid{hfh::HeightView{level.data(), 65, 65}, {.spacing = {10.0, 10.0}}};

    const double stiffness = 400; // N/m, felt at the hand
    const hfh::DeviceCapabilities device = hfh::simulated_touch.capabilities;
    hfh::HapticLoop loop{grid,
                         {.workspace = {.scale = 4000, .offset = {320, 320, 0}},
                          .material = {.stiffness = stiffness},
                          .limits = hfh::guard_limits(device, stiffness)}};

    // A hand that goes down by 10 mm in a second, and a device whose position is no number for one update.
    double before = 0, during = 1;
    for (int k = 0; k < 1000; ++k) {
        hfh::DeviceSample sample{.time = k * 0.001, .position = {0, 0, 0.002 - 0.00001 * k}};
        if (k == 900) sample.position.x = std::numeric_limits<double>::quiet_NaN();
        const double newtons = loop.update(sample).newtons.z;
        if (k == 899) before = newtons;
        if (k == 900) during = newtons;
    }
    std::printf("%.1f N before the bad sample, %g N with it\n", before, during);
    for (int k = 1; k < hfh::guard_trip_count; ++k) {
        const auto trip = static_cast<hfh::GuardTrip>(k);
        if (loop.guard().counts().trips[k] > 0) std::printf("tripped by %s\n", hfh::to_string(trip));
    }
    return before > 1 && during == 0 ? 0 : 1;
}
