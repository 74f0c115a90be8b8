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
/// before, but for the rounding of t; a touch by less may be found or passed over. Computes in double. Does not throw and does not allocate.
template <HeightField Field>
[[nodiscard]] BallSweep<typename Field::Scalar> first_touch(const Field& field, const glm::dvec3& from,
                                                            const glm::dvec3& to, double radius,
                                                            Index max_work = 1'000'000) noexcept;

namespace detail {

/// How far a ball may go before the next look: of the order of what it takes to look around it, and for a ball of about a cell
/// its radius.
template <HeightField Field>
[[nodiscard]] double widest_margin(const Field& field, double radius) noexcept {
    const glm::dvec2 spacing = field.lattice().spacing();
    const double cell = glm::min(spacing.x, spacing.y);
    return glm::max(radius / 2, glm::clamp(radius, cell / 2, cell));
}

/// A ball on a segment, and what is around it at t.
template <HeightField Field>
class SweptBall {
public:
    SweptBall(const Field& field, const glm::dvec3& from, const glm::dvec3& to, double radius,
              Index max_work) noexcept
        : from_{from}, way_{to - from}, radius_{radius}, least_margin_{glm::min(widest_margin(field, radius),
                                                                                glm::length(way_))},
          most_margin_{glm::max(least_margin_, longest_margin(field))}, margin_{least_margin_},
          work_{max_work}, around_{field} {}

    [[nodiscard]] Index work_left() const noexcept { return work_; }
    [[nodiscard]] double t() const noexcept { return t_; }
    [[nodiscard]] bool overlaps() const noexcept { return around_.smallest_gap() < -touching(); }
    /// False if that is too much work; t stays then. Where nothing is near, the next look goes twice as far.
    [[nodiscard]] bool look_at(double t) noexcept {
        if (!around_.look(from_ + t * way_, radius_, margin_, work_)) return false;
        t_ = t;
        margin_ = around_.size() == 0 ? glm::min(2 * margin_, most_margin_) : least_margin_;
        return true;
    }
    /// The nearest of the obstacles that the ball touches and goes against.
    [[nodiscard]] const BallObstacle* touched() const noexcept {
        const BallObstacle* nearest = nullptr;
        for (const BallObstacle& obstacle : around_) {
            const bool touches = obstacle.gap <= touching() && glm::dot(obstacle.normal, way_) < 0;
            if (touches && (!nearest || obstacle.gap < nearest->gap)) nearest = &obstacle;
        }
        return nearest;
    }
    /// Goes on to where the first of the half-spaces ends, or less far where a patch is bent towards the ball. False if that is too
    /// much work.
    [[nodiscard]] bool advance() noexcept {
        const double length = glm::length(way_), part = glm::min(around_.margin() / length, 1 - t_),
                     before = t_, distance_before = bent_distance();
        double next = glm::min(1.0, t_ + part * around_.clear_part(part * way_, 0));
        for (;;) {
            if (!look_at(next)) return false;
            if (!overlaps() && is_clear_between(distance_before, bent_distance(), (next - before) * length))
                return true;
            const double middle = before + (next - before) / 2;
            if (!(middle > before && middle < next)) return look_at(before);
            next = middle;
        }
    }
    /// Unit, from the point of an obstacle to the centre.
    [[nodiscard]] glm::dvec3 normal_at(const BallObstacle& touched) const noexcept {
        return around_.normal_at(from_ + t_ * way_, touched);
    }

private:
    /// And the rounding of t.
    [[nodiscard]] double touching() const noexcept {
        return 1e-9 * radius_ + 4 * epsilon<double> * glm::length(way_);
    }
    /// Of the patches that are bent from the centre.
    [[nodiscard]] double bent_distance() const noexcept { return radius_ + around_.smallest_bent_gap(); }
    /// Whether the ball stays clear of them on a way, by their distances at its ends. Along the way s, of length l, the square of
    /// the distance from a point is a parabola,
    ///
    ///     D(s)² = (1 − s/l) D(0)² + s/l D(l)² − s (l − s)
    ///
    /// so no point comes nearer than this with the least distances of all.
    [[nodiscard]] bool is_clear_between(double begin, double end, double length) const noexcept {
        const double nearest = radius_ - touching(), rise = end * end - begin * begin,
                     square = length * length;
        const double lowest = glm::clamp((square - rise) / 2, 0.0, square); // s·l
        return square == 0 || begin * begin - nearest * nearest >= lowest * (square - rise - lowest) / square;
    }

    glm::dvec3 from_, way_;
    double radius_, least_margin_, most_margin_, margin_, t_ = 0; // metres; t: 0 to 1
    Index work_;
    BallObstacles<Field> around_;
};

} // namespace detail

template <HeightField Field>
BallSweep<typename Field::Scalar> first_touch(const Field& field, const glm::dvec3& from,
                                              const glm::dvec3& to, double radius, Index max_work) noexcept {
    using T = typename Field::Scalar;
    BallSweep<T> result;
    const auto is_place = [](const glm::dvec3& p) {
        return is_height(p.x) && is_height(p.y) && is_height(p.z);
    };
    if (!is_place(from) || !is_place(to) || !(radius > 0) || !is_height(radius) || !field.lattice().valid()) {
        result.status = BallSweepStatus::bad_query;
        return result;
    }
    detail::SweptBall<Field> ball{field, from, to, radius, max_work};
    const auto end = [&](BallSweepStatus status) {
        result.status = status;
        result.t = ball.t();
        result.work = max_work - ball.work_left();
        return result;
    };
    if (!ball.look_at(0)) return end(BallSweepStatus::work_limit);
    if (ball.overlaps()) return end(BallSweepStatus::overlap);
    for (;;) {
        if (const auto* touched = ball.touched()) {
            const auto& at = touched->point;
            result.point = {at.cell, static_cast<T>(at.u), static_cast<T>(at.v)};
            result.normal = vec3<T>{ball.normal_at(*touched)};
            return end(BallSweepStatus::touch);
        }
        if (!(ball.t() < 1) || from == to) {
            result = end(BallSweepStatus::miss);
            result.t = 1;
            return result;
        }
        const double before = ball.t();
        if (!ball.advance()) return end(BallSweepStatus::work_limit);
        if (!(ball.t() > before)) return end(BallSweepStatus::touch); // as far as roundings tell
    }
}

} // namespace hfh

#endif // HFH_TRAVERSAL_BALL_SWEEP_HPP
