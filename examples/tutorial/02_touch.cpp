// Step 2: a stylus comes down on the surface and moves along in it.

#include <hfh/hfh.hpp>

#include <cstdio>
#include <vector>

int main() {
    const std::vector<float> level(5 * 5, 2.0f); // level ground, 2 m high
    const hfh::BilinearGrid grid{hfh::HeightView{level.data(), 5, 5}, {.spacing = {1.0, 1.0}}};

    hfh::ProxyTracker tracker{grid};
    hfh::Contact<double> contact;
    for (const double z : {3.0, 2.5, 1.9, 1.8}) {
        contact = tracker.update({2.0, 2.0, z});
        std::printf("stylus at z = %.1f m: %s, proxy at z = %.1f m, %.1f m deep\n", z,
                    hfh::to_string(contact.status), contact.proxy.z, contact.depth);
    }
    return contact.touching() && contact.proxy.z == 2.0 ? 0 : 1;
}
