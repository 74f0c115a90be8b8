#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/terrains.hpp"

#include <hfh/loop/any_haptic_loop.hpp>
#include <hfh/loop/ball_tip.hpp>
#include <hfh/loop/haptic_loop.hpp>
#include <hfh/terrain/extended_field.hpp>
#include <hfh/terrain/min_max_pyramid.hpp>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <vector>

using namespace hfh;
using namespace hfh::test;

// The loop has no logic of its own: it is the chain that README and the examples used to write, to the bit.

using Grid64 = Terrain<double>::Grid;
using Grid32 = Terrain<float>::Grid;
static_assert(sizeof(HapticLoop<Grid64>) <= 1232 && sizeof(HapticLoop<Grid32>) <= 1056);
static_assert(std::is_trivially_copyable_v<HapticLoop<Grid64>>);
static_assert(std::is_nothrow_constructible_v<HapticLoop<Grid64>, const Grid64&, const HapticLoopOptions&>);
static_assert(!std::is_constructible_v<HapticLoop<Grid64>, Grid64>, "the field must outlive the loop");
static_assert(noexcept(std::declval<HapticLoop<Grid64>&>().update(std::declval<const DeviceSample&>())));
static_assert(noexcept(std::declval<AnyHapticLoop&>().update(std::declval<const DeviceSample&>())));
static_assert(!std::is_copy_constructible_v<AnyHapticLoop>);

namespace {

/// 400 m of rough ground, 10 m between samples, heights of 0 to 30 m.
template <Real T>
[[nodiscard]] Terrain<T> rough() {
    const GridFrame frame{.origin = {-200, -200}, .spacing = {10, 10}};
    Terrain<T> ground = rough_in_steps<T>(41, 41, 30, 5, frame);
    ground.remove(30, 12);
    return ground;
}

/// 10 cm of hand are 400 m of terrain, turned by 30 degrees.
[[nodiscard]] WorkspaceFrame frame() {
    const double c = std::cos(0.5), s = std::sin(0.5);
    return {.scale = 4000, .rotation = glm::dmat3{c, s, 0, -s, c, 0, 0, 0, 1}, .offset = {3, -7, 15}};
}

struct Setting {
    Material material;
    double lag = 0;
    unsigned clutch = 0;
    bool tells_velocity = false;
    SurfaceKind surface = SurfaceKind::solid;
    double release_speed = std::numeric_limits<double>::infinity();
};

[[nodiscard]] HapticLoopOptions options_of(const Setting& setting) {
    return {.workspace = frame(),
            .material = setting.material,
            .limits = {.stiffness = 700, .max_step = 0.002},
            .tracker = {.surface = setting.surface, .max_contact_patches = 8},
            .release_speed = setting.release_speed,
            .lag = setting.lag,
            .clutch_buttons = setting.clutch};
}

/// What a driver tells of a hand that presses, strokes and lifts, now and then of nothing sensible.
class Hand {
public:
    Hand(std::uint64_t seed, const Setting& setting)
        : random_{seed}, tells_velocity_{setting.tells_velocity} {}

    [[nodiscard]] DeviceSample next() {
        if (random_.one_in(300))
            wanted_ = {random_.between(-0.06, 0.06), random_.between(-0.06, 0.06),
                       random_.between(-8e-3, 8e-3)};
        velocity_ += 30e-3 * (wanted_ - position_) * 20.0 - 0.05 * velocity_;
        position_ += 1e-3 * velocity_;
        if (random_.one_in(700)) position_.z = 0.012;
        if (!random_.one_in(200)) time_ += 1e-3;
        if (random_.one_in(900)) time_ += 0.1;
        DeviceSample sample{.time = time_, .position = position_};
        if (tells_velocity_) sample.velocity = velocity_, sample.has_velocity = true;
        if (random_.one_in(150)) held_ = !held_;
        sample.buttons = held_ ? 6u : 8u;
        sample.force_refused = random_.one_in(3000);
        if (random_.one_in(400)) releasing_ = !releasing_;
        sample.release = releasing_ && random_.one_in(4);
        sample.has_sent = random_.one_in(3);
        sample.sent = {0, 0, random_.between(0, 1)};
        sample.sent_at = time_ - 1e-3;
        if (random_.one_in(400)) sample.position.x = hidden_nan<double>();
        if (random_.one_in(400)) sample.time = hidden_nan<double>();
        if (!held_ && random_.one_in(400)) sample.position.y = 1e60;
        if (!held_ && random_.one_in(400)) sample.position.y = 1e15;
        return sample;
    }

private:
    Random random_;
    bool tells_velocity_;
    glm::dvec3 position_{0, 0, 0.012}, velocity_{0.0}, wanted_{0.0};
    double time_ = 5;
    bool held_ = false, releasing_ = false;
};

/// The chain by hand: what README, the Phantom and the viewer wrote.
template <HeightField Field, class Tip = PointTip>
struct Chain {
    using T = typename Field::Scalar;
    using Friction = typename Tip::template Friction<T>;

