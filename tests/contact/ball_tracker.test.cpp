#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/ball_strokes.hpp"
#include "support/ball_sweeps.hpp"
#include "support/counting_field.hpp"

#include <hfh/contact/ball_tracker.hpp>

#include <glm/geometric.hpp>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>

using namespace hfh;
using namespace hfh::test;

namespace {

template <Real T>
using Tracker = BallTracker<typename Terrain<T>::Grid>;

constexpr auto make_tracker = [](const auto&, const auto& grid, auto radius, SurfaceKind kind) {
    return BallTracker<std::remove_cvref_t<decltype(grid)>>{grid, radius, {.surface = kind}};
};

/// A ball on a terrain of its own, each update judged: also by the gradient flow, and whether there was something on the way.
class Ball {
public:
    Ball(Terrain<double> made, double radius, const TrackerOptions& options = {})
        : terrain{std::move(made)}, grid{terrain.grid()}, tracker{grid, radius, options},
          judged_{terrain, {"made", radius, options.surface, {}}, tracker} {}
    Ball(const Ball&) = delete;
    Ball& operator=(const Ball&) = delete;

    BallContact<double> update(const glm::dvec3& stylus, bool flow = true) {
        const auto answer = judged_.update(stylus, {.flow = flow, .sweep = flow});
        CHECK(answer.replay == "");
        return answer.found;
    }
    /// Once the ground or the radius has changed.
    void changed() { judged_.forget(tracker.radius()); }

    Terrain<double> terrain;
    Terrain<double>::Grid grid;
    Tracker<double> tracker;

private:
    FollowedBall<double, Tracker<double>> judged_;
};

[[nodiscard]] bool near(const glm::dvec3& a, const glm::dvec3& b, double within = 1e-8) {
    return glm::length(a - b) < within;
}

/// To the bit.
template <class A, class B>
[[nodiscard]] bool same(const A& a, const B& b) {
    return a.status == b.status && a.side == b.side && a.proxy == b.proxy && a.normal == b.normal &&
           a.penetration == b.penetration && a.depth == b.depth && a.point.cell == b.point.cell &&
           a.point.u == b.point.u && a.point.v == b.point.v;
}

/// z = `slope` times the distance to the nearest of three planes through the middle sample, 120° apart: a pit.
[[nodiscard]] Terrain<double> pit_of_three_planes(double slope) {
    return terrain<double>(41, 41, [=](Index i, Index j) {
        const double x = static_cast<double>(i - 20), y = static_cast<double>(j - 20), s = std::sqrt(3.0) / 2;
        return slope * std::max({y, s * x - y / 2, -s * x - y / 2});
    });
}

/// Level, without the samples where `gone` says so.
template <class Gone>
[[nodiscard]] Terrain<double> with_holes(Gone&& gone) {
    auto made = plane<double>(24, 20, 0);
    for (Index j = 0; j < 20; ++j) {
        for (Index i = 0; i < 24; ++i) {
            if (gone(i, j)) made.remove(i, j);
        }
    }
    return made;
}

} // namespace

TEST_CASE("ball tracker: level ground, in closed form and at rest to the bit", "[ball]") {
    Ball ball{plane<double>(24, 20, 3, {.origin = {500000, 4649776}, .spacing = {10, 10}}), 12};
    CHECK(ball.update({500100.3, 4649850.7, 40}).status == ContactStatus::free);
    const glm::dvec3 stylus{500103.1, 4649849.2, 1};
    const auto found = ball.update(stylus);
    REQUIRE(found.status == ContactStatus::contact);
    CHECK(found.penetration.x == 0);
    CHECK(found.penetration.y == 0);
    CHECK(found.penetration.z == Approx(14).epsilon(1e-14));
    CHECK(found.count == 1);
    CHECK(found.touches[0].share == Approx(14).epsilon(1e-12));
    CHECK(near(ball.tracker.centre(), {500103.1, 4649849.2, 15}));
    const auto rests = ball.update(stylus);
    CHECK(near(rests.proxy, found.proxy, 1e-9));
    for (int n = 0; n < 3; ++n) CHECK(same(ball.update(stylus), rests));
    CHECK(ball.update({500103.1, 4649849.2, 15.5}).status == ContactStatus::free);
}

TEST_CASE("ball tracker: a V valley holds it by two touches", "[ball]") {
    Ball ball{valley<double>(24, 20, 1), 1};
    (void)ball.update({12.4, 10, 6});
    for (const double x : {12.4, 12.0, 11.9, 12.2}) {
        const auto found = ball.update({x, 10.2, -1});
        REQUIRE(found.status == ContactStatus::contact);
        CHECK(near(found.proxy, {12, 10.2, std::sqrt(2.0)}));
        REQUIRE(found.count == 2);
        // share₁ + share₂ = √2·depth in z, share₁ − share₂ = √2·|x − 12|.
        const double down = std::sqrt(2.0) + 1, aside = std::abs(x - 12);
        CHECK(found.touches[0].share == Approx((down + aside) / std::sqrt(2.0)).epsilon(1e-7));
        CHECK(found.touches[1].share == Approx((down - aside) / std::sqrt(2.0)).epsilon(1e-7));
    }
    // Along the valley, and out of it.
    CHECK(near(ball.update({12.2, 14, -1}).proxy, {12, 14, std::sqrt(2.0)}));
    CHECK(ball.update({18, 14, 5}).count == 1);
    CHECK(ball.update({18, 14, 9}).status == ContactStatus::free);
}

