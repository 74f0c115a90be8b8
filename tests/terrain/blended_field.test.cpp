#include "catch.hpp"
#include "support/level_oracle.hpp"
#include "support/numbers.hpp"
#include "support/plain_first_hit.hpp"
#include "support/random.hpp"
#include "support/terrains.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/terrain/blended_field.hpp>
#include <hfh/terrain/extended_field.hpp>

#include <algorithm>
#include <cstdint>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

using namespace hfh;
using namespace hfh::test;

namespace {

template <Real T, class Levels>
using Field = BlendedField<T, Levels>;

/// All corners of a patch, in the order of its members.
template <Real T>
std::vector<T> corners(const BilinearPatch<T>& p) {
    return {p.p00, p.p10, p.p01, p.p11};
}

template <HeightField F>
bool corners_agree(const F& field, Cell c) {
    const auto here = field.patch(c);
    if (!here) return true;
    bool agree = true;
    if (const auto east = field.patch({c.i + 1, c.j}))
        agree = agree && here->p10 == east->p00 && here->p11 == east->p01;
    if (const auto north = field.patch({c.i, c.j + 1}))
        agree = agree && here->p01 == north->p00 && here->p11 == north->p10;
    if (const auto beyond = field.patch({c.i + 1, c.j + 1})) agree = agree && here->p11 == beyond->p00;
    if (const auto beyond = field.patch({c.i - 1, c.j + 1})) agree = agree && here->p01 == beyond->p10;
    return agree;
}

/// Any level that there is, often a whole number or right beside one.
double random_level(Random& random, int count) {
    const auto whole = static_cast<double>(random.whole(0, count - 1));
    switch (random.whole(0, 3)) {
    case 0: return whole;
    case 1: return whole + 1e-9;
    case 2: return std::max(0.0, whole - 1e-9);
    default: return random.between(0, count - 1);
    }
}

/// Scalar and sample type together.
template <Real T, Sample S>
struct Kind {
    using Scalar = T;
    using SampleType = S;
};

/// Whether a range of heights bounds the patches of some cells; one that bounds nothing holds everything.
template <HeightField F>
bool holds(const F& field, const HeightRange<typename F::Scalar>& range, const CellRange& cells) {
    const bool tells = range.highest < std::numeric_limits<typename F::Scalar>::max();
    for (Index j = cells.begin.j; j < cells.end.j; ++j) {
        for (Index i = cells.begin.i; i < cells.end.i; ++i) {
            const auto p = field.patch({i, j});
            if (p ? !(range.lowest <= p->lowest() && p->highest() <= range.highest) : tells) return false;
        }
    }
    return true;
}

/// Checks every block of a level, some of them in pairs. Returns how many bound something.
template <BoundedHeightField F>
int blocks_that_tell(const F& field, int level, Random& random) {
    const Index side = Index{1} << (F::block_bits + 2 * level);
    const Cell end = field.cells().end;
    int telling = 0;
    bool right = true;
    for (Index j = 0; j * side < end.j; ++j) {
        for (Index i = 0; i * side < end.i; ++i) {
            const bool pair = (i + 1) * side < end.i && random.one_in(2);
            const auto range = field.block_range(level, {i, j}, {i + pair, j});
            telling += range.highest < std::numeric_limits<typename F::Scalar>::max();
            const Cell last{std::min(end.i, (i + 1 + pair) * side), std::min(end.j, (j + 1) * side)};
            right = right && holds(field, range, {{i * side, j * side}, last});
        }
    }
    CHECK(right);
    return telling;
}

/// Whether every cell of two fields has the same patch.
template <HeightField A, HeightField B>
bool same_patches(const A& a, const B& b) {
    if (a.cells().end != b.cells().end) return false;
    for (Index j = 0; j < a.cells().end.j; ++j) {
        for (Index i = 0; i < a.cells().end.i; ++i) {
            const auto one = a.patch({i, j}), other = b.patch({i, j});
            if (one.has_value() != other.has_value()) return false;
            if (one && corners(*one) != corners(*other)) return false;
        }
    }
    return true;
}

/// Whether the cells of `fine` are quarters of those of `coarse`, where there are both.
template <HeightField A, HeightField B>
bool are_quarters(const A& fine, const B& coarse) {
    using T = typename A::Scalar;
    for (Index j = 0; j < 2 * coarse.cells().end.j; ++j) {
        for (Index i = 0; i < 2 * coarse.cells().end.i; ++i) {
            const auto quarter = fine.patch({i, j}), whole = coarse.patch({i / 2, j / 2});
            if (!quarter || !whole) continue; // holes are of the finer level
            const T u = static_cast<T>(i % 2) / 2, v = static_cast<T>(j % 2) / 2, half = T(0.5);
            const std::vector<T> wanted{whole->height(u, v), whole->height(u + half, v),
                                        whole->height(u, v + half), whole->height(u + half, v + half)};
            if (corners(*quarter) != wanted) return false;
        }
    }
    return true;
}

} // namespace

