#ifndef TOUCH_TERRAIN_BAD_INPUT_HPP
#define TOUCH_TERRAIN_BAD_INPUT_HPP

#include <stdexcept>
#include <string>
#include <string_view>

namespace demo {

/// What the user can mend: one sentence that names file, place, value and rule. `main` prints it and exits with 2.
struct BadInput : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A piece of the user's input as it may stand inside a sentence: in quotes, on one line, not too long.
[[nodiscard]] inline std::string shown(std::string_view text) {
    constexpr std::size_t longest = 60;
    std::string out = "'";
    for (const char c : text.substr(0, longest)) {
        const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
        out += control ? '?' : c;
    }
    return out + (text.size() > longest ? "...'" : "'");
}

} // namespace demo

#endif // TOUCH_TERRAIN_BAD_INPUT_HPP