    Chain(const Field& on, const HapticLoopOptions& options)
        : field{on}, material{options.material}, lag{options.lag}, clutch_buttons{options.clutch_buttons},
          release_speed{options.release_speed}, workspace{options.workspace}, tracker{on, options.tracker},
          guard{options.limits} {}

    DeviceCommand update(const DeviceSample& sample) {
        if (sample.force_refused) tracker.reset();
        const bool clutch = (sample.buttons & clutch_buttons) > 0;
        stylus = workspace.update(sample.position, clutch);
        contact = tracker.update(stylus);
        glide.set_speed(workspace.frame().scale * release_speed);
        contact = glide.follow(field, contact, stylus);
        if (material.shading) contact = shade_force(field, contact);
        if (material.static_friction != 0 || material.dynamic_friction != 0)
            contact = friction.hold(field, contact, stylus);
        const ForceEvaluator<T> force{.stiffness = workspace.terrain_stiffness(material.stiffness)};
        vec3<T> newtons = force(contact).newtons;
        if (material.damping != 0) {
            glm::dvec3 v = sample.velocity;
            if (!sample.has_velocity) {
                v = velocity.update(sample.position, sample.time - before);
                before = sample.time;
            }
            const Damping<T> damping{.along_normal = workspace.terrain_stiffness(material.damping)};
            newtons = damping(force, contact, workspace.velocity_on_terrain(v)).newtons;
        }
        asked = workspace.force_at_hand(newtons);
        if (clutch) asked = {0, 0, 0};
        asked = coupling(sample.position, asked).newtons;
        sent = guard.update(sample, asked, contact.status == ContactStatus::buried);
        if (clutch) {
            guard.restart();
            sent.newtons = {0, 0, 0};
        }
        return {sent.newtons};
    }

    void change(const Material& to) {
        const auto held = friction.state();
        if (to.stiffness != material.stiffness) coupling = VirtualCoupling{{to.stiffness, lag}};
        if (to.damping == 0) velocity = VelocityFilter<double>{};
        material = to;
        friction = Friction{coefficients()};
        if (to.static_friction != 0 || to.dynamic_friction != 0) friction.restore(held);
    }

    void reset() {
        tracker.reset();
        friction = Friction{coefficients()};
        glide.reset();
        velocity = VelocityFilter<double>{};
        coupling = VirtualCoupling{{material.stiffness, lag}};
        guard.restart();
    }

    [[nodiscard]] typename Friction::Coefficients coefficients() const {
        return {static_cast<T>(material.static_friction), static_cast<T>(material.dynamic_friction)};
    }

    const Field& field;
    Material material;
    double lag;
    unsigned clutch_buttons;
    double release_speed;
    Workspace<T> workspace;
    typename Tip::template Tracker<Field> tracker;
    Friction friction{coefficients()};
    typename Tip::template Glide<T> glide{};
    VelocityFilter<double> velocity{};
    double before = 0;
    VirtualCoupling coupling{{material.stiffness, lag}};
    ForceGuard guard;
    vec3<T> stylus{T(0)};
    typename Tip::template Contact<T> contact{};
    glm::dvec3 asked{0.0};
    GuardedForce sent{};
};

template <class V>
[[nodiscard]] bool same_bits(const V& a, const V& b) {
    for (int k = 0; k < 3; ++k)
        if (hfh::detail::bits_of(a[k]) != hfh::detail::bits_of(b[k])) return false;
    return true;
}

template <Real T>
[[nodiscard]] bool same(const Contact<T>& a, const Contact<T>& b) {
    return a.status == b.status && a.side == b.side && a.patches == b.patches &&
           same_bits(a.proxy, b.proxy) && same_bits(a.normal, b.normal) &&
           same_bits(a.penetration, b.penetration) && a.depth == b.depth && a.point.cell == b.point.cell &&
           a.point.u == b.point.u && a.point.v == b.point.v;
}

[[nodiscard]] bool same(const GuardedForce& a, const GuardedForce& b) {
    return same_bits(a.newtons, b.newtons) && a.trip == b.trip && a.latched == b.latched &&
           a.clamped == b.clamped && a.ramped == b.ramped && a.held_back == b.held_back &&
           a.slewed == b.slewed && a.released == b.released;
}

/// What a run saw, so that a comparison of nothing with nothing is found out.
struct Seen {
    unsigned statuses = 0, trips = 0;
    int updates = 0, touching = 0, pushing = 0, different = 0;

