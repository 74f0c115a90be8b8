#include "catch.hpp"
#include "support/brute_force_hit.hpp"
#include "support/terrains.hpp"

#include <hfh/traversal/first_hit.hpp>

#include <cmath>
#include <limits>
#include <sstream>
#include <string>

using glm::dvec2;
using glm::dvec3;
using hfh::Cell;
using hfh::first_hit;
using hfh::FirstHit;
using hfh::FirstHitOptions;
using hfh::HitStatus;
using hfh::Index;
using hfh::Side;
using hfh::SurfaceKind;
using hfh::test::brute_force_hit;
using hfh::test::BruteForceHit;
using hfh::test::Random;
using hfh::test::Terrain;

namespace {

constexpr double eps = hfh::epsilon<double>;
constexpr FirstHitOptions sheet{.surface = SurfaceKind::sheet};

/// Is the crossing where its fields say it is: on the segment, on the surface and inside a cell that has a patch?
template <class T>
std::string misplaced(const Terrain<T>& terrain, const dvec3& a, const dvec3& b, const FirstHit<T>& found) {
    std::ostringstream wrong;
    const auto grid = terrain.grid();
    const auto patch = grid.patch(found.point.cell);
    if (!patch) return "no patch there";
    const auto [cell, u, v] = found.point;
    if (!(u >= 0 && u <= 1 && v >= 0 && v <= 1)) wrong << "outside the cell; ";
    if (!(found.t >= 0 && found.t <= 1)) wrong << "outside the segment; ";
    const dvec3 p = a + found.t * (b - a);
    const dvec2 spacing = terrain.frame.spacing;
    const double x = (static_cast<double>(cell.i) + static_cast<double>(u)) * spacing.x;
    const double y = (static_cast<double>(cell.j) + static_cast<double>(v)) * spacing.y;
    // The segment's ends are known to ε of their distance from the world's origin, its times to a few ε, and u and v
    // are rounded to T; 32 stands for the dozen steps between.
    const double reach = std::abs(terrain.frame.origin.x) + std::abs(terrain.frame.origin.y) +
                         std::abs(a.x - b.x) + std::abs(a.y - b.y) + std::abs(x) + std::abs(y);
    const double off = 32 * eps * reach + static_cast<double>(hfh::epsilon<T>) * (spacing.x + spacing.y);
    if (std::abs(p.x - terrain.frame.origin.x - x) > off) wrong << "x is " << p.x << "; ";
    if (std::abs(p.y - terrain.frame.origin.y - y) > off) wrong << "y is " << p.y << "; ";
    // That much sideways is this much up, and the height itself has the rounding of its corners.
    const double relief = static_cast<double>(patch->highest()) - static_cast<double>(patch->lowest());
    const double size =
        std::max({std::abs(static_cast<double>(patch->highest())),
                  std::abs(static_cast<double>(patch->lowest())), std::abs(a.z), std::abs(b.z)});
    const double steep = std::abs(b.z - a.z) / std::max(std::hypot(b.x - a.x, b.y - a.y), 1e-3);
    const double rise = off * (steep + relief * (1 / spacing.x + 1 / spacing.y)) +
                        8 * static_cast<double>(hfh::epsilon<T>) * size;
    const double height = static_cast<double>(patch->height(u, v));
    if (std::abs(p.z - height) > rise) wrong << "is " << p.z - height << " above the surface; ";
    return wrong.str();
}

/// Compares with brute force. A segment that grazes the surface within `rounding_bound` metres may be answered either way;
/// `clear` counts those that may not.
template <class T>
struct Compare {
    const Terrain<T>& terrain;
    int hits = 0, misses = 0, unclear = 0;

    void operator()(const dvec3& a, const dvec3& b) {
        const auto pieces = hfh::test::hit_pieces(terrain, a, b);
        const Side start = pieces.empty()              ? Side::none
                           : pieces.front().at(0) >= 0 ? Side::above
                                                       : Side::below;
        for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
            one(a, b, kind, Side::none);
            one(a, b, kind, start); // known, and so
        }
    }

    void one(const dvec3& a, const dvec3& b, SurfaceKind kind, Side side) {
        const auto found = first_hit(terrain.grid(), a, b, {.surface = kind, .side = side});
        check(a, b, kind, side, found);
    }

    void check(const dvec3& a, const dvec3& b, SurfaceKind kind, Side side, const FirstHit<T>& found) {
        // Heights of at most a few hundred metres, a few roundings of each.
        constexpr long double rounding_bound = 1e-11L;
        const auto pieces = hfh::test::hit_pieces(terrain, a, b);
        const auto exact = brute_force_hit(pieces, kind, side);
        const auto lifted = brute_force_hit(pieces, kind, side, rounding_bound);
        const auto lowered = brute_force_hit(pieces, kind, side, -rounding_bound);
        CAPTURE(a.x, a.y, a.z, b.x, b.y, b.z, static_cast<int>(kind), static_cast<int>(side));
        CAPTURE(static_cast<double>(exact.t), exact.hit, found.t);
        REQUIRE(found.status != HitStatus::cell_limit);
        const bool hit = found.status == HitStatus::hit;
        if (hit) REQUIRE(misplaced(terrain, a, b, found) == "");
        if (exact.hit != lifted.hit || exact.hit != lowered.hit || exact.side != lifted.side ||
            exact.side != lowered.side || std::abs(lifted.t - lowered.t) > 1e-3L) {
            ++unclear;
            return;
        }
        REQUIRE(hit == exact.hit);
        REQUIRE(found.side == exact.side);
        hits += hit;
        misses += !hit;
        if (hit) {
            REQUIRE(found.t >= static_cast<double>(std::min({exact.t, lifted.t, lowered.t})) - 8 * eps);
            REQUIRE(found.t <= static_cast<double>(std::max({exact.t, lifted.t, lowered.t})) + 8 * eps);
        } else {
            REQUIRE(found.t == 1);
        }
    }
};

