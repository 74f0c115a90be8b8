#ifndef HFH_SIMULATION_HPP
#define HFH_SIMULATION_HPP

// A device for those who have none.

#include <hfh/simulation/driven_axis.hpp>
#include <hfh/simulation/encoders.hpp>
#include <hfh/simulation/end_stops.hpp>
#include <hfh/simulation/simulated_device.hpp>
#include <hfh/simulation/stick_slip_mass.hpp>

#endif // HFH_SIMULATION_HPP
