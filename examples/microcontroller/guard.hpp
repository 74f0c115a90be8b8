#ifndef HFH_EXAMPLE_GUARD_HPP
#define HFH_EXAMPLE_GUARD_HPP

#include <hfh/device/force_guard.hpp>

// The guard between force and motors. Times and positions of devices are in double; so it has a file of its own, and the
// rest of a firmware in float has no double.

namespace microcontroller {

using Scalar = HFH_SCALAR;

class Guard {
public:
    Guard() noexcept;

    /// What the motors get at `milliseconds`.
    [[nodiscard]] hfh::GuardedForce update(int milliseconds, const hfh::vec3<Scalar>& stylus,
                                           const hfh::vec3<Scalar>& newtons, bool buried) noexcept;

private:
    hfh::ForceGuard guard_;
};

} // namespace microcontroller

#endif // HFH_EXAMPLE_GUARD_HPP
