#include "catch.hpp"
#include "support/numbers.hpp"
#include "support/reference.hpp"
#include "support/scenes.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/terrain/bridged_field.hpp>
#include <hfh/terrain/extended_field.hpp>

#include <algorithm>
#include <optional>
#include <vector>

using namespace hfh;
using namespace hfh::test;

namespace {

/// The definition over again, from a table of the vertices that are corners of patches, in long double.
template <Real T>
class Bridging {
public:
    Bridging(const Terrain<T>& ground, Index widest) : ground_{&ground}, widest_{widest} {
        const auto is_there = [&](Index i, Index j) { return holds_number(ground.at(i, j)); };
        known_.resize(ground.heights.size());
        for (Index j = 0; j + 1 < ground.rows; ++j) {
            for (Index i = 0; i + 1 < ground.columns; ++i) {
                if (!is_there(i, j) || !is_there(i + 1, j) || !is_there(i, j + 1) || !is_there(i + 1, j + 1))
                    continue;
                for (const Index corner : {Index{0}, Index{1}, ground.columns, ground.columns + 1})
                    known_[static_cast<std::size_t>(i + j * ground.columns + corner)] = true;
            }
        }
    }

    [[nodiscard]] bool known(Index i, Index j) const {
        return i >= 0 && j >= 0 && i < ground_->columns && j < ground_->rows &&
               known_[static_cast<std::size_t>(i + j * ground_->columns)];
    }
    [[nodiscard]] std::optional<Wide> height(Index i, Index j) const {
        if (known(i, j)) return metres(i, j);
        Wide sum = 0, weights = 0;
        for (int axis = 0; axis < 2; ++axis) {
            // Every pair of known vertices on the line with v between them and none of them between: the nearest two.
            Index before = -1, after = -1;
            const Index at = axis == 0 ? i : j, end = axis == 0 ? ground_->columns : ground_->rows;
            const auto known_at = [&](Index n) { return axis == 0 ? known(n, j) : known(i, n); };
            for (Index n = 0; n < end; ++n) {
                if (known_at(n) && n < at) before = n;
                if (known_at(n) && n > at && after < 0) after = n;
            }
            if (before < 0 || after < 0 || after - before > widest_) continue;
            for (const Index n : {before, after}) {
                const Wide weight = 1 / static_cast<Wide>(std::abs(n - at));
                sum += weight * (axis == 0 ? metres(n, j) : metres(i, n));
                weights += weight;
            }
        }
        if (weights == 0) return std::nullopt;
        return sum / weights;
    }

private:
    [[nodiscard]] Wide metres(Index i, Index j) const {
        return static_cast<Wide>(static_cast<T>(ground_->frame.height_offset) +
                                 static_cast<T>(ground_->frame.height_scale) * ground_->at(i, j));
    }
    const Terrain<T>* ground_;
    Index widest_;
    std::vector<bool> known_;
};

template <Real T>
bool same(const BilinearPatch<T>& a, const BilinearPatch<T>& b) {
    return a.p00 == b.p00 && a.p10 == b.p10 && a.p01 == b.p01 && a.p11 == b.p11 && a.spacing == b.spacing;
}

/// Holes of every kind: specks, blobs, stripes, and some at the rim.
template <Real T>
void make_holes(Terrain<T>& ground, Random& random) {
    for (int n = 0; n < 4; ++n) {
        const Index i = random.whole(-2, ground.columns), j = random.whole(-2, ground.rows);
        const Index width = random.whole(1, 7), depth = random.whole(1, 7);
        for (Index b = std::max<Index>(j, 0); b < std::min(j + depth, ground.rows); ++b)
            for (Index a = std::max<Index>(i, 0); a < std::min(i + width, ground.columns); ++a)
                if (!random.one_in(9)) ground.remove(a, b);
    }
}

/// Level at 2 m with a hole over samples [from, from + width) in x and all of [4, 12) in y.
template <Real T>
Terrain<T> with_void(Index width) {
    auto ground = plane<T>(40, 16, 2);
    for (Index j = 4; j < 12; ++j)
        for (Index i = 10; i < 10 + width; ++i) ground.remove(i, j);
    return ground;
}

} // namespace

namespace {

/// Compares one cell with the definition. Returns whether the cell has a patch.
template <Real T, class Field>
bool check_cell(const Terrain<T>& ground, const Field& field, const Bridging<T>& reference, Cell c,
                Wide rounding) {
    const auto grid = ground.grid();
    const auto patch = field.patch(c);
    if (const auto inside = grid.patch(c)) {
        REQUIRE(patch);
        REQUIRE(same(*patch, *inside));
        return true;
    }
    bool wanted = grid.cells().contains(c);
    for (Index k = 0; k < 4 && wanted; ++k) {
        const Vertex v{c.i + k % 2, c.j + k / 2};
        const auto height = reference.height(v.i, v.j);
        wanted = height.has_value();
        if (!patch || !height) continue;
        const T corners[]{patch->p00, patch->p10, patch->p01, patch->p11};
        REQUIRE(std::abs(static_cast<Wide>(corners[k]) - *height) <= rounding);
        REQUIRE(field.height(v) == corners[k]);
    }
    REQUIRE(patch.has_value() == wanted);
    return wanted;
}

/// Of the heights that are there.
template <Real T>
Wide largest_height(const Terrain<T>& ground) {
    Wide largest = 0;
    for (const T height : ground.heights)
        if (holds_number(height)) largest = std::max(largest, std::abs(static_cast<Wide>(height)));
    return largest;
}

} // namespace

