#include "catch.hpp"
#include "support/random.hpp"

#include <hfh/geometry/bilinear_patch.hpp>

#include <array>
#include <bit>
#include <cmath>
#include <vector>

using hfh::BilinearPatch;
using hfh::vec3;
using hfh::test::Random;

namespace {

using Exact = long double;

/// Eq. (1)-(5) [P] as printed, the corners as points in space.
struct Printed {
    std::array<Exact, 3> A, B, C, D;

    template <class T>
    explicit Printed(const BilinearPatch<T>& p) {
        const auto dx = Exact(p.spacing.x), dy = Exact(p.spacing.y);
        const std::array<Exact, 3> p00{0, 0, Exact(p.p00)}, p10{dx, 0, Exact(p.p10)},
            p01{0, dy, Exact(p.p01)}, p11{dx, dy, Exact(p.p11)};
        for (std::size_t n = 0; n < 3; ++n) {
            A[n] = p11[n] - p10[n] - p01[n] + p00[n];
            B[n] = p10[n] - p00[n];
            C[n] = p01[n] - p00[n];
            D[n] = p00[n];
        }
    }
    std::array<Exact, 3> at(Exact u, Exact v) const {
        return combine([&](std::size_t n) { return u * v * A[n] + u * B[n] + v * C[n] + D[n]; });
    }
    std::array<Exact, 3> along_u(Exact v) const {
        return combine([&](std::size_t n) { return v * A[n] + B[n]; });
    }
    std::array<Exact, 3> along_v(Exact u) const {
        return combine([&](std::size_t n) { return u * A[n] + C[n]; });
    }
    std::array<Exact, 3> normal(Exact u, Exact v) const {
        const auto s = along_u(v), t = along_v(u);
        const std::array<Exact, 3> n{s[1] * t[2] - s[2] * t[1], s[2] * t[0] - s[0] * t[2],
                                     s[0] * t[1] - s[1] * t[0]};
        const Exact length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        return {n[0] / length, n[1] / length, n[2] / length};
    }

private:
    template <class Component>
    static std::array<Exact, 3> combine(Component&& component) {
        return {component(0), component(1), component(2)};
    }
};

template <class T>
double distance(const vec3<T>& a, const std::array<Exact, 3>& b) {
    const Exact x = Exact(a.x) - b[0], y = Exact(a.y) - b[1], z = Exact(a.z) - b[2];
    return static_cast<double>(std::sqrt(x * x + y * y + z * z));
}

template <class T>
constexpr auto eps = static_cast<double>(hfh::epsilon<T>);

template <class T>
double largest(const BilinearPatch<T>& p) {
    return static_cast<double>(std::max(std::abs(p.highest()), std::abs(p.lowest())));
}

/// Trivial, tiny and random patches.
template <class T>
std::vector<BilinearPatch<T>> patches(std::uint64_t seed) {
    std::vector<BilinearPatch<T>> all{
        {},
        {T(5), T(5), T(5), T(5), {T(10), T(3)}},
        {T(0), T(1), T(0), T(1)},
        {T(0), T(0), T(0), T(1), {T(10), T(10)}},
        {T(1), T(-1), T(-1), T(1)},
        {T(1e-10), T(-1e-10), T(2e-10), T(0), {T(1e-8), T(1e-8)}},
    };
    Random random{seed};
    for (const double relief : {1e-6, 1.0, 30.0, 9000.0}) {
        for (int n = 0; n < 250; ++n) {
            const auto height = [&] { return static_cast<T>(random.between(-relief, relief)); };
            const auto step = [&] { return static_cast<T>(random.between(0.1, 30)); };
            all.push_back({height(), height(), height(), height(), {step(), step()}});
        }
    }
    return all;
}

/// Corners, edges and random points of a patch.
template <class T>
std::vector<std::pair<T, T>> parameters(Random& random) {
    std::vector<std::pair<T, T>> all;
    for (const T u : {T(0), T(0.5), T(1)}) {
        for (const T v : {T(0), T(0.5), T(1)}) all.emplace_back(u, v);
    }
    for (int n = 0; n < 30; ++n) {
        all.emplace_back(static_cast<T>(random.unit()), static_cast<T>(random.unit()));
    }
    return all;
}

} // namespace

