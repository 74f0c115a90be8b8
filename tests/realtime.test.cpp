#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/scenes.hpp"
#include "support/witness.hpp"

#include <hfh/hfh.hpp>

#include <cstdlib>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

// What a haptic thread may rely on: no allocation, no exception, little memory.

using namespace hfh;
using namespace hfh::test;

TEST_CASE("allocations: the counter sees new, vectors and strings", "[realtime]") {
    // Compilers may leave out an allocation that nobody looks at.
    const void* volatile seen = nullptr;
    const auto before = allocations();
    const auto number = std::make_unique<int>(1);
    seen = number.get();
    const auto after_new = allocations();
    CHECK(after_new > before);
    const auto before_vector = allocations();
    const std::vector<double> numbers(100, 1.0);
    seen = numbers.data();
    const auto after_vector = allocations();
    CHECK(after_vector > before_vector);
    const auto before_string = allocations();
    const std::string text(200, 'x');
    seen = text.data();
    const auto after_string = allocations();
    CHECK(after_string > before_string);
    CHECK(seen != nullptr);
}

#if defined(HFH_TEST_ADDRESS_SANITIZER) || defined(__GLIBC__)
TEST_CASE("allocations: the counter sees malloc", "[realtime]") {
    void* (*volatile allocate)(std::size_t) = &std::malloc;
    const auto before = allocations();
    void* const block = allocate(64);
    const auto after = allocations();
    std::free(block);
    CHECK(after == before + 1);
}
#endif

TEMPLATE_TEST_CASE("ProxyTracker: update and force allocate nothing, in any state", "[realtime]", float,
                   double) {
    using T = TestType;
    const ForceEvaluator<T> force{.max_force = T(3.25)};
    for (auto& scene : scenes<T>()) {
        for (const bool holes : {false, true}) {
            if (holes) punch_holes(scene.terrain, 24, 61);
            const auto grid = scene.terrain.grid();
            for (const auto surface : {SurfaceKind::solid, SurfaceKind::sheet}) {
                ProxyTracker tracker{grid, {.surface = surface}};
                Hand<T> hand{scene.terrain, 62};
                std::vector<vec3<T>> path;
                for (int n = 0; n < 2000; ++n) path.push_back(hand.next());
                path.push_back(vec3<T>{std::numeric_limits<T>::quiet_NaN()});
                vec3<T> sum{T(0)};
                int touching = 0;
                const auto before = allocations();
                for (const auto& stylus : path) {
                    const auto contact = tracker.update(stylus);
                    touching += contact.touching();
                    sum += force(contact).newtons;
                }
                const auto after = allocations();
                CAPTURE(scene.name, sum.z);
                CHECK(after == before);
                CHECK(touching > 100);
            }
        }
    }
}

TEMPLATE_TEST_CASE("hfh: nothing on the way of an update can throw", "[realtime]", float, double) {
    using T = TestType;
    using Grid = typename Terrain<T>::Grid;
    using Tracker = ProxyTracker<Grid>;
    using Place = vec3<PlaceScalar<T>>;
    // The arguments are not made here, for GLM does not mark its constructors.
    static_assert(noexcept(std::declval<Tracker&>().update(std::declval<const vec3<T>&>())));
    static_assert(noexcept(std::declval<Tracker&>().reset()));
    static_assert(noexcept(std::declval<Tracker&>().restore(std::declval<const typename Tracker::State&>())));
    static_assert(noexcept(std::declval<const Tracker&>().state()));
    static_assert(noexcept(std::declval<const ForceEvaluator<T>&>()(std::declval<const Contact<T>&>())));
    static_assert(noexcept(std::declval<const Grid&>().patch(std::declval<const Cell&>())));
    static_assert(noexcept(
        newton_closest_point(std::declval<const BilinearPatch<T>&>(), std::declval<const CellPoint<T>&>(),
                             std::declval<const vec2<T>&>(), std::declval<const NewtonOptions&>())));
    static_assert(noexcept(descend(std::declval<const Grid&>(), std::declval<const vec3<T>&>(),
                                   std::declval<const SurfacePoint<T>&>(), 1)));
    static_assert(noexcept(first_hit(std::declval<const Grid&>(), std::declval<const Place&>(),
                                     std::declval<const Place&>(),
                                     std::declval<const BasicFirstHitOptions<PlaceScalar<T>>&>())));
    SUCCEED();
}

TEMPLATE_TEST_CASE("ProxyTracker: its state takes no more than 192 bytes, the rest three pointers",
                   "[realtime]", float, double) {
    using T = TestType;
    using Tracker = ProxyTracker<typename Terrain<T>::Grid>;
    using State = typename Tracker::State;
    static_assert(std::is_trivially_copyable_v<State>);
    static_assert(std::is_trivially_copyable_v<Tracker>);
    CHECK(sizeof(State) <= 192);
    CHECK(sizeof(Tracker) <= sizeof(State) + 3 * sizeof(void*));
}

TEMPLATE_TEST_CASE("ProxyTracker: its work is bounded by what it was allowed", "[realtime]", float, double) {
    using T = TestType;
    // The worst a hand can do to the roughest ground: from anywhere to anywhere, at any depth.
    const auto ground = rough<T>(257, 257, 8, 63);
    const auto grid = ground.grid();
    for (const int limit : {64, 1024}) {
        ProxyTracker tracker{grid, {.max_patches = limit}};
        Random random{64};
        int most = 0;
        for (int n = 0; n < 5000; ++n) {
            const auto contact = tracker.update({static_cast<T>(random.between(0, 256)),
                                                 static_cast<T>(random.between(0, 256)),
                                                 static_cast<T>(random.between(-20, 12))});
            most = std::max(most, contact.patches);
        }
        CAPTURE(limit, most);
        CHECK(most <= limit + 16); // those that meet at the last point are looked at together
    }
}
