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

/// The centre of a ball at `centre`, which is clear, on its way to the stylus, in explicit steps of at most r/50. Each step
/// goes along F = stylus − centre as far as the half-spaces of all that is near let it, is pushed clear, and is halved until
/// the distance to the stylus falls. Ends where what is left of F is 10⁻⁸ of it, or shorter than roundings.
template <Real T>
[[nodiscard]] Flow flow_of_ball(const BallSurface<T>& ground, Point centre, const Point& stylus, Wide radius,
                                SurfaceKind kind, int max_steps = 20000) {
    const Wide longest = radius / 50, tiny = 1e-13L * (radius + largest_coordinate(stylus));
    Flow flow{FlowEnd::stuck, centre, 0};
    Wide part = 0.5L;
    for (; flow.steps < max_steps; ++flow.steps) {
        const Point force = stylus - flow.centre;
        const Wide depth = length(force);
        if (depth <= tiny) {
            flow.end = FlowEnd::arrived;
            return flow;
        }
        std::vector<HalfSpace> near, touching;
        bool rims_alone = true;
        for (const BallFoot& foot : ground.feet(flow.centre, radius + 2 * longest)) {
            near.push_back({foot.normal(), radius - foot.distance});
            if (foot.distance > radius * (1 + 1e-10L) + tiny) continue;
            touching.push_back({foot.normal(), 0});
            const bool pulls = dot(foot.normal(), force) < 0;
            if (pulls && !(ground.on_rim(foot.at) && kind == SurfaceKind::solid)) rims_alone = false;
        }
        const auto along = nearest_in(touching, force);
        if (!along) return flow;
        if (!touching.empty() && rims_alone && force.z > 0 && along->count > 0) {
            flow.end = FlowEnd::rim;
            return flow;
        }
        if (length(along->at) <= 1e-8L * depth + tiny) {
            flow.end = FlowEnd::minimum;
            return flow;
        }
        bool moved = false;
        part = std::min(part * 2, Wide(1));
        for (; !moved && part > 1e-12L; part /= 2) {
            auto step = nearest_in(near, part * force);
            if (!step) return flow;
            const Wide far = length(step->at);
            if (far > longest) {
                part *= longest / far;
                step = nearest_in(near, part * force);
                if (!step) return flow;
                if (length(step->at) > 1.01L * longest) continue;
            }
            const auto to = ground.pushed_clear(flow.centre + step->at, radius);
            if (!to || !(length(*to - stylus) < depth)) continue;
            flow.centre = *to;
            moved = true;
            break;
        }
        if (!moved) {
            // Nothing falls by more than roundings.
            flow.end = length(along->at) <= 1e-5L * depth + 100 * tiny ? FlowEnd::minimum : FlowEnd::stuck;
            return flow;
        }
    }
    return flow;
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
    /// Whether the last update's flow came to an end.
    [[nodiscard]] const std::optional<Point>& centre() const { return centre_; }

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