#define HFH_TEST_KINDS                                                                                       \
    (Kind<float, std::int16_t>), (Kind<double, std::int16_t>), (Kind<float, std::uint8_t>),                  \
        (Kind<double, std::int32_t>), (Kind<float, float>), (Kind<double, float>), (Kind<double, double>)

TEMPLATE_TEST_CASE("BlendedField: every vertex is its height of level k blended with the mean of level k+1",
                   "[blended_field][law][ieee]", HFH_TEST_KINDS) {
    using T = typename TestType::Scalar;
    using S = typename TestType::SampleType;
    Random random{181};
    for (int n = 0; n < 60; ++n) {
        const RandomSamples<S> samples{random, random.whole(2, 40), random.whole(2, 40),
                                       static_cast<int>(random.whole(0, 2) * 12), 200};
        const GridFrame frame{.origin = {random.between(-1e5, 1e5), random.between(-1e5, 1e5)},
                              .spacing = {random.between(0.5, 20), random.between(0.5, 20)},
                              .height_scale = random.between(-2, 2),
                              .height_offset = random.between(-1000, 1000)};
        Field<T, StridedLevels<typename RandomSamples<S>::View>> field{StridedLevels{samples.view()}, frame};
        const auto oracle = samples.oracle(static_cast<double>(static_cast<T>(frame.height_scale)),
                                           static_cast<double>(static_cast<T>(frame.height_offset)));
        REQUIRE(field.status() == GridStatus::ok);
        for (int m = 0; m < 6; ++m) {
            const double level = field.set_level(random_level(random, field.level_count()));
            const int k = field.finer_level();
            CAPTURE(level, samples.columns, samples.rows);
            REQUIRE(level == k + field.alpha());
            REQUIRE(field.lattice().origin() == frame.origin);
            REQUIRE(field.lattice().spacing() == frame.spacing * static_cast<double>(1 << k));
            REQUIRE(field.cells().begin == Cell{0, 0});
            REQUIRE(field.cells().end == Cell{oracle.cells(k, true), oracle.cells(k, false)});
            int wrong = 0, patches = 0;
            for (Index j = -1; j <= field.cells().end.j; ++j) {
                for (Index i = -1; i <= field.cells().end.i; ++i) {
                    const auto patch = field.patch({i, j});
                    bool there = true;
                    std::vector<Metres> wanted;
                    for (const Cell v : {Cell{i, j}, Cell{i + 1, j}, Cell{i, j + 1}, Cell{i + 1, j + 1}}) {
                        const auto z = oracle.vertex(k, static_cast<Metres>(field.alpha()), v.i, v.j);
                        there = there && z;
                        wanted.push_back(z.value_or(0));
                    }
                    wrong += there != patch.has_value();
                    if (!patch || !there) continue;
                    ++patches;
                    const auto found = corners(*patch);
                    for (std::size_t c = 0; c < 4; ++c) {
                        const Metres off = std::abs(static_cast<Metres>(found[c]) - wanted[c]);
                        wrong += !(off <= 4 * static_cast<Metres>(epsilon<T>) * 1400);
                    }
                    wrong += patch->spacing != vec2<T>{field.lattice().spacing()};
                    wrong += !corners_agree(field, {i, j});
                }
            }
            CHECK(wrong == 0);
            if (samples.columns > 8 && samples.rows > 8) CHECK((patches > 0 || k > 1));
        }
    }
}

