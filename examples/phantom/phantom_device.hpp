#ifndef PHANTOM_PHANTOM_DEVICE_HPP
#define PHANTOM_PHANTOM_DEVICE_HPP

#include "haptic_api.hpp"
#include "shared_driver.hpp"

#include <hfh/device/device.hpp>
#include <hfh/device/triple_buffer.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>
#include <type_traits>

// A Phantom or Touch as an hfh::Device. What is called, in which order, and what is made of errors is here; the calls
// themselves go through `Api` (openhaptics.hpp has the real ones), time through `Clock`, so that all of it can be tested
// without a device.

namespace phantom {

struct SteadyClock {
    [[nodiscard]] double now() const noexcept {
        return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    }
    /// Lets other threads work for a while.
    void wait() const { std::this_thread::sleep_for(std::chrono::milliseconds{5}); }
};

struct Options {
    double late_after = 1e-3;   ///< s past when it was due (the last one + 1/rate): the update counts as late
    int max_force_errors = 100; ///< updates in a row with a force error (warm motors aside) that end the run
    double patience = 1;        ///< s without an update that end the run
    double take_back = 1; ///< s from the wish for a calibration to a force of zero, if the tick takes longer
    /// Of the temperature that counts as warm: below it motors count as cool again. PreventWarmMotors, an example of the
    /// SDK, waits for 0.5 as well.
    double cool_below = 0.5;
    double cool_after = 5; ///< s without an error that count as cooled, where the driver tells no temperature
};

/// Why there is no force whatever the tick says.
enum class Withheld : unsigned char {
    none,
    force_error,  ///< too much force, impulse or velocity in the last update
    warm_motors,  ///< until they have cooled
    device_fault, ///< the device has switched itself off, and the driver is bringing it back
    calibration   ///< on its way to zero, or zero until the device is calibrated
};

[[nodiscard]] constexpr const char* to_string(Withheld why) noexcept {
    switch (why) {
    case Withheld::none: return "none";
    case Withheld::force_error: return "force_error";
    case Withheld::warm_motors: return "warm_motors";
    case Withheld::device_fault: return "device_fault";
    case Withheld::calibration: return "calibration";
    }
    return "unknown";
}

/// How the updates went, and how the device is. Seconds. What is optional is empty where the driver does not tell it.
struct Report {
    unsigned long updates = 0;
    unsigned long late = 0;                    ///< more than `late_after` past due
    double latest = 0;                         ///< the most that an update was past due
    double longest_tick = 0;                   ///< the most that the tick took
    unsigned long force_errors = 0;            ///< updates with a force error, warm motors among them
    unsigned long device_faults = 0;           ///< updates with a device fault
    unsigned last_error = 0;                   ///< the driver's code of the last error of any kind
    Calibration calibration = Calibration::ok; ///< what the device wants
    Withheld withheld = Withheld::none;        ///< in the last update
    std::optional<double> temperature{};       ///< of the warmest motor: 0 at room temperature, 1 overheated
    std::optional<bool> inkwell_switch{}; ///< as the driver tells it: on a Touch true while the stylus is out
    std::optional<bool> safety_switch{};  ///< as the driver tells it
};

/// Opens the device on construction, closes it on destruction. Sequence and meaning are those of the HDAPI as its
/// public reference, its header and its examples ErrorHandling and PreventWarmMotors tell them.
///
/// Threads. `run` blocks; the tick is called from the driver's thread. From the start of the scheduler to its stop that
/// thread alone takes errors and writes the report. `stop` may be called from any thread and from a signal handler,
/// `report` from one thread at a time. Two devices: open both, then run each in a thread of its own; they share the
/// scheduler, and each gets its own errors. A device that is opened while another runs is not opened. One that is
/// destroyed or lost while another runs leaves the other alone: its force is zero from the other's next update on.
///
/// Errors. In an update that follows one the force is zero and the sample says `force_refused`:
/// - force (0x201–0x204): while it comes; `max_force_errors` in a row end the run as `force_fault`;
/// - warm motors (0x200): until they have cooled;
/// - device fault (0x300): while it comes; the driver recovers by itself. A device that never does is one whose run goes
///   on without force, and `report().withheld` says so.
/// Where the callback cannot be scheduled, or the motors cannot be switched on, the run does not begin: `not_available`,
/// and a device that runs meanwhile goes on. Any other error ends the run, as `lost` or `fault`, after one more update
/// without tick and force.
///
/// Calibration. The position jumps when the device is calibrated, so the force has to be zero by then. From the update in
/// which the device asks for it the tick is told by `release` to take the force back; whatever the tick does, the force is
/// shortened to zero within `take_back`. Then the device is calibrated, where it can do that by itself or in its
/// inkwell, and the tick is not called, for the position is not to be trusted. The first sample after that says
/// `force_refused`. If the device wants no calibration any more before the force is zero, the tick goes on.
///
/// Every sample but a run's first tells what the motors got in the update before (`sent`), with or without a tick in it.
template <HapticApi Api, class Clock = SteadyClock>
class PhantomDevice {
public:
    /// `name` as in the maker's configuration tool; nullptr: the default device.
    explicit PhantomDevice(const char* name = nullptr, const Options& options = {}, Api api = {},
                           Clock clock = {})
        : options_{options}, api_{api}, clock_{clock} {
        const auto lock = Shared::lock();
        if (Shared::is_running()) return;
        Shared::discard_errors(api_); // of another's making
        handle_ = api_.open(name);
        if (api_.valid(handle_)) place_ = Shared::enter(handle_);
        is_open_ = !failed() && place_ != Shared::none;
        if (is_open_) {
            ask_abilities();
        } else {
            if (place_ != Shared::none)
                Shared::leave(api_, place_);
            else if (api_.valid(handle_))
                api_.close(handle_);
        }
    }
    /// Not while it runs. While another runs the device is closed only when that has stopped.
    ~PhantomDevice() {
        if (!is_open_) return;
        const auto lock = Shared::lock();
        Shared::leave(api_, place_);
    }
    PhantomDevice(const PhantomDevice&) = delete;
    PhantomDevice& operator=(const PhantomDevice&) = delete;

