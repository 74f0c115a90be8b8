#include "bad_input.hpp"
#include "numbers.hpp"
#include "packed_heights.hpp"
#include "terrain.hpp"

#include <png.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <limits>
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
    /// What `read_pixels` gives: samples in this machine's byte order, palettes as the colours they stand for.
    [[nodiscard]] bool set_up() {
        if (setjmp(png_jmpbuf(png_)) != 0) return false;
        if (colour() == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
        if (bits() == 16 && std::endian::native == std::endian::little) png_set_swap(png_);
        png_set_interlace_handling(png_);
        png_read_update_info(png_, info_);
        return true;
    }
    [[nodiscard]] bool read_pixels(png_bytep* rows) {
        if (setjmp(png_jmpbuf(png_)) != 0) return false;
        png_read_image(png_, rows);
        png_read_end(png_, nullptr);
        return true;
    }

    [[nodiscard]] hfh::Index columns() const { return png_get_image_width(png_, info_); }
    [[nodiscard]] hfh::Index rows() const { return png_get_image_height(png_, info_); }
    [[nodiscard]] hfh::Index channels() const { return png_get_channels(png_, info_); }
    [[nodiscard]] int bits() const { return png_get_bit_depth(png_, info_); }
    [[nodiscard]] int colour() const { return png_get_color_type(png_, info_); }
    [[nodiscard]] std::size_t row_bytes() const { return png_get_rowbytes(png_, info_); }
    [[nodiscard]] const char* complaint() const { return complaint_.text; }
    /// The one grey or colour that tRNS makes transparent, one number a channel; nothing if there is none.
    [[nodiscard]] std::optional<std::array<png_uint_16, 3>> transparent() const {
        png_color_16p one = nullptr;
        if (png_get_tRNS(png_, info_, nullptr, nullptr, &one) == 0 || one == nullptr) return std::nullopt;
        if (colour() == PNG_COLOR_TYPE_GRAY) return std::array<png_uint_16, 3>{one->gray, 0, 0};
        return std::array<png_uint_16, 3>{one->red, one->green, one->blue};
    }

private:
    Complaint complaint_;
    png_structp png_;
    png_infop info_;
    std::FILE* file_;
};

/// Decoded pixels, channels together, north row first.
template <class S>
struct Pixels {
    hfh::Index columns, rows;
    std::size_t channels;
    std::vector<S> values;
    std::optional<std::array<png_uint_16, 3>> transparent; ///< as in PngReader

    [[nodiscard]] std::size_t count() const { return values.size() / channels; }
    [[nodiscard]] S operator()(std::size_t k, std::size_t channel) const {
        return values[k * channels + channel];
    }
    [[nodiscard]] bool has_alpha() const { return channels % 2 == 0; }
    [[nodiscard]] std::size_t alpha() const { return channels - 1; }
    [[nodiscard]] bool is_transparent(std::size_t k) const {
        if (!transparent) return false;
        for (std::size_t channel = 0; channel < channels; ++channel) {
            if ((*this)(k, channel) != (*transparent)[channel]) return false;
        }
        return true;
    }
    [[nodiscard]] bool is_grey() const {
        if (channels < 3) return true;
        for (std::size_t k = 0; k < count(); ++k) {
            if ((*this)(k, 0) != (*this)(k, 1) || (*this)(k, 0) != (*this)(k, 2)) return false;
        }
        return true;
    }
};

template <class S>
Pixels<S> decode(const std::filesystem::path& file, PngReader& reader) {
    // Deflate packs at most 1032:1, so a short file cannot hold a large image, whatever its header says.
    const auto file_size = static_cast<double>(std::filesystem::file_size(file));
    if (static_cast<double>(reader.row_bytes()) * static_cast<double>(reader.rows()) > 1100.0 * file_size) {
        throw BadInput{file.string() + " declares " + std::to_string(reader.columns()) + " x " +
                       std::to_string(reader.rows()) + " pixels, more than a file of its size can hold."};
    }
    const auto damaged = [&] {
        return BadInput{file.string() + " is damaged or cut short: libpng says " + shown(reader.complaint()) +
                        "."};
    };
    const auto transparent = reader.colour() == PNG_COLOR_TYPE_PALETTE ? std::nullopt : reader.transparent();
    if (!reader.set_up()) throw damaged();
    const auto channels = static_cast<std::size_t>(reader.channels());
    const std::size_t in_row = static_cast<std::size_t>(reader.columns()) * channels;
    const auto rows = static_cast<std::size_t>(reader.rows());
    Pixels<S> pixels{reader.columns(), reader.rows(), channels, std::vector<S>(in_row * rows), transparent};
    std::vector<png_bytep> row_starts;
    row_starts.reserve(rows);
    for (std::size_t j = 0; j < rows; ++j)
        row_starts.push_back(reinterpret_cast<png_bytep>(pixels.values.data() + j * in_row));
    if (!reader.read_pixels(row_starts.data())) throw damaged();
    return pixels;
}

