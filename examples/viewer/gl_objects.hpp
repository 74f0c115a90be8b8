#ifndef VIEWER_GL_OBJECTS_HPP
#define VIEWER_GL_OBJECTS_HPP

#include <epoxy/gl.h>

#include <glm/ext/matrix_float4x4.hpp>
#include <glm/ext/vector_float2.hpp>
#include <glm/ext/vector_float3.hpp>
#include <glm/ext/vector_float4.hpp>
#include <glm/ext/vector_int2.hpp>

#include <string>
#include <utility>

// Names of OpenGL that are given back. All need a current context of OpenGL 3.3 core or later, which somebody else has made.

namespace viewer {

/// An object of OpenGL, owned. `Deleter`: takes the name.
template <auto Deleter>
class GlName {
public:
    GlName() = default;
    explicit GlName(GLuint name) noexcept : name_{name} {}
    GlName(GlName&& other) noexcept : name_{std::exchange(other.name_, 0)} {}
    GlName& operator=(GlName&& other) noexcept {
        std::swap(name_, other.name_);
        return *this;
    }
    ~GlName() {
        if (name_ != 0) Deleter(name_);
    }
    [[nodiscard]] GLuint get() const noexcept { return name_; }

private:
    GLuint name_ = 0;
};

namespace detail {
inline void delete_buffer(GLuint name) { glDeleteBuffers(1, &name); }
inline void delete_vertex_array(GLuint name) { glDeleteVertexArrays(1, &name); }
inline void delete_texture(GLuint name) { glDeleteTextures(1, &name); }
inline void delete_program(GLuint name) { glDeleteProgram(name); }
inline void delete_framebuffer(GLuint name) { glDeleteFramebuffers(1, &name); }
inline void delete_renderbuffer(GLuint name) { glDeleteRenderbuffers(1, &name); }
} // namespace detail

using GlBuffer = GlName<detail::delete_buffer>;
using GlVertexArray = GlName<detail::delete_vertex_array>;
using GlTexture = GlName<detail::delete_texture>;
using GlFramebuffer = GlName<detail::delete_framebuffer>;
using GlRenderbuffer = GlName<detail::delete_renderbuffer>;

[[nodiscard]] inline GlBuffer make_buffer() {
    GLuint name = 0;
    glGenBuffers(1, &name);
    return GlBuffer{name};
}
[[nodiscard]] inline GlVertexArray make_vertex_array() {
    GLuint name = 0;
    glGenVertexArrays(1, &name);
    return GlVertexArray{name};
}
[[nodiscard]] inline GlTexture make_texture() {
    GLuint name = 0;
    glGenTextures(1, &name);
    return GlTexture{name};
}

/// A program of a vertex and a fragment shader.
class GlProgram {
public:
    GlProgram() = default;
    /// Throws BadInput with what the driver says where it does not compile.
    GlProgram(const std::string& vertex, const std::string& fragment);

    void use() const { glUseProgram(name_.get()); }
    void set(const char* name, int value) const { glUniform1i(at(name), value); }
    void set(const char* name, float value) const { glUniform1f(at(name), value); }
    void set(const char* name, const glm::ivec2& v) const { glUniform2i(at(name), v.x, v.y); }
    void set(const char* name, const glm::vec2& v) const { glUniform2f(at(name), v.x, v.y); }
    void set(const char* name, const glm::vec3& v) const { glUniform3f(at(name), v.x, v.y, v.z); }
    void set(const char* name, const glm::vec4& v) const { glUniform4f(at(name), v.x, v.y, v.z, v.w); }
    void set(const char* name, const glm::mat4& m) const {
        glUniformMatrix4fv(at(name), 1, GL_FALSE, &m[0][0]);
    }

private:
    [[nodiscard]] GLint at(const char* name) const { return glGetUniformLocation(name_.get(), name); }
    GlName<detail::delete_program> name_;
};

/// Throws BadInput, in one sentence, where the current context cannot do what the viewer needs.
void require_opengl();

/// "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5 (Core Profile) Mesa 22.3.6"
[[nodiscard]] std::string renderer_name();
/// Whether the renderer draws without a graphics card.
[[nodiscard]] bool is_software_renderer();

} // namespace viewer

#endif // VIEWER_GL_OBJECTS_HPP
