#ifndef TOUCH_TERRAIN_TRACE_HPP
#define TOUCH_TERRAIN_TRACE_HPP

#include "touch.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

// What the picture shows of a session, in a few thousand points however long the session is.

namespace demo {

struct TracePoint {
    double t = 0;
    glm::dvec2 at{0.0};
    double force = 0; ///< N: the largest of what the point stands for
    bool contact = false;
};

/// Force over time. A point is the firmest of a stretch of updates; stretches double when there are too many.
class ForceTrace {
public:
    void add(const TracePoint& point) {
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

/// The path seen from above. A point stands for all that is nearer to it than a step; steps double when there are
/// too many.
class PathTrace {
public:
    void add(const TracePoint& point) {
        const double moved = points_.empty() ? 0.0 : glm::distance(points_.back().at, point.at);
        if (points_.empty() || moved > step_) {
            if (points_.size() == most) thin();
            length_ += moved;
            points_.push_back(point);
        } else {
            points_.back().force = std::max(points_.back().force, point.force);
            points_.back().contact = points_.back().contact || point.contact;
        }
    }
    [[nodiscard]] const std::vector<TracePoint>& points() const noexcept { return points_; }

private:
    static constexpr std::size_t most = 65536;

    void thin() {
        step_ = std::max(2 * step_, 2 * length_ / static_cast<double>(most));
        length_ = 0;
        for (const TracePoint& point : std::exchange(points_, {})) add(point);
    }

    std::vector<TracePoint> points_;
    double step_ = 0;   ///< metres
    double length_ = 0; ///< metres, of the path as kept
};

struct Trace {
    ForceTrace force;
    PathTrace path;

    void add(const Touch& touch) {
        const TracePoint point{
            touch.t, {touch.stylus.x, touch.stylus.y}, glm::length(touch.force), touch.contact};
        force.add(point);
        path.add(point);
    }
};

} // namespace demo

#endif // TOUCH_TERRAIN_TRACE_HPP
