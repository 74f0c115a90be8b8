#ifndef POLLED_POLLED_DEVICE_HPP
#define POLLED_POLLED_DEVICE_HPP

#include <hfh/device/device.hpp>

#include <atomic>
#include <chrono>
#include <concepts>

// Devices that do not call back, as hfh::Device. README.md in this directory tells which driver goes with which, and what
// to set the guard to. The driver's calls go through `Api`, in SI units, z up, the origin in the middle of the workspace;
// time goes through `Clock`.

namespace polled {

struct SteadyClock {
    [[nodiscard]] double now() const noexcept {
        return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    }
};

/// What the driver tells.
struct Reading {
    glm::dvec3 position{0.0}; ///< m
    glm::dvec3 velocity{0.0}; ///< m/s, if `has_velocity`
    bool has_velocity = false;
    unsigned buttons = 0;
};

/// A driver that is asked for the position and told the force (Force Dimension). False: the connection is lost. `read` may
/// give what it gave before, if asked faster than the device samples.
// clang-format off
template <class A>
concept PolledApi = requires(A& api, Reading& reading, const glm::dvec3& newtons) {
    { api.read(reading) } -> std::same_as<bool>;
    { api.send(newtons) } -> std::same_as<bool>;
};

/// A driver that gives a position for a force (Haply). False: the connection is lost.
template <class A>
concept ExchangeApi = requires(A& api, const glm::dvec3& newtons, Reading& reading) {
    { api.exchange(newtons, reading) } -> std::same_as<bool>;
};
// clang-format on

/// What the two have in common: the sample, what was sent last, and the stop.
class Loop {
public:
    /// Ends the run at its next update; without one, the next run before it begins. From any thread, or a signal handler.
    void stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

protected:
    static_assert(std::atomic<bool>::is_always_lock_free, "stop() is called from signal handlers");

    void begin() noexcept { has_sent_ = false; }
    [[nodiscard]] bool is_stopped() const noexcept { return stop_.load(std::memory_order_relaxed); }
    hfh::DeviceEnd end(hfh::DeviceEnd how) noexcept {
        stop_.store(false, std::memory_order_relaxed);
        return how;
    }

    /// Zero if the tick, or somebody else, wants no more; and where the force is no number.
    template <class Tick>
    hfh::DeviceCommand call(Tick& tick, double now, const Reading& reading) {
        hfh::DeviceCommand command = tick(hfh::DeviceSample{.time = now,
                                                            .position = reading.position,
                                                            .velocity = reading.velocity,
                                                            .has_velocity = reading.has_velocity,
                                                            .buttons = reading.buttons,
                                                            .has_sent = has_sent_,
                                                            .sent = sent_,
                                                            .sent_at = sent_at_});
        if (is_stopped()) command.go_on = false;
        if (!command.go_on || !hfh::is_finite(command.newtons)) command.newtons = glm::dvec3{0.0};
        has_sent_ = true;
        sent_ = command.newtons;
        sent_at_ = now;
        return command;
    }

private:
    std::atomic<bool> stop_{false};
    bool has_sent_ = false;
    glm::dvec3 sent_{0.0}; ///< N
    double sent_at_ = 0;   ///< s
};

/// Reads, ticks, sends, without a pause: the driver's calls set the pace. `capabilities` are the maker's, with the rate at
/// which the device samples (not the one at which it is asked).
template <PolledApi Api, class Clock = SteadyClock>
class PolledDevice : public Loop {
public:
    explicit PolledDevice(const hfh::DeviceCapabilities& capabilities, Api api = {}, Clock clock = {})
        : capabilities_{capabilities}, api_{api}, clock_{clock} {}

    [[nodiscard]] hfh::DeviceCapabilities capabilities() const noexcept { return capabilities_; }

    template <hfh::DeviceTick Tick>
    hfh::DeviceEnd run(Tick&& tick) {
        begin();
        bool pushes = false; // the motors hold a force
        while (!is_stopped()) {
            Reading reading;
            if (!api_.read(reading)) {
                (void)api_.send(glm::dvec3{0.0}); // in case it is only the way back that is lost
                return end(hfh::DeviceEnd::lost);
            }
            const hfh::DeviceCommand command = call(tick, clock_.now(), reading);
            if (!api_.send(command.newtons)) return end(hfh::DeviceEnd::lost);
            pushes = command.newtons != glm::dvec3{0.0};
            if (!command.go_on) break;
        }
        // Stopped after the tick, which the force had left by then.
        if (pushes && !api_.send(glm::dvec3{0.0})) return end(hfh::DeviceEnd::lost);
        return end(hfh::DeviceEnd::stopped);
    }

private:
    hfh::DeviceCapabilities capabilities_;
    Api api_;
    Clock clock_;
};

/// Exchanges the force of the last tick for a position, ticks. The first force is a zero for nothing, and a force acts one
/// exchange later than with a driver that is polled: `delay` is one more than `capabilities` say.
template <ExchangeApi Api, class Clock = SteadyClock>
class ExchangeDevice : public Loop {
public:
    explicit ExchangeDevice(const hfh::DeviceCapabilities& capabilities, Api api = {}, Clock clock = {})
        : capabilities_{capabilities}, api_{api}, clock_{clock} {
        if (capabilities_.delay != hfh::unknown_delay) ++capabilities_.delay;
    }

    [[nodiscard]] hfh::DeviceCapabilities capabilities() const noexcept { return capabilities_; }

    template <hfh::DeviceTick Tick>
    hfh::DeviceEnd run(Tick&& tick) {
        begin();
        hfh::DeviceCommand command;
        while (command.go_on && !is_stopped()) {
            Reading reading;
            if (!api_.exchange(command.newtons, reading)) return end(hfh::DeviceEnd::lost);
            command = call(tick, clock_.now(), reading);
        }
        Reading unused;
        (void)api_.exchange(glm::dvec3{0.0}, unused);
        return end(hfh::DeviceEnd::stopped);
    }

private:
    hfh::DeviceCapabilities capabilities_;
    Api api_;
    Clock clock_;
};

} // namespace polled

#endif // POLLED_POLLED_DEVICE_HPP
