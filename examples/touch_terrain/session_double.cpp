#include "session_loop.hpp"

namespace demo {

template <>
Summary touch_terrain<double>(const Terrain& terrain, const hfh::GridFrame& frame, const Feeling& feeling,
                              const StepSource& path, const ForceSink& feel,
                              const std::function<void(const Touch&)>& on_touch) {
    return std::visit(
        [&](const auto& heights) { return follow<double>(heights, frame, feeling, path, feel, on_touch); },
        terrain.heights);
}

} // namespace demo
