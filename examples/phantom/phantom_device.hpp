#ifndef PHANTOM_PHANTOM_DEVICE_HPP
#define PHANTOM_PHANTOM_DEVICE_HPP

#include <hfh/device.hpp>
#include <hfh/latest_value.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <concepts>
#include <thread>
#include <type_traits>

// A Phantom or Touch as an hfh::Device. What is called, in which order, and what is made of errors is here; the calls
// themselves go through `Api` (openhaptics.hpp has the real ones), time through `Clock`, so that all of it can be tested
// without a device.

namespace phantom {

/// What kind of error the driver reports, as far as it matters here.
enum class ErrorKind : unsigned char {
    none,
    force,         ///< 0x200-0x204: motors warm, too much force, impulse or velocity: let go, and go on
    communication, ///< the cable, the network
    other          ///< frames, timer, handles, a device fault: the run is over
};
struct ApiError {
    ErrorKind kind = ErrorKind::none;
    unsigned code = 0;
};

enum class Calibration : unsigned char { ok, needs_update, needs_user };

/// What a scheduler calls once per update, until it returns false.
struct Callback {
    bool (*call)(void* user) noexcept;
    void* user;
};

/// The driver's calls, in its own units and axes: mm, N, N/mm; x right, y up, z towards the user.
// clang-format off
template <class A>
concept HapticApi = requires(A& api, const A& constant, const char* name, typename A::Handle handle,
                             typename A::Schedule schedule, Callback& callback, double (&three)[3], double (&six)[6]) {
        { api.error() } -> std::same_as<ApiError>; // takes the oldest one off the driver's stack
        { api.open(name) } -> std::same_as<typename A::Handle>;
        { constant.valid(handle) } -> std::same_as<bool>;
        { api.nominal_max_stiffness() } -> std::same_as<double>;
        { api.nominal_max_force() } -> std::same_as<double>;
        { api.update_rate() } -> std::same_as<double>;
        api.usable_workspace(six); // minimum, maximum
        api.enable_force_output();
        api.enable_force_ramping();
        api.enable_force_clamping();
        api.disable_force_output();
        { api.schedule(callback) } -> std::same_as<typename A::Schedule>; // every update, at the highest priority
        api.start();
        api.stop();
        api.unschedule(schedule);
        api.close(handle);
        // In the callback:
        api.begin_frame(handle);
        { api.calibration() } -> std::same_as<Calibration>;
        api.update_calibration();
        api.position(three);
        api.velocity(three);
        { api.buttons() } -> std::same_as<unsigned>;
        api.set_force(three);
        api.end_frame(handle);
    };
// clang-format on

struct SteadyClock {
    [[nodiscard]] double now() const noexcept {
        return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    }
    /// Lets other threads work for a while.
    void wait() const { std::this_thread::sleep_for(std::chrono::milliseconds{5}); }
};

struct Options {
    double late_after = 1e-3;   ///< s past when it was due (the last one + 1/rate): the update counts as late
    int max_force_errors = 100; ///< updates in a row with a force error that end the run
    double patience = 1;        ///< s without an update that end the run
};

/// How the updates went. Seconds.
struct Report {
    unsigned long updates = 0;
    unsigned long late = 0;                    ///< more than `late_after` past due
    double latest = 0;                         ///< the most that an update was past due
    double longest_tick = 0;                   ///< the most that the tick took
    unsigned long force_errors = 0;            ///< updates with a force error
    unsigned last_error = 0;                   ///< the driver's code of the last error of any kind
    Calibration calibration = Calibration::ok; ///< not ok: no tick and no force until it is
};

/// Opens the device on construction, closes it on destruction. Sequence and meaning are those of the HDAPI as its
/// public reference tells them.
///
/// An error of force lets go: that update's force is the last, the next sample says `force_refused`, and forces stay at zero
/// while such errors come. Any other error ends the run. While the device wants calibration the force is zero and the
/// tick is not called, because the position is not to be trusted; where the device can calibrate by itself or in its
/// inkwell, it is asked to; `report().calibration` tells what is waited for.
template <HapticApi Api, class Clock = SteadyClock>
class PhantomDevice {
public:
    /// `name` as in the maker's configuration tool; nullptr: the default device.
    explicit PhantomDevice(const char* name = nullptr, const Options& options = {}, Api api = {},
                           Clock clock = {})
        : options_{options}, api_{api}, clock_{clock} {
        drain();
        handle_ = api_.open(name);
        const ApiError error = drain();
        is_open_ = api_.valid(handle_) && error.kind == ErrorKind::none;
        if (!is_open_) {
            report_.last_error = error.code;
            published_.put(report_);
            if (api_.valid(handle_)) api_.close(handle_);
            return;
        }
        double box[6]{};
        api_.usable_workspace(box);
        for (int k = 0; k < 3; ++k) middle_[k] = (box[k] + box[k + 3]) / 2;
        capabilities_ = {
            .max_force = api_.nominal_max_force(),
            .max_stiffness = 1000 * api_.nominal_max_stiffness(),
            .rate = api_.update_rate(),
            .workspace = {(box[3] - box[0]) / 1000, (box[5] - box[2]) / 1000, (box[4] - box[1]) / 1000}};
        drain(); // a driver that does not know one of them has said so
    }
    ~PhantomDevice() {
        if (is_open_) api_.close(handle_);
    }
    PhantomDevice(const PhantomDevice&) = delete;
    PhantomDevice& operator=(const PhantomDevice&) = delete;

    [[nodiscard]] bool is_open() const noexcept { return is_open_; }
    [[nodiscard]] hfh::DeviceCapabilities capabilities() const noexcept { return capabilities_; }

