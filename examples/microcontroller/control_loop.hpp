#ifndef HFH_EXAMPLE_CONTROL_LOOP_HPP
#define HFH_EXAMPLE_CONTROL_LOOP_HPP

#include "recorded_strokes.hpp"

#include <hfh/device/force_guard.hpp>
#include <hfh/hfh.hpp>

#include <concepts>
#include <cstdint>

// What firmware computes in an update: stylus → contact → force → guard, over ground in flash. HFH_SCALAR is what all of it
// is computed in, float or double.

namespace microcontroller {

using Scalar = HFH_SCALAR;
// Places are computed in Scalar too: the ground lies at the origin.
using Ground = hfh::BilinearGrid<Scalar, hfh::HeightView<std::int16_t>, Scalar>;

inline constexpr Ground felt_ground{hfh::HeightView{ground.data(), samples, samples},
                                    {.spacing = glm::dvec2{cell_size}, .height_scale = height_unit}};
static_assert(felt_ground.status() == hfh::GridStatus::ok);

[[nodiscard]] inline hfh::vec3<Scalar> stylus_at(const EncoderCounts& counts) noexcept {
    return Scalar(encoder_step) * hfh::vec3<Scalar>{counts.x, counts.y, counts.z};
}

/// The time of an update, so many milliseconds after the start.
template <hfh::Real T>
[[nodiscard]] constexpr hfh::DeviceTime<T> time_of(std::int32_t milliseconds) noexcept {
    if constexpr (std::same_as<T, double>)
        return 0.001 * milliseconds;
    else
        return {std::int64_t{1'000'000} * milliseconds};
}

/// What a control loop has, once a device.
class ControlLoop {
public:
    [[nodiscard]] hfh::Contact<Scalar> touch(const hfh::vec3<Scalar>& stylus) noexcept {
        return tracker_.update(stylus);
    }
    [[nodiscard]] hfh::vec3<Scalar> push_back(const hfh::Contact<Scalar>& contact) const noexcept {
        return force_(contact).newtons;
    }
    /// What the motors get at `milliseconds`. Not inlined, so that a clock before it and one behind it count all of it.
    [[nodiscard, gnu::noinline]] hfh::BasicGuardedForce<Scalar> guard(std::int32_t milliseconds,
                                                                      const hfh::vec3<Scalar>& stylus,
                                                                      const hfh::vec3<Scalar>& newtons,
                                                                      bool buried) noexcept {
        return guard_.update({.time = time_of<Scalar>(milliseconds), .position = stylus}, newtons, buried);
    }

private:
    hfh::ProxyTracker<Ground> tracker_{felt_ground, {.max_patches = 100, .max_contact_patches = 8}};
    hfh::ForceEvaluator<Scalar> force_{.stiffness = 500, .max_force = Scalar(3.3)};
    hfh::BasicForceGuard<Scalar> guard_;
};

} // namespace microcontroller

#endif // HFH_EXAMPLE_CONTROL_LOOP_HPP
