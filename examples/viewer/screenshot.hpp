#ifndef VIEWER_SCREENSHOT_HPP
#define VIEWER_SCREENSHOT_HPP

#include <output_file.hpp>

#include <glm/ext/vector_int2.hpp>

#include <cstdint>
#include <vector>

namespace viewer {

/// Writes RGB bytes, south row first, as a PNG. Throws BadInput.
void write_png(demo::OutputFile& file, const std::vector<std::uint8_t>& colours, const glm::ivec2& size);

} // namespace viewer

#endif // VIEWER_SCREENSHOT_HPP
