#ifndef PHANTOM_SHARED_DRIVER_HPP
#define PHANTOM_SHARED_DRIVER_HPP

#include "haptic_api.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>

namespace phantom {

/// What all devices of a process have in common: one scheduler, and one stack of errors. Whoever takes an error off the
/// stack may take another device's; it is put down for the device that it is about, or for all of them if it is about
/// none in particular, and each device finds the gravest of its own.
///
/// The first device to run switches the motors of all open ones on and starts the scheduler; the last to leave switches
/// them off and stops it. While it runs, the thread that calls back owns the driver: nobody else takes errors or makes
/// another device the current one. Hence all devices are opened while none runs.
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
    static void leave(std::size_t place) { places_[place].is_open.store(false, std::memory_order_release); }

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
        return true;
    }
    /// Under lock: one less. Motors off first; once the scheduler has stopped nobody calls back any more.
    static void end(Api& api) {
        if (--running_ > 0) return;
        for (Place& place : places_) {
            if (!place.is_open.load(std::memory_order_relaxed)) continue;
            make_current(api, place.handle);
            api.disable_force_output();
        }
        api.stop();
    }

    /// Takes all errors off the stack and puts them down, each for whom it is about.
    static void collect_errors(Api& api) noexcept {
        for (int n = 0; n < most_errors; ++n) {
            const ApiError error = api.error();
            if (error.kind == ErrorKind::none) return;
            put_down(error);
        }
    }
    static void put_down(const ApiError& error) noexcept {
        const bool has_owner = std::any_of(places_.begin(), places_.end(),
                                           [&](const Place& place) { return is_about(error, place); });
        for (Place& place : places_)
            if (has_owner ? is_about(error, place) : place.is_open.load(std::memory_order_acquire))
                put(place, error);
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
    };

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