    [[nodiscard]] bool is_open() const noexcept { return is_open_; }
    [[nodiscard]] hfh::DeviceCapabilities capabilities() const noexcept { return capabilities_; }
    /// N that the motors can give for ever without getting warm; 0 where the driver does not tell.
    [[nodiscard]] double continuous_force() const noexcept { return continuous_force_; }

    /// Ends the run at its next update; without one, the next run before it begins. Safe in a signal handler.
    void stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

    /// How the run goes, or went; from one thread at a time.
    [[nodiscard]] Report report() noexcept {
        Report report;
        (void)published_.take(report);
        return report;
    }

    /// The tick is called from the driver's thread, through C: it must not throw.
    template <hfh::DeviceTick Tick>
    hfh::DeviceEnd run(Tick&& tick) {
        using hfh::DeviceEnd;
        if (!is_open_) return DeviceEnd::not_available;
        if (stop_.exchange(false, std::memory_order_relaxed)) return DeviceEnd::stopped;
        bool started = true;
        {
            const auto lock = Shared::lock();
            // An earlier run was lost while another device went on, and its callback may still come.
            if (Shared::is_scheduled(place_)) return DeviceEnd::not_available;
            begin(tick);
            const bool is_first = Shared::begin(api_);
            started = !note(Shared::motors(place_));
            if (started) Shared::schedule(api_, place_, callback_);
            if (started && is_first) {
                started = !failed();
                if (started) api_.start(); // from here to the end the callback alone takes errors
            }
        }
        const DeviceEnd end = started ? wait() : DeviceEnd::not_available;
        {
            const auto lock = Shared::lock();
            Shared::hold_off(place_);
            // Where others go on, nothing else waits for a late callback.
            while (!Shared::is_alone() && Shared::is_busy(place_)) clock_.wait();
            if (end == DeviceEnd::not_available && !Shared::is_busy(place_)) {
                // Where no callback came nobody has taken the error that tells why, and stopping may add one of its own.
                if (Shared::is_alone())
                    (void)failed();
                else
                    (void)has_failed_to_schedule();
            }
            Shared::end(api_, place_, done_.load());
        }
        stop_.store(false, std::memory_order_relaxed);
        return end;
    }

private:
    using Shared = SharedDriver<Api>;
    static_assert(std::atomic<bool>::is_always_lock_free, "stop() is called from signal handlers");

