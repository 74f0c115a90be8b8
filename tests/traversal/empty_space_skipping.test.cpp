#include "catch.hpp"
#include "support/plain_first_hit.hpp"
#include "support/terrains.hpp"

#include <hfh/terrain/min_max_pyramid.hpp>
#include <hfh/traversal/first_hit.hpp>

#include <cmath>
#include <type_traits>
#include <vector>

// What first_hit passes over without a crossing test must not change its answer by a bit: it is compared with a traversal
// that tests every cell, on fields without bounds and with them.

using glm::dvec2;
using glm::dvec3;
using hfh::Block;
using hfh::Cell;
using hfh::FirstHitOptions;
using hfh::HitStatus;
using hfh::Index;
using hfh::Side;
using hfh::SurfaceKind;
using hfh::test::Random;
using hfh::test::Terrain;

namespace {

/// Counts how often a field is asked for a patch, and for bounds.
template <class Field>
struct Counting {
    using Scalar = typename Field::Scalar;
    Field field;
    Index* asked;
    Index* blocks = nullptr;

    [[nodiscard]] hfh::Lattice lattice() const noexcept { return field.lattice(); }
    [[nodiscard]] hfh::CellRange cells() const noexcept { return field.cells(); }
    [[nodiscard]] std::optional<hfh::BilinearPatch<Scalar>> patch(Cell c) const noexcept {
        ++*asked;
        return field.patch(c);
    }
    [[nodiscard]] int levels() const noexcept requires hfh::BoundedHeightField<Field> {
        return field.levels();
    }
    static constexpr int block_bits = 4;
    [[nodiscard]] hfh::HeightRange<Scalar>
    block_range(int level, Block one, Block other) const noexcept requires hfh::BoundedHeightField<Field> {
        static_assert(block_bits == Field::block_bits);
        ++*blocks;
        return field.block_range(level, one, other);
    }
};

/// A field in which one cell of three has no patch, whatever its neighbours have.
template <class Field>
struct Riddled {
    using Scalar = typename Field::Scalar;
    Field field;

    [[nodiscard]] hfh::Lattice lattice() const noexcept { return field.lattice(); }
    [[nodiscard]] hfh::CellRange cells() const noexcept { return field.cells(); }
    [[nodiscard]] std::optional<hfh::BilinearPatch<Scalar>> patch(Cell c) const noexcept {
        if ((c.i * c.i + 5 * c.j) % 3 == 0) return std::nullopt;
        return field.patch(c);
    }
};

/// Bounds that are made up where there is no such block: nobody may ask for them.
template <class Field>
struct Strict : Field {
    using Scalar = typename Field::Scalar;
    using Field::Field;

    [[nodiscard]] hfh::HeightRange<Scalar> block_range(int level, Block one, Block other) const noexcept {
        const Index side = Index{1} << (Field::block_bits + 2 * level);
        const auto exists = [&](Block block) {
            return level >= 0 && level < this->levels() &&
                   this->cells().contains({block.i * side, block.j * side});
        };
        if (!exists(one) || !exists(other)) return {Scalar(-1e30), Scalar(-1e30)};
        return Field::block_range(level, one, other);
    }
};

/// A terrain's grid with bounds.
template <class T>
class Bounded {
public:
    explicit Bounded(const Terrain<T>& ground)
        : storage_(static_cast<std::size_t>(hfh::MinMaxPyramid<T>::size(ground.columns, ground.rows))),
          grid{ground.grid(), storage_.data(), std::ssize(storage_)} {
        REQUIRE(grid.build() == hfh::PyramidStatus::ok);
    }
    Bounded(const Bounded&) = delete;
    Bounded& operator=(const Bounded&) = delete;

private:
    std::vector<hfh::SampleRange<T>> storage_;

public:
    Strict<hfh::BoundedGrid<T, hfh::HeightView<T>>> grid;
};

/// A terrain in steps of an eighth of a metre, as int16: with blocks half as wide.
template <class T>
class BoundedSteps {
public:
    using Samples = hfh::HeightView<std::int16_t, hfh::MissingValue<std::int16_t>>;
    using Bounds = hfh::MinMaxPyramid<std::int16_t>;

