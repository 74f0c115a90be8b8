#ifndef TOUCH_TERRAIN_GNUPLOT_HPP
#define TOUCH_TERRAIN_GNUPLOT_HPP

#include <string>
#include <string_view>

namespace demo {

/// Throws BadInput unless gnuplot is installed: so that a long run does not fail at its end.
void require_gnuplot();

/// Runs gnuplot on `script` (which may hold binary data), waits, and gives what it wrote to its standard output: to us and
/// not to a file, for gnuplot does not say when a disk is full. Throws BadInput if gnuplot cannot be started or fails.
[[nodiscard]] std::string run_gnuplot(std::string_view script);

} // namespace demo

#endif // TOUCH_TERRAIN_GNUPLOT_HPP
