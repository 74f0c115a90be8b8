#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/random.hpp"
#include "support/real_terrains.hpp"
#include "support/terrains.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/terrain/min_max_pyramid.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

using hfh::BilinearGrid;
using hfh::Block;
using hfh::BoundedGrid;
using hfh::Cell;
using hfh::CellRange;
using hfh::GridFrame;
using hfh::HeightRange;
using hfh::HeightView;
using hfh::Index;
using hfh::MinMaxPyramid;
using hfh::MissingValue;
using hfh::PyramidStatus;
using hfh::SampleRange;
using hfh::VertexRange;
using hfh::test::Random;

namespace {

template <class S>
std::vector<SampleRange<S>> storage_for(Index columns, Index rows) {
    return std::vector<SampleRange<S>>(static_cast<std::size_t>(MinMaxPyramid<S>::size(columns, rows)));
}

/// Heights that are read through a function, as a user's own tiles are.
template <class S>
struct Tiled {
    using SampleType = S;
    const S* samples;
    Index width, height;

    Index columns() const noexcept { return width; }
    Index rows() const noexcept { return height; }
    S operator()(Index i, Index j) const noexcept { return samples[i + j * width]; }
    static bool missing(S sample) noexcept { return sample == S(7); }
};

/// The cells along a side of a block.
template <class S>
constexpr Index block_side(int level) {
    return Index{1} << (MinMaxPyramid<S>::block_bits + 2 * level);
}

/// The corners of the patches in the block, one by one: what the concept says that a range is.
template <class Field, class Grid>
HeightRange<typename Field::Scalar> by_patches(const Grid& grid, int level, Block block) {
    using T = typename Field::Scalar;
    constexpr T lowest = std::numeric_limits<T>::lowest(), highest = std::numeric_limits<T>::max();
    const Index side = block_side<typename Grid::SampleType>(level);
    const Cell last = grid.cells().end;
    HeightRange<T> range{highest, lowest};
    for (Index j = side * block.j; j < std::min(last.j, side * (block.j + 1)); ++j) {
        for (Index i = side * block.i; i < std::min(last.i, side * (block.i + 1)); ++i) {
            const auto patch = grid.patch({i, j});
            if (!patch) return {lowest, highest};
            for (const T corner : {patch->p00, patch->p10, patch->p01, patch->p11}) {
                range.lowest = std::min(range.lowest, corner);
                range.highest = std::max(range.highest, corner);
            }
        }
    }
    return range;
}

struct Count {
    int blocks = 0, holed = 0;
};

template <hfh::Real T>
bool same(const HeightRange<T>& a, const HeightRange<T>& b) {
    return a.lowest == b.lowest && a.highest == b.highest;
}

/// How many ranges of a block with one of its neighbours, on two sides, are not what bounds both, or nothing.
template <class Field>
Index wrong_beside(const Field& field, int level, Block block,
                   const HeightRange<typename Field::Scalar>& wanted) {
    using T = typename Field::Scalar;
    const Index side = block_side<typename Field::Grid::SampleType>(level);
    const Cell end = field.cells().end;
    Index wrong = 0;
    for (const Block other : {Block{block.i + 1, block.j}, Block{block.i, block.j + 1}}) {
        if (other.i * side >= end.i || other.j * side >= end.j) continue;
        const auto beside = by_patches<Field>(field.grid(), level, other);
        const HeightRange<T> both{std::min(wanted.lowest, beside.lowest),
                                  std::max(wanted.highest, beside.highest)};
        wrong += same(field.block_range(level, block, other), both) ? 0 : 1;
        wrong += same(field.block_range(level, other, block), both) ? 0 : 1;
    }
    return wrong;
}

/// Every block of every level against its patches.
template <class Field>
Count check_all(const Field& field) {
    Count count;
    Index wrong = 0;
    const Cell last = field.cells().end;
    for (int level = 0; level < field.levels(); ++level) {
        const Index side = block_side<typename Field::Grid::SampleType>(level);
        for (Index j = 0; j * side < last.j; ++j) {
            for (Index i = 0; i * side < last.i; ++i) {
                const auto wanted = by_patches<Field>(field.grid(), level, {i, j});
                const auto found = field.block_range(level, {i, j}, {i, j});
                wrong += same(found, wanted) ? 0 : 1;
                wrong += wrong_beside(field, level, {i, j}, wanted);
                ++count.blocks;
                count.holed += wanted.highest == std::numeric_limits<typename Field::Scalar>::max() ? 1 : 0;
            }
        }
        // The highest level is the first that has one block.
        const bool one = side >= last.i && side >= last.j;
        CHECK(one == (level == field.levels() - 1));
    }
    CHECK(wrong == 0);
    CHECK(count.blocks == MinMaxPyramid<typename Field::Grid::SampleType>::size(last.i + 1, last.j + 1));
    return count;
}

template <class T, class Heights>
Count build_and_check(const Heights& heights, const GridFrame& frame = {}) {
    const BilinearGrid<T, Heights> grid{heights, frame};
    auto storage = storage_for<typename Heights::SampleType>(heights.columns(), heights.rows());
    BoundedGrid field{grid, storage.data(), std::ssize(storage)};
    STATIC_REQUIRE(hfh::BoundedHeightField<decltype(field)>);
    CHECK(field.build() == PyramidStatus::ok);
    return check_all(field);
}

/// Anything that S can hold, so that the widest samples round on the way to metres, or small whole numbers.
template <class S>
std::vector<S> random_samples(Random& random, Index count, bool wide) {
    std::vector<S> samples;
    for (Index n = 0; n < count; ++n) {
        if constexpr (std::is_floating_point_v<S>) {
            samples.push_back(static_cast<S>(random.between(-1e4, 1e4)));
        } else if (wide) {
            samples.push_back(static_cast<S>(random.whole(std::numeric_limits<std::int64_t>::min() / 2,
                                                          std::numeric_limits<std::int64_t>::max() / 2) *
                                             2));
        } else {
            samples.push_back(static_cast<S>(random.whole(0, 100)));
        }
    }
    return samples;
}

constexpr std::array<std::pair<Index, Index>, 18> sizes{{{2, 2},
                                                         {2, 3},
                                                         {3, 2},
                                                         {9, 8},
                                                         {9, 10},
                                                         {16, 16},
                                                         {17, 17},
                                                         {18, 17},
                                                         {17, 18},
                                                         {33, 34},
                                                         {2, 100},
                                                         {100, 2},
                                                         {65, 65},
                                                         {66, 49},
                                                         {97, 120},
                                                         {131, 70},
                                                         {40, 300},
                                                         {4200, 20}}};

} // namespace

