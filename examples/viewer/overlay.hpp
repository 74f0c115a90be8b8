#ifndef VIEWER_OVERLAY_HPP
#define VIEWER_OVERLAY_HPP

#include "camera.hpp"
#include "force_history.hpp"
#include "gl_objects.hpp"
#include "palettes.hpp"

#include <string>

// Text, scale bar, chart and panel over the picture, by Dear ImGui.

struct ImGuiContext;

namespace viewer {

/// A context of Dear ImGui that draws through the context of OpenGL which is current.
class ImGuiLayer {
public:
    /// `pixels`: of the framebuffer in a pixel of text, 1 on an ordinary screen.
    explicit ImGuiLayer(float pixels);
    ~ImGuiLayer();
    ImGuiLayer(const ImGuiLayer&) = delete;
    ImGuiLayer& operator=(const ImGuiLayer&) = delete;

    /// Begins a frame of a framebuffer of `size`. Without a window, which would tell Dear ImGui itself.
    void begin_without_window(const glm::ivec2& size, float seconds);
    void begin();
    void draw();
    [[nodiscard]] float pixels() const noexcept { return pixels_; }
    /// Between two frames: the window has come to a screen of another scale.
    void set_pixels(float pixels);

private:
    void set_sizes();

    ImGuiContext* context_;
    float pixels_;
};

/// Of the panel, in pixels of text.
inline constexpr float panel_width = 330;

/// What is written over the picture.
struct OverlayText {
    HandState hand;
    double slope = 0;             ///< radians, of the ground under the proxy
    double frames_per_second = 0; ///< 0: not told
    bool real_time = true;
    std::string renderer;
    std::string message; ///< what went wrong or was done last
    bool feet = false;
    bool shows_hint = true;
    bool in_a_hand = false; ///< a real device moves the stylus, not the pointer
    bool shows_keys = false;
    bool shows_panel = false;       ///< on the right, and what is drawn here keeps clear of it
    double lowest = 0, highest = 0; ///< m, of the tints
    std::size_t palette = 0;
    double contour_interval = 0; ///< m; 0: none
    std::uint64_t triangles = 0;
};

/// Draws it in the frame of Dear ImGui that has begun.
void draw_overlay(const OverlayText& text, const ForceHistory& force, const Camera& camera,
                  const glm::ivec2& size, float pixels);

} // namespace viewer

#endif // VIEWER_OVERLAY_HPP
