#include "catch.hpp"
#include "support/random.hpp"

#include <hfh/terrain/height_view.hpp>

#include <array>
#include <cstring>
#include <vector>

using hfh::HeightView;
using hfh::Index;
using hfh::MissingValue;

namespace {

/// Every sample different: 0, 1, 2, … in storage order.
template <class S>
std::vector<S> counting(std::size_t count) {
    std::vector<S> samples(count);
    for (std::size_t n = 0; n < count; ++n) samples[n] = static_cast<S>(n);
    return samples;
}

} // namespace

#define HFH_SAMPLE_TYPES std::uint8_t, std::uint16_t, std::int16_t, std::int32_t, float, double

TEMPLATE_TEST_CASE("height_view: reads rows one after the other", "[height_view]", HFH_SAMPLE_TYPES) {
    using S = TestType;
    const auto samples = counting<S>(5 * 3);
    const HeightView view{samples.data(), 5, 3};
    STATIC_REQUIRE(std::is_same_v<std::remove_const_t<decltype(view)>, HeightView<S>>);
    STATIC_REQUIRE(std::is_same_v<decltype(view(0, 0)), S>);
    CHECK(view.columns() == 5);
    CHECK(view.rows() == 3);
    for (Index j = 0; j < 3; ++j) {
        for (Index i = 0; i < 5; ++i) CHECK(view(i, j) == static_cast<S>(i + 5 * j));
    }
}

TEMPLATE_TEST_CASE("height_view: reads the extreme values of a type unchanged", "[height_view][hard]",
                   HFH_SAMPLE_TYPES) {
    using S = TestType;
    using limits = std::numeric_limits<S>;
    const std::array<S, 4> samples{limits::lowest(), limits::max(), S(0), limits::min()};
    const HeightView view{samples.data(), 2, 2};
    CHECK(view(0, 0) == limits::lowest());
    CHECK(view(1, 0) == limits::max());
    CHECK(view(0, 1) == S(0));
    CHECK(view(1, 1) == limits::min());
    for (const S sample : samples) CHECK_FALSE(view.missing(sample));
}

TEMPLATE_TEST_CASE("height_view: copies nothing and sees every edit", "[height_view][law]",
                   HFH_SAMPLE_TYPES) {
    using S = TestType;
    auto samples = counting<S>(4 * 4);
    const HeightView view{samples.data(), 4, 4};
    const HeightView copy = view;
    CHECK(view.data() == samples.data());
    CHECK(copy.data() == samples.data());
    samples[6] = S(99);
    CHECK(view(2, 1) == S(99));
    CHECK(copy(2, 1) == S(99));
    CHECK(view.flipped_rows()(2, 2) == S(99));

    // A pointer and four numbers; a predicate without state costs nothing.
    STATIC_REQUIRE(sizeof(view) == sizeof(S*) + 4 * sizeof(Index));
    STATIC_REQUIRE(std::is_trivially_copyable_v<HeightView<S>>);
    STATIC_REQUIRE(std::is_nothrow_copy_constructible_v<HeightView<S>>);
    STATIC_REQUIRE(noexcept(view(0, 0))&& noexcept(view.missing(S(0)))&& noexcept(view.flipped_rows()));
}

TEMPLATE_TEST_CASE("height_view: sees the alpha channel of RGBA pixels", "[height_view]", HFH_SAMPLE_TYPES) {
    using S = TestType;
    constexpr Index w = 7, h = 5;
    std::vector<S> pixels(4 * w * h, S(77)); // red, green, blue
    for (std::size_t n = 0; n < w * h; ++n) pixels[4 * n + 3] = static_cast<S>(n);
    const HeightView view{pixels.data() + 3, w, h, 4, 4 * w};
    const auto north_first = view.flipped_rows();
    for (Index j = 0; j < h; ++j) {
        for (Index i = 0; i < w; ++i) {
            CHECK(view(i, j) == static_cast<S>(i + w * j));
            CHECK(north_first(i, j) == static_cast<S>(i + w * (h - 1 - j)));
        }
    }
}

