#include <hfh/hfh.hpp>

#include <cstdint>
#include <cstdio>

// What a first program does: look at heights, track a stylus, ask for the force. Compiled without exceptions and RTTI.
int main() {
    const std::int16_t samples[] = {0, 0, 0, 0, 5, 0, 0, 0, 0};
    const hfh::HeightView heights{samples, 3, 3};
    const hfh::BilinearGrid<double, hfh::HeightView<std::int16_t>> grid{heights, {.spacing = {10.0, 10.0}}};
    hfh::ProxyTracker tracker{grid};
    const hfh::ForceEvaluator<double> force{.stiffness = 500.0, .max_force = 3.3};

    const auto above = tracker.update({10.0, 10.0, 6.0});
    const auto pressed = tracker.update({10.0, 10.0, 4.0});
    std::printf("hfh %d.%d.%d: %s, then %s with %g N\n", HFH_VERSION_MAJOR, HFH_VERSION_MINOR,
                HFH_VERSION_PATCH, hfh::to_string(above.status), hfh::to_string(pressed.status),
                force(pressed).newtons.z);
    return !above.touching() && pressed.touching() && force(pressed).clamped ? 0 : 1;
}