TEMPLATE_TEST_CASE("BlendedField: without holes it is (1 - alpha) S_k + alpha S_k+1 everywhere",
                   "[blended_field][law]", float, double) {
    using T = TestType;
    Random random{182};
    for (int n = 0; n < 40; ++n) {
        const RandomSamples<std::int16_t> samples{random, random.whole(9, 60), random.whole(9, 60), 0, 300};
        const GridFrame frame{.spacing = {2, 0.75}};
        Field<T, StridedLevels<RandomSamples<std::int16_t>::View>> field{StridedLevels{samples.view()},
                                                                         frame};
        const auto oracle = samples.oracle(1, 0);
        for (int m = 0; m < 200; ++m) {
            const double level = field.set_level(random.between(0, field.level_count() - 1.001));
            const int k = field.finer_level();
            // Where cells of level k+1 are complete.
            const auto width = static_cast<double>(2 << k);
            const double x = random.between(0, width * static_cast<double>(oracle.cells(k + 1, true))),
                         y = random.between(0, width * static_cast<double>(oracle.cells(k + 1, false)));
            const Cell c{static_cast<Index>(x * 2 / width), static_cast<Index>(y * 2 / width)};
            const auto patch = field.patch(c);
            REQUIRE(patch);
            const Metres across = static_cast<Metres>(x), along = static_cast<Metres>(y);
            const auto fine = oracle.surface(k, across, along), coarse = oracle.surface(k + 1, across, along);
            REQUIRE((fine && coarse));
            const auto alpha = static_cast<Metres>(level) - static_cast<Metres>(k);
            const auto wanted = (1 - alpha) * *fine + alpha * *coarse;
            const T u = static_cast<T>(x * 2 / width - static_cast<double>(c.i)),
                    v = static_cast<T>(y * 2 / width - static_cast<double>(c.j));
            CHECK(std::abs(static_cast<Metres>(patch->height(u, v)) - wanted) <=
                  16 * static_cast<Metres>(epsilon<T>) * 600);
        }
    }
}

TEMPLATE_TEST_CASE(
    "BlendedField: alpha 0 is a grid over the level, alpha 1 the surface of the next, to the bit",
    "[blended_field][ieee]", HFH_TEST_KINDS) {
    using T = typename TestType::Scalar;
    using S = typename TestType::SampleType;
    Random random{183};
    for (int n = 0; n < 40; ++n) {
        const RandomSamples<S> samples{random, random.whole(5, 40), random.whole(5, 40),
                                       static_cast<int>(random.whole(0, 1) * 20), 200};
        const GridFrame frame{.spacing = {3, 2}, .height_scale = random.between(-2, 2), .height_offset = 0.1};
        Field<T, StridedLevels<typename RandomSamples<S>::View>> field{StridedLevels{samples.view()}, frame};
        for (int k = 0; k < field.level_count(); ++k) {
            field.set_level(k);
            GridFrame coarse_frame = frame;
            coarse_frame.spacing *= static_cast<double>(1 << k);
            const RandomSamples<S>& all = samples;
            // The same samples, copied.
            const Index columns = (samples.columns - 1) / (1 << k) + 1,
                        rows = (samples.rows - 1) / (1 << k) + 1;
            std::vector<S> copied;
            for (Index j = 0; j < rows; ++j) {
                for (Index i = 0; i < columns; ++i) copied.push_back(all.at(i << k, j << k));
            }
            const BilinearGrid<T, HeightView<S, MissingValue<S>>> grid{
                HeightView{copied.data(), columns, rows, MissingValue<S>{RandomSamples<S>::hole}},
                coarse_frame};
            CHECK(same_patches(field, grid));
            if (k == 0) continue;
            CHECK(field.blend(k - 1, 1) == k);
            CHECK(are_quarters(field, grid));
        }
    }
}

