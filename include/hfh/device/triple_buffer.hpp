#ifndef HFH_DEVICE_TRIPLE_BUFFER_HPP
#define HFH_DEVICE_TRIPLE_BUFFER_HPP

#include <atomic>
#include <type_traits>

// From the haptic loop to a display: the last value wins, nobody waits.

namespace hfh {

/// A triple buffer. One thread puts, one takes; each does one atomic exchange and one copy and never waits for the
/// other, whatever the other is doing (where exchange is one instruction, as on x86-64 and ARMv8.1, this is wait-free to
/// the letter; elsewhere it is a loop that only the other's exchange can make go round). A value that was not taken in
/// time is overwritten.
///
/// Of the three slots one is the writer's, one the reader's, and one lies between, whose number is in `between_`, with
/// a mark if it holds a value that was not taken yet. Putting fills the writer's slot and exchanges it for the one
/// between; taking exchanges the reader's for it, if marked. So no slot is ever in two hands. Memory orders:
/// - put releases, take acquires: the copy into a slot comes before the copy out of it, so no value is torn.
/// - take releases, put acquires: the reader is done with a slot before the writer fills it again.
/// Hence acq_rel for both exchanges. The reader's look at the mark may be relaxed: nothing is read by its leave, and the
/// exchange that follows acquires. All exchanges are of one object, so they have one order, and values come in the order
/// in which they were put.
///
/// Does not allocate, throw or lock.
template <class T>
class TripleBuffer {
public:
    static_assert(std::is_trivially_copyable_v<T>, "a value is copied like plain bytes, and cannot throw");
    static_assert(std::is_default_constructible_v<T>, "before the first value there is T{}");

    TripleBuffer() noexcept = default;
    TripleBuffer(const TripleBuffer&) = delete; // two threads hold on to it
    TripleBuffer& operator=(const TripleBuffer&) = delete;

    /// By the one thread that writes.
    void put(const T& value) noexcept {
        slots_[writers_].value = value;
        writers_ =
            between_.exchange(static_cast<unsigned char>(writers_ | fresh), std::memory_order_acq_rel) & 3u;
    }

    /// By the one thread that reads: the last value put, and whether it is another than the last time. T{} before any.
    [[nodiscard]] bool take(T& value) noexcept {
        const bool is_new = (between_.load(std::memory_order_relaxed) & fresh) != 0;
        if (is_new) readers_ = between_.exchange(readers_, std::memory_order_acq_rel) & 3u;
        value = slots_[readers_].value;
        return is_new;
    }

private:
    static_assert(std::atomic<unsigned char>::is_always_lock_free);
    static constexpr unsigned char fresh = 4;

    /// A cache line or more each: the threads do not slow each other down.
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
