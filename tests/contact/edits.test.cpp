#include "catch.hpp"
#include "support/edited_touch.hpp"
#include "support/reference.hpp"
#include "support/scenes.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/force_evaluator.hpp>

#include <string>

// Ground that is edited while it is touched: nothing is rebuilt, the next update feels it.

using namespace hfh;
using namespace hfh::test;

namespace {

/// A stamp of radius `radius` cells that lifts ground by up to `by`, most at (x, y) in cells; the most that it did.
template <Real T>
double stamp(Terrain<T>& ground, double x, double y, double radius, double by) {
    double most = 0;
    for (Index j = 0; j < ground.rows; ++j) {
        for (Index i = 0; i < ground.columns; ++i) {
            const double dx = double(i) - x, dy = double(j) - y,
                         inside = 1 - (dx * dx + dy * dy) / (radius * radius);
            if (inside <= 0) continue;
            const T before = ground.at(i, j);
            ground.at(i, j) += static_cast<T>(by * inside * inside);
            most = std::max(most, std::abs(double(ground.at(i, j)) - double(before)));
        }
    }
    return most;
}

} // namespace

TEMPLATE_TEST_CASE("edits: a resting stylus feels level ground rise and sink by just as much", "[edits]",
                   float, double) {
    using T = TestType;
    auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
        for (auto& h : ground.heights) h = T(0);
        ProxyTracker tracker{grid, {.surface = kind}};
        const vec3<T> at{T(4.25), T(3.5), T(-0.5)};
        static_cast<void>(tracker.update({at.x, at.y, T(1)}));
        REQUIRE(tracker.update(at).penetration == vec3<T>{T(0), T(0), T(0.5)});
        for (int n = -7; n < 64; ++n) {
            for (auto& h : ground.heights) h = T(n) / 16;
            const auto contact = tracker.update(at);
            REQUIRE(contact.touching());
            CHECK(contact.penetration == vec3<T>{T(0), T(0), T(n) / 16 + T(0.5)});
            CHECK(contact.proxy == vec3<T>{at.x, at.y, T(n) / 16});
        }
        // Dug away from under it the stylus is free, on its side; raised over it again it is touched again: the solid
        // was met from above.
        for (auto& h : ground.heights) h = T(-1);
        CHECK(tracker.update(at).status == ContactStatus::free);
        for (auto& h : ground.heights) h = T(0);
        const auto again = tracker.update(at);
        CHECK(again.touching());
        CHECK(again.penetration == vec3<T>{T(0), T(0), T(0.5)});
    }
}

TEMPLATE_TEST_CASE(
    "edits: the force moves no more than stiffness times edit and motion, in a pit that is dug",
    "[edits][law]", float, double) {
    using T = TestType;
    // The stylus digs where it is, at a vertex, on an edge, within a cell. A pit has valleys at its edges, and the
    // penetration is continuous over those; on the wall of the pit the ground is convex, by the second derivative of
    // the stamp, and the force may move by that much of the depth more.
    for (const auto& where : {glm::dvec2{10, 10}, {10, 9.5}, {10.25, 9.75}}) {
        const double x = where.x, y = where.y;
        auto ground = plane<T>(21, 21);
        const auto grid = ground.grid();
        ProxyTracker tracker{grid};
        const ForceEvaluator<T> force{.stiffness = T(100)};
        const auto at = [&](double z) {
            return vec3<T>{static_cast<T>(x), static_cast<T>(y), static_cast<T>(z)};
        };
        static_cast<void>(tracker.update(at(1)));
        double edit = 0, z = 0.25, last_z = 1;
        vec3<T> before{T(0)};
        int dug = 0;
        for (int n = 0; n < 1000; ++n) {
            if (z > -2) z -= 0.004;
            const auto contact = tracker.update(at(z));
            const vec3<T> now = force(contact).newtons;
            const double step = double(glm::length(now - before)),
                         allowed = 100 * (edit + std::abs(z - last_z));
            CHECK(step <= allowed * 1.001 + 4000 * double(epsilon<T>));
            if (z < 0) CHECK((contact.touching() || contact.status == ContactStatus::free));
            before = now, last_z = z, edit = 0;
            // Yields at a depth of a quarter of a cell.
            if (double(contact.depth) > 0.25) {
                edit = stamp(ground, double(contact.proxy.x), double(contact.proxy.y), 6,
                             -0.3 * (double(contact.depth) - 0.25));
                ++dug;
            }
        }
        CAPTURE(x, y);
        CHECK(dug > 300);
        CHECK(double(before.z) == Approx(25).margin(1)); // what the ground bears
        CHECK(ground.at(10, 10) < T(-1.5));              // more than a whole cell deep
    }
}

