#include "catch.hpp"
#include "support/reference.hpp"
#include "support/scenes.hpp"

#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/damping.hpp>

#include <type_traits>
#include <utility>

using namespace hfh;
using namespace hfh::test;

namespace {

constexpr Wide pi = 3.14159265358979323846L;

template <Real T>
vec3<T> random_vector(Random& random, double size) {
    return {static_cast<T>(random.between(-size, size)), static_cast<T>(random.between(-size, size)),
            static_cast<T>(random.between(-size, size))};
}

/// A contact that pushes out along its normal, tilted as at a crease or by friction; at a bad crease, against it.
template <Real T>
Contact<T> random_contact(Random& random) {
    Contact<T> c;
    c.status = ContactStatus::contact;
    c.side = Side::above;
    const vec3<T> n = random_vector<T>(random, 1) + vec3<T>{T(0), T(0), T(1.5)};
    c.normal = n / glm::length(n);
    const T depth = static_cast<T>(std::pow(10.0, random.between(-6, -2)));
    c.penetration = depth * (c.normal + random_vector<T>(random, random.one_in(4) ? 3.0 : 0.3));
    c.depth = glm::length(c.penetration);
    return c;
}

Point times(Wide k, const Point& a) { return {k * a.x, k * a.y, k * a.z}; }
Point plus(const Point& a, const Point& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }

} // namespace

TEMPLATE_TEST_CASE("VelocityFilter: follows a ramp as the formula says, and meets it in the end", "[damping]",
                   float, double) {
    using T = TestType;
    for (const double cutoff : {5.0, 50.0, 200.0}) {
        VelocityFilter<T> filter{static_cast<T>(cutoff)};
        const Wide speed = 0.125L, dt = static_cast<Wide>(static_cast<T>(1e-3));
        // A step of the position is a rounding of it, over Δt.
        const Wide tolerance = 4 * static_cast<Wide>(epsilon<T>) * (1 + Wide(0.25L) / dt);
        for (int k = 0; k <= 2000; ++k) {
            const Wide x = speed * dt * k;
            const auto v = filter.update({static_cast<T>(x), static_cast<T>(-x), T(3)}, static_cast<T>(dt));
            const Wide wanted = speed * -std::expm1(-2 * pi * static_cast<Wide>(cutoff) * dt * k);
            REQUIRE(std::abs(static_cast<Wide>(v.x) - wanted) <= tolerance);
            REQUIRE(std::abs(static_cast<Wide>(v.y) + wanted) <= tolerance);
            REQUIRE(v.z == 0);
        }
        CHECK(std::abs(static_cast<Wide>(filter.velocity().x) - speed) <= tolerance);
    }
}

TEST_CASE("VelocityFilter: passes a sine as the low pass it is", "[damping]") {
    // Of x = sin ωt the difference quotient has the amplitude 2 sin(ωΔt/2)/Δt, the low pass 1 − α behind its pole
    // takes α/√(1 − 2(1−α) cos ωΔt + (1−α)²) of it: near 1/√2 at the cut-off.
    const double dt = 1e-3, cutoff = 40;
    for (const double hertz : {1.0, 10.0, 40.0, 150.0, 400.0}) {
        VelocityFilter<double> filter{cutoff};
        const double omega = 2 * double(pi) * hertz, keep = std::exp(-2 * double(pi) * cutoff * dt);
        double energy = 0;
        const int settle = 1000, count = 1000; // whole periods of each
        for (int k = 0; k < settle + count; ++k) {
            const double v = filter.update({0, std::sin(omega * dt * k), 0}, dt).y;
            if (k >= settle) energy += v * v;
        }
        const double amplitude = std::sqrt(2 * energy / count);
        const double wanted = 2 * std::sin(omega * dt / 2) / dt * (1 - keep) /
                              std::sqrt(1 - 2 * keep * std::cos(omega * dt) + keep * keep);
        CHECK(amplitude == Approx(wanted).epsilon(1e-9));
        if (hertz == cutoff) CHECK(amplitude / omega == Approx(std::sqrt(0.5)).epsilon(0.02));
    }
}

