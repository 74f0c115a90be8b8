#include "catch.hpp"
#include "support/reference.hpp"

#include <hfh/force/force_evaluator.hpp>

#include <type_traits>
#include <utility>

using namespace hfh;
using namespace hfh::test;

namespace {

template <Real T>
Contact<T> contact(const vec3<T>& penetration, ContactStatus status = ContactStatus::contact) {
    Contact<T> c;
    c.status = status;
    c.side = Side::above;
    c.proxy = {T(1), T(2), T(3)};
    c.penetration = penetration;
    c.depth = static_cast<T>(length(wide(penetration)));
    return c;
}

} // namespace

TEMPLATE_TEST_CASE("ForceEvaluator: the force is stiffness times penetration", "[force_evaluator][law]",
                   float, double) {
    using T = TestType;
    Random random{51};
    for (int n = 0; n < 1000; ++n) {
        const auto c =
            contact<T>({static_cast<T>(random.between(-1, 1)), static_cast<T>(random.between(-1, 1)),
                        static_cast<T>(random.between(-1, 1))});
        const T stiffness = static_cast<T>(random.between(0, 5000));
        const auto force = ForceEvaluator<T>{.stiffness = stiffness}(c);
        CHECK(force.newtons == stiffness * c.penetration); // to the bit
        CHECK_FALSE(force.clamped);
    }
}

TEMPLATE_TEST_CASE("ForceEvaluator: beyond the device's maximum the force keeps its direction and says so",
                   "[force_evaluator][law]", float, double) {
    using T = TestType;
    Random random{52};
    const ForceEvaluator<T> evaluate{.stiffness = T(500), .max_force = T(3.25)};
    for (int n = 0; n < 1000; ++n) {
        const auto c =
            contact<T>({static_cast<T>(random.between(-1, 1)), static_cast<T>(random.between(-1, 1)),
                        static_cast<T>(random.between(-1, 1))});
        const auto force = evaluate(c);
        const Wide size = length(wide(force.newtons)), wanted = 500 * length(wide(c.penetration));
        // A product, a quotient and a length: four roundings.
        const Wide tolerance = 4 * static_cast<Wide>(epsilon<T>);
        const bool clamped = wanted > 3.25L;
        CHECK(force.clamped == clamped);
        CHECK(std::abs(size - std::min(wanted, 3.25L)) <= tolerance * 3.25L);
        const Point off = {wide(force.newtons).x / size - wide(c.penetration).x * 500 / wanted,
                           wide(force.newtons).y / size - wide(c.penetration).y * 500 / wanted,
                           wide(force.newtons).z / size - wide(c.penetration).z * 500 / wanted};
        CHECK(length(off) <= tolerance);
    }
}

TEMPLATE_TEST_CASE("ForceEvaluator: at the maximum exactly nothing is cut", "[force_evaluator]", float,
                   double) {
    using T = TestType;
    const ForceEvaluator<T> evaluate{.stiffness = T(100), .max_force = T(50)};
    const auto at = evaluate(contact<T>({T(0), T(0), T(0.5)}));
    CHECK_FALSE(at.clamped);
    CHECK(at.newtons == vec3<T>{T(0), T(0), T(50)});
    const auto above = evaluate(contact<T>({T(0), T(0), std::nextafter(T(0.5), T(1))}));
    CHECK(above.clamped);
    CHECK(std::abs(above.newtons.z - T(50)) <= 50 * 2 * epsilon<T>);
}

TEMPLATE_TEST_CASE("ForceEvaluator: without contact there is no force, whatever the numbers say",
                   "[force_evaluator]", float, double) {
    using T = TestType;
    const ForceEvaluator<T> evaluate{};
    for (const auto status :
         {ContactStatus::free, ContactStatus::sweep_limit, ContactStatus::buried, ContactStatus::off_surface,
          ContactStatus::left_at_border, ContactStatus::left_at_hole, ContactStatus::bad_input}) {
        CAPTURE(to_string(status));
        const auto force = evaluate(contact<T>({T(1), T(2), T(3)}, status));
        CHECK(force.newtons == vec3<T>{T(0)});
        CHECK_FALSE(force.clamped);
    }
    CHECK(evaluate(contact<T>({T(0), T(0), T(1)}, ContactStatus::descent_limit)).newtons.z == T(500));
    CHECK(evaluate(Contact<T>{}).newtons == vec3<T>{T(0)});
    CHECK(evaluate(contact<T>({T(0), T(0), T(0)})).newtons == vec3<T>{T(0)});
}

