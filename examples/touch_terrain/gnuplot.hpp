#ifndef TOUCH_TERRAIN_GNUPLOT_HPP
#define TOUCH_TERRAIN_GNUPLOT_HPP

#include <string_view>

namespace demo {

/// Throws BadInput unless gnuplot is installed: so that a long run does not fail at its end.
void require_gnuplot();

/// Runs gnuplot on `script` (which may hold binary data) with its output going to `descriptor`, and waits.
/// Throws BadInput if gnuplot cannot be started or fails.
void run_gnuplot(std::string_view script, int descriptor);

} // namespace demo

#endif // TOUCH_TERRAIN_GNUPLOT_HPP