TEMPLATE_TEST_CASE("VelocityFilter: gives the same for one long update as for many short ones of a ramp",
                   "[damping]", float, double) {
    using T = TestType;
    VelocityFilter<T> often{T(20)}, seldom{T(20)};
    static_cast<void>(often.update({T(0), T(0), T(0)}, T(0)));
    static_cast<void>(seldom.update({T(0), T(0), T(0)}, T(0)));
    for (int k = 1; k <= 64; ++k) {
        static_cast<void>(often.update({T(k) / 64, T(0), T(0)}, T(1) / 1024));
        if (k % 16 == 0) static_cast<void>(seldom.update({T(k) / 64, T(0), T(0)}, T(16) / 1024));
    }
    CHECK(std::abs(often.velocity().x - seldom.velocity().x) <= 200 * epsilon<T> * 16);
}

TEMPLATE_TEST_CASE("VelocityFilter: starts at zero, ignores repeats, and starts anew after bad numbers",
                   "[damping]", float, double) {
    using T = TestType;
    const T nan = std::numeric_limits<T>::quiet_NaN(), inf = std::numeric_limits<T>::infinity();
    const vec3<T> zero{T(0)};
    VelocityFilter<T> filter{T(0)}; // no filter: the difference itself
    CHECK(filter.update({T(5), T(5), T(5)}, T(0.25)) == zero);
    CHECK(filter.update({T(6), T(5), T(4)}, T(0.25)) == vec3<T>{T(4), T(0), T(-4)});
    CHECK(filter.update({T(9), T(9), T(9)}, T(0)) ==
          vec3<T>{T(4), T(0), T(-4)}); // no time: as if it had not been
    CHECK(filter.update({T(9), T(9), T(9)}, T(-1)) == vec3<T>{T(4), T(0), T(-4)});
    CHECK(filter.update({T(7), T(5), T(4)}, T(0.5)) == vec3<T>{T(2), T(0), T(0)});
    for (const T bad : {nan, inf, -inf}) {
        CHECK(filter.update({T(7), bad, T(4)}, T(0.5)) == zero);
        CHECK(filter.update({T(70), T(0), T(0)}, T(0.5)) == zero);
        CHECK(filter.update({T(71), T(0), T(0)}, T(0.5)) == vec3<T>{T(2), T(0), T(0)});
        CHECK(filter.update({T(72), T(0), T(0)}, bad) == zero);
        CHECK(filter.update({T(7), T(0), T(0)}, T(0.5)) == zero);
        CHECK(filter.update({T(8), T(0), T(0)}, T(0.5)) == vec3<T>{T(2), T(0), T(0)});
    }
    const T huge = std::numeric_limits<T>::max();
    CHECK(filter.update({huge, T(0), T(0)}, T(0.5)) == zero); // the quotient overflows
    CHECK(filter.update({huge, T(0), T(0)}, T(0.5)) == zero);
    for (const T cutoff : {nan, inf, T(-3)}) {
        VelocityFilter<T> none{cutoff};
        static_cast<void>(none.update(zero, T(1)));
        CHECK(none.update({T(1), T(2), T(3)}, T(0.5)) == vec3<T>{T(2), T(4), T(6)});
    }
}

TEMPLATE_TEST_CASE("Damping: takes its coefficients times the velocity from the spring", "[damping][law]",
                   float, double) {
    using T = TestType;
    Random random{61};
    int full = 0, cut_normal = 0, cut_across = 0, clamps = 0;
    for (int n = 0; n < 20000; ++n) {
        const auto c = random_contact<T>(random);
        const vec3<T> v = random_vector<T>(random, std::pow(10.0, random.between(-4, 1)));
        const ForceEvaluator<T> spring{.stiffness = static_cast<T>(random.between(1, 2000)),
                                       .max_force = T(3)};
        const Damping<T> damping{static_cast<T>(random.between(0, 5)), static_cast<T>(random.between(0, 5))};
        const auto force = damping(spring, c, v);

        // The law, in long double.
        const Point normal = wide(c.normal), velocity = wide(v);
        const Point elastic = times(static_cast<Wide>(spring.stiffness), wide(c.penetration));
        const Wide out = dot(velocity, normal), push = dot(elastic, normal), spring_size = length(elastic);
        const Point across = plus(velocity, times(-out, normal));
        const Wide b_n = static_cast<Wide>(damping.along_normal), b_t = static_cast<Wide>(damping.tangential);
        const Wide brake_n = std::min(b_n * std::abs(out), std::max(push, Wide(0)));
        const Wide brake_t = std::min(b_t * length(across), spring_size);
        cut_normal += brake_n < b_n * std::abs(out);
        cut_across += brake_t < b_t * length(across);
        full += brake_n == b_n * std::abs(out) && brake_t == b_t * length(across);
        Point wanted = plus(elastic, times(out > 0 ? -brake_n : brake_n, normal));
        wanted = plus(wanted, times(-brake_t / length(across), across));
        const Wide size = length(wanted),
                   tolerance = 32 * static_cast<Wide>(epsilon<T>) *
                               (spring_size + b_n * length(velocity) + b_t * length(velocity));
        if (size > 3) wanted = times(3 / size, wanted);
        CHECK(length(wide(force.newtons) - wanted) <= tolerance);
        if (std::abs(size - 3) > tolerance) CHECK(force.clamped == (size > 3));
        clamps += force.clamped;

        // Never towards the surface, never beyond the device, never more than the spring in either part.
        CHECK(dot(wide(force.newtons), normal) >= std::min(push, Wide(0)) - tolerance);
        CHECK(length(wide(force.newtons)) <= 3 * (1 + 8 * static_cast<Wide>(epsilon<T>)));
    }
    CHECK(full > 500);
    CHECK(cut_normal > 500);
    CHECK(cut_across > 500);
    CHECK(clamps > 500);
}