TEMPLATE_TEST_CASE("height_view: strides of either sign reach the same samples", "[height_view][law]",
                   HFH_SAMPLE_TYPES) {
    using S = TestType;
    constexpr Index w = 6, h = 4;
    const auto samples = counting<S>(w * h);
    const S* const first = samples.data();
    const HeightView plain{first, w, h, 1, w};
    const HeightView mirrored{first + (w - 1), w, h, -1, w};
    const HeightView flipped{first + (h - 1) * w, w, h, 1, -w};
    const HeightView turned{first + (w * h - 1), w, h, -1, -w};
    const HeightView transposed{first, h, w, w, 1};
    const HeightView every_other{first, w / 2, h / 2, 2, 2 * w};
    const HeightView one_row_for_all{first, w, h, 1, 0};
    for (Index j = 0; j < h; ++j) {
        for (Index i = 0; i < w; ++i) {
            const S sample = samples[static_cast<std::size_t>(i + w * j)];
            CHECK(plain(i, j) == sample);
            CHECK(mirrored(w - 1 - i, j) == sample);
            CHECK(flipped(i, h - 1 - j) == sample);
            CHECK(turned(w - 1 - i, h - 1 - j) == sample);
            CHECK(transposed(j, i) == sample);
            if (i % 2 == 0 && j % 2 == 0) CHECK(every_other(i / 2, j / 2) == sample);
            if (j == 0) CHECK(one_row_for_all(i, h - 1) == sample);
        }
    }
}

TEMPLATE_TEST_CASE("height_view: flipped_rows shows the last row first and undoes itself",
                   "[height_view][law]", HFH_SAMPLE_TYPES) {
    using S = TestType;
    constexpr Index w = 3, h = 5;
    const auto samples = counting<S>(w * h);
    const HeightView view{samples.data(), w, h, MissingValue<S>{S(4)}};
    const auto flipped = view.flipped_rows();
    const auto again = flipped.flipped_rows();
    CHECK(flipped.columns() == w);
    CHECK(flipped.rows() == h);
    CHECK(again.data() == view.data());
    CHECK(view.row_stride() == w);
    CHECK(flipped.row_stride() == -w);
    CHECK(flipped.column_stride() == 1);
    CHECK(flipped.missing(S(4)));
    for (Index j = 0; j < h; ++j) {
        for (Index i = 0; i < w; ++i) {
            CHECK(flipped(i, j) == view(i, h - 1 - j));
            CHECK(again(i, j) == view(i, j));
        }
    }
    const HeightView one_row{samples.data(), w, 1};
    CHECK(one_row.flipped_rows()(1, 0) == one_row(1, 0));
    const HeightView none{samples.data(), 0, 0};
    CHECK(none.flipped_rows().data() == samples.data());
}

TEMPLATE_TEST_CASE("height_view: a missing value is a hole and only that value is", "[height_view]",
                   HFH_SAMPLE_TYPES) {
    using S = TestType;
    const auto samples = counting<S>(9);
    const HeightView view{samples.data(), 3, 3, MissingValue<S>{S(5)}};
    STATIC_REQUIRE(std::is_same_v<std::remove_const_t<decltype(view)>, HeightView<S, MissingValue<S>>>);
    for (Index n = 0; n < 9; ++n) CHECK(view.missing(view(n % 3, n / 3)) == (n == 5));

    const HeightView strided{samples.data(), 3, 3, 1, 3, MissingValue<S>{S(5)}};
    CHECK(strided.missing(S(5)));
    CHECK_FALSE(strided.missing(S(4)));
    const HeightView complete{samples.data(), 3, 3};
    for (const S sample : samples) CHECK_FALSE(complete.missing(sample));
}

