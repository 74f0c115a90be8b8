#include "catch.hpp"
#include "support/random.hpp"

#include <hfh/geometry/lattice.hpp>

#include <cmath>

using hfh::Cell;
using hfh::CellRange;
using hfh::Index;
using hfh::Lattice;
using hfh::vec3;
using hfh::test::Random;

TEST_CASE("lattice: a range holds its first cell and not its last", "[lattice]") {
    constexpr CellRange range{{-2, 3}, {4, 5}};
    STATIC_REQUIRE_FALSE(range.empty());
    int inside = 0;
    for (Index j = 0; j < 10; ++j) {
        for (Index i = -5; i < 10; ++i) {
            const bool expected = i >= -2 && i <= 3 && j >= 3 && j <= 4;
            CHECK(range.contains({i, j}) == expected);
            inside += range.contains({i, j});
        }
    }
    CHECK(inside == 12);
    STATIC_REQUIRE(CellRange{}.empty());
    STATIC_REQUIRE(CellRange{{0, 0}, {0, 5}}.empty());
    STATIC_REQUIRE(CellRange{{0, 0}, {5, -1}}.empty());
    STATIC_REQUIRE_FALSE(CellRange{}.contains({0, 0}));
}

namespace {
template <class To, class... From>
concept MadeOf = requires(From... from) {
    To{from...};
};
template <class A, class B>
concept Comparable = requires(A a, B b) {
    a == b;
};
} // namespace

TEST_CASE("lattice: a vertex is not a cell and a range of vertices not one of cells", "[lattice]") {
    using hfh::Vertex, hfh::VertexRange;
    STATIC_REQUIRE(VertexRange{}.empty());
    STATIC_REQUIRE(VertexRange{{1, 2}, {1, 5}}.empty());
    STATIC_REQUIRE(VertexRange{{1, 2}, {5, 2}}.empty());
    STATIC_REQUIRE_FALSE(VertexRange{{1, 2}, {2, 3}}.empty());
    STATIC_REQUIRE(Comparable<Vertex, Vertex>);
    STATIC_REQUIRE_FALSE(Comparable<Vertex, Cell>);
    STATIC_REQUIRE(MadeOf<VertexRange, Vertex, Vertex>);
    STATIC_REQUIRE_FALSE(MadeOf<VertexRange, Cell, Cell>);
    STATIC_REQUIRE_FALSE(MadeOf<CellRange, Vertex, Vertex>);
    STATIC_REQUIRE_FALSE(MadeOf<Vertex, Cell>);
    STATIC_REQUIRE_FALSE(MadeOf<Cell, Vertex>);
    STATIC_REQUIRE_FALSE(MadeOf<VertexRange, CellRange>);
}

