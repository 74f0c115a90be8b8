#include "catch.hpp"
#include "support/random.hpp"
#include "support/terrains.hpp"

#include <hfh/terrain/bilinear_grid.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

using hfh::BilinearGrid;
using hfh::BilinearPatch;
using hfh::Cell;
using hfh::CellRange;
using hfh::GridFrame;
using hfh::GridStatus;
using hfh::HeightView;
using hfh::Index;
using hfh::MissingValue;
using hfh::Vertex;
using hfh::test::Random;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Heights that are a formula: no storage, no HeightView.
struct Formula {
    using SampleType = int;

    static constexpr Index columns() noexcept { return 5; }
    static constexpr Index rows() noexcept { return 4; }
    constexpr int operator()(Index i, Index j) const noexcept { return static_cast<int>(10 * i + j); }
    static constexpr bool missing(int sample) noexcept { return sample == 21; }
};

template <class T>
GridStatus status_of(const GridFrame& frame) {
    const std::array<std::uint8_t, 4> samples{1, 2, 3, 4};
    const BilinearGrid<T, HeightView<std::uint8_t>> grid{HeightView{samples.data(), 2, 2}, frame};
    // Whatever the status, asking is safe, and a grid that is not ok is empty.
    CHECK(grid.cells().empty() == (grid.status() != GridStatus::ok));
    const bool heights =
        hfh::is_height(static_cast<T>(4 * frame.height_scale) + static_cast<T>(frame.height_offset));
    CHECK(grid.patch({0, 0}).has_value() == (grid.status() == GridStatus::ok && heights));
    CHECK_FALSE(grid.patch({-1, 0}).has_value());
    return grid.status();
}

} // namespace

#define HFH_SCALARS_AND_SAMPLES                                                                              \
    (float, std::uint8_t), (float, std::uint16_t), (float, std::int16_t), (float, std::int32_t),             \
        (float, float), (float, double), (double, std::uint8_t), (double, std::uint16_t),                    \
        (double, std::int16_t), (double, std::int32_t), (double, float), (double, double)

TEMPLATE_PRODUCT_TEST_CASE("bilinear_grid: a patch is four neighbouring samples in metres", "[grid][law]",
                           (std::pair), (HFH_SCALARS_AND_SAMPLES)) {
    using T = typename TestType::first_type;
    using S = typename TestType::second_type;
    constexpr Index w = 5, h = 4;
    std::vector<S> samples;
    for (int n = 0; n < w * h; ++n) samples.push_back(static_cast<S>((n * 37) % 101));
    // Dyadic scale and offset and small samples: exact in float.
    const GridFrame frame{{100, 200}, {10, 2.5}, -0.25, 1000};
    const BilinearGrid<T, HeightView<S>> grid{HeightView{samples.data(), w, h}, frame};

    REQUIRE(grid.status() == GridStatus::ok);
    CHECK(grid.cells().begin == Cell{0, 0});
    CHECK(grid.cells().end == Cell{w - 1, h - 1});
    CHECK(grid.lattice().origin() == glm::dvec2{100, 200});
    CHECK(grid.lattice().spacing() == glm::dvec2{10, 2.5});
    CHECK(grid.heights().data() == samples.data());
    for (Index j = -2; j < h + 2; ++j) {
        for (Index i = -2; i < w + 2; ++i) {
            const auto patch = grid.patch({i, j});
            const bool inside = i >= 0 && i < w - 1 && j >= 0 && j < h - 1;
            REQUIRE(patch.has_value() == inside);
            if (!inside) continue;
            const auto metres = [&](Index column, Index row) {
                return static_cast<T>(1000 - 0.25 * static_cast<double>((column + row * w) * 37 % 101));
            };
            CHECK(patch->p00 == metres(i, j));
            CHECK(patch->p10 == metres(i + 1, j));
            CHECK(patch->p01 == metres(i, j + 1));
            CHECK(patch->p11 == metres(i + 1, j + 1));
            CHECK(patch->spacing == hfh::vec2<T>{T(10), T(2.5)});
        }
    }
}

