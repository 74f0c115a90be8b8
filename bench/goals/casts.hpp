#ifndef HFH_BENCH_GOALS_CASTS_HPP
#define HFH_BENCH_GOALS_CASTS_HPP

#include "../segments.hpp"
#include "goal.hpp"
#include "ground.hpp"
#include "race.hpp"
#include "text.hpp"

#include <hfh/traversal/first_hit.hpp>

// Segments, where the library says that they first cross the surface, and whether that is right.

namespace hfh::bench {

inline constexpr std::size_t casts_a_slice = 512;

/// Segments of one length.
template <Real T>
struct CastSet {
    double length; ///< cells
    std::vector<CastSegment<T>> queries;
    std::vector<double> t; ///< the library's answers; 2: none
};

/// All of them, timed in slices; the answers go into the set.
template <HeightField Field, Real T = typename Field::Scalar>
[[nodiscard]] Runner casts(const Field& field, CastSet<T>& set) {
    return {set.queries.size() / casts_a_slice, static_cast<double>(casts_a_slice),
            [&field, &set](std::size_t slice) {
                for (std::size_t k = slice * casts_a_slice; k < (slice + 1) * casts_a_slice; ++k) {
                    const auto hit =
                        first_hit(field, glm::dvec3{set.queries[k].a}, glm::dvec3{set.queries[k].b});
                    set.t[k] = hit.status == HitStatus::hit ? static_cast<double>(hit.t) : 2;
                }
            }};
}

/// A multiple of `casts_a_slice` segments, and the answers.
template <Real T, HeightField Field, class G>
[[nodiscard]] CastSet<T> cast_set(const Field& field, const G& ground, double length, std::size_t count) {
    CastSet<T> set{length, {}, std::vector<double>(count)};
    for (const auto& s : segments(ground, count, length)) set.queries.push_back({vec3<T>{s.a}, vec3<T>{s.b}});
    const Runner run = casts(field, set);
    for (std::size_t slice = 0; slice < run.slices; ++slice) run.run(slice);
    return set;
}

/// Whether an answer is the first crossing, by looking at the segment in steps of 1/32 of a cell.
template <class G, Real T>
[[nodiscard]] bool is_first_crossing(const G& ground, const CastSet<T>& set, std::size_t k) {
    const glm::dvec3 a{set.queries[k].a}, b{set.queries[k].b};
    const auto height_over = [&](double t) {
        const glm::dvec3 at = a + t * (b - a);
        return at.z - ground.surface(at.x, at.y);
    };
    // Rounding of coordinates, and what it makes of the height on the steepest slope.
    const double size = ground.kind.spacing.x * static_cast<double>(ground.kind.columns) +
                        ground.kind.spacing.y * static_cast<double>(ground.kind.rows);
    const double tolerance =
        8 * static_cast<double>(epsilon<T>) * (size * (1 + ground.steepest) + ground.kind.highest);
    const bool found = set.t[k] <= 1;
    if (found && !(std::abs(height_over(set.t[k])) <= tolerance)) return false;
    if (!found && !(height_over(1) >= -tolerance)) return false;
    const double searched = found ? set.t[k] : 1;
    const int steps = 8 + static_cast<int>(32 * set.length);
    for (int n = 0; n < steps; ++n) {
        if (height_over(searched * static_cast<double>(n) / steps) < -tolerance) return false;
    }
    return true;
}

/// Throws a Fault if an answer is wrong. Looking takes longer than finding, so it is one in 32 that is looked at, or one
/// in 256 of the long ones.
template <class G, Real T>
void check_casts(const G& ground, const CastSet<T>& set) {
    const std::size_t stride = set.length > 30 ? 256 : 32;
    for (std::size_t k = 0; k < set.queries.size(); k += stride) {
        if (!is_first_crossing(ground, set, k)) {
            throw Fault{"cast of " + text(set.length) + " cells on " + ground.kind.name +
                        ": not the first crossing"};
        }
    }
}

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_CASTS_HPP
