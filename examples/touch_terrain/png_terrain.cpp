#include "bad_input.hpp"
#include "terrain.hpp"

#include <png.h>

#include <bit>
#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <vector>

namespace demo {
namespace {

struct FileCloser {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

/// Where libpng puts its complaint before it jumps back.
struct Complaint {
    char text[120] = "";
};

extern "C" {
[[noreturn]] void on_png_error(png_structp png, png_const_charp message) {
    auto* const complaint = static_cast<Complaint*>(png_get_error_ptr(png));
    std::snprintf(complaint->text, sizeof complaint->text, "%s", message);
    png_longjmp(png, 1);
}
void on_png_warning(png_structp, png_const_charp) {}
}

/// The libpng calls that may jump, each in a function that holds nothing which a jump would leak.
class PngReader {
public:
    explicit PngReader(std::FILE* file)
        : png_{png_create_read_struct(PNG_LIBPNG_VER_STRING, &complaint_, on_png_error, on_png_warning)},
          info_{png_ != nullptr ? png_create_info_struct(png_) : nullptr}, file_{file} {
        if (info_ == nullptr) throw std::bad_alloc{};
    }
    ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;

    [[nodiscard]] bool read_header() {
        if (setjmp(png_jmpbuf(png_)) != 0) return false;
        png_init_io(png_, file_);
        png_read_info(png_, info_);
        return true;
    }
    [[nodiscard]] bool read_pixels(png_bytep* rows) {
        if (setjmp(png_jmpbuf(png_)) != 0) return false;
        if (bits() == 16 && std::endian::native == std::endian::little) png_set_swap(png_);
        png_set_interlace_handling(png_);
        png_read_update_info(png_, info_);
        png_read_image(png_, rows);
        png_read_end(png_, nullptr);
        return true;
    }

    [[nodiscard]] hfh::Index columns() const { return png_get_image_width(png_, info_); }
    [[nodiscard]] hfh::Index rows() const { return png_get_image_height(png_, info_); }
    [[nodiscard]] hfh::Index channels() const { return png_get_channels(png_, info_); }
    [[nodiscard]] int bits() const { return png_get_bit_depth(png_, info_); }
    [[nodiscard]] int colour() const { return png_get_color_type(png_, info_); }
    [[nodiscard]] const char* complaint() const { return complaint_.text; }

private:
    Complaint complaint_;
    png_structp png_;
    png_infop info_;
    std::FILE* file_;
};

/// A view on the last channel of the pixels: alpha in GA and RGBA, grey in G.
template <class S>
Terrain decode(const std::filesystem::path& file, PngReader& reader) {
    const hfh::Index columns = reader.columns(), rows = reader.rows(), channels = reader.channels();
    const hfh::Index in_row = columns * channels;

    // Deflate packs at most 1032:1, so a short file cannot hold a large image, whatever its header says.
    const auto file_size = static_cast<double>(std::filesystem::file_size(file));
    const double bytes = static_cast<double>(in_row) * static_cast<double>(rows) * sizeof(S);
    if (bytes > 1100.0 * file_size) {
        throw BadInput{file.string() + " declares " + std::to_string(columns) + " x " + std::to_string(rows) +
                       " pixels, more than a file of its size can hold."};
    }

    auto pixels = std::make_shared<std::vector<S>>(static_cast<std::size_t>(in_row * rows));
    std::vector<png_bytep> row_starts;
    row_starts.reserve(static_cast<std::size_t>(rows));
    for (hfh::Index j = 0; j < rows; ++j) {
        row_starts.push_back(reinterpret_cast<png_bytep>(pixels->data() + j * in_row));
    }
    if (!reader.read_pixels(row_starts.data())) {
        throw BadInput{file.string() + " is damaged or cut short: libpng says " + shown(reader.complaint()) +
                       "."};
    }
    const Heights<S> north_first{
        pixels->data() + (channels - 1), columns, rows, channels, in_row, NoData<S>{}};
    return {file.filename().string(), std::move(pixels), north_first.flipped_rows(), std::nullopt};
}

} // namespace

Terrain read_png(const std::filesystem::path& file) {
    const File opened{std::fopen(file.c_str(), "rb")};
    if (!opened) throw BadInput{file.string() + " cannot be read: " + std::strerror(errno) + "."};

    png_byte signature[8] = {};
    const std::size_t read = std::fread(signature, 1, sizeof signature, opened.get());
    if (read != sizeof signature || png_sig_cmp(signature, 0, sizeof signature) != 0) {
        throw BadInput{file.string() + " is not a PNG image: its first 8 bytes are not the PNG signature."};
    }
    std::rewind(opened.get());

    PngReader reader{opened.get()};
    if (!reader.read_header()) {
        throw BadInput{file.string() + " is not a PNG image that can be read: libpng says " +
                       shown(reader.complaint()) + "."};
    }
    if (reader.colour() == PNG_COLOR_TYPE_PALETTE) {
        throw BadInput{file.string() +
                       " is a palette image, but its numbers must be heights: grey, or with alpha."};
    }
    if (reader.colour() == PNG_COLOR_TYPE_RGB) {
        throw BadInput{file.string() +
                       " is an RGB image without alpha, but its numbers must be heights: grey, or "
                       "with alpha."};
    }
    if (reader.bits() != 8 && reader.bits() != 16) {
        throw BadInput{file.string() + " has " + std::to_string(reader.bits()) +
                       " bits a sample, but heights need 8 or 16."};
    }
    require_a_patch(file, reader.columns(), reader.rows());
    return reader.bits() == 8 ? decode<std::uint8_t>(file, reader) : decode<std::uint16_t>(file, reader);
}

} // namespace demo