#define HFH_BOUNDED_SAMPLES                                                                                  \
    std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t, std::uint32_t, std::int64_t,       \
        std::uint64_t, float, double, long double

TEMPLATE_TEST_CASE("min_max_pyramid: every block of every level is bounded by its patches to the bit",
                   "[bounds][law]", HFH_BOUNDED_SAMPLES) {
    using S = TestType;
    Random random{40};
    for (const auto& [w, h] : sizes) {
        for (const double scale : {1.0, -0.1, 0.0}) {
            const auto samples = random_samples<S>(random, w * h, w % 2 == 0);
            const HeightView view{samples.data(), w, h};
            CHECK(build_and_check<double>(view, {{3, 4}, {1, 2}, scale, -431.7}).holed == 0);
            // Of wide integers only the smaller ones are heights in float, the others are holes.
            constexpr bool wide = std::is_integral_v<S> && std::numeric_limits<S>::digits > 30;
            const double small = wide ? std::ldexp(scale, 30 - std::numeric_limits<S>::digits) : scale;
            CHECK(build_and_check<float>(view.flipped_rows(), {{3, 4}, {1, 2}, small, -431.7}).holed == 0);
            if (wide) build_and_check<float>(view.flipped_rows(), {{3, 4}, {1, 2}, scale, -431.7});
        }
    }
    for (int n = 0; n < 10; ++n) {
        const Index w = random.whole(2, 90), h = random.whole(2, 90);
        const auto samples = random_samples<S>(random, w * h, false);
        build_and_check<double>(HeightView{samples.data(), w, h});
    }
}

TEMPLATE_TEST_CASE("min_max_pyramid: a lone peak or pit is in its blocks and in no other", "[bounds][hard]",
                   HFH_BOUNDED_SAMPLES) {
    using S = TestType;
    // Each sample in turn, those on the lines between blocks among them.
    const Index w = 35, h = 34;
    std::vector<S> samples(w * h, S(50));
    for (Index n = 0; n < w * h; ++n) {
        auto& sample = samples[static_cast<std::size_t>(n)];
        sample = n % 2 == 0 ? S(90) : S(10);
        const HeightView view{samples.data(), w, h};
        const BilinearGrid<double, HeightView<S>> grid{view, {}};
        auto storage = storage_for<S>(w, h);
        BoundedGrid field{grid, storage.data(), std::ssize(storage)};
        field.build();
        bool right = true;
        for (Index j = 0; j * block_side<S>(0) < h - 1; ++j) {
            for (Index i = 0; i * block_side<S>(0) < w - 1; ++i) {
                const auto wanted = by_patches<decltype(field)>(grid, 0, {i, j});
                const auto found = field.block_range(0, {i, j}, {i, j});
                right = right && found.lowest == wanted.lowest && found.highest == wanted.highest;
            }
        }
        CHECK(right);
        sample = S(50);
    }
}

