#include "support/limited_work.hpp"
#include "catch.hpp"
#include "support/raw_field.hpp"
#include "support/watchdog.hpp"

#include <hfh/hfh.hpp>

#include <array>
#include <cstdint>
#include <cstdio>

// `max_patches` and `max_contact_patches` from 1 up, on ground of every kind: what may never happen under them. And the numbers at the
// end of the scalar's range, which once kept an update from returning.

using namespace hfh;
using namespace hfh::test;

namespace {

/// Strokes on so many grounds of kinds `first` to `last` in turn, with limits at random.
template <Real T>
void check_strokes(HardGround first, HardGround last, int grounds, std::uint64_t seed) {
    const Watchdog watchdog{"an update with limited work", 120};
    Random random{seed};
    long updates = 0, contacts = 0, rests = 0;
    int faults = 0;
    const int kinds = static_cast<int>(last) - static_cast<int>(first) + 1;
    for (int n = 0; n < grounds && faults < 5; ++n) {
        const auto ground =
            hard_ground<T>(static_cast<HardGround>(static_cast<int>(first) + n % kinds), random);
        const TrackerOptions options{.surface = random.one_in(5) ? SurfaceKind::sheet : SurfaceKind::solid,
                                     .max_patches = any_limit(random),
                                     .max_contact_patches = any_limit(random)};
        LimitedWork<T> work{ground, options, any_glide_speed(random, ground)};
        stroke_about(work, ground, random);
        updates += work.updates, contacts += work.contacts, rests += work.rests;
        if (work.fault().empty()) continue;
        ++faults; // told as it is, for Catch would break its lines
        std::fprintf(stderr, "ground %d, %s\n", n, work.fault().c_str());
    }
    CHECK(faults == 0);
    if (faults > 0) return;
    CHECK(updates > 80 * grounds); // and there was something to judge
    CHECK(contacts * 3 > updates);
    CHECK(rests > grounds);
}

/// The end of a search in pieces of `max_cells`, and how many it took.
struct InPieces {
    HitStatus status;
    Side side;
    Wide x, y, z;
    int pieces;
};
template <class Grid>
[[nodiscard]] InPieces search_in_pieces(const Grid& grid, glm::dvec3 from, const glm::dvec3& to,
                                        Index max_cells, int most) {
    FirstHitOptions options{.max_cells = max_cells};
    for (int pieces = 1;; ++pieces) {
        const auto hit = first_hit(grid, from, to, options);
        const glm::dvec3 at = from + hit.t * (to - from);
        if (hit.status != HitStatus::cell_limit || pieces == most) {
            return {hit.status,
                    hit.side,
                    static_cast<Wide>(at.x),
                    static_cast<Wide>(at.y),
                    static_cast<Wide>(at.z),
                    pieces};
        }
        from = at;
        options.side = hit.side;
    }
}

} // namespace

TEMPLATE_TEST_CASE("ProxyTracker: whatever work is allowed, no contact is dropped and the proxy gets there",
                   "[proxy_tracker][limited][law]", float, double) {
    check_strokes<TestType>(HardGround::rough, HardGround::crease, 2500, 141);
}

TEMPLATE_TEST_CASE("ProxyTracker: the same among heights of every size and undeclared \"no data\"",
                   "[proxy_tracker][limited][law]", float, double) {
    check_strokes<TestType>(HardGround::no_data, HardGround::magnitudes, 500, 142);
}