/// What the alpha channel is for.
enum class AlphaRole {
    constant, ///< the same everywhere: nothing
    mask,     ///< 0 and the highest number only: it tells which pixels are there
    numbers
};

template <class S>
AlphaRole role_of_alpha(const Pixels<S>& pixels) {
    const S first = pixels(0, pixels.alpha());
    bool constant = true, mask = true;
    for (std::size_t k = 0; k < pixels.count(); ++k) {
        const S alpha = pixels(k, pixels.alpha());
        constant = constant && alpha == first;
        mask = mask && (alpha == 0 || alpha == std::numeric_limits<S>::max());
    }
    return constant ? AlphaRole::constant : mask ? AlphaRole::mask : AlphaRole::numbers;
}

/// The channel that the user names.
template <class S>
std::size_t channel_named(const std::filesystem::path& file, const Pixels<S>& pixels,
                          const std::string& wanted) {
    std::vector<std::string> names{"grey", "alpha"};
    if (pixels.channels > 2) names = {"red", "green", "blue", "alpha"};
    names.resize(pixels.channels);
    if (const auto number = parse_number<std::size_t>(wanted);
        number && *number >= 1 && *number <= names.size())
        return *number - 1;
    const auto at = std::ranges::find(names, wanted);
    if (at != names.end()) return static_cast<std::size_t>(at - names.begin());
    std::string all = names.front();
    for (std::size_t k = 1; k < names.size(); ++k) all += (k + 1 == names.size() ? " and " : ", ") + names[k];
    throw BadInput{"--channel is " + shown(wanted) + ", but " + file.string() + " has " + all + "."};
}

/// The channel that holds heights, and a sentence about it where there is a choice.
template <class S>
std::size_t channel_of_heights(const std::filesystem::path& file, const Pixels<S>& pixels,
                               std::vector<std::string>& assumed) {
    if (!pixels.has_alpha()) return 0;
    const AlphaRole role = role_of_alpha(pixels);
    if (role == AlphaRole::numbers) {
        assumed.emplace_back("heights are in the alpha channel (see --channel)");
        return pixels.alpha();
    }
    const std::string what_alpha_is =
        role == AlphaRole::constant
            ? "alpha is " + std::to_string(pixels(0, pixels.alpha())) + " everywhere"
            : "alpha is 0 or " + std::to_string(std::numeric_limits<S>::max()) + " everywhere";
    if (!pixels.is_grey()) {
        throw BadInput{
            file.string() + " is in colours and its " + what_alpha_is +
            ", so that none of its channels is the height: --channel or --encoding must say what is."};
    }
    assumed.push_back("heights are in the grey channel, for " + what_alpha_is +
                      (role == AlphaRole::mask ? ", which marks holes" : "") + " (see --channel)");
    return 0;
}

template <class S>
Terrain terrain_of(const std::filesystem::path& file, PngReader& reader, const ReadOptions& options) {
    auto pixels = std::make_shared<Pixels<S>>(decode<S>(file, reader));
    std::vector<std::string> assumed;
    const std::size_t channel = options.channel.empty() ? channel_of_heights(file, *pixels, assumed)
                                                        : channel_named(file, *pixels, options.channel);
    // Alpha is a mask for the other channels, if it says anything at all.
    const bool masked =
        pixels->has_alpha() && channel != pixels->alpha() && role_of_alpha(*pixels) != AlphaRole::constant;
    const hfh::Index columns = pixels->columns, rows = pixels->rows;
    if (!masked && !pixels->transparent) {
        const auto step = static_cast<hfh::Index>(pixels->channels);
        const Heights<S> north_first{
            pixels->values.data() + channel, columns, rows, step, step * columns, NoData<S>{}};
        return {.name = file.filename().string(),
                .storage = std::move(pixels),
                .heights = north_first.flipped_rows(),
                .spacing = std::nullopt,
                .assumed = std::move(assumed)};
    }
    auto heights = std::make_shared<std::vector<float>>(pixels->count()); // holds 16 bits, and holes
    for (std::size_t k = 0; k < pixels->count(); ++k) {
        const bool hole = pixels->is_transparent(k) || (masked && (*pixels)(k, pixels->alpha()) == 0);
        (*heights)[k] = hole ? std::numeric_limits<float>::quiet_NaN() : (*pixels)(k, channel);
    }
    const Heights<float> north_first{heights->data(), columns, rows, NoData<float>{}};
    return {.name = file.filename().string(),
            .storage = std::move(heights),
            .heights = north_first.flipped_rows(),
            .spacing = std::nullopt,
            .assumed = std::move(assumed)};
}

