#ifndef VIEWER_PATH_HAND_HPP
#define VIEWER_PATH_HAND_HPP

#include <stylus_path.hpp>

#include <glm/common.hpp>

#include <utility>
#include <vector>

namespace viewer {

/// A hand that goes along a path, evenly from sample to sample, and stays at its end.
class PathHand {
public:
    /// Precondition: at least one sample.
    explicit PathHand(std::vector<demo::StylusSample> path) noexcept : path_{std::move(path)} {}

    /// Where it is, in the terrain, `t` seconds after the beginning. To be asked in the order of time.
    [[nodiscard]] glm::dvec3 at(double t) noexcept {
        const double time = path_.front().t + t;
        while (next_ < path_.size() && path_[next_].t <= time) ++next_;
        if (next_ == path_.size()) return path_.back().position;
        if (next_ == 0) return path_.front().position;
        const demo::StylusSample &last = path_[next_ - 1], &next = path_[next_];
        return glm::mix(last.position, next.position, (time - last.t) / (next.t - last.t));
    }

private:
    std::vector<demo::StylusSample> path_;
    std::size_t next_ = 0;
};

} // namespace viewer

#endif // VIEWER_PATH_HAND_HPP
