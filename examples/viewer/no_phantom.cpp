#include "real_device.hpp"

#include <bad_input.hpp>

namespace viewer {

std::unique_ptr<RealDevice> open_phantom() {
    throw demo::BadInput{
        "--device phantom is for a viewer that was built with the OpenHaptics SDK, and this one was "
        "not (CMake looks for it below OPENHAPTICS_ROOT)."};
}

} // namespace viewer
