#include "window.hpp"

#include <bad_input.hpp>

// Before GLFW's header, whose OpenGL is this one.
#include <epoxy/gl.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <imgui.h>

#include <backends/imgui_impl_glfw.h>

namespace viewer {
namespace {

std::string last_error; ///< of GLFW, for the sentence that is printed

bool is_down(GLFWwindow* window, int key) { return glfwGetKey(window, key) == GLFW_PRESS; }
bool is_button_down(GLFWwindow* window, int button) {
    return glfwGetMouseButton(window, button) == GLFW_PRESS;
}

/// Dear ImGui counts in pixels of the framebuffer, as all that is drawn here does. Its backend counts in those of the window,
/// which are fewer on some high-DPI screens. `scale`: framebuffer by window.
void count_in_framebuffer(const glm::ivec2& framebuffer, const glm::vec2& scale) {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = {static_cast<float>(framebuffer.x), static_cast<float>(framebuffer.y)};
    io.DisplayFramebufferScale = {1, 1};
    if (scale == glm::vec2{1.0f} || !ImGui::IsMousePosValid()) return;
#if IMGUI_VERSION_NUM >= 18700
    const ImVec2 at = ImGui::GetMousePos();
    io.AddMousePosEvent(at.x * scale.x, at.y * scale.y);
#else
    io.MousePos = {io.MousePos.x * scale.x, io.MousePos.y * scale.y};
#endif
}

} // namespace

struct Window::State {
    GLFWwindow* window = nullptr;
    FrameInput input; ///< gathered by callbacks
    glm::dvec2 pointer{0.0};
    double last_time = 0;
    bool has_layer = false;
    bool pressing = false; ///< begun over the ground, not over the panel
    bool dragging = false;

    static State& of(GLFWwindow* window) { return *static_cast<State*>(glfwGetWindowUserPointer(window)); }
    void on_key(int key, int mods);
};

void Window::State::on_key(int key, int mods) {
    if (has_layer && ImGui::GetIO().WantTextInput) return;
    switch (key) {
    case GLFW_KEY_H: input.toggles_keys = !input.toggles_keys; break;
    case GLFW_KEY_TAB: input.toggles_panel = !input.toggles_panel; break;
    case GLFW_KEY_ESCAPE: glfwSetWindowShouldClose(window, GLFW_TRUE); break;
    case GLFW_KEY_U: input.undoes = true; break;
    case GLFW_KEY_Z: input.undoes = input.undoes || (mods & GLFW_MOD_CONTROL) != 0; break;
    case GLFW_KEY_HOME: input.goes_home = true; break;
    case GLFW_KEY_1: input.brush = BrushKind::none; break;
    case GLFW_KEY_2: input.brush = BrushKind::dig; break;
    case GLFW_KEY_3: input.brush = BrushKind::heap; break;
    default: break;
    }
}

Window::Window(const std::string& title, const glm::ivec2& size) : state_{std::make_unique<State>()} {
    glfwSetErrorCallback([](int, const char* what) { last_error = what; });
    const auto refuse = [] {
        for (char& c : last_error) c = c == '\n' ? ' ' : c;
        return demo::BadInput{
            "No window can be opened here: " + (last_error.empty() ? "no reason is told" : last_error) +
            " (--screenshot draws without one)."};
    };
    if (glfwInit() != GLFW_TRUE) throw refuse();
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 24);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    state_->window = glfwCreateWindow(size.x, size.y, title.c_str(), nullptr, nullptr);
    if (state_->window == nullptr) {
        glfwTerminate();
        throw refuse();
    }
    GLFWwindow* const window = state_->window;
    glfwSetWindowUserPointer(window, state_.get());
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    glfwSetScrollCallback(window, [](GLFWwindow* w, double, double up) {
        if (!State::of(w).has_layer || !ImGui::GetIO().WantCaptureMouse) State::of(w).input.zoom += 0.35 * up;
    });
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int mods) {
        if (action == GLFW_PRESS) State::of(w).on_key(key, mods);
    });
    glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int) {
        State& state = State::of(w);
        const bool over_panel = state.has_layer && ImGui::GetIO().WantCaptureMouse;
        if (button == GLFW_MOUSE_BUTTON_LEFT)
            state.pressing = action == GLFW_PRESS && !over_panel;
        else
            state.dragging = action == GLFW_PRESS && !over_panel;
    });
    glfwSetWindowFocusCallback(window, [](GLFWwindow* w, int focused) {
        if (focused == GLFW_FALSE) State::of(w).pressing = State::of(w).dragging = false;
    });
    state_->last_time = glfwGetTime();
    try {
        require_opengl();
    } catch (...) {
        glfwDestroyWindow(window);
        glfwTerminate();
        throw;
    }
}