TEST_CASE("ball tracker: a pit of three planes holds it by three touches", "[ball]") {
    const double slope = 1.5, r = 3;
    Ball ball{pit_of_three_planes(slope), r};
    (void)ball.update({20.3, 20.1, 12});
    const double height = r * std::sqrt(1 + slope * slope);
    auto found = ball.update({20, 20, 0});
    CHECK(near(found.proxy, {20, 20, height}));
    REQUIRE(found.count == 3);
    for (const auto& touch : found.touches)
        CHECK(touch.share == Approx(height * std::sqrt(1 + slope * slope) / 3).epsilon(1e-7));
    found = ball.update({20.2, 19.9, -1});
    CHECK(near(found.proxy, {20, 20, height}));
    CHECK(found.count == 3);
    // Up one of the three valleys: two touches.
    found = ball.update({20, 14, 1});
    CHECK(found.count == 2);
    CHECK(found.proxy.y < 19);
    CHECK(std::abs(found.proxy.x - 20) < 1e-8);
}

TEST_CASE("ball tracker: over a knife ridge and back", "[ball]") {
    Ball ball{ridge<double>(24, 20, 8), 1.5};
    (void)ball.update({11, 10, 4});
    for (int n = 0; n <= 20; ++n) (void)ball.update({11 + 0.1 * n, 10 + 0.03 * n, -1});
    for (int n = 0; n <= 20; ++n) (void)ball.update({13 - 0.1 * n, 10, -1 - 0.1 * n});
}

TEST_CASE("ball tracker: from a crest on which it leans it goes to that side", "[ball]") {
    // z = −|x − 10|: the ball touches the crest alone, and leans to the left.
    Ball ball{terrain<double>(24, 20, [](Index i, Index) { return -std::abs(static_cast<double>(i) - 10); }),
              1};
    const glm::dvec3 normal = glm::normalize(glm::dvec3{-0.565, 0, 0.825}),
                     centre = glm::dvec3{10, 9.5, 0} + normal;
    (void)ball.update(centre + 0.3 * normal);
    const auto leans = ball.update(centre - 0.2 * normal);
    CHECK(near(leans.proxy, centre));
    const auto found = ball.update({10.5, 9.5, -3});
    const double along = (3 + 0.5 + std::sqrt(2.0)) / 2; // to the offset plane z = x − 10 + √2
    CHECK(near(found.proxy, {10.5 - along, 9.5, along - 3}));
}

TEST_CASE("ball tracker: it rolls over what is in the way only where going round that leads nearer",
          "[ball]") {
    // From x = -0.6 to 0 on the plane z = -1. Corner 10 of the patch is clear of both ends, and in the way between.
    const hfh::detail::RelativePatch patch{-1.3, 0, 1, 1, -3, -0.954, -3, -3};
    const auto rolls_to = [&](const glm::dvec3& target) {
        const hfh::detail::RollingBall<> ball{{-0.6, 0, 0}, {0, 0, 1}, target, 1, 1e-12};
        return ball.is_clear_of(patch);
    };
    CHECK(rolls_to({2, 0, -1}));
    CHECK_FALSE(rolls_to({-0.2, 0, -6})); // it would have to rise
    // Higher than an eighth of the radius it is no small thing.
    const hfh::detail::RelativePatch higher{-1.3, 0, 1, 1, -3, -0.8, -3, -3};
    CHECK_FALSE(
        hfh::detail::RollingBall<>{{-0.6, 0, 0}, {0, 0, 1}, {2, 0, -1}, 1, 1e-12}.is_clear_of(higher));
}

