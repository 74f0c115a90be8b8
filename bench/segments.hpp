#ifndef HFH_BENCH_SEGMENTS_HPP
#define HFH_BENCH_SEGMENTS_HPP

#include "wander.hpp"

namespace hfh::bench {

struct Segment {
    glm::dvec3 a, b;
};

/// Segments of `length` cells in plan, anywhere on the ground and in any direction. Each starts above everything that
/// lies under it and ends a quarter of a cell over or under the ground, half of them each.
template <class Ground>
[[nodiscard]] std::vector<Segment> segments(const Ground& terrain, std::size_t count, double length) {
    const glm::dvec2 spacing = terrain.kind.spacing;
    const glm::dvec2 size = spacing * glm::dvec2{static_cast<double>(terrain.kind.columns - 1),
                                                 static_cast<double>(terrain.kind.rows - 1)};
    const double clearance = terrain.cell() / 4;
    Random random{7};
    std::vector<Segment> made;
    while (made.size() < count) {
        const double heading = random.between(0, 2 * std::numbers::pi);
        const glm::dvec2 a{size.x * random.unit(), size.y * random.unit()};
        const glm::dvec2 b = a + length * spacing * glm::dvec2{std::cos(heading), std::sin(heading)};
        if (b.x <= 0 || b.x >= size.x || b.y <= 0 || b.y >= size.y) continue;
        double highest = 0;
        const int samples = 4 + static_cast<int>(4 * length);
        for (int k = 0; k <= samples; ++k) {
            const glm::dvec2 at = a + (b - a) * (static_cast<double>(k) / samples);
            highest = std::max(highest, terrain.surface(at.x, at.y));
        }
        const double end = terrain.surface(b.x, b.y) + (made.size() % 2 == 0 ? -clearance : clearance);
        made.push_back({{a.x, a.y, highest + clearance}, {b.x, b.y, end}});
    }
    return made;
}

inline constexpr double segment_lengths[] = {0.5, 3, 30, 300};
inline constexpr const char* segment_names[] = {"0.5", "3", "30", "300"};

} // namespace hfh::bench

#endif // HFH_BENCH_SEGMENTS_HPP
