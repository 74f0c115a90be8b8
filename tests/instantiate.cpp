// Instantiates every template for every scalar and sample type, in a translation unit of its own: what is not inline
// enough shows at link time, what only compiles when unused shows here. Compiled without exceptions and without RTTI.

#include <hfh/contact/ball_friction.hpp>
#include <hfh/contact/ball_level_change.hpp>
#include <hfh/contact/ball_shading.hpp>
#include <hfh/contact/ball_tracker.hpp>
#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/contact/friction_cone.hpp>
#include <hfh/contact/level_change.hpp>
#include <hfh/device/force_guard.hpp>
#include <hfh/device/limit_cycle_filter.hpp>
#include <hfh/device/triple_buffer.hpp>
#include <hfh/device/workspace.hpp>
#include <hfh/force/damping.hpp>
#include <hfh/force/energy_tank.hpp>
#include <hfh/force/passivity_observer.hpp>
#include <hfh/force/virtual_coupling.hpp>
#include <hfh/hfh.hpp>
#include <hfh/loop/any_haptic_loop.hpp>
#include <hfh/loop/ball_tip.hpp>
#include <hfh/loop/haptic_loop.hpp>
#include <hfh/simulation/driven_axis.hpp>
#include <hfh/simulation/end_stops.hpp>
#include <hfh/simulation/simulated_device.hpp>
#include <hfh/terrain/blended_field.hpp>
#include <hfh/terrain/bridged_field.hpp>
#include <hfh/terrain/extended_field.hpp>
#include <hfh/terrain/min_max_pyramid.hpp>
#include <hfh/traversal/local_closest_points.hpp>
#include <hfh/traversal/nearest_point.hpp>
#include <hfh/traversal/surface_at.hpp>

#include <cstdint>

