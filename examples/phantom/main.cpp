// Hills of two and a half kilometres in a Phantom or Touch: phantom_touch [SECONDS [DEVICE]]. Hold button 1 and move the
// hand to move on; Ctrl-C ends it. Needs the user's own OpenHaptics SDK. README.md in this directory tells what to expect.

#include "openhaptics.hpp"
#include "phantom_device.hpp"
#include "reconnect.hpp"
#include "scene.hpp"
#include "sentences.hpp"

#include <hfh/terrain/extended_field.hpp>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

namespace {

using Device = phantom::PhantomDevice<phantom::OpenHaptics>;
using Hills = hfh::BilinearGrid<double, hfh::HeightView<std::int16_t>>;

constexpr int size = 256; // samples
constexpr double spacing = 10;

/// Ctrl-C, or the system asks the program to end. The tick sees it in its next update, and gives no force any more.
std::atomic<bool> is_asked_to_end{false};
static_assert(std::atomic<bool>::is_always_lock_free, "written by a signal handler");

extern "C" void ask_to_end(int signal) {
    is_asked_to_end.store(true, std::memory_order_relaxed);
    std::signal(signal, SIG_DFL); // a second one ends the program at once
}

/// Why there is no force, or no terrain, under the hand.
const char* say(const phantom::Report& report, const phantom::Shown& shown) {
    if (const char* why = phantom::sentence(report); *why != '\0') return why;
    if (*hint(shown.place) != '\0') return hint(shown.place);
    return shown.trip != hfh::GuardTrip::none ? to_string(shown.trip) : "";
}

/// Until it is stopped, or fails.
hfh::DeviceEnd touch(Device& device, const Hills& grid, double until) {
    const hfh::ExtendedField ground{grid}; // nobody falls off the edge of the map
    const auto able = device.capabilities();
    phantom::Scene scene{
        ground, phantom::frame_for(able, spacing * size, {spacing * size / 2, spacing * size / 2, 150}),
        phantom::stiffness_for(able), phantom::limits_for(able),
        phantom::Bounds{.workspace = able.workspace, .map = grid.cells()}};

    std::atomic<bool> is_over{false};
    std::thread display{[&] {
        phantom::Shown shown;
        const phantom::SteadyClock clock;
        while (!is_over.load()) {
            (void)scene.show(shown);
            const phantom::Report report = device.report();
            char motors[24] = "";
            if (report.temperature)
                std::snprintf(motors, sizeof motors, "motors %.0f %%", 100 * *report.temperature);
            std::printf("\r%8.1f %8.1f %7.1f m  %5.2f N  %-14s %-12s %-76s", shown.stylus.x, shown.stylus.y,
                        shown.stylus.z, hfh::detail::norm(shown.force), to_string(shown.contact), motors,
                        say(report, shown));
            std::fflush(stdout);
            if (clock.now() > until || is_asked_to_end.load()) device.stop();
            std::this_thread::sleep_for(std::chrono::milliseconds{100});
        }
    }};
    const auto end = device.run([&](const hfh::DeviceSample& sample) noexcept {
        auto command = scene(sample);
        command.go_on = !is_asked_to_end.load(std::memory_order_relaxed);
        return command;
    });
    is_over.store(true);
    display.join();

    const auto report = device.report();
    std::printf("\n%s; %lu updates, %lu late (%.2f ms at most), longest tick %.3f ms, %lu force errors, %lu "
                "device faults, last error 0x%04x\n",
                phantom::sentence(end), report.updates, report.late, 1e3 * report.latest,
                1e3 * report.longest_tick, report.force_errors, report.device_faults, report.last_error);
    for (int k = 1; k < hfh::guard_trip_count; ++k)
        if (const unsigned n = scene.counts().trips[k]; n > 0)
            std::printf("guard: %s %u times\n", to_string(static_cast<hfh::GuardTrip>(k)), n);
    return end;
}

void say_not_open(const phantom::Report& report) {
    std::printf("no device: error 0x%04x\n", report.last_error);
#ifdef __linux__
    const char* home = std::getenv("GTDD_HOME");
    std::printf("GTDD_HOME, below which the drivers of the Touch for Linux keep their settings, is %s\n",
                home != nullptr ? home : "not set");
#endif
}

} // namespace

int main(int argc, char** argv) {
    std::signal(SIGINT, ask_to_end);
    std::signal(SIGTERM, ask_to_end);
    const phantom::SteadyClock clock;
    const double until = clock.now() + (argc > 1 ? std::atof(argv[1]) : 60);

    std::vector<std::int16_t> heights(size * size);
    for (std::size_t n = 0; n < heights.size(); ++n) {
        const double i = static_cast<double>(n % size), j = static_cast<double>(n / size);
        heights[n] = static_cast<std::int16_t>(100 + 60 * std::sin(i * 0.09) * std::cos(j * 0.07) +
                                               15 * std::sin(i * j * 2e-3));
    }
    const Hills grid{hfh::HeightView{heights.data(), size, size}, {.spacing = {spacing, spacing}}};

    const auto attempt = [&] {
        Device device{argc > 2 ? argv[2] : nullptr};
        if (!device.is_open()) {
            say_not_open(device.report());
            return hfh::DeviceEnd::not_available;
        }
        std::printf("up to %.1f N, %.1f N for ever, %.0f N/m, %.3f mm\n", device.capabilities().max_force,
                    device.continuous_force(), device.capabilities().max_stiffness,
                    1000 * device.capabilities().resolution);
        return touch(device, grid, until);
    };
    const auto wait = [] { std::this_thread::sleep_for(std::chrono::milliseconds{500}); };
    const auto goes_on = [&] { return clock.now() < until && !is_asked_to_end.load(); };
    const hfh::DeviceEnd end = phantom::run_and_reconnect(attempt, wait, goes_on);
    return end == hfh::DeviceEnd::stopped ? 0 : 1;
}