TEMPLATE_TEST_CASE("Damping: acts in contact only, and not on numbers that are none", "[damping]", float,
                   double) {
    using T = TestType;
    const T nan = std::numeric_limits<T>::quiet_NaN(), inf = std::numeric_limits<T>::infinity();
    const T huge = std::numeric_limits<T>::max();
    Random random{62};
    const ForceEvaluator<T> spring{.stiffness = T(500), .max_force = T(3.25)};
    const Damping<T> damping{T(2), T(3)};
    const auto same = [&](const Damping<T>& d, const Contact<T>& c, const vec3<T>& v) {
        const auto with = d(spring, c, v), without = spring(c);
        return with.newtons == without.newtons && with.clamped == without.clamped;
    };
    for (int n = 0; n < 200; ++n) {
        auto c = random_contact<T>(random);
        CHECK_FALSE(same(damping, c, {T(0.01), T(0.02), T(0.03)}));
        CHECK(same(damping, c, vec3<T>{T(0)}));
        CHECK(same(Damping<T>{}, c, {T(1), T(2), T(3)}));
        for (const T bad : {nan, inf, -inf, huge, -huge}) {
            CHECK(same(damping, c, {T(0), bad, T(0)}));
            CHECK(same(damping, c, {bad, T(0), bad}));
        }
        for (const T bad : {nan, inf, -inf, T(-1)}) {
            CHECK(same(Damping<T>{bad, T(1)}, c, {T(1), T(0), T(1)}));
            CHECK(same(Damping<T>{T(1), bad}, c, {T(1), T(0), T(1)}));
            const auto bad_spring = ForceEvaluator<T>{.stiffness = bad, .max_force = T(3.25)},
                       bad_limit = ForceEvaluator<T>{.stiffness = T(500), .max_force = bad};
            CHECK(damping(bad_spring, c, {T(1), T(0), T(-1)}).newtons == vec3<T>{T(0)});
            if (bad != inf) CHECK(damping(bad_limit, c, {T(1), T(0), T(-1)}).newtons == vec3<T>{T(0)});
        }
        c.status = ContactStatus::free;
        CHECK(damping(spring, c, {T(1), T(1), T(-1)}).newtons == vec3<T>{T(0)});
        c.status = ContactStatus::bad_input;
        CHECK(damping(spring, c, {T(1), T(1), T(-1)}).newtons == vec3<T>{T(0)});
        c.status = ContactStatus::contact;
        c.depth = T(0);
        c.penetration = vec3<T>{T(0)};
        CHECK(damping(spring, c, {T(1), T(1), T(-1)}).newtons == vec3<T>{T(0)});
    }
}