TEMPLATE_TEST_CASE("BridgedField: is as defined, keeps what is there to the bit, and has no cracks",
                   "[bridged_field][law]", float, double) {
    using T = TestType;
    Random random{311};
    int bridged = 0, left = 0;
    for (int round = 0; round < 6; ++round) {
        for (auto& scene : scenes<T>()) {
            auto& ground = scene.terrain;
            make_holes(ground, random);
            const auto grid = ground.grid();
            const Index widest = random.whole(0, 9);
            const BridgedField field{grid, widest};
            static_assert(HeightField<BridgedField<decltype(ground.grid())>>);
            const Bridging<T> reference{ground, widest};
            CAPTURE(scene.name, widest);
            const Wide rounding = 16 * static_cast<Wide>(epsilon<T>) * largest_height(ground);
            for (Index j = -2; j <= ground.rows; ++j) {
                for (Index i = -2; i <= ground.columns; ++i) {
                    const bool has_patch = check_cell(ground, field, reference, {i, j}, rounding);
                    const bool is_hole = grid.cells().contains({i, j}) && !grid.patch({i, j});
                    bridged += is_hole && has_patch;
                    left += is_hole && !has_patch;
                }
            }
        }
    }
    CHECK(bridged > 500);
    CHECK(left > 500);
}

TEMPLATE_TEST_CASE("BridgedField: spans voids up to its width and no wider", "[bridged_field]", float,
                   double) {
    using T = TestType;
    for (Index width = 1; width <= 6; ++width) {
        const auto ground = with_void<T>(width);
        const auto grid = ground.grid();
        for (Index widest = 0; widest <= 8; ++widest) {
            CAPTURE(width, widest);
            const BridgedField field{grid, widest};
            // From the known column 9 to the known column 10 + width.
            const bool spans = width + 1 <= widest;
            const auto middle = field.patch({10, 8});
            CHECK(middle.has_value() == spans);
            if (middle) CHECK(same(*middle, *grid.patch({2, 8})));
        }
    }
}

TEMPLATE_TEST_CASE("BridgedField: fills a hole in a plane by that plane", "[bridged_field]", float, double) {
    using T = TestType;
    auto ground = tilted_plane<T>(20, 20, 0.5, -0.25);
    const auto whole = ground;
    for (const Cell hole : {Cell{6, 6}, Cell{7, 6}, Cell{6, 7}, Cell{7, 7}, Cell{8, 7}, Cell{12, 3}})
        ground.remove(hole.i, hole.j);
    const auto grid = ground.grid(), filled = whole.grid();
    const BridgedField field{grid, 6};
    for (Index j = 0; j < 19; ++j) {
        for (Index i = 0; i < 19; ++i) {
            const auto patch = field.patch({i, j}), wanted = filled.patch({i, j});
            REQUIRE(patch);
            CHECK(std::abs(patch->p00 - wanted->p00) <= 8 * epsilon<T>);
            CHECK(std::abs(patch->p11 - wanted->p11) <= 8 * epsilon<T>);
        }
    }
}

TEMPLATE_TEST_CASE(
    "BridgedField: leaves what reaches the rim, and a width that makes no sense bridges nothing",
    "[bridged_field]", float, double) {
    using T = TestType;
    auto ground = plane<T>(20, 20, 1);
    for (Index j = 0; j < 20; ++j)
        for (Index i = 0; i < 3; ++i) ground.remove(i, j);
    ground.remove(10, 10);
    const auto grid = ground.grid();
    const BridgedField field{grid, 8};
    CHECK_FALSE(field.patch({1, 10}));
    CHECK(field.patch({9, 9}));
    for (const Index width : {Index{-5}, Index{0}, Index{1}})
        CHECK_FALSE((BridgedField{grid, width}.patch({9, 9})));
    // No cell number is too large to be asked for.
    const auto most = std::numeric_limits<Index>::max() / 4;
    CHECK_FALSE((BridgedField{grid, std::numeric_limits<Index>::max()}.patch({-most, most})));
    const ExtendedField endless{grid};
    CHECK((BridgedField{endless, 8}.patch({-1000, 10})) == std::nullopt);
}

TEMPLATE_TEST_CASE("BridgedField: a stylus is dragged over voids without losing contact", "[bridged_field]",
                   float, double) {
    using T = TestType;
    auto ground = hills<T>(60, 20, 2, 15);
    for (Index i = 5; i < 55; i += 7)
        for (Index j = 6; j < 12; ++j)
            for (Index k = 0; k < 3; ++k) ground.remove(i + k, j);
    const auto grid = ground.grid();
    const BridgedField field{grid, 4};
    ProxyTracker bridged{field};
    ProxyTracker plain{grid};
    int lost = 0, lost_without = 0;
    for (int n = 0; n <= 1000; ++n) {
        const T x = T(2 + 0.055 * n);
        const vec3<T> at{x, T(9.3), T(n == 0 ? 5 : -2)};
        lost += n > 0 && !bridged.update(at).touching();
        lost_without += n > 0 && !plain.update(at).touching();
        if (n == 0) (void)bridged.update(at), (void)plain.update(at);
    }
    CHECK(lost == 0);
    CHECK(lost_without > 500);
}
