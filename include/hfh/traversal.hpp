#ifndef HFH_TRAVERSAL_HPP
#define HFH_TRAVERSAL_HPP

// Which patches a segment may touch, where it first hits, and the way down to the closest point.

#include <hfh/traversal/candidate_walker.hpp>
#include <hfh/traversal/cell_crossing.hpp>
#include <hfh/traversal/descent.hpp>
#include <hfh/traversal/empty_space_skipping.hpp>
#include <hfh/traversal/first_hit.hpp>
#include <hfh/traversal/local_closest_points.hpp>
#include <hfh/traversal/nearest_point.hpp>
#include <hfh/traversal/reach_search.hpp>
#include <hfh/traversal/surface_at.hpp>

#endif // HFH_TRAVERSAL_HPP
