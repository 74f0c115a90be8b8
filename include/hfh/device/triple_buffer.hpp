#ifndef HFH_DEVICE_TRIPLE_BUFFER_HPP
#define HFH_DEVICE_TRIPLE_BUFFER_HPP

#include <atomic>
#include <type_traits>

// From the haptic loop to a display: the last value wins, and neither thread waits.

namespace hfh {

/// A triple buffer. One thread puts, one takes. Each does one atomic exchange and one copy and never waits for the other,
/// whatever the other is doing. Where an exchange is one instruction, as on x86-64 and ARMv8.1, this is wait-free in the
/// strict sense; elsewhere it is a loop that repeats only after an exchange by the other thread. A value that was not taken
/// in time is overwritten.
///
/// Of the three slots one is the writer's, one the reader's, and one lies between; `between_` has its number, with a mark
/// if it holds a value that was not taken yet. Putting fills the writer's slot and exchanges it for the one between;
/// taking exchanges the reader's slot for it, if marked. So no slot is ever used by both threads. Memory orders:
/// - put releases, take acquires: the copy into a slot comes before the copy out of it, so no value is torn.
/// - take releases, put acquires: the reader is done with a slot before the writer fills it again.
/// Hence acq_rel for both exchanges. The reader's load of the mark may be relaxed, because the exchange that follows
/// acquires before a slot is read. All exchanges are of one object, so they have one order, and values come in the order in
/// which they were put.
///
/// Does not allocate, throw or lock.
template <class T>
class TripleBuffer {
public:
    static_assert(std::is_trivially_destructible_v<T>,
                  "a value owns nothing, so a copy does not allocate, throw or lock");
    static_assert(std::is_default_constructible_v<T>, "before the first value there is T{}");

    TripleBuffer() noexcept = default;
    TripleBuffer(const TripleBuffer&) = delete; // two threads refer to it
    TripleBuffer& operator=(const TripleBuffer&) = delete;

    /// By the one thread that writes.
    void put(const T& value) noexcept {
        slots_[writers_].value = value;
        writers_ =
            between_.exchange(static_cast<unsigned char>(writers_ | fresh), std::memory_order_acq_rel) & 3u;
    }

    /// By the one thread that reads: the last value put, and whether it was put since the last call. T{} before any.
    [[nodiscard]] bool take(T& value) noexcept {
        const bool is_new = (between_.load(std::memory_order_relaxed) & fresh) != 0;
        if (is_new) readers_ = between_.exchange(readers_, std::memory_order_acq_rel) & 3u;
        value = slots_[readers_].value;
        return is_new;
    }

private:
    static_assert(std::atomic<unsigned char>::is_always_lock_free);
    static constexpr unsigned char fresh = 4;

    /// A cache line or more each, so that the threads do not write to one line.
    struct alignas(64) Slot {
        T value{};
    };

    Slot slots_[3]{};
    alignas(64) unsigned char writers_ = 0;
    alignas(64) unsigned char readers_ = 1;
    alignas(64) std::atomic<unsigned char> between_{2};
};

} // namespace hfh

#endif // HFH_DEVICE_TRIPLE_BUFFER_HPP
