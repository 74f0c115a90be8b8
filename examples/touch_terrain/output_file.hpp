#ifndef TOUCH_TERRAIN_OUTPUT_FILE_HPP
#define TOUCH_TERRAIN_OUTPUT_FILE_HPP

#include <filesystem>
#include <string>
#include <string_view>

namespace demo {

/// A file that is there whole or not at all: written beside its target under another name, and renamed at the end. Interrupt,
/// hang-up and termination (SIGINT, SIGHUP, SIGTERM) remove what was written, and then end the program as they would.
class OutputFile {
public:
    /// Opens the file beside `target`. Throws BadInput if that cannot be, if `target` is there and no regular file, or if it
    /// is where standard output or standard error go.
    explicit OutputFile(const std::filesystem::path& target);
    /// Removes what was written, unless it was kept.
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// Throws BadInput if the system cannot take it all.
    void write(std::string_view text);

    /// Puts the file in the target's place. Throws BadInput.
    void keep();

    /// For a caller who takes room in advance, or waits until the disk has it all.
    [[nodiscard]] int descriptor() const noexcept { return descriptor_; }

private:
    std::filesystem::path target_;
    std::string partial_; ///< does not change while a signal may look at it
    int descriptor_ = -1;
    bool kept_ = false;
};

} // namespace demo

#endif // TOUCH_TERRAIN_OUTPUT_FILE_HPP