TEMPLATE_TEST_CASE("Damping: a tap begins without a blow and ends without a pull", "[damping]", float,
                   double) {
    using T = TestType;
    // Down at 0.2 m/s to 2 mm and up again at 0.5 m/s, sliding at 0.3 m/s: the force is continuous but where the velocity
    // jumps, never pulls, and is the plain sum once deep enough.
    const auto ground = plane<T>(9, 9, 0.5, {.spacing = {0.05, 0.05}});
    const auto grid = ground.grid();
    for (const auto surface : {SurfaceKind::solid, SurfaceKind::sheet}) {
        for (const T sign : {T(1), T(-1)}) {
            if (surface == SurfaceKind::solid && sign < 0) continue; // a sheet from below as well
            ProxyTracker tracker{grid, {.surface = surface}};
            const ForceEvaluator<T> spring{.stiffness = T(1000)};
            const Damping<T> damping{T(3), T(1)};
            const double dt = 1e-4;
            vec3<T> before{T(0)};
            double depth = -0.001, speed = 0.2;
            int pressed = 0, plain = 0;
            for (int k = 0; depth > -0.002; ++k) {
                const bool turns = depth >= 0.002;
                if (turns) speed = -0.5;
                depth += speed * dt;
                const vec3<T> at{static_cast<T>(0.1 + 0.3 * dt * k), T(0.2),
                                 T(0.5) - sign * static_cast<T>(depth)};
                const vec3<T> v{T(0.3), T(0), -sign * static_cast<T>(speed)};
                const auto contact = tracker.update(at);
                const auto force = damping(spring, contact, v).newtons;
                const T out = sign * force.z;
                CHECK(out >= 0);
                // The spring changes by k·|v|·dt, and either part of the damping by no more than the spring.
                if (!turns)
                    CHECK(glm::length(force - before) <=
                          T(1.01 * 3 * 1000 * std::abs(speed) * dt) + 2000 * epsilon<T>);
                before = force;
                if (!contact.touching()) continue;
                ++pressed;
                if (depth > 0.0016) {
                    ++plain;
                    CHECK(out == Approx(1000 * depth + 3 * speed).margin(4000 * double(epsilon<T>)));
                    CHECK(force.x == Approx(-0.3).margin(100 * double(epsilon<T>)));
                }
            }
            CHECK(pressed > 100);
            CHECK(plain > 10);
        }
    }
}

TEMPLATE_TEST_CASE("Damping: never pulls on a contact that friction holds back, shaded or not",
                   "[damping][law]", float, double) {
    using T = TestType;
    const ForceEvaluator<T> spring{.stiffness = T(500)};
    const Damping<T> damping{T(20), T(10)};
    for (const bool shaded : {false, true}) {
        int held = 0, off_the_proxy = 0, lifted = 0;
        Random random{44};
        for (const auto& scene : scenes<T>()) {
            const Surface<T> surface{scene.terrain};
            const auto grid = scene.terrain.grid();
            const glm::dvec2 low = scene.terrain.low(), size = scene.terrain.high() - low;
            const double cell = scene.terrain.frame.spacing.x;
            ProxyTracker tracker{grid};
            Friction<T> friction{};
            for (int n = 0; n < 600; ++n) {
                const double s = 0.1 + 0.8 * n / 600.0;
                const T x = static_cast<T>(low.x + s * size.x), y = static_cast<T>(low.y + (1 - s) * size.y);
                const auto z = *surface.height(Wide(x), Wide(y));
                const double above = n % 100 == 0 ? 30 * cell : random.between(-1, 0) * cell;
                const vec3<T> at{x, y, static_cast<T>(z + Wide(above))};
                auto contact = tracker.update(at);
                const bool is_held_back = contact.status == ContactStatus::contact && contact.depth > 0;
                if (shaded) contact = shade_force(grid, contact);
                const auto proxy = contact.point;
                contact = friction.hold(grid, contact, at);
                if (!is_held_back) continue;
                const bool is_off = !(proxy.cell == contact.point.cell && proxy.u == contact.point.u &&
                                      proxy.v == contact.point.v);
                if (!shaded && !is_off) continue; // the tracker's
                ++held;
                off_the_proxy += is_off;
                const vec3<T> velocity = random_vector<T>(random, 0.5);
                const vec3<T> newtons = damping(spring, contact, velocity).newtons;
                const T rounding = 32 * epsilon<T> * spring.stiffness * contact.depth;
                REQUIRE(glm::dot(contact.penetration, contact.normal) >= 0);
                REQUIRE(glm::dot(newtons, contact.normal) >= -rounding);
                lifted += glm::dot(velocity, contact.normal) > 0;
            }
        }
        CAPTURE(shaded, held, off_the_proxy, lifted);
        CHECK(off_the_proxy > 500);
        CHECK(lifted > 200);
    }
}

TEST_CASE("Damping: is a plain value without state", "[damping]") {
    static_assert(std::is_trivially_copyable_v<Damping<double>> && std::is_aggregate_v<Damping<float>>);
    static_assert(std::is_trivially_copyable_v<VelocityFilter<float>>);
    static_assert(noexcept(std::declval<const Damping<double>&>()(
        std::declval<const ForceEvaluator<double>&>(), std::declval<const Contact<double>&>(),
        std::declval<const vec3<double>&>())));
    CHECK(Damping<double>{}.along_normal == 0);
}
