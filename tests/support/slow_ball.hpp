#ifndef HFH_TESTS_SUPPORT_SLOW_BALL_HPP
#define HFH_TESTS_SUPPORT_SLOW_BALL_HPP

#include "ball_judge.hpp"

// A ball that goes where a ball should, slowly: the gradient flow of its centre, in long double.

namespace hfh::test {

/// Where a flow has come to.
enum class FlowEnd : unsigned char {
    arrived, ///< at the stylus: the ball is free
    minimum, ///< held by what it touches
    rim,     ///< on a solid, held by rims alone, and they would hold it from above
    stuck    ///< too many steps, or between walls
};

struct Flow {
    FlowEnd end = FlowEnd::stuck;
    Point centre;
    int steps = 0;
};

/// The gradient flow of a ball's centre, in explicit steps of at most `longest`. Each step goes along F = stylus − centre as far as
/// the half-spaces of all that is near let it, is pushed clear, and is halved until the distance to the stylus falls.
template <Real T>
class BallFlow {
public:
    BallFlow(const BallSurface<T>& ground, const Point& stylus, Wide radius, SurfaceKind kind, Wide longest)
        : ground_{&ground}, stylus_{stylus}, radius_{radius}, kind_{kind}, longest_{longest},
          tiny_{1e-13L * (radius + largest_coordinate(stylus))} {}

    /// From a centre that is clear. Ends where what is left of F is 10⁻⁸ of it, or shorter than roundings.
    [[nodiscard]] Flow operator()(const Point& start, int max_steps) {
        Flow flow{FlowEnd::stuck, start, 0};
        for (; flow.steps < max_steps; ++flow.steps) {
            const Point force = stylus_ - flow.centre;
            const Wide depth = length(force);
            if (depth <= tiny_) {
                flow.end = FlowEnd::arrived;
                return flow;
            }
            look(flow.centre, force);
            const auto along = nearest_in(touching_, force);
            if (!along) return flow;
            if (kind_ == SurfaceKind::solid && rims_alone_ && along->count > 0 && force.z > 0) {
                flow.end = FlowEnd::rim;
                return flow;
            }
            const Wide left = length(along->at);
            if (left <= 1e-8L * depth + tiny_) {
                flow.end = FlowEnd::minimum;
                return flow;
            }
            if (!step(flow.centre)) {
                // Nothing falls by more than roundings.
                if (left <= 1e-5L * depth + 100 * tiny_) flow.end = FlowEnd::minimum;
                return flow;
            }
        }
        return flow;
    }

private:
    /// What is near, what touches, and whether all that pulls is a rim.
    void look(const Point& centre, const Point& force) {
        near_.clear();
        touching_.clear();
        rims_alone_ = true;
        for (const BallFoot& foot : ground_->feet(centre, radius_ + 2 * longest_)) {
            near_.push_back({foot.normal(), radius_ - foot.distance});
            if (foot.distance > radius_ * (1 + 1e-10L) + tiny_) continue;
            touching_.push_back({foot.normal(), 0});
            if (dot(foot.normal(), force) < 0 && !ground_->on_rim(foot.at)) rims_alone_ = false;
        }
    }
    /// One step; false if no part of it leads nearer.
    [[nodiscard]] bool step(Point& centre) {
        const Point force = stylus_ - centre;
        for (part_ = std::min(part_ * 2, Wide(1)); part_ > 1e-12L; part_ /= 2) {
            auto way = nearest_in(near_, part_ * force);
            if (!way) return false;
            if (const Wide far = length(way->at); far > longest_) {
                part_ *= longest_ / far;
                way = nearest_in(near_, part_ * force);
                if (!way) return false;
                if (length(way->at) > 1.01L * longest_) continue;
            }
            const auto to = ground_->pushed_clear(centre + way->at, radius_);
            if (!to || !(length(*to - stylus_) < length(force))) continue;
            centre = *to;
            return true;
        }
        return false;
    }

