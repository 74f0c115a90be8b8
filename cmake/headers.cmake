# The one list of headers: a room at a time, each in reading order. From it come what is installed, what tests compile
# one by one, which header may include which, and the tables that include/hfh/README.md has to have (tests/headers.cmake).
set(hfh_rooms geometry terrain traversal contact force device loop simulation)

set(hfh_in_geometry scalar lattice bilinear_patch surface_point distance_function newton_step safeguarded_step closest_point global_closest_point patch_minima)
set(hfh_in_terrain height_view height_field bilinear_grid extended_field bridged_field dilated_field min_max_pyramid height_levels blended_field)
set(hfh_in_traversal candidate_walker empty_space_skipping cell_crossing first_hit descent surface_at reach_search nearest_point local_closest_points)
set(hfh_in_contact contact proxy_tracker friction_cone friction force_shading level_change)
set(hfh_in_force force_evaluator damping virtual_coupling passivity_observer energy_tank)
set(hfh_in_device device workspace guard_limits sample_check force_guard triple_buffer limit_cycle_filter)
set(hfh_in_loop haptic_loop any_haptic_loop)
set(hfh_in_simulation stick_slip_mass driven_axis end_stops encoders simulated_device)

# What a room may look into, beside itself.
set(hfh_below_geometry)
set(hfh_below_terrain geometry)
set(hfh_below_traversal geometry terrain)
set(hfh_below_contact geometry terrain traversal)
set(hfh_below_force geometry contact)
set(hfh_below_device geometry)
set(hfh_below_loop geometry terrain contact force device)
set(hfh_below_simulation geometry device)

# As they are included: <hfh/...>. hfh.hpp is the core; <room>.hpp is all of a room.
set(hfh_headers hfh.hpp version.hpp)
foreach(room IN LISTS hfh_rooms)
    list(APPEND hfh_headers ${room}.hpp)
    list(TRANSFORM hfh_in_${room} REPLACE "(.+)" "${room}/\\1.hpp" OUTPUT_VARIABLE hfh_of_room)
    list(APPEND hfh_headers ${hfh_of_room})
endforeach()
unset(hfh_of_room)