TEMPLATE_TEST_CASE("min_max_pyramid: strides, flipped rows and alpha channels are read as a grid reads them",
                   "[bounds]", HFH_BOUNDED_SAMPLES) {
    using S = TestType;
    Random random{41};
    const Index w = 53, h = 41;
    const auto pixels = random_samples<S>(random, 4 * w * h, true);
    const HeightView alpha{pixels.data() + 3, w, h, 4, 4 * w};
    const HeightView padded{pixels.data() + 9, w, h, 1, 3 * w + 5};
    const HeightView transposed{pixels.data(), w, h, h, 1};
    const HeightView mirrored{pixels.data() + w - 1, w, h, -1, w};
    for (const auto& view : {alpha, padded, transposed, mirrored, alpha.flipped_rows(), padded.flipped_rows(),
                             transposed.flipped_rows(), mirrored.flipped_rows()}) {
        build_and_check<double>(view);
        build_and_check<float>(view);
    }
}

TEMPLATE_TEST_CASE("min_max_pyramid: a block with a missing sample bounds nothing, and only such a block",
                   "[bounds][hard]", HFH_BOUNDED_SAMPLES) {
    using S = TestType;
    Random random{42};
    Count all;
    for (const auto& [w, h] : sizes) {
        for (const int one_in : {5, 300, 3000}) {
            auto samples = random_samples<S>(random, w * h, false);
            for (auto& sample : samples) {
                if (sample == S(7)) sample = S(8);
                if (random.one_in(one_in)) sample = S(7);
            }
            const HeightView by_value{samples.data(), w, h, MissingValue{S(7)}};
            const HeightView by_rule{samples.data(), w, h, [](S sample) { return sample == S(7); }};
            const auto value = build_and_check<double>(by_value);
            const auto rule = build_and_check<float>(by_rule);
            build_and_check<float>(by_value.flipped_rows());
            const auto tiled = build_and_check<double>(Tiled<S>{samples.data(), w, h});
            if (h > 2) {
                const HeightView every_other{samples.data(), w / 2 + 1, h - 1, 2, w, MissingValue{S(7)}};
                build_and_check<float>(every_other);
            }
            CHECK(value.holed == rule.holed);
            CHECK(value.holed == tiled.holed);
            all.blocks += value.blocks;
            all.holed += value.holed;
        }
    }
    CHECK(all.holed > 50);
    CHECK(all.blocks - all.holed > 50);
}

TEMPLATE_TEST_CASE("min_max_pyramid: a hole's value may lie below, above or among all heights",
                   "[bounds][hard]", HFH_BOUNDED_SAMPLES) {
    using S = TestType;
    // Some blocks, with and without a hole in one that is off the border.
    const Index side = 49;
    const int levels = MinMaxPyramid<S>{nullptr, 0, side, side}.levels();
    for (const int value : {0, 9, 10, 50, 51, 99, 100, 127}) {
        for (const bool with_hole : {false, true}) {
            std::vector<S> samples;
            for (Index n = 0; n < side * side; ++n) samples.push_back(static_cast<S>(10 + 2 * (n % 45)));
            for (auto& sample : samples) {
                if (sample == static_cast<S>(value)) sample = S(20);
            }
            if (with_hole) samples[20 * side + 20] = static_cast<S>(value);
            const HeightView view{samples.data(), side, side, MissingValue{static_cast<S>(value)}};
            const int holed = with_hole ? levels : 0; // its block on each
            CHECK(build_and_check<double>(view).holed == holed);
            CHECK(build_and_check<float>(view.flipped_rows(), {{0, 0}, {1, 1}, -1.0}).holed == holed);
        }
    }
}

TEMPLATE_TEST_CASE("min_max_pyramid: samples at both ends of their type are not taken for a hole",
                   "[bounds][hard]", HFH_BOUNDED_SAMPLES) {
    using S = TestType;
    using Limits = std::numeric_limits<S>;
    std::vector<S> samples(20 * 20, S(1));
    samples[5] = Limits::lowest();
    samples[7] = Limits::max();
    MinMaxPyramid<S> bounds;
    auto storage = storage_for<S>(20, 20);
    bounds = {storage.data(), std::ssize(storage), 20, 20};
    CHECK(bounds.build(HeightView{samples.data(), 20, 20}) == PyramidStatus::ok);
    if constexpr (!std::is_same_v<S, long double>) { // which holds numbers that no height can be
        CHECK(bounds.range(0, {0, 0}).lowest == Limits::lowest());
        CHECK(bounds.range(0, {0, 0}).highest == Limits::max());
        CHECK_FALSE(bounds.range(0, {0, 0}).holed());
    }
    CHECK(bounds.range(0, {1, 1}).lowest == S(1));
    CHECK(bounds.range(0, {1, 1}).highest == S(1));
    for (const S all : {Limits::lowest(), Limits::max()}) {
        std::fill(samples.begin(), samples.end(), all);
        if (std::is_same_v<S, long double>) continue;
        bounds.build(HeightView{samples.data(), 20, 20});
        CHECK_FALSE(bounds.range(1, {0, 0}).holed());
        CHECK(bounds.range(1, {0, 0}).lowest == all);
        CHECK(bounds.range(1, {0, 0}).highest == all);
    }
}