TEMPLATE_TEST_CASE("bilinear_grid: the default frame is one metre per sample and per unit", "[grid]", float,
                   double) {
    using T = TestType;
    const std::array<T, 4> samples{T(1), T(2), T(3), T(4)};
    const BilinearGrid<T, HeightView<T>> grid{HeightView{samples.data(), 2, 2}, {}};
    const auto patch = grid.patch({0, 0});
    REQUIRE(patch);
    CHECK(patch->p00 == 1);
    CHECK(patch->p10 == 2);
    CHECK(patch->p01 == 3);
    CHECK(patch->p11 == 4);
    CHECK(patch->spacing == hfh::vec2<T>{T(1)});
    CHECK(grid.lattice().origin() == glm::dvec2{0});
}

TEMPLATE_TEST_CASE("bilinear_grid: heights round once from the sample and once from the frame", "[grid][law]",
                   float, double) {
    using T = TestType;
    const GridFrame frame{{0, 0}, {30, 30}, 0.1, -431.7};
    Random random{30};
    std::vector<std::uint16_t> samples;
    for (int n = 0; n < 100; ++n) samples.push_back(static_cast<std::uint16_t>(random.whole(0, 65535)));
    const BilinearGrid<T, HeightView<std::uint16_t>> grid{HeightView{samples.data(), 10, 10}, frame};
    for (Index j = 0; j < 9; ++j) {
        for (Index i = 0; i < 9; ++i) {
            const long double scaled = 0.1L * samples[static_cast<std::size_t>(i + 10 * j)];
            const auto found = static_cast<long double>(grid.patch({i, j})->p00);
            // Rounded to T: the scale and the product, the offset, the sum.
            const auto bound = 1.5L * static_cast<long double>(hfh::epsilon<T>) * (scaled + 432);
            CHECK(std::abs(found - (scaled - 431.7L)) <= bound);
        }
    }
}

TEMPLATE_TEST_CASE("bilinear_grid: says why a frame or a size is bad and is then empty", "[grid][hard]",
                   float, double) {
    using T = TestType;
    CHECK(status_of<T>({}) == GridStatus::ok);
    CHECK(status_of<T>({{-1e7, 1e7}, {1e-3, 1e4}, -2, 9000}) == GridStatus::ok);
    CHECK(status_of<T>({{0, 0}, {1, 1}, 0, 0}) == GridStatus::ok); // flat, but a terrain
    for (const double bad : {0.0, -0.0, -10.0, not_a_number, inf, -inf, 1e-310}) {
        CHECK(status_of<T>({{0, 0}, {bad, 1}}) == GridStatus::bad_spacing);
        CHECK(status_of<T>({{0, 0}, {1, bad}}) == GridStatus::bad_spacing);
    }
    for (const double bad : {not_a_number, inf, -inf}) {
        CHECK(status_of<T>({{bad, 0}, {1, 1}}) == GridStatus::bad_spacing);
        CHECK(status_of<T>({{0, bad}, {1, 1}}) == GridStatus::bad_spacing);
        CHECK(status_of<T>({{0, 0}, {1, 1}, bad}) == GridStatus::bad_height_scale);
        CHECK(status_of<T>({{0, 0}, {1, 1}, 1, bad}) == GridStatus::bad_height_scale);
    }
    const std::array<T, 4> samples{};
    for (const auto& [columns, rows] :
         {std::pair<Index, Index>{1, 4}, {4, 1}, {0, 0}, {1, 1}, {-3, 2}, {2, -3}}) {
        const BilinearGrid<T, HeightView<T>> grid{HeightView{samples.data(), columns, rows}, {}};
        CHECK(grid.status() == GridStatus::too_few_samples);
        CHECK(grid.cells().empty());
        CHECK_FALSE(grid.patch({0, 0}).has_value());
    }
}