TEST_CASE("ball tracker: it stops at the first minimum on its way", "[ball]") {
    struct Led {
        const char* scene;
        double radius;
        BallState<double> before;
        glm::dvec3 stylus;
    };
    const auto touching = [](const glm::dvec3& centre, const glm::dvec3& stylus,
                             const SurfacePoint<double>& foot) {
        return BallState<double>{.centre = centre,
                                 .stylus = stylus,
                                 .foot = foot,
                                 .side = Side::above,
                                 .phase = TrackerPhase::contact};
    };
    const Led many[] = {
        // The foot of the stylus is across a hollow or an edge.
        {"gentle hills",
         0.5,
         touching({7.2868418989764994, 12.085539861066506, 1.107630366001908},
                  {6.4565736382801253, 11.84275788536841, -0.06735229216819065},
                  {{7, 12}, 0.0023213800569333747, 0.0023421080270212375}),
         {6.4297418136894855, 11.830419112294866, -0.036330390249827683}},
        {"rough",
         1,
         touching({6.9236229322574481, 11.082269737880416, 1.3400509766985653},
                  {7.0011577729600898, 10.328861689254293, 0.48239003834600536},
                  {{6, 10}, 1, 0.41912469480759967}),
         {7.0026020068967174, 10.341055047531222, 0.46971385936786852}},
        {"terraces",
         2,
         touching({14.476679764322968, 1.4766797643229679, 7.2065647182838273},
                  {15.17673965631543, 2.99488152246251, 5.6030804514888368},
                  {{14, 2}, 1, 0.84162224130339758}),
         {15.094039685497957, 3.0699645574447594, 5.614805578891545}},
        // A step as long as a look allows ends beyond.
        {"checkerboard",
         1,
         touching({4.9999999999999938, 11, 1.4142135623731014},
                  {4.7261370077643488, 4.3655585268080097, -5.5781300111561531},
                  {{4, 10}, 1, 0.29289321881344932}),
         {4.7356142029757162, 4.2700385467340816, -5.4412049233214388}},
        {"checkerboard",
         0.5,
         touching({15.125293372411708, 15.000000000000002, 0.83283685183720968},
                  {16.507348546220314, 15.07188299834673, -0.6098558948622258},
                  {{15, 15}, 0.47087185634781131, 0.021015414761598569}),
         {16.519514495733503, 15.076334698644695, -0.58489221911099598}},
    };
    for (const Led& led : many) {
        CAPTURE(led.scene, led.radius);
        const auto ground = named_terrain<double>(led.scene);
        REQUIRE(ground);
        const auto grid = ground->grid();
        BallTracker tracker{grid, led.radius};
        tracker.restore(led.before);
        const auto found = tracker.update(led.stylus);
        REQUIRE(found.status == ContactStatus::contact);
        const BallSurface<double> surface{*ground};
        const Wide radius = static_cast<Wide>(led.radius);
        const auto start = surface.pushed_clear(wide(led.before.centre), radius);
        REQUIRE(start);
        const Flow flow =
            flow_of_ball(surface, *start, wide(led.stylus), radius, SurfaceKind::solid, 20000, 400);
        REQUIRE(flow.end == FlowEnd::minimum);
        CHECK(in_one_basin(surface, flow.centre, centre_of(led.stylus, found), wide(led.stylus), radius));
    }
}

TEST_CASE("ball tracker: no speed takes it through spikes thinner than itself", "[ball]") {
    // A fence: every second sample of a column is a spike.
    auto ground = plane<double>(24, 20, 0);
    for (Index j = 0; j < 20; j += 2) ground.at(12, j) = 8;
    for (const double r : {1.2, 2.0, 4.0}) {
        for (const double y : {10.0, 9.3, 9.0}) {
            Ball ball{ground, r};
            (void)ball.update({3, y, 5});
            const auto found = ball.update({22, y, 5});
            CHECK(found.touching());
            CHECK(found.proxy.x < 12);
        }
    }
    // A single one is passed by on the side where it is hit, not through it.
    Ball ball{peak<double>(24, 20, 8), 1};
    (void)ball.update({3, 9.7, 4});
    const auto passed = ball.update({20, 9.7, 4});
    CHECK((passed.status == ContactStatus::free || passed.proxy.x < 12));
}

TEST_CASE("ball tracker: at the foot of a step and over a cliff", "[ball]") {
    auto step = terrain<double>(24, 20, [](Index i, Index) { return i < 12 ? 0.0 : 6.0; });
    for (const double r : {0.3, 1.0, 2.5}) {
        Ball ball{step, r};
        (void)ball.update({6, 10, 4});
        for (int n = 0; n < 12; ++n) {
            const auto found = ball.update({6 + 0.5 * n, 10, -1});
            CHECK(found.touching());
        }
        const auto held = ball.update({11.2, 10, -1});
        CHECK(held.count == 2);
    }
    Ball over{step, 1};
    (void)over.update({16, 10, 9});
    for (int n = 0; n < 10; ++n) CHECK(over.update({16 - 0.5 * n, 10, 5}).touching());
    CHECK(over.update({8, 10, 5}).status == ContactStatus::free);
}

TEST_CASE("ball tracker: a ball pushed clear of a thin ridge stays on its side of it", "[ball]") {
    struct {
        const char* terrain;
        glm::dvec3 centre;
        SurfacePoint<double> foot;
        glm::dvec3 stylus;
    } const cases[]{
        {"checkerboard",
         {11, 2.9999999999722808, 0.1668042184674654},
         {{11, 3}, 0.055, 0.055},
         {10.97707514571939, 8.2145371634091564, -2.3670479915867708}},
        {"checkerboard",
         {14.687902286381414, 9, 0.45550057839404356},
         {{14, 9}, 0.69, 0.06},
         {9.8408118480019375, 10.11994417841405, -4.0247999931837075}},
    };
    for (const auto& c : cases) {
        INFO(c.terrain);
        const auto ground = *named_terrain<double>(c.terrain);
        const auto grid = ground.grid();
        Tracker<double> ball{grid, 0.1};
        ball.restore({.centre = c.centre,
                      .stylus = c.stylus,
                      .foot = c.foot,
                      .side = Side::above,
                      .phase = TrackerPhase::contact});
        const auto found = ball.update(c.stylus);
        CHECK(found.status == ContactStatus::contact);
        const BallJudge<double> judge{ground};
        CHECK(judge({wide(c.centre), ContactStatus::contact, c.stylus, found, 0.1L}).fault == "");
    }
}