TEMPLATE_TEST_CASE(
    "edits: a brush that raises ground under a resting hand moves the force no more than it may",
    "[edits][law]", float, double) {
    using T = TestType;
    // Raised ground is convex. What an edit adds to the slope of a patch turns its plane about the foot, and that moves
    // the foot by depth · change of slope besides what the ground was lifted; the slopes on both sides of a crest
    // part, so by twice that where the foot of a face that was flat is a crest. The hand is touched from a depth of 0.
    for (const auto& [x, y] : {std::pair{20.0, 20.0}, {20.0, 20.5}, {20.25, 19.75}, {22.5, 21.0}}) {
        for (const double radius : {4.0, 12.0}) {
            auto ground = plane<T>(41, 41);
            const auto grid = ground.grid();
            ProxyTracker tracker{grid};
            const ForceEvaluator<T> force{.stiffness = T(100)};
            const vec3<T> at{static_cast<T>(x), static_cast<T>(y), T(0)};
            static_cast<void>(tracker.update({at.x, at.y, T(1)}));
            static_cast<void>(tracker.update(at));
            vec3<T> before{T(0)};
            double depth = 0, worst = 0;
            for (int n = 0; n < 400; ++n) {
                const double by = 0.002;
                const double lifted = stamp(ground, 20, 20, radius, by);
                const auto contact = tracker.update(at);
                const vec3<T> now = force(contact).newtons;
                REQUIRE(contact.touching());
                // d/ds of (1 − s²/r²)² is at most 1.54/r.
                const double turned = by * 1.54 / radius;
                const double allowed = 100 * (lifted + 2 * std::sqrt(2.0) * turned * depth);
                worst = std::max(worst, double(glm::length(now - before)) / allowed);
                before = now, depth = double(contact.depth);
            }
            CAPTURE(x, y, radius, worst);
            CHECK(worst <= 1.01 + 1000 * double(epsilon<T>));
            CHECK(double(before.z) > 20);
        }
    }
}

TEMPLATE_TEST_CASE("edits: vertices and cells around a resting stylus, edited at random", "[edits][law]",
                   float, double) {
    using T = TestType;
    // Every update one sample changes: of the cell of the proxy, or of a neighbour. Then the proxy is on the edited surface,
    // at a minimum, and was never farther than the old proxy is after the edit.
    for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
        for (const double size : {0.01, 0.25, 2.0}) {
            Random random{111};
            auto ground = rough_in_steps<T>(16, 16, 0.5, 112);
            const auto grid = ground.grid();
            const Surface<T> surface{ground};
            ProxyTracker tracker{grid, {.surface = kind}};
            const vec3<T> at{T(8.3), T(7.6), T(-0.25)};
            int touching = 0, freed = 0;
            for (int n = 0; n < 4000; ++n) {
                const auto before = tracker.state();
                if (!before.touching())
                    static_cast<void>(tracker.update({at.x, at.y, T(40)})); // come from above again
                const Cell c = before.touching() ? before.proxy.cell : Cell{8, 7};
                const Index i = std::clamp<Index>(c.i + random.whole(-1, 2), 1, 14),
                            j = std::clamp<Index>(c.j + random.whole(-1, 2), 1, 14);
                ground.at(i, j) = static_cast<T>(
                    std::clamp(double(ground.at(i, j)) + random.between(-size, size), -2.0, 2.0));
                const auto contact = tracker.update(at);
                const Point q = wide(at);
                if (!contact.touching()) {
                    ++freed;
                    const Wide above = q.z - *surface.height(q.x, q.y);
                    if (contact.status == ContactStatus::free && kind == SurfaceKind::solid)
                        REQUIRE(above >= -Wide(1e-12L));
                    REQUIRE(contact.status == ContactStatus::free);
                    continue;
                }
                ++touching;
                const WideSurfacePoint now = wide(contact.point);
                REQUIRE(length(wide(contact.proxy) - surface.position(now)) <=
                        64 * static_cast<Wide>(epsilon<T>) * 16);
                REQUIRE(surface.template fall<T>(now, q) <= 64);
                if (before.touching() && contact.side == before.side &&
                    contact.status == ContactStatus::contact) {
                    const Wide was = surface.half_square(wide(before.proxy), q),
                               is = surface.half_square(now, q);
                    if (contact.depth > 0)
                        REQUIRE(is <= was * (1 + 64 * static_cast<Wide>(epsilon<T>)) +
                                          64 * static_cast<Wide>(epsilon<T>));
                }
            }
            CAPTURE(size, touching, freed);
            CHECK(touching > 1000);
        }
    }
}

