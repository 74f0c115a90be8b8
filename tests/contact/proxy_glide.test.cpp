#include "catch.hpp"
#include "support/hard_ground.hpp"
#include "support/limited_work.hpp"
#include "support/reference.hpp"
#include "support/scenes.hpp"

#include <hfh/contact/friction.hpp>
#include <hfh/contact/proxy_glide.hpp>
#include <hfh/loop/haptic_loop.hpp>

#include <type_traits>

using namespace hfh;
using namespace hfh::test;

namespace {

template <Real T>
bool same(const Contact<T>& a, const Contact<T>& b) {
    return a.status == b.status && a.side == b.side && a.proxy == b.proxy && a.normal == b.normal &&
           a.penetration == b.penetration && a.depth == b.depth && a.point.cell == b.point.cell &&
           a.point.u == b.point.u && a.point.v == b.point.v;
}

/// A tracker, and what a glide makes of its contacts, judged by the heights.
template <Real T>
class GlideWitness {
public:
    GlideWitness(const Terrain<T>& terrain, double speed, const TrackerOptions& options)
        : surface_{terrain}, grid_{terrain.grid()}, tracker_{grid_, options}, glide_{speed}, speed_{speed} {}
    GlideWitness(const GlideWitness&) = delete;
    GlideWitness& operator=(const GlideWitness&) = delete;

    int updates = 0, under_way = 0, jumps = 0;

    Contact<T> update(const vec3<T>& stylus) {
        tracked_ = tracker_.update(stylus);
        const auto contact = glide_.follow(grid_, tracked_, stylus);
        judge(contact, stylus);
        before_ = contact;
        stylus_ = stylus;
        ++updates;
        return contact;
    }
    [[nodiscard]] const Contact<T>& tracked() const { return tracked_; }
    [[nodiscard]] bool is_under_way() const { return glide_.state().is_under_way; }

private:
    void judge(const Contact<T>& c, const vec3<T>& stylus) {
        // Felt when the tracker's contact is.
        REQUIRE(c.touching() == tracked_.touching());
        REQUIRE((c.depth > 0) == (tracked_.depth > 0));
        REQUIRE(c.side == tracked_.side);
        const bool glides = is_under_way();
        under_way += glides;
        if (!glides) REQUIRE(same(c, tracked_));
        if (!c.touching()) return;
        const Point proxy = surface_.position(wide(c.point)), q = wide(stylus), offset = proxy - q;
        const Wide eps = static_cast<Wide>(epsilon<T>);
        const Wide blur = 64 * eps *
                          (length(q) + length(proxy) + length(offset) +
                           surface_.patch(c.point.cell.i, c.point.cell.j)->reach({}));
        if (glides) {
            REQUIRE(c.status == ContactStatus::descent_limit);
            REQUIRE(length(wide(c.penetration) - offset) <= blur);
            REQUIRE(length(wide(c.proxy) - proxy) <= blur);
        }
        if (!(before_.depth > 0) || before_.side != c.side) return;
        const Point last = surface_.position(wide(before_.point));
        const Wide moved = length(proxy - last),
                   allowed = static_cast<Wide>(speed_) + length(q - wide(stylus_));
        if (glides) {
            // A step may be 2⁻¹² cells long: then its slope bounds it.
            REQUIRE(moved <= allowed + blur);
            REQUIRE(length(offset) <= length(last - q) + blur);
        } else {
            jumps += moved > allowed + blur;
        }
    }

    const Surface<T> surface_;
    const typename Terrain<T>::Grid grid_;
    ProxyTracker<typename Terrain<T>::Grid> tracker_;
    ProxyGlide<T> glide_;
    double speed_;
    Contact<T> tracked_{}, before_{};
    vec3<T> stylus_{T(0)};
};

/// A way over a terrain, in steps of 0.2 cells, that turns at random and back from the border.
template <Real T>
class Wandering {
public:
    explicit Wandering(const Terrain<T>& terrain)
        : low_{terrain.low()}, high_{terrain.high()}, cell_{terrain.frame.spacing}, at_{low_ + 5.0 * cell_} {}

