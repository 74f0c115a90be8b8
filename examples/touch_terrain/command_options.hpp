#ifndef TOUCH_TERRAIN_COMMAND_OPTIONS_HPP
#define TOUCH_TERRAIN_COMMAND_OPTIONS_HPP

#include <filesystem>
#include <optional>
#include <string>

namespace CLI {
class App;
}

// What the command lines of several programs have in common.

namespace demo {

/// False if the user asked for help, which has then been printed. Throws BadInput.
[[nodiscard]] bool read_command_line(CLI::App& app, int argc, const char* const* argv);

/// Throws BadInput: `option` is `value`, but must be `rule`.
[[noreturn]] void refuse(const std::string& option, const std::string& value, const std::string& rule);

/// The number that `text` is, of a size from 1e-12 to 1e12. Throws BadInput.
[[nodiscard]] double number_from(const std::string& option, const std::string& text, bool may_be_negative);

/// The file that `option` names, if it is on the command line. Throws BadInput where the name is empty.
[[nodiscard]] std::optional<std::filesystem::path> file_from(const CLI::App& app, const char* option,
                                                             const std::string& name);

/// Throws BadInput where both options name one file.
void refuse_same_file(const char* a, const std::optional<std::filesystem::path>& first, const char* b,
                      const std::optional<std::filesystem::path>& second);

} // namespace demo

#endif // TOUCH_TERRAIN_COMMAND_OPTIONS_HPP
