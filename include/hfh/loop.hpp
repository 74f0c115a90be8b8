#ifndef HFH_LOOP_HPP
#define HFH_LOOP_HPP

// The whole update of a haptic device in one object.

#include <hfh/loop/any_haptic_loop.hpp>
#include <hfh/loop/haptic_loop.hpp>

#endif // HFH_LOOP_HPP
