#include "command_options.hpp"

#include "bad_input.hpp"
#include "numbers.hpp"
#include "standard_streams.hpp"
#include "terrain_files.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>

namespace demo {

bool read_command_line(CLI::App& app, int argc, const char* const* argv) {
    try {
        app.parse(argc, argv);
        return true;
    } catch (const CLI::CallForHelp&) {
        print(app.help());
        return false;
    } catch (const CLI::ParseError& error) {
        std::string what = error.what();
        std::ranges::replace(what, '\n', ' ');
        throw BadInput{"The command line cannot be read (see --help): " + what +
                       (what.ends_with('.') ? "" : ".")};
    }
}

void refuse(const std::string& option, const std::string& value, const std::string& rule) {
    throw BadInput{option + " is " + shown(value) + ", but must be " + rule + "."};
}

double number_from(const std::string& option, const std::string& text, bool may_be_negative) {
    const auto value = parse_finite(text);
    const double size = value ? std::abs(*value) : 0.0;
    const bool fits = size >= 1e-12 && size <= 1e12 && (may_be_negative || *value > 0);
    if (!fits)
        refuse(option, text,
               std::string{"a number from 1e-12 to 1e12"} + (may_be_negative ? ", or its negative" : ""));
    return *value;
}

std::optional<std::filesystem::path> file_from(const CLI::App& app, const char* option,
                                               const std::string& name) {
    if (app.count(option) == 0) return std::nullopt;
    if (name.empty()) refuse(option, name, "the name of a file");
    return name;
}

void refuse_same_file(const char* a, const std::optional<std::filesystem::path>& first, const char* b,
                      const std::optional<std::filesystem::path>& second) {
    if (!first || !second || !is_same_file(*first, *second)) return;
    throw BadInput{std::string{a} + " and " + b + " are both " + second->string() +
                   ", but each must be a file of its own."};
}

} // namespace demo