Terrain unpacked(const std::filesystem::path& file, PngReader& reader) {
    const Pixels<std::uint8_t> pixels = decode<std::uint8_t>(file, reader);
    auto heights = std::make_shared<std::vector<std::int32_t>>(pixels.count());
    for (std::size_t k = 0; k < pixels.count(); ++k) {
        const bool hole = pixels.is_transparent(k) || (pixels.has_alpha() && pixels(k, pixels.alpha()) == 0);
        (*heights)[k] = hole ? no_packed_sample : packed_sample(pixels.values.data(), pixels.channels, k);
    }
    const Heights<std::int32_t> north_first{heights->data(), pixels.columns, pixels.rows,
                                            NoData<std::int32_t>{no_packed_sample}};
    return {.name = file.filename().string(),
            .storage = std::move(heights),
            .heights = north_first.flipped_rows(),
            .spacing = std::nullopt,
            .assumed = {}};
}

/// The kinds of PNG that hold heights, `options` considered. Throws BadInput.
void require_heights(const std::filesystem::path& file, const PngReader& reader, const ReadOptions& options) {
    const int colour = reader.colour();
    if (options.encoding != Encoding::none) {
        const bool coloured = (colour & PNG_COLOR_MASK_COLOR) != 0;
        if (coloured && reader.bits() <= 8 && options.channel.empty()) return;
        throw BadInput{file.string() +
                       (coloured ? " has " + std::to_string(reader.bits()) + " bits a sample"
                                 : " is an image without colours") +
                       ", but --encoding wants red, green and blue of 8 bits, and all of them."};
    }
    if (colour == PNG_COLOR_TYPE_PALETTE) {
        throw BadInput{
            file.string() +
            " is a palette image, but its numbers must be heights: grey, or with alpha, or packed as "
            "--encoding says."};
    }
    if (colour == PNG_COLOR_TYPE_RGB && options.channel.empty()) {
        throw BadInput{
            file.string() +
            " is an RGB image without alpha, but its numbers must be heights: grey, or with alpha, or "
            "as --channel or --encoding says."};
    }
    if (reader.bits() != 8 && reader.bits() != 16) {
        throw BadInput{file.string() + " has " + std::to_string(reader.bits()) +
                       " bits a sample, but heights need 8 or 16."};
    }
}

/// The scale, offset and unit of an image from its metadata, if they can be had. Its channels have them in common.
bool heights_known([[maybe_unused]] Terrain& terrain, [[maybe_unused]] const std::filesystem::path& file,
                   [[maybe_unused]] const ReadOptions& options) {
#ifdef TOUCH_TERRAIN_HAS_GDAL
    return set_heights_with_gdal(terrain, file, options, 1);
#else
    return false;
#endif
}

/// The spacing of an image from its world file or its metadata, if they can be had.
void place_if_known([[maybe_unused]] Terrain& terrain, [[maybe_unused]] const std::filesystem::path& file,
                    [[maybe_unused]] const ReadOptions& options) {
#ifdef TOUCH_TERRAIN_HAS_GDAL
    place_with_gdal(terrain, file, options);
#endif
}

} // namespace

Terrain read_png(const std::filesystem::path& file, const ReadOptions& options) {
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
    require_heights(file, reader, options);
    require_a_patch(file, reader.columns(), reader.rows());

    Terrain terrain = options.encoding != Encoding::none ? unpacked(file, reader)
                      : reader.bits() == 8               ? terrain_of<std::uint8_t>(file, reader, options)
                                                         : terrain_of<std::uint16_t>(file, reader, options);
    if (options.encoding != Encoding::none) {
        const auto [scale, offset] = scale_of(options.encoding);
        set_height_unit(terrain, file, options, 1.0, scale, offset);
    } else if (!heights_known(terrain, file, options)) {
        set_height_unit(terrain, file, options, std::nullopt);
    }
    place_if_known(terrain, file, options);
    return terrain;
}

} // namespace demo
