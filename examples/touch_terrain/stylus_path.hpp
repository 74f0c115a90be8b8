#ifndef TOUCH_TERRAIN_STYLUS_PATH_HPP
#define TOUCH_TERRAIN_STYLUS_PATH_HPP

#include <glm/ext/vector_double3.hpp>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <vector>

namespace demo {

/// Where the tip of the stylus is at one instant: seconds, metres.
struct StylusSample {
    double t = 0;
    glm::dvec3 position{0.0};
};

/// Gives one sample a call, then nothing.
using StylusSource = std::function<std::optional<StylusSample>()>;

/// A path from a text file, header `t,x,y,z`, one row per update, read as it is needed.
class StylusPathFile {
public:
    /// Opens the file and reads its header. Throws BadInput.
    explicit StylusPathFile(const std::filesystem::path& file);

    /// The next row, or nothing at the end. Throws BadInput where a row is short or long, a value is no finite
    /// number, or time runs backwards, and if there is no row at all.
    [[nodiscard]] std::optional<StylusSample> next();

    /// The share of the file that has been read, from 0 to 1.
    [[nodiscard]] double progress() const noexcept;

private:
    [[nodiscard]] bool read_line();
    [[noreturn]] void refuse(const std::string& what) const;

    std::filesystem::path file_;
    std::vector<char> buffer_;
    std::ifstream stream_;
    std::string text_;
    std::uint64_t line_ = 0;
    double read_ = 0;
    double size_ = 0;
    double last_t_;
};

} // namespace demo

#endif // TOUCH_TERRAIN_STYLUS_PATH_HPP
