#ifndef VIEWER_HAPTIC_THREAD_HPP
#define VIEWER_HAPTIC_THREAD_HPP

#include <distribution.hpp>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>

namespace viewer {

/// How punctual a haptic loop was.
struct Punctuality {
    std::uint64_t ticks = 0;
    std::uint64_t skipped = 0; ///< whose time had passed before the loop got to them
    std::uint64_t late = 0;    ///< began more than 1 ms after their time
    std::array<std::uint64_t, 8>
        lateness{};                   ///< ticks by how late they began, in the classes of `lateness_class`
    demo::Distribution nanoseconds;   ///< of a tick itself
    std::uint64_t worst_lateness = 0; ///< ns
    long disk_reads = 0;              ///< page faults that waited for the disk
    bool real_time = false;           ///< SCHED_FIFO
};

/// Upper bounds of the classes, in microseconds; the last one has none.
inline constexpr std::array<int, 7> lateness_class{20, 50, 100, 200, 500, 1000, 5000};

/// Calls a tick every millisecond, in a thread that comes before all others where the system allows it. A tick that is missed
/// is skipped and never made up for. Never waits for anything but the clock.
class HapticThread {
public:
    explicit HapticThread(std::function<void()> tick);
    ~HapticThread() { stop(); }
    HapticThread(const HapticThread&) = delete;
    HapticThread& operator=(const HapticThread&) = delete;

    /// Ends the thread after the present tick.
    void stop();
    /// After `stop`.
    [[nodiscard]] const Punctuality& punctuality() const noexcept { return punctuality_; }
    /// Whether the thread got real-time priority; known once the first tick has run.
    [[nodiscard]] bool is_real_time() const noexcept { return real_time_.load(std::memory_order_relaxed); }

private:
    void run();

    std::function<void()> tick_;
    std::atomic<bool> stopping_{false}, real_time_{false};
    Punctuality punctuality_;
    std::thread thread_;
};

/// The lines about a haptic loop that are printed at the end.
[[nodiscard]] std::string report(const Punctuality& punctuality);

} // namespace viewer

#endif // VIEWER_HAPTIC_THREAD_HPP
