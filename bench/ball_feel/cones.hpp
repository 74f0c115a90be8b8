#ifndef HFH_BENCH_BALL_FEEL_CONES_HPP
#define HFH_BENCH_BALL_FEEL_CONES_HPP

#include "random.hpp"
#include "terrains.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

// Cones on a floor, and a ball let down on them: lengths in metres.
//
// Based on: Unger, Hollis and Klatzky, Roughness Perception in Virtual Textures (2011): cones on a jittered lattice, felt with
// balls of several sizes. Height and slope of the cones are our own.

namespace ball_feel {

using hfh::Index;

namespace cone {
inline constexpr double height = 0.4e-3;
inline constexpr double slope = 1; ///< tan α
} // namespace cone

/// A ball beside one cone, of which it touches the flank, the apex or neither. On the floor it touches the flank: the radius r
/// has r·(1 − cos α) ≤ height.
class BallOnCone {
public:
    explicit BallOnCone(double radius) : radius_{radius} {
        const double secant = std::sqrt(1 + cone::slope * cone::slope); // 1/cos α
        flank_ = cone::height + radius * secant;
        off_apex_ = radius * cone::slope / secant;
        clear_ = (flank_ - radius) / cone::slope; // h/tan α + r·tan(α/2)
    }
    /// How far from the axis of the cone it stands on the floor and touches it.
    [[nodiscard]] double clear() const { return clear_; }
    /// Height of the centre over the floor, let down this far from the axis.
    [[nodiscard]] double centre(double from_axis) const {
        if (from_axis >= clear_) return radius_;
        return from_axis >= off_apex_ ? flank_ - cone::slope * from_axis
                                      : cone::height + std::sqrt(radius_ * radius_ - from_axis * from_axis);
    }

private:
    double radius_, flank_ = 0, off_apex_ = 0, clear_ = 0;
};

/// Cones on a square lattice, each moved by up to `jitter` of the spacing along either axis, to the nearest sample.
class Cones {
public:
    static constexpr double jitter = 0.15;

    /// At least `size` metres square, `cell` metres from sample to sample.
    Cones(double spacing, double size, double cell, hfh::test::Random& random)
        : spacing_{spacing}, cell_{cell}, across_{static_cast<Index>(std::ceil(size / spacing))} {
        const auto near = [&](Index k) {
            const double at = (static_cast<double>(k) + 0.5 + random.between(-jitter, jitter)) * spacing;
            return std::round(at / cell) * cell;
        };
        for (Index j = 0; j < across_; ++j) {
            for (Index i = 0; i < across_; ++i) {
                const double x = near(i);
                apexes_.emplace_back(x, near(j));
            }
        }
    }
    [[nodiscard]] double size() const { return static_cast<double>(across_) * spacing_; }

    /// From (x, y) to the axis of the nearest cone, which is that of this square of the lattice or of one beside it.
    [[nodiscard]] double to_axis(double x, double y) const {
        const auto i = static_cast<Index>(std::floor(x / spacing_)),
                   j = static_cast<Index>(std::floor(y / spacing_));
        double nearest = std::numeric_limits<double>::max();
        for (Index b = std::max<Index>(j - 1, 0); b <= std::min(j + 1, across_ - 1); ++b) {
            for (Index a = std::max<Index>(i - 1, 0); a <= std::min(i + 1, across_ - 1); ++a) {
                const glm::dvec2& apex = apexes_[static_cast<std::size_t>(b * across_ + a)];
                nearest = std::min(nearest, std::hypot(apex.x - x, apex.y - y));
            }
        }
        return nearest;
    }
    /// As samples.
    [[nodiscard]] hfh::test::Terrain<double> terrain() const {
        const auto samples = static_cast<Index>(std::floor(size() / cell_));
        return hfh::test::terrain<double>(samples, samples,
                                          [&](Index i, Index j) {
                                              const double from_axis =
                                                  to_axis(static_cast<double>(i) * cell_,
                                                          static_cast<double>(j) * cell_);
                                              return std::max(cone::height - cone::slope * from_axis, 0.0);
                                          },
                                          {.spacing = {cell_, cell_}});
    }

private:
    double spacing_, cell_;
    Index across_;
    std::vector<glm::dvec2> apexes_; ///< row by row
};

} // namespace ball_feel

#endif // HFH_BENCH_BALL_FEEL_CONES_HPP
