#ifndef HFH_BENCH_HILLS_HPP
#define HFH_BENCH_HILLS_HPP

#include <hfh/geometry/scalar.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

// Generated ground.

namespace hfh::bench {
namespace detail {

/// The same number in [−1, 1] for the same arguments, everywhere.
inline double lattice_noise(std::uint64_t octave, Index i, Index j) noexcept {
    std::uint64_t x = octave * 0x9e37'79b9'7f4a'7c15u +
                      static_cast<std::uint64_t>(i) * 0xbf58'476d'1ce4'e5b9u +
                      static_cast<std::uint64_t>(j) * 0x94d0'49bb'1331'11ebu;
    x = (x ^ (x >> 30)) * 0xbf58'476d'1ce4'e5b9u;
    x = (x ^ (x >> 27)) * 0x94d0'49bb'1331'11ebu;
    return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-52 - 1;
}

inline double smooth_noise(std::uint64_t octave, double x, double y) noexcept {
    const double i = std::floor(x), j = std::floor(y);
    const auto ease = [](double t) { return t * t * (3 - 2 * t); };
    const double u = ease(x - i), v = ease(y - j);
    const auto at = [&](Index di, Index dj) {
        return lattice_noise(octave, static_cast<Index>(i) + di, static_cast<Index>(j) + dj);
    };
    return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
}

} // namespace detail

/// Hills without end, made for speed: a tile of 2048 × 2048 samples with wavelengths of 256 samples down to 2, which
/// fits its own other side, on broad ones of 16384 and 4096 samples that are interpolated over 64. One height is two
/// loads and a few additions, and the same for the same (i, j) whatever the size of the raster.
class Hills {
public:
    Hills() : tile_(side * side) {
        for (Index j = 0; j < side; ++j) {
            for (Index i = 0; i < side; ++i) tile_[static_cast<std::size_t>(i + j * side)] = detail_at(i, j);
        }
    }

    /// Samples (0…columns−1, j).
    void row(Index j, Index columns, std::int16_t* into) const {
        const float* tile = &tile_[static_cast<std::size_t>(j % side * side)];
        float left = broad(0, j);
        for (Index i = 0; i < columns; i += step) {
            const float right = broad(i + step, j);
            const Index end = std::min(step, columns - i);
            for (Index k = 0; k < end; ++k) {
                const float share = static_cast<float>(k) * (1.0f / step);
                into[i + k] = static_cast<std::int16_t>(left + (right - left) * share + tile[(i + k) % side]);
            }
            left = right;
        }
    }

    static constexpr double spacing = 10;               ///< metres, the paper's
    static constexpr double lowest = 0, highest = 4000; ///< about
    static constexpr double steepest = 2;               ///< no more: the octaves' slopes add to less

private:
    static constexpr Index side = 2048, step = 64;

    /// ±470 m.
    static float detail_at(Index i, Index j) {
        double sum = 0, amplitude = 256;
        for (Index wavelength = 256; wavelength >= 2; wavelength /= 2, amplitude *= 0.45) {
            const Index period = side / wavelength;
            const double x = static_cast<double>(i) / static_cast<double>(wavelength),
                         y = static_cast<double>(j) / static_cast<double>(wavelength);
            const Index a = static_cast<Index>(x), b = static_cast<Index>(y);
            const auto at = [&](Index di, Index dj) {
                return detail::lattice_noise(static_cast<std::uint64_t>(wavelength), (a + di) % period,
                                             (b + dj) % period);
            };
            const auto ease = [](double t) { return t * t * (3 - 2 * t); };
            const double u = ease(x - static_cast<double>(a)), v = ease(y - static_cast<double>(b));
            sum += amplitude *
                   ((1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1)));
        }
        return static_cast<float>(sum);
    }
    static float broad(Index i, Index j) {
        const double x = static_cast<double>(i), y = static_cast<double>(j);
        return static_cast<float>(2000 + 1000 * detail::smooth_noise(100, x / 16384, y / 16384) +
                                  400 * detail::smooth_noise(101, x / 4096, y / 4096));
    }

    std::vector<float> tile_;
};

} // namespace hfh::bench

#endif // HFH_BENCH_HILLS_HPP