    explicit BoundedSteps(const Terrain<T>& ground)
        : samples_(steps(ground)),
          storage_(static_cast<std::size_t>(Bounds::size(ground.columns, ground.rows))),
          grid{{Samples{samples_.data(), ground.columns, ground.rows, {missing}},
                {ground.frame.origin, ground.frame.spacing, 0.125}},
               storage_.data(),
               std::ssize(storage_)} {
        STATIC_REQUIRE(Bounds::block_bits == 3 && hfh::MinMaxPyramid<T>::block_bits == 4);
        REQUIRE(grid.build() == hfh::PyramidStatus::ok);
    }
    BoundedSteps(const BoundedSteps&) = delete;
    BoundedSteps& operator=(const BoundedSteps&) = delete;

private:
    static constexpr std::int16_t missing = -32768;
    static std::vector<std::int16_t> steps(const Terrain<T>& ground) {
        std::vector<std::int16_t> made;
        for (const T height : ground.heights) {
            made.push_back(hfh::is_finite(height) ? static_cast<std::int16_t>(8 * height) : missing);
        }
        return made;
    }

    std::vector<std::int16_t> samples_;
    std::vector<hfh::SampleRange<std::int16_t>> storage_;

public:
    Strict<hfh::BoundedGrid<T, Samples>> grid;
};

struct SameAsPlain {
    int hits = 0, misses = 0, below = 0, none = 0;

    template <class Field>
    void operator()(const Field& field, const dvec3& a, const dvec3& b, const FirstHitOptions& options) {
        const auto plain = hfh::test::plain::first_hit(field, a, b, options);
        const auto found = hfh::first_hit(field, a, b, options);
        const bool agree = found.status == plain.status && found.t == plain.t && found.side == plain.side &&
                           found.point.cell == plain.point.cell && found.point.u == plain.point.u &&
                           found.point.v == plain.point.v && (found.cells > 0) == (plain.cells > 0);
        if (!agree) { // seldom: an assertion costs more than the search
            CAPTURE(a.x, a.y, a.z, b.x, b.y, b.z, options.leaves_within);
            CAPTURE(static_cast<int>(options.surface), static_cast<int>(options.side));
            CAPTURE(hfh::BoundedHeightField<Field>, plain.cells, found.cells);
            REQUIRE(found.status == plain.status);
            REQUIRE(found.t == plain.t);
            REQUIRE(found.side == plain.side);
            REQUIRE(found.point.cell.i == plain.point.cell.i);
            REQUIRE(found.point.cell.j == plain.point.cell.j);
            REQUIRE(found.point.u == plain.point.u);
            REQUIRE(found.point.v == plain.point.v);
            FAIL("only one of the two looked at a cell");
        }
        hits += plain.status == HitStatus::hit;
        misses += plain.status == HitStatus::miss;
        below += plain.side == Side::below;
        none += plain.side == Side::none;
    }

    /// With every option.
    template <class Field>
    void in_every_way(const Field& field, const dvec3& a, const dvec3& b) {
        for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
            for (const auto side : {Side::none, Side::above, Side::below}) {
                (*this)(field, a, b, {.surface = kind, .side = side});
                if (side == Side::none) continue;
                (*this)(field, a, b, {.surface = kind, .side = side, .leaves_within = 0});
                (*this)(field, a, b, {.surface = kind, .side = side, .leaves_within = 1e-3});
            }
        }
    }
};

/// Grounds of 40 × 30 cells, rough and smooth, near and far, with holes and without.
template <class T, class Each>
void each_ground(Each&& each) {
    const hfh::GridFrame frames[]{
        {{0, 0}, {1, 1}}, {{-30, 12.5}, {10, 2.5}}, {{1e7 + 0.125, -1e7}, {4, 16}}, {{0.1, 3.7}, {0.3, 0.7}}};
    std::uint64_t seed = 700;
    for (const auto& frame : frames) {
        for (const std::int64_t holes : {0, 200, 20}) {
            for (const bool hilly : {false, true}) {
                auto ground = hilly ? hfh::test::hills<T>(41, 31, 4, 13, frame)
                                    : hfh::test::rough_in_steps<T>(41, 31, 4, ++seed, frame);
                if (holes > 0) hfh::test::punch_holes(ground, holes, ++seed);
                each(ground);
            }
        }
    }
}

