#include "x_client.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>

namespace viewer_tests {

struct XClient::State {
    Display* display = nullptr;
    Window root = 0, window = 0;
    glm::ivec2 pointer{0};

    [[nodiscard]] Atom atom(const char* name) const { return XInternAtom(display, name, False); }
    [[nodiscard]] Window find() const {
        Window root_of = 0, parent = 0, *children = nullptr;
        unsigned count = 0;
        Window found = 0;
        if (XQueryTree(display, root, &root_of, &parent, &children, &count) == 0) return 0;
        for (unsigned k = 0; k < count; ++k) {
            char* name = nullptr;
            XWindowAttributes attributes{};
            if (XFetchName(display, children[k], &name) == 0 || name == nullptr) continue;
            if (std::string{name}.ends_with("hfh viewer") &&
                XGetWindowAttributes(display, children[k], &attributes) != 0 &&
                attributes.map_state == IsViewable)
                found = children[k];
            XFree(name);
        }
        if (children != nullptr) XFree(children);
        return found;
    }
    void send_button(int type, unsigned button, unsigned held) const {
        XEvent event{};
        event.xbutton = {.type = type,
                         .serial = 0,
                         .send_event = True,
                         .display = display,
                         .window = window,
                         .root = root,
                         .subwindow = 0,
                         .time = CurrentTime,
                         .x = pointer.x,
                         .y = pointer.y,
                         .x_root = pointer.x,
                         .y_root = pointer.y,
                         .state = held,
                         .button = button,
                         .same_screen = True};
        XSendEvent(display, window, False, ButtonPressMask | ButtonReleaseMask, &event);
        XSync(display, False);
    }
    /// What a window manager tells about a window that it has minimised, or not.
    void set_window_state(long state) const {
        const Atom name = atom("WM_STATE");
        const std::array<long, 2> value{state, 0};
        XChangeProperty(display, window, name, name, 32, PropModeReplace,
                        reinterpret_cast<const unsigned char*>(value.data()), 2);
    }
};

XClient::XClient(const std::string& display) : state_{std::make_unique<State>()} {
    state_->display = XOpenDisplay(display.c_str());
    if (state_->display == nullptr) return;
    state_->root = DefaultRootWindow(state_->display);
    // A window may be gone before it hears of something.
    XSetErrorHandler([](Display*, XErrorEvent*) { return 0; });
}

XClient::~XClient() {
    if (state_->display != nullptr) XCloseDisplay(state_->display);
}

bool XClient::is_connected() const noexcept { return state_->display != nullptr; }

void XClient::set_dots_per_inch(int dots) {
    const std::string text = "Xft.dpi:\t" + std::to_string(dots) + "\n";
    XChangeProperty(state_->display, state_->root, XA_RESOURCE_MANAGER, XA_STRING, 8, PropModeReplace,
                    reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
    XSync(state_->display, False);
}

bool XClient::find_window() {
    for (int k = 0; k < 200; ++k) {
        state_->window = state_->find();
        if (state_->window != 0) {
            const auto pixels = picture();
            if (!pixels.empty() && pixels[pixels.size() / 2] != std::array<std::uint8_t, 3>{}) return true;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds{50});
    }
    return false;
}

void XClient::move_pointer(const glm::ivec2& to) {
    state_->pointer = to;
    XWarpPointer(state_->display, 0, state_->window, 0, 0, 0, 0, to.x, to.y);
    XSync(state_->display, False);
}

void XClient::press_button(unsigned button) { state_->send_button(ButtonPress, button, 0); }
void XClient::release_button(unsigned button) {
    state_->send_button(ButtonRelease, button, unsigned{Button1Mask} << (button - 1));
}

void XClient::unfocus() {
    XSetInputFocus(state_->display, PointerRoot, RevertToPointerRoot, CurrentTime);
    XSetInputFocus(state_->display, state_->root, RevertToPointerRoot, CurrentTime);
    XSync(state_->display, False);
}

void XClient::focus() {
    XSetInputFocus(state_->display, state_->window, RevertToParent, CurrentTime);
    XSync(state_->display, False);
}

void XClient::resize(const glm::ivec2& size) {
    XResizeWindow(state_->display, state_->window, static_cast<unsigned>(size.x),
                  static_cast<unsigned>(size.y));
    XSync(state_->display, False);
}

void XClient::minimise() {
    XUnmapWindow(state_->display, state_->window);
    state_->set_window_state(IconicState);
    XSync(state_->display, False);
}

void XClient::restore() {
    state_->set_window_state(NormalState);
    XMapWindow(state_->display, state_->window);
    XSync(state_->display, False);
}

void XClient::close() {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = state_->window;
    event.xclient.message_type = state_->atom("WM_PROTOCOLS");
    event.xclient.format = 32;
    event.xclient.data.l[0] = static_cast<long>(state_->atom("WM_DELETE_WINDOW"));
    XSendEvent(state_->display, state_->window, False, NoEventMask, &event);
    XSync(state_->display, False);
}

glm::ivec2 XClient::size() const {
    XWindowAttributes attributes{};
    XGetWindowAttributes(state_->display, state_->window, &attributes);
    return {attributes.width, attributes.height};
}

std::vector<std::array<std::uint8_t, 3>> XClient::picture() const {
    std::vector<std::array<std::uint8_t, 3>> pixels;
    const glm::ivec2 whole = size();
    XImage* const image = XGetImage(state_->display, state_->window, 0, 0, static_cast<unsigned>(whole.x),
                                    static_cast<unsigned>(whole.y), AllPlanes, ZPixmap);
    if (image == nullptr) return pixels;
    for (int y = 0; y < image->height; ++y) {
        for (int x = 0; x < image->width; ++x) {
            const unsigned long pixel = XGetPixel(image, x, y);
            pixels.push_back({static_cast<std::uint8_t>(pixel >> 16), static_cast<std::uint8_t>(pixel >> 8),
                              static_cast<std::uint8_t>(pixel)});
        }
    }
    XDestroyImage(image);
    return pixels;
}

} // namespace viewer_tests
