#ifndef HFH_TESTS_VIEWER_X_CLIENT_HPP
#define HFH_TESTS_VIEWER_X_CLIENT_HPP

#include <glm/ext/vector_int2.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace viewer_tests {

/// Another client of an X display, which does to a window of the viewer what a person and a window manager would.
class XClient {
public:
    /// Not connected where there is no such display.
    explicit XClient(const std::string& display);
    ~XClient();
    [[nodiscard]] bool is_connected() const noexcept;

    /// Dots per inch, as desktops with a screen scale set them (96 times the scale). For windows that open later.
    void set_dots_per_inch(int dots);
    /// Waits for some seconds for the viewer's window to be there and drawn into. False if it is not.
    bool find_window();

    void move_pointer(const glm::ivec2& to);
    void press_button(unsigned button);
    void release_button(unsigned button);
    void unfocus();
    void focus();
    void resize(const glm::ivec2& size);
    void minimise();
    void restore();
    /// As the window's own button does.
    void close();

    [[nodiscard]] glm::ivec2 size() const;
    /// Red, green and blue of the window's pixels, row by row from the top left. Empty if part of it is off the screen.
    [[nodiscard]] std::vector<std::array<std::uint8_t, 3>> picture() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace viewer_tests

#endif // HFH_TESTS_VIEWER_X_CLIENT_HPP
