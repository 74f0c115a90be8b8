#ifndef TOUCH_TERRAIN_SESSION_HPP
#define TOUCH_TERRAIN_SESSION_HPP

#include "distribution.hpp"
#include "stylus_path.hpp"
#include "terrain.hpp"
#include "touch.hpp"

#include <hfh/loop/haptic_loop.hpp>
#include <hfh/terrain/bilinear_grid.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

namespace demo {

struct Summary {
    std::uint64_t updates = 0;
    std::uint64_t in_contact = 0;
    std::uint64_t buried = 0;
    std::uint64_t refused = 0;   ///< positions with status bad_input
    double largest_force = 0;    ///< N, as felt
    Distribution patches;        ///< looked at, per update
    Distribution nanoseconds;    ///< per update, from the sample to the force
    std::size_t state_bytes = 0; ///< what the tracker remembers from update to update
    hfh::GuardCounts guard;      ///< what the guard did
};

/// What holds the stylus: one step a call, then nothing.
using StepSource = std::function<std::optional<StylusStep>()>;
/// Takes the force that is felt, in N at the hand, and whether the stylus is buried.
using ForceSink = std::function<void(const glm::dvec3& newtons, bool buried)>;

/// How the stylus feels the terrain.
struct Feeling {
    hfh::HapticLoopOptions loop{};
    /// False: the stylus is in nobody's hand and feels what the terrain asks for, whatever a guard says. No force moves it,
    /// none can hurt, and its path may be of any speed.
    bool guarded = true;
    hfh::Index bridge = 0; ///< cells: holes up to this width are spanned
};

/// Moves the stylus along `path` over the terrain, one update a step, and hands the force to `feel` and every touch to
/// `on_touch` before it asks for the next step.
template <hfh::Real T>
Summary touch_terrain(const Terrain& terrain, const hfh::GridFrame& frame, const Feeling& feeling,
                      const StepSource& path, const ForceSink& feel,
                      const std::function<void(const Touch&)>& on_touch);

} // namespace demo

#endif // TOUCH_TERRAIN_SESSION_HPP
