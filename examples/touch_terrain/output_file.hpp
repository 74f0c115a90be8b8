#ifndef TOUCH_TERRAIN_OUTPUT_FILE_HPP
#define TOUCH_TERRAIN_OUTPUT_FILE_HPP

#include <filesystem>
#include <string_view>

namespace demo {

/// A file that is there whole or not at all: written beside its target under another name, and renamed at the end.
class OutputFile {
public:
    /// Opens the file beside `target`. Throws BadInput if that cannot be, or if `target` is there and no regular file.
    explicit OutputFile(const std::filesystem::path& target);
    /// Removes what was written, unless it was kept.
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// Throws BadInput if the system cannot take it all.
    void write(std::string_view text);

    /// For a child process that writes in our place.
    [[nodiscard]] int descriptor() const noexcept { return descriptor_; }

    /// Puts the file in the target's place. Throws BadInput.
    void keep();

private:
    std::filesystem::path target_;
    std::filesystem::path partial_;
    int descriptor_ = -1;
};

} // namespace demo

#endif // TOUCH_TERRAIN_OUTPUT_FILE_HPP