    [[nodiscard]] glm::dvec2 next(Random& random) {
        heading_ += random.between(-0.4, 0.4);
        at_.x = std::clamp(at_.x + 0.2 * cell_.x * std::cos(heading_), low_.x + cell_.x, high_.x - cell_.x);
        at_.y = std::clamp(at_.y + 0.2 * cell_.y * std::sin(heading_), low_.y + cell_.y, high_.y - cell_.y);
        if (at_.x < low_.x + 2 * cell_.x || at_.x > high_.x - 2 * cell_.x) heading_ = 3.14159 - heading_;
        if (at_.y < low_.y + 2 * cell_.y || at_.y > high_.y - 2 * cell_.y) heading_ = -heading_;
        return at_;
    }

private:
    const glm::dvec2 low_, high_, cell_;
    glm::dvec2 at_;
    double heading_ = 0;
};

} // namespace

TEMPLATE_TEST_CASE(
    "ProxyGlide: where a ridge lets go it moves by its speed, and arrives at the tracker's proxy",
    "[proxy_glide]", float, double) {
    using T = TestType;
    // A ridge along x = 20, steep on this side and gentle on the other. The stylus goes on below it until the near face does
    // not hold it any more, and rests there.
    const auto ground =
        terrain<T>(41, 9, [](Index i, Index) { return i < 20 ? double(i) - 20 : 5 - 0.25 * double(i); });
    for (const double speed : {0.0625, 0.25, 1.0}) {
        GlideWitness<T> witness{ground, speed, {}};
        static_cast<void>(witness.update({T(15), T(4.25), T(5)}));
        T x = 17;
        for (; !witness.is_under_way(); x += T(0.03125)) {
            REQUIRE(x < 28);
            static_cast<void>(witness.update({x, T(4.25), T(-4)}));
        }
        x -= T(0.03125);
        Contact<T> contact;
        int updates = 0;
        do {
            contact = witness.update({x, T(4.25), T(-4)});
            REQUIRE(contact.depth > 0);
        } while (witness.is_under_way() && ++updates < 100000);
        CHECK(same(contact, witness.tracked()));
        CHECK(witness.jumps == 0);
        // From the ridge down the other face, to the foot of the stylus.
        const double way = 5;
        CHECK(updates >= 3);
        CHECK(updates <= way / speed + 1);
    }
}

TEMPLATE_TEST_CASE("ProxyGlide: never faster than its speed, never farther, felt as the tracker's contact is",
                   "[proxy_glide][law]", float, double) {
    using T = TestType;
    Random random{201};
    int under_way = 0, updates = 0, jumps = 0, rests = 0;
    for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
        for (const int limit : {8192, 8}) {
            for (const auto& scene : scenes<T>()) {
                const Surface<T> surface{scene.terrain};
                const double cell = scene.terrain.frame.spacing.x;
                GlideWitness<T> witness{
                    scene.terrain, 0.3 * cell, {.surface = kind, .max_contact_patches = limit}};
                Wandering<T> wandering{scene.terrain};
                for (int n = 0; n < 300; ++n) {
                    const glm::dvec2 on = wandering.next(random);
                    const auto z = static_cast<double>(*surface.height(Wide(on.x), Wide(on.y)));
                    const vec3<T> at{static_cast<T>(on.x), static_cast<T>(on.y),
                                     static_cast<T>(z + (n == 0 ? 30 * cell : -3 * cell))};
                    static_cast<void>(witness.update(at));
                    if (!witness.is_under_way() || !random.one_in(4)) continue;
                    ++rests; // the hand rests: it gets to the tracker's proxy
                    for (int k = 0; witness.is_under_way() && k < 2000; ++k)
                        static_cast<void>(witness.update(at));
                    REQUIRE_FALSE(witness.is_under_way());
                    const auto once = witness.update(at);
                    REQUIRE(same(once, witness.tracked()));
                }
                under_way += witness.under_way, updates += witness.updates, jumps += witness.jumps;
            }
        }
    }
    CAPTURE(under_way, updates, jumps, rests);
    CHECK(under_way > 500);
    CHECK(rests > 20);
    CHECK(jumps * 100 < updates); // its slide ended elsewhere than the tracker's
}

