#ifndef PHANTOM_RECONNECT_HPP
#define PHANTOM_RECONNECT_HPP

#include <hfh/device/device.hpp>

namespace phantom {

/// Opens and runs a device, and does so again where its connection broke. `attempt()` is one opening and one run;
/// `wait()` passes the time between two of them; `goes_on()` tells whether another is wanted.
///
/// Once a connection has broken, a device that does not open, or opens and does not start, is tried again as well: it may
/// still be on its way back. One that is not there at the first attempt is not waited for, and all other ends are final.
/// Returns the end of the last attempt.
template <class Attempt, class Wait, class GoesOn>
hfh::DeviceEnd run_and_reconnect(Attempt&& attempt, Wait&& wait, GoesOn&& goes_on) {
    using hfh::DeviceEnd;
    DeviceEnd end = attempt();
    if (end != DeviceEnd::lost) return end;
    while ((end == DeviceEnd::lost || end == DeviceEnd::not_available) && goes_on()) {
        wait();
        if (goes_on()) end = attempt();
    }
    return end;
}

} // namespace phantom

#endif // PHANTOM_RECONNECT_HPP
