#include "catch.hpp"
#include "support/ball_strokes.hpp"
#include "support/hard_patches.hpp"
#include "support/scanned_minima.hpp"

#include <glm/geometric.hpp>

using namespace hfh;
using namespace hfh::test;

// The judge of a ball is right itself: where there is a closed form, and where it is told what is wrong.

namespace {

using Made = Terrain<double>;

/// Where the ball of the slow tracker is held, from above.
BallContact<double> slow_contact(const Made& ground, double r, const glm::dvec3& above,
                                 const glm::dvec3& stylus) {
    SlowBall<double> ball{ground, static_cast<Wide>(r)};
    (void)ball.update(above);
    return ball.update(stylus);
}

/// A tracker that says what it was told to say.
struct Told {
    std::vector<BallContact<double>> answers;
    std::size_t next = 0;
    BallContact<double> update(const vec3<double>&) { return answers[next++]; }
};

BallContact<double> free_at(const glm::dvec3& stylus) {
    BallContact<double> c;
    c.proxy = stylus;
    return c;
}

/// What the judge says of a contact that begins from a ball at `above`.
std::string fault_of(const Made& ground, double r, const glm::dvec3& above, const glm::dvec3& stylus,
                     const BallContact<double>& found, bool flow = false) {
    Told told{{free_at(above), found}};
    FollowedBall<double, Told> ball{ground, {"made", r, SurfaceKind::solid, {}}, told};
    (void)ball.update(above, {});
    const auto answer = ball.update(stylus, {.flow = flow, .sweep = true});
    return answer.other_minimum ? "other minimum" : answer.verdict.fault;
}

/// The contact with its centre moved, and all that follows from it: the touches stay.
BallContact<double> moved(BallContact<double> c, const glm::dvec3& stylus, const glm::dvec3& centre) {
    c.proxy = centre;
    c.penetration = centre - stylus;
    c.depth = glm::length(c.penetration);
    c.normal = c.penetration / c.depth;
    return c;
}

bool begins(const std::string& text, const std::string& with) { return text.rfind(with, 0) == 0; }

} // namespace

TEST_CASE("ball judge: the local closest points of a patch are those of a dense sampling", "[ball]") {
    Random random{301};
    int several = 0;
    for (int n = 0; n < 400; ++n) {
        const auto between = [&](double low, double high) {
            return static_cast<Wide>(random.between(low, high));
        };
        const WidePatch p{between(-3, 3),   between(-3, 3), between(-3, 3), between(-3, 3), 1,
                          between(0.5, 1.5)};
        const Point q{between(-0.5, 1.5), between(-0.5, 1.5), between(-4, 4)};
        std::vector<Point> found;
        each_local_minimum(p, q, [&](Wide x, Wide y, Wide z, Wide distance) {
            CHECK(std::abs(length({x, y, z}) - distance) < 1e-17L);
            const Wide u = (q.x + x) / p.dx, v = (q.y + y) / p.dy;
            CHECK(length(p.position(u, v) - q - Point{x, y, z}) < 1e-17L);
            found.push_back({x, y, z});
        });
        Wide nearest = 1e9L;
        for (const Point& x : found) nearest = std::min(nearest, length(x));
        CHECK(nearest <= search_closest_point(p, q, 24).distance + 1e-15L);
        const auto scanned = scanned_minima(p, q);
        for (const Foot& foot : scanned) {
            if (fall_into(p, foot.u, foot.v, q, {1, 1}) > 1e-6L) continue; // where the walk gave up
            const Point at = p.position(foot.u, foot.v) - q;
            bool known = false;
            for (const Point& x : found) known = known || length(x - at) < 1e-4L;
            CHECK(known);
        }
        several += found.size() > 1;
    }
    CHECK(several > 50);
}

TEST_CASE("ball judge: half-spaces, their nearest point and what holds it", "[ball]") {
    const Wide s = std::sqrt(Wide(0.5));
    const std::vector<HalfSpace> valley{{{-s, 0, s}, 1}, {{s, 0, s}, 1}, {{0, 0, 1}, -5}};
    const auto found = nearest_in(valley, {0.1L, 7, -3});
    REQUIRE(found);
    CHECK(length(found->at - Point{0, 7, 1 / s}) < 1e-17L);
    CHECK(found->count == 2);
    CHECK_FALSE(nearest_in({{{0, 0, 1}, 1}, {{0, 0, -1}, 1}}, {}));
    CHECK(nearest_in({}, {1, 2, 3})->count == 0);
}

