#include "catch.hpp"
#include "support/terrains.hpp"

#include <height_field_proxy.hpp>

#include <hfh/force/force_evaluator.hpp>

#include <cmath>

using namespace hfh;
using namespace hfh::test;
using chai3d::cVector3d;

namespace {

/// A haptic point on hills, and what is needed around it.
struct Stage {
    Terrain<double> ground = hills<double>(40, 40, 2, 12);
    Terrain<double>::Grid grid = ground.grid();
    chai3d::cWorld world;
    chai3d::cGenericObject object;
    chai3d::cHapticPoint point;
    hfh_chai3d::HeightFieldProxy<Terrain<double>::Grid>* proxy = nullptr;

    explicit Stage(double radius = 0) {
        object.m_material->setStiffness(100);
        point.m_algorithmFingerProxy->initialize(&world, {0, 0, 50});
        point.setRadius(radius);
        proxy = &hfh_chai3d::feel(point, grid, object);
    }
    cVector3d move(const cVector3d& to) { return point.m_algorithmFingerProxy->computeForces(to, {}); }
};

vec3<double> on_path(int n) { return {8 + 0.02 * n, 10 + 0.01 * n, n == 0 ? 5 : -1.5 + std::sin(0.01 * n)}; }

bool is_near(const cVector3d& a, const cVector3d& b, double tolerance) {
    return (a - b).length() <= tolerance;
}

/// 30° about z, then 50° about x.
chai3d::cMatrix3d turned() {
    const double c = std::cos(0.5), s = std::sin(0.5), d = std::cos(0.9), t = std::sin(0.9);
    return {{c, -s, 0}, {d * s, d * c, -t}, {t * s, t * c, d}};
}

} // namespace

TEST_CASE("chai3d: a tool feels what the tracker feels, to the bit", "[chai3d][law]") {
    for (const bool friction : {false, true}) {
        for (const bool shading : {false, true}) {
            Stage stage;
            auto& material = *stage.object.m_material;
            if (friction) material.setStaticFriction(0.5), material.setDynamicFriction(0.3);
            material.setUseHapticShading(shading);
            ProxyTracker tracker{stage.grid, hfh_chai3d::default_options};
            Friction<double> hold{{.at_rest = 0.5, .sliding = 0.3}};
            int touching = 0;
            for (int n = 0; n < 1000; ++n) {
                const auto at = on_path(n);
                auto contact = tracker.update(at);
                if (shading) contact = shade_force(stage.grid, contact);
                if (friction) contact = hold.hold(stage.grid, contact, at);
                const auto wanted = ForceEvaluator<double>{.stiffness = 100}(contact).newtons;
                const auto force = stage.move(hfh_chai3d::to_chai3d(at));
                REQUIRE(is_near(force, hfh_chai3d::to_chai3d(wanted), 1e-12));
                REQUIRE(stage.proxy->contact().proxy == contact.proxy);
                REQUIRE(is_near(stage.proxy->getProxyGlobalPosition(), hfh_chai3d::to_chai3d(contact.proxy),
                                1e-12));
                REQUIRE(
                    is_near(stage.proxy->getNormalForce() + stage.proxy->getTangentialForce(), force, 1e-12));
                touching += contact.touching();
            }
            CHECK(touching > 300);
        }
    }
}

TEST_CASE("chai3d: the tool's contacts are there to be asked for", "[chai3d]") {
    Stage stage;
    chai3d::cGenericObject other;
    (void)stage.move({20, 20, 5});
    CHECK_FALSE(stage.point.isInContact(&stage.object));
    CHECK(stage.proxy->getNumCollisionEvents() == 0);
    CHECK(stage.proxy->getProxyGlobalPosition().z() == 5);
    (void)stage.move({20, 20, -3});
    CHECK(stage.point.isInContact(&stage.object));
    CHECK_FALSE(stage.point.isInContact(&other));
    CHECK(stage.proxy->getNumCollisionEvents() == 1);
    const auto& event = *stage.proxy->m_collisionEvents[0];
    CHECK(is_near(event.m_globalPos, stage.proxy->getProxyGlobalPosition(), 0));
    CHECK(std::abs(event.m_globalNormal.length() - 1) < 1e-12);
    (void)stage.move({20, 20, 5});
    CHECK_FALSE(stage.point.isInContact(&stage.object));
    CHECK(stage.move({20, 20, 5}).length() == 0);
}