TEST_CASE("bilinear_grid: a frame that only a double can hold is bad for float", "[grid][hard]") {
    CHECK(status_of<double>({{0, 0}, {1e60, 1e60}}) == GridStatus::ok);
    CHECK(status_of<float>({{0, 0}, {1e60, 1e60}}) == GridStatus::bad_spacing);
    CHECK(status_of<float>({{0, 0}, {1e-60, 1}}) == GridStatus::bad_spacing);
    CHECK(status_of<double>({{0, 0}, {1e-18, 1e-18}}) == GridStatus::ok);
    CHECK(status_of<float>({{0, 0}, {1e-18, 1e-18}}) == GridStatus::bad_spacing); // (dx·dy)² is 0
    CHECK(status_of<float>({{0, 0}, {1e12, 1e12}}) == GridStatus::bad_spacing);   // and infinite
    CHECK(status_of<double>({{0, 0}, {1, 1}, 1e60}) == GridStatus::ok);
    CHECK(status_of<float>({{0, 0}, {1, 1}, 1e60}) == GridStatus::bad_height_scale);
    CHECK(status_of<float>({{0, 0}, {1, 1}, 1, 1e60}) == GridStatus::bad_height_scale);
    CHECK(status_of<float>({{0, 0}, {1, 1}, 1e36}) == GridStatus::ok);
    CHECK(status_of<float>({{0, 0}, {1, 1}, 1e37}) == GridStatus::bad_height_scale); // times 255
}

TEMPLATE_TEST_CASE(
    "bilinear_grid: what it takes for a spacing gives normals of unit length and squares in range",
    "[grid][hard]", float, double) {
    using T = TestType;
    constexpr int most = std::is_same_v<T, float> ? 31 : 255, step = std::is_same_v<T, float> ? 1 : 8;
    const std::array<T, 4> level{};
    // As steep as heights below 2³¹ (float) or 2²⁵⁵ (double) make it.
    const T top = hfh::longest<T> * (1 - hfh::epsilon<T>);
    const std::array<T, 4> cliff{-top, top, top, -top};
    int taken = 0, refused = 0, wrong = 0;
    for (int x = -most - 8 * step; x <= most + 8 * step; x += step) {
        for (int y = -most - 8 * step; y <= most + 8 * step; y += step) {
            const glm::dvec2 spacing{std::exp2(x), std::exp2(y)};
            const BilinearGrid<T, HeightView<T>> grid{HeightView{level.data(), 2, 2}, {{0, 0}, spacing}};
            const bool in_range = std::abs(x) <= most && std::abs(y) <= most;
            if ((grid.status() == GridStatus::ok) != in_range) ++wrong;
            if (grid.status() != GridStatus::ok) {
                ++refused;
                CHECK(grid.status() == GridStatus::bad_spacing);
                CHECK(grid.cells().empty());
                continue;
            }
            ++taken;
            const auto flat = *grid.patch({0, 0});
            if (flat.normal(T(0.5), T(0.5)) != hfh::vec3<T>{0, 0, 1}) ++wrong;
            const T dx2 = flat.spacing.x * flat.spacing.x, dy2 = flat.spacing.y * flat.spacing.y;
            if (!std::isnormal(dx2) || !std::isnormal(dy2) || !std::isnormal(dx2 * dy2)) ++wrong;
            const BilinearPatch<T> steep{cliff[0], cliff[1], cliff[2], cliff[3], flat.spacing};
            for (const T u : {T(0), T(0.25), T(1)}) {
                const auto n = steep.normal(u, T(0));
                if (!(std::abs(static_cast<double>(glm::dot(n, n)) - 1) < 8 * hfh::widen(hfh::epsilon<T>)))
                    ++wrong;
            }
        }
    }
    CHECK(wrong == 0);
    CHECK(taken > 1000);
    CHECK(refused > 1000);
}

