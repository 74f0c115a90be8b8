#ifndef PHANTOM_SHARED_DRIVER_HPP
#define PHANTOM_SHARED_DRIVER_HPP

#include "haptic_api.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>

namespace phantom {

/// What all devices of a process have in common: one scheduler, and one stack of errors. Whoever takes an error off the
/// stack may take another device's; it is put down for the device that it is about, or for all of them if it is about
/// none in particular, and each device finds the gravest of its own. An error of scheduling is about the devices that
/// have begun and were not called back yet, whichever the driver names: it names the current device, which another
/// thread's callback has made so.
///
/// The first device to run switches the motors of all open ones on and starts the scheduler; the last to leave switches
/// them off and stops it. While it runs, the thread that calls back owns the driver: nobody else takes errors, makes
/// another device the current one, or makes a call that may raise an error, but for the one that schedules. Hence all
/// devices are opened while none runs. A device that leaves while others run is left on the schedule if it has not said
/// itself that it is done; a running device's callback takes its force to zero. If it is destroyed, it is closed when
/// the scheduler has stopped.
template <HapticApi Api>
class SharedDriver {
public:
    using Handle = typename Api::Handle;
    static constexpr std::size_t max_devices = 8;
    static constexpr std::size_t none = max_devices;

    /// Holds off starting and stopping. Never taken in the callback.
    [[nodiscard]] static std::unique_lock<std::mutex> lock() { return std::unique_lock{mutex_}; }
    /// Under lock.
    [[nodiscard]] static bool is_running() { return running_ > 0; }
    [[nodiscard]] static bool is_alone() { return running_ == 1; }

    /// Under lock, while none runs: a place for a device; `none` if there are too many.
    [[nodiscard]] static std::size_t enter(Handle handle) {
        for (std::size_t k = 0; k < max_devices; ++k) {
            if (places_[k].is_open.load(std::memory_order_relaxed)) continue;
            places_[k].handle = handle;
            places_[k].gravest.store(0, std::memory_order_relaxed);
            places_[k].is_open.store(true, std::memory_order_release);
            return k;
        }
        return none;
    }
    /// Under lock: the device is closed, now or when the scheduler has stopped. Its place is its own until then, so that
    /// its errors are nobody else's.
    static void leave(Api& api, std::size_t place) {
        places_[place].is_left = true;
        if (!is_running()) close_left(api);
    }

    /// Under lock: one more device runs. The first switches the motors on; `start` follows where it answers true.
    [[nodiscard]] static bool begin(Api& api) {
        if (running_++ > 0) return false;
        for (Place& place : places_) {
            if (!place.is_open.load(std::memory_order_relaxed)) continue;
            make_current(api, place.handle);
            api.enable_force_output();
            api.enable_force_ramping();
            api.enable_force_clamping();
        }
        collect_errors(api);
        for (std::size_t k = 0; k < max_devices; ++k) places_[k].motors = take_error(k);
        return true;
    }
    /// Under lock, after `begin`: why the motors of a device could not be switched on.
    [[nodiscard]] static const ApiError& motors(std::size_t place) { return places_[place].motors; }

    /// Under lock: `callback` is called from now on, until it returns false or is held off. Whether that has failed is
    /// told later, by `take_scheduling_error`.
    static void schedule(Api& api, std::size_t which, const Callback& callback) {
        Place& place = places_[which];
        place.callback = callback;
        place.scheduling_error.store(0, std::memory_order_relaxed);
        place.needs_zero.store(false, std::memory_order_relaxed);
        place.is_starting.store(true);
        place.is_done.store(false);
        place.is_held_off.store(false);
        place.entry = {&call_back, &place};
        place.schedule = api.schedule(place.entry);
    }
    /// Under lock, for a device that does not run: whether an earlier callback of its may still be called.
    [[nodiscard]] static bool is_scheduled(std::size_t place) {
        return places_[place].schedule && !places_[place].is_done.load();
    }
    /// In the callback: errors of scheduling are not this device's any more.
    static void has_started(std::size_t place) noexcept {
        places_[place].is_starting.store(false, std::memory_order_relaxed);
        places_[place].scheduling_error.store(0, std::memory_order_relaxed);
    }
    /// The driver's code of the error by which scheduling has failed; 0 if it has not. What has failed is not on the
    /// schedule.
    [[nodiscard]] static unsigned take_scheduling_error(std::size_t place) {
        const unsigned code = places_[place].scheduling_error.exchange(0, std::memory_order_relaxed);
        if (code != 0) places_[place].schedule.reset();
        return code;
    }
    /// The callback is not called any more but for a call that is going on.
    static void hold_off(std::size_t place) { places_[place].is_held_off.store(true); }
    [[nodiscard]] static bool is_busy(std::size_t place) { return places_[place].is_busy.load(); }

