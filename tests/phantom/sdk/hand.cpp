// Makes the fake a library that moves by itself: between start and stop a thread ticks a thousand times a second, and a
// hand presses into the ground and comes up again. HFH_TEST_EVENT in the environment has something happen while it
// presses: INT or TERM, a signal; LOSE, the connection breaks, once, and the
// scheduler does not start the next time. Tells what force there is then, and what the last
// update left.

#include "../fake_hd.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <thread>
#include <vector>

namespace hfh::test {

namespace {

std::thread servo;
std::atomic<bool> on{false}, is_lost{false};

constexpr int event_at = 600; // ticks

double length(const std::vector<double>& f) { return f.empty() ? 0 : std::hypot(f[0], f[1], f[2]); }

void before_tick(int n, std::string_view event) {
    fake_hd().position[1] = 10 + 40 * std::cos(n * 1e-3 * 6.28);
    if (n == event_at && event == "LOSE") {
        fake_hd().errors.push_back(HD_COMM_ERROR);
        is_lost = true;
    }
    if (n == event_at && (event == "INT" || event == "TERM")) {
        std::printf("\nsignal at %.2f N\n", length(fake_hd().force));
        std::raise(event == "INT" ? SIGINT : SIGTERM);
    }
}

} // namespace

void start_hand();
void start_hand() {
    on = true;
    const char* set = std::getenv("HFH_TEST_EVENT");
    const std::string_view event = set != nullptr ? set : "";
    fake_hd().before_update = [event](int n) { before_tick(n, event); };
    servo = std::thread{[] {
        FakeHd& hd = fake_hd();
        auto next = std::chrono::steady_clock::now();
        while (on) {
            hd.update();
            std::this_thread::sleep_until(next += std::chrono::milliseconds{1});
        }
    }};
}

void stop_hand();
void stop_hand() {
    on = false;
    if (servo.joinable()) servo.join();
    fake_hd().start_error = is_lost.exchange(false) ? unsigned{HD_TIMER_ERROR} : 0u;
    std::printf("\nleft at %.2f N\n", length(fake_hd().left));
    for (const auto& breach : fake_hd().breaches) std::printf("\nbreach: %s\n", breach.c_str());
}

} // namespace hfh::test