TEMPLATE_TEST_CASE(
    "bilinear_grid: cells of 1e-155 by 1e155 metres are refused, and those just inside are not",
    "[grid][hard]", float, double) {
    using T = TestType;
    CHECK(status_of<T>({{0, 0}, {1e-155, 1e155}}) == GridStatus::bad_spacing);
    CHECK(status_of<T>({{0, 0}, {1e155, 1e-155}}) == GridStatus::bad_spacing);
    CHECK(status_of<T>({{0, 0}, {1, 1e-155}}) == GridStatus::bad_spacing);
    const double most = hfh::widen(hfh::longest<T>), least = 1 / most;
    CHECK(status_of<T>({{0, 0}, {most, least}}) == GridStatus::ok);
    CHECK(status_of<T>({{0, 0}, {std::nextafter(most, inf), 1}}) == GridStatus::bad_spacing);
    CHECK(status_of<T>({{0, 0}, {1, std::nextafter(least, 0.0)}}) == GridStatus::bad_spacing);
}

TEMPLATE_TEST_CASE("bilinear_grid: a missing sample takes the patches around it and no other", "[grid]",
                   float, double) {
    using T = TestType;
    for (Index hole_j = 0; hole_j < 5; ++hole_j) {
        for (Index hole_i = 0; hole_i < 6; ++hole_i) {
            auto terrain = hfh::test::rough<T>(6, 5, 3, 31);
            terrain.remove(hole_i, hole_j);
            const auto grid = terrain.grid();
            std::array<std::int16_t, 6 * 5> samples{};
            samples[static_cast<std::size_t>(hole_i + 6 * hole_j)] = -9999;
            const HeightView view{samples.data(), 6, 5, MissingValue{-9999}};
            const BilinearGrid<T, std::remove_const_t<decltype(view)>> valued{view, {}};
            for (Index j = 0; j < 4; ++j) {
                for (Index i = 0; i < 5; ++i) {
                    const bool touches = (hole_i == i || hole_i == i + 1) && (hole_j == j || hole_j == j + 1);
                    CHECK(grid.patch({i, j}).has_value() == !touches);
                    CHECK(valued.patch({i, j}).has_value() == !touches);
                }
            }
        }
    }
}

TEMPLATE_TEST_CASE("bilinear_grid: holes by value and by rule are seen before the scale is applied", "[grid]",
                   float, double) {
    using T = TestType;
    const std::array<std::int16_t, 9> samples{1, 2, 3, 4, 5, 6, 7, 8, -32768};
    const GridFrame frame{{0, 0}, {1, 1}, 0.5, 10};
    const HeightView by_value{samples.data(), 3, 3, MissingValue{-32768}};
    const HeightView by_rule{samples.data(), 3, 3, [](std::int16_t sample) { return sample < 0; }};
    const BilinearGrid<T, decltype(by_value)> valued{by_value, frame};
    const BilinearGrid<T, std::remove_const_t<decltype(by_rule)>> ruled{by_rule, frame};
    for (Index n = 0; n < 4; ++n) {
        const Cell c{n % 2, n / 2};
        CHECK(valued.patch(c).has_value() == (n != 3));
        CHECK(ruled.patch(c).has_value() == (n != 3));
    }
    CHECK(valued.patch({0, 0})->p11 == T(12.5));
}

TEMPLATE_TEST_CASE("bilinear_grid: no patch has a height that is not finite", "[grid][hard]", float, double) {
    using T = TestType;
    // Finite as a sample, infinite in metres: the commonest no-data value of a raster of doubles in a float field,
    // and a sum that overflows in either.
    const double lowest = std::numeric_limits<double>::lowest();
    const std::array<double, 6> samples{1, 2, lowest, 3, 4, 5};
    for (const double scale : {1.0, 2.0, -2.0}) {
        const BilinearGrid<T, HeightView<double>> grid{HeightView{samples.data(), 3, 2},
                                                       {{0, 0}, {1, 1}, scale}};
        CHECK(grid.patch({0, 0}).has_value());
        if (const auto patch = grid.patch({1, 0})) {
            CHECK(hfh::is_finite(patch->lowest()));
            CHECK(hfh::is_finite(patch->highest()));
        }
    }
}