TEMPLATE_TEST_CASE("ForceEvaluator: never gives a force that is not finite or above the maximum",
                   "[force_evaluator][hard]", float, double) {
    using T = TestType;
    const T nan = std::numeric_limits<T>::quiet_NaN(), inf = std::numeric_limits<T>::infinity();
    const T huge = std::numeric_limits<T>::max(), tiny = std::numeric_limits<T>::denorm_min();
    for (const T stiffness : {T(0), T(500), huge, inf, nan, tiny}) {
        for (const T maximum : {T(0), T(3.25), huge}) {
            const ForceEvaluator<T> evaluate{.stiffness = stiffness, .max_force = maximum};
            for (const T depth : {T(0), tiny, T(0.5), std::sqrt(huge), huge / 2, huge, inf, nan}) {
                auto c = contact<T>({T(0), T(0), depth});
                c.depth = depth;
                const auto force = evaluate(c);
                CAPTURE(stiffness, maximum, depth);
                CHECK(is_finite(force.newtons));
                CHECK(std::abs(force.newtons.z) <= maximum);
            }
        }
    }
}

TEMPLATE_TEST_CASE("ForceEvaluator: with a maximum that cannot be kept there is no force",
                   "[force_evaluator][hard]", float, double) {
    using T = TestType;
    const T nan = std::numeric_limits<T>::quiet_NaN(), inf = std::numeric_limits<T>::infinity();
    for (const T maximum : {nan, -nan, T(-1), -inf, -std::numeric_limits<T>::denorm_min()}) {
        const ForceEvaluator<T> evaluate{.stiffness = T(500), .max_force = maximum};
        CAPTURE(maximum);
        CHECK(evaluate(contact<T>({T(0), T(0), T(0.5)})).newtons == vec3<T>{T(0)});
    }
    const ForceEvaluator<T> unlimited{.stiffness = T(500), .max_force = inf};
    CHECK(unlimited(contact<T>({T(0), T(0), T(0.5)})).newtons == vec3<T>{0, 0, T(250)});
    CHECK_FALSE(unlimited(contact<T>({T(0), T(0), T(0.5)})).clamped);
}

TEMPLATE_TEST_CASE(
    "ForceEvaluator: with a stiffness below zero or not finite there is no force, and so no pull",
    "[force_evaluator][hard]", float, double) {
    using T = TestType;
    const T nan = std::numeric_limits<T>::quiet_NaN(), inf = std::numeric_limits<T>::infinity();
    // A stiffness of −500 once pulled into the ground, without a limit.
    for (const T stiffness : {T(-500), -std::numeric_limits<T>::denorm_min(),
                              std::numeric_limits<T>::lowest(), nan, -nan, inf, -inf, -T(0)}) {
        for (const T maximum : {T(0), T(3.3), std::numeric_limits<T>::max(), inf}) {
            const ForceEvaluator<T> evaluate{.stiffness = stiffness, .max_force = maximum};
            const auto force = evaluate(contact<T>({T(0.25), T(0), T(0.5)}));
            CAPTURE(stiffness, maximum);
            CHECK(force.newtons == vec3<T>{T(0)});
            CHECK_FALSE(force.clamped);
        }
    }
}

TEST_CASE("ForceEvaluator: is a plain value without state", "[force_evaluator]") {
    static_assert(std::is_trivially_copyable_v<ForceEvaluator<double>> &&
                  std::is_aggregate_v<ForceEvaluator<float>>);
    static_assert(
        noexcept(std::declval<const ForceEvaluator<double>&>()(std::declval<const Contact<double>&>())));
    constexpr auto force = [] {
        Contact<double> c;
        c.status = ContactStatus::contact;
        c.penetration.z = c.depth = 0.25;
        return ForceEvaluator<double>{.stiffness = 8}(c);
    };
    CHECK(force().newtons.z == 2.0);
}
