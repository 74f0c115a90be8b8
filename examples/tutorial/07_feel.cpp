// Step 7: shading, friction and damping.

#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/force/damping.hpp>
#include <hfh/hfh.hpp>

#include <cstdio>
#include <vector>

int main() {
    const std::vector<float> level(5 * 5);
    const hfh::BilinearGrid grid{hfh::HeightView{level.data(), 5, 5}, {.spacing = {1.0, 1.0}}};
    hfh::ProxyTracker tracker{grid};
    const hfh::ForceEvaluator<double> force{.stiffness = 100};

    hfh::Friction<double> friction{{.at_rest = 0.5, .sliding = 0.4}};
    hfh::VelocityFilter<double> velocity;
    const hfh::Damping<double> damping{.along_normal = 0.1}; // N·s/m

    double along = 0;
    for (int k = 0; k < 500; ++k) {
        // Down to 10 mm below the ground, then along it.
        const glm::dvec3 stylus{1.0 + 0.0002 * k, 2.0, k < 20 ? 0.01 - 0.001 * k : -0.01};
        auto contact = hfh::shade_force(grid, tracker.update(stylus));             // shading first,
        contact = friction.hold(grid, contact, stylus);                            // then friction,
        along = damping(force, contact, velocity.update(stylus, 0.001)).newtons.x; // damping with the force
    }
    std::printf("pressed with 1 N, the ground holds the stylus back with %.2f N\n", -along);
    return -along > 0.35 && -along < 0.45 ? 0 : 1;
}
