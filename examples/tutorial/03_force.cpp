// Step 3: a contact becomes a force.

#include <hfh/hfh.hpp>

#include <cstdio>
#include <vector>

int main() {
    const std::vector<float> level(5 * 5);
    const hfh::BilinearGrid grid{hfh::HeightView{level.data(), 5, 5}, {.spacing = {1.0, 1.0}}};
    hfh::ProxyTracker tracker{grid};

    const hfh::ForceEvaluator<double> force{.stiffness = 100, .max_force = 3.0}; // N/m, N
    bool clamped = false;
    for (const double depth : {-0.01, 0.01, 0.02, 0.05}) {
        const auto contact = tracker.update({2.0, 2.0, -depth});
        const auto push = force(contact);
        std::printf("%5.0f mm deep: %.1f N%s\n", 1000 * depth, push.newtons.z,
                    push.clamped ? ", cut off" : "");
        clamped = push.clamped;
    }
    return clamped ? 0 : 1;
}