/// Rough terrains to run every family of segments on; dyadic lattices, near and far, with holes and without.
template <class T, class Each>
void for_each_terrain(Each&& each) {
    const hfh::GridFrame frames[]{{{0, 0}, {1, 1}}, {{-30, 12.5}, {10, 2.5}}, {{1e7 + 0.125, -1e7}, {4, 16}}};
    std::uint64_t seed = 60;
    for (const auto& frame : frames) {
        for (const bool holes : {false, true}) {
            auto terrain = hfh::test::rough_in_steps<T>(8, 7, 4, ++seed, frame);
            if (holes) hfh::test::punch_holes(terrain, 8, seed);
            each(terrain);
        }
        each(hfh::test::saddle<T>(8, 7, 0.25, frame));
    }
}

template <class T>
dvec2 somewhere(Random& random, const Terrain<T>& terrain, double margin) {
    const dvec2 cells{random.between(-margin, static_cast<double>(terrain.columns - 1) + margin),
                      random.between(-margin, static_cast<double>(terrain.rows - 1) + margin)};
    return terrain.frame.origin + cells * terrain.frame.spacing;
}

template <class T>
dvec2 vertex(Random& random, const Terrain<T>& terrain) {
    const dvec2 cells{static_cast<double>(random.whole(0, terrain.columns - 1)),
                      static_cast<double>(random.whole(0, terrain.rows - 1))};
    return terrain.frame.origin + cells * terrain.frame.spacing;
}

} // namespace

TEMPLATE_TEST_CASE("first_hit: random segments hit where brute force does", "[first_hit][law]", float,
                   double) {
    using T = TestType;
    Random random{61};
    for_each_terrain<T>([&](const Terrain<T>& terrain) {
        Compare<T> compare{terrain};
        for (int n = 0; n < 1500; ++n) {
            const dvec3 a{somewhere(random, terrain, 1), random.between(-2, 6)};
            dvec3 b{somewhere(random, terrain, 1), random.between(-2, 6)};
            if (n % 3 == 0) b = a + 0.2 * (b - a); // in and about one patch
            compare(a, b);
        }
        CHECK(compare.hits > 500);
        CHECK(compare.misses > 500);
        CHECK(compare.unclear < 5);
    });
}

TEMPLATE_TEST_CASE("first_hit: segments along grid lines and through vertices hit where brute force does",
                   "[first_hit][law][hard]", float, double) {
    using T = TestType;
    Random random{62};
    for_each_terrain<T>([&](const Terrain<T>& terrain) {
        Compare<T> compare{terrain};
        for (int n = 0; n < 300; ++n) {
            const dvec2 v = vertex(random, terrain), w = vertex(random, terrain),
                        p = somewhere(random, terrain, 1), q = somewhere(random, terrain, 1);
            const auto z = [&] { return random.fraction(-1, 5, 64) + 1e-3; };
            compare({v.x, p.y, z()}, {v.x, q.y, z()});
            compare({p.x, v.y, z()}, {q.x, v.y, z()});
            compare({v, z()}, {w, z()});
            compare({v, z()}, {p, z()});
            compare({p, z()}, {2.0 * v - p, z()});
        }
        CHECK(compare.hits > 300);
        CHECK(compare.misses > 300);
        CHECK(compare.unclear < 5);
    });
}

TEMPLATE_TEST_CASE("first_hit: vertical and level segments hit where brute force does",
                   "[first_hit][law][hard]", float, double) {
    using T = TestType;
    Random random{63};
    for_each_terrain<T>([&](const Terrain<T>& terrain) {
        Compare<T> compare{terrain};
        for (int n = 0; n < 400; ++n) {
            const dvec2 p = somewhere(random, terrain, 0.5), q = somewhere(random, terrain, 0.5),
                        v = vertex(random, terrain);
            const double z = random.between(-1, 5), w = random.between(-1, 5);
            compare({p, z}, {p, w});
            compare({v, z}, {v, w});
            compare({v.x, p.y, z}, {v.x, p.y, w});
            compare({p, z}, {q, z});
            compare({p, z}, {p, z});
        }
        CHECK(compare.hits > 200);
        CHECK(compare.misses > 200);
        CHECK(compare.unclear < 5);
    });
}

TEMPLATE_TEST_CASE("first_hit: a segment of three thousand cells hits where brute force does",
                   "[first_hit][law]", float, double) {
    using T = TestType;
    Random random{64};
    const auto terrain = hfh::test::rough<T>(3100, 6, 4, 65, {{-50, 1e5}, {0.75, 3}});
    Compare<T> compare{terrain};
    Index longest = 0;
    for (int n = 0; n < 60; ++n) {
        // Level but for centimetres, just below the highest tops: some hit early, some late, some not at all.
        const double z = random.between(3.9, 4.02);
        const dvec3 a{terrain.low() + dvec2{random.between(0, 30), random.between(0, 15)}, z};
        const dvec3 b{terrain.high() - dvec2{random.between(0, 30), random.between(0, 15)},
                      z - random.between(0, 0.03)};
        compare.one(a, b, SurfaceKind::solid, Side::none);
        compare.one(b, a, SurfaceKind::sheet, Side::above);
        longest = std::max(longest, first_hit(terrain.grid(), a, b).cells);
    }
    CHECK(compare.hits > 10);
    CHECK(longest > 3000);
    CHECK(compare.unclear == 0);
}

