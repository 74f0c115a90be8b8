#ifndef VIEWER_TERRAIN_DRAWER_HPP
#define VIEWER_TERRAIN_DRAWER_HPP

#include "camera.hpp"
#include "gl_objects.hpp"
#include "level_loader.hpp"
#include "palettes.hpp"
#include "window_indices.hpp"

#include <cstdint>
#include <vector>

namespace viewer {

/// How the ground looks.
struct Look {
    std::size_t palette = 0;
    double light_azimuth = -1.3;  ///< radians, clockwise from where the eye looks: from the left
    double light_elevation = 0.8; ///< radians
    double relief = 1;            ///< of the shading, over what suits the slopes that are seen
    bool contours = true;
    bool cells = true; ///< grid lines, where cells are large enough
};

/// What of a terrain is drawn, and how.
struct TerrainView {
    Camera camera;
    double scale = 1;              ///< m of terrain per m of hand
    glm::dvec3 offset{0.0};        ///< m of terrain at the middle of the hand's workspace
    double level = 0;              ///< that of the hand: it is drawn around the middle of the windows
    double contour_interval = 100; ///< m
    glm::vec2 tints{0.0f}; ///< m above the datum: the lowest and the highest height that tints tell apart
    Look look;
};

struct DrawnTerrain {
    std::uint64_t triangles = 0;
    std::uint64_t uploaded_vertices = 0;
    double level = 0; ///< that was drawn in the middle: the hand's, or the finest that is loaded
};

/// Draws a terrain as nested windows of vertices. Takes the context that is current and makes none.
///
/// A vertex lies at (1 − α)·(height at its level) + α·(height at the next coarser level). In the middle of the innermost window
/// α is the fraction of the hand's level; towards the border of every window it rises to 1, so that the windows join. These are
/// the patches that the hand feels, each drawn as two triangles. Where the terrain is not a whole number of the hand's cells wide,
/// the rest is neither felt nor drawn.
class TerrainDrawer {
public:
    TerrainDrawer(const DisplayedTerrain& terrain, int n);

    /// Brings the windows of `levels` that have changed onto the card, and draws into the framebuffer that is bound.
    DrawnTerrain draw(const LoadedLevels& levels, const TerrainView& view, const glm::ivec2& size);

    /// α of a vertex of a window of `level`, `from_middle` vertices of that level from the place of `levels`.
    [[nodiscard]] double blend(const LoadedLevels& levels, int level, const glm::dvec2& from_middle,
                               double hand_level) const noexcept;
    /// Bytes that windows and indices take on the card.
    [[nodiscard]] std::size_t card_bytes() const noexcept;

private:
    struct OnCard {
        GlVertexArray array;
        GlBuffer vertices;
        std::uint64_t version = 0;
        bool used = false;
    };
    void upload(const LoadedLevel& level, OnCard& card, DrawnTerrain& drawn);
    void make_palette(std::size_t palette);
    void draw_window(const LoadedLevel& level, const std::vector<WindowIndices::Block>& blocks,
                     const TerrainView& view, const glm::ivec2& size, DrawnTerrain& drawn);
    void set_uniforms(const LoadedLevels& levels, const TerrainView& view, const glm::ivec2& size);

    const DisplayedTerrain* terrain_;
    int n_;
    GlProgram program_;
    GlTexture palette_;
    std::size_t palette_made_ = palettes.size();
    WindowIndices indices_;
    std::vector<OnCard> cards_; ///< by level
};

} // namespace viewer

#endif // VIEWER_TERRAIN_DRAWER_HPP
