// Step 4: a hand that moves a few centimetres touches kilometres of terrain.

#include <hfh/device/workspace.hpp>
#include <hfh/hfh.hpp>

#include <cmath>
#include <cstdio>
#include <vector>

int main() {
    const std::vector<float> level(101 * 101, 500.0f); // 10 km × 10 km, 500 m up
    const hfh::BilinearGrid grid{hfh::HeightView{level.data(), 101, 101}, {.spacing = {100.0, 100.0}}};
    hfh::ProxyTracker tracker{grid};

    // 1 cm of the hand is 500 m of the terrain, and the middle of the device lies in the middle of the ground.
    hfh::Workspace<double> workspace{{.scale = 50000, .offset = {5000, 5000, 500}}};
    const double stiffness = workspace.terrain_stiffness(400); // of the terrain, for 400 N/m at the hand
    const hfh::ForceEvaluator<double> force{.stiffness = stiffness};

    double felt = 0;
    for (const double z : {0.005, -0.001, -0.002}) { // metres, as the device tells them
        const auto contact = tracker.update(workspace.update({0.01, 0.0, z}));
        felt = workspace.force_at_hand(force(contact).newtons).z;
        std::printf("hand at %4.1f mm: stylus at z = %5.0f m, %.2f N at the hand\n", 1000 * z,
                    workspace.to_terrain({0.01, 0.0, z}).z, felt);
    }
    return std::abs(felt - 0.8) < 1e-9 ? 0 : 1;
}
