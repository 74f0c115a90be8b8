#include "catch.hpp"
#include "support/random.hpp"

#include <hfh/geometry/scalar.hpp>

#include <cmath>
#include <type_traits>

using hfh::is_finite;

TEST_CASE("scalar: float and double are the scalars and nothing else is", "[scalar]") {
    STATIC_REQUIRE(hfh::Real<float>);
    STATIC_REQUIRE(hfh::Real<double>);
    STATIC_REQUIRE_FALSE(hfh::Real<long double>);
    STATIC_REQUIRE_FALSE(hfh::Real<int>);
    STATIC_REQUIRE_FALSE(hfh::Real<const double>);
    STATIC_REQUIRE(std::is_signed_v<hfh::Index>);
    STATIC_REQUIRE(std::is_same_v<hfh::vec3<float>, glm::vec3>);
    STATIC_REQUIRE(std::is_same_v<hfh::vec2<double>, glm::dvec2>);
}

TEMPLATE_TEST_CASE("scalar: epsilon is the spacing of numbers at 1", "[scalar]", float, double) {
    using T = TestType;
    CHECK(hfh::epsilon<T> == std::nextafter(T(1), T(2)) - T(1));
}

TEMPLATE_TEST_CASE("scalar: is_finite refuses NaN of either sign and both infinities", "[scalar][hard]",
                   float, double) {
    using T = TestType;
    using limits = std::numeric_limits<T>;
    for (const T bad : {limits::quiet_NaN(), -limits::quiet_NaN(), limits::signaling_NaN(),
                        limits::infinity(), -limits::infinity()}) {
        CHECK_FALSE(is_finite(bad));
        CHECK_FALSE(is_finite(hfh::vec3<T>{bad, 0, 0}));
        CHECK_FALSE(is_finite(hfh::vec3<T>{0, bad, 0}));
        CHECK_FALSE(is_finite(hfh::vec3<T>{0, 0, bad}));
    }
    for (const T good : {T(0), -T(0), limits::denorm_min(), limits::min(), limits::max(), limits::lowest()}) {
        CHECK(is_finite(good));
        CHECK(is_finite(hfh::vec3<T>{good, good, good}));
    }
    STATIC_REQUIRE(is_finite(T(1)));
    STATIC_REQUIRE_FALSE(is_finite(limits::infinity()));
}

TEMPLATE_TEST_CASE("scalar: is_finite agrees with the standard library on random bit patterns",
                   "[scalar][law]", float, double) {
    using T = TestType;
    using Bits = std::conditional_t<std::is_same_v<T, float>, std::uint32_t, std::uint64_t>;
    hfh::test::Random random{1};
    int disagreements = 0, infinite = 0;
    for (int n = 0; n < 100'000; ++n) {
        Bits bits = static_cast<Bits>(random.whole(0, std::numeric_limits<std::int64_t>::max() - 1)) << 1;
        // Every other one with all exponent bits set, which random bits rarely have.
        if (n % 2 == 0) bits |= std::bit_cast<Bits>(std::numeric_limits<T>::infinity());
        if (n % 64 == 0) bits = std::bit_cast<Bits>(std::numeric_limits<T>::infinity());
        const T x = std::bit_cast<T>(bits);
        infinite += !std::isfinite(x);
        disagreements += is_finite(x) != std::isfinite(x);
    }
    CHECK(disagreements == 0);
    CHECK(infinite >= 50'000);
}

namespace {

// Two floats or three that are made of doubles. Called through pointers that are read at run time, so that the compiler
// does not know what goes in.
[[gnu::noinline]] void widen_pair(const double* in, double* out) {
    const auto x = static_cast<float>(in[0] + 1.0), y = static_cast<float>(in[1] + 1.0);
    out[0] = hfh::widen(x);
    out[1] = hfh::widen(y);
}
[[gnu::noinline]] glm::dvec3 widen_point(const double* in) {
    const hfh::vec3<float> p{in[0] * 0.25, in[1] * 0.25, in[2] * 0.25};
    return hfh::widen(p);
}

} // namespace

TEST_CASE("scalar: a pair of floats is widened with the rounding they were made with", "[scalar][hard]") {
    // GCC 12 at -O2 gave the doubles that the floats were rounded from.
    const double in[3] = {0.1, 0.2, 0.7};
    double out[2] = {};
    void (*volatile widen_two)(const double*, double*) = widen_pair;
    widen_two(in, out);
    CHECK(out[0] == 1.10000002384185791015625);
    CHECK(out[1] == 1.2000000476837158203125);
    glm::dvec3 (*volatile widen_three)(const double*) = widen_point;
    const glm::dvec3 p = widen_three(in);
    CHECK(p.x == 0x1.99999ap-6);
    CHECK(p.y == 0x1.99999ap-5);
    CHECK(p.z == 0x1.666666p-3);
}

TEMPLATE_TEST_CASE("scalar: widening keeps every number, and can be done at compile time", "[scalar]", float,
                   double) {
    using T = TestType;
    using limits = std::numeric_limits<T>;
    STATIC_REQUIRE(hfh::widen(T(0.5)) == 0.5);
    STATIC_REQUIRE(std::is_same_v<decltype(hfh::widen(T(1))), double>);
    for (const T x :
         {T(0), T(-0.1), limits::denorm_min(), limits::min(), limits::max(), limits::infinity()}) {
        CHECK(static_cast<T>(hfh::widen(x)) == x);
        CHECK(hfh::widen(hfh::vec3<T>{x, -x, 1}) == glm::dvec3{hfh::widen(x), -hfh::widen(x), 1});
    }
    CHECK(std::signbit(hfh::widen(-T(0))));
    CHECK(std::isnan(hfh::widen(limits::quiet_NaN())));
}

TEMPLATE_TEST_CASE(
    "scalar: coefficients are zero of either sign and finite numbers above, limits also infinity",
    "[scalar][hard]", float, double) {
    using T = TestType;
    using limits = std::numeric_limits<T>;
    for (const T good : {T(0), -T(0), limits::denorm_min(), T(1), limits::max()}) {
        CHECK(hfh::is_at_least_zero(good));
        CHECK(hfh::is_upper_limit(good));
    }
    for (const T bad : {-limits::denorm_min(), T(-1), limits::lowest(), limits::quiet_NaN(),
                        -limits::quiet_NaN(), limits::signaling_NaN(), -limits::infinity()}) {
        CHECK_FALSE(hfh::is_at_least_zero(bad));
        CHECK_FALSE(hfh::is_upper_limit(bad));
    }
    CHECK_FALSE(hfh::is_at_least_zero(limits::infinity()));
    CHECK(hfh::is_upper_limit(limits::infinity()));
    STATIC_REQUIRE(hfh::is_at_least_zero(T(0)));
    STATIC_REQUIRE(hfh::is_upper_limit(limits::infinity()));
    STATIC_REQUIRE_FALSE(hfh::is_upper_limit(T(-1)));
}