    /// Ends a run from another thread, at the next update.
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
        begin();
        if (failed()) return DeviceEnd::not_available;

        struct Call {
            PhantomDevice& device;
            std::remove_reference_t<Tick>& tick;
        } call{*this, tick};
        Callback callback{[](void* user) noexcept {
                              auto& c = *static_cast<Call*>(user);
                              return c.device.update(c.tick);
                          },
                          &call};
        const auto schedule = api_.schedule(callback);
        bool started = !failed();
        if (started) {
            api_.start();
            started = !failed();
        }
        const DeviceEnd end = started ? wait() : DeviceEnd::not_available;

        // Motors off first; once the scheduler has stopped nobody calls back any more.
        api_.disable_force_output();
        api_.stop();
        api_.unschedule(schedule);
        drain();
        return end;
    }

private:
    /// Takes all errors; the gravest of them. A driver that has lost its device may never come to an end of them.
    ApiError drain() {
        ApiError worst;
        for (int n = 0; n < 64; ++n) {
            const ApiError error = api_.error();
            if (error.kind == ErrorKind::none) break;
            if (worst.kind == ErrorKind::none || error.kind == ErrorKind::communication ||
                (worst.kind == ErrorKind::force && error.kind == ErrorKind::other))
                worst = error;
        }
        return worst;
    }
    bool failed() {
        const ApiError error = drain();
        if (error.kind == ErrorKind::none) return false;
        report_.last_error = error.code;
        published_.put(report_);
        return true;
    }

    void begin() {
        report_ = {};
        refused_ = 0;
        stop_.store(false, std::memory_order_relaxed);
        done_.store(false, std::memory_order_relaxed);
        updates_.store(0, std::memory_order_relaxed);
        api_.enable_force_output();
        api_.enable_force_ramping();
        api_.enable_force_clamping();
    }

    /// Until the callback is done, or does not come any more.
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
                return hfh::DeviceEnd::lost;
            }
        }
        return end_;
    }

    /// One update, in the driver's thread. False: no more.
    template <class Tick>
    bool update(Tick& tick) noexcept {
        const double now = clock_.now();
        measure(now);

        api_.begin_frame(handle_);
        report_.calibration = api_.calibration();
        double position[3]{}, velocity[3]{};
        api_.position(position);
        api_.velocity(velocity);
        for (int k = 0; k < 3; ++k) position[k] -= middle_[k];
        const hfh::DeviceSample sample{.time = now,
                                       .position = z_up(position) / 1000.0,
                                       .velocity = z_up(velocity) / 1000.0,
                                       .has_velocity = true,
                                       .buttons = api_.buttons(),
                                       .force_refused = refused_ > 0};
        hfh::DeviceCommand command;
        if (report_.calibration == Calibration::ok) command = tick(sample);
        if (stop_.load(std::memory_order_relaxed)) command.go_on = false;
        const bool none = !command.go_on || refused_ > 0 || !hfh::is_finite(command.newtons);
        const glm::dvec3 newtons = none ? glm::dvec3{0.0} : command.newtons;
        double force[3]{newtons.x, newtons.z, -newtons.y};
        api_.set_force(force);
        api_.end_frame(handle_);
        if (report_.calibration == Calibration::needs_update) api_.update_calibration();
        report_.longest_tick = std::max(report_.longest_tick, clock_.now() - now);

        const bool go_on = judge(drain(), command.go_on);
        published_.put(report_);
        updates_.store(report_.updates, std::memory_order_relaxed);
        if (!go_on) done_.store(true, std::memory_order_release);
        return go_on;
    }

    /// +x right, +y up, +z to the user → +x right, +y away from the user, +z up.
    static glm::dvec3 z_up(const double (&p)[3]) noexcept { return {p[0], -p[2], p[1]}; }

    void measure(double now) noexcept {
        if (report_.updates++ > 0 && capabilities_.rate > 0) {
            const double past_due = now - last_ - 1 / capabilities_.rate;
            report_.latest = std::max(report_.latest, past_due);
            report_.late += past_due > options_.late_after;
        }
        last_ = now;
    }

    bool judge(const ApiError& error, bool go_on) noexcept {
        using hfh::DeviceEnd;
        if (error.kind != ErrorKind::none) report_.last_error = error.code;
        refused_ = error.kind == ErrorKind::force ? refused_ + 1 : 0;
        report_.force_errors += error.kind == ErrorKind::force;
        end_ = error.kind == ErrorKind::communication  ? DeviceEnd::lost
               : error.kind == ErrorKind::other        ? DeviceEnd::fault
               : refused_ >= options_.max_force_errors ? DeviceEnd::force_fault
                                                       : DeviceEnd::stopped;
        return go_on && end_ == DeviceEnd::stopped;
    }

    Options options_;
    Api api_;
    Clock clock_;
    typename Api::Handle handle_{};
    bool is_open_ = false;
    hfh::DeviceCapabilities capabilities_{};
    double middle_[3]{}; ///< mm, of the usable workspace, in the driver's axes

    // The driver's thread's during a run.
    Report report_{};
    double last_ = 0; ///< s: the last update
    int refused_ = 0; ///< updates in a row with a force error

    hfh::DeviceEnd end_ = hfh::DeviceEnd::stopped; ///< written before `done_`, read after it
    std::atomic<bool> done_{false}, stop_{false};
    std::atomic<unsigned long> updates_{0};
    hfh::LatestValue<Report> published_{};
};

} // namespace phantom

#endif // PHANTOM_PHANTOM_DEVICE_HPP
