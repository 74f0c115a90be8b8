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

} // namespace hfh

#endif // HFH_SCALAR_HPP
