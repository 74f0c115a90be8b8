#include "offscreen.hpp"

#include <bad_input.hpp>

#include <epoxy/egl.h>

#include <array>

namespace viewer {

struct OffscreenContext::Egl {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;
    ~Egl() {
        if (display == EGL_NO_DISPLAY) return;
        eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
        eglTerminate(display);
    }
};

OffscreenContext::OffscreenContext() : egl_{std::make_unique<Egl>()} {
    const auto refuse = [](const char* what) {
        return demo::BadInput{std::string{"Nothing can be drawn without a window here: EGL "} + what + "."};
    };
    if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
        throw refuse("has no surfaceless platform");
    egl_->display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (egl_->display == EGL_NO_DISPLAY || eglInitialize(egl_->display, nullptr, nullptr) != EGL_TRUE)
        throw refuse("does not start");
    if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) throw refuse("has no OpenGL");
    constexpr std::array<EGLint, 7> wanted{EGL_CONTEXT_MAJOR_VERSION,
                                           3,
                                           EGL_CONTEXT_MINOR_VERSION,
                                           3,
                                           EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                           EGL_NONE};
    egl_->context = eglCreateContext(egl_->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted.data());
    if (egl_->context == EGL_NO_CONTEXT ||
        eglMakeCurrent(egl_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl_->context) != EGL_TRUE)
        throw refuse("has no context of OpenGL 3.3");
    require_opengl();
}

OffscreenContext::~OffscreenContext() = default;

OffscreenFrame::OffscreenFrame(const glm::ivec2& size, int samples) : size_{size} {
    std::array<GLuint, 2> buffers{};
    GLuint frame = 0;
    glGenFramebuffers(1, &frame);
    glGenRenderbuffers(2, buffers.data());
    frame_ = GlFramebuffer{frame};
    colour_ = GlRenderbuffer{buffers[0]};
    depth_ = GlRenderbuffer{buffers[1]};
    bind();
    glBindRenderbuffer(GL_RENDERBUFFER, colour_.get());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_RGBA8, size.x, size.y);
    glBindRenderbuffer(GL_RENDERBUFFER, depth_.get());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT24, size.x, size.y);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_.get());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_.get());
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        throw demo::BadInput{"The graphics driver cannot draw a picture of " + std::to_string(size.x) +
                             " x " + std::to_string(size.y) + " pixels."};
    }
}

void OffscreenFrame::bind() const { glBindFramebuffer(GL_FRAMEBUFFER, frame_.get()); }

void OffscreenFrame::resolve_into(const OffscreenFrame& other) const {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, frame_.get());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, other.frame_.get());
    glBlitFramebuffer(0, 0, size_.x, size_.y, 0, 0, size_.x, size_.y, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    other.bind();
}

std::vector<std::uint8_t> read_colours(const glm::ivec2& size) {
    std::vector<std::uint8_t> colours(3 * static_cast<std::size_t>(size.x) *
                                      static_cast<std::size_t>(size.y));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, size.x, size.y, GL_RGB, GL_UNSIGNED_BYTE, colours.data());
    return colours;
}

std::vector<float> read_depths(const glm::ivec2& size) {
    std::vector<float> depths(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, size.x, size.y, GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
    return depths;
}

} // namespace viewer
