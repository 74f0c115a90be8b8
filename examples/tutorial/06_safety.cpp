// Step 6: a virtual coupling and a guard before the motors.

#include <hfh/device/force_guard.hpp>
#include <hfh/device/workspace.hpp>
#include <hfh/force/virtual_coupling.hpp>
#include <hfh/hfh.hpp>
#include <hfh/simulation/simulated_device.hpp>

#include <cstdio>
#include <limits>
#include <vector>

int main() {
    const std::vector<float> level(65 * 65);
    const hfh::BilinearGrid grid{hfh::HeightView{level.data(), 65, 65}, {.spacing = {10.0, 10.0}}};
    hfh::Workspace<double> workspace{{.scale = 4000, .offset = {320, 320, 0}}};

    const double stiffness = 400, lag = 0.5; // N/m at the hand; updates
    hfh::ProxyTracker tracker{grid, {.max_contact_patches = 8}};
    const hfh::ForceEvaluator<double> force{.stiffness = workspace.terrain_stiffness(stiffness)};
    hfh::VirtualCoupling coupling{{.stiffness = stiffness, .lag = lag}};
    hfh::GuardLimits limits = hfh::guard_limits(hfh::simulated_touch.capabilities);
    limits.stiffness = (1 + 1.5 * lag) * stiffness;
    hfh::ForceGuard guard{limits};

    const auto tick = [&](const hfh::DeviceSample& sample) -> hfh::DeviceCommand {
        if (sample.force_refused) tracker.reset();
        const auto contact = tracker.update(workspace.update(sample.position));
        const auto asked = workspace.force_at_hand(force(contact).newtons);
        const bool buried = contact.status == hfh::ContactStatus::buried;
        return {guard.update(sample, coupling(sample.position, asked).newtons, buried).newtons};
    };

    // A device whose position becomes no number for one update: the guard sends zero at once.
    double before = 0, during = 1;
    for (int k = 0; k < 1000; ++k) {
        hfh::DeviceSample sample{.time = k * 0.001, .position = {0, 0, 0.002 - 0.00001 * k}};
        if (k == 900) sample.position.x = std::numeric_limits<double>::quiet_NaN();
        const double newtons = tick(sample).newtons.z;
        if (k == 899) before = newtons;
        if (k == 900) during = newtons;
    }
    std::printf("%.2f N before the bad sample, %g N with it\n", before, during);
    for (int k = 1; k < hfh::guard_trip_count; ++k) {
        const auto trip = static_cast<hfh::GuardTrip>(k);
        if (guard.counts().trips[k] > 0) std::printf("tripped by %s\n", hfh::to_string(trip));
    }
    return before > 1 && during == 0 ? 0 : 1;
}
