#ifndef TOUCH_TERRAIN_STANDARD_STREAMS_HPP
#define TOUCH_TERRAIN_STANDARD_STREAMS_HPP

#include <string_view>

namespace demo {

/// To be called before any file is opened, which would take the place of a standard stream that is closed. Opens /dev/null
/// for closed input and errors, and makes writing to what nobody reads, or to a file grown too large, an error that can be
/// seen, in place of a signal that ends the program. Throws BadInput if standard output is closed.
void set_up_standard_streams();

/// Writes `text` to standard output, all of it. Throws BadInput if that cannot be.
void print(std::string_view text);

} // namespace demo

#endif // TOUCH_TERRAIN_STANDARD_STREAMS_HPP