TEMPLATE_TEST_CASE("bilinear_patch: positions are those of the printed formula",
                   "[patch][law][eq:1][eq:6][eq:7]", float, double) {
    using T = TestType;
    Random random{10};
    for (const auto& patch : patches<T>(11)) {
        const Printed printed{patch};
        for (const auto& [u, v] : parameters<T>(random)) {
            // Two mixes, one after the other; each rounds 1 − u, the product and the sum by ε/2 of at most the
            // largest corner: 6·ε/2. Below the normal numbers each of those is half a denormal instead.
            const double bound =
                3 * eps<T> * largest(patch) + 6 * static_cast<double>(std::numeric_limits<T>::denorm_min());
            const auto expected = printed.at(Exact(u), Exact(v));
            CHECK(std::abs(static_cast<double>(Exact(patch.height(u, v)) - expected[2])) <= bound);
            const auto position = patch.position(u, v);
            CHECK(position.x == Approx(static_cast<double>(expected[0])).epsilon(eps<T>));
            CHECK(position.y == Approx(static_cast<double>(expected[1])).epsilon(eps<T>));
            CHECK(position.z == patch.height(u, v));
            // A mix of corners lies among them, up to the same rounding.
            CHECK(static_cast<double>(patch.height(u, v)) <= static_cast<double>(patch.highest()) + bound);
            CHECK(static_cast<double>(patch.height(u, v)) >= static_cast<double>(patch.lowest()) - bound);
        }
    }
}

TEMPLATE_TEST_CASE("bilinear_patch: corners are the samples to the bit", "[patch][law][eq:5]", float,
                   double) {
    using T = TestType;
    for (const auto& patch : patches<T>(12)) {
        CHECK(patch.height(0, 0) == patch.p00);
        CHECK(patch.height(1, 0) == patch.p10);
        CHECK(patch.height(0, 1) == patch.p01);
        CHECK(patch.height(1, 1) == patch.p11);
        CHECK(patch.lowest() == std::min({patch.p00, patch.p10, patch.p01, patch.p11}));
        CHECK(patch.highest() == std::max({patch.p00, patch.p10, patch.p01, patch.p11}));
        CHECK(patch.position(0, 0).x == 0);
        CHECK(patch.position(0, 0).y == 0);
        CHECK(patch.position(1, 1).x == patch.spacing.x);
        CHECK(patch.position(1, 1).y == patch.spacing.y);
    }
}

TEMPLATE_TEST_CASE("bilinear_patch: twist is the height of A", "[patch][law][eq:2]", float, double) {
    using T = TestType;
    for (const auto& patch : patches<T>(13)) {
        // Two differences of at most 2·largest and one of at most 4·largest, each rounded by ε/2.
        const double bound = 4 * eps<T> * largest(patch);
        CHECK(std::abs(static_cast<double>(Exact(patch.twist()) - Printed{patch}.A[2])) <= bound);
    }
    CHECK(BilinearPatch<T>{T(1), T(2), T(4), T(8)}.twist() == 3);
    CHECK(BilinearPatch<T>{T(1), T(2), T(4), T(5)}.twist() == 0);
}

TEMPLATE_TEST_CASE("bilinear_patch: partials are those of the printed formula", "[patch][law][eq:3][eq:4]",
                   float, double) {
    using T = TestType;
    Random random{14};
    for (const auto& patch : patches<T>(15)) {
        const Printed printed{patch};
        for (const auto& [u, v] : parameters<T>(random)) {
            // A mix of two differences of at most 2·largest: the difference, 1 − v, the product and the sum round.
            const double bound = 4 * eps<T> * largest(patch);
            CHECK(distance(patch.partial_u(v), printed.along_u(Exact(v))) <= bound);
            CHECK(distance(patch.partial_v(u), printed.along_v(Exact(u))) <= bound);
            CHECK(patch.partial_u(v).z == patch.slope_u(v));
            CHECK(patch.partial_v(u).z == patch.slope_v(u));
        }
    }
}

TEMPLATE_TEST_CASE("bilinear_patch: partials are the differences of positions", "[patch][law]", float,
                   double) {
    using T = TestType;
    Random random{16};
    for (const auto& patch : patches<T>(17)) {
        for (int n = 0; n < 20; ++n) {
            const T u = static_cast<T>(random.between(0.25, 0.75)),
                    v = static_cast<T>(random.between(0.25, 0.75));
            const T step = T(0.25);
            // Along u and v the surface is straight, so central differences have no error but rounding: 3ε·largest
            // for each height (see above), divided by the two steps between them, ε/2 for u ± step times a slope
            // of 2·largest, and 4ε·largest for the partial itself.
            const double bound = (2 * 3 / 0.5 + 2 / 0.5 + 4) * eps<T> * largest(patch);
            const T by_u = (patch.height(u + step, v) - patch.height(u - step, v)) / (2 * step);
            const T by_v = (patch.height(u, v + step) - patch.height(u, v - step)) / (2 * step);
            CHECK(std::abs(static_cast<double>(by_u - patch.slope_u(v))) <= bound);
            CHECK(std::abs(static_cast<double>(by_v - patch.slope_v(u))) <= bound);
        }
    }
}

