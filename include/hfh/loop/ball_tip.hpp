#ifndef HFH_LOOP_BALL_TIP_HPP
#define HFH_LOOP_BALL_TIP_HPP

#include <hfh/contact/ball_friction.hpp>
#include <hfh/contact/ball_glide.hpp>
#include <hfh/contact/ball_shading.hpp>
#include <hfh/contact/ball_tracker.hpp>
#include <hfh/loop/haptic_loop.hpp>

namespace hfh {

/// A ball touches the ground in a `HapticLoop`:
///
///     hfh::HapticLoop<Grid, hfh::BallTip> loop{grid, options};
///     loop.tracker().set_radius(0.5); // metres of terrain; between updates, in contact as well
///
/// With the radius 0, which it begins with, it is the loop with a point, to the bit. A zoom that is to keep the ball's size in
/// the hand sets radius = size in the hand × scale of the workspace.
struct BallTip {
    template <HeightField Field>
    using Tracker = BallTracker<Field>;
    template <Real T>
    using Friction = BallFriction<T>;
    template <Real T>
    using Glide = BallGlide<T>;
    template <Real T>
    using Contact = BallContact<T>;
};

} // namespace hfh

#endif // HFH_LOOP_BALL_TIP_HPP