Window::~Window() {
    glfwDestroyWindow(state_->window);
    glfwTerminate();
}

glm::ivec2 Window::size() const {
    glm::ivec2 size{0};
    if (glfwGetWindowAttrib(state_->window, GLFW_ICONIFIED) == GLFW_TRUE) return size;
    glfwGetFramebufferSize(state_->window, &size.x, &size.y);
    return size;
}

float Window::pixels() const {
    float x = 1, y = 1;
    glfwGetWindowContentScale(state_->window, &x, &y);
    return std::clamp(std::max(x, y), 1.0f, 4.0f);
}

bool Window::is_open() const { return glfwWindowShouldClose(state_->window) == GLFW_FALSE; }
void Window::close() { glfwSetWindowShouldClose(state_->window, GLFW_TRUE); }

Window::LayerInput::LayerInput(Window& window) : window_{&window} {
    ImGui_ImplGlfw_InitForOpenGL(window.state_->window, true);
    window.state_->has_layer = true;
}

Window::LayerInput::~LayerInput() {
    window_->state_->has_layer = false;
    ImGui_ImplGlfw_Shutdown();
}

FrameInput Window::begin_frame(Viewer& viewer) {
    glfwPollEvents();
    GLFWwindow* const window = state_->window;
    FrameInput input = std::exchange(state_->input, {});
    const double now = glfwGetTime(), seconds = std::min(0.1, now - std::exchange(state_->last_time, now));

    glm::dvec2 at{0.0};
    glm::ivec2 window_size{1};
    glfwGetCursorPos(window, &at.x, &at.y);
    glfwGetWindowSize(window, &window_size.x, &window_size.y);
    const glm::ivec2 framebuffer = glm::max(size(), 1);
    const glm::dvec2 scale = glm::dvec2{framebuffer} / glm::dvec2{glm::max(window_size, 1)};
    at *= scale;
    ImGui_ImplGlfw_NewFrame();
    count_in_framebuffer(framebuffer, glm::vec2{scale});
    viewer.layer().begin();
    const glm::dvec2 moved = at - std::exchange(state_->pointer, at);
    const bool focused = glfwGetWindowAttrib(window, GLFW_FOCUSED) == GLFW_TRUE;
    const bool shift = is_down(window, GLFW_KEY_LEFT_SHIFT) || is_down(window, GLFW_KEY_RIGHT_SHIFT);
    const bool middle = is_button_down(window, GLFW_MOUSE_BUTTON_MIDDLE);
    if (state_->dragging && (shift || middle)) input.pan += moved;
    if (state_->dragging && !shift && !middle) input.turn += moved / static_cast<double>(pixels());
    input.pointer = at;
    input.has_pointer = focused && !state_->dragging &&
                        glfwGetWindowAttrib(window, GLFW_HOVERED) == GLFW_TRUE &&
                        !ImGui::GetIO().WantCaptureMouse;
    const bool types = ImGui::GetIO().WantTextInput;
    input.pressing = focused && (state_->pressing || (!types && is_down(window, GLFW_KEY_SPACE)));
    if (!types && focused) {
        const auto key = [&](int plus, int minus) {
            return seconds *
                   (static_cast<double>(is_down(window, plus)) - static_cast<double>(is_down(window, minus)));
        };
        const double far = 600 * static_cast<double>(pixels());
        input.pan += far * glm::dvec2{key(GLFW_KEY_LEFT, GLFW_KEY_RIGHT), key(GLFW_KEY_UP, GLFW_KEY_DOWN)};
        input.turn += 250.0 * glm::dvec2{key(GLFW_KEY_E, GLFW_KEY_Q), key(GLFW_KEY_R, GLFW_KEY_F)};
        input.zoom +=
            1.5 * (key(GLFW_KEY_EQUAL, GLFW_KEY_MINUS) + key(GLFW_KEY_KP_ADD, GLFW_KEY_KP_SUBTRACT));
    }
    return input;
}

void Window::show() { glfwSwapBuffers(state_->window); }
void Window::wait() { glfwWaitEventsTimeout(0.1); }

} // namespace viewer
