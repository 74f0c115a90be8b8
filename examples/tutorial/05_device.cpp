// Step 5: a device that runs the loop, here a simulated one.

#include <hfh/device/workspace.hpp>
#include <hfh/hfh.hpp>
#include <hfh/simulation/simulated_device.hpp>

#include <cmath>
#include <cstdio>
#include <vector>

int main() {
    const std::vector<float> level(65 * 65);
    const hfh::BilinearGrid grid{hfh::HeightView{level.data(), 65, 65}, {.spacing = {10.0, 10.0}}};
    hfh::ProxyTracker tracker{grid};
    hfh::Workspace<double> workspace{{.scale = 4000, .offset = {320, 320, 0}}};
    const hfh::ForceEvaluator<double> force{.stiffness = workspace.terrain_stiffness(200)};

    // The hand wants to be up to 20 mm below the ground and back within two seconds.
    const auto hand = [](double t) { return glm::dvec3{0, 0, 0.02 * std::cos(3.14159 * t)}; };
    hfh::SimulatedDevice device{hfh::simulated_touch, hfh::HandGrip{}, hand, 2.0};

    double deepest = 0;
    const hfh::DeviceEnd end = device.run([&](const hfh::DeviceSample& sample) -> hfh::DeviceCommand {
        const auto contact = tracker.update(workspace.update(sample.position));
        deepest = std::fmax(deepest, -sample.position.z);
        return {workspace.force_at_hand(force(contact).newtons)};
    });
    std::printf("%s after %g s; the ground held the hand at %.1f mm of the 20 mm that it wanted\n",
                hfh::to_string(end), device.time(), 1000 * deepest);
    return deepest > 0.005 && deepest < 0.015 ? 0 : 1;
}