TEMPLATE_TEST_CASE("first_hit: on a plane the crossing is one division", "[first_hit]", float, double) {
    using T = TestType;
    Random random{66};
    const auto flat = hfh::test::plane<T>(20, 20, 2, {{1e7, -1e7}, {3, 5}});
    const auto tilted = hfh::test::tilted_plane<T>(20, 20, 0.5, -0.25, 3); // dyadic, exact in float
    for (int n = 0; n < 2000; ++n) {
        const dvec3 a{somewhere(random, flat, 0), random.between(2, 9)},
            b{somewhere(random, flat, 0), random.between(-5, 2)};
        const auto found = first_hit(flat.grid(), a, b);
        REQUIRE(found.status == HitStatus::hit);
        CHECK(found.side == Side::above);
        // Heights of at most 9 m over a drop of at least 1e-2 m or so.
        CHECK(found.t == Approx((a.z - 2) / (a.z - b.z)).margin(64 * eps / (a.z - b.z)));

        const dvec2 p = somewhere(random, tilted, 0), q = somewhere(random, tilted, 0);
        const double over = random.between(0.01, 5), under = random.between(0.01, 5);
        const auto ground = [](const dvec2& at) { return 3 + 0.5 * at.x - 0.25 * at.y; };
        const auto slant =
            first_hit(tilted.grid(), dvec3{p, ground(p) + over}, dvec3{q, ground(q) - under}, sheet);
        REQUIRE(slant.status == HitStatus::hit);
        CHECK(slant.t == Approx(over / (over + under)).margin(128 * eps / (over + under)));
        const auto back =
            first_hit(tilted.grid(), dvec3{q, ground(q) - under}, dvec3{p, ground(p) + over}, sheet);
        REQUIRE(back.status == HitStatus::hit);
        CHECK(back.side == Side::below);
        CHECK(back.t == Approx(under / (over + under)).margin(128 * eps / (over + under)));
        // A solid is not met from below.
        const auto out = first_hit(tilted.grid(), dvec3{q, ground(q) - under}, dvec3{p, ground(p) + over});
        CHECK(out.status == HitStatus::miss);
        CHECK(out.side == Side::above);
    }
}

TEMPLATE_TEST_CASE("first_hit: from strictly above to strictly below nothing slips through",
                   "[first_hit][law][hard]", float, double) {
    using T = TestType;
    Random random{67};
    int slipped = 0, off = 0, checked = 0;
    for (int round = 0; round < 50; ++round) {
        // Powers of two, so that grid lines are doubles; a fifth of the terrains 10 000 km away.
        const double far = round % 5 == 0 ? 1e7 : 0;
        const double relief = std::exp2(random.whole(-6, 6));
        const auto terrain = hfh::test::rough<T>(7, 6, relief, 68 + static_cast<std::uint64_t>(round),
                                                 {{far, -far}, {2, 0.5}});
        const auto grid = terrain.grid();
        const dvec2 low = terrain.low(), high = terrain.high();
        const auto surface = [&](const dvec2& p) {
            const auto pieces = hfh::test::hit_pieces(terrain, {p, 0}, {p, 0});
            return static_cast<double>(-pieces.front().c0);
        };
        const auto nudge = [&](double x) { // up to two doubles to either side
            for (auto k = random.whole(-2, 2); k != 0; k += k > 0 ? -1 : 1) {
                x = std::nextafter(x, k > 0 ? 1e9 : -1e9);
            }
            return x;
        };
        const auto clamp = [&](dvec2 p) {
            return dvec2{std::clamp(p.x, low.x, high.x), std::clamp(p.y, low.y, high.y)};
        };
        for (int n = 0; n < 2000; ++n) {
            dvec2 p = somewhere(random, terrain, 0), q = somewhere(random, terrain, 0);
            const dvec2 v = vertex(random, terrain);
            switch (n % 8) {
            case 0: break;
            case 1: p = clamp(p), q = clamp(2.0 * v - p); break;         // through a vertex
            case 2: p = {v.x, p.y}, q = {v.x, q.y}; break;               // along a line
            case 3: p = {nudge(v.x), p.y}, q = {nudge(v.x), q.y}; break; // along it but for an ulp
            case 4: p = {nudge(v.x), nudge(v.y)}; break;                 // from around a vertex
            case 5: q = {nudge(v.x), nudge(v.y)}; break;                 // to around a vertex
            case 6: p = {nudge(v.x), nudge(v.y)}, q = {nudge(v.x), nudge(v.y)}; break;
            case 7: p = {v.x, p.y}, q = p; break; // vertical
            }
            p = clamp(p), q = clamp(q);
            const double over = relief * std::exp2(-random.between(0, 40)),
                         under = relief * std::exp2(-random.between(0, 40));
            const dvec3 a{p, surface(p) + over}, b{q, surface(q) - under};
            ++checked;
            for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
                const auto found = first_hit(grid, a, b, {.surface = kind});
                slipped += found.status != HitStatus::hit || found.side != Side::above;
                if (found.status == HitStatus::hit) off += misplaced(terrain, a, b, found) != "";
                const auto known = first_hit(grid, a, b, {.surface = kind, .side = Side::above});
                slipped += known.status != HitStatus::hit;
            }
            const auto up = first_hit(grid, b, a, sheet);
            slipped += up.status != HitStatus::hit || up.side != Side::below;
        }
    }
    CHECK(checked == 100'000);
    CHECK(slipped == 0);
    CHECK(off == 0);
}

