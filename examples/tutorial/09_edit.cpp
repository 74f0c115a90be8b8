// Step 9: ground that changes while it is touched.

#include <hfh/hfh.hpp>

#include <cstdio>
#include <vector>

int main() {
    std::vector<double> samples(9 * 9);
    const hfh::BilinearGrid grid{hfh::HeightView{samples.data(), 9, 9}, {.spacing = {0.01, 0.01}}};
    hfh::ProxyTracker tracker{grid};
    const hfh::ForceEvaluator<double> force{.stiffness = 500};

    // Where the stylus pushes with more than 1 N, the sample below it gives way by a micrometre an update.
    double newtons = 0;
    (void)tracker.update({0.04, 0.04, 0.001});
    for (int k = 0; k < 3000; ++k) {
        newtons = force(tracker.update({0.04, 0.04, -0.004})).newtons.z;
        if (newtons > 1) samples[4 + 4 * 9] -= 1e-6; // between two updates, never during one
    }
    std::printf("the ground sank by %.2f mm and bears %.2f N now\n", -1000 * samples[4 + 4 * 9], newtons);
    return newtons < 1.01 && newtons > 0.9 ? 0 : 1;
}
