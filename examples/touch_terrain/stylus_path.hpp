#ifndef TOUCH_TERRAIN_STYLUS_PATH_HPP
#define TOUCH_TERRAIN_STYLUS_PATH_HPP

#include <hfh/device/device.hpp>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <vector>

namespace demo {

/// Where the tip of the stylus is at one instant: seconds, metres.
struct StylusSample {
    double t = 0;
    glm::dvec3 position{0.0};
};

/// The same as a device tells it: `t` is the path's time, the sample's may begin elsewhere.
struct StylusStep {
    double t = 0;
    hfh::DeviceSample sample{};
};

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
