#ifndef HFH_HFH_HPP
#define HFH_HFH_HPP

// Everything, in reading order.

#include <hfh/version.hpp>

#include <hfh/scalar.hpp>

#include <hfh/bilinear_grid.hpp>
#include <hfh/bilinear_patch.hpp>
#include <hfh/height_field.hpp>
#include <hfh/height_view.hpp>
#include <hfh/lattice.hpp>

#include <hfh/candidate_walker.hpp>
#include <hfh/first_hit.hpp>
#include <hfh/surface.hpp>

#include <hfh/closest_point.hpp>
#include <hfh/descent.hpp>
#include <hfh/global_closest_point.hpp>

#include <hfh/contact.hpp>
#include <hfh/force_evaluator.hpp>
#include <hfh/proxy_tracker.hpp>

#endif // HFH_HFH_HPP