TEMPLATE_TEST_CASE("first_hit: a segment that begins on a solid and goes down hits at once",
                   "[first_hit][hard]", float, double) {
    using T = TestType;
    const auto flat = hfh::test::plane<T>(6, 6, 2);
    const auto grid = flat.grid();
    // In a cell, on an edge, at a vertex, at the corner of the grid.
    for (const dvec2 p :
         {dvec2{2.5, 2.25}, dvec2{2, 2.25}, dvec2{2.5, 3}, dvec2{2, 3}, dvec2{0, 0}, dvec2{5, 5}}) {
        for (const dvec2 q : {p, dvec2{4.5, 1.25}, dvec2{1, 1}, dvec2{p.x, 4.5}, dvec2{5, 0}}) {
            CAPTURE(p.x, p.y, q.x, q.y);
            const auto down = first_hit(grid, dvec3{p, 2}, dvec3{q, 1});
            CHECK(down.status == HitStatus::hit);
            CHECK(down.t == 0);
            CHECK(down.side == Side::above);
            const auto up = first_hit(grid, dvec3{p, 2}, dvec3{q, 3});
            CHECK(up.status == HitStatus::miss);
            CHECK(up.side == Side::above);
            // Ending on it from above is no crossing yet; the side says that the next segment begins above.
            const auto onto = first_hit(grid, dvec3{p, 3}, dvec3{q, 2});
            CHECK(onto.status == HitStatus::miss);
            CHECK(onto.side == Side::above);
            // From below likewise.
            const auto under = first_hit(grid, dvec3{p, 1}, dvec3{q, 2});
            CHECK(under.status == HitStatus::miss);
            CHECK(under.side == Side::below);
        }
    }
}

TEMPLATE_TEST_CASE("first_hit: a segment that begins on a sheet is on the side to which it goes",
                   "[first_hit][hard]", float, double) {
    using T = TestType;
    const auto flat = hfh::test::plane<T>(6, 6, 2);
    const auto grid = flat.grid();
    for (const dvec2 p :
         {dvec2{2.5, 2.25}, dvec2{2, 2.25}, dvec2{2.5, 3}, dvec2{2, 3}, dvec2{0, 0}, dvec2{5, 5}}) {
        for (const dvec2 q : {p, dvec2{4.5, 1.25}, dvec2{1, 1}, dvec2{p.x, 4.5}, dvec2{5, 0}}) {
            CAPTURE(p.x, p.y, q.x, q.y);
            const auto down = first_hit(grid, dvec3{p, 2}, dvec3{q, 1}, sheet);
            CHECK(down.status == HitStatus::miss);
            CHECK(down.side == Side::below);
            const auto up = first_hit(grid, dvec3{p, 2}, dvec3{q, 3}, sheet);
            CHECK(up.status == HitStatus::miss);
            CHECK(up.side == Side::above);
            const auto along = first_hit(grid, dvec3{p, 2}, dvec3{q, 2}, sheet);
            CHECK(along.status == HitStatus::miss);
            CHECK(along.side == Side::above); // neither; counts as above
            // Known from before, the side stays: the stylus was held on the surface.
            const auto held = first_hit(grid, dvec3{p, 2}, dvec3{q, 1}, {SurfaceKind::sheet, Side::above});
            CHECK(held.status == HitStatus::hit);
            CHECK(held.t == 0);
            const auto lifted = first_hit(grid, dvec3{p, 2}, dvec3{q, 3}, {SurfaceKind::sheet, Side::below});
            CHECK(lifted.status == HitStatus::hit);
            CHECK(lifted.side == Side::below);
        }
    }
    // On z = (x − 4)(y − 4) at (5, 5), along (−1, −1) and level: rises over the surface, which falls away, dives again.
    const auto saddle = hfh::test::saddle<T>(9, 9);
    const auto over = first_hit(saddle.grid(), dvec3{5, 5, 1}, dvec3{2.5, 2.5, 1}, sheet);
    CHECK(over.status == HitStatus::hit);
    CHECK(over.side == Side::above);
    CHECK(over.t == Approx(0.8));
    // The same within one patch of one cell: f = s − s² over u = v = s.
    const auto tent = hfh::test::terrain<T>(2, 2, [](Index i, Index j) { return i == j ? 0 : 1; });
    const auto hump = first_hit(tent.grid(), dvec3{1, 1, 0}, dvec3{-0.5, -0.5, 0}, sheet);
    CHECK(hump.status == HitStatus::miss); // below all along: the patch is a ridge there
    CHECK(hump.side == Side::none);
    const auto trough = hfh::test::terrain<T>(2, 2, [](Index i, Index j) { return i == j ? 0 : -1; });
    const auto dip = first_hit(trough.grid(), dvec3{1, 1, 0}, dvec3{0, 0, -0.25}, sheet);
    CHECK(dip.status == HitStatus::hit); // f = 2s − 2s² − s/4: up at first, and through at s = 7/8
    CHECK(dip.side == Side::above);
    CHECK(dip.t == Approx(0.875));
}