TEST_CASE("BlendedField: a level is set as far as there is one", "[blended_field]") {
    const std::vector<short> heights(17 * 9, 5);
    BlendedField field{StridedLevels{HeightView{heights.data(), 17, 9}}, {}};
    static_assert(std::is_same_v<decltype(field)::Scalar, double>);
    CHECK(field.level_count() == 4); // of 8 × 16 cells down to 1 × 2
    CHECK(field.set_level(1.25) == 1.25);
    CHECK(field.finer_level() == 1);
    CHECK(field.alpha() == 0.25);
    CHECK(field.set_level(hidden_nan<double>()) == 1.25);
    CHECK(field.set_level(hidden_infinity<double>()) == 1.25);
    CHECK(field.blend(2, hidden_nan<double>()) == 1.25);
    CHECK(field.set_level(-3) == 0);
    CHECK(field.set_level(17) == 3);
    CHECK(field.alpha() == 0);
    CHECK(field.cells().end == Cell{2, 1});
    CHECK(field.blend(3, 0.5) == 3); // there is no level 4
    CHECK(field.blend(2, 0.5) == 2.5);
    CHECK(field.blend(2, 7) == 3);
    CHECK(field.finer_level() == 2);
    CHECK(field.blend(-1, -1) == 0);

    CHECK(BlendedField{StridedLevels{HeightView{heights.data(), 1, 9}}, {}}.status() ==
          GridStatus::too_few_samples);
    BlendedField none{StridedLevels{HeightView{heights.data(), 1, 9}}, {}};
    CHECK(none.level_count() == 1);
    CHECK(none.set_level(2) == 0);
    CHECK(none.cells().empty());
    CHECK_FALSE(none.patch({0, 0}));
    CHECK_FALSE(none.surely_below({0, 0}, {0, 0}, 1e9));
    CHECK(BlendedField{StridedLevels{HeightView{heights.data(), 3, 2}}, {.spacing = {0, 1}}}.status() ==
          GridStatus::bad_spacing);
}

TEMPLATE_TEST_CASE("BlendedField: samples that are no heights are holes on every level", "[blended_field]",
                   float, double) {
    using T = TestType;
    for (const T none :
         {hidden_nan<T>(), hidden_infinity<T>(), -no_height_from<T>, std::numeric_limits<T>::lowest()}) {
        auto ground = plane<T>(9, 9, 1);
        ground.at(4, 4) = none; // on levels 0, 1 and 2
        ground.at(1, 7) = none; // on level 0
        Field<T, StridedLevels<HeightView<T>>> field{
            StridedLevels{HeightView<T>{ground.heights.data(), 9, 9}}, {}};
        for (const auto& [k, holes] : {std::tuple{0, 8}, {1, 4}, {2, 4}, {3, 0}}) {
            for (const double alpha : {0.0, 0.25, 0.75, 1.0}) {
                field.blend(k, alpha);
                int missing = 0;
                for (Index j = 0; j < field.cells().end.j; ++j) {
                    for (Index i = 0; i < field.cells().end.i; ++i) {
                        const auto patch = field.patch({i, j});
                        missing += !patch;
                        if (patch) CHECK(corners(*patch) == std::vector<T>(4, 1));
                        if (field.surely_below({i, j}, {i, j}, 2)) CHECK(patch);
                    }
                }
                CHECK(missing == holes);
            }
        }
    }
}

TEMPLATE_TEST_CASE("BlendedField: says of cells that they lie below only where they do",
                   "[blended_field][law]", HFH_TEST_KINDS) {
    using T = typename TestType::Scalar;
    using S = typename TestType::SampleType;
    Random random{184};
    int yes = 0;
    for (int n = 0; n < 60; ++n) {
        const RandomSamples<S> samples{random, random.whole(5, 40), random.whole(5, 40),
                                       static_cast<int>(random.whole(0, 1) * 30), 100};
        const double scale = random.one_in(2) ? 1 : -1;
        Field<T, StridedLevels<typename RandomSamples<S>::View>> field{StridedLevels{samples.view()},
                                                                       {.height_scale = scale}};
        static_assert(QuickHeightField<decltype(field)>);
        for (int m = 0; m < 200; ++m) {
            field.set_level(random_level(random, field.level_count()));
            const Cell end = field.cells().end;
            const Cell one{random.whole(-1, end.i), random.whole(-1, end.j)};
            const auto way = random.whole(0, 2);
            const Cell other{one.i + (way == 1), one.j + (way == 2)};
            const auto a = field.patch(one), b = field.patch(other);
            T z = static_cast<T>(random.between(-120, 220));
            if (a && random.one_in(2)) z = a->highest(); // not below itself
            const bool surely = field.surely_below(one, other, z);
            const bool below = a && b && a->highest() < z && b->highest() < z;
            if (surely) REQUIRE(below);
            yes += surely;
            // Above all samples it is told wherever these are there on both levels.
            const auto whole = [&](Cell c) {
                return field.alpha() == 0 || field.coarser().patch({c.i >> 1, c.j >> 1}).has_value();
            };
            if (a && b && whole(one) && whole(other)) CHECK(field.surely_below(one, other, T(1e6)));
        }
    }
    CHECK(yes > 500);
}