    /// Under lock: one less; its callback is held off, and not busy where others go on. `is_at_zero`: its last update has
    /// sent no force. Motors off first; once the scheduler has stopped nobody calls back any more.
    static void end(Api& api, std::size_t which, bool is_at_zero) {
        Place& own = places_[which];
        own.is_starting.store(false);
        if (--running_ > 0) {
            own.needs_zero.store(own.schedule && !is_at_zero, std::memory_order_release);
            if (own.is_done.load()) own.schedule.reset();
            return;
        }
        for (Place& place : places_) {
            if (!place.is_open.load(std::memory_order_relaxed)) continue;
            make_current(api, place.handle);
            api.disable_force_output();
        }
        api.stop();
        for (Place& place : places_) {
            if (place.schedule) api.unschedule(*place.schedule);
            place.schedule.reset();
            place.needs_zero.store(false, std::memory_order_relaxed);
        }
        close_left(api);
        discard_errors(api);
    }
    /// In the callback, outside of a frame: forces to zero that were left by devices whose callback has not come any
    /// more.
    static void zero_left(Api& api) noexcept {
        if constexpr (!MonitoredApi<Api>) return; // one device at a time
        for (Place& place : places_) {
            if (!place.needs_zero.load(std::memory_order_acquire)) continue;
            place.needs_zero.store(false, std::memory_order_relaxed);
            make_current(api, place.handle);
            api.begin_frame(place.handle);
            double force[3]{};
            api.set_force(force);
            api.end_frame(place.handle);
        }
    }

    /// Takes all errors off the stack and puts them down, each for whom it is about.
    static void collect_errors(Api& api) noexcept {
        for (int n = 0; n < most_errors; ++n) {
            const ApiError error = api.error();
            if (error.kind == ErrorKind::none) return;
            put_down(error);
        }
    }
    /// The same after a question about the current device: whether one of them is the question's own, which is put down
    /// for nobody.
    [[nodiscard]] static bool collect_refusal(Api& api) noexcept {
        bool is_refused = false;
        for (int n = 0; n < most_errors; ++n) {
            const ApiError error = api.error();
            if (error.kind == ErrorKind::none) break;
            if (error.kind == ErrorKind::other)
                is_refused = true;
            else
                put_down(error);
        }
        return is_refused;
    }
    /// Takes all errors off the stack, for nobody; the most recent of them.
    static ApiError discard_errors(Api& api) noexcept {
        const ApiError first = api.error();
        for (int n = 1; n < most_errors; ++n)
            if (api.error().kind == ErrorKind::none) break;
        return first;
    }
    /// The gravest error put down for a place since the last time; of equally grave ones that which came off the stack
    /// first.
    [[nodiscard]] static ApiError take_error(std::size_t place) noexcept {
        const std::uint64_t bits = places_[place].gravest.exchange(0, std::memory_order_relaxed);
        return {static_cast<ErrorKind>(bits >> 32), static_cast<unsigned>(bits), -1};
    }

    static void make_current(Api& api, Handle handle) {
        if constexpr (MonitoredApi<Api>) api.make_current(handle);
    }

private:
    /// A driver that has lost its device may never come to an end of them.
    static constexpr int most_errors = 64;

    struct Place {
        std::atomic<bool> is_open{false};
        std::atomic<std::uint64_t> gravest{0}; ///< kind in the upper half, code in the lower
        Handle handle{};                       ///< written while closed

        // Under lock.
        bool is_left = false; ///< destroyed, and not closed yet
        ApiError motors{};
        std::optional<typename Api::Schedule> schedule{}; ///< what may be on the schedule

        /// What the scheduler is given; lives on where a device does not.
        Callback entry{};
        Callback callback{}; ///< the device's: written while held off
        std::atomic<bool> is_held_off{true}, is_busy{false}, is_done{false};
        std::atomic<bool> is_starting{false}; ///< begun, and not called back yet
        std::atomic<unsigned> scheduling_error{0};
        std::atomic<bool> needs_zero{false};
    };

    static bool call_back(void* user) noexcept {
        // Of two flags, each set before the other is read, one side sees the other's.
        auto& place = *static_cast<Place*>(user);
        place.is_busy.store(true);
        const bool go_on = !place.is_held_off.load() && place.callback.call(place.callback.user);
        if (!go_on) place.is_done.store(true);
        place.is_busy.store(false);
        return go_on;
    }

    /// Under lock, while none runs.
    static void close_left(Api& api) {
        for (Place& place : places_) {
            if (!place.is_left) continue;
            api.close(place.handle);
            place.is_left = false;
            place.is_open.store(false, std::memory_order_release);
        }
    }

    static void put_down(const ApiError& error) noexcept {
        if (error.kind == ErrorKind::scheduling) {
            for (Place& place : places_)
                if (place.is_starting.load(std::memory_order_relaxed))
                    place.scheduling_error.store(error.code, std::memory_order_relaxed);
            return;
        }
        const bool has_owner = std::any_of(places_.begin(), places_.end(),
                                           [&](const Place& place) { return is_about(error, place); });
        for (Place& place : places_)
            if (has_owner ? is_about(error, place) : place.is_open.load(std::memory_order_acquire))
                put(place, error);
    }
    [[nodiscard]] static bool is_about(const ApiError& error, const Place& place) noexcept {
        return place.is_open.load(std::memory_order_acquire) && error.device >= 0 &&
               error.device == static_cast<long long>(place.handle);
    }
    static void put(Place& place, const ApiError& error) noexcept {
        const std::uint64_t bits = std::uint64_t{static_cast<unsigned char>(error.kind)} << 32 | error.code;
        std::uint64_t before = place.gravest.load(std::memory_order_relaxed);
        while (before >> 32 < bits >> 32 &&
               !place.gravest.compare_exchange_weak(before, bits, std::memory_order_relaxed)) {
        }
    }

    static inline std::mutex mutex_;
    static inline int running_ = 0; ///< devices, under lock
    static inline std::array<Place, max_devices> places_{};
};

} // namespace phantom

#endif // PHANTOM_SHARED_DRIVER_HPP