TEMPLATE_TEST_CASE("first_hit: in and out of the same patch", "[first_hit][hard]", float, double) {
    using T = TestType;
    // One cell of the saddle z = 4·(u − ½)(v − ½) + 1: along u = v the surface is 1 + (2u − 1)², a bowl; along
    // u = 1 − v it is 1 − (2u − 1)², a hump.
    const auto terrain = hfh::test::terrain<T>(2, 2, [](Index i, Index j) { return i == j ? 2 : 0; });
    const auto grid = terrain.grid();
    const auto hump = [&](double z, const FirstHitOptions& options = {}) {
        return first_hit(grid, dvec3{0, 1, z}, dvec3{1, 0, z}, options);
    };
    const auto bowl = [&](double z, const FirstHitOptions& options = {}) {
        return first_hit(grid, dvec3{0, 0, z}, dvec3{1, 1, z}, options);
    };
    // Level at z = ¾ through the hump: in at (2u − 1)² = ¼, u = ¼.
    CHECK(hump(0.75).status == HitStatus::hit);
    CHECK(hump(0.75).t == 0.25);
    CHECK(hump(0.75, sheet).t == 0.25);
    // The tangent at its top only touches; a hair below it does not.
    CHECK(hump(1).status == HitStatus::miss);
    CHECK(hump(1).side == Side::above);
    CHECK(hump(1, sheet).status == HitStatus::miss);
    CHECK(hump(1 + 1e-12).status == HitStatus::miss);
    const auto grazing = hump(1 - 1e-12);
    CHECK(grazing.status == HitStatus::hit);
    // (2u − 1)² = 1e-12, and an error of 2ε in that; u is ½ − ½·1e-6.
    CHECK(grazing.t == Approx(0.5 - 0.5e-6).margin(1e-9));

    // Level at z = 1¼ through the bowl, from inside the solid: out at u = ¼, in again at u = ¾.
    const auto again = bowl(1.25);
    CHECK(again.status == HitStatus::hit);
    CHECK(again.t == 0.75);
    CHECK(again.side == Side::above);
    CHECK(bowl(1.25, sheet).t == 0.25);
    CHECK(bowl(1.25, sheet).side == Side::below);
    // Touching its bottom from inside is no coming out.
    CHECK(bowl(1).status == HitStatus::miss);
    CHECK(bowl(1).side == Side::below);
    CHECK(bowl(1, sheet).status == HitStatus::miss);
    CHECK(bowl(1 - 1e-12).status == HitStatus::miss);
    CHECK(bowl(1 + 1e-12).status == HitStatus::hit);
    // The last part, in the solid from the start of the segment.
    const auto tail = first_hit(grid, dvec3{0.8, 0.8, 1.25}, dvec3{1, 1, 1.25});
    CHECK(tail.status == HitStatus::miss);
    CHECK(tail.side == Side::below);
}