    void add(ContactStatus status, bool touches, const GuardedForce& force) {
        statuses |= 1u << static_cast<unsigned>(status);
        trips |= 1u << static_cast<unsigned>(force.trip);
        ++updates;
        touching += touches;
        pushing += force.newtons != glm::dvec3{0.0};
    }
};

/// Every combination of what a material and its surroundings switch.
[[nodiscard]] std::vector<Setting> settings() {
    std::vector<Setting> all;
    constexpr double frictions[][2] = {{0, 0}, {0.5, 0.4}, {0, 0.3}, {0.6, 0}};
    for (const bool shading : {false, true})
        for (const auto& [at_rest, sliding] : frictions)
            for (const double damping : {0.0, 0.8})
                for (const double lag : {0.0, 0.5})
                    for (const unsigned clutch : {0u, 2u})
                        for (const bool tells : {false, true})
                            all.push_back({{400, at_rest, sliding, damping, shading}, lag, clutch, tells});
    return all;
}

/// The tip of the loop, which has the radius that is told, and that of the chain.
template <class InLoop, class InChain>
struct Tips {
    double radius = 0;
};
using Points = Tips<PointTip, PointTip>;

/// `material` with some of its values changed at random, also to some that are not sensible.
[[nodiscard]] Material with_changes(Material material, Random& random) {
    if (random.one_in(2)) material.stiffness = random.one_in(2) ? 250 : -1;
    if (random.one_in(3)) material.static_friction = 0.2;
    if (random.one_in(3)) material.dynamic_friction = random.one_in(4) ? hidden_nan<double>() : 0.1;
    if (random.one_in(3)) material.damping = random.one_in(2) ? 0 : 2;
    if (random.one_in(3)) material.shading = !material.shading;
    return material;
}

/// Loop and chain with the same samples, and the same done to both between them. Counts where they differ.
template <HeightField Field, class InLoop, class InChain>
void compare(const Field& field, const Setting& setting, std::uint64_t seed, int updates, Seen& seen,
             Tips<InLoop, InChain> tips) {
    const HapticLoopOptions options = options_of(setting);
    HapticLoop<Field, InLoop> loop{field, options};
    Chain<Field, InChain> chain{field, options};
    const auto set_radius = [&](double metres) {
        const auto radius = static_cast<typename Field::Scalar>(metres);
        if constexpr (requires { loop.tracker().set_radius(radius); }) loop.tracker().set_radius(radius);
        if constexpr (requires { chain.tracker.set_radius(radius); }) chain.tracker.set_radius(radius);
    };
    set_radius(tips.radius);
    Hand hand{seed, setting};
    Random random{seed + 1};
    for (int n = 0; n < updates; ++n) {
        if (random.one_in(97)) {
            const double scale = 4000 * random.between(0.8, 1.25);
            const glm::dvec3 about = widen(chain.contact.proxy);
            REQUIRE(loop.workspace().zoom(scale, about) == chain.workspace.zoom(scale, about));
            set_radius(tips.radius * scale / 4000);
        }
        if (random.one_in(1500)) loop.reset(), chain.reset();
        if (random.one_in(150)) {
            const Material other = with_changes(setting.material, random);
            loop.set_material(other), chain.change(other);
        }
        const DeviceSample sample = hand.next();
        const DeviceCommand command = loop.update(sample), by_hand = chain.update(sample);
        const bool agrees = command.go_on && same_bits(command.newtons, by_hand.newtons) &&
                            same_bits(loop.asked(), chain.asked) && same(loop.force(), chain.sent) &&
                            same_bits(loop.stylus(), chain.stylus) && same(loop.contact(), chain.contact);
        seen.different += !agrees;
        seen.add(loop.contact().status, loop.contact().touching(), loop.force());
    }
}

template <Real T>
[[nodiscard]] DeviceSample at(double time, const glm::dvec3& hand) {
    return {.time = time, .position = hand};
}

/// A loop of 400 N/m at the hand on level ground at 0, in metres as they are, after its ramp, with the hand at rest
/// `depth` below it.
template <HeightField Field>
struct Pressed {
    explicit Pressed(const Field& field, HapticLoopOptions options = {}) : loop{field, options} {
        for (; time < 0.6; time += 1e-3) step({5, 5, 1e-3});
        for (int n = 0; n <= 50; ++n) step({5, 5, 1e-3 - 4e-3 * n / 50});
        for (int n = 0; n < 100; ++n) step({5, 5, -3e-3});
    }
    glm::dvec3 step(const glm::dvec3& hand) {
        time += 1e-3;
        newtons = loop.update({.time = time, .position = hand}).newtons;
        return newtons;
    }
    HapticLoop<Field> loop;
    double time = 0;
    glm::dvec3 newtons{0.0};
};

} // namespace