TEST_CASE("ball tracker: on a sheet, a ball that is pushed round the border is on the other side", "[ball]") {
    const auto ground = *named_terrain<double>("rough");
    const auto grid = ground.grid();
    Tracker<double> ball{grid, 1, {.surface = SurfaceKind::sheet}};
    const glm::dvec3 centre{11.131867563530998, 7.0263734177813033, 1.5162082931473049},
        stylus{0.46873160263002589, 18.989999999999998, 0.4486695524693165};
    ball.restore({.centre = centre,
                  .stylus = {11, 7, 0.5},
                  .foot = {{11, 7}, 0.1, 0.1},
                  .side = Side::above,
                  .phase = TrackerPhase::contact});
    const auto found = ball.update(stylus);
    REQUIRE(found.touching());
    CHECK(found.side == hfh::detail::side_of(grid, ball.centre()));
}

TEST_CASE("ball tracker: on a sheet, it does not roll under an edge", "[ball]") {
    const auto ground = *named_terrain<double>("steep hills");
    const auto grid = ground.grid();
    Tracker<double> ball{grid, 0.1, {.surface = SurfaceKind::sheet}};
    const glm::dvec3 centre{22.371224210746149, 12.018454310662285, -3.2321378114520094},
        stylus{22.440487353252472, 11.942801923504094, -3.5168294447693582};
    ball.restore({.centre = centre,
                  .stylus = {22.371224210746146, 12.05595713613425, -3.25379007783362},
                  .foot = {{22, 12}, 0.37122421074614304, 0.1050568510407289},
                  .side = Side::above,
                  .phase = TrackerPhase::contact});
    const auto found = ball.update(stylus);
    const BallJudge<double> judge{ground};
    CHECK(judge({wide(centre), ContactStatus::contact, stylus, found, 0.1L, SurfaceKind::sheet}).fault == "");
}

TEST_CASE("ball tracker: checkerboard heights", "[ball]") {
    for (const double r : {0.2, 0.7, 1.6}) {
        Ball ball{terrain<double>(24, 20, [](Index i, Index j) { return double((i + j) % 2); }), r};
        (void)ball.update({6, 6, 5});
        for (int n = 0; n < 30; ++n) {
            const double s = n;
            CHECK(ball.update({6 + 0.3 * s, 6 + 0.17 * s, -0.5}).touching());
        }
    }
}

TEST_CASE("ball tracker: a patch bent more sharply than the ball touches it twice", "[ball]") {
    // One patch among many: a saddle with a valley along its diagonal.
    auto ground = terrain<double>(4, 4, [](Index i, Index j) { return (i + j) % 2 == 0 ? 0.0 : 12.0; });
    Ball ball{ground, 0.4};
    (void)ball.update({1.5, 1.5, 20});
    // In the middle of the patch its section across is z = 6 + 12 t²: the centre is at 6 + 12 r² + 1/48.
    const double height = 6 + 12 * 0.16 + 1.0 / 48;
    auto found = ball.update({1.5, 1.5, height - 0.01});
    CHECK(near(found.proxy, {1.5, 1.5, height}));
    REQUIRE(found.count == 2);
    CHECK(found.touches[0].point.cell == found.touches[1].point.cell);
    for (int n = 0; n < 10; ++n) CHECK(ball.update({1.5 + 0.02 * n, 1.5, 6}).touching());
}

TEST_CASE("ball tracker: it rests on the rims of a slot and of a hole narrower than itself", "[ball]") {
    const double height = std::sqrt(3.0); // r = 2, a cell on either side
    Ball slot{with_holes([](Index i, Index) { return i == 12; }), 2};
    (void)slot.update({12.3, 9.4, 5});
    auto found = slot.update({12.1, 9.4, -1});
    CHECK(near(found.proxy, {12, 9.4, height}));
    CHECK(found.count == 2);
    // Out of the slot, over the ground and back.
    CHECK(slot.update({16, 9.4, -1}).proxy.z == Approx(2));
    CHECK(near(slot.update({12.1, 9.4, -1}).proxy, {12, 9.4, height}));

    Ball hole{with_holes([](Index i, Index j) { return i == 12 && j == 10; }), 2};
    (void)hole.update({12.3, 9.6, 5});
    found = hole.update({12.1, 10.05, -1});
    CHECK(near(found.proxy, {12, 10, height}));
    CHECK(found.count >= 2);
    CHECK_FALSE(hole.update({12.2, 10.3, 1.9}).touching());
}