TEMPLATE_TEST_CASE("bilinear_grid: neighbouring patches share their corners to the bit", "[grid][law]", float,
                   double) {
    using T = TestType;
    const auto terrain = hfh::test::rough<T>(20, 15, 9000, 32, {{1e7, -1e7}, {0.3, 7.7}, 0.1, -0.7});
    const auto grid = terrain.grid();
    for (Index j = 0; j < 13; ++j) {
        for (Index i = 0; i < 18; ++i) {
            const auto here = *grid.patch({i, j}), east = *grid.patch({i + 1, j}),
                       north = *grid.patch({i, j + 1});
            CHECK(here.p10 == east.p00);
            CHECK(here.p11 == east.p01);
            CHECK(here.p01 == north.p00);
            CHECK(here.p11 == north.p10);
        }
    }
}

TEMPLATE_TEST_CASE("bilinear_grid: copies nothing and shows edited heights at once", "[grid]", float,
                   double) {
    using T = TestType;
    auto terrain = hfh::test::plane<T>(3, 3);
    const auto grid = terrain.grid();
    const auto copy = grid;
    STATIC_REQUIRE(std::is_trivially_copyable_v<typename hfh::test::Terrain<T>::Grid>);
    STATIC_REQUIRE(sizeof(grid) <= 160); // the same whatever the terrain
    CHECK(grid.patch({1, 1})->p00 == 0);
    terrain.at(1, 1) = T(7);
    CHECK(grid.patch({1, 1})->p00 == 7);
    CHECK(copy.patch({0, 0})->p11 == 7);
    terrain.remove(1, 1);
    CHECK_FALSE(grid.patch({1, 1}).has_value());
    terrain.at(1, 1) = T(1);
    CHECK(grid.patch({1, 1}).has_value());
}

TEMPLATE_TEST_CASE("bilinear_grid: a north-first raster is seen right way up", "[grid]", float, double) {
    using T = TestType;
    // North row first: the north-west sample is 1, the south-west 5.
    const std::array<std::uint16_t, 6> raster{1, 2, 3, 4, 5, 6};
    const auto view = HeightView{raster.data(), 2, 3}.flipped_rows();
    const BilinearGrid<T, HeightView<std::uint16_t>> grid{view, {}};
    const auto south = *grid.patch({0, 0}), north = *grid.patch({0, 1});
    CHECK(south.p00 == 5);
    CHECK(south.p10 == 6);
    CHECK(south.p01 == 3);
    CHECK(south.p11 == 4);
    CHECK(north.p01 == 1);
    CHECK(north.p11 == 2);
}

TEMPLATE_TEST_CASE("bilinear_grid: keeps its origin in double and its patches exact far out", "[grid][hard]",
                   float, double) {
    using T = TestType;
    const auto terrain =
        hfh::test::tilted_plane<T>(100, 100, 1, 2, 0, {{1e7 + 0.125, -1e7 - 0.125}, {10, 10}});
    const auto grid = terrain.grid();
    CHECK(grid.lattice().origin() == glm::dvec2{1e7 + 0.125, -1e7 - 0.125});
    const auto at = grid.lattice().locate(hfh::vec3<T>{T(1e7 + 424), T(-1e7 + 177), 0}, {42, 17});
    CHECK(at.u == T(0.3875));
    CHECK(at.v == T(0.7125));
    CHECK(grid.patch({42, 17})->height(0, 1) == 42 + 2 * 18);
}

TEMPLATE_TEST_CASE("bilinear_grid: looks at any heights that can be asked like a view", "[grid]", float,
                   double) {
    using T = TestType;
    using Grid = BilinearGrid<T, Formula>;
    STATIC_REQUIRE(hfh::HeightField<Grid>);
    const Grid grid{Formula{}, {{0, 0}, {1, 1}, 2}};
    CHECK(grid.cells().end == Cell{4, 3});
    CHECK(grid.patch({2, 1}) == std::nullopt);
    REQUIRE(grid.patch({3, 2}));
    CHECK(grid.patch({3, 2})->p00 == 64);
    CHECK(grid.patch({3, 2})->p10 == 84);
    CHECK(grid.patch({3, 2})->p01 == 66);
}

