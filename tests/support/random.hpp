#ifndef HFH_TESTS_SUPPORT_RANDOM_HPP
#define HFH_TESTS_SUPPORT_RANDOM_HPP

#include <cstdint>
#include <random>

namespace hfh::test {

/// Numbers that are the same on every machine: the distributions of <random> are not, so they are not used.
class Random {
public:
    explicit Random(std::uint64_t seed) : bits_{seed} {}

    /// In [0, 1), a multiple of 2⁻⁵³.
    double unit() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }
    double between(double low, double high) { return low + (high - low) * unit(); }
    /// A whole number, low ≤ n ≤ high.
    std::int64_t whole(std::int64_t low, std::int64_t high) {
        const auto count = static_cast<std::uint64_t>(high - low) + 1;
        return low + static_cast<std::int64_t>(bits_() % count);
    }
    bool one_in(std::int64_t n) { return whole(1, n) == 1; }
    /// A multiple of 1/`parts`, low ≤ x ≤ high: exact in float and double when `parts` is a power of two.
    double fraction(std::int64_t low, std::int64_t high, std::int64_t parts) {
        return static_cast<double>(whole(low * parts, high * parts)) / static_cast<double>(parts);
    }

private:
    std::mt19937_64 bits_;
};

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_RANDOM_HPP
