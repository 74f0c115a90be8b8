#ifndef HFH_TERRAIN_HPP
#define HFH_TERRAIN_HPP

// Heights as the user has them, the grid over them, and what wraps a field.

#include <hfh/terrain/bilinear_grid.hpp>
#include <hfh/terrain/blended_field.hpp>
#include <hfh/terrain/bridged_field.hpp>
#include <hfh/terrain/dilated_field.hpp>
#include <hfh/terrain/extended_field.hpp>
#include <hfh/terrain/height_field.hpp>
#include <hfh/terrain/height_levels.hpp>
#include <hfh/terrain/height_view.hpp>
#include <hfh/terrain/min_max_pyramid.hpp>

#endif // HFH_TERRAIN_HPP