TEST_CASE("ball tracker: it falls through a hole wider than itself", "[ball]") {
    Ball ball{with_holes([](Index i, Index j) { return i == 12 && j == 10; }), 0.5};
    (void)ball.update({12.1, 10.1, 3});
    auto found = ball.update({12, 10, -3});
    CHECK_FALSE(found.touching());
    // Below the ground there is no force.
    found = ball.update({16, 10, -3});
    CHECK(found.status == ContactStatus::buried);
    CHECK(found.depth == 0);
    // Over the rim from the ground.
    ball.tracker.reset();
    ball.changed();
    (void)ball.update({9, 10, 2});
    ContactStatus last = ContactStatus::free;
    for (int n = 0; n < 12 && last != ContactStatus::left_at_hole; ++n) {
        found = ball.update({9 + 0.25 * n, 10, -0.2});
        CHECK((found.touching() || found.status == ContactStatus::left_at_hole ||
               found.status == ContactStatus::free));
        last = found.status;
    }
    CHECK(last == ContactStatus::left_at_hole);
}

TEST_CASE("ball tracker: the border of the grid is a wire that holds it from above", "[ball]") {
    Ball ball{plane<double>(24, 20, 0), 2};
    (void)ball.update({20, 10, 4});
    CHECK(near(ball.update({22, 10, -0.5}).proxy, {22, 10, 2}));
    // Beyond the rim: on a circle around it.
    const glm::dvec3 outward = glm::normalize(glm::dvec3{1, 0, 0.5});
    auto found = ball.update({24, 10, 0.5});
    REQUIRE(found.touching());
    CHECK(near(found.proxy, glm::dvec3{23, 10, 0} + 2.0 * outward));
    // The normal would point down.
    found = ball.update({24, 10, -0.5});
    CHECK(found.status == ContactStatus::left_at_border);
    CHECK(found.depth == 0);
    CHECK_FALSE(ball.update({24, 10, -0.6}).touching());
    CHECK_FALSE(ball.update({27, 10, 3}).touching());
    CHECK(ball.update({20, 10, 3}).status == ContactStatus::free);
    CHECK(ball.update({20, 10, 1}).touching());
}

TEST_CASE("ball tracker: a ball larger than the terrain", "[ball]") {
    Ball ball{plane<double>(4, 4, 0), 10};
    (void)ball.update({1, 1, 12});
    CHECK(near(ball.update({1.5, 1.25, -2}).proxy, {1.5, 1.25, 10}));

    Ball uneven{rough<double>(4, 4, 1, 303), 10};
    (void)uneven.update({1.5, 1.5, 12});
    for (int n = 0; n < 12; ++n) CHECK(uneven.update({1 + 0.1 * n, 2 - 0.1 * n, 0}).touching());
}

TEST_CASE("ball tracker: a ball that starts in the ground is buried until it was out", "[ball]") {
    for (const double z : {-1.0, 0.5}) {
        Ball ball{plane<double>(24, 20, 0), 1};
        CHECK(ball.update({12, 10, z}).status == ContactStatus::buried);
        CHECK(ball.update({13, 10, 0.9}).status == ContactStatus::buried);
        CHECK(ball.update({13, 10, 1.1}).status == ContactStatus::free);
        CHECK(ball.update({13, 10, z}).status == ContactStatus::contact);
    }
}

TEST_CASE("ball tracker: bad input is refused and changes nothing", "[ball]") {
    Ball ball{valley<double>(24, 20, 1), 1};
    (void)ball.update({12.4, 10, 6});
    const auto before = ball.update({12.1, 10.2, -1});
    const double nan = hidden_nan<double>(), inf = hidden_infinity<double>();
    for (const double bad : {nan, inf, -inf, 1e300, -1e300}) {
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 stylus{12.1, 10.2, -1};
            stylus[axis] = bad;
            const auto refused = ball.tracker.update(stylus);
            CHECK(refused.status == ContactStatus::bad_input);
            CHECK(refused.count == 0);
            CHECK(refused.proxy == glm::dvec3{0.0});
        }
    }
    CHECK(same(ball.update({12.1, 10.2, -1}), before));
}

TEST_CASE("ball tracker: raised ground lifts it, and on lowered ground it sinks", "[ball]") {
    Ball ball{plane<double>(24, 20, 0), 1};
    (void)ball.update({12.3, 10.2, 3});
    const glm::dvec3 stylus{12.3, 10.2, -4};
    CHECK(near(ball.update(stylus).proxy, {12.3, 10.2, 1}));
    const auto set_all = [&](double height) {
        for (double& sample : ball.terrain.heights) sample = height;
        ball.changed();
    };
    set_all(2.5);
    CHECK(near(ball.update(stylus).proxy, {12.3, 10.2, 3.5}));
    set_all(-2);
    CHECK(near(ball.update(stylus).proxy, {12.3, 10.2, -1}));
    set_all(-6);
    CHECK(ball.update(stylus).status == ContactStatus::free);
    // A heap under it: it comes out on top or beside it, clear, and rests there.
    set_all(-6);
    CHECK(ball.update({12.3, 10.2, -7}).touching());
    ball.terrain.at(12, 10) = -3.5, ball.terrain.at(13, 10) = -4;
    ball.changed();
    const auto found = ball.update({12.3, 10.2, -7});
    CHECK(found.touching());
    // A trench beside it.
    for (Index j = 0; j < 20; ++j) ball.terrain.at(14, j) = -9;
    ball.changed();
    CHECK(ball.update({13.5, 10.2, -8}).touching());
}

