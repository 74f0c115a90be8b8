#ifndef HFH_TESTS_PHANTOM_FAKE_HD_HPP
#define HFH_TESTS_PHANTOM_FAKE_HD_HPP

#include <HD/hd.h>

#include <deque>
#include <functional>
#include <string>
#include <vector>

namespace hfh::test {

/// A device of our own behind the calls that the adapter makes. It notes the calls, minds their order as the reference
/// asks for, and has whatever go wrong that a test puts in. Nothing moves by itself: `update` is one servo tick.
struct FakeHd {
    std::vector<std::string> calls{};    ///< all but those within a tick
    std::vector<std::string> in_tick{};  ///< those of the last tick
    std::vector<std::string> breaches{}; ///< of the order that the reference asks for
    std::deque<unsigned> errors{};

    // What the device is like.
    bool init_gives_no_handle = false;
    unsigned init_error = 0, enable_error = 0, schedule_error = 0, start_error = 0;
    double stiffness = 0.5, max_force = 3.3;
    double box[6]{-80, -50, -35, 80, 70, 35};
    int rate = 1000, styles = HD_CALIBRATION_INKWELL, buttons = 0;
    unsigned calibration = HD_CALIBRATION_OK;
    double position[3]{}, velocity[3]{};

    // What has come of it.
    std::vector<unsigned> enabled{};
    std::vector<double> force{0, 0, 0}; ///< what the motors do
    std::vector<double> left{};         ///< what they did after the last tick of a run
    unsigned priority = 0;
    int calibrations = 0;

    double time = 1000;                       ///< of the clock that the adapter is given
    std::function<void(int)> before_update{}; ///< before tick n, from 0
    int updates = 0;

    [[nodiscard]] bool running() const { return started && callback != nullptr; }
    void update();

    HDSchedulerCallback callback = nullptr;
    void* user = nullptr;
    bool open = false, started = false, in_frame = false, ticking = false;
};

/// The one device.
FakeHd& fake_hd();

} // namespace hfh::test

#endif // HFH_TESTS_PHANTOM_FAKE_HD_HPP
