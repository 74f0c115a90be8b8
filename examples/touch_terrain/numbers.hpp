#ifndef TOUCH_TERRAIN_NUMBERS_HPP
#define TOUCH_TERRAIN_NUMBERS_HPP

#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

// Numbers as text: the same in every locale, and the shortest digits that read back as the same bits.

namespace demo {

/// `text` without blanks at either end.
[[nodiscard]] inline std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// `text` without the mark that some editors put in front of UTF-8.
[[nodiscard]] inline std::string_view without_byte_order_mark(std::string_view text) {
    constexpr std::string_view mark = "\xef\xbb\xbf";
    if (text.starts_with(mark)) text.remove_prefix(mark.size());
    return text;
}

/// The number that `text` is, all of it, or nothing.
template <class T>
[[nodiscard]] std::optional<T> parse_number(std::string_view text) {
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

/// The finite number that `text` is, or nothing.
[[nodiscard]] inline std::optional<double> parse_finite(std::string_view text) {
    const auto value = parse_number<double>(text);
    return value && std::isfinite(*value) ? value : std::nullopt;
}

/// Appends `value` so that it reads back as the same double.
template <class T>
void append_number(std::string& out, T value) {
    char digits[32];
    out.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

/// `value` in `significant` digits, for people.
[[nodiscard]] inline std::string rounded(double value, int significant = 3) {
    char digits[64];
    std::snprintf(digits, sizeof digits, "%.*g", significant, value);
    if (std::string_view{digits}.find('e') != std::string_view::npos && std::abs(value) >= 1 &&
        std::abs(value) < 1e9) {
        std::snprintf(digits, sizeof digits, "%.0f", value);
    }
    return digits;
}

/// 1234567 as "1,234,567".
[[nodiscard]] inline std::string grouped(unsigned long long value) {
    std::string out = std::to_string(value);
    for (auto at = static_cast<std::ptrdiff_t>(out.size()) - 3; at > 0; at -= 3) {
        out.insert(static_cast<std::size_t>(at), 1, ',');
    }
    return out;
}

} // namespace demo

#endif // TOUCH_TERRAIN_NUMBERS_HPP
