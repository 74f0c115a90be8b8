#ifndef HFH_HFH_HPP
#define HFH_HFH_HPP

// The core that a scene always needs, in reading order. What it leaves out is included by name, or a room at a time.

#include <hfh/version.hpp>

// Numbers, places on the grid, one patch of it, and its closest point.
#include <hfh/geometry/scalar.hpp>

#include <hfh/geometry/lattice.hpp>

#include <hfh/geometry/bilinear_patch.hpp>
#include <hfh/geometry/surface_point.hpp>

#include <hfh/geometry/distance_function.hpp>

#include <hfh/geometry/newton_step.hpp>
#include <hfh/geometry/safeguarded_step.hpp>

#include <hfh/geometry/closest_point.hpp>
#include <hfh/geometry/global_closest_point.hpp>

// The user's heights as a field of patches.
#include <hfh/terrain/height_view.hpp>

#include <hfh/terrain/height_field.hpp>

#include <hfh/terrain/bilinear_grid.hpp>

// The patches that a segment may touch, the first that it hits, and the way down to the closest point.
#include <hfh/traversal/candidate_walker.hpp>
#include <hfh/traversal/first_hit.hpp>

#include <hfh/traversal/descent.hpp>

// The proxy of a stylus, and the force on it.
#include <hfh/contact/contact.hpp>
#include <hfh/contact/proxy_tracker.hpp>

#include <hfh/force/force_evaluator.hpp>

#endif // HFH_HFH_HPP
