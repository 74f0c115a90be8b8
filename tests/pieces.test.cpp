#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/reference.hpp"
#include "support/scenes.hpp"

#include <hfh/contact/ball_friction.hpp>
#include <hfh/contact/ball_shading.hpp>
#include <hfh/contact/ball_tracker.hpp>
#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/force/damping.hpp>
#include <hfh/hfh.hpp>
#include <hfh/terrain/extended_field.hpp>

// The optional pieces, all at once; and that a scene without them is as small as before they existed. That its code is
// the same too is a test of its own, plain_scene in CMakeLists.txt.

using namespace hfh;
using namespace hfh::test;

// What a tracker and a contact were before there were pieces: nothing was added to them.
static_assert(sizeof(TrackerState<double>) == 120 && sizeof(TrackerState<float>) == 104);
static_assert(sizeof(Contact<double>) == 120 && sizeof(Contact<float>) == 72);
static_assert(sizeof(ForceEvaluator<double>) == 16 && sizeof(ForceEvaluator<float>) == 8);
static_assert(sizeof(ProxyTracker<Terrain<double>::Grid>) == 144);

TEMPLATE_TEST_CASE("pieces: work together, on solid and sheet, allocate nothing, and never give a bad force",
                   "[pieces][realtime]", float, double) {
    using T = TestType;
    for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
        for (auto& scene : scenes<T>()) {
            const auto& ground = scene.terrain;
            const auto grid = ground.grid();
            const glm::dvec2 low = ground.low(), high = ground.high(), cell = ground.frame.spacing;
            const Surface<T> surface{ground};

            const ExtendedField field{grid};
            BallTracker tracker{field, static_cast<T>(0.5 * cell.x), {.surface = kind}};
            BallFriction<T> friction{{T(0.5), T(0.25)}};
            VelocityFilter<T> velocity{T(100)};
            const Damping<T> damping{T(0.5), T(0.25)};
            const ForceEvaluator<T> force{.stiffness = T(50), .max_force = T(3.25)};

            Random random{121};
            double x = low.x, y = low.y, heading = 0;
            int touching = 0, held = 0, clamped = 0, beyond = 0;
            std::vector<vec3<T>> path;
            for (int n = 0; n < 1000; ++n) {
                heading += random.between(-0.5, 0.5);
                x = std::clamp(x + 0.2 * cell.x * std::cos(heading), low.x - 3 * cell.x, high.x + 3 * cell.x);
                y = std::clamp(y + 0.2 * cell.y * std::sin(heading), low.y - 3 * cell.y, high.y + 3 * cell.y);
                const Wide z =
                    *surface.height(Wide(std::clamp(x, low.x, high.x)), Wide(std::clamp(y, low.y, high.y)));
                path.push_back(
                    {static_cast<T>(x), static_cast<T>(y),
                     static_cast<T>(z + Wide(cell.x * (n % 100 == 0 ? 20 : random.between(0.2, 0.6))))});
                if (n % 97 == 50) path.back().y = std::numeric_limits<T>::quiet_NaN();
            }
            const auto before = allocations();
            bool finite = true, within = true;
            for (const auto& at : path) {
                const auto contact = friction.hold(field, shade_force(field, tracker.update(at)), at);
                const auto felt = damping(force, contact, velocity.update(at, T(0.001)));
                touching += contact.touching();
                held += friction.state().side != Side::none && !friction.state().slipping;
                clamped += felt.clamped;
                beyond += contact.touching() && !grid.cells().contains(contact.point.cell);
                finite = finite && is_finite(felt.newtons);
                within = within && glm::length(felt.newtons) <= T(3.25) * (1 + 4 * epsilon<T>);
            }
            const auto after = allocations();
            CAPTURE(scene.name, touching, held, clamped, beyond);
            CHECK(after == before);
            CHECK(finite);
            CHECK(within);
            CHECK(touching > 300);
            CHECK(beyond > 30);
        }
    }
}

TEMPLATE_TEST_CASE("pieces: on level ground with a still hand they change nothing, to the bit", "[pieces]",
                   float, double) {
    using T = TestType;
    const auto ground = plane<T>(9, 9, 0.5);
    const auto grid = ground.grid();
    const ExtendedField field{grid};
    ProxyTracker tracker{field};
    ProxyTracker plain{grid};
    Friction<T> friction{};
    VelocityFilter<T> velocity{};
    const Damping<T> damping{T(2), T(1)};
    const ForceEvaluator<T> force{.max_force = T(3.25)};
    for (const T depth : {T(-1), T(0.001), T(0.001), T(0.001)}) {
        const vec3<T> at{T(3.2), T(4.1), T(0.5) - depth};
        const auto with = damping(force, friction.hold(field, shade_force(field, tracker.update(at)), at),
                                  velocity.velocity());
        const auto without = force(plain.update(at));
        CHECK(with.newtons == without.newtons);
        CHECK(with.clamped == without.clamped);
    }
}