TEST_CASE("ball judge: distances on a plane, over a vertex and over an edge", "[ball]") {
    const auto slope = tilted_plane<double>(24, 20, 0.75, 0);
    const BallSurface<double> tilted{slope};
    const Point over{10 - 0.6L * 2, 10, 7.5L + 0.8L * 2};
    CHECK(std::abs(tilted.distance(over, 3) - 2) < 1e-17L);
    CHECK(tilted.feet(over, 2.001L).size() == 1);
    CHECK(length(tilted.feet(over, 2.1L)[0].normal() - Point{-0.6L, 0, 0.8L}) < 1e-17L);

    const auto top = peak<double>(24, 20, 9);
    const BallSurface<double> vertex{top};
    const auto foot = vertex.nearest({12.1L, 10, 9.5L}, 1);
    REQUIRE(foot);
    CHECK(length(foot->offset - Point{-0.1L, 0, -0.5L}) < 1e-17L);

    const auto crest = ridge<double>(24, 20, 3);
    const BallSurface<double> edge{crest};
    const auto across = edge.nearest({12.25L, 7.3L, 1}, 2);
    REQUIRE(across);
    CHECK(length(across->offset - Point{-0.25L, 0, -1}) < 1e-17L);
}

TEST_CASE("ball judge: a ball in a valley and on a plane, by flow", "[ball]") {
    const auto ground = valley<double>(24, 20, 1);
    const glm::dvec3 above{12.4, 10, 6}, stylus{12.1, 10.2, -1};
    const auto held = slow_contact(ground, 1, above, stylus);
    CHECK(glm::length(held.proxy - glm::dvec3{12, 10.2, std::sqrt(2.0)}) < 1e-9);
    CHECK(held.count == 2);
    CHECK(fault_of(ground, 1, above, stylus, held, true) == "");

    const auto flat = plane<double>(24, 20, 3);
    const auto rests = slow_contact(flat, 0.5, {4, 5, 8}, {4.5, 5, 2});
    CHECK(glm::length(rests.proxy - glm::dvec3{4.5, 5, 3.5}) < 1e-12);
    CHECK(fault_of(flat, 0.5, {4, 5, 8}, {4.5, 5, 2}, rests, true) == "");
}

TEST_CASE("ball judge: wrong contacts are found out", "[ball]") {
    const auto ground = valley<double>(24, 20, 1);
    const glm::dvec3 above{12.4, 10, 6}, stylus{12.1, 10.2, -1};
    const auto right = slow_contact(ground, 1, above, stylus);
    const auto judged = [&](const BallContact<double>& found) {
        return fault_of(ground, 1, above, stylus, found, true);
    };
    CHECK(judged(right) == "");
    CHECK(begins(judged(moved(right, stylus, right.proxy - glm::dvec3{0, 0, 1e-6})), "penetration"));
    // The touches stay as they are: one is turned, the other one too far away.
    const auto aside = moved(right, stylus, right.proxy + glm::dvec3{1e-5, 0, 1e-5});
    CHECK(begins(judged(aside), "normal of a touch"));
    CHECK_FALSE(judged(moved(right, stylus, right.proxy + glm::dvec3{0, 0.1, 0})).empty());
    CHECK_FALSE(judged(moved(right, stylus, {12.1, 10.2, -1.5})).empty());

    auto wrong = right;
    wrong.touches[1].point.cell.i += 3;
    CHECK(begins(judged(wrong), "a touch that is not"));
    wrong = right;
    wrong.touches[0].share *= 1.01;
    CHECK(begins(judged(wrong), "shares do not make up"));
    wrong = right;
    wrong.touches[1].share = -wrong.touches[1].share;
    CHECK(begins(judged(wrong), "a share below zero"));
    wrong = right;
    wrong.count = 1;
    CHECK(begins(judged(wrong), "shares do not make up"));
    wrong = right;
    std::swap(wrong.touches[0], wrong.touches[1]);
    CHECK_FALSE(judged(wrong).empty());
    wrong = right;
    wrong.normal = {0, 0, 1};
    CHECK(begins(judged(wrong), "normal is not"));
    wrong = right;
    wrong.depth *= 2;
    CHECK(begins(judged(wrong), "depth"));
    CHECK(begins(judged(free_at(stylus)), "free below the ground"));
    wrong = free_at(stylus);
    wrong.status = ContactStatus::off_surface;
    CHECK(begins(judged(wrong), "not felt"));
    CHECK(begins(fault_of(ground, 1, above, {12, 10, 1}, free_at({12, 10, 1})), "free in the ground"));
}