TEMPLATE_TEST_CASE(
    "haptic_loop: is the chain written by hand, to the bit, in every combination of its switches",
    "[haptic_loop]", float, double) {
    const Terrain<TestType> ground = rough<TestType>();
    const auto grid = ground.grid();
    Seen seen;
    std::uint64_t seed = 0;
    for (Setting setting : settings()) {
        setting.surface = seed % 4 == 3 ? SurfaceKind::sheet : SurfaceKind::solid;
        if (seed % 3 == 0) setting.release_speed = 0.5e-3;
        const Material& m = setting.material;
        CAPTURE(m.shading, m.static_friction, m.dynamic_friction, m.damping, setting.lag, setting.clutch,
                setting.tells_velocity);
        const int before = seen.different;
        compare(grid, setting, seed, 2000, seen, Points{});
        CHECK(seen.different == before);
        seed += 2;
    }
    CHECK(seen.updates == 256000);
    CHECK(seen.touching > 50000);
    CHECK(seen.pushing > 30000);
    using S = ContactStatus;
    for (const S status : {S::free, S::contact, S::descent_limit, S::buried, S::off_surface, S::bad_input}) {
        CAPTURE(to_string(status));
        CHECK((seen.statuses >> static_cast<unsigned>(status) & 1) == 1);
    }
    using G = GuardTrip;
    for (const G trip : {G::none, G::bad_sample, G::device_fault, G::stale, G::jump, G::buried}) {
        CAPTURE(to_string(trip));
        CHECK((seen.trips >> static_cast<unsigned>(trip) & 1) == 1);
    }
}

TEMPLATE_TEST_CASE("haptic_loop: wrapped fields are fields like any other", "[haptic_loop]", float, double) {
    const Terrain<TestType> ground = rough<TestType>();
    const auto grid = ground.grid();
    const ExtendedField endless{grid};
    Seen seen;
    compare(endless, {{400, 0.5, 0.4, 0.8, true}, 0.5, 2}, 7, 12000, seen, Points{});
    CHECK(seen.different == 0);
    CHECK(seen.touching > 1000);
}

TEMPLATE_TEST_CASE("haptic_loop: with a ball of radius 0 it is the loop with a point, to the bit",
                   "[haptic_loop][ball]", float, double) {
    const Terrain<TestType> ground = rough<TestType>();
    const auto grid = ground.grid();
    Seen seen;
    std::uint64_t seed = 400;
    for (Setting setting : settings()) {
        if (seed % 3 == 0) setting.release_speed = 0.5e-3;
        compare(grid, setting, seed += 2, 1000, seen, Tips<BallTip, PointTip>{0});
    }
    CHECK(seen.different == 0);
    CHECK(seen.touching > 20000);
}

