#ifndef VIEWER_OFFSCREEN_HPP
#define VIEWER_OFFSCREEN_HPP

#include "gl_objects.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace viewer {

/// A context of OpenGL without a window or a display, through EGL; current in the thread that made it.
class OffscreenContext {
public:
    /// Throws BadInput, in one sentence, where there is none.
    OffscreenContext();
    ~OffscreenContext();
    OffscreenContext(const OffscreenContext&) = delete;
    OffscreenContext& operator=(const OffscreenContext&) = delete;

private:
    struct Egl;
    std::unique_ptr<Egl> egl_;
};

/// A framebuffer to draw into without a window.
class OffscreenFrame {
public:
    /// `samples`: in a pixel, for smooth edges; 0 for a depth in each pixel that can be read.
    explicit OffscreenFrame(const glm::ivec2& size, int samples = 0);
    void bind() const;
    /// Brings what was drawn into `other`, which is of the same size, and binds it.
    void resolve_into(const OffscreenFrame& other) const;
    [[nodiscard]] const glm::ivec2& size() const noexcept { return size_; }

private:
    glm::ivec2 size_;
    GlFramebuffer frame_;
    GlRenderbuffer colour_, depth_;
};

/// RGB bytes of the framebuffer that is bound, south row first.
[[nodiscard]] std::vector<std::uint8_t> read_colours(const glm::ivec2& size);
/// Its depths, 0 to 1, south row first.
[[nodiscard]] std::vector<float> read_depths(const glm::ivec2& size);

} // namespace viewer

#endif // VIEWER_OFFSCREEN_HPP
