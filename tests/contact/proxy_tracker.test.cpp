#include "catch.hpp"
#include "support/real_terrains.hpp"
#include "support/scenes.hpp"
#include "support/witness.hpp"

#include <hfh/force/force_evaluator.hpp>

#include <array>
#include <cstring>

using namespace hfh;
using namespace hfh::test;

namespace {

template <Real T>
using Bytes = std::array<unsigned char, sizeof(TrackerState<T, PlaceScalar<T>>)>;

/// The state of a tracker, bit by bit.
template <HeightField Field>
auto bits(const ProxyTracker<Field>& tracker) {
    Bytes<typename Field::Scalar> bytes;
    std::memcpy(bytes.data(), &tracker.state(), bytes.size());
    return bytes;
}

template <Real T>
bool same(const Contact<T>& a, const Contact<T>& b) {
    return a.status == b.status && a.side == b.side && a.proxy == b.proxy && a.normal == b.normal &&
           a.penetration == b.penetration && a.depth == b.depth && a.point.cell == b.point.cell &&
           a.point.u == b.point.u && a.point.v == b.point.v;
}

template <Real T>
Wide x_of(const SurfacePoint<T>& s) {
    return static_cast<Wide>(s.cell.i) + static_cast<Wide>(s.u);
}
template <Real T>
Wide y_of(const SurfacePoint<T>& s) {
    return static_cast<Wide>(s.cell.j) + static_cast<Wide>(s.v);
}

/// Ridges of one cell to each side and `height` metres, along every column that is a multiple of `every`.
template <Real T>
Terrain<T> comb(Index columns, Index rows, double height, Index every) {
    return terrain<T>(columns, rows, [=](Index i, Index) { return i % every == 0 ? height : 0.0; });
}

/// Two ridges along the diagonals i − j = ±2, of single samples `height` metres high: each patch on a diagonal is a
/// saddle with one face to each side of the ridge.
template <Real T>
Terrain<T> diagonal_ridges(double height) {
    return terrain<T>(24, 24, [=](Index i, Index j) { return i - j == 2 || i - j == -2 ? height : 0.0; });
}

/// §4.3.2 as the paper has it: the bounded closest point of the patch, then of its neighbours, moving to the patch that
/// is closest as long as that helps. By brute force.
template <Real T>
WideSurfacePoint closest_patch_search(const Surface<T>& surface, Index i, Index j, const Point& q) {
    for (;;) {
        const Foot foot = search_closest_point(*surface.patch(i, j), surface.seen_from(q, i, j));
        Wide nearest = foot.distance * (1 - 1e-12L);
        Index next_i = i, next_j = j;
        surface.each_patch_at({i, j, foot.u, foot.v}, [&](const WidePatch& p, Wide, Wide, Index m, Index n) {
            const Foot other = search_closest_point(p, surface.seen_from(q, m, n));
            if (other.distance < nearest) nearest = other.distance, next_i = m, next_j = n;
        });
        if (next_i == i && next_j == j) return {i, j, foot.u, foot.v};
        i = next_i, j = next_j;
    }
}

/// A length or a direction is the same to the bit; under -ffast-math, where a root is an estimate and a correction, but for
/// two roundings.
template <Real T>
bool is_length(T found, T wanted) {
#ifdef __FAST_MATH__
    return std::abs(found - wanted) <= 2 * epsilon<T> * wanted;
#else
    return found == wanted;
#endif
}
template <Real T>
bool is_direction(const vec3<T>& normal, const vec3<T>& wanted) {
#ifdef __FAST_MATH__
    return length(normal - wanted) <= 2 * epsilon<T>;
#else
    return normal == wanted;
#endif
}

/// No more than a few microseconds an update.
constexpr TrackerOptions brisk{.max_contact_patches = 8};

/// Runs a hand over a terrain under a witness.
template <Real T>
void check_hand(const char* name, const Terrain<T>& ground, const TrackerOptions& options, std::uint64_t seed,
                int updates, double longest_swipe = 100) {
    Witness<T> witness{ground, options};
    Hand<T> hand{ground, seed, longest_swipe};
    for (int n = 0; n < updates && witness.faults < 3; ++n) witness.update(hand.next());
    INFO(name << ", patches at most " << witness.most_patches << ", in contact " << witness.contacts << " of "
              << witness.updates);
    CHECK(witness.first_fault == "");
    CHECK(witness.faults == 0);
    CHECK(witness.contacts * 10 > witness.updates);
}

} // namespace

TEMPLATE_TEST_CASE("ProxyTracker: keeps its invariants under any hand on synthetic terrains",
                   "[proxy_tracker][law]", float, double) {
    for (const auto& scene : scenes<TestType>()) check_hand(scene.name, scene.terrain, {}, 31, 20000);
}

