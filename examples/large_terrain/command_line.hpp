#ifndef LARGE_TERRAIN_COMMAND_LINE_HPP
#define LARGE_TERRAIN_COMMAND_LINE_HPP

#include <bad_input.hpp>
#include <command_options.hpp>
#include <numbers.hpp>

#include <CLI/CLI.hpp>

#include <concepts>
#include <string>

namespace large_terrain {

using demo::read_command_line;

/// The number that `text` is, from `low` to `high`. Throws BadInput.
template <class T>
[[nodiscard]] T number_from(const std::string& option, const std::string& text, T low, T high) {
    const auto value = demo::parse_number<T>(text);
    if (value && low <= *value && *value <= high) return *value; // NaN is not
    std::string rule = std::integral<T> ? "a whole number from " : "a number from ";
    demo::append_number(rule, low);
    rule += " to ";
    demo::append_number(rule, high);
    throw demo::BadInput{option + " is " + demo::shown(text) + ", but must be " + rule + "."};
}

} // namespace large_terrain

#endif // LARGE_TERRAIN_COMMAND_LINE_HPP