TEST_CASE("chai3d: ground that was moved and turned is felt the same in its own frame", "[chai3d][law]") {
    Stage plain, moved;
    moved.object.setLocalRot(turned());
    moved.object.setLocalPos({3, -7, 11});
    int touching = 0;
    for (int n = 0; n < 1000; ++n) {
        const cVector3d at = hfh_chai3d::to_chai3d(on_path(n));
        const cVector3d force = plain.move(at), other = moved.move(cVector3d{3, -7, 11} + turned() * at);
        REQUIRE(is_near(turned() * force, other, 1e-9));
        REQUIRE(is_near(cVector3d{3, -7, 11} + turned() * plain.proxy->getProxyGlobalPosition(),
                        moved.proxy->getProxyGlobalPosition(), 1e-9));
        touching += force.length() > 0;
    }
    CHECK(touching > 300);
}

TEST_CASE("chai3d: ground that rises under a tool at rest meets it", "[chai3d]") {
    Stage stage;
    (void)stage.move({20, 20, 2});
    double last = 0;
    for (int n = 0; n <= 100; ++n) {
        stage.object.setLocalPos({0, 0, 0.05 * n});
        const double force = stage.move({20, 20, 2}).z();
        CHECK(force >= last - 1e-9);
        last = force;
    }
    CHECK(last > 100);
}

TEST_CASE("chai3d: a reset tool begins anew", "[chai3d]") {
    Stage stage;
    for (const bool by_reset : {true, false}) {
        (void)stage.move({20, 20, 5});
        CHECK(stage.move({20, 20, -2}).length() > 0);
        if (by_reset) {
            stage.proxy->reset();
        } else {
            stage.proxy->initialize(&stage.world, {20, 20, -2});
        }
        // Below the ground, and nobody came from above.
        CHECK(stage.move({20, 20, -2}).length() == 0);
        CHECK(stage.proxy->getProxyGlobalPosition().z() == -2);
    }
    // To another place, through the ground and without contact.
    (void)stage.move({20, 20, 5});
    stage.proxy->initialize(&stage.world, {20, 20, -50});
    CHECK(stage.move({20, 20, -50}).length() == 0);
}

TEST_CASE("chai3d: the material acts live", "[chai3d]") {
    Stage stage;
    (void)stage.move({20, 20, 5});
    const double soft = stage.move({20, 20, -2}).length();
    stage.object.m_material->setStiffness(300);
    const double hard = stage.move({20, 20, -2}).length();
    CHECK(std::abs(hard - 3 * soft) <= 1e-9 * hard);

    const auto before = stage.proxy->getProxyGlobalPosition();
    (void)stage.move({20.1, 20, -2});
    const double slid = (stage.proxy->getProxyGlobalPosition() - before).length();
    CHECK(slid > 0.01);
    stage.object.m_material->setStaticFriction(5);
    stage.object.m_material->setDynamicFriction(5);
    (void)stage.move({20.1, 20, -2});
    const auto held = stage.proxy->getProxyGlobalPosition();
    (void)stage.move({20.2, 20, -2});
    CHECK(is_near(stage.proxy->getProxyGlobalPosition(), held, 1e-12));
    stage.object.m_material->setUseHapticFriction(false);
    (void)stage.move({20.2, 20, -2});
    CHECK_FALSE(is_near(stage.proxy->getProxyGlobalPosition(), held, 0.01));
}

