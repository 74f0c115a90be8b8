#include "control_loop.hpp"

#include <cstdint>

// What a device's maker would ship, and nothing else: the control loop between encoders and motors. It is linked and not
// run, to see how large it is: the registers are nobody's.

namespace {

struct Registers {
    std::int32_t milliseconds;
    std::int32_t x, y, z; ///< of the encoders
    float newtons[3];     ///< for the motors
};

volatile Registers& registers = *reinterpret_cast<volatile Registers*>(0x40000000);

} // namespace

int main() {
    microcontroller::ControlLoop loop;
    for (;;) {
        const auto stylus = microcontroller::stylus_at({registers.x, registers.y, registers.z});
        const auto contact = loop.touch(stylus);
        const auto guarded = loop.guard(registers.milliseconds, stylus, loop.push_back(contact),
                                        contact.status == hfh::ContactStatus::buried);
        for (int axis = 0; axis < 3; ++axis)
            registers.newtons[axis] = static_cast<float>(guarded.newtons[axis]);
    }
}
