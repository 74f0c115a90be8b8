// The adapter with a thread that calls back, as a driver does, and others that ask how it goes and stop it. By its
// results alone, and under the thread sanitizer (see CMakeLists.txt; exit status 66 is the sanitizer's).

#include "fake_hd.hpp"

#include "openhaptics.hpp"
#include "phantom_device.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <thread>
#include <vector>

namespace hfh::test {

namespace {

std::thread servo;
std::atomic<bool> on{false}, in_first_tick{false};

using Phantom = phantom::PhantomDevice<phantom::OpenHaptics>;

int failures = 0;
void expect(bool holds, const char* what, int run) {
    if (holds) return;
    ++failures;
    std::printf("FAILED in run %d: %s\n", run, what);
}

void expect_no_breach(int run) {
    for (const auto& breach : fake_hd().breaches) expect(false, breach.c_str(), run);
}

/// Runs a device while another thread watches its updates, and stops it once `enough(updates)`.
template <class Tick, class Enough>
DeviceEnd run_watched(Phantom& device, Tick& tick, Enough enough) {
    std::atomic<bool> over{false};
    std::thread watcher{[&] {
        while (!over && !enough(device.report().updates)) std::this_thread::yield();
        device.stop();
    }};
    const DeviceEnd end = device.run(tick);
    over = true;
    watcher.join();
    return end;
}

/// Warm motors in the first updates: right after the start, where two threads could both be after the errors.
void one_device(int run) {
    fake_hd() = FakeHd{};
    fake_hd().before_update = [](int n) {
        if (n < 20) fake_hd().errors.push_back(HD_WARM_MOTORS);
        if (n == 0) in_first_tick = true;
    };
    Phantom device;
    unsigned long refused = 0, ticks = 0;
    const auto tick = [&](const DeviceSample& sample) -> DeviceCommand {
        refused += sample.force_refused;
        if (++ticks < 20)
            std::this_thread::sleep_for(std::chrono::microseconds{200}); // with an error on the stack
        return {{0, 0, 1}};
    };
    const auto enough = [](unsigned long updates) { return updates >= 200; };
    expect(run_watched(device, tick, enough) == DeviceEnd::stopped, "ends because it is stopped", run);
    expect(device.report().force_errors == 20, "every error is the callback's", run);
    expect(refused == 20, "each is told to the next tick", run);
    expect_no_breach(run);
}

/// Two on one scheduler, each run in a thread of its own: each gets its own force and its own errors. The second leaves
/// first and is destroyed, and the first goes on.
void two_devices(int run) {
    FakeHd& hd = fake_hd() = FakeHd{};
    hd.position[1] = 12, hd.second.position[1] = 20; // 2 and 10 mm above the middles
    std::atomic<bool> has_begun[2]{}, is_alone{false};
    const auto both = [&] { return has_begun[0] && has_begun[1]; };
    std::vector<double> felt[2];
    hd.before_update = [&](int n) {
        in_first_tick = true;
        if (!both()) return;
        felt[0].push_back(hd.force[1]);
        felt[1].push_back(hd.second.force[1]);
        if (n % 10 == 0) hd.errors.emplace_back(HD_EXCEEDED_MAX_FORCE, hd.second.handle);
    };
    Phantom first;
    std::optional<Phantom> second{std::in_place, "second"};
    expect(first.is_open() && second->is_open(), "both are open", run);
    const auto force_of_height = [&](const DeviceSample& sample) -> DeviceCommand {
        has_begun[sample.position.z > 0.005] = true;
        return {{0, 0, 100 * sample.position.z}};
    };
    // So many updates after something has come true.
    const auto after = [](unsigned long count, auto is_so) {
        return [=, from = 0ul](unsigned long updates) mutable {
            if (from == 0 && is_so()) from = updates;
            return from > 0 && updates >= from + count;
        };
    };
    const auto hundred = after(100, both);
    const auto fifty_alone = after(50, [&] { return is_alone.load(); });
    DeviceEnd ends[2];
    std::thread one{[&] { ends[0] = run_watched(first, force_of_height, fifty_alone); }};
    ends[1] = run_watched(*second, force_of_height, hundred);
    expect(second->report().force_errors > 0, "the second's errors are its own", run);
    second.reset();
    is_alone = true;
    one.join();
    expect(ends[0] == DeviceEnd::stopped && ends[1] == DeviceEnd::stopped,
           "both end because they are stopped", run);
    expect(first.report().force_errors == 0, "no error of the second is the first's", run);
    const auto has = [](const std::vector<double>& forces, double newtons) {
        return std::count_if(forces.begin(), forces.end(),
                             [=](double f) { return std::abs(f - newtons) < 1e-9; }) > 5;
    };
    expect(has(felt[0], 0.2), "the first feels its own force", run);
    expect(has(felt[1], 1), "the second feels its own force", run);
    expect(!has(felt[0], 1), "the first does not feel the second's force", run);
    expect_no_breach(run);
}

/// A second one that cannot be scheduled while the first runs: the callback of the first takes the error.
void second_not_scheduled(int run) {
    FakeHd& hd = fake_hd() = FakeHd{};
    hd.before_update = [](int) { in_first_tick = true; };
    Phantom first, second{"second", {.patience = 0.5}};
    std::atomic<bool> runs{false}, enough{false};
    const auto tick = [&](const DeviceSample&) -> DeviceCommand {
        runs = true;
        return {{0, 0, 1}};
    };
    DeviceEnd end{};
    std::thread one{[&] { end = run_watched(first, tick, [&](unsigned long) { return enough.load(); }); }};
    while (!runs) std::this_thread::yield();
    hd.schedule_error = HD_SCHEDULER_FULL;
    expect(second.run(tick) == DeviceEnd::not_available, "the second does not run", run);
    expect(second.report().last_error == HD_SCHEDULER_FULL, "the second is told why", run);
    enough = true;
    one.join();
    expect(end == DeviceEnd::stopped, "the first goes on", run);
    expect(first.report().last_error == 0, "the error is not the first's", run);
    expect_no_breach(run);
}

} // namespace

void start_hand();
void start_hand() {
    on = true;
    in_first_tick = false;
    servo = std::thread{[] {
        while (on) {
            fake_hd().update();
            std::this_thread::yield();
        }
    }};
    while (!in_first_tick) std::this_thread::yield(); // a start that returns when the loop runs
}

void stop_hand();
void stop_hand() {
    on = false;
    if (servo.joinable()) servo.join();
}

} // namespace hfh::test

int main() {
    constexpr int runs = 30;
    for (int run = 0; run < runs; ++run) hfh::test::one_device(run);
    for (int run = 0; run < runs; ++run) hfh::test::two_devices(run);
    for (int run = 0; run < 2; ++run) hfh::test::second_not_scheduled(run);
    std::printf("%d runs, %d failures\n", runs, hfh::test::failures);
    return hfh::test::failures == 0 ? 0 : 1;
}
