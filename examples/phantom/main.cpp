// Hills of two and a half kilometres in a Phantom or Touch: phantom_touch [SECONDS [DEVICE]]. Hold button 1 and move the
// hand to move on. Needs the user's own OpenHaptics SDK.

#include "openhaptics.hpp"
#include "scene.hpp"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

const char* name_of(hfh::DeviceEnd end) {
    switch (end) {
    case hfh::DeviceEnd::stopped: return "stopped";
    case hfh::DeviceEnd::not_available: return "no device, or it did not start";
    case hfh::DeviceEnd::force_fault: return "the device refused to render forces";
    case hfh::DeviceEnd::lost: return "the connection broke";
    case hfh::DeviceEnd::fault: return "the device failed";
    }
    return "unknown";
}

} // namespace

int main(int argc, char** argv) {
    const double seconds = argc > 1 ? std::atof(argv[1]) : 60;
    constexpr int size = 256;
    std::vector<std::int16_t> heights(size * size);
    for (std::size_t n = 0; n < heights.size(); ++n) {
        const double i = static_cast<double>(n % size), j = static_cast<double>(n / size);
        heights[n] = static_cast<std::int16_t>(100 + 60 * std::sin(i * 0.09) * std::cos(j * 0.07) +
                                               15 * std::sin(i * j * 2e-3));
    }
    const hfh::BilinearGrid<double, hfh::HeightView<std::int16_t>> grid{
        hfh::HeightView{heights.data(), size, size}, {.spacing = {10.0, 10.0}}};

    phantom::PhantomDevice<phantom::OpenHaptics> device{argc > 2 ? argv[2] : nullptr};
    const auto able = device.capabilities();
    phantom::Scene scene{grid, phantom::frame_for(able, 10.0 * size, {5.0 * size, 5.0 * size, 150}),
                         phantom::stiffness_for(able), phantom::limits_for(able)};

    std::atomic<bool> over{false};
    std::thread display{[&] {
        phantom::Shown shown;
        const phantom::SteadyClock clock;
        const double until = clock.now() + seconds;
        while (!over.load()) {
            if (scene.show(shown))
                std::printf("\r%8.1f %8.1f %7.1f m  %5.2f N  %-14s %-12s", shown.stylus.x, shown.stylus.y,
                            shown.stylus.z, hfh::detail::norm(shown.force), to_string(shown.contact),
                            to_string(shown.trip));
            else if (device.is_open() && device.report().calibration != phantom::Calibration::ok)
                std::printf(
                    "\rthe device wants to be calibrated: put the stylus into its inkwell            ");
            std::fflush(stdout);
            if (clock.now() > until) device.stop();
            std::this_thread::sleep_for(std::chrono::milliseconds{100});
        }
    }};
    const auto end = device.run(scene);
    over.store(true);
    display.join();

    const auto report = device.report();
    std::printf("\n%s; %lu updates, %lu late (%.2f ms at most), longest tick %.3f ms, %lu force errors, last "
                "error 0x%04x\n",
                name_of(end), report.updates, report.late, 1e3 * report.latest, 1e3 * report.longest_tick,
                report.force_errors, report.last_error);
    for (int k = 1; k < hfh::guard_trip_count; ++k)
        if (const unsigned n = scene.counts().trips[k]; n > 0)
            std::printf("guard: %s %u times\n", to_string(static_cast<hfh::GuardTrip>(k)), n);
    return end == hfh::DeviceEnd::stopped ? 0 : 1;
}