TEMPLATE_TEST_CASE("bilinear_grid: is a height field that throws nothing and can be const", "[grid]", float,
                   double) {
    using T = TestType;
    using Grid = BilinearGrid<T, HeightView<std::int16_t, MissingValue<std::int16_t>>>;
    STATIC_REQUIRE(hfh::HeightField<Grid>);
    STATIC_REQUIRE(hfh::HeightField<const Grid>);
    STATIC_REQUIRE(std::is_same_v<typename Grid::Scalar, T>);
    using Heights = HeightView<std::int16_t, MissingValue<std::int16_t>>;
    STATIC_REQUIRE(std::is_nothrow_constructible_v<Grid, Heights, const GridFrame&>);
    STATIC_REQUIRE(std::is_nothrow_copy_constructible_v<Grid>);
    const std::array<std::int16_t, 4> samples{};
    const Grid grid{Heights{samples.data(), 2, 2, MissingValue<std::int16_t>{-1}}, {}};
    STATIC_REQUIRE(noexcept(grid.patch(Cell{})));
    STATIC_REQUIRE(noexcept(grid.cells())&& noexcept(grid.lattice())&& noexcept(grid.status()));
    CHECK(grid.patch({0, 0}).has_value());
    // No index leaves the storage, however far.
    for (const Index far :
         {std::numeric_limits<Index>::min(), Index{-1}, Index{1}, std::numeric_limits<Index>::max()}) {
        CHECK_FALSE(grid.patch({far, 0}).has_value());
        CHECK_FALSE(grid.patch({0, far}).has_value());
    }
}

namespace {

struct NoCells {
    using Scalar = float;
    hfh::Lattice lattice() const noexcept;
    std::optional<BilinearPatch<float>> patch(Cell) const noexcept;
};
struct MayThrow {
    using Scalar = float;
    hfh::Lattice lattice() const noexcept;
    CellRange cells() const noexcept;
    std::optional<BilinearPatch<float>> patch(Cell) const;
};
struct OtherScalar {
    using Scalar = double;
    hfh::Lattice lattice() const noexcept;
    CellRange cells() const noexcept;
    std::optional<BilinearPatch<float>> patch(Cell) const noexcept;
};
struct NotConst {
    using Scalar = float;
    hfh::Lattice lattice() const noexcept;
    CellRange cells() const noexcept;
    std::optional<BilinearPatch<float>> patch(Cell) noexcept;
};
struct Whole {
    using Scalar = int;
    hfh::Lattice lattice() const noexcept;
    CellRange cells() const noexcept;
    std::optional<BilinearPatch<float>> patch(Cell) const noexcept;
};
struct Enough {
    using Scalar = float;
    const hfh::Lattice& lattice() const noexcept;
    static CellRange cells() noexcept;
    std::optional<BilinearPatch<float>> patch(Cell) const noexcept;
};

} // namespace

TEST_CASE("height_field: the concept asks for four names and takes nothing less", "[grid]") {
    STATIC_REQUIRE(hfh::HeightField<Enough>);
    STATIC_REQUIRE_FALSE(hfh::HeightField<NoCells>);
    STATIC_REQUIRE_FALSE(hfh::HeightField<MayThrow>);
    STATIC_REQUIRE_FALSE(hfh::HeightField<OtherScalar>);
    STATIC_REQUIRE_FALSE(hfh::HeightField<NotConst>);
    STATIC_REQUIRE_FALSE(hfh::HeightField<Whole>);
    STATIC_REQUIRE_FALSE(hfh::HeightField<int>);
}

