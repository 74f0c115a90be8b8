#ifndef HFH_CONTACT_BALL_LEVEL_CHANGE_HPP
#define HFH_CONTACT_BALL_LEVEL_CHANGE_HPP

#include <hfh/contact/ball_friction.hpp>
#include <hfh/contact/ball_glide.hpp>
#include <hfh/contact/ball_tracker.hpp>
#include <hfh/contact/level_change.hpp>

namespace hfh {

/// Sets the level of detail under a ball, as `change_level` does under a point: the result is how far, in metres, the ground
/// rose, and the stylus has to be moved by as much before its next update.
///
/// In contact that is the rise of the ground at the touch with the largest share, and the ball goes along. Where it is not
/// clear then, or no longer touches, the next update lifts or lowers it, as after an edit of the ground.
template <LeveledHeightField Levels, HeightField Field>
double change_level(Levels& levels, double level, BallTracker<Field>& tracker) noexcept;

/// The same with friction on the tracker's contact.
template <LeveledHeightField Levels, HeightField Field>
double change_level(Levels& levels, double level, BallTracker<Field>& tracker,
                    BallFriction<typename Field::Scalar>& friction) noexcept;

/// The same with friction and glide.
template <LeveledHeightField Levels, HeightField Field>
double change_level(Levels& levels, double level, BallTracker<Field>& tracker,
                    BallFriction<typename Field::Scalar>& friction,
                    BallGlide<typename Field::Scalar>& glide) noexcept;

template <LeveledHeightField Levels, HeightField Field>
double change_level(Levels& levels, double level, BallTracker<Field>& tracker) noexcept {
    auto state = tracker.state();
    if (state.phase == TrackerPhase::unseen) {
        levels.set_level(level);
        return 0;
    }
    const auto ground = [&] {
        return state.touching() ? detail::height_at(tracker.field(), state.foot)
                                : detail::height_over(tracker.field(), state.centre.x, state.centre.y);
    };
    const auto before = ground();
    const int k = levels.finer_level();
    levels.set_level(level);
    const int by = levels.finer_level() - k;
    state.foot = renumbered(state.foot, by);
    state.point.proxy = renumbered(state.point.proxy, by);
    const auto after = ground();
    const double rise = before && after ? *after - *before : 0;
    state.centre.z += rise;
    state.stylus.z += rise;
    state.point.stylus.z += rise;
    state.point.search_from.z += rise;
    tracker.restore(state);
    return rise;
}

template <LeveledHeightField Levels, HeightField Field>
double change_level(Levels& levels, double level, BallTracker<Field>& tracker,
                    BallFriction<typename Field::Scalar>& friction) noexcept {
    const int k = levels.finer_level();
    const double rise = change_level(levels, level, tracker);
    auto state = friction.state();
    state.centre.z += rise;
    state.point.anchor = renumbered(state.point.anchor, levels.finer_level() - k);
    friction.restore(state);
    return rise;
}

template <LeveledHeightField Levels, HeightField Field>
double change_level(Levels& levels, double level, BallTracker<Field>& tracker,
                    BallFriction<typename Field::Scalar>& friction,
                    BallGlide<typename Field::Scalar>& glide) noexcept {
    const int k = levels.finer_level();
    const double rise = change_level(levels, level, tracker, friction);
    auto state = glide.state();
    state.centre.z += rise;
    state.stylus.z += rise;
    state.point.proxy = renumbered(state.point.proxy, levels.finer_level() - k);
    glide.restore(state);
    return rise;
}

} // namespace hfh

#endif // HFH_CONTACT_BALL_LEVEL_CHANGE_HPP
