#ifndef LARGE_TERRAIN_LEVEL_RESIDENCY_HPP
#define LARGE_TERRAIN_LEVEL_RESIDENCY_HPP

#include "residency.hpp"

#include <hfh/device/triple_buffer.hpp>

#include <array>

namespace large_terrain {

struct LevelResidencySettings {
    hfh::Index margin = 64; ///< cells of a level kept to every side of the stylus
    hfh::Index reach = 24; ///< cells of a level around stylus and proxy that an update may read; below margin
    double look_ahead = 0.25;    ///< s along the motion, and along the zoom
    hfh::Index most_ahead = 256; ///< cells of a level: bounds the work of a round
    double most_change =
        0.02; ///< of the level in one update, so that the ground does not jump under the hand
    std::size_t whole = 64 << 20; ///< bytes: the finest level whose pages are no more is kept as a whole
    std::chrono::milliseconds pause{4}; ///< between rounds
};

/// How the level waited for the disk.
struct LevelWaits {
    std::uint64_t waits = 0;   ///< how often it began to
    std::uint64_t updates = 0; ///< in which it did
    std::uint64_t longest = 0; ///< updates one after another
    double farthest = 0;       ///< levels between the one wanted and the one set meanwhile, at most
};

/// Keeps the memory-mapped samples around the stylus in memory at every level of detail that it is about to touch, and
/// tells which level it may touch now. Level k has every 2ᵏ-th sample, as in `hfh::StridedLevels`.
///
/// *Who decides the level.* The application wants one, `hfh::suitable_level` of its scale or what the user asks for. Each
/// update, before anything reads the ground, it asks `level_for` and gives the answer to `hfh::change_level`:
///
///     level = residency.level_for(stylus_cell, proxy_cell, wanted);
///     rise = change_level(ground, level, tracker);
///
/// *What waits.* The level, never the hand: the stylus goes where the hand is and the scale is what the user sets, on
/// ground that is coarser or finer than wanted. The answer is the wanted level where the samples that an update on it may
/// read are in memory, else the nearest level whose are. It goes towards the wanted level by at most `most_change` an
/// update. Where the hand leaves what is in memory, it changes at once. A coarse level is kept as a whole from the start,
/// so there is always an answer. The second thread alone waits for the disk; the haptic thread does three relaxed stores
/// and takes from a triple buffer.
///
/// *What is reported.* `waiting()` after each update, for a display; `waits()`: how often, how long and how far the level
/// was from the one that was wanted; `report()`: the rounds of the second thread.
///
/// Pages are never locked or given back. A level that no round asks for is no longer counted as in memory. While memory is
/// short the kernel may still take pages between two rounds.
class LevelResidency {
public:
    /// Brings in the coarse levels and the neighbourhood of the first position on the first level, waiting for the disk, and
    /// starts the thread. `finest` is level 0. The mapping must outlive this.
    LevelResidency(const SampleLayout& finest, hfh::Cell here, double level,
                   const LevelResidencySettings& settings = {});
    ~LevelResidency() { stop(); }
    LevelResidency(const LevelResidency&) = delete;
    LevelResidency& operator=(const LevelResidency&) = delete;

    /// Ends the thread; for good.
    void stop();

    /// By the haptic thread: the level to set, while the stylus and its proxy are over these cells of level 0 and `wanted`
    /// is the level wanted, any finite number. Wait-free.
    [[nodiscard]] double level_for(hfh::Cell stylus, hfh::Cell proxy, double wanted) noexcept;

    /// Whether the last answer was another for want of samples. For the haptic thread.
    [[nodiscard]] bool waiting() const noexcept { return waiting_ > 0; }
    /// So far. For the haptic thread, or once that has ended.
    [[nodiscard]] const LevelWaits& waits() const noexcept { return waits_; }

    /// Of the rounds so far; call after `stop`.
    [[nodiscard]] const ResidencyReport& report() const noexcept { return report_; }

    /// Coarser levels are in memory as a whole, and so is this one.
    [[nodiscard]] int whole_level() const noexcept { return whole_; }

private:
    static constexpr int most_levels = 32;
    /// Of each level those vertices, in its own numbers, whose samples are in memory.
    using Boxes = std::array<hfh::VertexRange, most_levels>;

    [[nodiscard]] bool in_memory(int level, hfh::Cell stylus, hfh::Cell proxy) const noexcept;
    [[nodiscard]] double nearest_in_memory(double level, hfh::Cell stylus, hfh::Cell proxy) const noexcept;
    void count_wait(bool waits, double behind) noexcept;
    void run();
    void bring_in_whole();
    void bring_in(int level, hfh::Cell here, hfh::Cell there);
    void round(hfh::Cell here, hfh::Cell before, double wanted, double wanted_before, double elapsed);

    LevelResidencySettings settings_;
    std::array<SampleLayout, most_levels> levels_{};
    int last_ = 0;  ///< the coarsest level
    int whole_ = 0; ///< kept as a whole, and so coarser ones

    // Of the haptic thread.
    double level_;
    Boxes known_{};
    std::uint64_t waiting_ = 0; ///< updates of the present wait
    LevelWaits waits_;

    // Between the threads.
    std::atomic<std::uint64_t> position_;
    std::atomic<double> wanted_, set_;
    std::atomic<bool> stopping_{false};
    hfh::TripleBuffer<Boxes> brought_in_;

    // Of the second thread.
    PageReader pages_;
    Boxes boxes_{};
    ResidencyReport report_;
    std::thread thread_;
};

static_assert(std::atomic<double>::is_always_lock_free, "the haptic thread must not wait");

} // namespace large_terrain

#endif // LARGE_TERRAIN_LEVEL_RESIDENCY_HPP