namespace hfh {

template struct BilinearPatch<float>;
template struct BilinearPatch<double>;
template struct CellPoint<float>;
template struct CellPoint<double>;
template struct SurfacePoint<float>;
template struct SurfacePoint<double>;
template struct Contact<float>;
template struct Contact<double>;
template struct ForceEvaluator<float>;
template struct ForceEvaluator<double>;
template struct Damping<float>;
template struct Damping<double>;
template struct FrictionCone<float>;
template struct FrictionCone<double>;
template class Friction<float>;
template class Friction<double>;
template class BallFriction<float>;
template class BallFriction<double>;
template class VelocityFilter<float>;
template class VelocityFilter<double>;
template struct NewtonResult<float>;
template struct NewtonResult<double>;
template struct DistanceFunction<float>;
template struct DistanceFunction<double>;
template struct DescentResult<float>;
template struct DescentResult<double>;
template struct NearestPoint<float>;
template struct NearestPoint<double>;
template struct LocalClosestPoint<float>;
template struct LocalClosestPoint<double>;
template struct FirstHit<float>;
template struct FirstHit<double>;
template struct TrackerState<float>;
template struct TrackerState<double>;
template class Workspace<float>;
template class Workspace<double>;
template class Workspace<float, float>;
template class BasicForceGuard<float>;
template class TripleBuffer<TrackerState<float>>;
template class TripleBuffer<DeviceSample>;

#define HFH_TEST_INSTANTIATE(S)                                                                              \
    template class HeightView<S>;                                                                            \
    template class HeightView<S, MissingValue<S>>;                                                           \
    template class BilinearGrid<float, HeightView<S>>;                                                       \
    template class BilinearGrid<double, HeightView<S>>;                                                      \
    template class BilinearGrid<float, HeightView<S, MissingValue<S>>>;                                      \
    template class BilinearGrid<double, HeightView<S, MissingValue<S>>>;                                     \
    template class ExtendedField<BilinearGrid<float, HeightView<S>>>;                                        \
    template class ExtendedField<BilinearGrid<double, HeightView<S>>>;                                       \
    template class BridgedField<BilinearGrid<float, HeightView<S>>>;                                         \
    template class BridgedField<BilinearGrid<double, HeightView<S>>>;                                        \
    template class ProxyTracker<BilinearGrid<float, HeightView<S>>>;                                         \
    template class ProxyTracker<BilinearGrid<double, HeightView<S>>>;                                        \
    template class ProxyTracker<BilinearGrid<float, HeightView<S, MissingValue<S>>>>;                        \
    template class ProxyTracker<BilinearGrid<double, HeightView<S, MissingValue<S>>>>;                       \
    template class HapticLoop<BilinearGrid<float, HeightView<S>>>;                                           \
    template class FieldLoop<BilinearGrid<double, HeightView<S, MissingValue<S>>>>;                          \
    template struct SampleRange<S>;                                                                          \
    template class MinMaxPyramid<S>;                                                                         \
    template class BoundedGrid<float, HeightView<S>>;                                                        \
    template class BoundedGrid<double, HeightView<S, MissingValue<S>>>;                                      \
    template class ProxyTracker<BoundedGrid<float, HeightView<S>>>;                                          \
    template class ProxyTracker<BoundedGrid<double, HeightView<S, MissingValue<S>>>>;                        \
    template class StridedLevels<HeightView<S>>;                                                             \
    template class OverviewLevels<HeightView<S, MissingValue<S>>>;                                           \
    template class BlendedField<float, StridedLevels<HeightView<S>>>;                                        \
    template class BlendedField<double, OverviewLevels<HeightView<S, MissingValue<S>>>>;                     \
    template class BoundedBlendedField<double, HeightView<S>>;                                               \
    template class ProxyTracker<BlendedField<float, StridedLevels<HeightView<S>>>>;                          \
    template class ProxyTracker<BoundedBlendedField<double, HeightView<S>>>;

HFH_TEST_INSTANTIATE(std::uint8_t)
HFH_TEST_INSTANTIATE(std::uint16_t)
HFH_TEST_INSTANTIATE(std::int16_t)
HFH_TEST_INSTANTIATE(std::int32_t)
HFH_TEST_INSTANTIATE(float)
HFH_TEST_INSTANTIATE(double)

#undef HFH_TEST_INSTANTIATE

template class BallTracker<BilinearGrid<float, HeightView<std::int16_t>>>;
template class FieldLoop<BilinearGrid<double, HeightView<float>>, BallTip>;

namespace {

/// A hand that keeps still.
struct Still {
    glm::dvec3 operator()(double) const noexcept { return glm::dvec3{0.0}; }
};

} // namespace

template struct EndStops<StickSlipMass>;
template struct EndStops<DrivenAxis>;
template class SimulatedDevice<Still>;
template class SimulatedDevice<Still, OwnAxes<EndStops<DrivenAxis>>, JointEncoders>;

namespace {

/// The simulated device's steps kept steady, a spring and its damper, and through the tank back to it.
[[maybe_unused]] bool use_device() {
    SimulatedDevice device{simulated_touch, {}, Still{}, 0.01};
    EnergyTank tank;
    LimitCycleFilter steady{simulated_touch.capabilities.resolution};
    VirtualCoupling coupling{{.stiffness = 500}};
    PassivityObserver observer{simulated_touch.capabilities.resolution};
    return device.run([&](const DeviceSample& sample) -> DeviceCommand {
        const auto coupled = coupling(sample.position, -500.0 * steady(sample.position));
        const auto sent = tank(sample.position, coupled.newtons);
        observer.update(sample.position, sent.newtons);
        return {.newtons = sent.newtons, .go_on = observer.owed() < 1};
    }) == DeviceEnd::stopped;
}

/// Calls the function templates and what deduction guides are for.
template <Real T, Sample S>
[[maybe_unused]] bool use(const S* samples) {
    const HeightView heights{samples, 4, 4};
    const HeightView strided{samples, 2, 2, 2, 8};
    const HeightView holed{samples, 4, 4, MissingValue{samples[0]}};
    const BilinearGrid<T, HeightView<S>> grid{heights.flipped_rows(), {.spacing = {2, 3}}};
    const BilinearGrid<T, decltype(holed)> holed_grid{holed, {}};
    SampleRange<S> range;
    BoundedGrid bounded{grid, &range, 1};
    ProxyTracker bounded_tracker{bounded};
    ProxyTracker tracker{grid};
    ProxyTracker holed_tracker{holed_grid, {.surface = SurfaceKind::sheet}};
    const ForceEvaluator<T> force{};
    Index seen = strided.columns();
    walk_cells(grid.lattice(), grid.cells(), {0, 0}, {3, 3}, [&](const CellSpan&) { return ++seen < 9; });
    walk_candidates(grid, vec3<T>{0, 0, 0}, vec3<T>{3, 3, 0},
                    [&](const CellSpan&, const BilinearPatch<T>&) { return ++seen < 9; });
    const auto hit = first_hit(grid, {0, 0, 300}, {3, 3, -300});
    const auto foot = newton_closest_point(BilinearPatch<T>{}, CellPoint<T>{}, vec2<T>{T(0)});
    const auto nearest = global_closest_point(BilinearPatch<T>{}, CellPoint<T>{});
    const auto under = surface_at(holed_grid, vec2<T>{1, 1});
    const auto of_all = nearest_point(bounded, vec3<T>{1, 1, 0});
    const auto near = collect_local_closest_points(grid, vec3<T>{1, 1, 0}, T(1), {});
    const auto end = descend(grid, vec3<T>{1, 1, 0}, SurfacePoint<T>{}, 64);
    const auto contact = tracker.update({T(1), T(1), T(300)});
    const ExtendedField level{holed_grid};
    BallTracker level_tracker{level, T(1)};
    const vec3<T> stylus{T(1), T(1), T(1)};
    BallFriction<T> friction{};
    const auto shaded = friction.hold(level, shade_force(level, level_tracker.update(stylus)), stylus);
    const auto damped = Damping<T>{}(force, shaded, VelocityFilter<T>{}.update(shaded.proxy, T(1)));
    return seen > 0 && is_finite(damped.newtons) && hit.cells > 0 && foot.iterations + end.patches > 0 &&
           nearest.u >= 0 && under && of_all.signed_distance() && near.count == 0 &&
           is_finite(force(contact).newtons) && bounded.build() == PyramidStatus::ok &&
           bounded.update({{1, 1}, {2, 2}}) == PyramidStatus::ok &&
           bounded.block_range(0, {0, 0}, {0, 0}).lowest < 300 &&
           bounded_tracker.update({T(1), T(1), T(300)}).depth >= 0 &&
           holed_tracker.update({T(1), T(1), T(300)}).depth >= 0 && to_string(contact.status) != nullptr;
}

} // namespace

/// Called by nobody; refers to every instance.
bool use_everything(const std::uint8_t* a, const std::uint16_t* b, const std::int16_t* c,
                    const std::int32_t* d, const float* e, const double* f);
bool use_everything(const std::uint8_t* a, const std::uint16_t* b, const std::int16_t* c,
                    const std::int32_t* d, const float* e, const double* f) {
    return use<float>(a) && use<double>(a) && use<float>(b) && use<double>(b) && use<float>(c) &&
           use<double>(c) && use<float>(d) && use<double>(d) && use<float>(e) && use<double>(e) &&
           use<float>(f) && use<double>(f) && use_device();
}

} // namespace hfh
