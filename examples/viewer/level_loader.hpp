#ifndef VIEWER_LEVEL_LOADER_HPP
#define VIEWER_LEVEL_LOADER_HPP

#include "level_window.hpp"

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

namespace viewer {

/// One level's window, ready for the card.
struct LoadedLevel {
    int level = 0;
    hfh::Cell origin{0, 0};
    std::uint64_t version = 0; ///< equal numbers of one level: equal vertices
    bool has_holes = false;
    std::vector<LevelVertex> vertices;
};

/// Windows around one place that fit into each other, from the finest that is there to the coarsest.
struct LoadedLevels {
    glm::dvec2 place{0.0}; ///< samples: the middle of all windows
    std::vector<std::shared_ptr<const LoadedLevel>> levels;
    float steepness = 0;            ///< mean size of the slopes in the finest one
    std::uint64_t edit = 0;         ///< of `LevelRequest`
    std::uint64_t samples_read = 0; ///< total

    /// The height at a place (samples), of the finest window that has it: m above the datum. Empty where none has it, or it is
    /// a hole. n: vertices along a side of a window.
    [[nodiscard]] std::optional<float> height_at(const glm::dvec2& at, int n) const noexcept;
};

/// What the display wants to be loaded.
struct LevelRequest {
    glm::dvec2 place{0.0}; ///< samples
    int finest = 0;
    SampleRange changed{};  ///< to be read again
    std::uint64_t edit = 0; ///< the number of the last of these edits
};

/// Fills the windows of the display in a thread of its own, from the coarsest to the finest, so that the disk is waited for
/// here and nowhere else.
class LevelLoader {
public:
    /// `terrain` must outlive it. n: vertices along a side of a window, 4·m − 1. `coarsest_felt`: the coarsest level of the hand.
    LevelLoader(const DisplayedTerrain& terrain, int n, int coarsest_felt);
    ~LevelLoader();
    LevelLoader(const LevelLoader&) = delete;
    LevelLoader& operator=(const LevelLoader&) = delete;

    /// Asks for windows; takes the place of what was asked for before, but for its edits.
    void ask(const LevelRequest& request);
    /// The newest windows; none before the first ones are there.
    [[nodiscard]] std::shared_ptr<const LoadedLevels> newest() const;
    /// Waits until the last request has been met.
    void wait() const;

    /// The coarsest level: the first one whose window holds all of the terrain, or the coarsest that the hand can feel.
    [[nodiscard]] int coarsest() const noexcept { return coarsest_; }
    [[nodiscard]] int n() const noexcept { return n_; }

private:
    void run();
    void load(const LevelRequest& request);
    void publish(const LevelRequest& request, int finest);

    const DisplayedTerrain* terrain_;
    int n_, coarsest_;
    std::vector<LevelWindow> windows_; ///< by level
    std::vector<std::shared_ptr<const LoadedLevel>> loaded_;

    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    std::optional<LevelRequest> request_;
    std::shared_ptr<const LoadedLevels> newest_;
    bool busy_ = false, stopping_ = false;
    std::thread thread_;
};

} // namespace viewer

#endif // VIEWER_LEVEL_LOADER_HPP
