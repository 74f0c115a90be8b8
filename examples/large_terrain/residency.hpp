#ifndef LARGE_TERRAIN_RESIDENCY_HPP
#define LARGE_TERRAIN_RESIDENCY_HPP

#include "page_reader.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

namespace large_terrain {

struct ResidencySettings {
    hfh::Index margin = 64;      ///< cells kept to every side of the stylus
    double look_ahead = 0.25;    ///< s along the motion: longer than the disk takes for one round
    hfh::Index most_ahead = 384; ///< cells: bounds the work of a round, however fast the stylus seems to be
    std::chrono::milliseconds pause{4}; ///< between rounds
};

struct ResidencyReport {
    std::uint64_t rounds = 0;
    std::uint64_t ranges = 0; ///< handed to the kernel
    std::chrono::nanoseconds longest_round{0};
    long page_reads = 0; ///< pages that the helper waited for instead of the haptic thread
};

/// Where the stylus will be in `look_ahead` seconds if it goes on as it did in the `elapsed` seconds from `before` to
/// `here`; at most `most_ahead` cells from here in i and in j. Precondition: elapsed > 0.
[[nodiscard]] hfh::Cell foresee(hfh::Cell before, hfh::Cell here, double elapsed,
                                const ResidencySettings& settings) noexcept;

/// A cell's numbers, of which 32 bits each are kept, in one word that two threads may share.
[[nodiscard]] inline std::uint64_t pack(hfh::Cell c) noexcept {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(c.i)) << 32 |
           static_cast<std::uint32_t>(c.j);
}
[[nodiscard]] inline hfh::Cell unpack(std::uint64_t bits) noexcept {
    return {static_cast<std::int32_t>(bits >> 32), static_cast<std::int32_t>(bits)};
}

/// Keeps the memory-mapped samples around the stylus in memory, so that a haptic update never waits for the disk.
///
/// A second thread of low priority looks every few milliseconds where the stylus is, takes its velocity from where it
/// was the last time, and has the kernel read and map the pages of the box around here and the place foreseen. A round
/// asks for at most 2·margin + most_ahead + 2 rows. Pages are never locked or given back: the kernel does that.
///
/// The haptic thread does one relaxed store an update: it cannot be made to wait. For one level of detail;
/// `LevelResidency` is for all of them.
class Residency {
public:
    /// Brings in the neighbourhood of the first position, waiting for the disk, and starts the thread. The mapping must
    /// outlive it.
    Residency(const SampleLayout& layout, hfh::Cell here, const ResidencySettings& settings = {});
    ~Residency() { stop(); }
    Residency(const Residency&) = delete;
    Residency& operator=(const Residency&) = delete;

    /// Ends the thread; for good.
    void stop();

    /// The stylus is over cell c. Wait-free. Keeps the lower 32 bits of its numbers.
    void note(hfh::Cell c) noexcept { position_.store(pack(c), std::memory_order_relaxed); }

    /// Of the rounds so far; call after `stop`.
    [[nodiscard]] const ResidencyReport& report() const noexcept { return report_; }

private:
    void run();
    void bring_in(hfh::Cell here, hfh::Cell there);

    SampleLayout layout_;
    ResidencySettings settings_;
    PageReader pages_;
    std::atomic<std::uint64_t> position_{0};
    std::atomic<bool> stopping_{false};
    ResidencyReport report_;
    std::thread thread_;
};

static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "the haptic thread must not wait");

} // namespace large_terrain

#endif // LARGE_TERRAIN_RESIDENCY_HPP