TEMPLATE_TEST_CASE("ProxyTracker: keeps its invariants on a sheet, felt from either side",
                   "[proxy_tracker][law]", float, double) {
    for (const auto& scene : scenes<TestType>()) {
        check_hand(scene.name, scene.terrain, {.surface = SurfaceKind::sheet}, 32, 10000);
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: keeps its invariants among holes", "[proxy_tracker][law]", float, double) {
    std::uint64_t seed = 33;
    for (auto& scene : scenes<TestType>()) {
        punch_holes(scene.terrain, 24, seed++);
        check_hand(scene.name, scene.terrain, {}, seed, 10000);
        check_hand(scene.name, scene.terrain, {.surface = SurfaceKind::sheet}, seed, 10000);
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: keeps its invariants on real terrains without holes",
                   "[proxy_tracker][law][real][ieee]", float, double) {
    on_real_terrains_or_skip<TestType>(real_terrains_without_holes, [](const auto& name, const auto& ground) {
        check_hand(name.c_str(), ground, {}, 34, 40000);
    });
}

TEMPLATE_TEST_CASE("ProxyTracker: keeps its invariants on real terrains with holes",
                   "[proxy_tracker][law][real][ieee]", float, double) {
    on_real_terrains_or_skip<TestType>(real_terrains_with_holes, [](const auto& name, const auto& ground) {
        check_hand(name.c_str(), ground, {}, 35, 40000);
    });
}

TEMPLATE_TEST_CASE("ProxyTracker: keeps its invariants when it may slide no farther than a little",
                   "[proxy_tracker][law][real][ieee]", float, double) {
    constexpr TrackerOptions brisk_sheet{.surface = SurfaceKind::sheet,
                                         .max_contact_patches = brisk.max_contact_patches};
    std::uint64_t seed = 37;
    for (auto& scene : scenes<TestType>()) {
        check_hand(scene.name, scene.terrain, brisk, seed, 10000);
        check_hand(scene.name, scene.terrain, brisk_sheet, seed, 10000);
        check_hand(scene.name, scene.terrain, {.max_contact_patches = 1}, seed, 10000);
        punch_holes(scene.terrain, 24, seed++);
        check_hand(scene.name, scene.terrain, brisk, seed, 10000);
        check_hand(scene.name, scene.terrain, brisk_sheet, seed, 10000);
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: keeps its invariants on scans when it may slide no farther than a little",
                   "[proxy_tracker][law][real][ieee]", float, double) {
    on_real_terrains_or_skip<TestType>(
        {"kinect_boxes", "bullet_scan"},
        [](const auto& name, const auto& ground) { check_hand(name.c_str(), ground, brisk, 53, 20000); });
}

TEMPLATE_TEST_CASE("ProxyTracker: first contact is at the first crossing, wherever it is along the segment",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    // Ridges every 4 cells. A swipe at a third of their height, over several of them, hits the first one first; its
    // near face holds the proxy, for its perpendiculars reach 25 cells. The stylus ends between ridges, above ground.
    const auto ground = comb<T>(129, 9, 6, 4);
    const auto grid = ground.grid();
    Random random{36};
    for (int n = 0; n < 500; ++n) {
        const double from = 4 * double(random.whole(1, 30)) + random.between(1.5, 2.5),
                     length = random.between(6, 18);
        const bool eastward = random.one_in(2);
        const double to = eastward ? from + length : from - length;
        const double between = 4 * std::floor(to / 4) + 2 + random.between(-0.25, 0.25);
        if (between < 0 || between > 128) continue;
        const T y0 = static_cast<T>(random.between(1, 7)), y1 = static_cast<T>(random.between(1, 7));
        ProxyTracker tracker{grid};
        REQUIRE(tracker.update({static_cast<T>(from), y0, T(3)}).status == ContactStatus::free);
        const auto contact = tracker.update({static_cast<T>(between), y1, T(2)});
        const double ridge = eastward ? 4 * std::ceil(from / 4) : 4 * std::floor(from / 4);
        CAPTURE(from, between, ridge);
        REQUIRE(contact.status == ContactStatus::contact);
        CHECK(std::abs(static_cast<double>(x_of(contact.point)) - ridge) <= 1);
        CHECK((eastward ? contact.normal.x < 0 : contact.normal.x > 0));
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: over a ridge and down behind it, it hits the far face", "[proxy_tracker]",
                   float, double) {
    using T = TestType;
    const auto ground = terrain<T>(25, 13, [](Index i, Index) { return i == 12 ? 10.0 : 0.0; });
    const auto grid = ground.grid();
    ProxyTracker tracker{grid};
    for (const T x : {T(11.7), T(12.2), T(12.7)})
        CHECK(tracker.update({x, T(6.3), T(11)}).status == ContactStatus::free);
    const auto c = tracker.update({T(12.7), T(6.3), T(2.5)});
    CHECK(c.status == ContactStatus::contact);
    CHECK(c.normal.x > 0); // on the far face
}

TEMPLATE_TEST_CASE("ProxyTracker: of Figure 8's two peaks the proxy stays on the near side of the first",
                   "[proxy_tracker][hard]", float, double) {
    using T = TestType;
    const auto ground = diagonal_ridges<T>(10);
    Witness<T> witness{ground};
    // In one update across the ridge i − j = 2, to a point between the ridges that is above the ground there.
    const vec3<T> from{T(14), T(5.125), T(2.25)}, to{T(10.125), T(8.875), T(2.25)};
    REQUIRE(witness.surface.height(10.125L, 8.875L).value() < 2.25L);
    REQUIRE(witness.update(from).status == ContactStatus::free);
    const auto contact = witness.update(to);
    CHECK(contact.status == ContactStatus::contact);
    CHECK(x_of(contact.point) - y_of(contact.point) > 2); // on the near side
    CHECK(contact.normal.x > 0);
    CHECK(contact.normal.y < 0);
    CHECK(contact.depth > T(0.5));
    CHECK(contact.penetration.x > 0); // back to where it came from
    CHECK(contact.penetration.y < 0);

    // This is a real Figure 8: from the patch that the segment meets first, the closest patch is the way through.
    const auto lost = closest_patch_search(witness.surface, 10, 8, wide(to));
    const Point through = witness.surface.position(lost);
    CHECK(through.x - through.y < 2);                                 // on the far side
    CHECK(dot(through - wide(to), witness.surface.normal(lost)) < 0); // where the paper applies no force

    // The force holds while the hand goes on between the ridges and up to the second one, and lets go on the way back.
    for (int k = 0; k <= 16; ++k) {
        const T s = static_cast<T>(k) / 16;
        const auto held = witness.update({to.x - s, to.y + s, T(2.25)});
        CHECK(held.status == ContactStatus::contact);
        CHECK(x_of(held.point) - y_of(held.point) > 2);
    }
    for (int k = 0; k <= 16; ++k) witness.update({to.x - 1 + T(k) / 4, to.y + 1 - T(k) / 4, T(2.25)});
    CHECK_FALSE(witness.tracker.state().touching());
    CHECK(witness.first_fault == "");
}

TEMPLATE_TEST_CASE("ProxyTracker: is never pushed through a ridge one cell wide", "[proxy_tracker][hard]",
                   float, double) {
    using T = TestType;
    // A knife edge along x = 12, ten cells high, one cell to each side. Pressed from the west at a twentieth of a cell
    // an update, to well beyond the far foot: the proxy stays on the west face, force grows all the way.
    const auto ground = terrain<T>(25, 13, [](Index i, Index) { return i == 12 ? 10.0 : 0.0; });
    Witness<T> witness{ground};
    witness.update({T(10), T(6.3), T(3)});
    T depth = 0;
    for (int k = 0; k <= 100; ++k) {
        const auto c = witness.update({T(10) + T(k) / 20, T(6.3), T(3)});
        if (T(10) + T(k) / 20 > T(11.4)) {
            CHECK(c.status == ContactStatus::contact);
            CHECK(c.normal.x < 0);
            CHECK(c.depth > depth);
            depth = c.depth;
        }
    }
    CHECK(depth > T(2.5));
    CHECK(witness.first_fault == "");
}

TEMPLATE_TEST_CASE(
    "ProxyTracker: released from one face and below another, it is in contact in the same update",
    "[proxy_tracker]", float, double) {
    using T = TestType;
    // Walls of slope 4 that meet at x = 12. The stylus leaves the west wall and is a metre below the east wall.
    const auto ground = valley<T>(25, 20, 4);
    Witness<T> witness{ground};
    witness.update({T(11.5), T(9.25), T(10)});
    const auto west = witness.update({T(9.5), T(9.25), T(9)});
    REQUIRE(west.status == ContactStatus::contact);
    CHECK(west.normal.x > 0);
    const auto east = witness.update({T(14.5), T(9.25), T(9)});
    CHECK(east.status == ContactStatus::contact);
    CHECK(east.normal.x < 0);
    // A metre straight up is 1/√17 m along the normal; coordinates up to 14.5 m, rounded a few times.
    CHECK(std::abs(static_cast<double>(east.depth) - 1 / std::sqrt(17.0)) <=
          200 * static_cast<double>(epsilon<T>));
    CHECK(witness.first_fault == "");
}

TEMPLATE_TEST_CASE("ProxyTracker: released into the open it is free, with the proxy at the stylus",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    const auto ground = hills<T>(25, 25, 2, 8);
    Witness<T> witness{ground};
    Random random{37};
    for (int n = 0; n < 300; ++n) {
        const T x = static_cast<T>(random.between(2, 22)), y = static_cast<T>(random.between(2, 22));
        witness.reset();
        REQUIRE(witness.update({x, y, T(3)}).status == ContactStatus::free);
        REQUIRE(witness.update({x, y, T(-1.5)}).status == ContactStatus::contact);
        const vec3<T> up{x, y, T(2.5)};
        const auto free = witness.update(up);
        REQUIRE(free.status == ContactStatus::free);
        REQUIRE(free.proxy == up);
        REQUIRE(free.depth == 0);
    }
    CHECK(witness.first_fault == "");
}

TEMPLATE_TEST_CASE("ProxyTracker: on the surface itself it pulls nowhere", "[proxy_tracker][hard]", float,
                   double) {
    using T = TestType;
    // Down to the surface exactly (dyadic places on dyadic heights), then an ulp below and above by turns.
    const auto ground = rough_in_steps<T>(17, 17, 2, 38);
    Witness<T> witness{ground};
    Random random{39};
    for (int n = 0; n < 2000; ++n) {
        const double x = random.fraction(1, 15, 8), y = random.fraction(1, 15, 8);
        const T z = static_cast<T>(*witness.surface.height(static_cast<Wide>(x), static_cast<Wide>(y)));
        const vec3<T> on{static_cast<T>(x), static_cast<T>(y), z};
        witness.reset();
        REQUIRE(witness.update({on.x, on.y, T(4)}).status == ContactStatus::free);
        for (const T height : {z, std::nextafter(z, T(-9)), z, std::nextafter(z, T(9)), z}) {
            const auto c = witness.update({on.x, on.y, height});
            REQUIRE(c.depth <= 4 * epsilon<T>);
        }
    }
    CHECK(witness.first_fault == "");
}

TEMPLATE_TEST_CASE("ProxyTracker: is felt however deep it is, to the bit on level ground", "[proxy_tracker]",
                   float, double) {
    using T = TestType;
    const auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid};
    CHECK(tracker.update({T(4.5), T(4.25), T(1)}).status == ContactStatus::free);
    const int deepest = std::same_as<T, float> ? 30 : 254;
    for (int power = -20; power <= deepest; ++power) {
        CAPTURE(power);
        const T depth = std::ldexp(T(1), power);
        const auto c = tracker.update({T(4.5), T(4.25), -depth});
        REQUIRE(c.status == ContactStatus::contact);
        REQUIRE(c.penetration == vec3<T>{T(0), T(0), depth});
        REQUIRE(is_length(c.depth, depth));
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: slides off the border, says so once, and is off the surface then",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    const auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    const ForceEvaluator<T> force{};
    for (const vec3<T>& way : {vec3<T>{1, 0, 0}, vec3<T>{-1, 0, 0}, vec3<T>{0, 1, 0}, vec3<T>{0, -1, 0},
                               vec3<T>{1, 1, 0}, vec3<T>{-1, 1, 0}}) {
        ProxyTracker tracker{grid};
        const vec3<T> middle{T(4), T(4), T(-0.5)};
        CHECK(tracker.update({T(4), T(4), T(1)}).status == ContactStatus::free);
        CHECK(tracker.update(middle).status == ContactStatus::contact);
        CHECK(tracker.update(middle + T(4) * way).status == ContactStatus::contact); // on the rim is still on
        const auto left = tracker.update(middle + T(4.125) * way);
        CHECK(left.status == ContactStatus::left_at_border);
        CHECK(left.proxy == middle + T(4.125) * way);
        CHECK(force(left).newtons == vec3<T>{T(0)});
        CHECK_FALSE(tracker.state().touching());
        CHECK(tracker.update(middle + T(4.25) * way).status == ContactStatus::off_surface);
        // Back in below the ground: nothing until it has been outside.
        CHECK(tracker.update(middle + T(3) * way).status == ContactStatus::buried);
        CHECK(tracker.update({T(4), T(4), T(1)}).status == ContactStatus::free);
        CHECK(tracker.update(middle).status == ContactStatus::contact);
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: slides off the rim of a hole, and says so", "[proxy_tracker]", float,
                   double) {
    using T = TestType;
    auto ground = plane<T>(13, 13);
    ground.remove(6, 6); // no patch over 5..7 × 5..7
    const auto grid = ground.grid();
    const ForceEvaluator<T> force{};
    ProxyTracker tracker{grid};
    CHECK(tracker.update({T(4), T(6), T(1)}).status == ContactStatus::free);
    CHECK(tracker.update({T(4), T(6), T(-1)}).status == ContactStatus::contact);
    CHECK(tracker.update({T(5), T(6), T(-1)}).status == ContactStatus::contact);
    const auto left = tracker.update({T(5.25), T(6), T(-1)});
    CHECK(left.status == ContactStatus::left_at_hole);
    CHECK(force(left).newtons == vec3<T>{T(0)});
    CHECK(tracker.update({T(6), T(6), T(-1)}).status == ContactStatus::off_surface);
    CHECK(tracker.update({T(7.5), T(6), T(-1)}).status == ContactStatus::buried);
    CHECK(tracker.update({T(6), T(6), T(0.5)}).status == ContactStatus::off_surface); // up through the hole
    CHECK(tracker.update({T(8), T(6), T(0.5)}).status == ContactStatus::free);
    CHECK(tracker.update({T(8), T(6), T(-0.5)}).status == ContactStatus::contact);
}

TEMPLATE_TEST_CASE("ProxyTracker: across a hole in one update it lets go, and is buried beyond",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    auto ground = plane<T>(13, 13);
    ground.remove(6, 6); // no patch over 5..7 × 5..7
    const auto grid = ground.grid();
    ProxyTracker tracker{grid};
    CHECK(tracker.update({T(4), T(6), T(1)}).status == ContactStatus::free);
    CHECK(tracker.update({T(4), T(6), T(-1)}).status == ContactStatus::contact);
    const vec3<T> beyond{T(8.5), T(6), T(-1)};
    const auto left = tracker.update(beyond);
    CHECK(left.status == ContactStatus::left_at_hole);
    CHECK((left.side == Side::below));
    CHECK_FALSE(tracker.state().touching());
    CHECK(tracker.update(beyond).status == ContactStatus::buried);
}

TEMPLATE_TEST_CASE("ProxyTracker: pinned at the rim it holds while the stylus is over the grid",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    // z = 2x: the foot of a stylus d below lies 2d·2/5 m west of it, soon beyond the western rim.
    const auto ground = tilted_plane<T>(9, 9, 2, 0);
    Witness<T> witness{ground};
    witness.update({T(2), T(4), T(6)});
    for (const T x : {T(1), T(0.5), T(0.25), T(0.125), T(0)}) {
        const auto c = witness.update({x, T(4), 2 * x - 3});
        CAPTURE(x);
        CHECK(c.status == ContactStatus::contact);
        CHECK(x_of(c.point) == 0);
        CHECK(y_of(c.point) == 4);
    }
    CHECK(witness.update({T(-0.0625), T(4), T(-3)}).status == ContactStatus::left_at_border);
    CHECK(witness.first_fault == "");
}

TEMPLATE_TEST_CASE(
    "ProxyTracker: a stylus that starts below the surface feels nothing until it has been outside",
    "[proxy_tracker]", float, double) {
    using T = TestType;
    const auto ground = hills<T>(25, 25, 2, 8);
    Witness<T> witness{ground};
    Random random{40};
    for (int n = 0; n < 200; ++n) {
        const auto c =
            witness.update({static_cast<T>(random.between(1, 23)), static_cast<T>(random.between(1, 23)),
                            static_cast<T>(random.between(-5, -1.25))});
        REQUIRE(c.status == ContactStatus::buried);
        REQUIRE(c.depth == 0);
    }
    REQUIRE(witness.update({T(12), T(12), T(1.5)}).status == ContactStatus::free);
    REQUIRE(witness.update({T(12), T(12), T(-1.5)}).status == ContactStatus::contact);
    // Also if it comes out and goes in again within one update, over a crest.
    ProxyTracker tracker{witness.grid};
    REQUIRE(tracker.update({T(1), T(4), T(-0.75)}).status ==
            ContactStatus::buried); // under the crest at x = 2
    CHECK(witness.first_fault == "");
}

TEMPLATE_TEST_CASE("ProxyTracker: out of the ground and in again within one update is a contact",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    // Ridges at x = 4 and 8; from inside the first, through the open between them, into the second.
    const auto ground = comb<T>(13, 9, 4, 4);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid};
    REQUIRE(tracker.update({T(4), T(4.5), T(1)}).status == ContactStatus::buried);
    const auto c = tracker.update({T(8), T(4.5), T(1)});
    CHECK(c.status == ContactStatus::contact);
    CHECK(c.normal.x < 0);
    CHECK(x_of(c.point) < 8);
}

TEMPLATE_TEST_CASE("ProxyTracker: off the grid it is off the surface, and comes back in from above or below",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    const auto ground = hills<T>(17, 17, 1, 8);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid};
    CHECK(tracker.update({T(-5), T(8), T(2)}).status == ContactStatus::off_surface);
    CHECK(tracker.update({T(-5), T(-900), T(-2)}).status == ContactStatus::off_surface);
    CHECK(tracker.update({T(8), T(8), T(-2)}).status == ContactStatus::buried); // in through the side, below
    CHECK(tracker.update({T(40), T(8), T(2)}).status == ContactStatus::off_surface);
    CHECK(tracker.update({T(8), T(8), T(2)}).status == ContactStatus::free); // in through the side, above
    CHECK(tracker.update({T(40), T(8), T(2)}).status == ContactStatus::off_surface);
    CHECK(tracker.update({T(8), T(8), T(-0.75)}).status == ContactStatus::contact); // in above and down
}

TEMPLATE_TEST_CASE("ProxyTracker: over a crossing from border to border it lets nothing pass",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    // From outside the grid, above, to outside the grid, below: the way leads through the ground.
    const auto ground = plane<T>(17, 17);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid};
    CHECK(tracker.update({T(-1), T(8), T(2)}).status == ContactStatus::off_surface);
    // It met the ground at x = 7.5 and slid off the far border in the same update.
    CHECK(tracker.update({T(17), T(8), T(-2)}).status == ContactStatus::left_at_border);
    CHECK(tracker.update({T(17), T(8), T(-2)}).status == ContactStatus::off_surface);
}

TEMPLATE_TEST_CASE("ProxyTracker: refuses positions that are no positions, its state unchanged bit by bit",
                   "[proxy_tracker][hard]", float, double) {
    using T = TestType;
    const T nan = hidden_nan<T>(), inf = hidden_infinity<T>();
    const T huge = std::is_same_v<T, float> ? T(1e38) : T(1e300);
    const auto ground = hills<T>(17, 17, 1, 8);
    const auto grid = ground.grid();
    const ForceEvaluator<T> force{};
    ProxyTracker tracker{grid};
    const std::array<vec3<T>, 4> path{vec3<T>{T(8), T(8), T(2)}, vec3<T>{T(8), T(8), T(-1)},
                                      vec3<T>{T(9), T(8), T(-1)}, vec3<T>{T(9), T(8), T(3)}};
    const auto refuse_all = [&] {
        for (const T bad : {nan, -nan, inf, -inf, huge, -huge}) {
            for (const vec3<T>& p :
                 {vec3<T>{bad, T(8), T(1)}, vec3<T>{T(8), bad, T(1)}, vec3<T>{bad, bad, bad}}) {
                const auto before = bits(tracker);
                const auto c = tracker.update(p);
                CHECK(c.status == ContactStatus::bad_input);
                CHECK_FALSE(c.touching());
                CHECK(force(c).newtons == vec3<T>{T(0)});
                CHECK((bits(tracker) == before));
            }
        }
        for (const T bad : {nan, inf, -inf, huge, -huge}) {
            const auto before = bits(tracker);
            CHECK(tracker.update({T(8), T(8), bad}).status == ContactStatus::bad_input);
            CHECK((bits(tracker) == before));
        }
    };
    refuse_all(); // before the first position
    ProxyTracker undisturbed{grid};
    for (const auto& p : path) {
        CHECK(same(tracker.update(p), undisturbed.update(p)));
        refuse_all(); // free and touching
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: survives heights of any size", "[proxy_tracker][hard]", float, double) {
    using T = TestType;
    // Very deep or very high is a position: nothing that is not a number comes of it, and it goes on afterwards.
    const T huge = std::is_same_v<T, float> ? T(1e38) : T(1e300);
    const auto ground = hills<T>(17, 17, 1, 8);
    const auto grid = ground.grid();
    const ForceEvaluator<T> force{.stiffness = T(500), .max_force = T(3)};
    for (const T z : {huge, -huge, std::sqrt(huge), -std::sqrt(huge), std::numeric_limits<T>::max(),
                      std::numeric_limits<T>::lowest()}) {
        for (const bool touching : {false, true}) {
            CAPTURE(z, touching);
            ProxyTracker tracker{grid};
            (void)tracker.update({T(8.5), T(8.25), T(2)});
            if (touching) REQUIRE(tracker.update({T(8.5), T(8.25), T(-1)}).status == ContactStatus::contact);
            const auto c = tracker.update({T(8.5), T(8.25), z});
            CHECK(is_finite(c.proxy));
            CHECK(is_finite(c.normal));
            CHECK(is_finite(force(c).newtons));
            if (c.status != ContactStatus::bad_input)
                CHECK(c.status == (z > 0 ? ContactStatus::free : ContactStatus::contact));
            for (int n = 0; n < 3; ++n) (void)tracker.update({T(8.5), T(8.25), T(-1)});
            CHECK(tracker.update({T(8.5), T(8.25), T(-1)}).status == ContactStatus::contact);
            CHECK(tracker.update({T(8.5), T(8.25), T(2)}).status == ContactStatus::free);
        }
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: ground raised over a free stylus is felt at once", "[proxy_tracker]", float,
                   double) {
    using T = TestType;
    auto ground = plane<T>(17, 17);
    Witness<T> witness{ground};
    const vec3<T> still{T(8.25), T(7.5), T(0.5)};
    for (const bool moving : {false, true}) {
        for (auto& h : ground.heights) h = 0;
        witness.reset();
        CHECK(witness.update(still).status == ContactStatus::free);
        CHECK(witness.update(still).status == ContactStatus::free);
        for (auto& h : ground.heights) h = 2;
        const auto c = witness.update(moving ? still + vec3<T>{T(0.125), T(0.25), T(0.125)} : still);
        CHECK(c.status == ContactStatus::contact);
        CHECK(is_length(c.depth, moving ? T(1.375) : T(1.5)));
        CHECK(is_direction(c.normal, {0, 0, 1}));
    }
    CHECK(witness.first_fault == "");
}

TEMPLATE_TEST_CASE("ProxyTracker: a sheet that sinks past a stylus below it takes it along",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid, {.surface = SurfaceKind::sheet}};
    const vec3<T> stylus{T(4.5), T(4.25), T(-1)};
    CHECK((tracker.update(stylus).side == Side::below));
    for (T& height : ground.heights) height = -5;
    const auto c = tracker.update(stylus);
    CHECK(c.status == ContactStatus::contact);
    CHECK((c.side == Side::below));
    CHECK(c.penetration == vec3<T>{T(0), T(0), T(-4)});
}

TEMPLATE_TEST_CASE("ProxyTracker: ground edited under the proxy lifts it, lowers it, lets it go",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    auto ground = plane<T>(17, 17);
    Witness<T> witness{ground};
    const vec3<T> still{T(8.25), T(7.5), T(-0.5)};
    const auto level = [&](T height) {
        for (auto& h : ground.heights) h = height;
    };
    CHECK(witness.update({T(8.25), T(7.5), T(1)}).status == ContactStatus::free);
    CHECK(is_length(witness.update(still).depth, T(0.5)));
    level(3);
    const auto lifted = witness.update(still);
    CHECK(lifted.status == ContactStatus::contact);
    CHECK(lifted.proxy == vec3<T>{T(8.25), T(7.5), T(3)});
    CHECK(is_length(lifted.depth, T(3.5)));
    level(T(-0.25));
    const auto lowered = witness.update(still);
    CHECK(lowered.status == ContactStatus::contact);
    CHECK(lowered.proxy == vec3<T>{T(8.25), T(7.5), T(-0.25)});
    CHECK(is_length(lowered.depth, T(0.25)));
    level(-2);
    CHECK(witness.update(still).status == ContactStatus::free); // the ground fell away from under it
    level(0);
    CHECK(witness.update(still).status == ContactStatus::contact); // and came back
    ground.remove(8, 8);
    CHECK(witness.update(still).status == ContactStatus::left_at_hole);
    CHECK(witness.update(still).status == ContactStatus::off_surface);
    ground.at(8, 8) = 0;
    CHECK(witness.update(still).status == ContactStatus::buried);
}

TEMPLATE_TEST_CASE("ProxyTracker: keeps its invariants while the ground is edited", "[proxy_tracker][law]",
                   float, double) {
    using T = TestType;
    // Ground that heaves around the hand. No promise is made about a stylus that the ground passed over while it was
    // not over the surface; the witness knows.
    auto ground = hills<T>(33, 33, 2, 8);
    Witness<T> witness{ground};
    Hand<T> hand{ground, 41};
    Random random{42};
    for (int n = 0; n < 20000; ++n) {
        witness.update(hand.next());
        for (int k = 0; k < 20; ++k) {
            ground.at(random.whole(0, 32), random.whole(0, 32)) +=
                static_cast<T>(random.between(-0.25, 0.25));
        }
    }
    CHECK(witness.first_fault == "");
    CHECK(witness.faults == 0);
    CHECK(witness.contacts > 4000);
}

TEMPLATE_TEST_CASE("ProxyTracker: a sheet is felt from above and from below, and released on each side",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    const auto ground = hills<T>(25, 25, 1, 12);
    Witness<T> witness{ground, {.surface = SurfaceKind::sheet}};
    for (const T side : {T(1), T(-1)}) {
        witness.reset();
        const auto away = witness.update({T(12), T(12), side * 2});
        CHECK(away.status == ContactStatus::free);
        CHECK(away.side == (side > 0 ? Side::above : Side::below));
        for (int k = 0; k < 40; ++k) {
            const auto c = witness.update({T(12) + T(k) / 16, T(12), side * T(-1)});
            CHECK(c.status == ContactStatus::contact);
            CHECK(c.side == (side > 0 ? Side::above : Side::below));
            CHECK(c.normal.z * side > 0);
            CHECK(c.penetration.z * side > 0);
        }
        const auto released = witness.update({T(12), T(12), side * 2});
        CHECK(released.status == ContactStatus::free);
        CHECK(released.side == (side > 0 ? Side::above : Side::below));
    }
    CHECK(witness.first_fault == "");
}

TEMPLATE_TEST_CASE("ProxyTracker: through a hole in a sheet it comes to the other side", "[proxy_tracker]",
                   float, double) {
    using T = TestType;
    auto ground = plane<T>(17, 17);
    ground.remove(8, 8);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid, {.surface = SurfaceKind::sheet}};
    CHECK(tracker.update({T(4), T(4), T(1)}).side == Side::above);
    CHECK(tracker.update({T(8), T(8), T(1)}).status == ContactStatus::off_surface);
    CHECK(tracker.update({T(8), T(8), T(-1)}).status == ContactStatus::off_surface);
    const auto below = tracker.update({T(4), T(4), T(-1)});
    CHECK(below.status == ContactStatus::free);
    CHECK(below.side == Side::below);
    const auto pushed = tracker.update({T(4), T(4), T(0.5)});
    CHECK(pushed.status == ContactStatus::contact);
    CHECK(pushed.side == Side::below);
    CHECK(pushed.penetration == vec3<T>{0, 0, T(-0.5)});
    CHECK(is_direction(pushed.normal, {0, 0, -1}));
    CHECK(tracker.update({T(4), T(4), T(-0.5)}).status == ContactStatus::free);
    // In one update through the hole, from above to below.
    tracker.reset();
    CHECK(tracker.update({T(4), T(8), T(2)}).side == Side::above);
    CHECK(tracker.update({T(12), T(8), T(-2)}).side == Side::below);
}

TEMPLATE_TEST_CASE(
    "ProxyTracker: a stylus that stands still for 100,000 updates leaves the proxy where it is",
    "[proxy_tracker][hard]", float, double) {
    using T = TestType;
    const auto ground = rough_in_steps<T>(17, 17, 2, 43);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid};
    (void)tracker.update({T(8.3), T(7.7), T(5)});
    const vec3<T> still{T(8.4), T(7.6), T(-0.3)};
    const auto first = tracker.update(still);
    REQUIRE(first.status == ContactStatus::contact);
    int moved = 0;
    for (int n = 0; n < 100000; ++n) moved += !same(tracker.update(still), first);
    CHECK(moved == 0);
}

TEMPLATE_TEST_CASE("ProxyTracker: a stylus at rest has its proxy at rest, anywhere on any terrain",
                   "[proxy_tracker][law][ieee]", float, double) {
    using T = TestType;
    for (const auto& scene : scenes<T>()) {
        const auto grid = scene.terrain.grid();
        ProxyTracker tracker{grid};
        Hand<T> hand{scene.terrain, 44};
        int drifting = 0;
        for (int n = 0; n < 3000; ++n) {
            const auto still = hand.next();
            const auto first = tracker.update(still);
            if (first.status != ContactStatus::contact) continue;
            for (int k = 0; k < 3; ++k) {
                const auto again = tracker.update(still);
                if (!same(again, first) && drifting++ == 0) {
                    INFO(scene.name << ", stylus " << digits(still));
                    CHECK(digits(again.proxy) == digits(first.proxy));
                    CHECK(digits(again.normal) == digits(first.normal));
                    CHECK(digits(again.penetration) == digits(first.penetration));
                    CHECK(to_string(again.status) == std::string{to_string(first.status)});
                    CHECK(again.point.cell.i == first.point.cell.i);
                    CHECK(again.point.cell.j == first.point.cell.j);
                    CHECK(digits(again.point.u) == digits(first.point.u));
                    CHECK(digits(again.point.v) == digits(first.point.v));
                }
            }
        }
        CHECK(drifting == 0);
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: on flat ground the force has no tangential part at all",
                   "[proxy_tracker][hard]", float, double) {
    using T = TestType;
    // As steady as the hand means: exactly zero along the ground, and along the normal the hand's depth to a rounding.
    for (const GridFrame& frame : {GridFrame{}, GridFrame{.origin = {-3, 7}, .spacing = {0.75, 2.5}},
                                   GridFrame{.origin = {500000.3, 4649776.7}, .spacing = {10, 10}}}) {
        const auto ground = plane<T>(65, 65, 3, frame);
        const auto grid = ground.grid();
        const ForceEvaluator<T> force{};
        ProxyTracker tracker{grid};
        Random random{45};
        glm::dvec2 at = (ground.low() + ground.high()) / 2.0;
        (void)tracker.update({static_cast<T>(at.x), static_cast<T>(at.y), T(4)});
        int unsteady = 0, off = 0;
        glm::dvec2 heading{0.3, 0.2};
        for (int n = 0; n < 100000; ++n) {
            heading += 0.05 * glm::dvec2{random.between(-1, 1), random.between(-1, 1)};
            for (int a = 0; a < 2; ++a) {
                heading[a] = std::clamp(heading[a], -0.5, 0.5);
                at[a] += heading[a] * frame.spacing[a];
                if (at[a] < ground.low()[a] + 1 || at[a] > ground.high()[a] - 1) heading[a] = -heading[a];
                at[a] = std::clamp(at[a], ground.low()[a] + 1, ground.high()[a] - 1);
            }
            const vec3<T> stylus{static_cast<T>(at.x), static_cast<T>(at.y),
                                 static_cast<T>(2 + 0.5 * random.unit())};
            const auto c = tracker.update(stylus);
            const auto f = force(c);
            unsteady += f.newtons.x != 0 || f.newtons.y != 0;
            off +=
                std::abs(c.depth - (T(3) - stylus.z)) > 8 * epsilon<T> || c.status != ContactStatus::contact;
        }
        CAPTURE(frame.origin.x, frame.spacing.x);
        CHECK(unsteady == 0);
        CHECK(off == 0);
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: swipes of hundreds of cells are felt where they first meet the ground",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    // Flat, with one ridge of slope 8; across most of the ground in one update. The perpendiculars of the ridge's faces
    // reach 57 cells beyond it.
    auto ground = plane<T>(513, 9);
    for (Index j = 0; j < 9; ++j) ground.at(300, j) = 8;
    Witness<T> witness{ground};
    for (const bool eastward : {true, false}) {
        const T from = eastward ? T(2.5) : T(509.5), to = eastward ? T(340.5) : T(259.5);
        witness.reset();
        CHECK(witness.update({from, T(3.25), T(2)}).status == ContactStatus::free);
        const auto c = witness.update({to, T(5.5), T(1)});
        CHECK(c.status == ContactStatus::contact);
        CHECK((eastward ? c.normal.x < 0 : c.normal.x > 0));
        CHECK(std::abs(x_of(c.point) - 300) <= 1);
    }
    CHECK(witness.first_fault == "");
}

TEMPLATE_TEST_CASE(
    "ProxyTracker: a sweep that runs out of work goes on in the next update and misses nothing",
    "[proxy_tracker]", float, double) {
    using T = TestType;
    auto ground = plane<T>(129, 9);
    for (Index j = 0; j < 9; ++j) ground.at(70, j) = 8;
    const auto grid = ground.grid();
    for (const int limit : {1, 4, 16, 48}) {
        CAPTURE(limit);
        ProxyTracker tracker{grid, {.max_patches = limit}};
        CHECK(tracker.update({T(2.5), T(3.25), T(2)}).status == ContactStatus::free);
        const vec3<T> to{T(120.5), T(5.5), T(1)};
        int limited = 0;
        auto c = tracker.update(to);
        for (; c.status == ContactStatus::sweep_limit && limited < 1000; c = tracker.update(to)) {
            ++limited;
            CHECK(c.depth == 0);
            CHECK(c.patches <= limit + 16);
        }
        CHECK(limited > 0);
        for (int n = 0; n < 1000 && c.status == ContactStatus::descent_limit; ++n) c = tracker.update(to);
        CHECK(c.status == ContactStatus::contact);
        CHECK(c.normal.x < 0);
        CHECK(std::abs(x_of(c.point) - 70) <= 1);
    }
    // The stylus may move on meanwhile: the search goes on from where it was to where the stylus is now.
    ProxyTracker tracker{grid, {.max_patches = 16}};
    CHECK(tracker.update({T(2.5), T(3.25), T(2)}).status == ContactStatus::free);
    CHECK(tracker.update({T(120.5), T(5.5), T(1)}).status == ContactStatus::sweep_limit);
    CHECK(tracker.update({T(121.5), T(5.5), T(12)}).status == ContactStatus::sweep_limit);
    // Or back to where the search has come.
    CHECK(tracker.state().phase == TrackerPhase::searching);
    const vec3<T> come{tracker.state().swept_to()};
    CHECK(tracker.update(come + vec3<T>{T(0), T(0), T(1)}).status == ContactStatus::free);
    CHECK_FALSE(tracker.state().phase == TrackerPhase::searching);
}

TEMPLATE_TEST_CASE(
    "ProxyTracker: a descent that runs out of work goes on in the next update and ends in the same place",
    "[proxy_tracker]", float, double) {
    using T = TestType;
    const auto ground = tilted_plane<T>(129, 9, 0.25, 0);
    const auto grid = ground.grid();
    const vec3<T> above{T(2.5), T(4.5), T(3)}, inside{T(2.5), T(4.5), T(0.25)}, far{T(120.5), T(5.25), T(25)};
    ProxyTracker unlimited{grid};
    (void)unlimited.update(above);
    (void)unlimited.update(inside);
    const auto goal = unlimited.update(far);
    REQUIRE(goal.status == ContactStatus::contact);
    for (const int limit : {1, 4, 8, 32}) {
        CAPTURE(limit);
        ProxyTracker tracker{grid, {.max_patches = limit}};
        auto c = tracker.update(above);
        for (int n = 0; n < 100 && c.status != ContactStatus::contact; ++n) c = tracker.update(inside);
        CHECK(c.status == ContactStatus::contact);
        T depth = std::numeric_limits<T>::max();
        int limited = 0;
        c = tracker.update(far);
        for (; c.status == ContactStatus::descent_limit && limited < 1000; c = tracker.update(far)) {
            ++limited;
            CHECK(c.touching());
            CHECK(c.depth <= depth);
            CHECK(c.patches <= limit + 16);
            depth = c.depth;
        }
        CHECK(limited > 0);
        CHECK(c.status == ContactStatus::contact);
        CHECK(std::abs(static_cast<double>(x_of(c.point) - x_of(goal.point))) <=
              512 * static_cast<double>(epsilon<T>));
        CHECK(std::abs(c.depth - goal.depth) <= 512 * epsilon<T>);
    }
}

namespace {

/// A gentle slope, 600 cells long, with a wall across it that rises five cells over one from column 9 to 10.
template <Real T>
Terrain<T> wall_on_a_slope() {
    return terrain<T>(601, 9,
                      [](Index i, Index) { return (i == 10 ? 5.0 : 0.0) - static_cast<double>(i) / 64; });
}

/// Deep below the slope: the wall holds the proxy in front of it until the stylus is five times as far beyond it as
/// below it; then the next minimum is right over the stylus, some 300 cells away.
inline constexpr double hidden = 60;

/// A tracker that was led there, one update before it is released; and the stylus of that update.
template <Real T, class Grid>
ProxyTracker<Grid> held_by_the_wall(const Grid& grid, const TrackerOptions& options, vec3<T>& stylus) {
    ProxyTracker<Grid> tracker{grid, options};
    stylus = {T(5.5), T(4.25), T(3)};
    (void)tracker.update(stylus);
    for (stylus.z = T(-1); stylus.z > T(-hidden); stylus.z -= T(1)) (void)tracker.update(stylus);
    for (;;) {
        auto next = tracker;
        const vec3<T> there = stylus + vec3<T>{T(0.5), T(0), T(0)};
        if (x_of(next.update(there).point) > 12 || there.x > T(590)) return tracker;
        tracker = next;
        stylus = there;
    }
}

} // namespace

TEMPLATE_TEST_CASE("ProxyTracker: a proxy that is released far from its next minimum glides there",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    const auto ground = wall_on_a_slope<T>();
    const auto grid = ground.grid();
    vec3<T> stylus{};
    const auto held = held_by_the_wall<T>(grid, brisk, stylus);
    REQUIRE(held.state().touching());
    REQUIRE(x_of(held.state().proxy) < 12);
    stylus.x += T(0.5);

    ProxyTracker at_once{grid};
    at_once.restore(held.state());
    const auto goal = at_once.update(stylus);
    REQUIRE(goal.status == ContactStatus::contact);
    REQUIRE(goal.patches > 200);

    SECTION("under the surface it is pressed all the way, by less and less") {
        auto tracker = held;
        auto c = tracker.update(stylus);
        int updates = 1;
        T depth = std::numeric_limits<T>::max();
        for (; c.status == ContactStatus::descent_limit && updates < 100; ++updates) {
            CHECK(c.patches >= brisk.max_contact_patches);
            CHECK(c.patches <= brisk.max_contact_patches + 1 + 4); // it moved half a cell, and then not
            CHECK(c.depth < depth);
            CHECK(c.depth > goal.depth);
            depth = c.depth;
            c = tracker.update(stylus);
        }
        CHECK(updates > 4);
        CHECK(c.status == ContactStatus::contact);
        CHECK(std::abs(static_cast<double>(x_of(c.point) - x_of(goal.point))) < 1e-3);
        CHECK(std::abs(c.depth - goal.depth) <= 512 * epsilon<T> * goal.depth);
    }
    SECTION("over the surface nothing is felt on the way, and at its end it is free") {
        auto tracker = held;
        stylus.z = T(1);
        auto c = tracker.update(stylus);
        int updates = 1;
        for (; c.status == ContactStatus::descent_limit && updates < 100; ++updates) {
            CHECK(c.depth == 0);
            c = tracker.update(stylus);
        }
        CHECK(updates > 4);
        for (; c.status == ContactStatus::sweep_limit && updates < 100; ++updates) c = tracker.update(stylus);
        CHECK(c.status == ContactStatus::free);
    }
    SECTION("a stylus that moves lets it slide two patches farther for each cell, whichever way") {
        for (const glm::dvec3& way : {glm::dvec3{20, 0, 0}, {-20, 0, 0}, {0, 20, 0}, {0, -20, 0}}) {
            auto state = held.state();
            state.stylus = glm::dvec3{stylus} - way;
            auto tracker = held;
            tracker.restore(state);
            const auto c = tracker.update(stylus);
            CHECK(c.status == ContactStatus::descent_limit);
            CHECK(c.patches >= brisk.max_contact_patches + 40);
            CHECK(c.patches <= brisk.max_contact_patches + 40 + 4);
        }
    }
    SECTION("that is no work without end") {
        ProxyTracker tracker{grid, {.max_patches = 32, .max_contact_patches = brisk.max_contact_patches}};
        tracker.restore(held.state());
        stylus.x += T(20);
        CHECK(tracker.update(stylus).patches <= 32 + 4);
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: a sheet felt from below is pressed on the way as a solid is from above",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    const auto ground = wall_on_a_slope<T>();
    auto ceiling = ground;
    for (T& height : ceiling.heights) height = -height;
    const auto grid = ground.grid(), below = ceiling.grid();
    vec3<T> stylus{};
    auto over = held_by_the_wall<T>(
        grid, {.surface = SurfaceKind::sheet, .max_contact_patches = brisk.max_contact_patches}, stylus);
    stylus.x += T(0.5);

    auto state = over.state();
    state.side = Side::below;
    state.stylus.z = -state.stylus.z;
    ProxyTracker under{below,
                       {.surface = SurfaceKind::sheet, .max_contact_patches = brisk.max_contact_patches}};
    under.restore(state);
    int limited = 0;
    for (int n = 0; n < 30; ++n) {
        const auto a = over.update(stylus), b = under.update({stylus.x, stylus.y, -stylus.z});
        CHECK(a.status == b.status);
        CHECK(a.depth == b.depth);
        CHECK(a.depth > 0);
        CHECK(a.penetration.z == -b.penetration.z);
        limited += a.status == ContactStatus::descent_limit;
    }
    CHECK(limited > 4);
}

TEMPLATE_TEST_CASE("ProxyTracker: a ridge holds a stylus in the open while its proxy glides along it",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    // The knife edge again, pressed through by a stylus that is above the ground behind it.
    const auto ground = terrain<T>(25, 25, [](Index i, Index) { return i == 12 ? 10.0 : 0.0; });
    const auto grid = ground.grid();
    const vec3<T> stylus{T(14), T(20.3), T(3)};
    typename ProxyTracker<typename Terrain<T>::Grid>::State state;
    state.phase = TrackerPhase::contact;
    state.side = Side::above;
    state.stylus = vec3<PlaceScalar<T>>{stylus};
    state.proxy = {{11, 3}, T(0.5), T(0.5)};
    ProxyTracker tracker{grid, {.max_contact_patches = 4}};
    tracker.restore(state);
    auto c = tracker.update(stylus);
    int limited = 0;
    for (; c.status == ContactStatus::descent_limit && limited < 100; ++limited) {
        CHECK(c.depth > T(2.5));
        CHECK(c.normal.x < 0);
        c = tracker.update(stylus);
    }
    CHECK(limited > 2);
    CHECK(c.status == ContactStatus::contact);
    CHECK(c.depth > T(2.5));
}

TEMPLATE_TEST_CASE(
    "ProxyTracker: the way to a stylus that is far outside is searched in more than one update",
    "[proxy_tracker]", float, double) {
    using T = TestType;
    // Released by a cliff that is far from the stylus; flat ground between them.
    const auto ground = terrain<T>(201, 9, [](Index i, Index) { return i <= 5 ? 200.0 : 0.0; });
    const auto grid = ground.grid();
    const vec3<T> stylus{T(105.5), T(4.25), T(100)};
    typename ProxyTracker<typename Terrain<T>::Grid>::State state;
    state.phase = TrackerPhase::contact;
    state.side = Side::above;
    state.stylus = {105.5, 4.25, 100};
    state.proxy = {{5, 4}, T(0.5), T(0.25)};
    ProxyTracker tracker{grid, brisk};
    tracker.restore(state);
    auto c = tracker.update(stylus);
    CHECK(c.status == ContactStatus::sweep_limit);
    CHECK(c.patches <= brisk.max_contact_patches + 4);
    c = tracker.update(stylus);
    CHECK(c.status == ContactStatus::free);
    CHECK(c.patches > 70);
}

TEMPLATE_TEST_CASE(
    "ProxyTracker: behind a search that was cut short the proxy slides no farther than at rest",
    "[proxy_tracker]", float, double) {
    using T = TestType;
    const auto ground = tilted_plane<T>(601, 9, 1, 0);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid, {.max_patches = 150, .max_contact_patches = brisk.max_contact_patches}};
    REQUIRE(tracker.update({T(2.5), T(4.25), T(350)}).status == ContactStatus::free);
    const vec3<T> inside{T(350.5), T(4.25), T(200)}; // in through column 245, the minimum is on 275
    auto c = tracker.update(inside);
    REQUIRE(c.status == ContactStatus::sweep_limit);
    while (c.status == ContactStatus::sweep_limit) c = tracker.update(inside);
    const auto swept = tracker.state().proxy;
    CHECK(c.status == ContactStatus::descent_limit);
    CHECK(x_of(swept) >= 245);
    CHECK(x_of(swept) < 245 + brisk.max_contact_patches);
    for (int n = 0; n < 10 && c.status == ContactStatus::descent_limit; ++n) {
        CHECK(c.depth > 0);
        c = tracker.update(inside);
    }
    CHECK(c.status == ContactStatus::contact);
    CHECK(std::abs(static_cast<double>(x_of(c.point)) - 275.25) < 1e-3);

    // Swept in one update the whole way counts.
    ProxyTracker whole{grid, brisk};
    REQUIRE(whole.update({T(2.5), T(4.25), T(350)}).status == ContactStatus::free);
    CHECK(whole.update(inside).status == ContactStatus::contact);
}

TEMPLATE_TEST_CASE("ProxyTracker: lifted straight off it is free at once, however little work is allowed",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    const auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    for (const TrackerOptions& options :
         {TrackerOptions{.max_patches = 1}, TrackerOptions{.max_contact_patches = 1}}) {
        ProxyTracker tracker{grid, options};
        CHECK(tracker.update({T(4.5), T(4.25), T(1)}).status == ContactStatus::free);
        CHECK(tracker.update({T(4.5), T(4.25), T(-0.5)}).status == ContactStatus::contact);
        CHECK(tracker.update({T(4.5), T(4.25), T(0.5)}).status == ContactStatus::free);
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: a sweep and the slide behind it share the work allowed", "[proxy_tracker]",
                   float, double) {
    using T = TestType;
    const auto ground = tilted_plane<T>(601, 9, 1, 0);
    const auto grid = ground.grid();
    // In through column 245, the minimum is on 275; the sweep takes most of the work, all of it, or two updates.
    for (int limit = 200; limit < 320; limit += 10) {
        CAPTURE(limit);
        ProxyTracker tracker{grid, {.max_patches = limit}};
        auto c = tracker.update({T(2.5), T(4.25), T(350)});
        for (int n = 0; n < 10 && c.status != ContactStatus::contact; ++n) {
            c = tracker.update({T(350.5), T(4.25), T(200)});
            CHECK(c.patches <= limit + 4);
        }
        CHECK(c.status == ContactStatus::contact);
    }
}

namespace {

/// A terrain that stores no sample: z = 2 sin(i/4) cos(j/4) at grid point (i, j), without end.
template <Real T>
struct Waves {
    using Scalar = T;
    [[nodiscard]] Lattice lattice() const noexcept { return {{0, 0}, {1, 1}}; }
    [[nodiscard]] CellRange cells() const noexcept { return CellRange::endless(); }
    [[nodiscard]] std::optional<BilinearPatch<T>> patch(Cell c) const noexcept {
        return BilinearPatch<T>{
            at(c.i, c.j), at(c.i + 1, c.j), at(c.i, c.j + 1), at(c.i + 1, c.j + 1), {T(1), T(1)}};
    }
    [[nodiscard]] static T at(Index i, Index j) noexcept {
        return static_cast<T>(2 * std::sin(static_cast<double>(i) / 4) *
                              std::cos(static_cast<double>(j) / 4));
    }
};

} // namespace

TEMPLATE_TEST_CASE("ProxyTracker: follows a terrain that is a formula, to both sides of its origin",
                   "[proxy_tracker]", float, double) {
    using T = TestType;
    const Waves<T> waves;
    ProxyTracker tracker{waves};
    Random random{46};
    double x = -1000, y = 500;
    CHECK(tracker.update({static_cast<T>(x), static_cast<T>(y), T(4)}).status == ContactStatus::free);
    for (int n = 0; n < 5000; ++n) {
        x += 0.5 * random.unit();
        y -= 0.5 * random.unit();
        const auto c = tracker.update({static_cast<T>(x), static_cast<T>(y), T(-3)});
        REQUIRE(c.status == ContactStatus::contact);
        const auto i = static_cast<Index>(std::floor(c.proxy.x)),
                   j = static_cast<Index>(std::floor(c.proxy.y));
        const WidePatch p{static_cast<Wide>(waves.at(i, j)), static_cast<Wide>(waves.at(i + 1, j)),
                          static_cast<Wide>(waves.at(i, j + 1)), static_cast<Wide>(waves.at(i + 1, j + 1))};
        const Wide z = p.height(static_cast<Wide>(c.proxy.x) - static_cast<Wide>(i),
                                static_cast<Wide>(c.proxy.y) - static_cast<Wide>(j));
        // Coordinates up to 1500 m rounded once, over slopes of half a metre per cell.
        REQUIRE(std::abs(z - static_cast<Wide>(c.proxy.z)) <= 2048 * static_cast<Wide>(epsilon<T>));
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: a saved state goes on as if nothing had been", "[proxy_tracker]", float,
                   double) {
    using T = TestType;
    using Grid = typename Terrain<T>::Grid;
    const auto ground = rough_in_steps<T>(25, 25, 2, 47);
    const auto grid = ground.grid();
    ProxyTracker<Grid> one{grid}, other{grid};
    Hand<T> hand{ground, 48};
    for (int n = 0; n < 2000; ++n) {
        const auto stylus = hand.next();
        typename ProxyTracker<Grid>::State copy;
        std::memcpy(static_cast<void*>(&copy), &one.state(), sizeof copy); // like plain bytes
        other.restore(copy);
        REQUIRE(same(one.update(stylus), other.update(stylus)));
    }
    one.reset();
    ProxyTracker<Grid> fresh{grid};
    for (int n = 0; n < 100; ++n) {
        const auto stylus = hand.next();
        REQUIRE(same(one.update(stylus), fresh.update(stylus)));
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: over a grid without patches it is off the surface", "[proxy_tracker]",
                   float, double) {
    using T = TestType;
    const auto small = plane<T>(1, 9);
    const auto bad = plane<T>(9, 9, 0, {.spacing = {0, 1}});
    const auto nowhere = small.grid(), flattened = bad.grid();
    ProxyTracker over_nothing{nowhere}, over_bad{flattened};
    for (const T z : {T(2), T(-2), T(2)}) {
        CHECK(over_nothing.update({T(0.5), T(4), z}).status == ContactStatus::off_surface);
        CHECK_FALSE(over_bad.update({T(0.5), T(4), z}).touching());
    }
}

TEMPLATE_TEST_CASE("ProxyTracker: far from the origin it is as exact as its scalar lets a position be",
                   "[proxy_tracker][hard]", float, double) {
    using T = TestType;
    // UTM: easting 500 km, northing 4650 km. In double nothing is lost; in float a position is a multiple of half a
    // metre there, but the surface at that position is exact.
    const auto ground = hills<T>(65, 65, 8, 16, {.origin = {500000, 4649776}, .spacing = {10, 10}});
    check_hand("hills at UTM", ground, {}, 49, 20000);
}

TEST_CASE("ProxyTracker: sweeps to the float position that it was given, not to what that was rounded from",
          "[proxy_tracker][hard][regression]") {
    const auto ground = hills<float>(9, 9, 1, 4);
    const auto grid = ground.grid();
    for (int k = 1; k < 100; ++k) {
        const glm::dvec3 at{0.01 * k, 0.02 * k, 20 + 0.001 * k};
        ProxyTracker tracker{grid};
        (void)tracker.update(vec3<float>{at}); // GCC 12 would see both conversions, were update inlined
        const volatile float x = static_cast<float>(at.x), y = static_cast<float>(at.y),
                             z = static_cast<float>(at.z);
        const glm::dvec3 given{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
        CHECK(glm::dvec3{tracker.state().swept_to()} == given);
    }
}

TEST_CASE("TrackerState: is a small value that can be copied like plain bytes", "[proxy_tracker]") {
    static_assert(std::is_trivially_copyable_v<TrackerState<float>>);
    static_assert(std::is_trivially_copyable_v<TrackerState<double>>);
    static_assert(std::is_trivially_copyable_v<Contact<float>>);
    static_assert(std::is_trivially_copyable_v<ProxyTracker<Terrain<double>::Grid>>);
    CHECK(sizeof(TrackerState<double>) <= 192);
}