    /// Whether the position is what it was: `ending` while the force goes down, `gone` until the device is calibrated.
    enum class Trust : unsigned char { good, ending, gone };

    void ask_abilities() {
        double box[6]{};
        api_.usable_workspace(box);
        for (int k = 0; k < 3; ++k) middle_[k] = (box[k] + box[k + 3]) / 2;
        capabilities_ = {
            .max_force = api_.nominal_max_force(),
            .max_stiffness = 1000 * api_.nominal_max_stiffness(),
            .rate = api_.update_rate(),
            .workspace = {(box[3] - box[0]) / 1000, (box[5] - box[2]) / 1000, (box[4] - box[1]) / 1000},
            .delay = hfh::unknown_delay}; // HDAPI does not say when a frame's force begins to act
        if constexpr (MonitoredApi<Api>) {
            continuous_force_ = api_.nominal_max_continuous_force();
            capabilities_.max_slew = api_.force_impulse_limit();
            capabilities_.resolution = api_.resolution() / 1000;
        }
        Shared::discard_errors(api_); // a driver that does not know one of them has said so
    }

    /// While no other runs: whether there was an error, and notes it.
    bool failed() {
        if (place_ == Shared::none) return note(Shared::discard_errors(api_));
        Shared::collect_errors(api_);
        const bool was_not_scheduled = has_failed_to_schedule();
        return note(Shared::take_error(place_)) || was_not_scheduled;
    }
    bool has_failed_to_schedule() {
        const unsigned code = Shared::take_scheduling_error(place_);
        return code != 0 && note({ErrorKind::scheduling, code});
    }
    /// Whether it is an error.
    bool note(const ApiError& error) {
        if (error.kind == ErrorKind::none) return false;
        report_.last_error = error.code;
        published_.put(report_);
        return true;
    }

    template <class Tick>
    void begin(Tick& tick) {
        report_ = {};
        (void)Shared::take_error(place_);
        refused_ = 0;
        is_warm_ = is_faulty_ = is_closing_ = false;
        trust_ = Trust::good;
        sent_ = glm::dvec3{0.0};
        done_.store(false, std::memory_order_relaxed);
        updates_.store(0, std::memory_order_relaxed);
        tick_ = const_cast<void*>(static_cast<const void*>(&tick));
        update_ = [](PhantomDevice& device, void* user) noexcept {
            return device.update(*static_cast<Tick*>(user));
        };
        callback_ = {[](void* user) noexcept {
                         auto& device = *static_cast<PhantomDevice*>(user);
                         return device.update_(device, device.tick_);
                     },
                     this};
    }

    /// Until the callback is done, or does not come any more, or never came.
    hfh::DeviceEnd wait() {
        unsigned long seen = 0;
        double seen_at = clock_.now();
        while (!done_.load(std::memory_order_acquire)) {
            clock_.wait();
            const unsigned long updates = updates_.load(std::memory_order_relaxed);
            if (updates != seen) {
                seen = updates;
                seen_at = clock_.now();
            } else if (clock_.now() - seen_at > options_.patience) {
                return seen > 0 ? hfh::DeviceEnd::lost : hfh::DeviceEnd::not_available;
            }
        }
        return end_;
    }

