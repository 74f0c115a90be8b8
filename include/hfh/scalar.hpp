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

namespace detail {

/// The upper 32 bits of x, with its sign and its exponent, of which the compiler knows nothing. Under -ffast-math it may
/// assume that no number is NaN or ∞, and Clang from 17 or so on extends that to the bits of the number. An empty
/// assembly, which costs no instruction, may do anything to them for all that the compiler knows. MSVC does not have
/// it, nor does it draw conclusions about bits.
[[nodiscard]] constexpr std::uint32_t high_bits(float x) noexcept {
    auto bits = std::bit_cast<std::uint32_t>(x);
#if defined(__GNUC__)
    if (!std::is_constant_evaluated()) asm("" : "+r"(bits));
#endif
    return bits;
}
[[nodiscard]] constexpr std::uint32_t high_bits(double x) noexcept {
    auto bits = static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(x) >> 32);
#if defined(__GNUC__)
    if (!std::is_constant_evaluated()) asm("" : "+r"(bits));
#endif
    return bits;
}

} // namespace detail

/// False for NaN and ±∞. Looks at the bits, so that it also holds under -ffast-math, where the compiler may assume
/// x == x.
template <Real T>
[[nodiscard]] constexpr bool is_finite(T x) noexcept {
    constexpr std::uint32_t exponent = std::same_as<T, float> ? 0x7f80'0000u : 0x7ff0'0000u;
    return (detail::high_bits(x) & exponent) != exponent;
}

template <Real T>
[[nodiscard]] constexpr bool is_finite(const vec3<T>& p) noexcept {
    return is_finite(p.x) && is_finite(p.y) && is_finite(p.z);
}

/// A finite number from 0 on, such as a stiffness, a coefficient or a limit has to be.
template <Real T>
[[nodiscard]] constexpr bool is_at_least_zero(T x) noexcept {
    return is_finite(x) && x >= 0;
}

/// x as a double, to the bit. Every step from float to double goes through here: GCC 12 at -O2 computes a pair of such
/// steps as a vector, and of a vector of (double)(float)y it drops both conversions, the rounding with them. It cannot
/// where it does not know how x was made; the empty assembly keeps x in its register and costs no instruction.
template <Real T>
[[nodiscard]] constexpr double widen(T x) noexcept {
    if constexpr (std::same_as<T, float>) {
#if defined(__GNUC__) && !defined(__clang__)
        if (!std::is_constant_evaluated()) {
#if defined(__SSE_MATH__)
            asm("" : "+x"(x));
#elif defined(__aarch64__)
            asm("" : "+w"(x));
#else
            // Through memory: here the registers that hold floats have no name to go by.
            asm("" : "+m"(x));
#endif
        }
#endif
    }
    return static_cast<double>(x);
}
template <Real T>
[[nodiscard]] constexpr glm::dvec3 widen(const vec3<T>& p) noexcept {
    return {widen(p.x), widen(p.y), widen(p.z)};
}

} // namespace hfh

#endif // HFH_SCALAR_HPP