TEST_CASE("ball tracker: ground raised by a ten-millionth of the radius under a free ball is felt",
          "[ball]") {
    Ball ball{plane<double>(24, 20, 0), 1};
    (void)ball.update({12.3, 10.4, 5});
    (void)ball.update({12.3, 10.4, 1 + 1e-12});
    for (double& height : ball.terrain.heights) height = 1e-7;
    ball.changed();
    CHECK(ball.update({12.3, 10.4, 1 + 1e-12}).status == ContactStatus::contact);
}

TEST_CASE("ball tracker: a lift along ground of any height comes to an end", "[ball]") {
    // Beside the corner of the grid, where no other cell is near.
    for (const double height : {1e4, 1e7, 1e9}) {
        INFO(height);
        auto ground = plane<double>(24, 20, 0);
        const auto grid = ground.grid();
        const CountingField counting{grid};
        BallTracker ball{counting, 0.5};
        (void)ball.update({-0.3, -0.3, 2});
        (void)ball.update({-0.3, -0.3, 0.2});
        ground.at(0, 0) = height;
        const long before = counting.looks();
        (void)ball.update({-0.3, -0.3, 0.2});
        CHECK(counting.looks() - before < 1'000'000);
    }
}

TEST_CASE("ball tracker: the radius changes while it touches", "[ball]") {
    Ball ball{plane<double>(24, 20, 0), 1};
    const auto set_radius = [](Ball& which, double r) {
        which.tracker.set_radius(r);
        which.changed();
    };
    (void)ball.update({12.3, 10.2, 3});
    const glm::dvec3 stylus{12.3, 10.2, -1};
    CHECK(near(ball.update(stylus).proxy, {12.3, 10.2, 1}));
    for (const double r : {2.0, 0.5, 4.0, 0.25}) {
        set_radius(ball, r);
        CHECK(ball.tracker.radius() == r);
        CHECK(near(ball.update(stylus).proxy, {12.3, 10.2, r}));
    }
    for (const double none : {0.0, -1.0, hidden_nan<double>(), hidden_infinity<double>()}) {
        ball.tracker.set_radius(none);
        CHECK(ball.tracker.radius() == 0);
        const auto point = ball.tracker.update(stylus);
        CHECK(point.status == ContactStatus::contact);
        CHECK(near(point.proxy, {12.3, 10.2, 0}));
    }
    set_radius(ball, 1);
    CHECK(near(ball.update(stylus).proxy, {12.3, 10.2, 1}));

    Ball held{valley<double>(24, 20, 1), 0.5};
    (void)held.update({12, 10, 6});
    (void)held.update({12.1, 10.2, -1});
    for (const double r : {1.0, 3.0, 0.75}) {
        set_radius(held, r);
        CHECK(near(held.update({12.1, 10.2, -1}).proxy, {12, 10.2, r * std::sqrt(2.0)}, 1e-7));
    }
}

TEST_CASE("ball tracker: with limited work a covered ball stays in contact and arrives at rest", "[ball]") {
    for (const int patches : {1, 8, 64}) {
        for (const int contact_patches : {1, 8}) {
            for (const double r : {0.5, 2.0}) {
                Ball ball{hills<double>(24, 20, 4, 7),
                          r,
                          {.max_patches = patches, .max_contact_patches = contact_patches}};
                (void)ball.update({6, 6, 4.5}, false);
                // Down until it is felt, then on.
                BallContact<double> found;
                for (int n = 0; n < 200 && !found.touching(); ++n) found = ball.update({6, 6, -3}, false);
                REQUIRE(found.touching());
                for (int n = 0; n < 30; ++n) {
                    const double s = n;
                    found = ball.update({6 + 0.4 * s, 6 + 0.2 * s, -3}, false);
                    CHECK(found.touching());
                    CHECK(found.depth > 0);
                }
                const glm::dvec3 last{17.6, 11.8, -3};
                for (int n = 0; n < 2000 && found.status != ContactStatus::contact; ++n)
                    found = ball.update(last, false);
                CHECK(found.status == ContactStatus::contact);
                CHECK(same(ball.update(last, false), ball.update(last, false)));
            }
        }
    }
}

TEST_CASE("ball tracker: a sheet is felt from either side", "[ball]") {
    Ball ball{plane<double>(24, 20, 0), 1, {.surface = SurfaceKind::sheet}};
    CHECK(ball.update({12, 10, 3}).side == Side::above);
    auto found = ball.update({12, 10, -0.5});
    CHECK(found.side == Side::above);
    CHECK(near(found.proxy, {12, 10, 1}));
    ball.tracker.reset();
    ball.changed();
    CHECK(ball.update({12, 10, -3}).side == Side::below);
    found = ball.update({12.5, 10.2, 0.5});
    CHECK(found.side == Side::below);
    CHECK(near(found.proxy, {12.5, 10.2, -1}));
    CHECK(found.normal.z < 0);
    CHECK(found.touches[0].normal.z < 0);
    CHECK(ball.update({12.5, 10.2, -1.5}).status == ContactStatus::free);

    // The underside of a ridge is a valley.
    Ball under{ridge<double>(24, 20, 1), 1, {.surface = SurfaceKind::sheet}};
    (void)under.update({12.3, 10, -9});
    found = under.update({12.1, 10.2, 2});
    CHECK(near(found.proxy, {12, 10.2, -std::sqrt(2.0)}));
    CHECK(found.count == 2);
}

