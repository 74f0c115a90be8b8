#ifndef HFH_TESTS_SUPPORT_SCANNED_MINIMA_HPP
#define HFH_TESTS_SUPPORT_SCANNED_MINIMA_HPP

#include "reference.hpp"

#include <algorithm>
#include <vector>

namespace hfh::test {

/// Downhill from a point of a closed patch, in ever smaller steps.
[[nodiscard]] inline Foot walked_down(const WidePatch& p, const Point& q, Foot at, Wide step) {
    for (int tries = 0; tries < 4000 && step > 1e-12L; ++tries) {
        Foot best = at;
        for (int n = -2; n <= 2; ++n) {
            for (int m = -2; m <= 2; ++m) {
                const Wide u = std::clamp(at.u + m * step / 2, Wide(0), Wide(1)),
                           v = std::clamp(at.v + n * step / 2, Wide(0), Wide(1)),
                           here = p.half_square(u, v, q);
                if (here < best.distance) best = {u, v, here};
            }
        }
        if (!(best.distance < at.distance)) step /= 2;
        at = best;
    }
    return at;
}

/// The local closest points of a closed patch, by a search that shares no code with the library: each lowest point of a dense
/// sampling, moved downhill in ever smaller steps. What is a dip for the sampling alone ends at a minimum that another finds,
/// or somewhere on a slope that is too narrow for the steps; the caller tells by `fall_into`.
[[nodiscard]] inline std::vector<Foot> scanned_minima(const WidePatch& p, const Point& q) {
    constexpr int samples = 24;
    Wide table[samples + 1][samples + 1];
    for (int b = 0; b <= samples; ++b) {
        for (int a = 0; a <= samples; ++a)
            table[b][a] = p.half_square(Wide(a) / samples, Wide(b) / samples, q);
    }
    const auto is_lowest = [&](int a, int b) {
        bool lowest = true;
        for (int n = std::max(b - 1, 0); n <= std::min(b + 1, samples); ++n) {
            for (int m = std::max(a - 1, 0); m <= std::min(a + 1, samples); ++m)
                lowest = lowest && table[n][m] >= table[b][a];
        }
        return lowest;
    };
    std::vector<Foot> found;
    for (int b = 0; b <= samples; ++b) {
        for (int a = 0; a <= samples; ++a) {
            if (!is_lowest(a, b)) continue;
            const Foot at =
                walked_down(p, q, {Wide(a) / samples, Wide(b) / samples, table[b][a]}, Wide(1) / samples);
            found.push_back({at.u, at.v, std::sqrt(2 * at.distance)});
        }
    }
    return found;
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_SCANNED_MINIMA_HPP