TEMPLATE_TEST_CASE("min_max_pyramid: what is not finite is a hole, whatever its source says",
                   "[bounds][hard]", float, double, long double) {
    using S = TestType;
    struct Careless : Tiled<S> {
        static bool missing(S) noexcept { return false; }
    };
    Random random{43};
    for (const S bad : {std::numeric_limits<S>::quiet_NaN(), std::numeric_limits<S>::infinity(),
                        -std::numeric_limits<S>::infinity()}) {
        for (int n = 0; n < 20; ++n) {
            const Index w = 50, h = 37;
            auto samples = random_samples<S>(random, w * h, false);
            samples[static_cast<std::size_t>(random.whole(0, w * h - 1))] = bad;
            const HeightView view{samples.data(), w, h};
            const auto plain = build_and_check<double>(view);
            CHECK(plain.holed >= 2);
            CHECK(plain.holed < plain.blocks);
            CHECK(build_and_check<float>(HeightView{samples.data(), w, h, MissingValue{S(2e5)}}).holed ==
                  plain.holed);
            CHECK(build_and_check<double>(Careless{{samples.data(), w, h}}).holed == plain.holed);
        }
    }
}

TEST_CASE("min_max_pyramid: a finite sample that is no finite height bounds nothing", "[bounds][hard]") {
    std::vector<double> samples(40 * 40, 1);
    const HeightView view{samples.data(), 40, 40};
    samples[40 * 30 + 5] = -1e75;                   // below 2²⁵⁵ in size
    CHECK(build_and_check<float>(view).holed == 2); // on each of two levels
    CHECK(build_and_check<double>(view).holed == 0);
    CHECK(build_and_check<double>(view, {{0, 0}, {1, 1}, -1e3}).holed > 0);
    samples[40 * 30 + 5] = -1.7e308;
    CHECK(build_and_check<double>(view).holed == 2);
}

TEMPLATE_TEST_CASE("min_max_pyramid: after an edit an update of the samples equals a new build",
                   "[bounds][law]", std::uint8_t, std::int16_t, float, double) {
    using S = TestType;
    Random random{44};
    int changed = 0;
    for (int n = 0; n < 40; ++n) {
        const Index w = random.whole(2, 200), h = random.whole(2, 200);
        auto samples = random_samples<S>(random, w * h, false);
        const HeightView view{samples.data(), w, h, MissingValue{S(101)}};
        auto updated = storage_for<S>(w, h), built = updated, before = updated;
        MinMaxPyramid<S> bounds{updated.data(), std::ssize(updated), w, h};
        MinMaxPyramid<S> fresh{built.data(), std::ssize(built), w, h};
        bounds.build(view);
        for (int edit = 0; edit < 20; ++edit) {
            // Brushes of all sizes, some of them partly or wholly beside the terrain.
            const Index reach = edit % 4 == 0 ? 120 : 12;
            VertexRange brush{{random.whole(-10, w), random.whole(-10, h)}, {}};
            brush.end = {brush.begin.i + random.whole(0, reach), brush.begin.j + random.whole(0, reach)};
            const S height = static_cast<S>(random.whole(0, 120));
            for (Index j = std::max<Index>(0, brush.begin.j); j < std::min(h, brush.end.j); ++j) {
                for (Index i = std::max<Index>(0, brush.begin.i); i < std::min(w, brush.end.i); ++i) {
                    samples[static_cast<std::size_t>(i + j * w)] = height;
                }
            }
            before = updated;
            CHECK(bounds.update(view, brush) == PyramidStatus::ok);
            fresh.build(view);
            bool same = true;
            for (std::size_t k = 0; k < built.size(); ++k) {
                same = same && updated[k].lowest == built[k].lowest && updated[k].highest == built[k].highest;
                changed += updated[k].lowest != before[k].lowest ? 1 : 0;
            }
            CHECK(same);
        }
    }
    CHECK(changed > 1000);
}

