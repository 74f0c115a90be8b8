#ifndef VIEWER_OPTIONS_HPP
#define VIEWER_OPTIONS_HPP

#include "haptics.hpp"

#include <terrain_options.hpp>
#include <tip_options.hpp>

#include <glm/ext/vector_int2.hpp>

#include <filesystem>
#include <optional>

namespace viewer {

/// The command line, checked.
struct Options : demo::TerrainOptions {
    DeviceKind device = DeviceKind::touch;
    std::optional<double> stiffness;
    demo::Tip tip;
    double release_speed = 0; ///< m of the hand an update; 0: a proxy that a ridge lets go does not glide
    std::optional<std::filesystem::path> path;
    std::optional<std::filesystem::path> record;
    std::optional<std::filesystem::path> screenshot;
    std::optional<std::uint64_t> frames;
    glm::ivec2 size{1280, 720};
};

/// Nothing if the user asked for help, which has then been printed. Throws BadInput.
[[nodiscard]] std::optional<Options> read_options(int argc, const char* const* argv);

} // namespace viewer

#endif // VIEWER_OPTIONS_HPP