TEMPLATE_TEST_CASE(
    "haptic_loop: a ball is tracked, shaded and held back as by hand, while its radius changes",
    "[haptic_loop][ball]", float, double) {
    const Terrain<TestType> ground = rough<TestType>();
    const auto grid = ground.grid();
    const ExtendedField endless{grid};
    Seen seen;
    std::uint64_t seed = 700;
    for (const double radius : {0.5, 12.0}) {
        for (const bool shading : {false, true}) {
            Setting setting{{400, 0.5, 0.4, 0.8, shading}, 0.5, 2};
            compare(grid, setting, seed += 2, 2000, seen, Tips<BallTip, BallTip>{radius});
            setting.release_speed = 0.5e-3;
            compare(endless, setting, seed += 2, 2000, seen, Tips<BallTip, BallTip>{radius});
        }
    }
    CHECK(seen.different == 0);
    CHECK(seen.touching > 2000);
}

TEMPLATE_TEST_CASE("any_haptic_loop: gives what the loop on the field's own type gives", "[any_haptic_loop]",
                   float, double) {
    using Field = typename Terrain<TestType>::Grid;
    const Terrain<TestType> ground = rough<TestType>();
    const auto grid = ground.grid();
    const Setting setting{{400, 0.5, 0.4, 0.8, true}, 0.5, 2};
    HapticLoop loop{grid, options_of(setting)};
    FieldLoop<Field> made{options_of(setting), grid};
    AnyHapticLoop& any = made;
    Hand hand{3, setting};
    const auto before = allocations();
    int different = 0, touching = 0;
    for (int n = 0; n < 20000; ++n) {
        if (n % 5000 == 4999) loop.reset(), any.reset();
        if (n % 300 == 299) {
            Material other = loop.material();
            other.stiffness = n % 200 + 300;
            loop.set_material(other), any.set_material(other);
        }
        if (n % 777 == 776) {
            const glm::dvec3 about{0, 0, 15};
            different += loop.workspace().zoom(3000 + n % 900, about) != any.zoom(3000 + n % 900, about);
            different += loop.workspace().move({1, 2, 0}) != any.move({1, 2, 0});
        }
        const DeviceSample sample = hand.next();
        const auto direct = loop.update(sample), erased = any.update(sample);
        const Contact<TestType>& a = loop.contact();
        const Contact<double> b = any.contact();
        different +=
            !same_bits(direct.newtons, erased.newtons) || !same(loop.force(), any.force()) ||
            !same_bits(loop.asked(), any.asked()) || !same_bits(widen(loop.stylus()), any.stylus()) ||
            any.frame().scale != loop.workspace().frame().scale ||
            any.material().stiffness != loop.material().stiffness || a.status != b.status ||
            a.side != b.side || a.patches != b.patches || !same_bits(widen(a.proxy), b.proxy) ||
            !same_bits(widen(a.normal), b.normal) || !same_bits(widen(a.penetration), b.penetration) ||
            widen(a.depth) != b.depth || a.point.cell != b.point.cell || widen(a.point.u) != b.point.u ||
            widen(a.point.v) != b.point.v;
        touching += a.touching();
    }
    const auto after = allocations();
    CHECK(after == before);
    CHECK(different == 0);
    CHECK(touching > 2000);
    CHECK(any.guard().counts().zeroed == loop.guard().counts().zeroed);
}

TEST_CASE("haptic_loop: allocates nothing", "[haptic_loop][realtime_safe]") {
    const Terrain<double> ground = rough<double>();
    const auto grid = ground.grid();
    const Setting setting{{400, 0.5, 0.4, 0.8, true}, 0.5, 2};
    Hand hand{5, setting};
    std::vector<DeviceSample> samples;
    for (int n = 0; n < 5000; ++n) samples.push_back(hand.next());
    const auto before = allocations();
    HapticLoop loop{grid, options_of(setting)};
    double sum = 0;
    for (const DeviceSample& sample : samples) {
        sum += glm::length(loop.update(sample).newtons);
        loop.set_material(loop.material());
    }
    loop.reset();
    const auto after = allocations();
    CHECK(after == before);
    CHECK(sum > 0);
}

TEST_CASE("haptic_loop: the stiffness is the one at the hand, whatever the scale", "[haptic_loop]") {
    for (const double scale : {0.01, 1.0, 5000.0}) {
        const Terrain<double> ground =
            plane<double>(9, 9, 0, {.origin = {-20 * scale, -20 * scale}, .spacing = {5 * scale, 5 * scale}});
        const auto grid = ground.grid();
        Pressed pressed{grid, {.workspace = {.scale = scale}}};
        CHECK(pressed.newtons.z == Approx(400 * 3e-3).epsilon(1e-9));
        CHECK(pressed.newtons.x == Approx(0).margin(1e-12));
        CHECK(glm::length(pressed.loop.stylus() - scale * glm::dvec3{5, 5, -3e-3}) < 1e-9 * scale);
    }
}

