# Run by CTest: cmake -D INCLUDE_DIR=... -P headers.cmake
# Checks that the headers include each other only downward, and little else.
cmake_minimum_required(VERSION 3.25)

# A header may include those that stand before it. The grid stands behind the algorithms, so none can depend on it. What
# stands behind hfh is included by name: a scene that does not use it does not pay for it in compile time either.
set(order
    version
    scalar
    height_view lattice surface
    bilinear_patch contact
    height_field
    candidate_walker clear_stretch first_hit closest_point global_closest_point descent
    proxy_tracker
    bilinear_grid
    force_evaluator
    hfh
    device
    damping force_shading friction_cone friction level_beyond raised_field
    height_bounds
    workspace guard_limits sample_check force_guard latest_value
    moving_mass driven_axis end_stops encoders simulated_device
    virtual_coupling passivity_observer energy_tank steady_position)

# Force ignores how a contact was found.
set(only_force_evaluator contact scalar)

# Costly to compile, or a temptation to allocate.
set(forbidden iostream string vector functional glm/glm.hpp)

set(complaints "")
cmake_path(ABSOLUTE_PATH INCLUDE_DIR)
file(GLOB headers RELATIVE ${INCLUDE_DIR} ${INCLUDE_DIR}/*.hpp)
if(NOT headers)
    message(FATAL_ERROR "no headers in ${INCLUDE_DIR}")
endif()
foreach(header IN LISTS headers)
    cmake_path(GET header STEM name)
    list(FIND order ${name} place)
    if(place EQUAL -1)
        list(APPEND complaints "${header} has no place in the order of tests/headers.cmake")
        continue()
    endif()

    file(STRINGS ${INCLUDE_DIR}/${header} lines REGEX "^[ \t]*#[ \t]*include")
    foreach(line IN LISTS lines)
        string(REGEX REPLACE ".*[<\"](.*)[>\"].*" "\\1" included "${line}")
        if(included IN_LIST forbidden)
            list(APPEND complaints "${header} includes <${included}>, which no header may")
        endif()
        if(included MATCHES "^(hfh/)?([a-z_]+)\\.hpp$")
            set(other ${CMAKE_MATCH_2})
            list(FIND order ${other} other_place)
            if(NOT other_place LESS place)
                list(APPEND complaints "${header} includes ${other}.hpp, which does not stand before it")
            elseif(DEFINED only_${name} AND NOT other IN_LIST only_${name})
                list(APPEND complaints "${header} includes ${other}.hpp, but may include only: ${only_${name}}")
            endif()
        endif()
    endforeach()
endforeach()

if(complaints)
    list(JOIN complaints "\n  " complaints)
    message(FATAL_ERROR "\n  ${complaints}")
endif()
list(LENGTH headers count)
message(STATUS "${count} headers include downward only")
