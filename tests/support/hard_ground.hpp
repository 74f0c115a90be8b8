#ifndef HFH_TESTS_SUPPORT_HARD_GROUND_HPP
#define HFH_TESTS_SUPPORT_HARD_GROUND_HPP

#include "terrains.hpp"

#include <array>
#include <cmath>

// Grounds on which limited work and roundings went wrong, or might: small, and no two alike.

namespace hfh::test {

/// What a ground is made of.
enum class HardGround : unsigned char {
    rough,        ///< every sample for itself
    steps,        ///< four heights, at random
    terraces,     ///< wide level steps
    checkerboard, ///< saddles, each with a ridge inside its patch
    spikes,       ///< level, with a few peaks and pits of 0.1 to 100 cells
    folds,        ///< level, with a few samples off by one to some hundred roundings, or by up to 0.03 cells
    cliffs,       ///< level, with a few cliffs of 10 to 10⁵ cells
    hills,
    slope,      ///< a tilted plane
    crease,     ///< two planes that meet, as a ridge or as a valley
    no_data,    ///< rough, with undeclared "no data" among the heights, and heights at the limit
    magnitudes, ///< of every size a file can hold
};
inline constexpr int hard_grounds = 12;

/// What rasters hold where nothing was measured, and what comes near the limit of heights.
template <Real T>
[[nodiscard]] T no_data_value(Random& random) {
    constexpr T top = std::numeric_limits<T>::max(), limit = no_height_from<T>;
    const std::array<T, 12> values{
        top,
        -top,
        static_cast<T>(-3.4028234663852886e38), // that of float files, in double a height
        static_cast<T>(1e20),
        static_cast<T>(-1e20),
        static_cast<T>(-32768e30),
        static_cast<T>(9.2233720368547758e18),
        static_cast<T>(1.8446744073709552e19),
        limit,
        -limit,
        std::nextafter(limit, T(0)),
        std::numeric_limits<T>::quiet_NaN()};
    return values[static_cast<std::size_t>(random.whole(0, static_cast<std::int64_t>(values.size()) - 1))];
}

/// low·(high/low)ˢ, s in [0, 1)
[[nodiscard]] inline double log_between(Random& random, double low, double high) {
    return low * std::pow(high / low, random.unit());
}

/// 4 to 31 samples along a side, in cells of 1 mm to 100 m.
template <Real T>
[[nodiscard]] Terrain<T> hard_ground(HardGround kind, Random& random) {
    const double dx = random.one_in(2) ? 1 : log_between(random, 1e-3, 100),
                 dy = random.one_in(5) ? dx * log_between(random, 0.1, 10) : dx;
    GridFrame frame{.spacing = {dx, dy}};
    if (random.one_in(6)) frame.origin = {dx * random.between(-1000, 1000), dy * random.between(-1000, 1000)};
    const Index columns = random.whole(4, 31), rows = random.whole(4, 31);
    const double relief = dx * log_between(random, 1e-3, 100),
                 base = random.one_in(2) ? 0 : relief * random.between(-1, 1);
    const double kx = log_between(random, 0.1, 3), ky = log_between(random, 0.1, 3),
                 a = random.between(-3, 3), b = random.between(-3, 3);
    const auto height = [&](Index column, Index row) -> double {
        const double i = static_cast<double>(column), j = static_cast<double>(row);
        switch (kind) {
        case HardGround::rough:
        case HardGround::no_data: return relief * random.between(-1, 1);
        case HardGround::steps: return relief * static_cast<double>(random.whole(0, 3));
        case HardGround::terraces: return relief * std::floor(i / 4 + j / 5 + a);
        case HardGround::checkerboard: return (column + row) % 2 == 0 ? 0 : relief;
        case HardGround::hills: return relief * std::sin(kx * i + a) * std::cos(ky * j + b);
        case HardGround::slope: return 0.3 * dx * (a * i + b * j);
        case HardGround::crease:
            return (b > 0 ? 0.2 : -0.2) * relief *
                   std::abs(std::cos(a) * (i - static_cast<double>(columns) / 2) +
                            std::sin(a) * (j - static_cast<double>(rows) / 2));
        case HardGround::magnitudes:
            return random.between(-1, 1) * std::exp2(random.between(-1, 1) * (sizeof(T) == 4 ? 127 : 300));
        case HardGround::spikes:
        case HardGround::folds:
        case HardGround::cliffs: return base;
        }
        return base;
    };
    auto made = terrain<T>(columns, rows, height, frame);
    const auto some = [&](std::int64_t most, auto&& change) {
        for (auto n = random.whole(1, most); n > 0; --n)
            change(made.at(random.whole(0, columns - 1), random.whole(0, rows - 1)));
    };
    switch (kind) {
    case HardGround::spikes:
        some(8, [&](T& sample) {
            sample = static_cast<T>(dx * random.between(-1, 1) * log_between(random, 0.1, 100));
        });
        break;
    case HardGround::folds:
        some(6, [&](T& sample) {
            const double rounding = static_cast<double>(epsilon<T>) * std::max(std::abs(base), dx);
            sample += static_cast<T>(random.between(-1, 1) * (random.one_in(2)
                                                                  ? rounding * log_between(random, 1, 300)
                                                                  : dx * log_between(random, 1e-5, 3e-2)));
        });
        break;
    case HardGround::cliffs: {
        const double cliff = dx * log_between(random, 10, 1e5) * (random.one_in(2) ? 1 : -1);
        some(4, [&](T& sample) { sample = static_cast<T>(base + cliff); });
        break;
    }
    case HardGround::no_data: some(5, [&](T& sample) { sample = no_data_value<T>(random); }); break;
    default: break;
    }
    return made;
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_HARD_GROUND_HPP