TEMPLATE_TEST_CASE("ball tracker: a ball of no radius is the point's tracker, to the bit", "[ball]", float,
                   double) {
    using T = TestType;
    for (const char* name : {"steep hills", "rough", "checkerboard"}) {
        const auto ground = *named_terrain<T>(name);
        const auto grid = ground.grid();
        for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
            Tracker<T> ball{grid, T(0), {.surface = kind}};
            ProxyTracker<typename Terrain<T>::Grid> point{grid, {.surface = kind}};
            BallHand<T> hand{ground, 0, 1, 1, false, 304};
            for (int n = 0; n < 300; ++n) {
                const auto stylus = hand.next();
                const auto one = ball.update(stylus);
                const auto other = point.update(stylus);
                REQUIRE(same(one, other));
                CHECK(one.patches == other.patches);
            }
        }
    }
}

TEST_CASE("ball tracker: a tiny ball is near the point's proxy", "[ball]") {
    for (const char* name : {"gentle hills", "steep hills", "saddle", "valley", "cone valley", "rough"}) {
        const auto ground = *named_terrain<double>(name);
        const auto grid = ground.grid();
        const Surface<double> surface{ground};
        Wide steepest = 0;
        for (Index j = 0; j + 1 < ground.rows; ++j) {
            for (Index i = 0; i + 1 < ground.columns; ++i) {
                const WidePatch p = *surface.patch(i, j);
                const Wide x = std::max(std::abs(p.along_u(0)), std::abs(p.along_u(1))) / p.dx,
                           y = std::max(std::abs(p.along_v(0)), std::abs(p.along_v(1))) / p.dy;
                steepest = std::max(steepest, x * x + y * y);
            }
        }
        for (const double r : {1e-3, 1e-6}) {
            const double within = r * static_cast<double>(std::sqrt(1 + steepest)) * (1 + 1e-6);
            Tracker<double> ball{grid, r};
            ProxyTracker<Terrain<double>::Grid> point{grid};
            BallHand<double> hand{ground, r, 0.4, 0.5, false, 305};
            int apart = 0, felt = 0;
            for (int n = 0; n < 300; ++n) {
                const auto stylus = hand.next();
                const auto one = ball.update(stylus);
                const auto other = point.update(stylus);
                if (one.status != ContactStatus::contact || other.status != ContactStatus::contact) continue;
                ++felt;
                apart += glm::length(one.proxy - other.proxy) > within;
            }
            INFO(name << ", r = " << r);
            CHECK(felt > 100);
            CHECK(apart == 0);
        }
    }
}

TEST_CASE("ball tracker: two balls on one field do not know of each other", "[ball]") {
    const auto ground = *named_terrain<double>("rough");
    const auto grid = ground.grid();
    Tracker<double> first{grid, 0.5}, second{grid, 2}, alone{grid, 0.5};
    BallHand<double> one{ground, 0.5, 1, 1, false, 306}, same_one{ground, 0.5, 1, 1, false, 306},
        other{ground, 2, 1, 1, false, 307};
    for (int n = 0; n < 200; ++n) {
        const auto together = first.update(one.next());
        (void)second.update(other.next());
        CHECK(same(together, alone.update(same_one.next())));
    }
}

TEST_CASE("ball tracker: does not allocate", "[ball]") {
    const auto ground = *named_terrain<double>("rough");
    const auto grid = ground.grid();
    Tracker<double> ball{grid, 2};
    BallHand<double> hand{ground, 2, 2, 2, false, 308};
    std::size_t asked = 0;
    for (int n = 0; n < 200; ++n) {
        const auto stylus = hand.next();
        const auto before = allocations();
        (void)ball.update(stylus);
        asked += allocations() - before;
    }
    CHECK(asked == 0);
}

TEST_CASE("ball tracker: the first touch of a moving ball", "[ball]") {
    Random random{309};
    int touches = 0;
    for (const char* name : {"rough", "steep hills", "peak", "checkerboard"}) {
        const auto ground = *named_terrain<double>(name);
        const auto grid = ground.grid();
        const BallSurface<double> surface{ground};
        for (int n = 0; n < 60; ++n) {
            const double r = log_between(random, 0.1, 5);
            const auto place = [&](double low, double high) {
                return glm::dvec3{random.between(6, 18), random.between(6, 14), random.between(low, high)};
            };
            glm::dvec3 from = place(5, 12), to = place(-3, 9);
            if (random.one_in(3)) to = from + 0.2 * (to - from);
            if (surface.distance(wide(from), static_cast<Wide>(r)) < static_cast<Wide>(r)) continue;
            const auto found = first_touch(grid, from, to, r);
            const bool touch = found.status == BallSweepStatus::touch;
            touches += touch;
            REQUIRE((touch || found.status == BallSweepStatus::miss));
            const auto verdict =
                judge_first_touch(ground, from, to, r, touch ? std::optional{found.t} : std::nullopt);
            INFO(name << ", r = " << digits(r) << ", " << digits(from) << " -> " << digits(to) << ", t "
                      << digits(found.t));
            CHECK((verdict == SweepVerdict::right || verdict == SweepVerdict::unclear));
        }
    }
    CHECK(touches > 50);
}

