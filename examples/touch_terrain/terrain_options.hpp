#ifndef TOUCH_TERRAIN_TERRAIN_OPTIONS_HPP
#define TOUCH_TERRAIN_TERRAIN_OPTIONS_HPP

#include "terrain.hpp"

#include <filesystem>
#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace demo {

/// The terrain that a command line asks for.
struct TerrainOptions {
    std::optional<std::filesystem::path> terrain; ///< none: the bundled one
    ReadOptions read;
    double height_scale = 1.0;
};

/// The part of a command line that names a terrain and says what its file leaves open: TERRAIN, --spacing, --unit, --channel,
/// --encoding and --height-scale. The command line refers to it.
class TerrainCommandLine {
public:
    explicit TerrainCommandLine(CLI::App& app);
    TerrainCommandLine(const TerrainCommandLine&) = delete;
    TerrainCommandLine& operator=(const TerrainCommandLine&) = delete;

    /// Once the command line has been parsed. Throws BadInput.
    [[nodiscard]] TerrainOptions options() const;

private:
    const CLI::App* app_;
    std::string terrain_, spacing_, unit_, channel_, encoding_, height_scale_;
};

/// The file of the terrain that `options` name, or of the bundled one.
[[nodiscard]] std::filesystem::path terrain_file(const TerrainOptions& options);

/// Reads that file; about the bundled one nothing is open. Throws BadInput.
[[nodiscard]] Terrain open_terrain(const TerrainOptions& options);

/// How the samples of a terrain become metres.
[[nodiscard]] hfh::GridFrame frame_of(const Terrain& terrain, const TerrainOptions& options);

} // namespace demo

#endif // TOUCH_TERRAIN_TERRAIN_OPTIONS_HPP
