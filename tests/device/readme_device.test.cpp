#include "catch.hpp"
#include "support/presses.hpp"

#include <hfh/hfh.hpp>

#include <hfh/device/device.hpp>
#include <hfh/loop/haptic_loop.hpp>
#include <hfh/simulation/simulated_device.hpp>

#include <cmath>
#include <cstdint>
#include <vector>

using namespace hfh::test;

// The loop that README shows for a device, to the letter (test `readme_device`), and what README promises of it.

namespace {

constexpr double wait = 0.6; ///< s above the ground, until the guard's ramp is over

/// A hand that waits, then presses.
struct Hand {
    Presses presses;
    [[nodiscard]] glm::dvec3 operator()(double t) const noexcept { return presses(std::max(0.0, t - wait)); }
};

/// A simulated Touch on level ground, and what the hand feels and gets of it.
class WatchedTouch {
public:
    WatchedTouch(const hfh::HandGrip& grip, const Presses& presses)
        : presses_{presses}, device_{hfh::simulated_touch, grip, Hand{presses}, 3 * presses.period() + wait} {
    }

    [[nodiscard]] hfh::DeviceCapabilities capabilities() const noexcept { return device_.capabilities(); }

    template <hfh::DeviceTick Tick>
    hfh::DeviceEnd run(Tick&& tick) {
        const double seconds = 3 * presses_.period() + wait;
        glm::dvec3 before{0.0};
        while (device_.time() < seconds) {
            const glm::dvec3 newtons = tick(device_.sample()).newtons;
            felt.most = std::max(felt.most, glm::length(newtons));
            felt.rise = std::max(felt.rise, glm::distance(newtons, before));
            before = newtons;
            if (device_.time() >= wait && presses_.holds(device_.time() - wait))
                felt.depth = std::max(felt.depth, -device_.position().z);
            const glm::dvec3 from = device_.position();
            device_.step(newtons);
            felt.last -= glm::dot(device_.held(), device_.position() - from);
            felt.lowest = std::min(felt.lowest, felt.last);
        }
        return hfh::DeviceEnd::stopped;
    }

    Pressed felt;

private:
    Presses presses_;
    hfh::SimulatedDevice<Hand> device_;
};
static_assert(hfh::Device<WatchedTouch>);

/// 640 m of level ground, 100 m up; the middle of the workspace is on it.
constexpr int samples = 65;
const std::vector<std::int16_t> heights(samples* samples, 100);
const hfh::BilinearGrid<double, hfh::HeightView<std::int16_t>> grid{
    hfh::HeightView{heights.data(), samples, samples}, {.spacing = {10.0, 10.0}}};
const glm::dvec3 middle{320, 320, 100};

/// What README's loop makes of it.
void run_as_readme(WatchedTouch& device, hfh::GuardCounts& counts) {
    // clang-format off
const double stiffness = 400;                        // N/m, felt at the hand
hfh::HapticLoop loop{grid, {.workspace = {.scale = 4000, .offset = middle},        // 16 cm of hand, 640 m of terrain
                            .material = {.stiffness = stiffness},
                            .limits = hfh::guard_limits(device.capabilities(), stiffness)}};

const auto end = device.run([&](const hfh::DeviceSample& sample) { return loop.update(sample); });
    // clang-format on
    CHECK(end == hfh::DeviceEnd::stopped);
    counts = loop.guard().counts();
}

/// The spring alone, without any controller or guard.
void run_spring(WatchedTouch& device) {
    device.run([](const hfh::DeviceSample& sample) -> hfh::DeviceCommand {
        return {{0, 0, std::max(0.0, -400 * sample.position.z)}};
    });
}

} // namespace

TEST_CASE("README: the loop for a device keeps depth, steps and balance on the simulated Touch",
          "[readme][virtual_coupling][force_guard]") {
    for (const hfh::HandGrip grip :
         {hfh::HandGrip{100, 0.5}, hfh::HandGrip{300, 4}, hfh::HandGrip{1000, 10}}) {
        for (const double speed : {0.005, 0.02, 0.1, 0.2, 0.5}) {
            const Presses presses{.depth = 0.01, .speed = speed};
            WatchedTouch plain{grip, presses}, device{grip, presses};
            run_spring(plain);
            hfh::GuardCounts counts;
            run_as_readme(device, counts);
            CAPTURE(grip.stiffness, speed, device.felt.rise, plain.felt.rise, device.felt.lowest,
                    plain.felt.lowest);
            if (grip.stiffness >= 300 || speed <= 0.1) // a light grip swings under the spring alone
                CHECK(device.felt.depth == Approx(plain.felt.depth).epsilon(0.1));
            if (speed <= 0.1) CHECK(device.felt.rise <= 0.1);
            CHECK(device.felt.lowest >= -1e-4);
            for (const unsigned times : counts.trips) CHECK(times == 0);
            CHECK(counts.held_back == 0);
            CHECK(counts.slewed == 0);
        }
    }
}