TEST_CASE(
    "haptic_loop: a material that changes while the ground is touched keeps the contact and comes gently",
    "[haptic_loop]") {
    const Terrain<double> ground = plane<double>(9, 9, 0, {.spacing = {5, 5}});
    const auto grid = ground.grid();
    Pressed pressed{grid};
    REQUIRE(pressed.newtons.z == Approx(1.2));
    SECTION("stiffer: by the pace of the ramp, beyond what may come at once") {
        pressed.loop.set_material({.stiffness = 1000});
        double before = 1.2;
        for (int n = 0; n < 600; ++n) {
            const double z = pressed.step({5, 5, -3e-3}).z;
            CHECK(z >= before - 1e-12);
            CHECK(z - before <= (n == 0 ? 0.3 : 0) + 3.3 / 500 + 1e-9);
            CHECK(pressed.loop.contact().touching());
            before = z;
        }
        CHECK(before == Approx(3));
    }
    SECTION("softer: by the slew") {
        pressed.loop.set_material({.stiffness = 10});
        CHECK(pressed.step({5, 5, -3e-3}).z == Approx(0.2));
        CHECK(pressed.step({5, 5, -3e-3}).z == Approx(0.03));
    }
    SECTION("no number: no force, and a good one again") {
        pressed.loop.set_material({.stiffness = hidden_nan<double>()});
        pressed.step({5, 5, -3e-3});
        CHECK(pressed.step({5, 5, -3e-3}).z == 0);
        CHECK(pressed.loop.contact().touching());
        pressed.loop.set_material({});
        for (int n = 0; n < 600; ++n) pressed.step({5, 5, -3e-3});
        CHECK(pressed.newtons.z == Approx(1.2));
    }
    SECTION("friction: the anchor is where the proxy is, and stays where it was when coefficients change") {
        pressed.loop.set_material({.static_friction = 0.9, .dynamic_friction = 0.9});
        pressed.step({5, 5, -3e-3});
        for (int n = 1; n <= 20; ++n) pressed.step({5 + 1e-4 * n, 5, -3e-3});
        for (int n = 0; n < 50; ++n) pressed.step({5 + 2e-3, 5, -3e-3});
        CHECK(pressed.newtons.x == Approx(-0.8));
        pressed.loop.set_material({.static_friction = 0.8, .dynamic_friction = 0.8});
        pressed.step({5 + 2e-3, 5, -3e-3});
        CHECK(pressed.newtons.x == Approx(-0.8));
        pressed.loop.set_material({});
        pressed.step({5 + 2e-3, 5, -3e-3});
        CHECK(pressed.newtons.x == 0);
        CHECK(pressed.newtons.z == Approx(1.2));
    }
    SECTION("damping: against the motion of the hand, told or not") {
        pressed.loop.set_material({.damping = 2});
        for (int n = 1; n <= 100; ++n) pressed.step({5, 5, -3e-3 - 1e-5 * n});
        const double moving = pressed.newtons.z;
        for (int n = 0; n < 100; ++n) pressed.step({5, 5, -4e-3});
        CHECK(pressed.newtons.z == Approx(1.6));
        CHECK(moving == Approx(1.6 + 2 * 0.01 + 0.75 * 400 * 1e-5).epsilon(1e-3));
    }
}

