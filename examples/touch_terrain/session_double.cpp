#include "session_loop.hpp"

namespace demo {

template <>
Summary touch_terrain<double>(const Terrain& terrain, const hfh::GridFrame& frame, const ForceRule& force,
                              const StylusSource& path, const std::function<void(const Touch&)>& on_touch) {
    return std::visit(
        [&](const auto& heights) { return follow<double>(heights, frame, force, path, on_touch); },
        terrain.heights);
}

} // namespace demo
