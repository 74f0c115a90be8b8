#ifndef HFH_TRAVERSAL_BALL_SWEEP_HPP
#define HFH_TRAVERSAL_BALL_SWEEP_HPP

#include <hfh/traversal/ball_obstacles.hpp>

// Where a ball that moves along a segment touches the surface first. There is no closed form: the surface at a distance r from
// a bilinear patch is of high degree. The ball goes by what is surely clear.
//
// Based on: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems (1996), conservative advancement, by half-spaces.

namespace hfh {

enum class BallSweepStatus : unsigned char {
    touch,      ///< the ball touches the surface at t
    miss,       ///< it touches nothing up to the end
    overlap,    ///< it overlaps the surface where it begins
    work_limit, ///< after max_work cells and blocks; it touches nothing up to t
    bad_query ///< a coordinate is NaN, infinite, or `longest` or more in size; a radius that is not above 0 and finite
};
[[nodiscard]] constexpr const char* to_string(BallSweepStatus status) noexcept {
    switch (status) {
    case BallSweepStatus::touch: return "touch";
    case BallSweepStatus::miss: return "miss";
    case BallSweepStatus::overlap: return "overlap";
    case BallSweepStatus::work_limit: return "work_limit";
    case BallSweepStatus::bad_query: return "bad_query";
    }
    return "unknown";
}

template <Real T>
struct BallSweep {
    BallSweepStatus status = BallSweepStatus::miss;
    double t = 1;            ///< 0 to 1: how far along the segment the ball gets
    SurfacePoint<T> point{}; ///< touch: of the surface
    vec3<T> normal{0, 0, 1}; ///< touch: unit, from the point to the centre
    Index work = 0;          ///< cells and blocks looked at
};

/// The first place where a ball of `radius` touches the surface while its centre moves from `from` to `to` (world coordinates,
/// metres). It is met from either side, and its rims are wires.
///
/// At t a point of the surface is within radius·(1 ± 1e-9) of the centre, and no point comes nearer than radius·(1 − 1e-9)
/// before; a touch by less may be found or passed over. Computes in double. Does not throw and does not allocate.
template <HeightField Field>
[[nodiscard]] BallSweep<typename Field::Scalar> first_touch(const Field& field, const glm::dvec3& from,
                                                            const glm::dvec3& to, double radius,
                                                            Index max_work = 1'000'000) noexcept;

namespace detail {

/// How far a ball may go before the next look: of the order of what it takes to look around it.
template <HeightField Field>
[[nodiscard]] double widest_margin(const Field& field, double radius) noexcept {
    const glm::dvec2 spacing = field.lattice().spacing();
    return glm::max(radius / 2, glm::min(spacing.x, spacing.y) / 2);
}

} // namespace detail

template <HeightField Field>
BallSweep<typename Field::Scalar> first_touch(const Field& field, const glm::dvec3& from,
                                              const glm::dvec3& to, double radius, Index max_work) noexcept {
    using T = typename Field::Scalar;
    constexpr double touching = 1e-9; // of the radius
    BallSweep<T> result;
    const auto is_place = [](const glm::dvec3& p) {
        return is_height(p.x) && is_height(p.y) && is_height(p.z);
    };
    if (!is_place(from) || !is_place(to) || !(radius > 0) || !is_height(radius) || !field.lattice().valid()) {
        result.status = BallSweepStatus::bad_query;
        return result;
    }
    const glm::dvec3 way = to - from;
    const double length = glm::length(way), ends_at = touching * radius;
    detail::BallObstacles<Field> around{field};
    Index work = max_work;
    const auto end = [&](BallSweepStatus status, double t) {
        result.status = status;
        result.t = t;
        result.work = max_work - work;
        return result;
    };
    const auto look = [&](double t, double margin) {
        return around.look(from + t * way, radius, margin, work);
    };
    // The obstacle that is nearest, if the ball goes against it.
    const auto touch_at = [&](double t) {
        const detail::BallObstacle* nearest = nullptr;
        for (const auto& obstacle : around) {
            if (glm::dot(obstacle.normal, way) < 0 && obstacle.gap <= ends_at &&
                (!nearest || obstacle.gap < nearest->gap))
                nearest = &obstacle;
        }
        if (!nearest) return false;
        const auto& at = nearest->point;
        result.point = {at.cell, static_cast<T>(at.u), static_cast<T>(at.v)};
        result.normal = vec3<T>{nearest->normal};
        result.t = t;
        return true;
    };

    const double margin = detail::widest_margin(field, radius);
    double t = 0;
    if (!look(t, glm::min(margin, length))) return end(BallSweepStatus::work_limit, t);
    if (around.smallest_gap() < -ends_at) return end(BallSweepStatus::overlap, t);
    for (;;) {
        if (touch_at(t)) return end(BallSweepStatus::touch, t);
        if (!(t < 1)) return end(BallSweepStatus::miss, 1);
        double far = around.margin() / length;
        const glm::dvec3 ahead = glm::min(far, 1 - t) * way;
        double next = glm::min(1.0, t + around.clear_part(ahead, 0) * glm::min(far, 1 - t));
        if (!(next > t)) return end(BallSweepStatus::touch, t);
        if (!look(next, glm::min(margin, length))) return end(BallSweepStatus::work_limit, t);
        // A patch that is curved comes nearer than its plane told.
        double clear = t;
        for (int halving = 0; halving < 60 && around.smallest_gap() < -ends_at; ++halving) {
            const double middle = clear + (next - clear) / 2;
            if (!(middle > clear && middle < next)) break;
            if (!look(middle, glm::min(margin, length))) return end(BallSweepStatus::work_limit, t);
            if (around.smallest_gap() < -ends_at) {
                next = middle;
            } else {
                if (touch_at(middle)) return end(BallSweepStatus::touch, middle);
                clear = middle;
                if (!look(next, glm::min(margin, length))) return end(BallSweepStatus::work_limit, t);
            }
        }
        t = next;
    }
}

} // namespace hfh

#endif // HFH_TRAVERSAL_BALL_SWEEP_HPP
