#ifndef VIEWER_WINDOW_HPP
#define VIEWER_WINDOW_HPP

#include "viewer.hpp"

#include <memory>
#include <string>

namespace viewer {

/// A window with a context of OpenGL 3.3, and what a person does in it.
class Window {
public:
    /// Throws BadInput, in one sentence, where there is no display or no such context.
    Window(const std::string& title, const glm::ivec2& size);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    /// Of the framebuffer, which is larger than the window on some high-DPI screens; 0 × 0 while minimised.
    [[nodiscard]] glm::ivec2 size() const;
    /// Pixels of the framebuffer in a pixel of an ordinary screen.
    [[nodiscard]] float pixels() const;
    [[nodiscard]] bool is_open() const;
    void close();

    /// While it is there, the layer of Dear ImGui sees mouse and keys as well, and first. Has to end before the layer does.
    class LayerInput {
    public:
        explicit LayerInput(Window& window);
        ~LayerInput();
        LayerInput(const LayerInput&) = delete;
        LayerInput& operator=(const LayerInput&) = delete;

    private:
        Window* window_;
    };
    /// What a person did since the last call. Begins a frame of Dear ImGui.
    [[nodiscard]] FrameInput begin_frame(Viewer& viewer);
    /// Shows what was drawn, at the screen's rate.
    void show();
    /// While there is nothing to draw into: until something happens, or for a tenth of a second.
    void wait();

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace viewer

#endif // VIEWER_WINDOW_HPP