    /// One update, in the driver's thread. False: no more.
    template <class Tick>
    bool update(Tick& tick) noexcept {
        const double now = clock_.now();
        const double passed = measure(now);
        if (report_.updates == 1) Shared::has_started(place_);
        Shared::zero_left(api_);
        if (is_closing_) return close();

        Shared::make_current(api_, handle_);
        api_.begin_frame(handle_);
        observe();
        const bool is_back = trust(passed);
        const bool is_refused = is_back || withheld() != Withheld::none;
        double position[3]{}, velocity[3]{};
        api_.position(position);
        api_.velocity(velocity);
        for (int k = 0; k < 3; ++k) position[k] -= middle_[k];
        const hfh::DeviceSample sample{.time = now,
                                       .position = z_up(position) / 1000.0,
                                       .velocity = z_up(velocity) / 1000.0,
                                       .has_velocity = true,
                                       .buttons = api_.buttons(),
                                       .force_refused = is_refused,
                                       .release = trust_ == Trust::ending,
                                       .has_sent = report_.updates > 1,
                                       .sent = sent_,
                                       .sent_at = sent_at_};
        hfh::DeviceCommand command;
        if (trust_ != Trust::gone) command = tick(sample);
        if (stop_.load(std::memory_order_relaxed)) command.go_on = false;
        sent_ = glm::dvec3{0.0};
        sent_at_ = now;
        if (command.go_on && !is_refused && hfh::is_finite(command.newtons))
            sent_ = taken_back(command.newtons);
        send();
        if (trust_ == Trust::gone && report_.calibration == Calibration::needs_update)
            api_.update_calibration();
        report_.longest_tick = std::max(report_.longest_tick, clock_.now() - now);

        Shared::collect_errors(api_);
        const bool go_on = judge(Shared::take_error(place_), now, command.go_on);
        is_closing_ = !go_on && sent_ != glm::dvec3{0.0};
        report_.withheld = trust_ != Trust::good ? Withheld::calibration : withheld();
        return publish(go_on || is_closing_);
    }

    /// An error came after a force: without one more update the motors would go on with it.
    bool close() noexcept {
        Shared::make_current(api_, handle_);
        api_.begin_frame(handle_);
        sent_ = glm::dvec3{0.0};
        send();
        Shared::collect_errors(api_); // what ended the run is told already
        return publish(false);
    }

    /// Ends the frame with the force `sent_`.
    void send() noexcept {
        double force[3]{sent_.x, sent_.z, -sent_.y};
        api_.set_force(force);
        api_.end_frame(handle_);
    }

    bool publish(bool go_on) noexcept {
        published_.put(report_);
        updates_.store(report_.updates, std::memory_order_relaxed);
        if (!go_on) done_.store(true, std::memory_order_release);
        return go_on;
    }

    /// +x right, +y up, +z to the user → +x right, +y away from the user, +z up.
    static glm::dvec3 z_up(const double (&p)[3]) noexcept { return {p[0], -p[2], p[1]}; }

    /// Seconds since the last update.
    double measure(double now) noexcept {
        const double passed = report_.updates > 0 ? now - last_ : 0;
        if (report_.updates++ > 0 && capabilities_.rate > 0) {
            const double past_due = passed - 1 / capabilities_.rate;
            report_.latest = std::max(report_.latest, past_due);
            report_.late += past_due > options_.late_after;
        }
        last_ = now;
        return passed;
    }

    /// How the device is. In the first update ever, what it does not know is told by an error after the question.
    void observe() noexcept {
        report_.calibration = api_.calibration();
        if constexpr (MonitoredApi<Api>) {
            if (!has_asked_) Shared::collect_errors(api_); // those of before the questions
            ask(knows_temperature_, report_.temperature, [&] { return api_.motor_temperature(); });
            ask(knows_inkwell_, report_.inkwell_switch, [&] { return api_.inkwell_switch(); });
            ask(knows_safety_, report_.safety_switch, [&] { return api_.safety_switch(); });
            has_asked_ = true;
        }
    }
    template <class T, class Read>
    void ask(bool& knows, std::optional<T>& told, Read read) noexcept {
        if (!knows) return;
        told = read();
        if (has_asked_) return;
        knows = !Shared::collect_refusal(api_);
        if (!knows) told.reset();
    }

