#ifndef HFH_GEOMETRY_HPP
#define HFH_GEOMETRY_HPP

// Numbers, one patch of the surface, and the closest point of it.

#include <hfh/geometry/bilinear_patch.hpp>
#include <hfh/geometry/closest_point.hpp>
#include <hfh/geometry/distance_function.hpp>
#include <hfh/geometry/global_closest_point.hpp>
#include <hfh/geometry/lattice.hpp>
#include <hfh/geometry/newton_step.hpp>
#include <hfh/geometry/patch_minima.hpp>
#include <hfh/geometry/safeguarded_step.hpp>
#include <hfh/geometry/scalar.hpp>
#include <hfh/geometry/surface_point.hpp>

#endif // HFH_GEOMETRY_HPP
