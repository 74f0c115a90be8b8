#ifndef LARGE_TERRAIN_JOURNEY_HPP
#define LARGE_TERRAIN_JOURNEY_HPP

#include <hfh/geometry/scalar.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace large_terrain {

/// Where a hand goes that wants to see much of a large terrain, in cells, one place an update at 1 kHz. Every ten
/// seconds: straight on, a bend, a slalom, a stop and back the same way, and one full circle. It turns at the border.
/// Always the same.
class Journey {
public:
    Journey(hfh::Index columns, hfh::Index rows, double cells_per_second) noexcept
        : size_{static_cast<double>(columns - 1), static_cast<double>(rows - 1)},
          at_{0.31 * size_.x, 0.23 * size_.y}, speed_{cells_per_second / rate} {}

    static constexpr double rate = 1000; ///< Hz

    [[nodiscard]] glm::dvec2 at() const noexcept { return at_; }

    void advance() noexcept {
        constexpr double pi = std::numbers::pi, cycle = 10;
        const double t = std::fmod(static_cast<double>(tick_++) / rate, cycle);
        double turn = 0, share = 1; // radians a second; of full speed
        if (tick_ < 300) share = static_cast<double>(tick_) / 300;
        if (t >= 3 && t < 3.5) {
            turn = 4;
        } else if (t >= 3.5 && t < 6.5) {
            turn = 7 * std::cos(3 * pi * (t - 3.5));
        } else if (t >= 6.5 && t < 6.8) { // full speed one way to full speed the other in 0.3 s
            share = std::cos(pi * (t - 6.5) / 0.3);
        } else if (t >= 6.8) {
            share = -1;
            if (t >= 9) turn = 2 * pi;
        }
        if (t < last_) heading_ += pi; // it goes on the way it went last
        last_ = t;
        heading_ += turn / rate;

        const glm::dvec2 step = share * speed_ * glm::dvec2{std::cos(heading_), std::sin(heading_)};
        const double margin = std::min({64.0, size_.x / 4, size_.y / 4});
        const auto leaves = [&](double from, double by, double size) {
            return (by < 0 && from < margin) || (by > 0 && from > size - margin);
        };
        glm::dvec2 bounced = step;
        if (leaves(at_.x, step.x, size_.x)) {
            heading_ = pi - heading_;
            bounced.x = -step.x;
        }
        if (leaves(at_.y, step.y, size_.y)) {
            heading_ = -heading_;
            bounced.y = -step.y;
        }
        at_ += bounced;
    }

private:
    glm::dvec2 size_;
    glm::dvec2 at_;
    double speed_; ///< cells an update
    double heading_ = 1.3;
    double last_ = 0;
    long tick_ = 0;
};

} // namespace large_terrain

#endif // LARGE_TERRAIN_JOURNEY_HPP
