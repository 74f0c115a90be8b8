#ifndef HFH_DEVICE_HPP
#define HFH_DEVICE_HPP

// Between the library and the motors.

#include <hfh/device/device.hpp>
#include <hfh/device/force_guard.hpp>
#include <hfh/device/guard_limits.hpp>
#include <hfh/device/limit_cycle_filter.hpp>
#include <hfh/device/sample_check.hpp>
#include <hfh/device/triple_buffer.hpp>
#include <hfh/device/workspace.hpp>

#endif // HFH_DEVICE_HPP
