#ifndef HFH_CONTACT_LEVEL_CHANGE_HPP
#define HFH_CONTACT_LEVEL_CHANGE_HPP

#include <hfh/contact/friction.hpp>
#include <hfh/contact/proxy_glide.hpp>
#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/geometry/surface_point.hpp>
#include <hfh/terrain/height_field.hpp>
#include <hfh/traversal/surface_at.hpp>

#include <cmath>

// Touch goes on while the level of detail changes.

namespace hfh {

/// A point of the surface in the cells of the level that is `by` levels coarser (below 0: finer), where it is in the same
/// place in plan. Going finer is exact, going coarser rounds u and v.
template <Real T>
[[nodiscard]] constexpr SurfacePoint<T> renumbered(const SurfacePoint<T>& point, int by) noexcept;

/// Sets the level of detail under a stylus, and what the tracker remembers goes along. To be called between updates, every
/// millisecond or seldom, with any change of the level:
///
///     const double rise = change_level(ground, level, tracker, friction);
///     workspace.move({0, 0, rise});                                      // before the next position
///
/// In contact the proxy keeps its place in plan and gets the height that the ground has there now. Free, the stylus keeps its
/// height over the ground. Either way the result is how far, in metres, the ground rose there, and the stylus has to be
/// moved by as much. Where there is no ground before or after, that is 0.
///
/// Across a whole number the level has another lattice. Then the proxy's cell and its (u, v) are renumbered, and so is
/// friction's anchor. A contact whose proxy is no longer on the ground (a hole or a cut-off rim of the coarser level) ends
/// at the next update, as one that slides off a rim.
///
/// `levels` is the field whose level is set. The tracker's field is that or one that wraps it. Does not throw, does not
/// allocate; looks at one patch before and one after.
template <LeveledHeightField Levels, HeightField Field>
double change_level(Levels& levels, double level, ProxyTracker<Field>& tracker) noexcept;

/// The same with friction on the tracker's contact.
template <LeveledHeightField Levels, HeightField Field>
double change_level(Levels& levels, double level, ProxyTracker<Field>& tracker,
                    Friction<typename Field::Scalar>& friction) noexcept;

/// The same with friction and glide.
template <LeveledHeightField Levels, HeightField Field>
double change_level(Levels& levels, double level, ProxyTracker<Field>& tracker,
                    Friction<typename Field::Scalar>& friction,
                    ProxyGlide<typename Field::Scalar>& glide) noexcept;

namespace detail {

/// One of u and v, and the cell's number along it.
template <Real T>
constexpr void renumber(Index& cell, T& u, int by) noexcept {
    if (by > 0) {
        const Index width = Index{1} << by, coarser = cell >> by;
        u = static_cast<T>((static_cast<double>(cell - coarser * width) + widen(u)) /
                           static_cast<double>(width));
        cell = coarser;
    } else if (by < 0) {
        const Index width = Index{1} << -by;
        const T within = u * static_cast<T>(width);
        const Index whole = std::min(static_cast<Index>(within), width - 1);
        u = within - static_cast<T>(whole);
        cell = cell * width + whole;
    }
}

} // namespace detail

template <Real T>
constexpr SurfacePoint<T> renumbered(const SurfacePoint<T>& point, int by) noexcept {
    SurfacePoint<T> result = point;
    detail::renumber(result.cell.i, result.u, by);
    detail::renumber(result.cell.j, result.v, by);
    return result;
}

template <LeveledHeightField Levels, HeightField Field>
double change_level(Levels& levels, double level, ProxyTracker<Field>& tracker) noexcept {
    auto state = tracker.state();
    const auto ground = [&] {
        return state.touching()
                   ? detail::height_at(tracker.field(), state.proxy)
                   : detail::height_over(tracker.field(), state.swept_to().x, state.swept_to().y);
    };
    if (state.phase == TrackerPhase::unseen) {
        levels.set_level(level);
        return 0;
    }
    const auto before = ground();
    const int k = levels.finer_level();
    levels.set_level(level);
    state.proxy = renumbered(state.proxy, levels.finer_level() - k);
    const auto after = ground();
    const double rise = before && after ? *after - *before : 0;
    state.stylus.z += rise;
    state.search_from.z += rise;
    tracker.restore(state);
    return rise;
}

template <LeveledHeightField Levels, HeightField Field>
double change_level(Levels& levels, double level, ProxyTracker<Field>& tracker,
                    Friction<typename Field::Scalar>& friction) noexcept {
    const int k = levels.finer_level();
    const double rise = change_level(levels, level, tracker);
    auto state = friction.state();
    state.anchor = renumbered(state.anchor, levels.finer_level() - k);
    friction.restore(state);
    return rise;
}

template <LeveledHeightField Levels, HeightField Field>
double change_level(Levels& levels, double level, ProxyTracker<Field>& tracker,
                    Friction<typename Field::Scalar>& friction,
                    ProxyGlide<typename Field::Scalar>& glide) noexcept {
    const int k = levels.finer_level();
    const double rise = change_level(levels, level, tracker, friction);
    auto state = glide.state();
    state.proxy = renumbered(state.proxy, levels.finer_level() - k);
    glide.restore(state);
    return rise;
}

} // namespace hfh

#endif // HFH_CONTACT_LEVEL_CHANGE_HPP