TEST_CASE("ball judge: a crest is no minimum, and one side of a ridge is not the other", "[ball]") {
    const auto ground = ridge<double>(24, 20, 1);
    // Straight over the crest it is balanced: one touch, no residual, and yet every way down is nearer.
    const glm::dvec3 above{12, 10.5, 4}, stylus{12, 10.5, -3};
    BallContact<double> crest;
    crest.status = ContactStatus::contact;
    crest.side = Side::above;
    crest = moved(crest, stylus, {12, 10.5, 1});
    crest.point = {{12, 10}, 0, 0.5};
    crest.touches[0] = {crest.point, {0, 0, 1}, crest.depth};
    crest.count = 1;
    CHECK(begins(fault_of(ground, 1, above, stylus, crest), "nearer nearby"));

    // A stylus to the right of it, and the minimum on the left.
    const glm::dvec3 from{12.5, 10.5, 4}, to{12.5, 10.5, -2};
    const auto right = slow_contact(ground, 1, from, to);
    CHECK(right.proxy.x > 12);
    CHECK(fault_of(ground, 1, from, to, right, true) == "");
    const auto left = slow_contact(ground, 1, {9, 10.5, 4}, {11.9, 10.5, -3});
    CHECK(left.proxy.x < 12);
    BallContact<double> wrong = left;
    // The offset plane over x < 12: z = x − 12 + √2.
    const double away = (to.z - (to.x - 12 + std::sqrt(2.0))) / 2;
    wrong = moved(wrong, to, to + glm::dvec3{away, 0, -away});
    wrong.touches[0].share = wrong.depth;
    const glm::dvec3 foot = wrong.proxy + glm::dvec3{1, 0, -1} / std::sqrt(2.0);
    wrong.point = {{static_cast<Index>(foot.x), 10}, foot.x - std::floor(foot.x), 0.5};
    wrong.touches[0].point = wrong.point;
    CHECK(begins(fault_of(ground, 1, from, to, wrong, true), "other minimum"));
    CHECK(begins(fault_of(ground, 1, right.proxy + glm::dvec3{0, 0, 1e-3}, to, wrong), "farther"));
}

TEST_CASE("ball judge: first touches in closed form", "[ball]") {
    const auto flat = plane<double>(24, 20, 0);
    const glm::dvec3 from{5, 5, 4}, to{9, 8, -4};
    CHECK(judge_first_touch(flat, from, to, 1, 3.0 / 8) == SweepVerdict::right);
    CHECK(judge_first_touch(flat, from, to, 1, 3.0 / 8 + 1e-9) == SweepVerdict::nearer_before);
    CHECK(judge_first_touch(flat, from, to, 1, 3.0 / 8 - 1e-8) == SweepVerdict::nothing_there);
    CHECK(judge_first_touch(flat, from, to, 1, {}) == SweepVerdict::nearer_before);
    CHECK(judge_first_touch(flat, to, from, 1, {}) != SweepVerdict::right);
    CHECK(judge_first_touch(flat, from, {9, 8, 1}, 1, {}) == SweepVerdict::right);
    CHECK(judge_first_touch(flat, {5, 5, 0.5}, to, 1, 0.0) == SweepVerdict::starts_in_the_surface);

    // Over a crest at x = 12: a graze, and a touch of its edge.
    const auto crest = ridge<double>(24, 20, 3);
    CHECK(judge_first_touch(crest, {2, 5, 1}, {22, 6, 1}, 1, {}) == SweepVerdict::right);
    CHECK(judge_first_touch(crest, {2, 5, 1 - 1e-8}, {22, 6, 1 - 1e-8}, 1, {}) ==
          SweepVerdict::nearer_before);
    // The circle around the crest is met at x = 12 − √(1 − 0.36), as the flanks are steep.
    CHECK(judge_first_touch(crest, {2, 5, 0.6}, {22, 5, 0.6}, 1, (12 - 0.8 - 2) / 20) == SweepVerdict::right);
    // The tip of a spike, through which a stride of any length passes in vain.
    const auto spike = peak<double>(24, 20, 9);
    CHECK(judge_first_touch(spike, {2, 10, 9.5}, {22, 10, 9.5}, 0.5, 0.5) == SweepVerdict::right);
    CHECK(judge_first_touch(spike, {2, 10, 9}, {22, 10, 9}, 0.5, {}) == SweepVerdict::nearer_before);
}

TEST_CASE("ball judge: balls that go by the gradient flow pass", "[ball]") {
    BallTally tally;
    const auto slow = [](const Made& ground, const auto&, double r, SurfaceKind kind) {
        return SlowBall<double>{ground, static_cast<Wide>(r), kind};
    };
    const auto named = [&](const char* name) { return *named_terrain<double>(name); };
    for (const char* name : {"valley", "steep hills", "rough"})
        follow_strokes<double>(name, named(name), 60, 1000, 302, slow, tally);
    for (const auto& example : tally.examples) FAIL_CHECK(example);
    CHECK(tally.contacts > 90);
}