TEMPLATE_TEST_CASE("BoundedBlendedField: blocks hold their patches at every level", "[blended_field][law]",
                   HFH_TEST_KINDS) {
    using T = typename TestType::Scalar;
    using S = typename TestType::SampleType;
    Random random{185};
    int bounded = 0;
    for (int n = 0; n < 12; ++n) {
        RandomSamples<S> samples{random, random.whole(2, 300), random.whole(2, 300),
                                 random.one_in(3) ? 300 : 0, 200};
        const GridFrame frame{.height_scale = random.between(-1, 1), .height_offset = 3};
        const Field<T, StridedLevels<typename RandomSamples<S>::View>> blended{StridedLevels{samples.view()},
                                                                               frame};
        std::vector<SampleRange<S>> storage(
            static_cast<std::size_t>(MinMaxPyramid<S>::size(samples.columns, samples.rows)));
        BoundedBlendedField field{blended, storage.data(), std::ssize(storage)};
        static_assert(BoundedHeightField<decltype(field)> && LeveledHeightField<decltype(field)>);
        CHECK(BoundedBlendedField{blended, storage.data(), std::ssize(storage) - 1}.levels() == 0);
        REQUIRE(field.build() == PyramidStatus::ok);
        for (int edit = 0; edit < 2; ++edit) {
            for (int m = 0; m < 12; ++m) {
                field.set_level(m < field.level_count() ? m : random_level(random, field.level_count()));
                const Cell end = field.cells().end;
                REQUIRE(field.levels() > 0);
                const auto top_side = Index{1} << (field.block_bits + 2 * (field.levels() - 1));
                REQUIRE(std::max(end.i, end.j) <= top_side);
                for (int l = 0; l < field.levels(); ++l) bounded += blocks_that_tell(field, l, random);
            }
            // An edit in a corner, out of the range so far.
            const Index i = random.whole(0, samples.columns - 1), j = random.whole(0, samples.rows - 1);
            samples.at(i, j) = std::is_signed_v<S> ? S(120) : S(250);
            CHECK(field.update({{i, j}, {i + 1, j + 1}}) == PyramidStatus::ok);
        }
    }
    CHECK(bounded > 1000);
}

TEMPLATE_TEST_CASE("BlendedField: what is passed over changes no first hit", "[blended_field][ieee]", float,
                   double) {
    using T = TestType;
    Random random{186};
    int hits = 0;
    for (int n = 0; n < 20; ++n) {
        const RandomSamples<std::int16_t> samples{random, random.whole(20, 200), random.whole(20, 200),
                                                  random.one_in(3) ? 200 : 0, 20};
        const Field<T, StridedLevels<RandomSamples<std::int16_t>::View>> blended{
            StridedLevels{samples.view()}, {}};
        std::vector<SampleRange<std::int16_t>> storage(
            static_cast<std::size_t>(MinMaxPyramid<std::int16_t>::size(samples.columns, samples.rows)));
        BoundedBlendedField bounded{blended, storage.data(), std::ssize(storage)};
        bounded.build();
        auto plain = blended;
        for (int m = 0; m < 400; ++m) {
            const double level = random_level(random, plain.level_count());
            plain.set_level(level);
            bounded.set_level(level);
            const double width = static_cast<double>(samples.columns),
                         depth = static_cast<double>(samples.rows);
            const glm::dvec3 a{random.between(-2, width), random.between(-2, depth), random.between(-20, 60)};
            glm::dvec3 b{random.between(-2, width), random.between(-2, depth), random.between(-60, 40)};
            if (random.one_in(3))
                b = a + glm::dvec3{random.between(-2, 2), random.between(-2, 2), random.between(-9, 3)};
            const FirstHitOptions options{.surface =
                                              random.one_in(2) ? SurfaceKind::solid : SurfaceKind::sheet};
            const auto wanted = plain::first_hit(plain, a, b, options);
            for (const auto& found : {first_hit(plain, a, b, options), first_hit(bounded, a, b, options)}) {
                REQUIRE(found.status == wanted.status);
                REQUIRE(found.side == wanted.side);
                if (wanted.status != HitStatus::hit) continue;
                REQUIRE(found.t == wanted.t);
                REQUIRE(found.point.cell == wanted.point.cell);
                REQUIRE((found.point.u == wanted.point.u && found.point.v == wanted.point.v));
                ++hits;
            }
        }
    }
    CHECK(hits > 1000);
}

