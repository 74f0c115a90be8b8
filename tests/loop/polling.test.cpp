#include "catch.hpp"

#include <hfh/device/device.hpp>
#include <hfh/hfh.hpp>
#include <hfh/loop/haptic_loop.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

// The loops that include/hfh/README.md shows for drivers that are asked or exchange, to the letter (tests `readme_polling`,
// `readme_exchange`), with stand-ins of ours for the driver and for time that goes by in uneven steps.

namespace {

constexpr int samples = 33;
const std::vector<std::int16_t> heights(samples* samples, 100);
const hfh::BilinearGrid<double, hfh::HeightView<std::int16_t>> grid{
    hfh::HeightView{heights.data(), samples, samples}, {.spacing = {10.0, 10.0}}};
const hfh::WorkspaceFrame frame{.scale = 1000, .offset = {160, 160, 100}};
constexpr double stiffness = 400;
constexpr hfh::DeviceCapabilities able{.max_force = 4, .max_stiffness = 1000, .rate = 1000};

/// A hand that waits until the guard's ramp is over, goes 5 mm into the ground at 0.05 m/s, and rests there.
struct Driver {
    double time = 10;
    int calls = 0, sends = 0;
    glm::dvec3 newtons{0.0};
    std::vector<double> felt{}, at{};

    void pass() { time += ++calls % 7 == 0 ? 2.1e-3 : 0.4e-3 + 0.1e-3 * (calls % 3); }
    [[nodiscard]] glm::dvec3 position() {
        pass();
        return {0, 0, std::clamp(0.002 - 0.05 * (time - 10.7), -0.005, 0.002)};
    }
    void set_force(const glm::dvec3& force) {
        newtons = force;
        felt.push_back(force.z);
        at.push_back(time);
        ++sends;
    }
    glm::dvec3 exchange(const glm::dvec3& force) {
        set_force(force);
        return position();
    }
};

struct Clock {
    const Driver* driver;
    [[nodiscard]] double now() const { return driver->time; }
};

/// No force in the air, 2 N at the end, and on the way there no more than the spring and the damper of the coupling.
void check(const Driver& driver, const hfh::GuardCounts& counts, double lag) {
    REQUIRE(driver.felt.size() > 1000);
    CHECK(driver.newtons == glm::dvec3{0.0});
    CHECK(driver.felt[driver.felt.size() - 2] == Approx(2).epsilon(1e-9));
    for (const double z : driver.felt) CHECK((z >= 0 && z <= 2 + 1.5 * lag * 400 * 0.05 * 2.2e-3));
    for (const unsigned times : counts.trips) CHECK(times == 0);
    // Of a change of up to 5 N, 1 N a millisecond, whatever a millisecond was.
    for (std::size_t k = 1; k + 1 < driver.felt.size(); ++k)
        CHECK(driver.felt[k] - driver.felt[k - 1] <= 1000 * (driver.at[k] - driver.at[k - 1]) + 1e-9);
    CHECK(counts.held_back == 0);
}

} // namespace

TEST_CASE("README: a loop of your own that asks feels what it should, by the time that went by",
          "[readme][haptic_loop]") {
    Driver driver;
    const Clock clock{&driver};
    const auto running = [&] { return driver.time < 11.5; };
    // clang-format off
hfh::HapticLoop loop{grid, {.workspace = frame,
                            .material = {.stiffness = stiffness},
                            .limits = hfh::guard_limits(able, stiffness)}};
hfh::DeviceSample sample{.has_sent = true};                           // nothing was sent yet: zero newtons
while (running()) {
    sample.position = driver.position();
    sample.time = clock.now();                                        // measured right behind the position
    sample.sent = loop.update(sample).newtons;
    driver.set_force(sample.sent);
    sample.sent_at = sample.time;
}
driver.set_force({0, 0, 0});
    // clang-format on
    check(driver, loop.guard().counts(), 0.5);
}

TEST_CASE("README: a loop of your own that exchanges feels what it should, by the time that went by",
          "[readme][haptic_loop]") {
    Driver driver;
    const Clock clock{&driver};
    const auto running = [&] { return driver.time < 11.5; };
    // clang-format off
const double lag = 1.5;                                               // half an update, and one exchange
hfh::HapticLoop loop{grid, {.workspace = frame,
                            .material = {.stiffness = stiffness},
                            .limits = hfh::guard_limits(able, stiffness, lag),
                            .lag = lag}};
hfh::DeviceSample sample{.has_sent = true};
while (running()) {
    sample.position = driver.exchange(sample.sent);                   // this state for the force of the last one
    sample.time = clock.now();
    sample.sent = loop.update(sample).newtons;
    sample.sent_at = sample.time;
}
(void)driver.exchange({0, 0, 0});
    // clang-format on
    check(driver, loop.guard().counts(), lag);
}
