#ifndef TOUCH_TERRAIN_UNITS_HPP
#define TOUCH_TERRAIN_UNITS_HPP

#include <optional>
#include <string_view>

namespace demo {

/// Metres in one unit of length, by a name that files and people give it: "m", "metres", "US survey foot", "us-ft", "km".
/// Case, blanks, signs and a plural s do not matter. Nothing if it is no unit of length that is known.
[[nodiscard]] std::optional<double> metres_in(std::string_view name);

} // namespace demo

#endif // TOUCH_TERRAIN_UNITS_HPP
