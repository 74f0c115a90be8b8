#ifndef LARGE_TERRAIN_COMMAND_LINE_HPP
#define LARGE_TERRAIN_COMMAND_LINE_HPP

#include <bad_input.hpp>
#include <numbers.hpp>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <concepts>
#include <cstdio>
#include <string>

namespace large_terrain {

/// False if the user asked for help, which has then been printed. Throws BadInput.
inline bool read_command_line(CLI::App& app, int argc, const char* const* argv) {
    try {
        app.parse(argc, argv);
        return true;
    } catch (const CLI::CallForHelp&) {
        std::fputs(app.help().c_str(), stdout);
        return false;
    } catch (const CLI::ParseError& error) {
        std::string what = error.what();
        std::ranges::replace(what, '\n', ' ');
        throw demo::BadInput{"The command line cannot be read (see --help): " + what +
                             (what.ends_with('.') ? "" : ".")};
    }
}

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