TEMPLATE_TEST_CASE("bilinear_patch: the normal is of unit length and upright on both partials",
                   "[patch][law]", float, double) {
    using T = TestType;
    Random random{18};
    for (const auto& patch : patches<T>(19)) {
        const Printed printed{patch};
        for (const auto& [u, v] : parameters<T>(random)) {
            const auto n = patch.normal(u, v);
            // n moves by no more than the slopes dz/dx and dz/dy do, which carry the error of the partials (4ε of the
            // largest corner) over the spacing; dividing and normalising adds ε/2 about eight times.
            const double slopes = largest(patch) * (1 / static_cast<double>(patch.spacing.x) +
                                                    1 / static_cast<double>(patch.spacing.y));
            CHECK(distance(n, printed.normal(Exact(u), Exact(v))) <= 4 * eps<T> * slopes + 4 * eps<T>);
            CHECK(std::hypot(n.x, n.y, n.z) == Approx(1).margin(4 * eps<T>));
            CHECK(n.z >= 0);
            const auto dot = [&](const std::array<Exact, 3>& s) {
                return std::abs(
                    static_cast<double>(Exact(n.x) * s[0] + Exact(n.y) * s[1] + Exact(n.z) * s[2]));
            };
            const auto length = [](const std::array<Exact, 3>& s) {
                return static_cast<double>(std::sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]));
            };
            const auto along_u = printed.along_u(Exact(v)), along_v = printed.along_v(Exact(u));
            CHECK(dot(along_u) <= (4 * slopes + 4) * eps<T> * length(along_u));
            CHECK(dot(along_v) <= (4 * slopes + 4) * eps<T> * length(along_v));
        }
    }
}

TEMPLATE_TEST_CASE("bilinear_patch: a plane has one normal and a saddle has a level middle", "[patch]", float,
                   double) {
    using T = TestType;
    const BilinearPatch<T> plane{T(0), T(30), T(40), T(70), {T(10), T(10)}}; // slopes 3 and 4
    const BilinearPatch<T> saddle{T(1), T(-1), T(-1), T(1), {T(7), T(9)}};
    for (const T u : {T(0), T(0.25), T(1)}) {
        for (const T v : {T(0), T(0.75), T(1)}) {
            const auto n = plane.normal(u, v);
            CHECK(n.x == Approx(-3 / std::sqrt(26.0)).epsilon(4 * eps<T>));
            CHECK(n.y == Approx(-4 / std::sqrt(26.0)).epsilon(4 * eps<T>));
            CHECK(n.z == Approx(1 / std::sqrt(26.0)).epsilon(4 * eps<T>));
            CHECK(plane.height(u, v) == 30 * u + 40 * v);
            CHECK(saddle.height(u, v) == (1 - 2 * u) * (1 - 2 * v));
        }
    }
    CHECK(saddle.normal(T(0.5), T(0.5)) == vec3<T>{0, 0, 1});
    CHECK(BilinearPatch<T>{}.normal(0, 0) == vec3<T>{0, 0, 1});
}

TEMPLATE_TEST_CASE("bilinear_patch: neighbours agree on their edge to the bit", "[patch][law]", float,
                   double) {
    using T = TestType;
    using Bits = std::conditional_t<std::is_same_v<T, float>, std::uint32_t, std::uint64_t>;
    Random random{20};
    int different = 0, compared = 0;
    for (int n = 0; n < 3000; ++n) {
        // Heights of like and of wildly different size, shared by west and east, south and north.
        const auto height = [&] {
            return static_cast<T>(random.between(0.5, 1) *
                                  std::exp2(n % 2 == 0 ? 10 : random.whole(-40, 40)));
        };
        const T a = height(), b = height();
        const BilinearPatch<T> west{height(), a, height(), b}, east{a, height(), b, height()};
        const BilinearPatch<T> south{height(), height(), a, b}, north{a, b, height(), height()};
        for (int k = 0; k < 30; ++k) {
            const T w = k == 0 ? T(0) : k == 1 ? T(1) : static_cast<T>(random.unit());
            different += std::bit_cast<Bits>(west.height(1, w)) != std::bit_cast<Bits>(east.height(0, w));
            different += std::bit_cast<Bits>(south.height(w, 1)) != std::bit_cast<Bits>(north.height(w, 0));
            compared += 2;
        }
    }
    CHECK(compared == 180'000);
    CHECK(different == 0);
}

TEST_CASE("bilinear_patch: is a passive value and its arithmetic throws nothing", "[patch]") {
    using Patch = BilinearPatch<float>;
    constexpr Patch patch{1, 2, 3, 4};
    STATIC_REQUIRE(std::is_aggregate_v<Patch>);
    STATIC_REQUIRE(std::is_trivially_copyable_v<Patch>);
    STATIC_REQUIRE(sizeof(Patch) == 6 * sizeof(float));
    STATIC_REQUIRE(noexcept(patch.height(0, 0)));
    STATIC_REQUIRE(noexcept(patch.position(0, 0)));
    STATIC_REQUIRE(noexcept(patch.normal(0, 0)));
    STATIC_REQUIRE(patch.height(0.5f, 0.5f) == 2.5f);
}
