#ifndef TOUCH_TERRAIN_OPTIONS_HPP
#define TOUCH_TERRAIN_OPTIONS_HPP

#include "terrain_options.hpp"
#include "tip_options.hpp"

#include <filesystem>
#include <optional>

namespace demo {

enum class DeviceChoice { none, touch, premium };

/// The command line, checked.
struct Options : TerrainOptions {
    std::optional<std::filesystem::path> path; ///< none: the built-in stroke
    DeviceChoice device = DeviceChoice::touch;
    std::optional<double> stiffness;
    Tip tip;
    double release_speed = 0; ///< m of the hand an update; 0: a proxy that a ridge lets go does not glide
    std::optional<std::filesystem::path> record;
    std::optional<std::filesystem::path> picture;
    hfh::Index bridge = 0; ///< cells: holes up to this width are spanned
    bool in_float = false;
};

/// Nothing if the user asked for help, which has then been printed. Throws BadInput.
[[nodiscard]] std::optional<Options> read_options(int argc, const char* const* argv);

} // namespace demo

#endif // TOUCH_TERRAIN_OPTIONS_HPP
