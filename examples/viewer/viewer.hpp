#ifndef VIEWER_VIEWER_HPP
#define VIEWER_VIEWER_HPP

#include "camera.hpp"
#include "force_history.hpp"
#include "level_loader.hpp"
#include "marker_drawer.hpp"
#include "overlay.hpp"
#include "terrain_drawer.hpp"
#include "touched_terrain.hpp"

#include <record.hpp>

#include <filesystem>
#include <optional>

namespace viewer {

/// What a person did since the last frame: of a window, or of a script.
struct FrameInput {
    glm::dvec2 pointer{0.0}; ///< pixels of the framebuffer from its top left
    bool has_pointer = false;
    bool pressing = false;
    glm::dvec2 turn{0.0}; ///< pixels
    glm::dvec2 pan{0.0};  ///< pixels
    double zoom = 0;      ///< doublings
    bool toggles_keys = false, toggles_panel = false;
    bool undoes = false, goes_home = false;
    std::optional<BrushKind> brush;
};

/// What the panel changes.
struct Settings {
    Feel feel;
    LevelChoice level;
    Brush brush;
    Look look;
    double firmness = 1; ///< N
    double exaggeration = 1;
    bool feet = false;
    bool shows_panel = false, shows_keys = false, shows_hint = true;
    std::string save_as; ///< the name in the panel
};

/// What the panel asks for.
struct PanelWishes {
    bool undo = false, save = false, home = false;
};

/// Draws the panel in the frame of Dear ImGui that has begun.
PanelWishes draw_panel(Settings& settings, const HandState& hand, double coarsest_level,
                       const glm::ivec2& size, float pixels);

struct FrameReport {
    DrawnTerrain terrain;
    std::uint64_t samples_read = 0; ///< total
    bool has_terrain = false;       ///< something of it is loaded and was drawn
};

/// The half of the program that is about the eye: from what the hand tells and what a person does to a picture. Needs a current
/// context of OpenGL and makes none.
class Viewer {
public:
    /// `touched` must outlive it. n: vertices along a side of a window of the terrain. `pixels`: of the framebuffer in a pixel of
    /// text.
    Viewer(TouchedTerrain& touched, int n, float pixels);

    /// One frame into the framebuffer that is bound. `seconds` since the last one. `waits`: until all that is to be seen is
    /// loaded; for pictures and tests.
    FrameReport frame(const FrameInput& input, const glm::ivec2& size, double seconds, bool waits);

    void record_to(demo::Record* record) noexcept { record_ = record; }
    void say(std::string message) {
        message_ = std::move(message);
        message_left_ = 4;
    }
    void set_real_time(bool real_time) noexcept { real_time_ = real_time; }

    [[nodiscard]] Settings& settings() noexcept { return settings_; }
    [[nodiscard]] Camera& camera() noexcept { return camera_; }
    [[nodiscard]] const HandState& hand() const noexcept { return hand_; }
    [[nodiscard]] const TerrainView& view() const noexcept { return view_; }
    [[nodiscard]] const std::shared_ptr<const LoadedLevels>& levels() const noexcept { return levels_; }
    [[nodiscard]] const TerrainDrawer& terrain_drawer() const noexcept { return terrain_drawer_; }
    [[nodiscard]] ImGuiLayer& layer() noexcept { return layer_; }
    /// Draws without the text over the picture, or without stylus, proxy and force.
    void hide_text() noexcept { shows_text_ = false; }
    void hide_markers() noexcept { shows_markers_ = false; }

private:
    void take_hand();
    void tell_hand(const FrameInput& input, const glm::ivec2& size);
    void follow();
    void ask_for_levels();
    void look_at_middle(double share);
    [[nodiscard]] glm::vec2 heights_within(double samples) const;
    void adapt_tints(const glm::ivec2& size, double share);
    void draw_markers(const glm::ivec2& size);
    void draw_text(const glm::ivec2& size, double seconds);
    void save();

    TouchedTerrain* touched_;
    const DisplayedTerrain* displayed_;
    Haptics* haptics_;
    LevelLoader loader_;
    TerrainDrawer terrain_drawer_;
    MarkerDrawer marker_drawer_;
    ImGuiLayer layer_;
    ForceHistory force_;
    demo::Record* record_ = nullptr;

    Settings settings_;
    Camera camera_;
    HandState hand_;
    HandInput told_;
    TerrainView view_;
    glm::vec2 tints_{0.0f}; ///< m above the datum
    std::shared_ptr<const LoadedLevels> levels_;
    glm::dvec2 place_{0.0}; ///< samples: the middle of the windows
    std::optional<LevelRequest> asked_;
    std::uint64_t edits_asked_ = 0;
    FrameReport report_;
    double frame_seconds_ = 0;
    std::string message_, renderer_;
    double message_left_ = 0; ///< s
    bool real_time_ = true, shows_text_ = true, shows_markers_ = true, placed_ = false;
};

} // namespace viewer

#endif // VIEWER_VIEWER_HPP
