#ifndef TOUCH_TERRAIN_REPORT_HPP
#define TOUCH_TERRAIN_REPORT_HPP

#include "device_in_hand.hpp"
#include "ground.hpp"
#include "session.hpp"
#include "terrain.hpp"

#include <optional>
#include <string>

// What the program says of a terrain and of a session, as text.

namespace demo {

/// "300 x 300 samples every 73.596 x 92.491 m"
[[nodiscard]] std::string describe(const Terrain& terrain, const Ground& ground);

/// What the stylus is held by: nothing, or a simulated device.
struct Setup {
    double stiffness = 0; ///< N/m in the hand; without a device, of terrain
    std::string device;   ///< empty: none
};

/// The line below a picture's title.
[[nodiscard]] std::string caption(const Summary& summary, const std::string& terrain, const Setup& setup);

/// The lines about a terrain: its name and size, and what was assumed about it.
[[nodiscard]] std::string report(const Terrain& terrain, const Ground& ground);

/// The lines about a session. `scalar`: what was computed in.
[[nodiscard]] std::string report(const Summary& summary, const std::string& scalar, const Setup& setup,
                                 const std::optional<DeviceInHand>& device);

} // namespace demo

#endif // TOUCH_TERRAIN_REPORT_HPP
