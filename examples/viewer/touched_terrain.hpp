#ifndef VIEWER_TOUCHED_TERRAIN_HPP
#define VIEWER_TOUCHED_TERRAIN_HPP

#include "felt_ground.hpp"
#include "haptics.hpp"
#include "level_window.hpp"

#include <memory>

namespace viewer {

/// A terrain, its hand and what a display needs to read of it. The parts refer to each other: it stays where it is.
struct TouchedTerrain {
    /// The terrain was read for editing. Size and cell of the settings are filled in. Throws BadInput where it makes no surface.
    TouchedTerrain(demo::Terrain read, const hfh::GridFrame& its_frame, HapticsSettings settings);
    TouchedTerrain(const TouchedTerrain&) = delete;
    TouchedTerrain& operator=(const TouchedTerrain&) = delete;

    demo::Terrain terrain;
    hfh::GridFrame frame;
    DisplayedTerrain displayed;
    std::unique_ptr<FeltGround> ground;
    Haptics haptics;
};

/// What the display reads of a terrain, which must outlive it.
[[nodiscard]] DisplayedTerrain displayed_terrain(const demo::Terrain& terrain, const hfh::GridFrame& frame);

} // namespace viewer

#endif // VIEWER_TOUCHED_TERRAIN_HPP
