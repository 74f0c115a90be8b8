#include "guard.hpp"

namespace microcontroller {

Guard::Guard() noexcept : guard_{{.max_force = 3.3}} {}

hfh::GuardedForce Guard::update(int milliseconds, const hfh::vec3<Scalar>& stylus,
                                const hfh::vec3<Scalar>& newtons, bool buried) noexcept {
    const hfh::DeviceSample sample{.time = 0.001 * milliseconds, .position = hfh::widen(stylus)};
    return guard_.update(sample, hfh::widen(newtons), buried);
}

} // namespace microcontroller
