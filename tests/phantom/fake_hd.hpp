#ifndef HFH_TESTS_PHANTOM_FAKE_HD_HPP
#define HFH_TESTS_PHANTOM_FAKE_HD_HPP

#include <HD/hd.h>

#include <deque>
#include <functional>
#include <string>
#include <vector>

namespace hfh::test {

/// On the stack of errors: what, and which device was the current one.
struct FakeError {
    FakeError(unsigned what, HHD whose = 5) : code{what}, device{whose} {}
    unsigned code;
    HHD device;
};

/// One device.
struct FakeDevice {
    HHD handle;

    // What it is like.
    double stiffness = 0.5, max_force = 3.3, continuous_force = 0.88, impulse = 0.7;
    double box[6]{-80, -50, -35, 80, 70, 35};
    int rate = 1000, styles = HD_CALIBRATION_INKWELL, buttons = 0;
    unsigned calibration = HD_CALIBRATION_OK;
    double position[3]{}, velocity[3]{}, temperature[6]{};
    bool inkwell = true, safety = true;
    const char* model = "PHANTOM Omni";
    unsigned temperature_error = 0; ///< raised when the temperature is read
    unsigned enable_error = 0;      ///< raised when something is enabled
    std::vector<HDenum> unknown{};  ///< what it raises an error about when asked

    // What has come of it.
    std::vector<unsigned> enabled{};
    std::vector<double> force{0, 0, 0}; ///< what the motors do
    std::vector<double> left{};         ///< what they did after the last tick of a run
    int calibrations = 0;
    bool open = false, in_frame = false;
};

/// Devices of our own behind the calls that the adapter makes. Notes the calls, minds their order as the reference asks
/// for, and has whatever go wrong that a test puts in. Nothing moves by itself: `update` is one servo tick. It is itself
/// the first device; "second" is the name of another.
struct FakeHd : FakeDevice {
    FakeHd() : FakeDevice{.handle = 5} {}

    std::vector<std::string> calls{};    ///< all but those within a tick
    std::vector<std::string> in_tick{};  ///< those of the last tick
    std::vector<std::string> breaches{}; ///< of the order that the reference asks for
    std::deque<FakeError> errors{};      ///< a stack: the last one is the next to be told
    int errors_raised_elsewhere = 0;     ///< by calls outside of a tick

    bool init_gives_no_handle = false;
    unsigned init_error = 0, schedule_error = 0, start_error = 0;
    unsigned priority = 0;

    FakeDevice second{.handle = 6};
    HHD current = HD_INVALID_HANDLE;

    double time = 1000;                       ///< of the clock that the adapter is given
    std::function<void(int)> before_update{}; ///< before tick n, from 0
    std::function<void(int)> calibrated{};    ///< within an update of the calibration, the how manieth
    int updates = 0;

    struct Scheduled {
        HDSchedulerHandle handle;
        HDSchedulerCallback callback;
        void* user;
        bool is_held_up = false; ///< is not called, and stays on the schedule
    };
    std::vector<Scheduled> scheduled{};
    HDSchedulerHandle last_schedule = 0x1'0000'0000ul; ///< does not fit into an int
    bool started = false;

    [[nodiscard]] bool running() const { return started && !scheduled.empty(); }
    void update();
};

/// The one driver.
FakeHd& fake_hd();

} // namespace hfh::test

#endif // HFH_TESTS_PHANTOM_FAKE_HD_HPP
