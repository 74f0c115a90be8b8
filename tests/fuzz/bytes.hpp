#ifndef HFH_TESTS_FUZZ_BYTES_HPP
#define HFH_TESTS_FUZZ_BYTES_HPP

#include <hfh/geometry/scalar.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string>

// A fuzzer's bytes, read as the numbers that geometry is made of; and how a target says what went wrong.

namespace hfh::fuzz {

/// Reads bytes from the front; zeros once they have run out.
class Bytes {
public:
    Bytes(const std::uint8_t* data, std::size_t size) noexcept : at_{data}, left_{size} {}

    [[nodiscard]] bool empty() const noexcept { return left_ == 0; }
    [[nodiscard]] std::size_t left() const noexcept { return left_; }
    [[nodiscard]] const std::uint8_t* rest() const noexcept { return at_; }

    template <class I>
    I raw() noexcept {
        I value{};
        const std::size_t n = std::min(sizeof value, left_);
        if (n > 0) std::memcpy(&value, at_, n);
        at_ += n, left_ -= n;
        return value;
    }
    std::uint8_t byte() noexcept { return raw<std::uint8_t>(); }
    bool flag() noexcept { return (byte() & 1) != 0; }
    /// low ≤ n ≤ high, high − low < 256.
    int whole(int low, int high) noexcept { return low + byte() % (high - low + 1); }
    /// −128 … 127
    double small() noexcept { return raw<std::int8_t>(); }
    /// In [0, 1], both ends and the middle included.
    double share() noexcept {
        const std::uint8_t b = byte();
        return b < 255 ? (b + (b > 128 ? raw<std::uint8_t>() * 0x1p-8 : 0)) * 0x1p-8 : 1;
    }

private:
    const std::uint8_t* at_;
    std::size_t left_;
};

/// x moved by `ulps` places among the numbers of T.
template <Real T>
[[nodiscard]] T moved_by_ulps(T x, int ulps) noexcept {
    const T towards = ulps < 0 ? std::numeric_limits<T>::lowest() : std::numeric_limits<T>::max();
    for (int n = std::abs(ulps); n > 0; --n) x = std::nextafter(x, towards);
    return x;
}

/// Numbers of all kinds, |x| ≤ most: whole, fractions, of any size, denormal, any bits, and near those given before.
template <Real T>
class Numbers {
public:
    Numbers(Bytes& bytes, T most) noexcept : bytes_{&bytes}, most_{most} {}

    T operator()() noexcept {
        T x = next();
        // Too large or not finite: the same digits, smaller.
        if (!is_finite(x)) x = T(1);
        while (std::abs(x) > most_) x /= most_;
        return last_ = x;
    }

private:
    T next() noexcept {
        const int exponent_range = static_cast<int>(std::log10(most_));
        switch (bytes_->byte() % 10) {
        case 0: return T(0);
        case 1: return static_cast<T>(bytes_->small());
        case 2: return static_cast<T>(bytes_->raw<std::int16_t>() / 256.0);
        case 3: return static_cast<T>(bytes_->raw<std::int32_t>() * 0x1p-24);
        case 4: {
            const double digits = bytes_->small();
            return static_cast<T>(digits * std::pow(10.0, bytes_->whole(-exponent_range, exponent_range)));
        }
        case 5: return static_cast<T>(bytes_->small()) * std::numeric_limits<T>::denorm_min();
        case 6: return bytes_->raw<T>();
        case 7: return moved_by_ulps(last_, bytes_->whole(-4, 4));
        case 8: return last_;
        default: return -last_;
        }
    }

    Bytes* bytes_;
    T most_;
    T last_{};
};

/// Collects what a target was given, for its last words.
class Story {
public:
    template <Real T>
    Story& operator()(const char* name, T x) {
        char text[96];
        std::snprintf(text, sizeof text, "%s %.*g (%a)  ", name, std::numeric_limits<T>::max_digits10,
                      static_cast<double>(x), static_cast<double>(x));
        told_ += text;
        return *this;
    }
    Story& operator()(const char* text) {
        told_ += text;
        return *this;
    }
    [[nodiscard]] const std::string& told() const { return told_; }

private:
    std::string told_;
};

/// The invariant `rule` does not hold. libFuzzer keeps the input.
[[noreturn]] inline void broken(const char* rule, const std::string& told) {
    std::fprintf(stderr, "BROKEN: %s\n%s\n", rule, told.c_str());
    std::abort();
}

/// What the first byte says: in which scalar an input is touched, and one in eight on a raw field.
template <class Touch>
int touch_in_either_scalar(Bytes bytes, Touch&& touch) {
    const std::uint8_t which = bytes.byte();
    const bool raw = which / 2 % 8 == 0;
    if (which % 2 != 0) {
        touch.template operator()<double>(bytes, raw);
    } else {
        touch.template operator()<float>(bytes, raw);
    }
    return 0;
}

} // namespace hfh::fuzz

#endif // HFH_TESTS_FUZZ_BYTES_HPP