template <class T>
dvec2 somewhere(Random& random, const Terrain<T>& ground, double margin) {
    return ground.frame.origin + ground.frame.spacing * dvec2{random.between(-margin, 40 + margin),
                                                              random.between(-margin, 30 + margin)};
}
template <class T>
dvec2 vertex(Random& random, const Terrain<T>& ground) {
    return ground.frame.origin + ground.frame.spacing * dvec2{static_cast<double>(random.whole(0, 40)),
                                                              static_cast<double>(random.whole(0, 30))};
}

double nudged(Random& random, double x) {
    for (auto k = random.whole(-3, 3); k != 0; k += k > 0 ? -1 : 1) x = std::nextafter(x, k > 0 ? 1e9 : -1e9);
    return x;
}

} // namespace

TEMPLATE_TEST_CASE("empty-space skipping: passing over empty slabs changes no answer by a bit",
                   "[empty_space_skipping][first_hit][law][hard]", float, double) {
    using T = TestType;
    Random random{71};
    SameAsPlain same;
    each_ground<T>([&](const Terrain<T>& ground) {
        const auto grid = ground.grid();
        const Bounded<T> bounded{ground};
        const BoundedSteps<T> steps{ground};
        const Riddled<decltype(ground.grid())> riddled{grid};
        for (int n = 0; n < 1200; ++n) {
            dvec2 p = somewhere(random, ground, 2), q = somewhere(random, ground, 2);
            const dvec2 v = vertex(random, ground), w = vertex(random, ground),
                        spacing = ground.frame.spacing;
            switch (n % 12) {
            case 0:
            case 1: break;
            case 2: q = p + 0.02 * (q - p); break; // within a cell or two
            case 3: q = p + 0.1 * (q - p); break;
            case 4: p = v, q = w; break;
            case 5: q = 2.0 * v - p; break;                      // through a vertex
            case 6: p.x = v.x, q.x = v.x; break;                 // along a line
            case 7: p.y = v.y, q.y = nudged(random, v.y); break; // along it but for some ulps
            case 8: p = v, q = v + spacing * static_cast<double>(random.whole(-9, 9)); break; // diagonal
            case 9: q = p; break;                                                             // vertical
            case 10: p = {nudged(random, v.x), nudged(random, v.y)}; break;
            case 11: q = {nudged(random, v.x), nudged(random, v.y)}; break;
            }
            // High, low and about the tops; now and then exactly the height of one.
            const auto height = [&]() -> double {
                switch (random.whole(0, 5)) {
                case 0: return random.between(4, 12);
                case 1: return random.between(-12, -2);
                case 2: return nudged(random, 4);
                default: return random.between(-2, 6);
                }
            };
            const dvec3 a{p, height()}, b{q, height()};
            same.in_every_way(grid, a, b);
            same.in_every_way(bounded.grid, a, b);
            same.in_every_way(steps.grid, a, b);
            if (n % 4 == 0) same.in_every_way(riddled, a, b);
        }
    });
    CHECK(same.hits > 40'000);
    CHECK(same.misses > 40'000);
    CHECK(same.below > 20'000);
    CHECK(same.none > 20'000);
}

TEMPLATE_TEST_CASE("empty-space skipping: segments of a thousand cells keep their answer to the bit",
                   "[empty_space_skipping][first_hit][law]", float, double) {
    using T = TestType;
    Random random{72};
    SameAsPlain same;
    for (const bool tall : {false, true}) {
        const Index columns = tall ? 60 : 1200, rows = tall ? 1200 : 60;
        auto ground = hfh::test::hills<T>(columns, rows, 40, 37, {{-50, 1e5}, {0.7, 3.1}});
        for (const bool holes : {false, true}) {
            if (holes) hfh::test::punch_holes(ground, 2000, 73);
            const Bounded<T> bounded{ground};
            const BoundedSteps<T> steps{ground};
            for (int n = 0; n < 1000; ++n) {
                const auto place = [&] {
                    return ground.low() +
                           (ground.high() - ground.low()) * dvec2{random.unit(), random.unit()};
                };
                const dvec2 p = n % 5 == 0 ? ground.low() : place(), q = n % 5 == 0 ? ground.high() : place();
                const double z = random.between(15, 40), w = random.between(-20, 40);
                const auto kind = n % 2 == 0 ? SurfaceKind::solid : SurfaceKind::sheet;
                for (const double sign : {1.0, -1.0}) {
                    same(ground.grid(), {p, sign * z}, {q, sign * w}, {.surface = kind});
                    same(bounded.grid, {p, sign * z}, {q, sign * w}, {.surface = kind});
                    same(steps.grid, {p, sign * z}, {q, sign * w}, {.surface = kind});
                }
            }
        }
    }
    CHECK(same.hits > 4'000);
    CHECK(same.misses > 1'000);
}

TEMPLATE_TEST_CASE(
    "empty-space skipping: depths, whose height falls as they rise, keep their answer to the bit",
    "[empty_space_skipping][first_hit][law]", float, double) {
    using T = TestType;
    Random random{76};
    const auto ground = hfh::test::hills<T>(400, 300, 40, 37);
    std::vector<std::int16_t> depths;
    for (const T height : ground.heights) depths.push_back(static_cast<std::int16_t>(-8 * height));
    const hfh::BilinearGrid<T, hfh::HeightView<std::int16_t>> grid{
        {depths.data(), 400, 300}, {.spacing = {0.7, 3.1}, .height_scale = -0.125}};
    std::vector<hfh::SampleRange<std::int16_t>> storage(1 << 13);
    hfh::BoundedGrid bounded{grid, storage.data(), std::ssize(storage)};
    REQUIRE(bounded.build() == hfh::PyramidStatus::ok);
    const dvec2 size{399 * 0.7, 299 * 3.1};
    SameAsPlain same;
    for (int n = 0; n < 2000; ++n) {
        const dvec3 a{size * dvec2{random.unit(), random.unit()}, random.between(15, 40)},
            b{size * dvec2{random.unit(), random.unit()}, random.between(-20, 40)};
        same(grid, a, b, {});
        same(bounded, a, b, {});
    }
    CHECK(same.hits > 500);
    CHECK(same.misses > 500);
}

TEMPLATE_TEST_CASE("empty-space skipping: heights of every size, and neighbours of another one",
                   "[empty_space_skipping][first_hit][hard]", float, double) {
    using T = TestType;
    Random random{74};
    SameAsPlain same;
    for (int round = 0; round < 60; ++round) {
        const double size = std::exp2(random.whole(-100, 100));
        const auto ground = hfh::test::terrain<T>(16, 12, [&](Index, Index) {
            return size * random.between(-1, 1) * std::exp2(random.whole(-60, 0));
        });
        const auto grid = ground.grid();
        const Bounded<T> bounded{ground};
        for (int n = 0; n < 300; ++n) {
            const dvec2 p{random.between(0, 15), random.between(0, 11)},
                q{random.between(0, 15), random.between(0, 11)};
            const double z = size * random.between(-1, 1) * std::exp2(random.whole(-60, 1)),
                         w = size * random.between(-1, 1) * std::exp2(random.whole(-60, 1));
            same.in_every_way(grid, {p, z}, {q, w});
            same.in_every_way(bounded.grid, {p, z}, {q, w});
        }
    }
    CHECK(same.hits > 20'000);
    CHECK(same.misses > 20'000);
}

TEMPLATE_TEST_CASE(
    "empty-space skipping: a segment that grazes the ground to the ulp keeps its answer to the bit",
    "[empty_space_skipping][first_hit][law][hard]", float, double) {
    using T = TestType;
    Random random{76};
    SameAsPlain same;
    for (int round = 0; round < 400; ++round) {
        // Tops of one height, and some ground that is lower, by rounding or by far.
        const double top = random.between(0.5, 4) * (round % 2 == 0 ? 1.0 : 1000.0);
        const auto ground = hfh::test::terrain<T>(
            40, 20,
            [&](Index, Index) {
                const double kind = random.unit();
                return kind < 0.9 ? top : kind < 0.95 ? random.between(0, top) : top / 2;
            },
            {{0.1, -7}, {0.3, 1.7}});
        const auto grid = ground.grid();
        const Bounded<T> bounded{ground};
        const double highest = static_cast<double>(static_cast<T>(top));
        for (int n = 0; n < 60; ++n) {
            const dvec2 p{random.between(0, 39), random.between(0, 19)};
            dvec2 q = n % 3 == 0 ? p + dvec2{random.between(-1, 1), random.between(-1, 1)}
                                 : dvec2{random.between(0, 39), random.between(0, 19)};
            if (n % 5 == 0) q.y = p.y;
            const auto place = [&](const dvec2& at, double z) {
                return dvec3{ground.frame.origin + ground.frame.spacing * at, z};
            };
            // Level, or coming down to the tops at some line under way.
            const double line = std::round((p.x + q.x) / 2);
            const double slope = n % 2 == 0 || p.x == q.x ? 0 : random.between(-1, 1) * highest / (q.x - p.x);
            const dvec3 a = place(p, nudged(random, highest + slope * (p.x - line))),
                        b = place(q, nudged(random, highest + slope * (q.x - line)));
            same.in_every_way(grid, a, b);
            same.in_every_way(bounded.grid, a, b);
        }
    }
    CHECK(same.hits > 10'000);
    CHECK(same.misses > 10'000);
}

TEMPLATE_TEST_CASE(
    "empty-space skipping: it never looks at more cells than allowed, and goes on from where it stopped",
    "[empty_space_skipping][first_hit][law]", float, double) {
    using T = TestType;
    Random random{75};
    const auto ground = hfh::test::hills<T>(200, 200, 10, 17, {{-5, 3}, {0.5, 2}});
    const Bounded<T> bounded{ground};
    const auto with_limits = [&](const auto& grid) {
        int limited = 0;
        for (int n = 0; n < 3000; ++n) {
            const auto place = [&] {
                return ground.low() + (ground.high() - ground.low()) * dvec2{random.unit(), random.unit()};
            };
            const dvec3 a{place(), random.between(4, 9)}, b{place(), random.between(-4, 9)};
            const Index limit = random.whole(1, 60);
            Index asked = 0, blocks = 0;
            const Counting<std::remove_cvref_t<decltype(grid)>> counting{grid, &asked, &blocks};
            const auto plain = hfh::test::plain::first_hit(ground.grid(), a, b);
            dvec3 from = a;
            Side side = Side::none;
            double done = 0;
            for (int casts = 0;; ++casts) {
                REQUIRE(casts < 1000);
                asked = blocks = 0;
                const auto found = hfh::first_hit(counting, from, b, {.side = side, .max_cells = limit});
                REQUIRE(found.cells <=
                        std::max<Index>(limit, 4) + (hfh::BoundedHeightField<decltype(counting)> ? 4 : 0));
                // A slab asks for one cell or two, and once more where it is tested.
                REQUIRE(asked + blocks <= 4 * std::max<Index>(limit, 4) + 8);
                done += (1 - done) * found.t;
                side = found.side;
                if (found.status != HitStatus::cell_limit) {
                    CAPTURE(a.x, a.y, a.z, b.x, b.y, b.z, limit);
                    REQUIRE(found.status == plain.status);
                    if (found.status == HitStatus::hit) REQUIRE(done == Approx(plain.t).margin(1e-9));
                    break;
                }
                ++limited;
                from = from + found.t * (b - from);
            }
            // The same segment to its end.
            FirstHitOptions options{.max_cells = limit};
            auto found = hfh::first_hit(counting, a, b, options);
            for (; found.status == HitStatus::cell_limit; found = hfh::first_hit(counting, a, b, options))
                options.begin_at = found.t, options.side = found.side;
            REQUIRE(found.status == plain.status);
            REQUIRE(found.t == plain.t);
        }
        return limited;
    };
    CHECK(with_limits(ground.grid()) > 5'000);
    CHECK(with_limits(bounded.grid) > 2'000);
}

TEMPLATE_TEST_CASE("empty-space skipping: a long flight over low ground asks for few patches and tests none",
                   "[empty_space_skipping]", float, double) {
    using T = TestType;
    const auto ground = hfh::test::plane<T>(1001, 11, 0);
    Index asked = 0;
    const Counting<decltype(ground.grid())> counting{ground.grid(), &asked};
    const auto found = hfh::first_hit(counting, dvec3{0.5, 0.5, 5}, dvec3{999.5, 9.5, 1});
    CHECK(found.status == HitStatus::miss);
    CHECK(found.side == Side::above);
    CHECK(found.cells == 1009); // 1000 columns, 9 rows crossed
    CHECK(asked == 1018);       // one a column, two beside each of the 9 vertices it passes
    asked = 0;
    CHECK(hfh::first_hit(counting, dvec3{2.5, 2.5, 5}, dvec3{3.25, 3.25, 1}).cells == 4);
    CHECK(asked == 4);
}

TEMPLATE_TEST_CASE(
    "empty-space skipping: bounds let a long flight ask for few blocks and no patch, on either side",
    "[empty_space_skipping]", float, double) {
    using T = TestType;
    const auto ground = hfh::test::hills<T>(4001, 301, 10, 37);
    const Bounded<T> bounded{ground};
    Index asked = 0, blocks = 0;
    const Counting<std::remove_cvref_t<decltype(bounded.grid)>> counting{bounded.grid, &asked, &blocks};
    for (const double z : {12.0, -12.0}) {
        for (const bool back : {false, true}) {
            asked = blocks = 0;
            dvec3 a{0.5, 0.5, z}, b{3999.5, 299.5, 3 * z};
            if (back) std::swap(a, b);
            const auto found = hfh::first_hit(counting, a, b);
            CHECK(found.status == HitStatus::miss);
            CHECK(found.side == (z > 0 ? Side::above : Side::below));
            CHECK(asked == 0);
            CHECK(blocks <= 20); // one for each of twice as many levels, were there no other rows of blocks
            // From below the first block is asked twice: whether it lies below, and whether above.
            CHECK(found.cells == blocks - (z < 0 ? 1 : 0));
        }
    }
}

TEMPLATE_TEST_CASE("empty-space skipping: bounds help a flight along the diagonal of the blocks as well",
                   "[empty_space_skipping]", float, double) {
    using T = TestType;
    const auto ground = hfh::test::hills<T>(1025, 1025, 10, 38);
    const Bounded<T> bounded{ground};
    Index asked = 0, blocks = 0;
    const Counting<std::remove_cvref_t<decltype(bounded.grid)>> counting{bounded.grid, &asked, &blocks};
    for (const double z : {12.0, -12.0}) {
        for (const bool back : {false, true}) {
            for (const bool mirrored : {false, true}) {
                asked = blocks = 0;
                dvec3 a{8, mirrored ? 1016 : 8, z}, b{1016, mirrored ? 8 : 1016, z};
                if (back) std::swap(a, b);
                CHECK(hfh::first_hit(counting, a, b).side == (z > 0 ? Side::above : Side::below));
                CHECK(asked <= 8);   // around the ends, which are vertices
                CHECK(blocks <= 40); // two through each vertex, up six levels and down again
            }
        }
    }
}

TEMPLATE_TEST_CASE(
    "empty-space skipping: a peak in the block between two vertices is in the way of the diagonal",
    "[empty_space_skipping]", float, double) {
    using T = TestType;
    auto ground = hfh::test::hills<T>(1025, 1025, 10, 38);
    ground.at(505, 505) = T(50);
    const Bounded<T> bounded{ground};
    for (const bool back : {false, true}) {
        dvec3 a{8, 8, 12}, b{1016, 1016, 12};
        if (back) std::swap(a, b);
        const auto found = hfh::first_hit(bounded.grid, a, b);
        REQUIRE(found.status == HitStatus::hit);
        CHECK(found.point.cell == (back ? Cell{505, 505} : Cell{504, 504}));
    }
}