TEST_CASE("lattice: an endless range ends where a double no longer counts halves of cells", "[lattice]") {
    constexpr CellRange range = CellRange::endless();
    STATIC_REQUIRE(range.contains({0, 0}));
    STATIC_REQUIRE(range.contains({-1'000'000'000'000, 1'000'000'000'000}));
    CHECK(static_cast<Index>(static_cast<double>(range.end.i)) == range.end.i);
    CHECK(range.end.i == 0x7'ffff'ffff'ffff);
    CHECK(range.begin.j == -0x7'ffff'ffff'ffff);
    CHECK(static_cast<Index>(static_cast<double>(range.begin.j) + 0.5) != range.begin.j);
}

TEMPLATE_TEST_CASE("lattice: an endless range leaves room for sums of four cell numbers, also in 32 bits",
                   "[lattice][hard]", std::int16_t, std::int32_t, std::int64_t) {
    using I = TestType;
    constexpr I far = hfh::detail::farthest_cell<I>();
    STATIC_REQUIRE(far > 0);
    STATIC_REQUIRE(far <= (std::numeric_limits<I>::max() - 1000) / 4);
    // A northing of 10 000 km in cells of 2 cm.
    STATIC_REQUIRE((sizeof(I) < 4 || far > 500'000'000));
}

TEST_CASE("lattice: the default has lines at whole metres", "[lattice]") {
    constexpr Lattice lattice;
    STATIC_REQUIRE(lattice.valid());
    STATIC_REQUIRE(lattice.u_of(2.75, 2) == 0.75);
    STATIC_REQUIRE(lattice.v_of(-0.25, -1) == 0.75);
}

TEST_CASE("lattice: refuses spacings that are not positive and numbers that are not finite",
          "[lattice][hard]") {
    constexpr double inf = std::numeric_limits<double>::infinity();
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(Lattice{{0, 0}, {1, 1}}.valid());
    CHECK(Lattice{{-1e300, 1e300}, {1e-300, 1e300}}.valid());
    for (const double bad : {inf, -inf, nan}) {
        CHECK_FALSE(Lattice{{bad, 0}, {1, 1}}.valid());
        CHECK_FALSE(Lattice{{0, bad}, {1, 1}}.valid());
    }
    // 1/1e-310 is infinite.
    for (const double bad : {0.0, -0.0, -1.0, 1e-310, inf, -inf, nan}) {
        CHECK_FALSE(Lattice{{0, 0}, {bad, 1}}.valid());
        CHECK_FALSE(Lattice{{0, 0}, {1, bad}}.valid());
    }
}

TEST_CASE("lattice: lines lie at origin plus a multiple of the spacing", "[lattice][law][eq:6][eq:7]") {
    // Powers of two and small whole numbers: every step is exact, so the answers are.
    const Lattice lattice{{100, -200}, {4, 0.5}};
    CHECK(lattice.origin() == glm::dvec2{100, -200});
    CHECK(lattice.spacing() == glm::dvec2{4, 0.5});
    CHECK(lattice.cells_per_metre() == glm::dvec2{0.25, 2});
    for (Index n = -20; n <= 20; ++n) {
        const auto line = static_cast<double>(n);
        CHECK(lattice.u_of(100 + 4 * line, n) == 0);
        CHECK(lattice.u_of(100 + 4 * line + 3, n) == 0.75);
        CHECK(lattice.v_of(-200 + 0.5 * line, n) == 0);
        CHECK(lattice.v_of(-200 + 0.5 * line + 0.125, n) == 0.25);
        CHECK(lattice.u_of(102, n) == 0.5 - line);
    }
}

TEMPLATE_TEST_CASE("lattice: locates points against long double also far from the origin of the world",
                   "[lattice][law][eq:6][eq:7]", float, double) {
    using T = TestType;
    constexpr auto eps = static_cast<double>(hfh::epsilon<double>);
    Random random{2};
    for (const double far : {0.0, 1e3, 1e7, -1e7}) {
        // 1e7 + 1/3 and a spacing of 0.3 are not floats; a lattice in float would be off by a third of a metre.
        const glm::dvec2 origin{far + 1.0 / 3, -far - 0.1}, spacing{10.0, 0.3};
        const Lattice lattice{origin, spacing};
        double worst_u = 0, worst_v = 0;
        for (int n = 0; n < 20'000; ++n) {
            const Cell c{random.whole(-4000, 4000), random.whole(-4000, 4000)};
            const auto ci = static_cast<double>(c.i), cj = static_cast<double>(c.j);
            const vec3<T> p{static_cast<T>(origin.x + (ci + random.between(-2, 3)) * spacing.x),
                            static_cast<T>(origin.y + (cj + random.between(-2, 3)) * spacing.y), T(7.5)};
            using Exact = long double;
            const Exact u = (Exact(p.x) - Exact(origin.x)) / Exact(spacing.x) - Exact(c.i);
            const Exact v = (Exact(p.y) - Exact(origin.y)) / Exact(spacing.y) - Exact(c.j);
            // Rounded: x − x₀, i·dx, their difference, 1/dx, the product; the first two by ε/2 of their own size,
            // and then the result once to T.
            const auto bound = [&](Exact w, Index line, T rounding) {
                const double cells = std::abs(static_cast<double>(line)) + 4;
                return eps / 2 * (2 * cells) + 1.5 * eps * std::abs(static_cast<double>(w)) +
                       static_cast<double>(rounding) / 2 * std::abs(static_cast<double>(w));
            };
            const auto at = lattice.locate(p, c);
            CHECK(at.z == p.z);
            worst_u = std::max(worst_u, static_cast<double>(std::abs(Exact(at.u) - u)) /
                                            bound(u, c.i, hfh::epsilon<T>));
            worst_v = std::max(worst_v, static_cast<double>(std::abs(Exact(at.v) - v)) /
                                            bound(v, c.j, hfh::epsilon<T>));
        }
        CAPTURE(far);
        CHECK(worst_u <= 1);
        CHECK(worst_v <= 1);
    }
}

TEMPLATE_TEST_CASE("lattice: a float point 10000 km out loses nothing but its own rounding",
                   "[lattice][hard]", float, double) {
    using T = TestType;
    // Floats are whole metres out there, the origin is not.
    const Lattice lattice{{1e7 + 0.25, -1e7 - 0.25}, {8, 8}};
    const auto at = lattice.locate(vec3<T>{T(10'000'043), T(-9'999'979), T(1)}, {5, 2});
    CHECK(at.u == T(0.34375)); // (42.75 − 40)/8
    CHECK(at.v == T(0.65625)); // (21.25 − 16)/8
}

TEMPLATE_TEST_CASE("lattice: reaches what an index can count and refuses the rest", "[lattice][hard]", float,
                   double) {
    using T = TestType;
    constexpr T inf = std::numeric_limits<T>::infinity(), nan = std::numeric_limits<T>::quiet_NaN();
    const Lattice lattice{{10, 20}, {2, 4}};
    CHECK(lattice.reaches(vec3<T>{0, 0, 0}));
    CHECK(lattice.reaches(vec3<T>{T(1e12), T(-1e12), 0}));
    // 2⁵¹ cells of 2 m and of 4 m.
    CHECK(lattice.reaches(vec3<T>{T(0x1p51), T(0x1p52), 0}));
    CHECK_FALSE(lattice.reaches(vec3<T>{T(0x1p53), 0, 0}));
    CHECK_FALSE(lattice.reaches(vec3<T>{-T(0x1p53), 0, 0}));
    CHECK_FALSE(lattice.reaches(vec3<T>{0, T(0x1p54), 0}));
    CHECK_FALSE(lattice.reaches(vec3<T>{0, -T(0x1p54), 0}));
    for (const T bad : {inf, -inf, nan, std::numeric_limits<T>::max()}) {
        CHECK_FALSE(lattice.reaches(vec3<T>{bad, 0, 0}));
        CHECK_FALSE(lattice.reaches(vec3<T>{0, bad, 0}));
    }
}

namespace {

// Called through pointers that are read at run time, so that the compiler does not know what goes in.
[[gnu::noinline]] hfh::CellPoint<float> locate_made_here(const Lattice& lattice, const double* p) {
    const vec3<float> at{static_cast<float>(p[0] * 0.25 + 1.0), static_cast<float>(p[1] * 0.25 + 1.0),
                         static_cast<float>(p[2])};
    return lattice.locate(at, {3, 4});
}
[[gnu::noinline]] hfh::CellPoint<float> locate_given(const Lattice& lattice, const vec3<float>& at) {
    return lattice.locate(at, {3, 4});
}

} // namespace

TEST_CASE("lattice: locates the float that it was given, not the double which that was made of",
          "[lattice][hard]") {
    // GCC 12 at -O2, inlined: u = 0.3 and v = 0.4 of the doubles, where the floats lie 0.003 m and 0.006 m from them.
    const Lattice lattice{{1e5, 2e5}, {1, 1}};
    const double p[3] = {4 * (1e5 + 3.3) - 4, 4 * (2e5 + 4.4) - 4, 0};
    hfh::CellPoint<float> (*volatile locate)(const Lattice&, const double*) = locate_made_here;
    const auto here = locate(lattice, p);
    const auto given = locate_given(
        lattice, {static_cast<float>(p[0] * 0.25 + 1.0), static_cast<float>(p[1] * 0.25 + 1.0), 0.0f});
    CHECK(here.u == given.u);
    CHECK(here.v == given.v);
    CHECK(here.u == 0.296875f);
    CHECK(here.v == 0.40625f);
}
