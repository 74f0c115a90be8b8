#ifndef HFH_FORCE_HPP
#define HFH_FORCE_HPP

// From a contact to newtons, and what keeps them passive.

#include <hfh/force/damping.hpp>
#include <hfh/force/energy_tank.hpp>
#include <hfh/force/force_evaluator.hpp>
#include <hfh/force/passivity_observer.hpp>
#include <hfh/force/virtual_coupling.hpp>

#endif // HFH_FORCE_HPP
