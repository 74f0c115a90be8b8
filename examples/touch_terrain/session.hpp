#ifndef TOUCH_TERRAIN_SESSION_HPP
#define TOUCH_TERRAIN_SESSION_HPP

#include "distribution.hpp"
#include "stylus_path.hpp"
#include "terrain.hpp"
#include "touch.hpp"

#include <hfh/bilinear_grid.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>

namespace demo {

struct Summary {
    std::uint64_t updates = 0;
    std::uint64_t in_contact = 0;
    double largest_force = 0;    ///< N
    Distribution patches;        ///< looked at, per update
    Distribution nanoseconds;    ///< per update, tracker and force together
    std::size_t state_bytes = 0; ///< what the tracker remembers from update to update
};

struct ForceRule {
    double stiffness = 0;                                  ///< N per metre of terrain
    double most = std::numeric_limits<double>::infinity(); ///< N
};

/// Moves the stylus along `path` over the terrain, one update a sample, and hands every touch to `on_touch` before it
/// asks for the next sample.
template <hfh::Real T>
Summary touch_terrain(const Terrain& terrain, const hfh::GridFrame& frame, const ForceRule& force,
                      const StylusSource& path, const std::function<void(const Touch&)>& on_touch);

} // namespace demo

#endif // TOUCH_TERRAIN_SESSION_HPP