TEMPLATE_PRODUCT_TEST_CASE(
    "bilinear_grid: six corners are below what two patches exist below, and nothing else", "[grid][law]",
    (std::pair), (HFH_SCALARS_AND_SAMPLES)) {
    using T = typename TestType::first_type;
    using S = typename TestType::second_type;
    constexpr Index w = 9, h = 7;
    Random random{23};
    std::vector<S> samples;
    for (Index n = 0; n < w * h; ++n) {
        if constexpr (std::is_floating_point_v<S>) {
            // Some that are no numbers, and some that are too large in metres.
            const double kinds[]{not_a_number, inf, -inf,
                                 0.9 * static_cast<double>(std::numeric_limits<S>::max())};
            const auto kind = random.whole(0, 40);
            samples.push_back(static_cast<S>(kind < 4 ? kinds[kind] : random.between(-100, 100)));
        } else {
            samples.push_back(static_cast<S>(random.whole(0, 30)));
        }
    }
    const HeightView view{samples.data(), w, h, MissingValue{S(21)}};
    for (const double scale : {-2.5, 0.75, 0.0}) {
        const BilinearGrid<T, HeightView<S, MissingValue<S>>> grid{view, {{1, 2}, {3, 4}, scale, 7}};
        STATIC_REQUIRE(hfh::CorneredHeightField<decltype(grid)>);
        int holes = 0, below = 0;
        // Two cells beside each other, one above the other, or one.
        for (const auto [di, dj] : {Cell{1, 0}, Cell{0, 1}, Cell{0, 0}}) {
            for (Index j = 0; j < h - 1 - dj; ++j) {
                for (Index i = 0; i < w - 1 - di; ++i) {
                    const Index k = i + di, m = j + dj;
                    const Vertex beside[]{{i, j}, {i, j + 1}, {k, j}, {k, j + 1}, {k + 1, j}, {k + 1, j + 1}},
                        above[]{{i, j}, {i + 1, j}, {i, m}, {i + 1, m}, {i, m + 1}, {i + 1, m + 1}};
                    const auto& six = di > 0 ? beside : above;
                    const auto one = grid.patch({i, j}), other = grid.patch({k, m});
                    if (!one || !other) {
                        ++holes;
                        CHECK_FALSE(grid.corners_below(six, std::numeric_limits<T>::max()));
                        continue;
                    }
                    const T highest = std::max(one->highest(), other->highest());
                    CHECK_FALSE(grid.corners_below(six, highest));
                    CHECK(grid.corners_below(six, std::nextafter(highest, std::numeric_limits<T>::max())));
                    ++below;
                }
            }
        }
        CHECK(holes > 0);
        CHECK(below > holes);
    }
}

namespace {
/// A source that leaves it to the grid to find out what is no number.
template <hfh::Sample S>
struct Trusting {
    using SampleType = S;
    const S* samples;
    [[nodiscard]] Index columns() const noexcept { return 2; }
    [[nodiscard]] Index rows() const noexcept { return 2; }
    [[nodiscard]] S operator()(Index i, Index j) const noexcept { return samples[i + 2 * j]; }
    [[nodiscard]] bool missing(S) const noexcept { return false; }
};
} // namespace

TEMPLATE_TEST_CASE("bilinear_grid: no number is below anything, whichever corner it is at", "[grid][law]",
                   float, double, long double) {
    using S = TestType;
    for (const double bad : {not_a_number, inf, -inf}) {
        for (int at = 0; at < 4; ++at) {
            S samples[]{1, 2, 3, 4};
            const BilinearGrid<double, Trusting<S>> grid{Trusting<S>{samples}, {}};
            const Vertex six[]{{0, 0}, {1, 0}, {0, 0}, {1, 0}, {0, 1}, {1, 1}};
            CHECK(grid.corners_below(six, 5));
            samples[at] = static_cast<S>(bad);
            CHECK_FALSE(grid.patch({0, 0}));
            CHECK_FALSE(grid.corners_below(six, 5));
        }
    }
}

TEST_CASE("bilinear_grid: the scalar may be chosen without naming the type of the heights",
          "[bilinear_grid]") {
    const float metres[] = {1, 2, 3, 4};
    const std::int16_t steps[] = {1, 2, 3, 4};
    const GridFrame frame{.spacing = {10.0, 10.0}};
    const hfh::BilinearGrid<float> of_floats{{metres, 2, 2}, frame};
    const auto of_integers = hfh::make_grid<float>(hfh::HeightView{steps, 2, 2}, frame);
    static_assert(
        std::is_same_v<decltype(of_integers), const hfh::BilinearGrid<float, hfh::HeightView<std::int16_t>>>);
    CHECK(of_floats.patch({0, 0})->p11 == 4);
    CHECK(of_integers.patch({0, 0})->p11 == 4);
}
