// Step 8: holes, the rim of the grid, and a round tip.

#include <hfh/hfh.hpp>
#include <hfh/terrain/dilated_field.hpp>
#include <hfh/terrain/extended_field.hpp>

#include <cstdint>
#include <cstdio>
#include <vector>

int main() {
    std::vector<std::int16_t> samples(9 * 9, 100);
    samples[0] = -9999; // the first corner was not measured

    const hfh::HeightView heights{samples.data(), 9, 9, hfh::MissingValue{-9999}};
    const hfh::BilinearGrid grid{heights, {.spacing = {1.0, 1.0}, .height_scale = 0.01}};
    std::printf("a patch beside the hole: %s, one away from it: %s\n", grid.patch({0, 0}) ? "yes" : "no",
                grid.patch({4, 4}) ? "yes" : "no");

    const hfh::ExtendedField endless{grid};           // the ground goes on beyond the rim
    const hfh::DilatedField ground{endless, 0.25, 2}; // felt with a ball of 25 cm
    hfh::ProxyTracker tracker{ground};
    (void)tracker.update({-5.0, 4.0, 3.0}); // 5 m outside of the grid
    const auto contact = tracker.update({-5.0, 4.0, 1.2});
    std::printf("outside of the grid: %s, the centre of the ball rests at %.2f m\n",
                hfh::to_string(contact.status), contact.proxy.z);
    return !grid.patch({0, 0}) && contact.touching() && contact.proxy.z == 1.25 ? 0 : 1;
}
