#ifndef HFH_TESTS_SUPPORT_NUMBERS_HPP
#define HFH_TESTS_SUPPORT_NUMBERS_HPP

#include <bit>
#include <concepts>
#include <cstdint>
#include <type_traits>

// What is no number, for tests that also run under -ffast-math: there a compiler may take it that nothing is NaN or ∞. Made
// from bits, and told by bits, both through volatile, so that it does not see what they are of. Shares nothing with
// scalar.hpp, which is judged by it.

namespace hfh::test {

template <class T>
using BitsOf = std::conditional_t<std::same_as<T, float>, std::uint32_t, std::uint64_t>;
template <class T>
inline constexpr BitsOf<T> bits_of_infinity = std::same_as<T, float> ? 0x7f80'0000u : 0x7ff0'0000'0000'0000u;

template <class T>
inline constexpr BitsOf<T> sign_bit = BitsOf<T>{1} << (8 * sizeof(T) - 1);

template <std::floating_point T>
[[nodiscard]] T made_of(BitsOf<T> bits) {
    const volatile BitsOf<T> hidden = bits;
    return std::bit_cast<T>(static_cast<BitsOf<T>>(hidden));
}
template <std::floating_point T>
[[nodiscard]] T hidden_nan() {
    return made_of<T>(bits_of_infinity<T> | bits_of_infinity<T> >> 1); // a quiet one
}
template <std::floating_point T>
[[nodiscard]] T hidden_infinity() {
    return made_of<T>(bits_of_infinity<T>);
}

/// False for NaN and ±∞.
template <std::floating_point T>
[[nodiscard]] bool holds_number(const T& x) {
    const volatile BitsOf<T> bits = std::bit_cast<BitsOf<T>>(x);
    return (bits & bits_of_infinity<T>) != bits_of_infinity<T>;
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_NUMBERS_HPP
