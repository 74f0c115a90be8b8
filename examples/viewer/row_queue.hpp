#ifndef VIEWER_ROW_QUEUE_HPP
#define VIEWER_ROW_QUEUE_HPP

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace viewer {

/// Values in order from one thread to another, without waiting: for records and charts, which want every update and not only
/// the newest. Where the reader is more than `Size` values late, new ones are dropped and counted.
template <class T, std::size_t Size>
class RowQueue {
public:
    /// By the one thread that writes.
    void put(const T& value) noexcept {
        const std::uint64_t at = written_.load(std::memory_order_relaxed);
        if (at - read_.load(std::memory_order_acquire) == Size) {
            dropped_.fetch_add(1, std::memory_order_relaxed);
            return;
        }
        slots_[at % Size] = value;
        written_.store(at + 1, std::memory_order_release);
    }

    /// By the one thread that reads: calls `use` with every value that has come since.
    template <class Use>
    void drain(Use&& use) {
        const std::uint64_t end = written_.load(std::memory_order_acquire);
        for (std::uint64_t at = read_.load(std::memory_order_relaxed); at != end; ++at) {
            use(slots_[at % Size]);
            read_.store(at + 1, std::memory_order_release);
        }
    }

    [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

private:
    std::array<T, Size> slots_{};
    alignas(64) std::atomic<std::uint64_t> written_{0};
    alignas(64) std::atomic<std::uint64_t> read_{0};
    std::atomic<std::uint64_t> dropped_{0};
};

} // namespace viewer

#endif // VIEWER_ROW_QUEUE_HPP