TEST_CASE("chai3d: the tip's radius is that of the tool, and may change while it touches", "[chai3d]") {
    Stage stage{0.5};
    CHECK(stage.proxy->getProxyRadius() == 0.5);
    for (auto& height : stage.ground.heights) height = 1; // level
    (void)stage.move({20, 20, 5});
    CHECK(stage.move({20, 20, 1.6}).length() == 0);
    CHECK(std::abs(stage.move({20, 20, 1.2}).z() - 30) < 1e-6);
    CHECK(std::abs(stage.proxy->getProxyGlobalPosition().z() - 1.5) < 1e-9); // the sphere is on the ground
    stage.point.setRadius(0.8);
    CHECK(std::abs(stage.move({20, 20, 1.2}).z() - 60) < 1e-6);
    stage.point.setRadius(0);
    CHECK(stage.move({20, 20, 1.2}).length() == 0);
    CHECK(std::abs(stage.move({20, 20, 0.9}).z() - 10) < 1e-9);
    stage.point.setRadius(0.2);
    CHECK(std::abs(stage.move({20, 20, 0.9}).z() - 30) < 1e-6);
    CHECK(stage.point.isInContact(&stage.object));
}

TEST_CASE("chai3d: an object that is switched off is not felt", "[chai3d]") {
    Stage stage;
    for (const bool by_haptics : {true, false}) {
        (void)stage.move({20, 20, 5});
        CHECK(stage.move({20, 20, -2}).length() > 0);
        if (by_haptics) stage.object.setHapticEnabled(false);
        if (!by_haptics) stage.object.setEnabled(false);
        CHECK(stage.move({20, 20, -2}).length() == 0);
        CHECK_FALSE(stage.point.isInContact(&stage.object));
        stage.object.setHapticEnabled(true), stage.object.setEnabled(true);
        CHECK(stage.move({20, 20, -2}).length() == 0); // from above first
    }
}

TEST_CASE("chai3d: a position that is no number gives no force, and the next one goes on", "[chai3d]") {
    Stage stage;
    (void)stage.move({20, 20, 5});
    const double force = stage.move({20, 20, -2}).length();
    const auto proxy = stage.proxy->getProxyGlobalPosition();
    CHECK(stage.move({20, hidden_nan<double>(), -2}).length() == 0);
    CHECK(is_near(stage.proxy->getProxyGlobalPosition(), proxy, 0));
    CHECK(stage.move({20, 20, -2}).length() == force);
}

TEST_CASE("chai3d: feel() replaces a proxy and deletes it", "[chai3d]") {
    const int before = chai3d::cAlgorithmFingerProxy::destroyed;
    {
        Stage stage{0.25};
        CHECK(chai3d::cAlgorithmFingerProxy::destroyed == before + 1);
        CHECK(stage.point.m_algorithmFingerProxy == stage.proxy);
        CHECK(stage.proxy->getWorld() == &stage.world);
        CHECK(stage.proxy->getDeviceGlobalPosition().z() == 50);
    }
    CHECK(chai3d::cAlgorithmFingerProxy::destroyed == before + 2);
}

TEST_CASE("chai3d: an object with effects tells where its surface is, tool by tool", "[chai3d]") {
    const auto ground = hills<double>(40, 40, 2, 12);
    const auto grid = ground.grid();
    hfh_chai3d::HeightFieldObject object{grid};
    ProxyTracker first{grid, hfh_chai3d::default_options}, second{grid, hfh_chai3d::default_options};
    int touching = 0;
    for (int n = 0; n < 1000; ++n) {
        const auto at = on_path(n), other = at + vec3<double>{5, 3, 1};
        const auto check = [&](unsigned tool, ProxyTracker<Terrain<double>::Grid>& tracker,
                               const vec3<double>& stylus) {
            const auto contact = tracker.update(stylus);
            object.computeLocalInteraction(hfh_chai3d::to_chai3d(stylus), {}, tool);
            REQUIRE(object.m_interactionInside == contact.touching());
            REQUIRE(is_near(object.m_interactionPoint, hfh_chai3d::to_chai3d(contact.proxy), 1e-12));
            REQUIRE(is_near(object.m_interactionNormal, hfh_chai3d::to_chai3d(contact.normal), 0));
            touching += contact.touching();
        };
        check(0, first, at);
        check(15, second, other);
    }
    CHECK(touching > 300);
    object.computeLocalInteraction({20, 20, -1}, {}, 16); // more tools than CHAI3D allows
    CHECK_FALSE(object.m_interactionInside);
    object.reset();
    object.computeLocalInteraction({20, 20, -1}, {}, 0); // starts below
    CHECK_FALSE(object.m_interactionInside);
}