TEST_CASE("min_max_pyramid: an update reads the blocks under the brush and no other", "[bounds]") {
    struct Counting : Tiled<std::int16_t> {
        mutable Index* reads = nullptr;
        std::int16_t operator()(Index i, Index j) const noexcept {
            ++*reads;
            return Tiled::operator()(i, j);
        }
    };
    const Index side = 1000;
    const std::vector<std::int16_t> samples(side * side, 3);
    Index reads = 0;
    const Counting heights{{samples.data(), side, side}, &reads};
    auto storage = storage_for<std::int16_t>(side, side);
    MinMaxPyramid<std::int16_t> bounds{storage.data(), std::ssize(storage), side, side};
    bounds.build(heights);
    const Index wide = block_side<std::int16_t>(0), whole = (side - 1) / wide;
    const Index in_row = whole * (wide + 1) + (side - 1) % wide + 1; // whole blocks, and one cut off
    const Index once = in_row * in_row;
    const Index for_all = reads;
    CHECK(for_all >= once);
    const auto cost = [&](const VertexRange& brush) {
        reads = 0;
        bounds.update(heights, brush);
        return reads;
    };
    // What a grid of one block takes.
    reads = 0;
    MinMaxPyramid<std::int16_t> one{storage.data(), std::ssize(storage), wide + 1, wide + 1};
    one.build(Counting{{samples.data(), wide + 1, wide + 1}, &reads});
    const auto at_most = [one_block = reads](Index blocks) { return blocks * one_block; };
    for (Index k = 0; k < 40; ++k) {
        CHECK(cost({{500 + k, 600 - k}, {500 + k + wide, 600 - k + wide}}) <= at_most(4));
    }
    CHECK(cost({{505, 505}, {506, 506}}) <= at_most(1));
    CHECK(cost({{505, 505}, {506, 506}}) > 0);
    CHECK(cost({{512, 512}, {513, 513}}) > at_most(1)); // a corner of four blocks
    CHECK(cost({{512, 512}, {513, 513}}) <= at_most(4));
    // Nothing to do, and no arithmetic that overflows.
    constexpr Index far = std::numeric_limits<Index>::max(), near = std::numeric_limits<Index>::min();
    CHECK(cost({{5, 5}, {5, 9}}) == 0);
    CHECK(cost({{9, 9}, {5, 5}}) == 0);
    CHECK(cost({{near, near}, {0, 0}}) == 0);
    CHECK(cost({{1000, 0}, {far, 5}}) == 0);
    CHECK(cost({{far, far}, {near, near}}) == 0);
    CHECK(cost({{near, near}, {far, far}}) == for_all);
}