    const BallSurface<T>* ground_;
    Point stylus_;
    Wide radius_;
    SurfaceKind kind_;
    Wide longest_; ///< step
    Wide tiny_;
    Wide part_ = 0.5L; ///< of F in a step
    std::vector<HalfSpace> near_, touching_;
    bool rims_alone_ = true;
};
template <Real T>
[[nodiscard]] Flow flow_of_ball(const BallSurface<T>& ground, const Point& centre, const Point& stylus,
                                Wide radius, SurfaceKind kind, int max_steps = 20000,
                                int steps_per_radius = 50) {
    return BallFlow<T>{ground, stylus, radius, kind, radius / steps_per_radius}(centre, max_steps);
}

/// Whether two places of the centre lie in one basin of the distance to the stylus: near each other, or on the way from the
/// farther one to the nearer one, pushed clear, the distance does not rise.
template <Real T>
[[nodiscard]] bool in_one_basin(const BallSurface<T>& ground, const Point& one, const Point& other,
                                const Point& stylus, Wide radius) {
    if (length(one - other) < 0.02L * radius) return true;
    const Wide to_one = length(one - stylus), to_other = length(other - stylus);
    const Point& far = to_one > to_other ? one : other;
    const Point& near = to_one > to_other ? other : one;
    const Wide top = std::max(to_one, to_other) + 1e-6L * radius;
    for (int k = 1; k < 128; ++k) {
        const auto place = ground.pushed_clear(far + static_cast<Wide>(k) / 128 * (near - far), radius);
        if (!place || length(*place - stylus) > top) return false;
    }
    return true;
}

/// A tracker by that flow. Begins clear of the surface, or is buried until it is.
template <Real T>
class SlowBall {
public:
    SlowBall(const Terrain<T>& terrain, Wide radius, SurfaceKind kind = SurfaceKind::solid)
        : ground_{terrain}, radius_{radius}, kind_{kind} {}

    [[nodiscard]] BallContact<T> update(const vec3<T>& stylus) {
        const Point to = wide(stylus);
        BallContact<T> found;
        found.proxy = stylus;
        if (!centre_) {
            const auto height = ground_.surface().height(to.x, to.y);
            const bool below = kind_ == SurfaceKind::solid && height && to.z < *height;
            if (below || ground_.distance(to, radius_) < radius_) {
                found.status = ContactStatus::buried;
                return found;
            }
            centre_ = to;
            return found;
        }
        const Flow flow = flow_of_ball(ground_, *centre_, to, radius_, kind_);
        if (flow.end == FlowEnd::rim) {
            centre_.reset();
            found.status = ContactStatus::left_at_hole;
            return found;
        }
        centre_ = flow.centre;
        if (flow.end == FlowEnd::arrived) {
            centre_ = to;
            return found;
        }
        return contact(stylus, flow);
    }

private:
    [[nodiscard]] BallContact<T> contact(const vec3<T>& stylus, const Flow& flow) const {
        BallContact<T> found;
        const Point offset = flow.centre - wide(stylus);
        const auto narrow = [](const Point& p) {
            return vec3<T>{static_cast<T>(p.x), static_cast<T>(p.y), static_cast<T>(p.z)};
        };
        const Wide depth = length(offset);
        found.status = flow.end == FlowEnd::minimum ? ContactStatus::contact : ContactStatus::descent_limit;
        const auto height = ground_.surface().height(flow.centre.x, flow.centre.y);
        found.side = height && flow.centre.z < *height ? Side::below : Side::above;
        found.proxy = narrow(flow.centre);
        found.penetration = narrow(offset);
        found.depth = static_cast<T>(depth);
        found.normal = narrow((1 / depth) * offset);
        std::vector<HalfSpace> cone;
        const auto feet = ground_.feet(flow.centre, radius_ * (1 + 1e-9L));
        for (const BallFoot& foot : feet) cone.push_back({foot.normal(), 0});
        const auto held = nearest_in(cone, -1 * offset);
        if (!held) return found;
        std::vector<std::size_t> order;
        for (std::size_t n = 0; n < held->count; ++n) order.push_back(n);
        std::sort(order.begin(), order.end(),
                  [&](std::size_t a, std::size_t b) { return held->pulls[a] > held->pulls[b]; });
        for (const std::size_t n : order) {
            const BallFoot& foot = feet[held->held_by[n]];
            found.touches[found.count++] = {
                {{foot.at.i, foot.at.j}, static_cast<T>(foot.at.u), static_cast<T>(foot.at.v)},
                narrow(foot.normal()),
                static_cast<T>(held->pulls[n])};
        }
        found.point = found.touches[0].point;
        return found;
    }

    BallSurface<T> ground_;
    Wide radius_;
    SurfaceKind kind_;
    std::optional<Point> centre_;
};

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_SLOW_BALL_HPP
