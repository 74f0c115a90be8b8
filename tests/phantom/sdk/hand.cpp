// Makes the fake a library that moves by itself: between start and stop a thread ticks a thousand times a second, and a
// hand presses into the ground and comes up again.

#include "../fake_hd.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

namespace hfh::test {

namespace {
std::thread servo;
std::atomic<bool> on{false};
} // namespace

void start_hand();
void start_hand() {
    on = true;
    fake_hd().before_update = [](int n) { fake_hd().position[1] = 10 + 40 * std::cos(n * 1e-3 * 6.28); };
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
}

} // namespace hfh::test