    /// Follows what the device wants of calibration. True in the one update in which the position is good again.
    bool trust(double passed) noexcept {
        const bool is_ok = report_.calibration == Calibration::ok;
        const Trust before = trust_;
        if (is_ok) {
            trust_ = Trust::good;
        } else if (report_.updates == 1) {
            trust_ = Trust::gone; // no tick has been called in this run, nor a force given
        } else if (before == Trust::good) {
            trust_ = Trust::ending;
            most_ = fall_from_ = glm::length(sent_);
        } else if (before == Trust::ending && sent_ == glm::dvec3{0.0}) {
            trust_ = Trust::gone;
        }
        if (trust_ == Trust::ending) {
            const double part = options_.take_back > passed ? passed / options_.take_back : 1;
            most_ = std::max(0.0, most_ - part * fall_from_);
        }
        return before == Trust::gone && is_ok;
    }
    [[nodiscard]] glm::dvec3 taken_back(const glm::dvec3& newtons) const noexcept {
        const double length = glm::length(newtons);
        return trust_ == Trust::good || length <= most_ ? newtons : newtons * (most_ / length);
    }

    [[nodiscard]] Withheld withheld() const noexcept {
        return is_faulty_     ? Withheld::device_fault
               : is_warm_     ? Withheld::warm_motors
               : refused_ > 0 ? Withheld::force_error
                              : Withheld::none;
    }

    bool judge(const ApiError& error, double now, bool go_on) noexcept {
        using hfh::DeviceEnd;
        const bool is_warm = error.kind == ErrorKind::warm;
        if (error.kind != ErrorKind::none) report_.last_error = error.code;
        if (is_warm) warm_at_ = now;
        is_warm_ = is_warm || (is_warm_ && !is_cool(now));
        is_faulty_ = error.kind == ErrorKind::device_fault;
        report_.device_faults += is_faulty_;
        refused_ = error.kind == ErrorKind::force ? refused_ + 1 : 0;
        report_.force_errors += error.kind == ErrorKind::force || is_warm;
        end_ = error.kind == ErrorKind::communication  ? DeviceEnd::lost
               : error.kind == ErrorKind::other        ? DeviceEnd::fault
               : refused_ >= options_.max_force_errors ? DeviceEnd::force_fault
                                                       : DeviceEnd::stopped;
        return go_on && end_ == DeviceEnd::stopped;
    }
    [[nodiscard]] bool is_cool(double now) const noexcept {
        return report_.temperature ? *report_.temperature < options_.cool_below
                                   : now - warm_at_ > options_.cool_after;
    }

    Options options_;
    Api api_;
    Clock clock_;
    typename Api::Handle handle_{};
    std::size_t place_ = Shared::none;
    bool is_open_ = false;
    hfh::DeviceCapabilities capabilities_{};
    double continuous_force_ = 0; ///< N
    double middle_[3]{};          ///< mm, of the usable workspace, in the driver's axes

    // Of a run: set before it starts.
    Callback callback_{};
    bool (*update_)(PhantomDevice&, void* tick) noexcept = nullptr;
    void* tick_ = nullptr;

    // The driver's thread's during a run.
    Report report_{};
    double last_ = 0, warm_at_ = 0; ///< s: the last update, the last error of warm motors
    int refused_ = 0;               ///< updates in a row with a force error
    bool is_warm_ = false, is_faulty_ = false, is_closing_ = false;
    bool has_asked_ = false, knows_temperature_ = true, knows_inkwell_ = true, knows_safety_ = true;
    Trust trust_ = Trust::good;
    double fall_from_ = 0; ///< N: before a calibration, the force from which it goes down
    double most_ = 0;      ///< N: how much of it there may still be
    glm::dvec3 sent_{0.0}; ///< N: what the motors got last
    double sent_at_ = 0;   ///< s: the time of the update in which they did

    hfh::DeviceEnd end_ = hfh::DeviceEnd::stopped; ///< written before `done_`, read after it
    std::atomic<bool> done_{false}, stop_{false};
    std::atomic<unsigned long> updates_{0};
    hfh::TripleBuffer<Report> published_{};
};

} // namespace phantom

#endif // PHANTOM_PHANTOM_DEVICE_HPP