TEMPLATE_TEST_CASE("BilinearGrid: a number from the limit of heights on is a hole, after scale and offset",
                   "[bilinear_grid][limited]", float, double) {
    // Sample by sample: the patches around the others are there, and one sample's size tells nothing of its neighbours.
    using T = TestType;
    const auto limit = static_cast<double>(no_height_from<T>);
    const auto grid_of = [](const auto& samples, double scale, double offset) {
        const HeightView view{samples.data(), 4, 3};
        return BilinearGrid<T, decltype(view)>{
            view, {.spacing = {1, 1}, .height_scale = scale, .height_offset = offset}};
    };
    const auto hole_around_the_second = [](const auto& grid) {
        REQUIRE(grid.status() == GridStatus::ok);
        for (Index j = 0; j < 2; ++j) {
            for (Index i = 0; i < 3; ++i) {
                CAPTURE(i, j);
                CHECK(grid.patch({i, j}).has_value() == (i > 1)); // the sample is (1, 1)
            }
        }
        // A look at corners agrees.
        const Vertex over_hole[6]{{0, 0}, {1, 0}, {0, 1}, {1, 1}, {0, 0}, {1, 0}},
            over_patch[6]{{2, 0}, {3, 0}, {2, 1}, {3, 1}, {2, 0}, {3, 0}};
        CHECK_FALSE(grid.corners_below(over_hole, static_cast<T>(no_height_from<T> / 2)));
        CHECK(grid.corners_below(over_patch, static_cast<T>(no_height_from<T> / 2)));
    };
    for (const double sign : {1.0, -1.0}) {
        CAPTURE(sign);
        std::array<T, 12> samples{};
        for (const double size : {1.0, 1.5, 1e6}) {
            samples[5] = static_cast<T>(sign * size * limit);
            hole_around_the_second(grid_of(samples, 1, 0));
            samples[5] = static_cast<T>(sign * size); // high by its scale alone
            hole_around_the_second(grid_of(samples, limit, 0));
        }
        samples[5] = static_cast<T>(sign * 0.75 * limit); // by its offset
        hole_around_the_second(grid_of(samples, 1, sign * 0.25 * limit));
        CHECK(grid_of(samples, 1, -sign * 0.25 * limit).patch({0, 0}).has_value());
        samples[5] = std::nextafter(static_cast<T>(sign * limit), T(0));
        CHECK(grid_of(samples, 1, 0).patch({0, 0}).has_value());
    }
    // Wide integers stay usable, whatever their type could hold.
    std::array<std::int64_t, 12> whole{};
    std::array<std::uint64_t, 12> natural{};
    CHECK(grid_of(whole, 1, 0).patch({0, 0}).has_value());
    CHECK(grid_of(natural, 1, 0).patch({0, 0}).has_value());
    if (sizeof(T) == 4) { // a double has heights as large as they are
        for (const std::int64_t high : {std::numeric_limits<std::int64_t>::max(),
                                        std::numeric_limits<std::int64_t>::min(), std::int64_t{1} << 31}) {
            whole[5] = high;
            hole_around_the_second(grid_of(whole, 1, 0));
        }
        natural[5] = std::numeric_limits<std::uint64_t>::max();
        hole_around_the_second(grid_of(natural, 1, 0));
        whole[5] = (std::int64_t{1} << 31) - 200; // below, in float too
        CHECK(grid_of(whole, 1, 0).patch({0, 0}).has_value());
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: on a field that breaks its contract an update returns within its bound",
                   "[proxy_tracker][limited]", float, double) {
    // NaN, infinity and numbers without squares for heights: what it returns means nothing, but it returns.
    using T = TestType;
    const Watchdog watchdog{"an update on a field of NaN and infinity", 60};
    Random random{143};
    constexpr T top = std::numeric_limits<T>::max(), infinity = std::numeric_limits<T>::infinity();
    const std::array<T, 6> bad{
        std::numeric_limits<T>::quiet_NaN(), infinity, -infinity, top, -top, 2 * no_height_from<T>};
    for (int n = 0; n < 3000; ++n) {
        auto ground = rough<T>(5, 5, 4, static_cast<std::uint64_t>(n) + 1);
        for (auto k = random.whole(1, 6); k > 0; --k)
            ground.at(random.whole(0, 4), random.whole(0, 4)) =
                bad[static_cast<std::size_t>(random.whole(0, 5))];
        const RawField<T> field{ground};
        CountingField counting{field};
        const TrackerOptions options{.surface = random.one_in(2) ? SurfaceKind::sheet : SurfaceKind::solid,
                                     .max_patches = any_limit(random),
                                     .max_contact_patches = any_limit(random)};
        ProxyTracker tracker{counting, options};
        for (int k = 0; k < 40; ++k) {
            counting.forget_looks();
            const auto contact = tracker.update({static_cast<T>(random.between(-0.5, 4.5)),
                                                 static_cast<T>(random.between(-0.5, 4.5)),
                                                 static_cast<T>(random.between(-6, 8))});
            if (contact.patches > options.max_patches + 16 ||
                counting.looks() > 4 * (options.max_patches + 16L)) {
                FAIL("ground " << n << ", update " << k << ": " << contact.patches << " patches, "
                               << counting.looks() << " looks of " << options.max_patches << " allowed");
            }
        }
    }
}

TEST_CASE("first_hit: a search in pieces gets on wherever it begins, and comes to the same end",
          "[first_hit][limited][law]") {
    // Within roundings of grid lines, far from the origin, steep and along lines: a piece with t > 0 may not have moved.
    Random random{144};
    int hits = 0;
    for (int n = 0; n < 4000; ++n) {
        const double spacing = log_between(random, 0.01, 100);
        const GridFrame frame{.origin = {spacing * random.between(-1, 1) * log_between(random, 1, 1e8),
                                         spacing * random.between(-1, 1) * log_between(random, 1, 1e8)},
                              .spacing = {spacing, spacing * (random.one_in(2) ? 1 : 0.3)}};
        const auto ground = random.one_in(2)
                                ? plane<double>(8, 6, 0, frame)
                                : rough<double>(8, 6, spacing, static_cast<std::uint64_t>(n) + 1, frame);
        const auto grid = ground.grid();
        const auto place = [&] {
            glm::dvec2 cells{random.between(-0.5, 7.5), random.between(-0.5, 5.5)};
            for (int axis = 0; axis < 2; ++axis) {
                if (random.one_in(2)) cells[axis] = std::round(cells[axis]);
            }
            glm::dvec2 at = frame.origin + cells * frame.spacing;
            for (int axis = 0; axis < 2; ++axis) {
                for (auto ulps = random.whole(0, 2); ulps > 0; --ulps)
                    at[axis] = std::nextafter(at[axis], random.one_in(2) ? 1e300 : -1e300);
            }
            return at;
        };
        const glm::dvec3 a{place(), spacing * random.between(1, 2)};
        const glm::dvec3 b{random.one_in(6) ? glm::dvec2{a} : place(), spacing * random.between(-3, 1.5)};
        const auto whole = search_in_pieces(grid, a, b, std::numeric_limits<Index>::max(), 1);
        hits += whole.status == HitStatus::hit;
        for (const Index cells : {1, 2, 3, 5}) {
            const auto parts = search_in_pieces(grid, a, b, cells, 200);
            CAPTURE(n, cells, parts.pieces);
            REQUIRE(parts.pieces < 64); // 8 + 6 cells are the longest way
            if (whole.status != parts.status) {
                // A graze may go either way when it is searched from a rounded place.
                const auto low = search_in_pieces(grid, a - glm::dvec3{0, 0, 1e-6 * spacing},
                                                  b - glm::dvec3{0, 0, 1e-6 * spacing},
                                                  std::numeric_limits<Index>::max(), 1),
                           high = search_in_pieces(grid, a + glm::dvec3{0, 0, 1e-6 * spacing},
                                                   b + glm::dvec3{0, 0, 1e-6 * spacing},
                                                   std::numeric_limits<Index>::max(), 1);
                REQUIRE(low.status != high.status);
            } else if (whole.status == HitStatus::hit) {
                const Point apart{whole.x - parts.x, whole.y - parts.y, whole.z - parts.z};
                REQUIRE(static_cast<double>(length(apart)) < 1e-4 * spacing);
            }
        }
    }
    CHECK(hits > 1000);
}
