#ifndef HFH_GEOMETRY_SCALAR_HPP
#define HFH_GEOMETRY_SCALAR_HPP

#if defined(_MSVC_LANG) ? _MSVC_LANG < 202002L : __cplusplus < 202002L
#error "hfh needs C++20: compile with -std=c++20 (MSVC: /std:c++20) or newer"
#include <hfh/needs_cpp20> // There is no such file, so the compiler stops here and adds no errors that follow from this.
#endif

#include <glm/common.hpp> // also undefines the macros min and max of <windows.h>
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

/// An attribute for what is inlined into each of its callers: that makes an update faster, and its code larger. Where code has
/// to be small, which HFH_SMALL_CODE says or -Os, it is none, and the compiler decides; and a cast skips no empty space. Results
/// are the same either way, but for how many patches were looked at.
#if defined(HFH_SMALL_CODE) || defined(__OPTIMIZE_SIZE__)
#define HFH_ALWAYS_INLINED
namespace hfh::detail {
inline constexpr bool small_code = true;
}
#else
#define HFH_ALWAYS_INLINED gnu::always_inline
namespace hfh::detail {
inline constexpr bool small_code = false;
}
#endif

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

/// Distance from 1 to the next number of T: 2⁻²³ or 2⁻⁵². Every tolerance of the library is a small multiple of it times
/// the size of the numbers that went in; there is no absolute tolerance.
template <Real T>
inline constexpr T epsilon = std::numeric_limits<T>::epsilon();

namespace detail {

/// Where the sign, the exponent and the rest are in the bits of a T.
template <Real T>
struct Bits {
    using Type = std::conditional_t<std::same_as<T, float>, std::uint32_t, std::uint64_t>;
    static constexpr int below_exponent = std::numeric_limits<T>::digits - 1;
    static constexpr Type sign = Type{1} << (8 * sizeof(T) - 1);
    static constexpr Type exponent = sign - (Type{1} << below_exponent);
};

/// The bits of x. Under -ffast-math a compiler may assume that no number is NaN or ∞, and Clang from 17 or so on extends
/// that to the bits of the number. It cannot past an empty assembly, of which it has to assume that it changes them. MSVC
/// does not extend the assumption to bits.
template <Real T>
[[nodiscard]] constexpr typename Bits<T>::Type bits_of(T x) noexcept {
    auto bits = std::bit_cast<typename Bits<T>::Type>(x);
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ > 0
    if (!std::is_constant_evaluated()) {
        if constexpr (sizeof bits <= sizeof(void*)) {
            asm("" : "+r"(bits));
        } else {
            asm("" : "+m"(bits)); // no register is as wide
        }
    }
#endif
    return bits;
}

} // namespace detail

/// False for NaN and ±∞. Looks at the bits, so that it also holds under -ffast-math, where the compiler may assume
/// x == x.
template <Real T>
[[nodiscard]] constexpr bool is_finite(T x) noexcept {
    return (detail::bits_of(x) & detail::Bits<T>::exponent) != detail::Bits<T>::exponent;
}

template <Real T>
[[nodiscard]] constexpr bool is_finite(const vec3<T>& p) noexcept {
    return is_finite(p.x) && is_finite(p.y) && is_finite(p.z);
}

/// A finite number from 0 on, as a stiffness or a coefficient has to be. Looks at the bits as well.
template <Real T>
[[nodiscard]] constexpr bool is_at_least_zero(T x) noexcept {
    const auto bits = detail::bits_of(x);
    return bits < detail::Bits<T>::exponent || bits == detail::Bits<T>::sign;
}
/// A number from 0 on, or +∞: what may limit something from above. +∞ limits nothing.
template <Real T>
[[nodiscard]] constexpr bool is_upper_limit(T x) noexcept {
    const auto bits = detail::bits_of(x);
    return bits <= detail::Bits<T>::exponent || bits == detail::Bits<T>::sign;
}

/// Lengths in metres lie between these and their inverse: heights, distances, the spacing of a grid. So the fourth power
/// of a length, the square of a slope, and the determinant of Eq. (11), which is (dx·dy)² at the least, are numbers.
template <Real T>
inline constexpr T longest = std::same_as<T, float> ? T(0x1p31) : T(0x1p255);

/// Whether z can be a height: a number below `longest` in size. The usual "no data" values of rasters, ±3.4·10³⁸ and
/// −1.8·10³⁰⁸, cannot. Looks at the bits: of numbers without a sign the larger one has the larger bits, and infinity and
/// NaN have larger ones than any.
template <Real T>
[[nodiscard]] constexpr bool is_height(T z) noexcept {
    return (detail::bits_of(z) & ~detail::Bits<T>::sign) <
           std::bit_cast<typename detail::Bits<T>::Type>(longest<T>);
}

/// a·b + c, by the same roundings everywhere. Of `a * b + c` compilers fuse the product with the sum in one place and not in
/// another, and the last bit differs. Here it is fused where the processor can; elsewhere an empty assembly, which costs no
/// instruction, hides from the compiler that it is a product.
template <Real T>
[[nodiscard]] constexpr T multiply_add(T a, T b, T c) noexcept {
#if defined(__GNUC__) && (defined(__FMA__) || defined(__aarch64__))
    if constexpr (std::same_as<T, float>) {
        return __builtin_fmaf(a, b, c);
    } else {
        return __builtin_fma(a, b, c);
    }
#else
    T product = a * b;
#if defined(__GNUC__)
    if (!std::is_constant_evaluated()) {
#if defined(__SSE_MATH__)
        asm("" : "+x"(product));
#elif defined(__arm__) && defined(__ARM_FP) && (__ARM_FP & 8)
        asm("" : "+w"(product));
#elif defined(__arm__) && defined(__ARM_FP) && (__ARM_FP & 4)
        if constexpr (std::same_as<T, float>)
            asm("" : "+t"(product));
        else
            asm("" : "+r"(product)); // software computes with doubles
#else
        asm("" : "+m"(product)); // no name for the registers that hold floats
#endif
    }
#endif
    return product + c;
#endif
}

/// x as a double, to the bit. Every conversion from float to double goes through here, because of an error of GCC 12: at
/// -O2 it converts two numbers as a vector, and of a vector of (double)(float)y it drops both conversions and with them the
/// rounding to float. It cannot where it does not know how x was made: an empty assembly hides that and costs no instruction.
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
template <std::same_as<float> T>
[[nodiscard]] constexpr glm::dvec3 widen(const vec3<T>& p) noexcept {
    return {widen(p.x), widen(p.y), widen(p.z)};
}
template <std::same_as<double> T>
[[nodiscard]] constexpr const vec3<T>& widen(const vec3<T>& p) noexcept {
    return p;
}

namespace detail {

/// x in F, which holds all that its own type holds: to the bit.
template <Real F>
[[nodiscard]] constexpr F widen_to(F x) noexcept {
    return x;
}
template <Real F>
[[nodiscard]] constexpr const vec3<F>& widen_to(const vec3<F>& p) noexcept {
    return p;
}
template <std::same_as<double>>
[[nodiscard]] constexpr double widen_to(float x) noexcept {
    return widen(x);
}
template <std::same_as<double>>
[[nodiscard]] constexpr glm::dvec3 widen_to(const vec3<float>& p) noexcept {
    return widen(p);
}

} // namespace detail

} // namespace hfh

#endif // HFH_GEOMETRY_SCALAR_HPP