TEMPLATE_TEST_CASE("height_view: a predicate with or without state decides what is missing", "[height_view]",
                   HFH_SAMPLE_TYPES) {
    using S = TestType;
    const auto samples = counting<S>(9);
    const HeightView by_rule{samples.data(), 3, 3, [](S sample) { return sample > S(6); }};
    STATIC_REQUIRE(sizeof(by_rule) == sizeof(HeightView<S>));
    S limit = S(3);
    const HeightView by_limit{samples.data(), 3, 3, 1, 3, [&limit](S sample) { return sample > limit; }};
    for (const S sample : samples) {
        CHECK(by_rule.missing(sample) == (sample > S(6)));
        CHECK(by_limit.missing(sample) == (sample > S(3)));
    }
    limit = S(200);
    CHECK_FALSE(by_limit.missing(S(100)));
}

TEMPLATE_TEST_CASE("height_view: floating samples that are not finite are missing whatever the rule",
                   "[height_view][hard]", float, double) {
    using S = TestType;
    using limits = std::numeric_limits<S>;
    const std::array<S, 4> samples{limits::quiet_NaN(), limits::infinity(), -limits::infinity(), S(1)};
    const HeightView plain{samples.data(), 2, 2};
    const HeightView with_value{samples.data(), 2, 2, MissingValue<S>{S(-9999)}};
    const HeightView with_nan{samples.data(), 2, 2, MissingValue<S>{limits::quiet_NaN()}};
    const HeightView with_rule{samples.data(), 2, 2, [](S) { return false; }};
    for (std::size_t n = 0; n < 4; ++n) {
        CHECK(plain.missing(samples[n]) == (n != 3));
        CHECK(with_value.missing(samples[n]) == (n != 3));
        CHECK(with_nan.missing(samples[n]) == (n != 3));
        CHECK(with_rule.missing(samples[n]) == (n != 3));
    }
    CHECK(with_value.missing(S(-9999)));
}

TEST_CASE("height_view: the no-data value of a 16 bit raster is not a height", "[height_view]") {
    const std::array<std::int16_t, 4> samples{-32768, 0, 120, -32768};
    // An int, as a person writes it.
    const HeightView view{samples.data(), 2, 2, MissingValue{-32768}};
    CHECK(view.missing(view(0, 0)));
    CHECK_FALSE(view.missing(view(1, 0)));
    CHECK_FALSE(view.missing(view(0, 1)));
    CHECK(view.missing(view(1, 1)));
}

namespace {

template <class S, class V>
concept CanMark = requires(const S* samples, V value) {
    HeightView{samples, 2, 2, MissingValue<V>{value}};
};
template <class S, class V>
concept CanMarkStrided = requires(const S* samples, V value) {
    HeightView{samples, 2, 2, 1, 2, MissingValue<V>{value}};
};
template <class S, class V>
concept CanName = requires {
    typename HeightView<S, MissingValue<V>>;
};
template <class S, class V>
constexpr bool can_mark(bool expected) {
    return CanMark<S, V> == expected && CanMarkStrided<S, V> == expected && CanName<S, V> == expected &&
           std::is_invocable_v<const MissingValue<V>&, S> == expected;
}

} // namespace

TEST_CASE(
    "height_view: a missing value is of the samples' type, or both are integers, or it does not compile",
    "[height_view][hard]") {
    // MissingValue{0} once took floats below 1 for holes, and MissingValue{-3.4e38} never took a float for one.
    STATIC_REQUIRE(can_mark<float, float>(true));
    STATIC_REQUIRE(can_mark<double, double>(true));
    STATIC_REQUIRE(can_mark<std::int16_t, std::int16_t>(true));
    STATIC_REQUIRE(can_mark<std::int16_t, int>(true));
    STATIC_REQUIRE(can_mark<std::uint64_t, char>(true));
    STATIC_REQUIRE(can_mark<float, int>(false));
    STATIC_REQUIRE(can_mark<float, double>(false));
    STATIC_REQUIRE(can_mark<double, float>(false));
    STATIC_REQUIRE(can_mark<double, long double>(false));
    STATIC_REQUIRE(can_mark<std::int16_t, double>(false));
    STATIC_REQUIRE(can_mark<std::uint8_t, float>(false));
}

