#ifndef RECIPES_SINGLE_QUEUE_HPP
#define RECIPES_SINGLE_QUEUE_HPP

#include <array>
#include <atomic>
#include <cstddef>
#include <type_traits>

namespace recipes {

/// A queue from one thread to one other. Neither waits: `push` says so when there is no room, `pop` when there is nothing.
/// Nothing is lost and the order stays, unlike in `hfh::TripleBuffer`, which is for values of which only the newest counts.
///
/// `pushed_` and `popped_` count for ever and each is written by one thread only. A release store of a count makes what was
/// done to the slot visible to the thread that acquires it.
template <class T, std::size_t Slots>
class SingleQueue {
    static_assert(std::is_trivially_copyable_v<T> && Slots > 0);

public:
    /// By the one thread that fills it. False: full, and `value` is not in it.
    [[nodiscard]] bool push(const T& value) noexcept {
        const std::size_t at = pushed_.load(std::memory_order_relaxed);
        if (at - popped_.load(std::memory_order_acquire) == Slots) return false;
        slots_[at % Slots] = value;
        pushed_.store(at + 1, std::memory_order_release);
        return true;
    }

    /// By the one thread that empties it. False: empty, and `value` is as it was.
    [[nodiscard]] bool pop(T& value) noexcept {
        const std::size_t at = popped_.load(std::memory_order_relaxed);
        if (at == pushed_.load(std::memory_order_acquire)) return false;
        value = slots_[at % Slots];
        popped_.store(at + 1, std::memory_order_release);
        return true;
    }

private:
    std::array<T, Slots> slots_{};
    alignas(64) std::atomic<std::size_t> pushed_{
        0}; // a cache line each, so that the threads do not share one
    alignas(64) std::atomic<std::size_t> popped_{0};
};

} // namespace recipes

#endif // RECIPES_SINGLE_QUEUE_HPP