TEMPLATE_TEST_CASE("edits: ground that is raised over a free stylus touches it, however deep it is buried",
                   "[edits]", float, double) {
    using T = TestType;
    for (const double heap : {0.5, 4.0, 1000.0}) {
        auto ground = plane<T>(17, 17);
        const auto grid = ground.grid();
        ProxyTracker tracker{grid};
        const vec3<T> at{T(8.25), T(8.5), T(0.25)};
        REQUIRE(tracker.update(at).status == ContactStatus::free);
        for (auto& h : ground.heights) h = static_cast<T>(heap);
        const auto contact = tracker.update(at);
        CAPTURE(heap);
        // It was above and still is, for all it knows: the ground came up under it.
        REQUIRE(contact.status == ContactStatus::contact);
        CHECK(contact.penetration == vec3<T>{T(0), T(0), static_cast<T>(heap) - T(0.25)});
        // A stylus that is new to it starts buried and feels nothing.
        ProxyTracker late{grid};
        CHECK(late.update(at).status == ContactStatus::buried);
        // The force is clamped, so being buried kicks by max_force at most.
        const ForceEvaluator<T> force{.stiffness = T(500), .max_force = T(3.25)};
        CHECK(glm::length(force(contact).newtons) <= T(3.25) * (1 + 4 * epsilon<T>));
    }
}

TEMPLATE_TEST_CASE(
    "edits: a surface that is taken away releases the stylus, and one that comes back is touched anew",
    "[edits]", float, double) {
    using T = TestType;
    auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid};
    const ForceEvaluator<T> force{.stiffness = T(100)};
    const vec3<T> at{T(4.25), T(4.5), T(-0.5)};
    static_cast<void>(tracker.update({at.x, at.y, T(1)}));
    REQUIRE(tracker.update(at).touching());
    ground.remove(4, 4);
    const auto gone = tracker.update(at);
    CHECK(gone.status == ContactStatus::left_at_hole);
    CHECK(force(gone).newtons == vec3<T>{T(0)});
    CHECK(tracker.update(at).status == ContactStatus::off_surface);
    ground.at(4, 4) = T(0);
    CHECK(tracker.update(at).status == ContactStatus::buried); // it is below and has not been outside
    CHECK(tracker.update({at.x, at.y, T(0.5)}).status == ContactStatus::free);
    CHECK(tracker.update(at).touching());
    // A neighbour that goes does not matter to a proxy within its cell.
    ground.remove(7, 7);
    CHECK(tracker.update(at).penetration == vec3<T>{T(0), T(0), T(0.5)});
}

TEMPLATE_TEST_CASE("edits: a guard passes on to the bit what ground asks for that gives way or is heaped up",
                   "[edits][force_guard][law]", float, double) {
    using T = TestType;
    // As in examples/dig: pressed down, dragged along, lifted a little; yields under more than 1 N, then a brush.
    EditedTouch<T> touch{plane<T>(41, 21, 0, five_millimetres), {T(0.04), T(0.051), T(0.002)}};
    for (int n = 0; n < 500; ++n) (void)touch.step(); // the ramp
    double dug = 0, raised = 0, strongest = 0;
    for (int n = 0; n < 2500; ++n) {
        if (n < 800) touch.stylus.z -= T(1e-5);
        if (n >= 800 && n < 1800) touch.stylus.x += T(6e-5);
        if (n >= 1800 && n < 2000) touch.stylus.z += T(1e-5);
        const auto now = touch.step();
        REQUIRE(now.result.newtons == now.asked);
        strongest = std::max(strongest, glm::length(now.asked));
        const double x = double(touch.stylus.x) / 0.005, y = double(touch.stylus.y) / 0.005,
                     excess = double(touch.contact().depth) - 0.002;
        if (n < 2000 && excess > 0) dug += stamp(touch.ground, x, y, 3, -std::min(0.3 * excess, 5e-5));
        if (n >= 2000) raised += stamp(touch.ground, x, y, 6, 5e-6);
    }
    CHECK_FALSE(touch.tripped());
    CHECK(touch.counts().slewed == 0);
    CHECK(touch.broken() == nullptr);
    CHECK(dug > 0.01);
    CHECK(raised > 0.002);
    CHECK(strongest > 1.2);
}