TEST_CASE("height_view: a missing value of another integer type is the same number or none",
          "[height_view][hard]") {
    // Not −1 as the unsigned number that it converts to, and not 65 535 cut to 16 bits.
    const std::array<std::uint16_t, 4> words{65535, 0, 1, 32768};
    CHECK_FALSE(HeightView{words.data(), 2, 2, MissingValue{-1}}.missing(words[0]));
    CHECK(HeightView{words.data(), 2, 2, MissingValue{65535}}.missing(words[0]));
    CHECK_FALSE(HeightView{words.data(), 2, 2, MissingValue{65536}}.missing(words[1]));
    CHECK_FALSE(HeightView{words.data(), 2, 2, MissingValue<std::int16_t>{-32768}}.missing(words[3]));
    const std::array<std::int32_t, 4> wide{-1, 0, 1, std::numeric_limits<std::int32_t>::min()};
    CHECK_FALSE(HeightView{wide.data(), 2, 2, MissingValue{0xffffffffu}}.missing(wide[0]));
    CHECK_FALSE(HeightView{wide.data(), 2, 2, MissingValue{~std::uint64_t{0}}}.missing(wide[0]));
    CHECK(HeightView{wide.data(), 2, 2, MissingValue{std::int64_t{-1}}}.missing(wide[0]));
    CHECK(HeightView{wide.data(), 2, 2, MissingValue{std::int8_t{-1}}}.missing(wide[0]));
    CHECK_FALSE(HeightView{wide.data(), 2, 2, MissingValue{0x80000000u}}.missing(wide[3]));
}

TEST_CASE("height_view: takes const and mutable storage and works in constant expressions", "[height_view]") {
    static constexpr std::array<int, 6> samples{1, 2, 3, 4, 5, 6};
    constexpr HeightView view{samples.data(), 3, 2};
    STATIC_REQUIRE(view(2, 1) == 6);
    STATIC_REQUIRE(view.flipped_rows()(2, 1) == 3);
    STATIC_REQUIRE_FALSE(view.missing(3));
    std::array<int, 6> edited = samples;
    const HeightView of_mutable{edited.data(), 3, 2};
    STATIC_REQUIRE(std::is_same_v<decltype(of_mutable(0, 0)), int>);
    STATIC_REQUIRE(std::is_same_v<decltype(of_mutable.data()), const int*>);
    STATIC_REQUIRE(std::is_same_v<decltype(HeightView{edited.data(), 3, 2}), HeightView<int>>);
}

TEST_CASE(
    "height_view: sizes and strides may be of any integer type, and one that is too large counts as none",
    "[height_view]") {
    const std::vector<float> samples{1, 2, 3, 4, 5, 6};
    const std::size_t width = 3, height = samples.size() / width;
    const hfh::HeightView view{samples.data(), width, height};
    const hfh::HeightView strided{samples.data(), 3U, 2LL, std::size_t{1}, width, hfh::MissingValue{6.0f}};
    CHECK(view.columns() == 3);
    CHECK(view.rows() == 2);
    CHECK(view(2, 1) == 6);
    CHECK(strided(1, 1) == 5);
    CHECK(strided.missing(strided(2, 1)));
    const std::size_t too_many = static_cast<std::size_t>(-1);
    CHECK(hfh::HeightView{samples.data(), too_many, height}.columns() == 0);
    CHECK(hfh::HeightView{samples.data(), width, too_many}.rows() == 0);
}

TEST_CASE("height_view: any arithmetic type but bool is a sample", "[height_view]") {
    STATIC_REQUIRE(hfh::Sample<char>);
    STATIC_REQUIRE(hfh::Sample<std::int8_t>);
    STATIC_REQUIRE(hfh::Sample<std::uint32_t>);
    STATIC_REQUIRE(hfh::Sample<std::int64_t>);
    STATIC_REQUIRE_FALSE(hfh::Sample<bool>);
    STATIC_REQUIRE_FALSE(hfh::Sample<int*>);
    const std::array<std::uint64_t, 4> samples{0, 1, 2, ~std::uint64_t{0}};
    const HeightView view{samples.data(), 2, 2, MissingValue{~std::uint64_t{0}}};
    CHECK(view.missing(view(1, 1)));
    CHECK_FALSE(view.missing(view(0, 1)));
}
