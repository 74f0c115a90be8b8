#ifndef TOUCH_TERRAIN_TRACE_HPP
#define TOUCH_TERRAIN_TRACE_HPP

#include "touch.hpp"

#include <glm/geometric.hpp>

#include <cstdint>
#include <vector>

namespace demo {

/// What the picture shows of one stretch of the path: its firmest update.
struct TracePoint {
    double t = 0;
    glm::dvec2 at{0.0};
    double force = 0; ///< N
    bool contact = false;
};

/// The path thinned to a few thousand points as it grows: each point stands for a stretch of updates, and stretches
/// double when there are too many. Short blows survive, since the firmest update of a stretch is the one kept.
class Trace {
public:
    void add(const Touch& touch) {
        const TracePoint point{
            touch.t, {touch.stylus.x, touch.stylus.y}, glm::length(touch.force), touch.contact};
        if (in_stretch_ == 0) {
            if (points_.size() == most) halve();
            points_.push_back(point);
        } else {
            points_.back() = firmer(points_.back(), point);
        }
        in_stretch_ = (in_stretch_ + 1) % stretch_;
    }

    [[nodiscard]] const std::vector<TracePoint>& points() const noexcept { return points_; }

private:
    static constexpr std::size_t most = 8192;

    static const TracePoint& firmer(const TracePoint& a, const TracePoint& b) noexcept {
        return b.force > a.force ? b : a;
    }
    void halve() {
        for (std::size_t k = 0; k < most / 2; ++k) points_[k] = firmer(points_[2 * k], points_[2 * k + 1]);
        points_.resize(most / 2);
        stretch_ *= 2;
    }

    std::vector<TracePoint> points_;
    std::uint64_t stretch_ = 1;
    std::uint64_t in_stretch_ = 0;
};

} // namespace demo

#endif // TOUCH_TERRAIN_TRACE_HPP
