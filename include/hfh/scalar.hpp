#ifndef HFH_SCALAR_HPP
#define HFH_SCALAR_HPP

#include <glm/ext/vector_double2.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/ext/vector_float2.hpp>
#include <glm/ext/vector_float3.hpp>

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace hfh {

/// The scalars the library computes in.
template <class T>
concept Real = std::same_as<T, float> || std::same_as<T, double>;

template <Real T>
using vec2 = glm::vec<2, T>;
template <Real T>
using vec3 = glm::vec<3, T>;

/// Column or row number of a sample or of a cell. Signed: a field may reach to both sides of its origin.
using Index = std::ptrdiff_t;

/// Unit roundoff spacing of T at 1: 2⁻²³ or 2⁻⁵². Every tolerance of the library is a small multiple of it
/// times the size of the numbers that went in; there is no absolute tolerance.
template <Real T>
inline constexpr T epsilon = std::numeric_limits<T>::epsilon();

/// False for NaN and ±∞. Looks at the bits, so that it also holds under -ffast-math, where the compiler may
/// assume x == x.
template <Real T>
[[nodiscard]] constexpr bool is_finite(T x) noexcept {
    if constexpr (std::same_as<T, float>) {
        return (std::bit_cast<std::uint32_t>(x) & 0x7f80'0000u) != 0x7f80'0000u;
    } else {
        return (std::bit_cast<std::uint64_t>(x) & 0x7ff0'0000'0000'0000u) != 0x7ff0'0000'0000'0000u;
    }
}

template <Real T>
[[nodiscard]] constexpr bool is_finite(const vec3<T>& p) noexcept {
    return is_finite(p.x) && is_finite(p.y) && is_finite(p.z);
}

/// Heights of the surface and of the stylus are smaller than this in size, in metres: 2³¹ (float) or 2²⁵⁵ (double), so
/// that the fourth power of a distance is a number still. The usual "no data" values of rasters, ±3.4·10³⁸ and
/// −1.8·10³⁰⁸, are beyond it.
template <Real T>
inline constexpr T height_limit = std::same_as<T, float> ? T(0x1p31) : T(0x1p255);

/// Whether z can be a height: a number, and below `height_limit` in size. Looks at the bits, as `is_finite` does.
template <Real T>
[[nodiscard]] constexpr bool is_height(T z) noexcept {
    using Bits = std::conditional_t<std::same_as<T, float>, std::uint32_t, std::uint64_t>;
    constexpr Bits without_sign = static_cast<Bits>(~Bits{0}) >> 1;
    // Of numbers without a sign the larger one has the larger bits, and infinity and NaN have larger ones than any.
    return (std::bit_cast<Bits>(z) & without_sign) < std::bit_cast<Bits>(height_limit<T>);
}

} // namespace hfh

#endif // HFH_SCALAR_HPP