TEMPLATE_TEST_CASE("ProxyGlide: without a speed that is one it changes nothing", "[proxy_glide]", float,
                   double) {
    using T = TestType;
    const auto ground = hills<T>(24, 20, 8, 6);
    const auto grid = ground.grid();
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double speed : {std::numeric_limits<double>::max(), 0.0, -1.0, nan}) {
        ProxyTracker tracker{grid};
        ProxyGlide<T> glide{speed};
        for (int n = 0; n < 200; ++n) {
            const vec3<T> at{T(3) + T(n) / 16, T(9), T(n == 0 ? 20 : -6)};
            const auto contact = tracker.update(at);
            REQUIRE(same(glide.follow(grid, contact, at), contact));
        }
    }
    static_assert(std::is_trivially_copyable_v<GlideState<T>>);
}

TEMPLATE_TEST_CASE("ProxyGlide: on hard ground and with any limits it is bounded, felt and gets there",
                   "[proxy_glide][law]", float, double) {
    using T = TestType;
    Random random{202};
    for (int n = 0; n < 60; ++n) {
        const auto kind = static_cast<HardGround>(n % (static_cast<int>(HardGround::crease) + 1));
        const auto ground = hard_ground<T>(kind, random);
        if (!without_holes(ground)) continue;
        const TrackerOptions options{.max_patches = any_limit(random),
                                     .max_contact_patches = any_limit(random)};
        const auto grid = ground.grid();
        const double speed = longest_patch(ground) / static_cast<double>(random.whole(1, 16));
        ProxyTracker tracker{grid, options};
        ProxyGlide<T> glide{speed, 100};
        const glm::dvec2 low = ground.low(), size = ground.high() - low;
        for (int k = 0; k < 40; ++k) {
            const vec3<T> at{
                static_cast<T>(low.x + size.x * random.between(0.1, 0.9)),
                static_cast<T>(low.y + size.y * random.between(0.1, 0.9)),
                static_cast<T>(k == 0 ? 2 * longest_patch(ground) : -longest_patch(ground) * random.unit())};
            for (int rest = 0; rest < (k % 8 == 0 ? 3000 : 2); ++rest) {
                const auto tracked = tracker.update(at);
                const auto c = glide.follow(grid, tracked, at);
                REQUIRE(c.touching() == tracked.touching());
                REQUIRE((c.depth > 0) == (tracked.depth > 0));
                REQUIRE(c.patches <= tracked.patches + 116);
                if (rest == 2999) REQUIRE_FALSE(glide.state().is_under_way);
            }
        }
    }
}

TEST_CASE("HapticLoop: a release speed at the hand is the same at every scale",
          "[proxy_glide][haptic_loop]") {
    // The same ground in a hand of millimetres and in one of metres: what the hand feels differs by roundings.
    std::vector<glm::dvec3> felt[2];
    int under_way = 0;
    for (const int k : {0, 1}) {
        const double scale = k == 0 ? 1000 : 8000;
        auto ground = hills<double>(40, 40, 3 * scale / 1000, 6);
        ground.frame.spacing = glm::dvec2{scale / 1000};
        const auto grid = ground.grid();
        HapticLoop loop{
            grid,
            {.workspace = {.scale = scale, .offset = {20 * scale / 1000, 20 * scale / 1000, 0}},
             .limits = {.max_force = 8, .max_slew = 100, .ramp = 0, .stiffness = 1000, .max_step = 0.01},
             .tracker = {},
             .release_speed = 0.2e-3,
             .lag = 0}};
        for (int n = 0; n < 400; ++n) {
            const double x = -0.01 + 0.05e-3 * n;
            static_cast<void>(
                loop.update({.time = 0.001 * n, .position = {x, 0.1 * x, n == 0 ? 0.01 : -0.005}}));
            felt[k].push_back(loop.asked());
            under_way += loop.glide().state().is_under_way;
        }
    }
    for (std::size_t n = 0; n < felt[0].size(); ++n) REQUIRE(glm::distance(felt[0][n], felt[1][n]) <= 1e-6);
    CHECK(under_way > 20);
}