TEMPLATE_TEST_CASE("first_hit: across many patches of one saddle it finds every in and out",
                   "[first_hit][law]", float, double) {
    using T = TestType;
    // z = xy/8 from the middle of 41 × 41 samples: along any line one quadratic, known beforehand.
    const auto terrain = hfh::test::saddle<T>(41, 41, 0.125);
    const auto grid = terrain.grid();
    Random random{69};
    int hits = 0;
    for (int n = 0; n < 20'000; ++n) {
        const dvec2 p{random.between(0, 40), random.between(0, 40)},
            q{random.between(0, 40), random.between(0, 40)};
        const double az = random.between(-30, 30), bz = random.between(-30, 30);
        const dvec2 o = p - 20.0, d = q - p;
        using Exact = long double;
        const Exact x = Exact(o.x), y = Exact(o.y), dx = Exact(d.x), dy = Exact(d.y);
        const std::vector<hfh::test::HitPiece> one{
            {0, 1, Exact(az) - x * y / 8, Exact(bz) - Exact(az) - (x * dy + y * dx) / 8, -dx * dy / 8}};
        const auto found = first_hit(grid, dvec3{p, az}, dvec3{q, bz});
        const auto exact = brute_force_hit(one, SurfaceKind::solid);
        const auto lifted = brute_force_hit(one, SurfaceKind::solid, Side::none, 1e-11L);
        const auto lowered = brute_force_hit(one, SurfaceKind::solid, Side::none, -1e-11L);
        if (lifted.hit != lowered.hit || std::abs(lifted.t - lowered.t) > 1e-6L) continue;
        CAPTURE(p.x, p.y, az, q.x, q.y, bz);
        REQUIRE((found.status == HitStatus::hit) == exact.hit);
        if (exact.hit) REQUIRE(std::abs(found.t - static_cast<double>(exact.t)) <= 1e-6);
        hits += exact.hit;
    }
    CHECK(hits > 4'000);
}

TEMPLATE_TEST_CASE("first_hit: a known side wins over the height at the start", "[first_hit][hard]", float,
                   double) {
    using T = TestType;
    const auto grid_of = hfh::test::plane<T>(6, 6, 2);
    const auto grid = grid_of.grid();
    const dvec2 p{2.5, 2.25}, q{3.75, 0.5};
    for (const double z : {2 - 1e-15, 2.0, 1.5, -100.0}) { // a rounding below, or left behind by an edit
        const auto down = first_hit(grid, dvec3{p, z}, dvec3{q, z - 1}, {.side = Side::above});
        CHECK(down.status == HitStatus::hit);
        CHECK(down.t == 0);
    }
    // Above but for a rounding and going up: no contact on the way.
    const auto out = first_hit(grid, dvec3{p, 2 - 1e-15}, dvec3{q, 3}, {.side = Side::above});
    CHECK(out.status == HitStatus::miss);
    CHECK(out.side == Side::above);
    // Below by decree: a solid has to be left first, and leaving it is no contact.
    const auto buried = first_hit(grid, dvec3{p, 2 + 1e-15}, dvec3{q, 1}, {.side = Side::below});
    CHECK(buried.status == HitStatus::miss);
    CHECK(buried.side == Side::below);
    const auto freed = first_hit(grid, dvec3{p, 2 - 1e-15}, dvec3{q, 3}, {.side = Side::below});
    CHECK(freed.status == HitStatus::miss);
    CHECK(freed.side == Side::above);
    // A sheet met from below.
    const auto met = first_hit(grid, dvec3{p, 1}, dvec3{q, 3}, {SurfaceKind::sheet, Side::below});
    CHECK(met.status == HitStatus::hit);
    CHECK(met.side == Side::below);
    CHECK(met.t == Approx(0.5));
}

TEMPLATE_TEST_CASE("first_hit: a segment that leaves the surface meets what lies beyond",
                   "[first_hit][regression]", float, double) {
    using T = TestType;
    // A start an ulp over flat ground is above the highest corner of its patch: it has left the surface there, and the
    // ridge at x = 7 was taken for a rounding of the start.
    const auto up = hfh::test::terrain<T>(12, 4, [](Index i, Index) { return i == 7 ? 6 : 2; });
    const auto down = hfh::test::terrain<T>(12, 4, [](Index i, Index) { return i == 7 ? -6 : -2; });
    for (const double z : {2.0, 2 - 4 * eps, 2 - 2 * eps, 2 + 2 * eps, 2 + 4 * eps}) {
        for (const double x : {2.0, 2.5}) {
            for (const double y : {1.0, 1.5}) {
                CAPTURE(z - 2, x, y);
                // z = 2 + (x' − x)/(9.5 − x) meets 2 + 4·(x' − 6).
                const double t = (6 - x) * 4 / (4 * (9.5 - x) - 1);
                const FirstHitOptions above{.side = Side::above, .leaves_within = 0};
                const auto met = first_hit(up.grid(), dvec3{x, y, z}, dvec3{9.5, y, 3}, above);
                CHECK(met.status == HitStatus::hit);
                CHECK(met.t == Approx(t).margin(16 * eps));
                const FirstHitOptions below{
                    .surface = SurfaceKind::sheet, .side = Side::below, .leaves_within = 0};
                const auto under = first_hit(down.grid(), dvec3{x, y, -z}, dvec3{9.5, y, -3}, below);
                CHECK(under.status == HitStatus::hit);
                CHECK(under.side == Side::below);
                CHECK(under.t == Approx(t).margin(16 * eps));
            }
        }
    }
}

TEMPLATE_TEST_CASE("first_hit: a buried start feels nothing until it has been outside", "[first_hit]", float,
                   double) {
    using T = TestType;
    const auto terrain = hfh::test::valley<T>(9, 3, 1); // z = |x − 4|
    const auto grid = terrain.grid();
    // Level at z = 2.25: in the flank, over the valley, into the other flank.
    const auto across = first_hit(grid, dvec3{0.5, 1.25, 2.25}, dvec3{7.5, 1.25, 2.25});
    CHECK(across.status == HitStatus::hit);
    CHECK(across.t == Approx(5.75 / 7));
    CHECK(across.point.cell == Cell{6, 1});
    const auto inside = first_hit(grid, dvec3{0.5, 1.25, 2}, dvec3{1.5, 1.25, 2});
    CHECK(inside.status == HitStatus::miss);
    CHECK(inside.side == Side::below);
    const auto outside = first_hit(grid, dvec3{0.5, 1.25, 2}, dvec3{4.5, 1.25, 2});
    CHECK(outside.status == HitStatus::miss);
    CHECK(outside.side == Side::above);
}

TEMPLATE_TEST_CASE("first_hit: where there is no patch there is no side", "[first_hit][hard]", float,
                   double) {
    using T = TestType;
    auto terrain = hfh::test::plane<T>(9, 5, 0);
    terrain.remove(4, 2); // no patch for 3 ≤ x ≤ 5, 1 ≤ y ≤ 3
    const auto grid = terrain.grid();
    // Down the hole, on below the surface and up again elsewhere: not met.
    const auto through = first_hit(grid, dvec3{1, 2, 3}, dvec3{7.5, 2, -3.5});
    CHECK(through.status == HitStatus::miss);
    CHECK(through.side == Side::below);
    const auto into = first_hit(grid, dvec3{4, 2, 3}, dvec3{4, 2, -3});
    CHECK(into.status == HitStatus::miss);
    CHECK(into.side == Side::none);
    CHECK(first_hit(grid, dvec3{1, 2, 3}, dvec3{4, 2, -0.5}).side == Side::none);
    // From the hole, below: decided when the patch is entered, even against a known side.
    const auto under = first_hit(grid, dvec3{4.5, 2.5, -1}, dvec3{7.5, 2.5, -2}, {.side = Side::above});
    CHECK(under.status == HitStatus::miss);
    CHECK(under.side == Side::below);
    // Over the hole and down behind it.
    const auto behind = first_hit(grid, dvec3{1, 2, 3}, dvec3{7, 2, -1});
    CHECK(behind.status == HitStatus::hit);
    CHECK(behind.t == 0.75);
    // The rim belongs to the surface: along it, and down at its corner.
    const auto rim = first_hit(grid, dvec3{3, 0.5, 1}, dvec3{3, 2.5, -1});
    CHECK(rim.status == HitStatus::hit);
    CHECK(rim.t == 0.5);
    CHECK(first_hit(grid, dvec3{3, 1, 1}, dvec3{3, 1, -1}).status == HitStatus::hit);
    CHECK(first_hit(grid, dvec3{3.001, 1.001, 1}, dvec3{3.001, 1.001, -1}).status == HitStatus::miss);
    // Through the corner of the hole, from patch to patch: the surface does not tear there.
    const auto corner = first_hit(grid, dvec3{2, 2, 1}, dvec3{4, 0, -3});
    CHECK(corner.status == HitStatus::hit);
    CHECK(corner.t == 0.25);
}

TEMPLATE_TEST_CASE("first_hit: outside the grid there is nothing to hit", "[first_hit][hard]", float,
                   double) {
    using T = TestType;
    const auto terrain = hfh::test::plane<T>(5, 5, 0);
    const auto grid = terrain.grid();
    for (const auto side : {Side::none, Side::above, Side::below}) {
        const FirstHitOptions options{.side = side};
        const auto away = first_hit(grid, dvec3{-3, 1, 1}, dvec3{-1, 3, -1}, options);
        CHECK(away.status == HitStatus::miss);
        CHECK(away.side == Side::none);
        CHECK(away.cells == 0);
        CHECK(away.t == 1);
        // In over the border, above: hits. Below: passes under.
        const auto over = first_hit(grid, dvec3{-2, 1.5, 2}, dvec3{2, 1.5, -1}, options);
        CHECK(over.status == HitStatus::hit);
        CHECK(over.side == Side::above);
        CHECK(over.t == Approx(2.0 / 3));
        const auto under = first_hit(grid, dvec3{-2, 1.5, -1}, dvec3{2, 1.5, -2}, options);
        CHECK(under.status == HitStatus::miss);
        CHECK(under.side == Side::below);
        // Out over the border.
        CHECK(first_hit(grid, dvec3{2, 1.5, 1}, dvec3{9, 1.5, -9}, {.side = Side::above}).side ==
              Side::above);
        CHECK(first_hit(grid, dvec3{2, 1.5, 9}, dvec3{9, 1.5, -1}, options).side == Side::none);
    }
    hfh::BilinearGrid<T, hfh::HeightView<T>> empty{hfh::HeightView{terrain.heights.data(), 5, 5},
                                                   {{0, 0}, {0, 0}}};
    CHECK(first_hit(empty, dvec3{1, 1, 1}, dvec3{1, 1, -1}).status == HitStatus::miss);
}

TEMPLATE_TEST_CASE("first_hit: the ridge between the stylus and the far side is met on the near side",
                   "[first_hit]", float, double) {
    using T = TestType;
    // Figure 8 [P]: two peaks, and a segment through both.
    const auto terrain =
        hfh::test::terrain<T>(12, 4, [](Index i, Index) { return i == 3 || i == 7 ? 6 : 0; });
    const auto found = first_hit(terrain.grid(), dvec3{1.5, 1.5, 3}, dvec3{9.5, 1.5, 3});
    REQUIRE(found.status == HitStatus::hit);
    CHECK(found.point.cell == Cell{2, 1});
    CHECK(found.t == 0.125);
    const auto back = first_hit(terrain.grid(), dvec3{9.5, 1.5, 3}, dvec3{1.5, 1.5, 3});
    CHECK(back.point.cell == Cell{7, 1});
}

TEMPLATE_TEST_CASE("first_hit: counts the cells it looks at and stops at the limit", "[first_hit]", float,
                   double) {
    using T = TestType;
    const auto terrain = hfh::test::plane<T>(20, 3, 0);
    const auto grid = terrain.grid();
    const dvec3 a{0.5, 0.5, 5}, b{18.5, 0.5, 4};
    CHECK(first_hit(grid, a, b).cells == 19);
    for (Index limit = 1; limit < 19; ++limit) {
        const auto found = first_hit(grid, a, b, {.side = Side::above, .max_cells = limit});
        CHECK(found.status == HitStatus::cell_limit);
        CHECK(found.cells == limit);
        CHECK(found.side == Side::above);
        CHECK(found.t == Approx((static_cast<double>(limit) - 0.5) / 18)); // where the next cell begins
    }
    const auto just = first_hit(grid, a, b, {.max_cells = 19});
    CHECK(just.status == HitStatus::miss);
    CHECK(just.t == 1);
}

TEMPLATE_TEST_CASE("first_hit: going on from where the limit stopped finds the same crossing",
                   "[first_hit][law][hard]", float, double) {
    using T = TestType;
    Random random{70};
    int resumed = 0, hits = 0;
    for_each_terrain<T>([&](const Terrain<T>& terrain) {
        const auto grid = terrain.grid();
        // A stop is rounded, and no longer on a line that runs aslant through vertices; at the corner of a hole that
        // is the difference between surface and none.
        const bool holes =
            std::any_of(terrain.heights.begin(), terrain.heights.end(), [](T z) { return z != z; });
        Compare<T> compare{terrain};
        for (int n = 0; n < 600; ++n) {
            dvec3 a{somewhere(random, terrain, 1), random.between(-1, 6)};
            dvec3 b{somewhere(random, terrain, 1), random.between(-2, 5)};
            if (n % 4 == 1) a.x = b.x = vertex(random, terrain).x;
            if (n % 4 == 2 && !holes) a = {vertex(random, terrain), a.z}, b = {vertex(random, terrain), b.z};
            const auto kind = n % 2 == 0 ? SurfaceKind::solid : SurfaceKind::sheet;
            const Index limit = random.whole(1, 6);
            CAPTURE(limit, n);
            dvec3 from = a;
            FirstHit<T> found;
            found.side = Side::none;
            double done = 0; // how far along a → b
            for (int casts = 0;; ++casts) {
                REQUIRE(casts < 100);
                found = first_hit(grid, from, b, {.surface = kind, .side = found.side, .max_cells = limit});
                done += (1 - done) * found.t;
                if (found.status != HitStatus::cell_limit) break;
                ++resumed;
                from = from + found.t * (b - from);
            }
            found.t = found.status == HitStatus::hit ? done : 1;
            hits += found.status == HitStatus::hit;
            // The stops are rounded to doubles, by up to 2e-9 m far out.
            if (std::abs(terrain.frame.origin.x) < 1e6) compare.check(a, b, kind, Side::none, found);
        }
        CHECK(compare.unclear < 5);
    });
    CHECK(resumed > 1'000);
    CHECK(hits > 1'000);
}

namespace {

/// Whether they found the same, to the bit.
template <class Hit>
[[nodiscard]] bool same(const Hit& one, const Hit& other) {
    return one.status == other.status && one.t == other.t && one.side == other.side &&
           one.leaving == other.leaving && one.point.cell == other.point.cell &&
           one.point.u == other.point.u && one.point.v == other.point.v;
}

struct Segment {
    dvec3 a, b;
};
/// The nth segment: anywhere; along a grid line; aslant through vertices; from one height of the ground to another, so that
/// it grazes what is between.
template <class T>
[[nodiscard]] Segment any_segment(Random& random, const Terrain<T>& terrain, int n) {
    dvec3 a{somewhere(random, terrain, 1), random.between(-1, 6)},
        b{somewhere(random, terrain, 1), random.between(-2, 5)};
    const auto some_height = [&] {
        const auto sample = static_cast<std::size_t>(random.whole(0, std::ssize(terrain.heights) - 1));
        const T height = terrain.heights[sample];
        return height == height ? static_cast<double>(height) : 0.0; // "no data"
    };
    if (n % 6 == 1) a.x = b.x = vertex(random, terrain).x;
    if (n % 6 == 2) a.y = b.y = vertex(random, terrain).y;
    if (n % 6 >= 3) a = {vertex(random, terrain), a.z}, b = {vertex(random, terrain), b.z};
    if (n % 6 == 4) a.z = b.z = static_cast<double>(random.whole(-2, 3));
    if (n % 6 == 5) a.z = b.z = some_height();
    return {a, b};
}
[[nodiscard]] FirstHitOptions any_options(Random& random) {
    FirstHitOptions options{.surface = random.one_in(2) ? SurfaceKind::solid : SurfaceKind::sheet};
    if (random.one_in(3)) return options;
    options.side = random.one_in(2) ? Side::above : Side::below;
    if (random.one_in(2)) options.leaves_within = random.between(0, 0.3);
    return options;
}

} // namespace

TEMPLATE_TEST_CASE(
    "first_hit: a search of the same segment goes on as if it had not been cut short, to the bit",
    "[first_hit][law][limited][hard]", float, double) {
    using T = TestType;
    Random random{72};
    int pieces = 0, hits = 0, leaving = 0;
    for_each_terrain<T>([&](const Terrain<T>& terrain) {
        const auto grid = terrain.grid();
        for (int n = 0; n < 600; ++n) {
            const auto [a, b] = any_segment(random, terrain, n);
            FirstHitOptions options = any_options(random);
            const double leaves_within = options.leaves_within;
            const auto whole = first_hit(grid, a, b, options);
            options.max_cells = random.whole(1, 6);
            CAPTURE(options.max_cells, n, a.x, a.y, a.z, b.x, b.y, b.z);
            auto found = first_hit(grid, a, b, options);
            for (int casts = 1; found.status == HitStatus::cell_limit; ++casts) {
                REQUIRE(casts < 100);
                REQUIRE(found.cells <= glm::max<Index>(options.max_cells, 4) + 3);
                REQUIRE(found.t > options.begin_at);
                options.begin_at = found.t, options.side = found.side;
                options.leaves_within = found.leaving ? leaves_within : -1;
                ++pieces, leaving += found.leaving;
                found = first_hit(grid, a, b, options);
            }
            hits += found.status == HitStatus::hit;
            CHECK(same(found, whole));
        }
    });
    CHECK(pieces > 5'000);
    CHECK(hits > 1'000);
    CHECK(leaving > 200);
}

TEMPLATE_TEST_CASE("first_hit: a search in pieces leaves the surface as one search does",
                   "[first_hit][law][limited]", float, double) {
    using T = TestType;
    constexpr double rounding = 0.05;
    Random random{71};
    int still_leaving = 0, hits = 0, misses = 0;
    for (int n = 0; n < 4000; ++n) {
        // Steps that a segment stays on, and ridges and pits.
        const auto ground = hfh::test::terrain<T>(8, 7, [&](Index, Index) {
            return random.one_in(6) ? random.between(-1, 1) : random.between(-0.04, 0.04);
        });
        const auto grid = ground.grid();
        const dvec2 place = somewhere(random, ground, -0.5);
        const Cell cell{static_cast<Index>(place.x), static_cast<Index>(place.y)};
        const double z = static_cast<double>(grid.patch(cell)->height(
            static_cast<T>(place.x - std::floor(place.x)), static_cast<T>(place.y - std::floor(place.y))));
        const dvec3 a{place, z}, b{somewhere(random, ground, 0.5), random.between(-0.1, 0.1)};
        FirstHitOptions options{.surface = n % 2 == 0 ? SurfaceKind::solid : SurfaceKind::sheet,
                                .side = n % 3 == 0 ? Side::below : Side::above,
                                .leaves_within = rounding};
        const auto whole = first_hit(grid, a, b, options);

        options.max_cells = random.whole(1, 4);
        CAPTURE(n, options.max_cells, a.x, a.y, a.z, b.x, b.y, b.z);
        dvec3 from = a;
        auto found = first_hit(grid, from, b, options);
        for (int casts = 1; found.status == HitStatus::cell_limit; ++casts) {
            REQUIRE(casts < 100);
            still_leaving += found.leaving;
            from = from + found.t * (b - from);
            options.side = found.side;
            options.leaves_within = found.leaving ? rounding : -1;
            found = first_hit(grid, from, b, options);
        }
        REQUIRE(found.status == whole.status);
        REQUIRE(found.side == whole.side);
        if (found.status == HitStatus::hit) {
            ++hits;
            CHECK(std::abs(from.x + found.t * (b.x - from.x) - a.x - whole.t * (b.x - a.x)) < 1e-9);
        } else {
            ++misses;
            CHECK(found.t == 1);
        }
    }
    CHECK(still_leaving > 1'000);
    CHECK(hits > 500);
    CHECK(misses > 500);
}
