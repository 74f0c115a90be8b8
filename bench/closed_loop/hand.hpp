#ifndef HFH_BENCH_CLOSED_LOOP_HAND_HPP
#define HFH_BENCH_CLOSED_LOOP_HAND_HPP

#include "grounds.hpp"
#include "random.hpp"
#include "reference.hpp"

#include <hfh/simulation/simulated_device.hpp>

#include <glm/geometric.hpp>

#include <cmath>
#include <optional>
#include <vector>

// Where hands go. All positions in metres at the hand; a path is a position an update, 1 ms apart.

namespace closed_loop {

using Path = std::vector<glm::dvec3>;
inline constexpr double period = 1e-3; ///< s

/// A path as the hand of a simulated device: rests at its end.
struct Along {
    const Path* path;
    [[nodiscard]] glm::dvec3 operator()(double t) const {
        const auto k = static_cast<std::size_t>(std::lround(std::max(0.0, t) / period));
        return (*path)[std::min(k, path->size() - 1)];
    }
};

/// The same way in steps of one length, from the first point on.
[[nodiscard]] inline Path evenly(const Path& path, double step) {
    Path even{path.front()};
    glm::dvec3 at = path.front();
    double left = step;
    for (std::size_t k = 1; k < path.size();) {
        const double length = glm::length(path[k] - at);
        if (length < left) {
            left -= length;
            at = path[k++];
        } else {
            at += (path[k] - at) * (left / length);
            even.push_back(at);
            left = step;
        }
    }
    return even;
}

/// A ground for hands: looks up heights in the samples themselves.
template <Real T>
class Site {
public:
    Site(const hfh::test::Terrain<T>& terrain, std::uint64_t seed)
        : surface_{terrain}, low_{terrain.low()}, high_{terrain.high()}, random_{seed} {}

    [[nodiscard]] std::optional<double> height(double x, double y) const {
        const auto z = surface_.height(static_cast<hfh::test::Wide>(x), static_cast<hfh::test::Wide>(y));
        return z ? std::optional{static_cast<double>(*z)} : std::nullopt;
    }
    /// A point over the ground, `margin` metres or more from the border; not over a hole.
    [[nodiscard]] glm::dvec3 somewhere(double margin) {
        for (;;) {
            const double x = random_.between(low_.x + margin, high_.x - margin),
                         y = random_.between(low_.y + margin, high_.y - margin);
            if (const auto z = height(x, y)) return {x, y, *z};
        }
    }

    /// Straight down to `depth` below the surface and back up, in equal steps; turns exactly at the depth.
    [[nodiscard]] Path press(double depth, double step) {
        const glm::dvec3 at = somewhere(5 * depth);
        const int steps = static_cast<int>(std::ceil(depth / step)) + 3;
        Path path;
        for (int k = -steps; k <= steps; ++k)
            path.push_back(at + glm::dvec3{0, 0, std::abs(k) * step - depth});
        return path;
    }

    /// From the air onto the ground, on under the surface at `depth`, and off again: straight seen from above, `length`
    /// metres long, with an eighth at each end to come and go, in equal steps in space. Not over holes; nothing if no
    /// place for it is found.
    [[nodiscard]] std::optional<Path> stroke(double length, double depth, double step) {
        constexpr int points = 4000;
        for (int attempt = 0; attempt < 1000; ++attempt) {
            const glm::dvec3 middle = somewhere(0.5 * length);
            const double heading = random_.between(0, 6.283185307);
            Path path;
            for (int k = 0; k <= points; ++k) {
                const double s = static_cast<double>(k) / points;
                const double x = middle.x + (s - 0.5) * length * std::cos(heading),
                             y = middle.y + (s - 0.5) * length * std::sin(heading);
                const auto z = height(x, y);
                if (!z) break;
                const double in = std::min(1.0, 8 * std::min(s, 1 - s));
                path.push_back({x, y, *z + depth * (1 - 2 * in)});
            }
            if (path.size() == points + 1) return evenly(path, step);
        }
        return {};
    }

    /// A wandering path `depth` under the surface, each step `step` metres long seen from above; over holes the height
    /// stays what it was.
    [[nodiscard]] Path wander(double depth, double step, double cell, std::size_t count) {
        const double margin = 4 * cell;
        glm::dvec3 at = somewhere(margin);
        double heading = random_.between(0, 6.283185307), ground = at.z;
        Path path;
        while (path.size() < count) {
            ground = height(at.x, at.y).value_or(ground);
            path.push_back({at.x, at.y, ground - depth});
            heading += random_.between(-0.4, 0.4) * std::sqrt(step / cell);
            const double to_x = at.x + step * std::cos(heading), to_y = at.y + step * std::sin(heading);
            if (to_x < low_.x + margin || to_x > high_.x - margin) heading = 3.14159265358979 - heading;
            if (to_y < low_.y + margin || to_y > high_.y - margin) heading = -heading;
            at += glm::dvec3{step * std::cos(heading), step * std::sin(heading), 0};
        }
        return path;
    }

    [[nodiscard]] hfh::test::Random& random() { return random_; }

private:
    hfh::test::Surface<T> surface_;
    glm::dvec2 low_, high_;
    hfh::test::Random random_;
};

} // namespace closed_loop

#endif // HFH_BENCH_CLOSED_LOOP_HAND_HPP