TEST_CASE("haptic_loop: bad samples, refused forces and resets end as the header says", "[haptic_loop]") {
    const Terrain<double> ground = plane<double>(9, 9, 0, {.spacing = {5, 5}});
    const auto grid = ground.grid();
    Pressed pressed{grid};
    auto& loop = pressed.loop;
    SECTION("no number: zero at once, and the contact goes on by the ramp") {
        pressed.step({5, 5, hidden_nan<double>()});
        CHECK(pressed.newtons == glm::dvec3{0.0});
        CHECK(loop.contact().status == ContactStatus::bad_input);
        CHECK(loop.force().trip == GuardTrip::bad_sample);
        pressed.step({5, 5, -3e-3});
        CHECK(loop.contact().touching());
        for (int n = 0; n < 600; ++n) pressed.step({5, 5, -3e-3});
        CHECK(pressed.newtons.z == Approx(1.2));
    }
    SECTION("refused: zero, then buried until the hand has been outside") {
        const auto command =
            loop.update({.time = pressed.time += 1e-3, .position = {5, 5, -3e-3}, .force_refused = true});
        CHECK(command.newtons == glm::dvec3{0.0});
        CHECK(loop.force().trip == GuardTrip::device_fault);
        pressed.step({5, 5, -3e-3});
        CHECK(loop.contact().status == ContactStatus::buried);
        CHECK(loop.force().trip == GuardTrip::buried);
        for (int n = 0; n <= 40; ++n) pressed.step({5, 5, -3e-3 + 1e-4 * n});
        CHECK(loop.contact().status == ContactStatus::free);
        for (int n = 0; n <= 40; ++n) pressed.step({5, 5, 1e-3 - 1e-4 * n});
        CHECK(loop.contact().touching());
    }
    SECTION("reset: as at the start, and the counts stay") {
        pressed.step({5, 5, hidden_nan<double>()});
        loop.reset();
        pressed.step({5, 5, -3e-3});
        CHECK(loop.contact().status == ContactStatus::buried);
        CHECK(pressed.newtons == glm::dvec3{0.0});
        CHECK(loop.guard().counts().trips[static_cast<int>(GuardTrip::bad_sample)] == 1);
    }
    SECTION("a workspace that is none gives no force") {
        Pressed nowhere{grid, {.workspace = {.scale = 0}}};
        CHECK(nowhere.loop.workspace().status() == WorkspaceStatus::bad_scale);
        CHECK(nowhere.newtons == glm::dvec3{0.0});
    }
}

TEST_CASE("haptic_loop: where there is a clutch, the hand goes back without the stylus and without force",
          "[haptic_loop]") {
    const Terrain<double> ground = plane<double>(9, 9, 0, {.spacing = {5, 5}});
    const auto grid = ground.grid();
    Pressed pressed{grid, {.clutch_buttons = 4}};
    auto& loop = pressed.loop;
    const auto hold = [&](const glm::dvec3& hand, unsigned buttons) {
        return loop.update({.time = pressed.time += 1e-3, .position = hand, .buttons = buttons}).newtons;
    };
    CHECK(hold({5, 5, -3e-3}, 3).z == Approx(1.2));
    for (int n = 0; n <= 100; ++n) CHECK(hold({5 + 1e-4 * n, 5, -3e-3}, 5) == glm::dvec3{0.0});
    CHECK(glm::length(loop.stylus() - glm::dvec3{5, 5, -3e-3}) < 1e-12);
    CHECK(loop.contact().touching());
    CHECK(hold({5.01, 5, -3e-3}, 0).z < 0.01);
    for (int n = 0; n < 600; ++n) (void)hold({5.01, 5, -3e-3}, 0);
    CHECK(loop.force().newtons.z == Approx(1.2));
    CHECK(glm::length(loop.stylus() - glm::dvec3{5, 5, -3e-3}) < 1e-12);
}

TEST_CASE("haptic_loop: an edit and new bounds are felt at the next update",
          "[haptic_loop][any_haptic_loop]") {
    Terrain<double> ground = plane<double>(9, 9, 0, {.spacing = {5, 5}});
    using Field = BoundedGrid<double, HeightView<double>>;
    std::array<SampleRange<double>, 4> ranges;
    FieldLoop<Field> any{{.limits = {.ramp = 0}}, ground.grid(), ranges.data(), Index(ranges.size())};
    REQUIRE(any.field().build() == PyramidStatus::ok);
    (void)any.update({.time = 0, .position = {12, 12, 1e-3}});
    (void)any.update({.time = 1e-3, .position = {12, 12, -1e-3}});
    REQUIRE(any.contact().touching());
    CHECK(any.contact().depth == Approx(1e-3));
    for (double& z : ground.heights) z = -0.5e-3;
    REQUIRE(any.field().build() == PyramidStatus::ok);
    (void)any.update({.time = 2e-3, .position = {12, 12, -1e-3}});
    CHECK(any.contact().depth == Approx(0.5e-3));
}
