#ifndef TOUCH_TERRAIN_PICTURE_HPP
#define TOUCH_TERRAIN_PICTURE_HPP

#include "ground.hpp"
#include "output_file.hpp"
#include "trace.hpp"

#include <string>

namespace demo {

/// Draws the ground around the path in shaded relief, north up, the path on it coloured by force, and the force over
/// time below, as a PNG. Throws BadInput where gnuplot cannot, or the
/// disk is full.
void draw_picture(OutputFile& file, const Ground& ground, const Trace& trace, const std::string& title,
                  const std::string& subtitle);

} // namespace demo

#endif // TOUCH_TERRAIN_PICTURE_HPP