TEMPLATE_TEST_CASE("edits: ground that is dug, raised or swapped in one update comes at the guard's pace",
                   "[edits][force_guard][law]", float, double) {
    using T = TestType;
    using Edit = void (*)(Terrain<T>&);
    const std::pair<const char*, Edit> edits[] = {
        {"dug", [](Terrain<T>& ground) { stamp(ground, 20.5, 20.25, 6, -0.003); }},
        {"dug away", [](Terrain<T>& ground) { ground.heights.assign(ground.heights.size(), T(-1)); }},
        {"raised", [](Terrain<T>& ground) { stamp(ground, 20.5, 20.25, 6, 0.002); }},
        {"raised beyond what the device can",
         [](Terrain<T>& ground) { ground.heights.assign(ground.heights.size(), T(1)); }},
        {"swapped for a slope",
         [](Terrain<T>& ground) {
             std::ranges::copy(tilted_plane<T>(41, 41, 0.0025, 0, -0.0517).heights, ground.heights.begin());
         }},
        {"swapped for hills", [](Terrain<T>& ground) {
             std::ranges::copy(hills<T>(41, 41, 0.01, 9).heights, ground.heights.begin());
         }}};
    for (const auto& [name, edit] : edits) {
        const GuardLimits limits{.max_slew = 0.07, .max_sudden = 4}; // the slew alone
        const double pace = 70;                                      // N/s
        EditedTouch<T> touch{
            plane<T>(41, 41, 0, five_millimetres), {T(20.5 * 0.005), T(20.25 * 0.005), T(0.001)}, limits};
        for (int n = 0; n < 500; ++n) (void)touch.step();
        touch.stylus.z = T(-0.004);
        for (int n = 0; n < 30; ++n) (void)touch.step();
        glm::dvec3 last = touch.step().result.newtons;
        CAPTURE(name, last.z);
        REQUIRE(last.z == Approx(2));

        edit(touch.ground);
        Random random{114};
        double since = 0, takes = 0; // s
        for (int n = 0; n < 200; ++n) {
            const double seconds = 0.001 * random.between(0.5, 1.5);
            const auto now = touch.step(seconds);
            const double asked = glm::length(now.asked);
            const glm::dvec3 raw =
                asked > limits.max_force ? now.asked * (limits.max_force / asked) : now.asked;
            if (n == 0) takes = glm::distance(raw, last) / pace;
            since += seconds;
            CAPTURE(n, since, takes);
            CHECK(glm::distance(now.result.newtons, last) <= pace * seconds * (1 + 1e-9));
            // There in the first update by when it can be, and not in one before.
            const bool there = glm::distance(now.result.newtons, raw) < 1e-12;
            if (std::abs(since - takes) > 1e-6) CHECK(there == (since > takes));
            last = now.result.newtons;
        }
        CHECK(takes > 0.005);
        CHECK(since > takes + 0.05);
        CHECK_FALSE(touch.tripped());
        CHECK(touch.broken() == nullptr);

        // To and fro in every update.
        auto other = plane<T>(41, 41).heights;
        for (int n = 0; n < 200; ++n) {
            std::ranges::swap_ranges(other, touch.ground.heights);
            const auto now = touch.step();
            CHECK(glm::distance(now.result.newtons, last) <= pace * 0.001 * (1 + 1e-9));
            last = now.result.newtons;
        }
        CHECK_FALSE(touch.tripped());
        CHECK(touch.broken() == nullptr);
    }
}

TEMPLATE_TEST_CASE("edits: whatever is edited at random, a guard holds its limits and does not trip",
                   "[edits][force_guard][law]", float, double) {
    for (const double size : {5e-5, 0.001, 0.008}) {
        const RandomEdits<TestType> edits{size};
        CAPTURE(size, edits.touching);
        CHECK(std::string{edits.touch.broken() == nullptr ? "" : edits.touch.broken()} == "");
        CHECK_FALSE(edits.touch.tripped());
        CHECK(edits.touching > 1000);
        CHECK((edits.slewed > 0) == (size > 5e-4)); // small edits are passed on as they are;
    }
}

TEMPLATE_TEST_CASE("edits: over a new hole the force falls by the slew, and ground that fills it over a "
                   "stylus trips the guard",
                   "[edits][force_guard]", float, double) {
    using T = TestType;
    EditedTouch<T> touch{plane<T>(9, 9, 0, five_millimetres), {T(0.021), T(0.022), T(0.001)}};
    for (int n = 0; n < 500; ++n) (void)touch.step();
    touch.stylus.z = T(-0.003);
    for (int n = 0; n < 5; ++n) (void)touch.step();
    touch.ground.remove(4, 4);
    CHECK(touch.step().result.newtons.z == Approx(0.5)); // from 1.5 N, by 1 N/ms
    CHECK(is_zero(touch.step().result.newtons));
    CHECK_FALSE(touch.tripped());
    touch.ground.at(4, 4) = T(0);
    const auto filled = touch.step(); // it is below and has not met it
    CHECK(filled.result.trip == GuardTrip::buried);
    CHECK(is_zero(filled.result.newtons));
    touch.stylus.z = T(0.001);
    CHECK(touch.step().result.trip == GuardTrip::none);
    touch.stylus.z = T(-0.002);
    for (int n = 0; n < 249; ++n) (void)touch.step();
    CHECK(touch.step().result.newtons.z == Approx(0.5).epsilon(0.02)); // half the ramp
    for (int n = 0; n < 250; ++n) (void)touch.step();
    CHECK(touch.step().result.newtons.z == Approx(1));
    CHECK(touch.broken() == nullptr);
}
