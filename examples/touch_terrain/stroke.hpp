#ifndef TOUCH_TERRAIN_STROKE_HPP
#define TOUCH_TERRAIN_STROKE_HPP

#include "ground.hpp"
#include "stylus_path.hpp"

#include <vector>

namespace demo {

/// How deep the built-in stroke presses on level ground, in metres: a fifth of a cell, so that it means the same on a
/// mountain range as on a scanned bullet. Bumps press back up to 1.6 times as deep, hollows down to 0.4 times.
[[nodiscard]] double stroke_depth(const Ground& ground) noexcept;

/// Newtons per metre of terrain if the user gives none: 2 N at a quarter of a cell. With `stroke_depth` this makes 0.6 to 2.6 N
/// on open ground, within the 3.3 N of a desktop device.
[[nodiscard]] double default_stiffness(const Ground& ground) noexcept;

/// The built-in stroke, 20 s at 1 kHz: down onto the ground, across the middle of the terrain from west to east in
/// loops, and off again. A hand that follows the ground, though not every bump of it; it lifts off before holes, and over
/// walls, which it could only press against: what is steeper than 63° and higher than `depth`. On level ground it is `depth`
/// metres below the surface; a ball at its end, of radius `tip` (m), is by as much below the place where it would touch.
[[nodiscard]] std::vector<StylusSample> built_in_stroke(const Ground& ground, double depth, double tip = 0);

} // namespace demo

#endif // TOUCH_TERRAIN_STROKE_HPP