TEST_CASE("ball tracker: a ball that leaves a patch touches it again where that is bent towards it",
          "[ball]") {
    auto ground = *named_terrain<double>("steep hills");
    punch_holes(ground, 8, 114);
    const MovingBall first{{15.212279304598031, 14.525453869190663, 1.4227989074739649},
                           {14.0371723590596, 14.038886393536274, -1.7883039084927217},
                           0.29285828084091498};
    CHECK(judge_moving_ball(BallSurface<double>{ground}, first).fault == "");
    const auto real = real_terrain<double>("sugarhouse_standin");
    if (!real) return;
    const MovingBall second{{4386.450518813559, 15263.215133171927, 1276.290020313136},
                            {4542.0057785609451, 15394.789845615969, 1215.1706229710132},
                            114.89483999414269};
    CHECK(judge_moving_ball(BallSurface<double>{*real}, second).fault == "");
}

TEST_CASE("ball tracker: the normal of a first touch comes from its point where the ball grazes a fold",
          "[ball]") {
    const MovingBall balls[]{{{-943.9522862555101, -289.81001532454673, -0.15921966802272303},
                              {-943.9522862555101, -293.42478136927281, -0.15921966802272303},
                              0.17099830941243799},
                             {{-949.86237298042397, -283.79667516458846, 2.3764936028466264},
                              {-965.02638908416793, -283.79667516458846, 2.3764936028466264},
                              2.3764936028466264}};
    CHECK(judge_moving_ball(BallSurface<double>{*named_terrain<double>("hard 2 1")}, balls[0]).fault == "");
    CHECK(judge_moving_ball(BallSurface<double>{*named_terrain<double>("hard 5 1")}, balls[1]).fault == "");
}

TEMPLATE_TEST_CASE("ball tracker: first touches from everywhere and in all directions, judged", "[ball]",
                   float, double) {
    using T = TestType;
    MovingBallTally tally;
    std::uint64_t seed = 320;
    for (const auto& scene : scenes<T>()) {
        auto ground = scene.terrain;
        move_balls<T>(scene.name, ground, 20, ++seed, tally);
        punch_holes(ground, 8, 114);
        move_balls<T>(scene.name, ground, 20, ++seed, tally);
    }
    for (int kind = 0; kind < static_cast<int>(HardGround::no_data); ++kind) {
        const std::string name = "hard " + std::to_string(kind) + " 1";
        move_balls<T>(name, *named_terrain<T>(name), 20, ++seed, tally);
    }
    for (const auto& example : tally.examples) FAIL_CHECK(example);
    CHECK(tally.faults == 0);
    CHECK(tally.touches > 200);
    CHECK(tally.unclear < tally.balls / 20);
}

TEMPLATE_TEST_CASE("ball tracker: random strokes on every kind of ground, judged", "[ball]", float, double) {
    using T = TestType;
    BallTally tally;
    std::uint64_t seed = 310;
    for (const auto& scene : scenes<T>())
        follow_strokes<T>(scene.name, scene.terrain, 150, 25, ++seed, make_tracker, tally);
    for (int kind = 0; kind < static_cast<int>(HardGround::no_data); ++kind) {
        const std::string name = "hard " + std::to_string(kind) + " 1";
        follow_strokes<T>(name, *named_terrain<T>(name), 100, 25, ++seed, make_tracker, tally);
    }
    for (const auto& example : tally.examples) FAIL_CHECK(example);
    CHECK(tally.faults == 0);
    CHECK(tally.other_minima == 0);
    CHECK(tally.contacts > 1000);
    CHECK(tally.flows > 10);
}

// Replays strokes, for who looks for a fault: HFH_BALL_REPLAY is a file with the lines that a judge has printed after "replay".
TEMPLATE_TEST_CASE("ball tracker: replay", "[.ball-replay]", float, double) {
    using T = TestType;
    const char* path = std::getenv("HFH_BALL_REPLAY");
    if (!path) return skip("HFH_BALL_REPLAY names no file");
    std::ifstream file{path};
    for (std::string line; std::getline(file, line);) {
        if ((line.rfind("float\t", 0) == 0) != std::is_same_v<T, float>) continue;
        const auto stroke = BallStroke<T>::read(line);
        const auto ground = named_terrain<T>(stroke.terrain);
        if (!ground) continue;
        const auto grid = ground->grid();
        auto tracker = make_tracker(*ground, grid, stroke.radius, stroke.kind);
        FollowedBall<T, Tracker<T>> ball{*ground, {stroke.terrain, stroke.radius, stroke.kind, {}}, tracker};
        for (const auto& stylus : stroke.way) {
            const auto answer = ball.update(stylus, {.flow = true, .sweep = true});
            std::cout << to_string(answer.found.status) << ", centre " << digits(answer.found.proxy)
                      << ", depth " << digits(answer.found.depth) << ' ' << answer.replay << '\n';
        }
    }
}
