#ifndef TOUCH_TERRAIN_SESSION_HPP
#define TOUCH_TERRAIN_SESSION_HPP

#include "distribution.hpp"
#include "stylus_path.hpp"
#include "terrain.hpp"
#include "touch.hpp"

#include <hfh/device/force_guard.hpp>
#include <hfh/terrain/bilinear_grid.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>

namespace demo {

struct Summary {
    std::uint64_t updates = 0;
    std::uint64_t in_contact = 0;
    std::uint64_t buried = 0;
    std::uint64_t refused = 0;   ///< positions with status bad_input
    double largest_force = 0;    ///< N, as felt
    Distribution patches;        ///< looked at, per update
    Distribution nanoseconds;    ///< per update, tracker and force together
    std::size_t state_bytes = 0; ///< what the tracker remembers from update to update
};

/// Takes the force that the terrain asks for, in N there, and whether the stylus is buried; gives what is felt of it.
using ForceSink = std::function<hfh::GuardedForce(const glm::dvec3& newtons, bool buried)>;

/// Moves the stylus along `path` over the terrain, one update a sample, and hands the force to `feel` and every touch to
/// `on_touch` before it asks for the next sample. `stiffness`: N per metre of terrain.
template <hfh::Real T>
Summary touch_terrain(const Terrain& terrain, const hfh::GridFrame& frame, double stiffness,
                      const StylusSource& path, const ForceSink& feel,
                      const std::function<void(const Touch&)>& on_touch);

} // namespace demo

#endif // TOUCH_TERRAIN_SESSION_HPP
