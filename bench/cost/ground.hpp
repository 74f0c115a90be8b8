#ifndef HFH_BENCH_COST_GROUND_HPP
#define HFH_BENCH_COST_GROUND_HPP

#include <hfh/terrain/bilinear_grid.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

// The ground of the cost guard and a path over it. Made with + − × ÷ √ only, which every machine rounds alike, and from
// nothing but this file: no change elsewhere moves the counts.

namespace hfh::cost {

/// The same sequence everywhere. Based on: Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators, 2014.
class Random {
public:
    explicit Random(std::uint64_t seed) noexcept : state_{seed} {}

    /// In [low, high).
    double between(double low, double high) noexcept {
        std::uint64_t x = state_ += 0x9e37'79b9'7f4a'7c15u;
        x = (x ^ (x >> 30)) * 0xbf58'476d'1ce4'e5b9u;
        x = (x ^ (x >> 27)) * 0x94d0'49bb'1331'11ebu;
        return low + (high - low) * (static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-53);
    }

private:
    std::uint64_t state_;
};

/// Square ground of whole metres on a grid of 10 m: bumps of 64, 32, 16, 8, 4 and 2 cells, each half as high as the one
/// before.
struct Ground {
    static constexpr Index size = 257;
    static constexpr double cell = 10.0;

    std::vector<std::int16_t> samples;

    /// `relief`: height of the longest bumps in metres, up and down.
    explicit Ground(double relief) {
        std::vector<double> heights(static_cast<std::size_t>(size * size), 0.0);
        Random random{1};
        for (Index wavelength = 64; wavelength >= 2; wavelength /= 2, relief /= 2) {
            const Index knots = (size - 1) / wavelength + 1;
            std::vector<double> knot(static_cast<std::size_t>(knots * knots));
            for (double& k : knot) k = random.between(-relief, relief);
            add_smoothly(heights, knot, knots, wavelength);
        }
        for (const double h : heights) samples.push_back(static_cast<std::int16_t>(h));
    }

    template <Real T>
    [[nodiscard]] auto grid() const noexcept {
        return BilinearGrid<T, HeightView<std::int16_t>>{{samples.data(), size, size},
                                                         {.spacing = {cell, cell}}};
    }

    /// Height of the bilinear surface over (x, y), straight from the samples.
    [[nodiscard]] double height(glm::dvec2 at) const noexcept {
        const auto i = static_cast<Index>(at.x / cell), j = static_cast<Index>(at.y / cell);
        const double u = at.x / cell - static_cast<double>(i), v = at.y / cell - static_cast<double>(j);
        const auto sample = [&](Index a, Index b) {
            return static_cast<double>(samples[static_cast<std::size_t>(b * size + a)]);
        };
        return (1 - v) * ((1 - u) * sample(i, j) + u * sample(i + 1, j)) +
               v * ((1 - u) * sample(i, j + 1) + u * sample(i + 1, j + 1));
    }

private:
    static void add_smoothly(std::vector<double>& heights, const std::vector<double>& knot, Index knots,
                             Index wavelength) {
        const auto ease = [](double t) { return t * t * (3 - 2 * t); };
        for (Index j = 0; j < size; ++j) {
            for (Index i = 0; i < size; ++i) {
                const Index a = std::min(i / wavelength, knots - 2), b = std::min(j / wavelength, knots - 2);
                const double u =
                    ease(static_cast<double>(i - a * wavelength) / static_cast<double>(wavelength));
                const double v =
                    ease(static_cast<double>(j - b * wavelength) / static_cast<double>(wavelength));
                const auto at = [&](Index di, Index dj) {
                    return knot[static_cast<std::size_t>((b + dj) * knots + a + di)];
                };
                heights[static_cast<std::size_t>(j * size + i)] +=
                    (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
            }
        }
    }
};

/// `count` places `step` cells apart, as a hand might take them: the direction turns a little at every step, and back
/// at the border.
[[nodiscard]] inline std::vector<glm::dvec2> wander(std::size_t count, double step) {
    constexpr double margin = 8 * Ground::cell, far = (Ground::size - 1) * Ground::cell - margin;
    Random random{2};
    glm::dvec2 at{1000.0, 1200.0}, heading{0.8, 0.6};
    std::vector<glm::dvec2> path;
    while (path.size() < count) {
        path.push_back(at);
        const double turn = random.between(-0.3, 0.3);
        heading += turn * glm::dvec2{-heading.y, heading.x};
        heading /= std::sqrt(heading.x * heading.x + heading.y * heading.y);
        const glm::dvec2 next = at + step * Ground::cell * heading;
        if (next.x < margin || next.x > far) heading.x = -heading.x;
        if (next.y < margin || next.y > far) heading.y = -heading.y;
        at += step * Ground::cell * heading;
    }
    return path;
}

} // namespace hfh::cost

#endif // HFH_BENCH_COST_GROUND_HPP