TEMPLATE_TEST_CASE("min_max_pyramid: all levels take at most 0.1 byte a sample but in small grids",
                   "[bounds]", HFH_BOUNDED_SAMPLES) {
    using S = TestType;
    using Bounds = MinMaxPyramid<S>;
    STATIC_REQUIRE(sizeof(SampleRange<S>) == 2 * sizeof(S));
    const auto bytes_a_sample = [](Index columns, Index rows) {
        return static_cast<double>(Bounds::size(columns, rows)) * sizeof(SampleRange<S>) /
               (static_cast<double>(columns) * static_cast<double>(rows));
    };
    const double widest = sizeof(S) > 8 ? 0.2 : 0.1;
    const auto side = static_cast<double>(block_side<S>(0));
    const double in_large_grids = 2 * sizeof(S) / (side * side) * 16 / 15;
    for (const auto& [w, h] : std::vector<std::pair<Index, Index>>{{541, 511},
                                                                   {1405, 1112},
                                                                   {1393, 1089},
                                                                   {4097, 4097},
                                                                   {16385, 16385},
                                                                   {32768, 32768},
                                                                   {1000, 100'000},
                                                                   {1'000'000, 1'000'000}}) {
        CHECK(bytes_a_sample(w, h) <= widest);
        CHECK(bytes_a_sample(w, h) >= 0.99 * in_large_grids);
    }
    // 2 bytes a sample: 0.067 in a large grid; small ones pay for the blocks cut off at the border.
    CHECK(bytes_a_sample(1405, 1112) <= 1.0176 * in_large_grids);
    constexpr Index one = block_side<S>(0) + 1; // samples
    CHECK(Bounds::size(2, 2) == 1);
    CHECK(Bounds::size(one, one) == 1);
    CHECK(Bounds::size(one + 1, one) == 2 + 1);
    CHECK(Bounds::size(one + 1, one + 1) == 4 + 1);
    CHECK(Bounds::size(100, 100) == (sizeof(S) <= 2 ? 169 + 16 + 1 : 49 + 4 + 1));
    CHECK(bytes_a_sample(100, 100) <= 1.3 * in_large_grids);
    CHECK(bytes_a_sample(2, 2) == 0.5 * sizeof(S));
    for (Index w = 300; w < 340; ++w) CHECK(bytes_a_sample(w, w + 7) <= widest);
    // Nothing for what has no cell; and no overflow.
    for (const Index few : {Index{-5}, Index{0}, Index{1}, std::numeric_limits<Index>::min()}) {
        CHECK(Bounds::size(few, 9) == 0);
        CHECK(Bounds::size(9, few) == 0);
    }
    constexpr Index most = std::numeric_limits<Index>::max();
    CHECK(Bounds::size(most, most) == most);
    CHECK(Bounds::size(most, 2) > most / 16);
}

TEMPLATE_TEST_CASE("min_max_pyramid: says why it bounds nothing, and the surface is there all the same",
                   "[bounds][hard]", float, double) {
    using T = TestType;
    using Grid = BilinearGrid<T, HeightView<std::int16_t>>;
    const std::vector<std::int16_t> samples(40 * 30, 3);
    const Grid grid{HeightView{samples.data(), 40, 30}, {}};
    auto storage = storage_for<std::int16_t>(40, 30);
    const auto nothing = [](const HeightRange<T>& range) {
        return range.lowest == std::numeric_limits<T>::lowest() &&
               range.highest == std::numeric_limits<T>::max();
    };
    const auto check_casts = [&](const auto& field) { // over all of it, and into it
        for (const double z : {9.0, -9.0}) {
            const auto with = hfh::first_hit(field, {0.5, 28.5, 9}, {38.5, 0.5, z});
            const auto plain = hfh::first_hit(grid, {0.5, 28.5, 9}, {38.5, 0.5, z});
            CHECK(with.status == (z > 0 ? hfh::HitStatus::miss : hfh::HitStatus::hit));
            CHECK(with.t == plain.t);
            CHECK(with.side == plain.side);
        }
    };
    // Too little storage, or none.
    for (const Index count : {std::ssize(storage) - 1, Index{0}, Index{-1}}) {
        BoundedGrid field{grid, storage.data(), count};
        CHECK(field.status() == PyramidStatus::too_little_storage);
        CHECK(field.build() == PyramidStatus::too_little_storage);
        CHECK(field.update({{0, 0}, {9, 9}}) == PyramidStatus::too_little_storage);
        CHECK(field.levels() == 0);
        CHECK(field.bounds().levels() == 3);
        CHECK(field.bounds().range(0, {0, 0}).holed());
        CHECK(field.patch({38, 28}).has_value());
        check_casts(field);
        CHECK(storage[0].holed());
    }
    CHECK(BoundedGrid{grid, nullptr, 1000}.build() == PyramidStatus::too_little_storage);

    // Storage as it is made, before the first build; then no index leaves it.
    BoundedGrid field{grid, storage.data(), std::ssize(storage)};
    CHECK(field.status() == PyramidStatus::ok);
    CHECK(field.levels() == 3);
    check_casts(field);
    CHECK(nothing(field.block_range(0, {0, 0}, {1, 0})));
    CHECK(nothing(field.block_range(2, {0, 0}, {0, 0})));
    CHECK(field.build() == PyramidStatus::ok);
    CHECK_FALSE(nothing(field.block_range(2, {0, 0}, {0, 0})));
    CHECK_FALSE(nothing(field.block_range(0, {4, 3}, {4, 2})));
    CHECK_FALSE(field.bounds().range(0, {4, 3}).holed());
    constexpr Index far = std::numeric_limits<Index>::max(), near = std::numeric_limits<Index>::min();
    for (const Block beside :
         {Block{5, 0}, Block{0, 4}, Block{-1, 0}, Block{0, -1}, Block{far, far}, Block{near, 0}}) {
        CHECK(field.bounds().range(0, beside).holed());
    }
    for (const int level : {-1, 3, std::numeric_limits<int>::max()}) {
        CHECK(field.bounds().range(level, {0, 0}).holed());
    }

    // A grid without cells.
    for (const Grid& empty : {Grid{HeightView{samples.data(), 1, 30}, {}},
                              Grid{HeightView{samples.data(), 40, 30}, {{0, 0}, {0, 1}}}}) {
        BoundedGrid none{empty, storage.data(), std::ssize(storage)};
        CHECK(none.status() == PyramidStatus::too_few_samples);
        CHECK(none.build() == PyramidStatus::too_few_samples);
        CHECK(none.cells().empty());
        CHECK(none.levels() == 0);
        CHECK(none.bounds().range(0, {0, 0}).holed());
    }
    CHECK(MinMaxPyramid<std::int16_t>{}.status() == PyramidStatus::too_few_samples);

    // Heights of another size.
    MinMaxPyramid<std::int16_t> bounds{storage.data(), std::ssize(storage), 40, 30};
    CHECK(bounds.build(HeightView{samples.data(), 30, 40}) == PyramidStatus::other_size);
    CHECK(bounds.update(HeightView{samples.data(), 40, 29}, {{0, 0}, {1, 1}}) == PyramidStatus::other_size);
    CHECK_FALSE(bounds.range(0, {0, 0}).holed());
}

TEMPLATE_TEST_CASE("min_max_pyramid: builds, updates and answers without allocating or throwing",
                   "[bounds][realtime]", float, double) {
    using T = TestType;
    auto terrain = hfh::test::hills<T>(300, 200, 50, 40);
    auto storage = storage_for<T>(300, 200);
    const auto before = hfh::test::allocations();
    BoundedGrid field{terrain.grid(), storage.data(), std::ssize(storage)};
    field.build();
    terrain.at(50, 60) = 900;
    field.update({{50, 60}, {51, 61}});
    const auto range = field.block_range(field.levels() - 1, {0, 0}, {0, 0});
    const auto after = hfh::test::allocations();
    CHECK(after == before);
    CHECK(range.highest == 900);
    using Field = decltype(field);
    STATIC_REQUIRE(noexcept(field.build())&& noexcept(field.update(VertexRange{})));
    STATIC_REQUIRE(noexcept(field.block_range(0, Block{}, Block{}))&& noexcept(field.levels()));
    STATIC_REQUIRE(std::is_trivially_copyable_v<Field>);
    STATIC_REQUIRE(hfh::BoundedHeightField<Field>);
    STATIC_REQUIRE(hfh::BoundedHeightField<const Field>);
    STATIC_REQUIRE_FALSE(hfh::BoundedHeightField<typename Field::Grid>);
    STATIC_REQUIRE(hfh::HeightField<Field>);
}

TEST_CASE("min_max_pyramid: casts among denormal heights end on the same side with bounds and without",
          "[bounds][hard]") {
    // Bounds of rounding that are shares of a height are 0 there. Over level 0, from −5e−324 to 5e−324, a cast with bounds
    // once ended below.
    constexpr double tiny = std::numeric_limits<double>::denorm_min();
    Random random{4711};
    constexpr Index w = 40, h = 48;
    std::vector<double> samples(w * h);
    const HeightView view{samples.data(), w, h};
    const BilinearGrid plain{view, {.origin = {-1, -6}, .spacing = {1, 2}}};
    std::vector<SampleRange<double>> storage(static_cast<std::size_t>(MinMaxPyramid<double>::size(w, h)));
    BoundedGrid bounded{plain, storage.data(), std::ssize(storage)};
    int differ = 0, hits = 0;
    for (int round = 0; round < 200; ++round) {
        const int relief = round % 4 == 0 ? 0 : round % 4 * 3;
        for (double& z : samples) z = tiny * static_cast<double>(random.whole(-relief, relief));
        REQUIRE(bounded.build() == PyramidStatus::ok);
        const auto end = [&] {
            return glm::dvec3{random.between(-3, 40), random.between(-8, 92),
                              tiny * static_cast<double>(random.whole(-20, 20))};
        };
        for (int n = 0; n < 100; ++n) {
            const glm::dvec3 a = end(), b = end();
            const auto one = first_hit(plain, a, b), other = first_hit(bounded, a, b);
            hits += one.status == hfh::HitStatus::hit;
            differ += one.status != other.status || one.side != other.side || one.t != other.t ||
                      one.point.cell != other.point.cell || one.point.u != other.point.u ||
                      one.point.v != other.point.v;
        }
    }
    CHECK(differ == 0);
    CHECK(hits > 1000);
    for (double& z : samples) z = 0;
    REQUIRE(bounded.build() == PyramidStatus::ok);
    const glm::dvec3 a{1.5, 61.25, -tiny}, b{1.625, 46, tiny};
    CHECK(first_hit(plain, a, b).side == hfh::Side::above);
    CHECK(first_hit(bounded, a, b).side == hfh::Side::above);
}

TEMPLATE_TEST_CASE("min_max_pyramid: a tracker over a grid with bounds feels what one over the grid feels",
                   "[bounds][law]", float, double) {
    using T = TestType;
    auto terrain = hfh::test::hills<T>(120, 90, 12, 17, {{-5, 40}, {1, 1}, -1, 3});
    hfh::test::punch_holes(terrain, 2000, 45);
    auto storage = storage_for<T>(120, 90);
    const auto grid = terrain.grid();
    BoundedGrid field{grid, storage.data(), std::ssize(storage)};
    field.build();
    hfh::ProxyTracker plain{grid};
    hfh::ProxyTracker bounded{field};
    Random random{46};
    int touching = 0, same = 0;
    for (int n = 0; n < 4000; ++n) {
        if (n % 20 == 0) {
            plain.reset();
            bounded.reset();
        }
        const hfh::vec3<T> stylus{static_cast<T>(random.between(-8, 118)),
                                  static_cast<T>(random.between(37, 132)),
                                  static_cast<T>(n % 20 == 0 ? 40.0 : random.between(-12, 20))};
        const auto a = plain.update(stylus);
        const auto b = bounded.update(stylus);
        same += a.status == b.status && a.proxy == b.proxy && a.depth == b.depth ? 1 : 0;
        touching += a.touching() ? 1 : 0;
    }
    CHECK(same == 4000);
    CHECK(touching > 500);
}

namespace {
/// Which calls compile with a place or a range of a type.
template <class Field, class Range>
concept UpdatesGrid = requires(Field field, Range samples) {
    field.update(samples);
};
template <class Field, class Range>
concept UpdatesPyramid = requires(const Field& field, typename Field::Bounds bounds, Range samples) {
    bounds.update(field.grid().heights(), samples);
};
template <class Field, class Place>
concept BoundsPatches = requires(const Field& field, Place place) {
    field.block_range(0, place, place);
};
template <class Field, class Place>
concept BoundsSamples = requires(const Field& field, Place place) {
    field.bounds().range(0, place);
};
template <class Field, class Place>
concept HasPatch = requires(const Field& field, Place place) {
    field.patch(place);
};
template <class Field, class Place>
concept ComparesCorners = requires(const Field& field, const Place (&places)[6]) {
    field.corners_below(places, 0);
};

/// Bounds that take cells for blocks.
struct BoundsOfCells : BoundedGrid<float, HeightView<float>> {
    [[nodiscard]] HeightRange<float> block_range(int, Cell, Cell) const noexcept;
};
} // namespace

TEST_CASE("min_max_pyramid: a cell does not pass for a vertex nor for a block", "[bounds]") {
    using hfh::Vertex;
    using Field = BoundedGrid<float, HeightView<float>>;
    STATIC_REQUIRE(UpdatesGrid<Field, VertexRange>);
    STATIC_REQUIRE_FALSE(UpdatesGrid<Field, CellRange>);
    STATIC_REQUIRE(UpdatesPyramid<Field, VertexRange>);
    STATIC_REQUIRE_FALSE(UpdatesPyramid<Field, CellRange>);
    STATIC_REQUIRE(BoundsPatches<Field, Block>);
    STATIC_REQUIRE_FALSE(BoundsPatches<Field, Cell>);
    STATIC_REQUIRE(BoundsSamples<Field, Block>);
    STATIC_REQUIRE_FALSE(BoundsSamples<Field, Cell>);
    STATIC_REQUIRE(HasPatch<Field, Cell>);
    STATIC_REQUIRE_FALSE(HasPatch<Field, Block>);
    STATIC_REQUIRE_FALSE(HasPatch<Field, Vertex>);
    STATIC_REQUIRE(ComparesCorners<Field, Vertex>);
    STATIC_REQUIRE_FALSE(ComparesCorners<Field, Cell>);
    STATIC_REQUIRE(hfh::BoundedHeightField<Field>);
    STATIC_REQUIRE_FALSE(hfh::BoundedHeightField<BoundsOfCells>);
}

TEMPLATE_TEST_CASE("min_max_pyramid: bounds real terrains, with holes and without", "[bounds][law]", float,
                   double) {
    using T = TestType;
    auto names = hfh::test::real_terrains_without_holes;
    const auto& with = hfh::test::real_terrains_with_holes;
    names.insert(names.end(), with.begin(), with.end());
    hfh::test::on_real_terrains_or_skip<T>(names, [&](const std::string& name, const auto& terrain) {
        INFO(name);
        const auto count = build_and_check<T>(
            HeightView{terrain.heights.data(), terrain.columns, terrain.rows}, terrain.frame);
        CHECK((count.holed > 0) == (std::find(with.begin(), with.end(), name) != with.end()));
        // Whole metres, as int16 with a value for holes.
        std::vector<std::int16_t> whole;
        for (const T height : terrain.heights) {
            whole.push_back(hfh::is_finite(height) ? static_cast<std::int16_t>(height)
                                                   : std::int16_t{-32768});
        }
        // As wide as in T, so as many blocks have holes.
        const std::vector<std::int32_t> wider(whole.begin(), whole.end());
        CHECK(build_and_check<T>(
                  HeightView{wider.data(), terrain.columns, terrain.rows, MissingValue<std::int32_t>{-32768}})
                  .holed == count.holed);
        const auto in_whole = build_and_check<T>(
            HeightView{whole.data(), terrain.columns, terrain.rows, MissingValue<std::int16_t>{-32768}});
        CHECK(in_whole.blocks > 3 * count.blocks); // half as wide
        CHECK((in_whole.holed > 0) == (count.holed > 0));
    });
}
