#include "session_loop.hpp"

namespace demo {

template <>
Summary touch_terrain<float>(const Terrain& terrain, const hfh::GridFrame& frame, const ForceRule& force,
                             const StylusSource& path, const std::function<void(const Touch&)>& on_touch) {
    return std::visit(
        [&](const auto& heights) { return follow<float>(heights, frame, force, path, on_touch); },
        terrain.heights);
}

} // namespace demo
