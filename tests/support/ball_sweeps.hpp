#ifndef HFH_TESTS_SUPPORT_BALL_SWEEPS_HPP
#define HFH_TESTS_SUPPORT_BALL_SWEEPS_HPP

#include "ball_strokes.hpp"
#include "nearest_judge.hpp"

#include <hfh/contact/ball_tracker.hpp>

// Balls that move along a segment over a terrain, from everywhere and in all directions, and where each of them touches first.

namespace hfh::test {

/// A ball on a segment, in metres.
struct MovingBall {
    glm::dvec3 from{0.0}, to{0.0};
    double radius = 1;

    [[nodiscard]] std::string told() const {
        return "r " + digits(radius) + ", " + digits(from) + " -> " + digits(to);
    }
};

[[nodiscard]] inline glm::dvec3 any_direction(Random& random) {
    const double angle = random.between(0, 6.283185307179586), up = random.between(-1, 1),
                 flat = std::sqrt(1 - up * up);
    return {flat * std::cos(angle), flat * std::sin(angle), up};
}

/// Radii of 0.1 to 5 cells and ways of 0.1 to 100, a third of them from where the ball touches or almost does, over vertices,
/// grid lines, rims and holes; in any direction, along an axis, or towards a place at the surface. May begin in the surface.
template <Real T>
[[nodiscard]] MovingBall moving_ball(Random& random, const BallSurface<T>& surface) {
    const double cell = static_cast<double>(surface.cell());
    MovingBall ball;
    ball.radius = cell * log_between(random, 0.1, 5);
    const auto place = [&](double farthest) { // cells from the surface
        return glm::dvec3{nearest_query(random, surface.terrain(), farthest)};
    };
    ball.from = place(100);
    if (random.one_in(3)) {
        ball.from = place(5);
        const Point centre = wide(vec3<double>{ball.from});
        const auto foot = surface.nearest(centre, static_cast<Wide>(10 * cell));
        if (foot && foot->distance > 0) {
            const double gap = random.one_in(3) ? 0 : log_between(random, 1e-12, 1e-2);
            const Point moved =
                centre + (static_cast<Wide>(ball.radius * (1 + gap)) - foot->distance) * foot->normal();
            ball.from = {static_cast<double>(moved.x), static_cast<double>(moved.y),
                         static_cast<double>(moved.z)};
        }
    }
    const double length = cell * log_between(random, 0.1, 100);
    glm::dvec3 way = any_direction(random);
    switch (random.whole(0, 5)) {
    case 0: way = {0, 0, way.z < 0 ? -1 : 1}; break;
    case 1:
        way = random.one_in(2) ? glm::dvec3{way.x < 0 ? -1 : 1, 0, 0} : glm::dvec3{0, way.y < 0 ? -1 : 1, 0};
        break;
    case 2:
    case 3: way = glm::normalize(place(1) + ball.radius * way - ball.from); break;
    default: break;
    }
    ball.to = ball.from + length * way;
    return ball;
}

/// What is wrong with the first touch that the library finds for a ball; empty if nothing is.
struct MovingBallVerdict {
    std::string fault;
    bool touches = false;
    bool unclear = false; ///< glides along the surface for too long to tell, or begins within roundings of it
    bool in_surface = false; ///< begins there: no question
};

template <Real T>
[[nodiscard]] MovingBallVerdict judge_moving_ball(const BallSurface<T>& surface, const MovingBall& ball) {
    const auto grid = surface.terrain().grid();
    const auto found = first_touch(grid, ball.from, ball.to, ball.radius);
    const Point from = wide(vec3<double>{ball.from}), to = wide(vec3<double>{ball.to});
    const Wide r = static_cast<Wide>(ball.radius);
    const Wide roundings = 4 * static_cast<Wide>(epsilon<double>) *
                           std::max({largest_coordinate(from), largest_coordinate(to), length(to - from)});
    MovingBallVerdict verdict;
    const Wide gap = surface.distance(from, 2 * r) - r;
    if (std::abs(gap + 1e-9L * r) <= 2 * roundings) {
        verdict.unclear = true;
        return verdict;
    }
    verdict.in_surface = gap < -1e-9L * r;
    if (found.status == BallSweepStatus::overlap || verdict.in_surface) {
        if ((found.status == BallSweepStatus::overlap) != verdict.in_surface)
            verdict.fault = verdict.in_surface ? "begins in the surface, and is not told so"
                                               : "told to begin in the surface";
        return verdict;
    }
    verdict.touches = found.status == BallSweepStatus::touch;
    if (found.status == BallSweepStatus::bad_query) verdict.fault = "refused";
    // As far as it got. Where the ball glides along what is bent it may take too long, as it does to tell.
    if (found.status == BallSweepStatus::work_limit) {
        verdict.unclear = judge_first_touch(surface, from, to, r, {}) == SweepVerdict::unclear;
        if (!verdict.unclear) verdict.fault = "took too long";
    }
    if (!verdict.fault.empty() || verdict.unclear) return verdict;
    switch (judge_first_touch(surface, from, to, r,
                              verdict.touches ? std::optional{static_cast<Wide>(found.t)} : std::nullopt)) {
    case SweepVerdict::right: break;
    case SweepVerdict::starts_in_the_surface:
    case SweepVerdict::unclear: verdict.unclear = true; break;
    case SweepVerdict::nearer_before: verdict.fault = "late: it has been nearer before"; break;
    case SweepVerdict::nothing_there: verdict.fault = "early: nothing is there"; break;
    }
    if (!verdict.touches || !verdict.fault.empty()) return verdict;
    // The point that is touched.
    const WideSurfacePoint at = wide(found.point);
    const auto patch = surface.surface().patch(at.i, at.j);
    if (!patch || !(0 <= at.u && at.u <= 1 && 0 <= at.v && at.v <= 1)) {
        verdict.fault = "touches off the surface";
        return verdict;
    }
    const Wide moved =
        2 * static_cast<Wide>(epsilon<T>) * (patch->dx + patch->dy + patch->highest() - patch->lowest());
    const Point centre = from + static_cast<Wide>(found.t) * (to - from);
    const Point arm = surface.surface().seen_from(centre, at.i, at.j) - patch->position(at.u, at.v);
    if (std::abs(length(arm) - r) > 1e-8L * r + 2 * roundings + moved)
        verdict.fault = "touches a point that is not at r";
    else if (length(r * wide(found.normal) - arm) >
             1e-8L * r + 2 * roundings + 2 * moved + 4 * static_cast<Wide>(epsilon<T>) * r)
        verdict.fault = "the normal does not come from the point";
    return verdict;
}

/// What is wrong where a tracker's ball, free, moves along the segment; empty if nothing is. Nothing is asked where it is not
/// free at first.
template <Real T>
[[nodiscard]] std::string judge_free_motion(const std::string& name, const Terrain<T>& terrain,
                                            const MovingBall& ball, SurfaceKind kind) {
    const auto grid = terrain.grid();
    const auto radius = static_cast<T>(ball.radius);
    BallTracker<std::remove_const_t<decltype(grid)>> tracker{grid, radius, {.surface = kind}};
    FollowedBall<T, decltype(tracker)> followed{terrain, {name, radius, kind, {}}, tracker};
    const auto first = followed.update(vec3<T>{ball.from}, {});
    if (!first.replay.empty() || first.found.status != ContactStatus::free) return first.replay;
    return followed.update(vec3<T>{ball.to}, {.flow = false, .sweep = true}).replay;
}

/// What came of many moving balls.
struct MovingBallTally {
    long balls = 0, touches = 0, unclear = 0, faults = 0;
    std::vector<std::string> examples{}; ///< the first few faults
};

/// So many moving balls on one terrain, none of which begins in the surface; each also as a tracker's, on a solid or a sheet.
template <Real T>
void move_balls(const std::string& name, const Terrain<T>& terrain, long count, std::uint64_t seed,
                MovingBallTally& tally) {
    Random random{seed};
    const BallSurface<T> surface{terrain};
    const auto fault = [&](const std::string& told) {
        if (++tally.faults <= 3) tally.examples.push_back(name + ": " + told);
    };
    // A ball that begins in the surface does not count, but ends the count on ground that leaves no place.
    for (long n = 0, tries = 0; n < count && tries < 100 * count; ++tries) {
        const auto ball = moving_ball(random, surface);
        const auto verdict = judge_moving_ball(surface, ball);
        if (!verdict.fault.empty()) fault(verdict.fault + ", " + ball.told());
        if (verdict.in_surface) continue;
        ++n, ++tally.balls;
        tally.touches += verdict.touches;
        tally.unclear += verdict.unclear;
        const auto kind = random.one_in(3) ? SurfaceKind::sheet : SurfaceKind::solid;
        const std::string told = judge_free_motion(name, terrain, ball, kind);
        if (!told.empty()) fault(told);
    }
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_BALL_SWEEPS_HPP
