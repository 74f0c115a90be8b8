#include "screenshot.hpp"

#include <bad_input.hpp>

#include <png.h>

#include <string>

namespace viewer {

void write_png(demo::OutputFile& file, const std::vector<std::uint8_t>& colours, const glm::ivec2& size) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(size.x);
    image.height = static_cast<png_uint_32>(size.y);
    image.format = PNG_FORMAT_RGB;
    const png_int_32 south_first = -3 * size.x;
    png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(image);
    std::string text(bytes, '\0');
    if (png_image_write_to_memory(&image, text.data(), &bytes, 0, colours.data(), south_first, nullptr) == 0)
        throw demo::BadInput{std::string{"The picture cannot be made into a PNG: "} + image.message + "."};
    text.resize(bytes);
    file.write(text);
}

} // namespace viewer
