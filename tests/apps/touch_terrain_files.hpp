#ifndef HFH_TESTS_TOUCH_TERRAIN_FILES_HPP
#define HFH_TESTS_TOUCH_TERRAIN_FILES_HPP

#include <png.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

// Files for the demo's tests, written without any code of the demo.

namespace touch_terrain_tests {

namespace fs = std::filesystem;

inline std::string contents(const fs::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
}

/// What a run of the program left behind.
struct Run {
    int code = -1;
    std::string out, err;
};

/// A folder of its own for one test, gone afterwards.
class Folder {
public:
    Folder() {
        std::string name = (fs::temp_directory_path() / "hfh-touch-terrain-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error{"no temporary folder"};
        root_ = name;
    }
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(root_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    [[nodiscard]] fs::path operator/(const std::string& name) const { return root_ / name; }

    fs::path text(const std::string& name, const std::string& content) const {
        std::ofstream{root_ / name, std::ios::binary} << content;
        return root_ / name;
    }
    template <class S>
    fs::path samples(const std::string& name, const std::vector<S>& values) const {
        std::ofstream{root_ / name, std::ios::binary}.write(
            reinterpret_cast<const char*>(values.data()),
            static_cast<std::streamsize>(values.size() * sizeof(S)));
        return root_ / name;
    }

    /// Every file and what it holds.
    [[nodiscard]] std::map<std::string, std::string> listing() const {
        std::map<std::string, std::string> files;
        for (const auto& entry : fs::recursive_directory_iterator{root_}) {
            files[entry.path().string()] = entry.is_regular_file() ? contents(entry.path()) : "";
        }
        return files;
    }

    /// Runs `program` in the folder; `arguments` as for a shell, `before` stands in front of the command.
    [[nodiscard]] Run run_program(const std::string& program, const std::string& arguments,
                                  const std::string& before = "") const {
        const Folder beside;
        const std::string command = "cd '" + root_.string() + "' && " + before + " '" + program + "' " +
                                    arguments + " >'" + (beside / "out").string() + "' 2>'" +
                                    (beside / "err").string() + "' </dev/null";
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(beside / "out"),
                contents(beside / "err")};
    }
    [[nodiscard]] Run run(const std::string& arguments, const std::string& before = "") const {
        return run_program(HFH_TOUCH_TERRAIN, arguments, before);
    }

private:
    fs::path root_;
};

/// Writes a PNG, `values` row by row, north first, channels together. Palette images have 8 bits and one colour.
inline void write_png(const fs::path& file, int columns, int rows, int bits, int colour,
                      const std::vector<int>& values, int interlace = PNG_INTERLACE_NONE) {
    std::FILE* const out = std::fopen(file.c_str(), "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, out);
    png_set_IHDR(png, info, static_cast<png_uint_32>(columns), static_cast<png_uint_32>(rows), bits, colour,
                 interlace, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (colour == PNG_COLOR_TYPE_PALETTE) {
        const png_color one{10, 20, 30};
        png_set_PLTE(png, info, &one, 1);
    }
    std::vector<std::uint8_t> bytes;
    for (const int value : values) {
        if (bits == 16) bytes.push_back(static_cast<std::uint8_t>(value >> 8));
        bytes.push_back(static_cast<std::uint8_t>(value & 0xff));
    }
    std::vector<png_bytep> starts;
    for (int j = 0; j < rows; ++j) {
        starts.push_back(bytes.data() +
                         bytes.size() / static_cast<std::size_t>(rows) * static_cast<std::size_t>(j));
    }
    png_set_rows(png, info, starts.data());
    png_write_png(png, info, PNG_TRANSFORM_IDENTITY, nullptr);
    png_destroy_write_struct(&png, &info);
    std::fclose(out);
}

/// The checksum of PNG and zip.
inline std::uint32_t crc_of(const std::string& data) {
    std::uint32_t crc = 0xffffffffu;
    for (const char c : data) {
        crc ^= static_cast<std::uint8_t>(c);
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0u);
    }
    return ~crc;
}

/// A zip archive of one file, which is not compressed.
inline std::string zip_of(const std::string& name, const std::string& data) {
    const auto number = [](std::size_t value, int bytes) {
        std::string out;
        for (int k = 0; k < bytes; ++k) out += static_cast<char>(k < 8 ? value >> 8 * k & 0xff : 0);
        return out;
    };
    const std::string about = number(10, 2) + number(0, 2) + number(0, 2) + number(0, 4) +
                              number(crc_of(data), 4) + number(data.size(), 4) + number(data.size(), 4) +
                              number(name.size(), 2) + number(0, 2);
    const std::string local = "PK\3\4" + about + name + data;
    const std::string central = "PK\1\2" + number(10, 2) + about + number(0, 2 + 2 + 2 + 4 + 4) + name;
    return local + central + "PK\5\6" + number(0, 4) + number(1, 2) + number(1, 2) +
           number(central.size(), 4) + number(local.size(), 4) + number(0, 2);
}

/// Puts a chunk in front of the pixels of a PNG.
inline void insert_chunk(const fs::path& file, const std::string& type, const std::string& data) {
    const auto append = [](std::string& out, std::uint32_t value) {
        for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift & 0xff);
    };
    std::string chunk;
    append(chunk, static_cast<std::uint32_t>(data.size()));
    chunk += type + data;
    append(chunk, crc_of(type + data));
    std::string bytes = contents(file);
    bytes.insert(bytes.find("IDAT") - 4, chunk);
    std::ofstream{file, std::ios::binary} << bytes;
}

} // namespace touch_terrain_tests

#endif // HFH_TESTS_TOUCH_TERRAIN_FILES_HPP
