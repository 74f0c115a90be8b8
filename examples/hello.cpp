// The smallest whole use: pixels with a height in their alpha channel, a stylus, a force. README quotes it.

#include <hfh/hfh.hpp>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace {

/// Stands in for a force-feedback device: a hand that moves down onto the ground, along it, and off again.
class Device {
public:
    [[nodiscard]] bool running() const { return tick_ < 1000; }

    [[nodiscard]] hfh::vec3<double> position() {
        const double t = ++tick_ / 1000.0;
        return {200 + 240 * t, 320 + 30 * t, 44 - 30 * std::sin(3.14159 * t)};
    }

    void send(const hfh::vec3<double>& newtons) const {
        if (tick_ % 100 == 0) {
            std::printf("%4d ms   force %7.3f %7.3f %7.3f N\n", tick_, newtons.x, newtons.y, newtons.z);
        }
    }

private:
    int tick_ = 0;
};

} // namespace

int main() {
    const int width = 64, height = 64;
    std::vector<std::uint8_t> pixels(4 * width * height);
    for (int j = 0; j < height; ++j) {
        for (int i = 0; i < width; ++i) {
            const double hill = 20 + 10 * std::sin(i * 0.4) * std::cos(j * 0.3);
            pixels[static_cast<std::size_t>(4 * (j * width + i) + 3)] = static_cast<std::uint8_t>(hill);
        }
    }
    Device device;

    // clang-format off
hfh::HeightView heights{pixels.data() + 3, width, height, /*column stride*/ 4, /*row stride*/ 4 * width};
hfh::BilinearGrid grid{heights, {.spacing = {10.0, 10.0}, .height_scale = 1.0}};   // metres; nothing is copied
hfh::ProxyTracker tracker{grid};
hfh::ForceEvaluator<double> force{.stiffness = 0.5, .max_force = 3.3};             // N/m, N

while (device.running()) {
    const auto contact = tracker.update(device.position());   // where the surface is ...
    device.send(force(contact).newtons);                      // ... and how hard it pushes back
}
    // clang-format on
}