namespace {

/// A user's own storage: no strides.
struct Columns {
    using SampleType = float;
    const std::vector<std::vector<float>>* all;
    int* outside; ///< reads where there is no sample

    [[nodiscard]] Index columns() const noexcept { return std::ssize(*all); }
    [[nodiscard]] Index rows() const noexcept { return std::ssize(all->front()); }
    [[nodiscard]] float operator()(Index i, Index j) const noexcept {
        if (i < 0 || j < 0 || i >= columns() || j >= rows()) {
            ++*outside;
            return 0;
        }
        return (*all)[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
    }
    [[nodiscard]] bool missing(float sample) const noexcept { return sample == -1; }
};

} // namespace

TEST_CASE("BlendedField: levels of a storage of one's own are those of its samples", "[blended_field]") {
    Random random{187};
    std::vector<std::vector<float>> all(23, std::vector<float>(14));
    std::vector<float> flat(23 * 14);
    for (Index i = 0; i < 23; ++i) {
        for (Index j = 0; j < 14; ++j) {
            const float z = random.one_in(20) ? -1.0f : static_cast<float>(random.between(0, 9));
            all[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = z;
            flat[static_cast<std::size_t>(i + 23 * j)] = z;
        }
    }
    int outside = 0;
    BlendedField own{StridedLevels{Columns{&all, &outside}}, {}};
    BlendedField view{StridedLevels{HeightView{flat.data(), 23, 14, MissingValue{-1.0f}}}, {}};
    std::vector<SampleRange<float>> storage(static_cast<std::size_t>(MinMaxPyramid<float>::size(23, 14)));
    BoundedBlendedField bounded{own, storage.data(), std::ssize(storage)};
    CHECK(bounded.build() == PyramidStatus::ok);
    CHECK(bounded.levels() == 2);
    REQUIRE(own.level_count() == view.level_count());
    for (const double level : {0.0, 0.3, 1.0, 1.8, 2.0, 3.0}) {
        own.set_level(level);
        view.set_level(level);
        REQUIRE(own.cells().end == view.cells().end);
        for (Index j = 0; j < own.cells().end.j; ++j) {
            for (Index i = 0; i < own.cells().end.i; ++i) {
                const auto a = own.patch({i, j}), b = view.patch({i, j});
                REQUIRE(a.has_value() == b.has_value());
                if (a) CHECK(corners(*a) == corners(*b));
            }
        }
        // No sample is asked for that a level does not have.
        for (Index j = -2; j <= own.cells().end.j + 1; ++j) {
            for (Index i = -2; i <= own.cells().end.i + 1; ++i) {
                (void)own.patch({i, j});
                (void)own.surely_below({i, j}, {i + 1, j}, 1e9);
                (void)own.surely_below({i, j}, {i, j + 1}, 1e9);
            }
        }
        CHECK(outside == 0);
    }
}

TEMPLATE_TEST_CASE("BlendedField: overviews of one's own are blended as they are",
                   "[blended_field][law][ieee]", float, double) {
    using T = TestType;
    using View = HeightView<T>;
    Random random{188};
    // Any numbers, with holes of their own on every level.
    const auto level = [&](Index columns, Index rows) {
        auto made = rough<T>(columns, rows, 9, static_cast<std::uint64_t>(random.whole(1, 1000)));
        punch_holes(made, 25, static_cast<std::uint64_t>(random.whole(1, 1000)));
        return made;
    };
    const std::vector<Terrain<T>> made{level(26, 19), level(13, 10), level(7, 5), level(4, 3)};
    std::vector<View> views;
    for (const auto& m : made) views.push_back({m.heights.data(), m.columns, m.rows});
    const LevelOracle oracle{[&](int k, Index i, Index j) -> std::optional<Metres> {
                                 const T z = made[static_cast<std::size_t>(k)].at(i, j);
                                 if (!holds_number(z)) return {};
                                 return static_cast<Metres>(z);
                             },
                             26, 19};
    Field<T, OverviewLevels<View>> field{OverviewLevels{views.data(), 4}, {}};
    REQUIRE(field.level_count() == 4);
    for (int n = 0; n < 60; ++n) {
        field.set_level(random_level(random, 4));
        for (Index j = 0; j < field.cells().end.j; ++j) {
            for (Index i = 0; i < field.cells().end.i; ++i) {
                const auto patch = field.patch({i, j});
                const auto alpha = static_cast<Metres>(field.alpha());
                const int k = field.finer_level();
                std::vector<std::optional<Metres>> wanted;
                for (const Cell v : {Cell{i, j}, Cell{i + 1, j}, Cell{i, j + 1}, Cell{i + 1, j + 1}})
                    wanted.push_back(k == 3 ? oracle.at(3, v.i, v.j) : oracle.vertex(k, alpha, v.i, v.j));
                const bool there =
                    std::all_of(wanted.begin(), wanted.end(), [](const auto& z) { return bool{z}; });
                REQUIRE(patch.has_value() == there);
                if (!there) continue;
                for (std::size_t c = 0; c < 4; ++c)
                    CHECK(std::abs(static_cast<Metres>(corners(*patch)[c]) - *wanted[c]) <=
                          static_cast<Metres>(epsilon<T>) * 40);
                CHECK(corners_agree(field, {i, j}));
            }
        }
    }
    // Those that do not fit are not used.
    CHECK(OverviewLevels{views.data(), 2}.count() == 2);
    views[2] = View{made[2].heights.data(), 6, 5};
    CHECK(OverviewLevels{views.data(), 4}.count() == 2);
    views[1] = View{made[1].heights.data(), 13, 9};
    CHECK(OverviewLevels{views.data(), 4}.count() == 1);
}

TEMPLATE_TEST_CASE("BlendedField: the tracker keeps its promises on a blend", "[blended_field]", float,
                   double) {
    using T = TestType;
    Random random{189};
    for (const SurfaceKind surface : {SurfaceKind::solid, SurfaceKind::sheet}) {
        for (int n = 0; n < 30; ++n) {
            const auto ground = rough<T>(40, 37, random.between(0.2, 4), static_cast<std::uint64_t>(n + 1));
            Field<T, StridedLevels<HeightView<T>>> field{
                StridedLevels{HeightView<T>{ground.heights.data(), 40, 37}}, {}};
            field.set_level(random.between(0, 2.9));
            ProxyTracker tracker{field, {.surface = surface}};
            glm::dvec2 at{random.between(12, 20), random.between(12, 20)};
            const auto height = [&](const glm::dvec2& p) {
                const glm::dvec2 cells = p / field.lattice().spacing();
                const Cell c{static_cast<Index>(cells.x), static_cast<Index>(cells.y)};
                return static_cast<double>(field.patch(c)->height(static_cast<T>(cells.x - double(c.i)),
                                                                  static_cast<T>(cells.y - double(c.j))));
            };
            (void)tracker.update(vec3<T>{glm::dvec3{at, height(at) + 5}});
            int dropped = 0;
            for (int k = 0; k < 300; ++k) {
                at += glm::dvec2{random.between(-0.3, 0.3), random.between(-0.3, 0.3)};
                at = glm::clamp(at, glm::dvec2{9.0}, glm::dvec2{23.0});
                const double below = height(at) - 0.02;
                const auto contact = tracker.update(vec3<T>{glm::dvec3{at, below}});
                dropped += !contact.touching();
            }
            CHECK(dropped == 0);
        }
    }
}
