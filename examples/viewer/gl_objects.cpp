#include "gl_objects.hpp"

#include <bad_input.hpp>

#include <array>

namespace viewer {
namespace {

using Shader = GlName<[](GLuint name) { glDeleteShader(name); }>;

Shader compiled(GLenum kind, const std::string& text) {
    Shader shader{glCreateShader(kind)};
    const std::string whole = "#version 330 core\n" + text;
    const char* const source = whole.c_str();
    glShaderSource(shader.get(), 1, &source, nullptr);
    glCompileShader(shader.get());
    GLint ok = GL_FALSE;
    glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &ok);
    if (ok != GL_TRUE) {
        std::array<char, 400> log{};
        glGetShaderInfoLog(shader.get(), log.size(), nullptr, log.data());
        throw demo::BadInput{"The graphics driver cannot compile the viewer's shaders: " +
                             std::string{log.data()}};
    }
    return shader;
}

std::string text_of(GLenum what) {
    const auto* const text = reinterpret_cast<const char*>(glGetString(what));
    return text != nullptr ? text : "unknown";
}

} // namespace

GlProgram::GlProgram(const std::string& vertex, const std::string& fragment) : name_{glCreateProgram()} {
    const Shader first = compiled(GL_VERTEX_SHADER, vertex), second = compiled(GL_FRAGMENT_SHADER, fragment);
    glAttachShader(name_.get(), first.get());
    glAttachShader(name_.get(), second.get());
    glLinkProgram(name_.get());
    GLint ok = GL_FALSE;
    glGetProgramiv(name_.get(), GL_LINK_STATUS, &ok);
    if (ok != GL_TRUE) throw demo::BadInput{"The graphics driver cannot link the viewer's shaders."};
}

void require_opengl() {
    const int version = epoxy_gl_version();
    if (!epoxy_is_desktop_gl() || version < 33) {
        throw demo::BadInput{"OpenGL 3.3 is needed, but " + renderer_name() + " is here."};
    }
}

std::string renderer_name() { return text_of(GL_RENDERER) + ", OpenGL " + text_of(GL_VERSION); }

bool is_software_renderer() {
    const std::string name = text_of(GL_RENDERER);
    return name.find("llvmpipe") != std::string::npos || name.find("softpipe") != std::string::npos ||
           name.find("SWR") != std::string::npos;
}

} // namespace viewer
