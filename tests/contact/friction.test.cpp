#include "catch.hpp"
#include "support/reference.hpp"
#include "support/scenes.hpp"

#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/force_evaluator.hpp>

#include <cstring>
#include <type_traits>
#include <utility>

using namespace hfh;
using namespace hfh::test;

namespace {

Point cross(const Point& a, const Point& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

bool at_end(double part) { return part <= 0 || part >= 1; }

/// tan of the angle between the penetration and the nearest normal at a surface point; > 0 always, infinite across.
/// Where patches meet, any slopes between theirs are the ground's. The cosine has one maximum over them: by halving.
template <Real T>
Wide tangent(const Surface<T>& surface, const SurfacePoint<T>& at, const Point& push, Side side) {
    const Wide inf = std::numeric_limits<Wide>::infinity();
    Wide low[2]{inf, inf}, high[2]{-inf, -inf};
    for (Index dj = -1; dj <= 1; ++dj) {
        for (Index di = -1; di <= 1; ++di) {
            const Wide u = static_cast<Wide>(at.u) - static_cast<Wide>(di),
                       v = static_cast<Wide>(at.v) - static_cast<Wide>(dj);
            if (u < 0 || u > 1 || v < 0 || v > 1) continue;
            const auto patch = surface.patch(at.cell.i + di, at.cell.j + dj);
            if (!patch) continue;
            const Point n = patch->normal(u, v);
            const Wide slopes[2]{-n.x / n.z, -n.y / n.z};
            for (int k = 0; k < 2; ++k) {
                low[k] = std::min(low[k], slopes[k]);
                high[k] = std::max(high[k], slopes[k]);
            }
        }
    }
    const Wide sign = side == Side::below ? Wide(-1) : Wide(1);
    const auto cosine = [&](Wide s, Wide t) {
        return sign * (push.z - push.x * s - push.y * t) / std::sqrt(1 + s * s + t * t);
    };
    const auto greatest = [](Wide from, Wide to, auto&& f) {
        for (int n = 0; n < 120 && from < to; ++n) {
            const Wide a = from + (to - from) / 3, b = to - (to - from) / 3;
            (f(a) < f(b) ? from : to) = f(a) < f(b) ? a : b;
        }
        return (from + to) / 2;
    };
    const auto best_t = [&](Wide s) {
        return greatest(low[1], high[1], [&](Wide t) { return cosine(s, t); });
    };
    const Wide s = greatest(low[0], high[0], [&](Wide x) { return cosine(x, best_t(x)); }), t = best_t(s);
    const Point n{-s * sign, -t * sign, sign};
    const Wide out = dot(push, n);
    return out > 0 ? length(cross(push, n)) / out : inf;
}

template <Real T>
bool same(const SurfacePoint<T>& a, const SurfacePoint<T>& b) {
    return a.cell == b.cell && a.u == b.u && a.v == b.v;
}

/// A tilted plane through the origin with a frame of its own: where a stylus is, `deep` below it and moved along it.
struct Slope {
    double along_x, along_y;

    [[nodiscard]] glm::dvec3 normal() const { return glm::normalize(glm::dvec3{-along_x, -along_y, 1}); }
    /// A unit vector in the plane, at an angle to the way up.
    [[nodiscard]] glm::dvec3 way(double angle) const {
        const glm::dvec3 n = normal();
        glm::dvec3 up{along_x, along_y, along_x * along_x + along_y * along_y};
        if (glm::length(up) == 0) up = {1, 0, 0};
        up = glm::normalize(up);
        return std::cos(angle) * up + std::sin(angle) * glm::cross(n, up);
    }
};

template <Real T>
using Grid_t = typename Terrain<T>::Grid;

/// A field that counts how often it is asked for a patch.
template <HeightField Field>
struct Counted {
    using Scalar = typename Field::Scalar;
    Field field;
    mutable int patches = 0;

    explicit Counted(const Field& counted) : field{counted} {}
    [[nodiscard]] Lattice lattice() const noexcept { return field.lattice(); }
    [[nodiscard]] CellRange cells() const noexcept { return field.cells(); }
    [[nodiscard]] std::optional<BilinearPatch<Scalar>> patch(Cell c) const noexcept {
        ++patches;
        return field.patch(c);
    }
};

constexpr Slope slopes_to_try[] = {{0, 0}, {0.25, 0}, {-0.5, 0.75}, {2, 1}, {0, -4}};

} // namespace

TEMPLATE_TEST_CASE("Friction: a push along a plane slips at the angle of friction, whatever the slope",
                   "[friction][law]", float, double) {
    using T = TestType;
    for (const auto& slope : slopes_to_try) {
        const auto ground = tilted_plane<T>(33, 33, slope.along_x, slope.along_y,
                                            -16 * (slope.along_x + slope.along_y), {.origin = {-16, -16}});
        const auto grid = ground.grid();
        for (const T at_rest : {T(0.125), T(0.5), T(1.5)}) {
            for (const double angle : {0.0, 0.7, 1.9, 3.14159, 4.5}) {
                const double deep = 0.25;
                const glm::dvec3 foot = 0.3 * slope.way(1) + 0.2 * slope.way(2.5);
                const auto pushed = [&](double by) {
                    return vec3<T>{foot - deep * slope.normal() + by * slope.way(angle)};
                };
                // The push at which it slips, by bisection, each from a fresh contact.
                double holds = 0, slips = 1;
                for (int n = 0; n < 60; ++n) {
                    const double by = (holds + slips) / 2;
                    ProxyTracker tracker{grid};
                    Friction<T> friction{{at_rest, at_rest / 2}};
                    static_cast<void>(
                        friction.hold(grid, tracker.update(vec3<T>{T(0), T(0), T(30)}), {T(0), T(0), T(30)}));
                    static_cast<void>(friction.hold(grid, tracker.update(pushed(0)), pushed(0)));
                    const auto anchor = friction.state().anchor;
                    REQUIRE(friction.state().side == Side::above);
                    static_cast<void>(friction.hold(grid, tracker.update(pushed(by)), pushed(by)));
                    CHECK(same(anchor, friction.state().anchor) == !friction.state().slipping);
                    (friction.state().slipping ? slips : holds) = by;
                }
                CAPTURE(slope.along_x, slope.along_y, double(at_rest), angle);
                // Roundings of positions of some 10 m at most, against a depth of 0.25 m.
                CHECK(slips / deep ==
                      Approx(double(at_rest)).margin(128 * double(epsilon<T>) * (1 + double(at_rest))));
            }
        }
    }
}

TEMPLATE_TEST_CASE("Friction: a hand that slides feels the dynamic coefficient times the normal force",
                   "[friction][law]", float, double) {
    using T = TestType;
    for (const auto& slope : slopes_to_try) {
        const auto ground = tilted_plane<T>(65, 65, slope.along_x, slope.along_y,
                                            -32 * (slope.along_x + slope.along_y), {.origin = {-32, -32}});
        const auto grid = ground.grid();
        const Surface<T> surface{ground};
        for (const T sliding : {T(0), T(0.25), T(0.75)}) {
            for (const double angle : {0.1, 0.8, 2.0, 3.7, 5.5}) {
                ProxyTracker tracker{grid};
                const ForceEvaluator<T> force{.stiffness = T(100)};
                Friction<T> friction{{sliding * 2, sliding}};
                const double deep = 0.25;
                int slipping = 0;
                for (int n = -1; n < 400; ++n) {
                    const vec3<T> at{n < 0 ? 5.0 * slope.normal()
                                           : -deep * slope.normal() + (0.01 * n) * slope.way(angle)};
                    const auto contact = friction.hold(grid, tracker.update(at), at);
                    if (!friction.state().slipping) continue;
                    ++slipping;
                    // The roundings of the heights, of some 100 m on the steepest plane, count against the depth.
                    const Wide eps = static_cast<Wide>(epsilon<T>),
                               blur = 64 * eps *
                                      (1 + static_cast<Wide>(std::hypot(slope.along_x, slope.along_y)));
                    const Point n_up = wide(vec3<double>{slope.normal()});
                    const Point newtons = wide(force(contact).newtons);
                    const Wide out = dot(newtons, n_up), across = length(cross(newtons, n_up));
                    CHECK(std::abs(across - static_cast<Wide>(sliding) * out) <= 100 * blur);
                    CHECK(std::abs(out - 100 * Wide(deep)) <= 100 * 8 * blur);
                    // Against the motion.
                    const Point w = wide(vec3<double>{slope.way(angle)});
                    CHECK(dot(newtons, w) <= -across + 100 * blur);
                }
                CAPTURE(slope.along_x, slope.along_y, double(sliding), angle);
                CHECK(slipping > 300);
            }
        }
    }
}

TEMPLATE_TEST_CASE("Friction: a hand at rest feels no drift in 100000 updates", "[friction]", float, double) {
    using T = TestType;
    for (const auto& scene : scenes<T>()) {
        const auto grid = scene.terrain.grid();
        const Surface<T> surface{scene.terrain};
        const glm::dvec2 middle = (scene.terrain.low() + scene.terrain.high()) / 2.0;
        const glm::dvec2 cell = scene.terrain.frame.spacing;
        Random random{91};
        for (const double jitter : {0.0, 0.01}) {
            ProxyTracker tracker{grid};
            Friction<T> friction{{T(0.75), T(0.5)}};
            const vec3<T> first{static_cast<T>(middle.x + 0.3 * cell.x),
                                static_cast<T>(middle.y + 0.2 * cell.y), T(1000)};
            static_cast<void>(tracker.update(first));
            const double z = double(*surface.height(Wide(first.x), Wide(first.y))) - 0.1 * cell.x;
            SurfacePoint<T> anchor{};
            vec3<T> proxy{T(0)};
            int moved = 0, inside = 0;
            bool touching = false;
            for (int n = 0; n < 100000 / (jitter > 0 ? 10 : 1); ++n) {
                const vec3<T> at{first.x + static_cast<T>(jitter * cell.x * random.between(-1, 1)),
                                 first.y + static_cast<T>(jitter * cell.y * random.between(-1, 1)),
                                 static_cast<T>(z)};
                const auto contact = friction.hold(grid, tracker.update(at), at);
                const bool was_touching = std::exchange(touching, contact.touching());
                if (!contact.touching() || !was_touching) {
                    anchor = friction.state().anchor;
                    proxy = contact.proxy;
                    continue;
                }
                if (!same(anchor, friction.state().anchor)) {
                    // It moved: then the stylus was outside the cone of rest, or the hand still slid.
                    const Point push = surface.position(wide(anchor)) - wide(at);
                    if (tangent(surface, anchor, push, Side::above) < Wide(0.5L) - Wide(1e-3L)) ++moved;
                } else {
                    ++inside;
                    if (jitter == 0 && n > 2) CHECK(contact.proxy == proxy);
                }
                anchor = friction.state().anchor;
                proxy = contact.proxy;
            }
            CAPTURE(scene.name, jitter);
            CHECK(moved == 0);
            CHECK(inside > (jitter > 0 ? 1000 : 99990));
        }
    }
}

TEMPLATE_TEST_CASE("Friction: with a jitter inside the cone the anchor stays to the bit", "[friction]", float,
                   double) {
    using T = TestType;
    const auto ground = tilted_plane<T>(9, 9, 0.5, 0.25);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid};
    Friction<T> friction{{T(0.5), T(0.25)}};
    Random random{92};
    static_cast<void>(tracker.update({T(4.3), T(4.2), T(20)}));
    SurfacePoint<T> anchor{};
    for (int n = 0; n < 100000; ++n) {
        const auto by = [&] { return n == 0 ? T(0) : static_cast<T>(random.between(-0.02, 0.02)); };
        const vec3<T> at{T(4.3) + by(), T(4.2) + by(), T(4.3 * 0.5 + 4.2 * 0.25 - 0.25) + by()};
        static_cast<void>(friction.hold(grid, tracker.update(at), at));
        if (n == 0) anchor = friction.state().anchor;
        REQUIRE(same(anchor, friction.state().anchor));
        REQUIRE_FALSE(friction.state().slipping);
    }
}

/// Friction on one terrain under a hand, each update judged by what the cone of Coulomb holds.
template <Real T>
class FrictionWitness {
public:
    struct Counts {
        int held = 0, slipped = 0, in_creases = 0;
        int late = 0; ///< slips past a point that held
    };

    FrictionWitness(const Terrain<T>& ground, SurfaceKind kind)
        : surface_{ground}, grid_{ground.grid()}, tracker_{grid_, {.surface = kind}} {}
    FrictionWitness(const FrictionWitness&) = delete;
    FrictionWitness& operator=(const FrictionWitness&) = delete;

    void update(const vec3<T>& at, Counts& counts) {
        const FrictionState<T> before = friction_.state();
        const auto free = tracker_.update(at);
        const auto contact = friction_.hold(grid_, free, at);
        const auto& after = friction_.state();
        REQUIRE(contact.status == free.status);
        if (!contact.touching()) {
            REQUIRE(after.side == Side::none);
            REQUIRE(contact.normal == free.normal);
            REQUIRE(contact.proxy == free.proxy);
            return;
        }
        REQUIRE(after.side == contact.side);
        REQUIRE(same(contact.point, after.anchor));
        const Point q = wide(at), anchor = surface_.position(wide(after.anchor)), push = anchor - q;
        const Wide eps = static_cast<Wide>(epsilon<T>);
        const Wide blur = 32 * eps *
                          (std::abs(anchor.z) + std::abs(q.x) + std::abs(q.y) + length(push) +
                           surface_.patch(after.anchor.cell.i, after.anchor.cell.j)->reach({}));
        REQUIRE(length(wide(contact.proxy) - anchor) <= blur);
        if (same(after.anchor, free.point)) { // nothing held it, or nothing had to
            REQUIRE(contact.penetration == free.penetration);
            REQUIRE(contact.normal == free.normal);
            return;
        }
        REQUIRE(length(wide(contact.penetration) - push) <= blur);
        REQUIRE(std::abs(static_cast<Wide>(contact.depth) - length(wide(contact.penetration))) <=
                8 * eps * length(push));
        // Never into the surface, and inside the cone that applies.
        const Wide lean = tangent(surface_, after.anchor, push, after.side);
        const Wide most = static_cast<Wide>(after.slipping || before.slipping ? sliding : at_rest);
        const Wide slack = blur / length(push) * (1 + most) * 4;
        REQUIRE(lean <= most + slack);
        // The normal is one that the ground has there, and the force is inside the cone that hangs from it.
        const Point n = wide(contact.normal);
        REQUIRE(std::abs(length(n) - 1) <= 8 * eps);
        // `tangent` finds a cosine's maximum, which tells the angle to the root of long double's rounding. It is slow.
        if ((counts.held + counts.slipped) % 16 == 0)
            REQUIRE(tangent(surface_, after.anchor, n, after.side) <=
                    1e-9L + 64 * eps * steepness(after.anchor));
        REQUIRE(dot(push, n) > 0);
        REQUIRE(length(cross(push, n)) <= (most + slack) * dot(push, n));
        if (!after.slipping) {
            ++counts.held;
            REQUIRE(same(before.anchor, after.anchor));
        } else {
            ++counts.slipped;
            judge_slip(before.anchor, after, free.point, q, blur, counts);
        }
    }

private:
    static constexpr T at_rest = T(0.625), sliding = T(0.375);

    /// 1 plus the height over the width of the cell: by how much more than its coordinates a normal is rounded.
    [[nodiscard]] Wide steepness(const SurfacePoint<T>& at) const {
        const auto p = surface_.patch(at.cell.i, at.cell.j);
        return 1 + (std::abs(p->lowest()) + std::abs(p->highest())) / std::min(p->dx, p->dy);
    }

    /// On the straight way in plan from one anchor to the next, or on one that bends at the crease in which the proxy is.
    void judge_slip(const SurfacePoint<T>& before, const FrictionState<T>& after,
                    const SurfacePoint<T>& proxy, const Point& q, Wide blur, Counts& counts) const {
        const Wide eps = static_cast<Wide>(epsilon<T>);
        const Point anchor = surface_.position(wide(after.anchor));
        const Point a = surface_.position(wide(before)), b = surface_.position(wide(proxy));
        const Wide dx = b.x - a.x, dy = b.y - a.y, way = std::hypot(dx, dy);
        const Wide off = std::abs((anchor.x - a.x) * dy - (anchor.y - a.y) * dx) / way;
        const bool straight = off <= blur + 32 * eps * way;
        const auto within = [blur](Wide k, Wide p, Wide r) {
            return std::min(p, r) - blur <= k && k <= std::max(p, r) + blur;
        };
        const bool bent = (at_end(double(proxy.u)) || at_end(double(proxy.v))) &&
                          within(anchor.x, a.x, b.x) && within(anchor.y, a.y, b.y);
        REQUIRE((straight || bent));
        counts.in_creases += !straight;
        const Wide gone = straight ? ((anchor.x - a.x) * dx + (anchor.y - a.y) * dy) / (way * way) : Wide(0);
        REQUIRE(gone <= 1 + blur);
        counts.late += holds_before(a, dx, dy, gone, q, after.side);
    }

    /// Whether a point before `gone` of the way a → a + (dx, dy) has the stylus inside the dynamic cone; 64 are looked at.
    [[nodiscard]] bool holds_before(const Point& a, Wide dx, Wide dy, Wide gone, const Point& q,
                                    Side side) const {
        for (int k = 0; k < 64; ++k) {
            const Wide t = (Wide(k) + Wide(0.5L)) / 64;
            if (t >= gone - Wide(1e-3L)) break;
            const auto s = surface_.under(a.x + t * dx, a.y + t * dy);
            if (!s) continue;
            const Point push_there = surface_.position(*s) - q;
            const Point normal = surface_.patch(s->i, s->j)->normal(s->u, s->v);
            const Wide out = dot(push_there, normal) * (side == Side::below ? -1 : 1);
            if (out > 0 && length(cross(push_there, normal)) <= out * (static_cast<Wide>(sliding) - 1e-3L))
                return true;
        }
        return false;
    }

    const Surface<T> surface_;
    const Grid_t<T> grid_;
    ProxyTracker<Grid_t<T>> tracker_;
    Friction<T> friction_{{at_rest, sliding}};
};

TEMPLATE_TEST_CASE(
    "Friction: holds what the cone holds, and moves no farther than to the first point that does",
    "[friction][law]", float, double) {
    using T = TestType;
    for (const bool holes : {false, true}) {
        for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
            typename FrictionWitness<T>::Counts counts;
            for (auto& scene : scenes<T>()) {
                if (holes) punch_holes(scene.terrain, 24, 93);
                const Surface<T> surface{scene.terrain};
                FrictionWitness<T> witness{scene.terrain, kind};
                Random random{94};
                const glm::dvec2 low = scene.terrain.low(), high = scene.terrain.high(),
                                 cell = scene.terrain.frame.spacing;
                double x = low.x + 5 * cell.x, y = low.y + 5 * cell.y, heading = 0;
                for (int n = 0; n < 4000; ++n) {
                    heading += random.between(-0.4, 0.4);
                    const double step = random.one_in(200) ? 4 : 0.15 * random.unit();
                    x = std::clamp(x + step * cell.x * std::cos(heading), low.x, high.x);
                    y = std::clamp(y + step * cell.y * std::sin(heading), low.y, high.y);
                    const auto z = surface.height(Wide(x), Wide(y));
                    witness.update(
                        {static_cast<T>(x), static_cast<T>(y),
                         static_cast<T>(z.value_or(0) +
                                        Wide(cell.x * (n % 25 == 0 ? 30.0 : random.between(-0.4, 0.02))))},
                        counts);
                }
            }
            CAPTURE(holes, counts.held, counts.slipped, counts.in_creases, counts.late);
            CHECK(counts.held > 500);
            CHECK(counts.slipped > 500);
            CHECK(counts.in_creases > 20);
            // A cone that begins and ends within one cell may be passed over; that is rare.
            CHECK(counts.late * 1000 <= counts.slipped);
        }
    }
}

TEMPLATE_TEST_CASE("Friction: along a valley it slips at the angle of friction, however steep its sides",
                   "[friction][law]", float, double) {
    using T = TestType;
    // A valley along y, in the middle of a column's line and tilted by `fall`. The stylus presses straight against the
    // bottom line; each side alone would hold nothing once it is steeper than the angle of friction.
    for (const double side : {0.05, 0.3, 1.0, 4.0}) {
        for (const double fall : {0.0, -0.5, 2.0}) {
            const auto ground = terrain<T>(17, 33, [&](Index i, Index j) {
                return side * std::abs(double(i - 8)) + fall * double(j - 4);
            });
            const auto grid = ground.grid();
            const glm::dvec3 along = glm::normalize(glm::dvec3{0, 1, fall}), up{0, -along.z, along.y};
            const double deep = 0.25;
            const auto at = [&](double by) {
                return vec3<T>{glm::dvec3{8, 4.25, 0.25 * fall} - deep * up + by * along};
            };
            const auto begin = [&](ProxyTracker<Grid_t<T>>& tracker, Friction<T>& friction) {
                static_cast<void>(tracker.update({T(8), T(4.25), T(30)}));
                static_cast<void>(friction.hold(grid, tracker.update(at(0)), at(0)));
                REQUIRE(friction.state().side == Side::above);
            };
            const T at_rest = T(0.75), sliding = T(0.5);
            const double blur = 64 * double(epsilon<T>) * (1 + std::abs(fall)) * (1 + side) * 8;
            CAPTURE(side, fall);
            double holds = 0, slips = 1;
            for (int n = 0; n < 60; ++n) {
                const double by = (holds + slips) / 2;
                ProxyTracker tracker{grid};
                Friction<T> friction{{at_rest, sliding}};
                begin(tracker, friction);
                static_cast<void>(friction.hold(grid, tracker.update(at(by)), at(by)));
                (friction.state().slipping ? slips : holds) = by;
            }
            CHECK(slips / deep == Approx(double(at_rest)).margin(blur / deep));

            ProxyTracker tracker{grid};
            Friction<T> friction{{at_rest, sliding}};
            begin(tracker, friction);
            int slipping = 0;
            for (int n = 0; n < 1000; ++n) {
                const auto contact = friction.hold(grid, tracker.update(at(0.01 * n)), at(0.01 * n));
                if (!friction.state().slipping) continue;
                ++slipping;
                const glm::dvec3 push{contact.penetration};
                CHECK(-glm::dot(push, along) == Approx(double(sliding) * deep).margin(blur));
                CHECK(glm::dot(push, up) == Approx(deep).margin(blur));
            }
            CHECK(slipping > 900);
        }
    }
}

TEMPLATE_TEST_CASE("Friction: a hand that slides aslant into a valley goes on along it without a jerk",
                   "[friction]", float, double) {
    using T = TestType;
    for (const double side : {0.3, 1.0, 2.0}) {
        const auto ground =
            terrain<T>(33, 65, [&](Index i, Index) { return side * std::abs(double(i - 16)); });
        const auto grid = ground.grid();
        for (const double aslant : {0.2, 0.8, 1.2}) {
            ProxyTracker tracker{grid};
            Friction<T> friction{{T(0.5), T(0.5)}};
            static_cast<void>(tracker.update({T(11), T(8), T(40)}));
            const double step = 0.002;
            vec3<T> last{T(0)}, last_at{T(0)};
            double most = 0;
            int along = 0;
            for (int n = 0; n < 8000; ++n) {
                // Down the side at a depth of 0.2, then straight on at the height of the bottom − 0.2.
                const double x = std::min(11 + step * n * std::cos(aslant), 16.0);
                const double y = 8 + step * n * std::sin(aslant);
                const vec3<T> at{static_cast<T>(x), static_cast<T>(y), static_cast<T>(side * (16 - x) - 0.2)};
                const auto contact = friction.hold(grid, tracker.update(at), at);
                if (n > 0) {
                    const double moved = double(glm::length(at - last_at));
                    most = std::max(most, double(glm::length(contact.penetration - last)) / moved);
                }
                last = contact.penetration, last_at = at;
                along += x == 16 && double(last.y) < -0.09;
            }
            CAPTURE(side, aslant);
            CHECK(along > 1000);
            // No more than a spring would; in float a step of 2 mm has some roundings of 20 m.
            CHECK(most <= 1.05 + 100 * double(epsilon<T>) / step);
        }
    }
}

TEMPLATE_TEST_CASE("Friction: a hand that stops while friction holds it feels no drift in 100000 updates",
                   "[friction]", float, double) {
    using T = TestType;
    // It slid until friction was fully taken up (slipping), or half up, and stops there: from the second update on every
    // force is the same to the bit.
    for (const auto& scene : scenes<T>()) {
        const auto grid = scene.terrain.grid();
        const Surface<T> surface{scene.terrain};
        const glm::dvec2 middle = (scene.terrain.low() + scene.terrain.high()) / 2.0;
        const glm::dvec2 cell = scene.terrain.frame.spacing;
        for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
            for (const double way : {0.05, 1.5}) {
                ProxyTracker tracker{grid, {.surface = kind}};
                Friction<T> friction{{T(0.75), T(0.5)}};
                const auto at = [&](double by) {
                    const double x = middle.x + (0.3 + by) * cell.x, y = middle.y + (0.2 + 0.7 * by) * cell.y;
                    return vec3<T>{static_cast<T>(x), static_cast<T>(y),
                                   static_cast<T>(double(*surface.height(Wide(x), Wide(y))) - 0.1 * cell.x)};
                };
                static_cast<void>(tracker.update(at(0) + vec3<T>{T(0), T(0), T(1000)}));
                for (int n = 0; n <= 50; ++n)
                    static_cast<void>(
                        friction.hold(grid, tracker.update(at(way * n / 50)), at(way * n / 50)));
                const vec3<T> rest = at(way);
                static_cast<void>(friction.hold(grid, tracker.update(rest), rest));
                const auto first = friction.hold(grid, tracker.update(rest), rest);
                const auto anchor = friction.state().anchor;
                CAPTURE(scene.name, way, double(first.depth));
                REQUIRE(first.touching());
                for (int n = 0; n < 100000; ++n) {
                    const auto contact = friction.hold(grid, tracker.update(rest), rest);
                    REQUIRE(contact.penetration == first.penetration);
                    REQUIRE(same(friction.state().anchor, anchor));
                    REQUIRE_FALSE(friction.state().slipping);
                }
            }
        }
    }
}

TEMPLATE_TEST_CASE(
    "Friction: in a pit of any steepness the anchor stays to the bit under a hand that trembles",
    "[friction]", float, double) {
    using T = TestType;
    for (const double steep : {0.5, 2.0, 8.0}) {
        const auto ground = pit<T>(17, 17, steep);
        const auto grid = ground.grid();
        ProxyTracker tracker{grid};
        Friction<T> friction{{T(0.25), T(0.125)}};
        static_cast<void>(tracker.update({T(8), T(8), T(100)}));
        Random random{95};
        SurfacePoint<T> anchor{};
        for (int n = 0; n < 100000; ++n) {
            const auto by = [&] { return n == 0 ? T(0) : static_cast<T>(random.between(-0.02, 0.02)); };
            const vec3<T> at{T(8) + by(), T(8) + by(), ground.at(8, 8) - T(0.25) + by()};
            static_cast<void>(friction.hold(grid, tracker.update(at), at));
            if (n == 0) anchor = friction.state().anchor;
            REQUIRE(same(friction.state().anchor, anchor));
        }
    }
}

TEMPLATE_TEST_CASE("Friction: looks at a bounded number of patches, whatever happens", "[friction][realtime]",
                   float, double) {
    using T = TestType;
    Random random{96};
    for (auto& scene : scenes<T>()) {
        const Counted counted{scene.terrain.grid()};
        const glm::dvec2 low = scene.terrain.low(), high = scene.terrain.high();
        for (const int max_cells : {0, 1, 8, 64}) {
            Friction<T> friction{{T(0.625), T(0.375)}, max_cells};
            int most = 0;
            for (int n = 0; n < 2000; ++n) {
                // Contacts at random, far from each other: on grid lines and vertices as well.
                Contact<T> contact;
                contact.status = ContactStatus::contact;
                contact.side = Side::above;
                contact.depth = T(1);
                const auto part = [&] { return static_cast<T>(random.whole(0, 8)) / T(8); };
                contact.point = {
                    {random.whole(0, scene.terrain.columns - 2), random.whole(0, scene.terrain.rows - 2)},
                    part(),
                    part()};
                const vec3<T> at{static_cast<T>(random.between(low.x, high.x)),
                                 static_cast<T>(random.between(low.y, high.y)),
                                 static_cast<T>(random.between(-20, 20))};
                counted.patches = 0;
                const auto held = friction.hold(counted, contact, at);
                REQUIRE(is_finite(held.penetration));
                most = std::max(most, counted.patches);
            }
            CAPTURE(scene.name, max_cells, most);
            // Three of the anchor, two at a bend, two in the end, and of a cell on the way itself, its crease at the start, and on a way
            // along a crease the neighbour at every other point looked at.
            CHECK(most <= 3 + 2 + 2 + 7 * max_cells + 66);
        }
    }
}

TEMPLATE_TEST_CASE("Friction: first contact sets the anchor, release clears it, bad input leaves it",
                   "[friction]", float, double) {
    using T = TestType;
    const T nan = std::numeric_limits<T>::quiet_NaN();
    const auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid};
    Friction<T> friction{{T(1), T(0.5)}};
    const auto feel = [&](T x, T z) {
        const vec3<T> at{x, T(4.25), z};
        return friction.hold(grid, tracker.update(at), at);
    };
    CHECK_FALSE(feel(T(3.25), T(1)).touching());
    CHECK(friction.state().side == Side::none);
    CHECK(feel(T(3.25), T(-0.25)).penetration == vec3<T>{T(0), T(0), T(0.25)});
    CHECK(feel(T(3.375), T(-0.25)).penetration == vec3<T>{T(-0.125), T(0), T(0.25)});
    const auto before = friction.state();
    CHECK(feel(nan, T(-0.25)).status == ContactStatus::bad_input);
    CHECK(same(friction.state().anchor, before.anchor));
    CHECK(friction.state().side == before.side);
    CHECK(feel(T(3.375), T(-0.25)).penetration == vec3<T>{T(-0.125), T(0), T(0.25)});
    // It slips at 0.25 to the side, to half the depth, and then holds again until 0.25.
    CHECK(feel(T(3.5), T(-0.25)).penetration.x == T(-0.25));
    CHECK(feel(T(3.5625), T(-0.25)).penetration.x == Approx(-0.125).margin(16 * double(epsilon<T>)));
    CHECK(friction.state().slipping);
    CHECK(feel(T(3.625), T(-0.25)).penetration.x == Approx(-0.125).margin(16 * double(epsilon<T>)));
    CHECK(friction.state().slipping);
    CHECK(feel(T(3.5625), T(-0.25)).penetration.x == Approx(-0.0625).margin(16 * double(epsilon<T>)));
    CHECK_FALSE(friction.state().slipping);
    CHECK(feel(T(3.6875), T(-0.25)).penetration.x == Approx(-0.1875).margin(16 * double(epsilon<T>)));
    CHECK_FALSE(friction.state().slipping);
    // As the hand lifts the cone shrinks and the tangential force with it; free: gone.
    for (const double depth : {0.1, 0.01, 0.001}) {
        const auto c = feel(T(3.6875), static_cast<T>(-depth));
        CHECK(std::abs(double(c.penetration.x)) <= 0.5 * depth + 16 * double(epsilon<T>));
    }
    CHECK_FALSE(feel(T(3.6875), T(0.5)).touching());
    CHECK(friction.state().side == Side::none);
    CHECK(feel(T(5), T(-0.25)).penetration.x == Approx(0).margin(64 * double(epsilon<T>)));
    friction.reset();
    CHECK(friction.state().side == Side::none);
}

TEMPLATE_TEST_CASE("Friction: an edit moves the anchor with its ground, a hole lets it go", "[friction]",
                   float, double) {
    using T = TestType;
    auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    ProxyTracker tracker{grid};
    Friction<T> friction{{T(1), T(1)}};
    const auto feel = [&](T x) {
        const vec3<T> at{x, T(4.25), T(-0.5)};
        return friction.hold(grid, tracker.update(at), at);
    };
    const vec3<T> above{T(2.25), T(4.25), T(1)};
    static_cast<void>(friction.hold(grid, tracker.update(above), above));
    static_cast<void>(feel(T(2.25)));
    CHECK(feel(T(2.5)).penetration == vec3<T>{T(-0.25), T(0), T(0.5)});
    for (auto& h : ground.heights) h = T(0.25);
    CHECK(feel(T(2.5)).penetration == vec3<T>{T(-0.25), T(0), T(0.75)});
    CHECK(feel(T(2.5)).proxy == vec3<T>{T(2.25), T(4.25), T(0.25)});
    for (auto& h : ground.heights) h = T(0);
    // The hand is past x = 3; the anchor on cell 2, which goes.
    CHECK(feel(T(2.75)).penetration == vec3<T>{T(-0.5), T(0), T(0.5)});
    static_cast<void>(feel(T(3.25)));
    REQUIRE(friction.state().anchor.cell == Cell{2, 4});
    ground.remove(2, 4);
    const auto free = feel(T(3.25));
    REQUIRE(free.touching());
    CHECK(free.penetration == vec3<T>{T(0), T(0), T(0.5)});
    CHECK(friction.state().anchor.cell == Cell{3, 4});
}

TEMPLATE_TEST_CASE("Friction: a way that leads over a hole, or too far, gives no hold", "[friction]", float,
                   double) {
    using T = TestType;
    auto ground = plane<T>(40, 9);
    for (Index j = 3; j < 7; ++j) ground.remove(12, j);
    const auto grid = ground.grid();
    const auto contact_at = [&](T x) {
        Contact<T> c;
        c.status = ContactStatus::contact;
        c.side = Side::above;
        c.depth = T(0.25);
        c.penetration.z = T(0.25);
        c.point = {{static_cast<Index>(x), 4}, x - std::floor(x), T(0.5)};
        c.proxy = {x, T(4.5), T(0)};
        return c;
    };
    const auto jump = [&](T from, T to, int max_cells) {
        Friction<T> friction{{T(0.5), T(0.5)}, max_cells};
        static_cast<void>(friction.hold(grid, contact_at(from), {from, T(4.5), T(-0.25)}));
        return friction.hold(grid, contact_at(to), {to, T(4.5), T(-0.25)}).penetration.x;
    };
    CHECK(jump(T(20.5), T(24.5), 64) == Approx(-0.125).margin(64 * double(epsilon<T>)));
    CHECK(jump(T(20.5), T(24.5), 5) == Approx(-0.125).margin(64 * double(epsilon<T>)));
    CHECK(jump(T(20.5), T(24.5), 4) == 0);  // five cells, four allowed
    CHECK(jump(T(10.5), T(15.5), 64) == 0); // the hole
    CHECK(jump(T(15.5), T(10.5), 64) == 0);
}

TEMPLATE_TEST_CASE("Friction: on the other side of a sheet it takes hold anew", "[friction]", float, double) {
    using T = TestType;
    const auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    Friction<T> friction{{T(1), T(1)}};
    const auto feel = [&](T x, T z) {
        Contact<T> c;
        c.status = ContactStatus::contact;
        c.side = z < 0 ? Side::above : Side::below;
        c.depth = std::abs(z);
        c.penetration.z = -z;
        c.point = {{4, 4}, x - T(4), T(0.5)};
        return friction.hold(grid, c, {x, T(4.5), z}).penetration.x;
    };
    CHECK(feel(T(4.25), T(-0.5)) == 0);
    CHECK(feel(T(4.5), T(-0.5)) == T(-0.25));
    CHECK(feel(T(4.5), T(0.5)) == 0);
    CHECK(feel(T(4.75), T(0.5)) == T(-0.25));
    CHECK(feel(T(4.75), T(-0.5)) == 0);
}

TEMPLATE_TEST_CASE(
    "Friction: to a proxy on an edge it slips straight unless it is drawn there, to one on a vertex by "
    "the nearer edge",
    "[friction]", float, double) {
    using T = TestType;
    auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    // The anchor, from the middle of cell (4, 4), when the stylus is `deep` below level ground, and the proxy elsewhere.
    const auto slipped = [&](const SurfacePoint<T>& proxy, const vec2<T>& stylus, T deep) {
        Friction<T> friction{{T(1), T(1)}};
        Contact<T> contact;
        contact.status = ContactStatus::contact;
        contact.side = Side::above;
        contact.depth = contact.penetration.z = deep;
        contact.point = {{4, 4}, T(0.5), T(0.5)};
        static_cast<void>(friction.hold(grid, contact, {T(4.5), T(4.5), -deep}));
        contact.point = proxy;
        contact.proxy = {static_cast<T>(proxy.cell.i) + proxy.u, static_cast<T>(proxy.cell.j) + proxy.v,
                         T(0)};
        return friction.hold(grid, contact, {stylus, -deep}).proxy;
    };
    // Away from the edge and along it: the straight way comes as near as 0.38, the edge itself does not.
    const vec3<T> east = slipped({{5, 4}, T(0), T(0.75)}, {T(4.45), T(4.9)}, T(0.39));
    CHECK(east.x > T(4.5));
    CHECK(east.x - T(4.5) == Approx(2 * double(east.y - T(4.5))).epsilon(1e-3));
    CHECK(std::hypot(east.x - T(4.45), east.y - T(4.9)) == Approx(0.39).epsilon(1e-5));
    const vec3<T> north = slipped({{4, 5}, T(0.75), T(0)}, {T(4.9), T(4.45)}, T(0.39));
    CHECK(std::abs(north.x - east.y) <= 64 * epsilon<T>);
    CHECK(std::abs(north.y - east.x) <= 64 * epsilon<T>);
    // Drawn by (0.6, 1.2), so first over the northern edge.
    const vec3<T> first = slipped({{5, 5}, T(0), T(0)}, {T(5.1), T(5.7)}, T(1));
    CHECK(first.y - T(4.5) == Approx(2 * double(first.x - T(4.5))).epsilon(1e-3));
    CHECK(std::hypot(first.x - T(5.1), first.y - T(5.7)) == Approx(1).epsilon(1e-5));
    const vec3<T> second = slipped({{5, 5}, T(0), T(0)}, {T(5.7), T(5.1)}, T(1));
    CHECK(std::abs(second.x - first.y) <= 64 * epsilon<T>);
    CHECK(std::abs(second.y - first.x) <= 64 * epsilon<T>);
    // Drawn to the eastern edge at y = 4.8, where the cell beyond is missing; the straight way goes round it.
    const auto round = [&] { return slipped({{5, 5}, T(0), T(0.5)}, {T(5.1), T(4.86)}, T(0.5)); };
    CHECK(round().y < T(4.8));
    ground.remove(6, 4);
    CHECK(round().y - T(4.5) == Approx(2 * double(round().x - T(4.5))).epsilon(1e-3));
    CHECK(std::hypot(round().x - T(5.1), round().y - T(4.86)) == Approx(0.5).epsilon(1e-5));
    // A bend behind a hole holds nothing, though the stylus is right under it.
    CHECK(slipped({{7, 5}, T(0), T(0.5)}, {T(7.1), T(4.9)}, T(0.5)) == vec3<T>{T(7), T(5.5), T(0)});
}

TEMPLATE_TEST_CASE("Friction: a contact without depth, as of a proxy on its way, is returned as it is",
                   "[friction]", float, double) {
    using T = TestType;
    const auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    Friction<T> friction{{T(1), T(1)}};
    const vec3<T> stylus{T(4.25), T(4.5), T(-0.5)};
    Contact<T> contact;
    contact.status = ContactStatus::contact;
    contact.side = Side::above;
    contact.depth = contact.penetration.z = T(0.5);
    contact.point = {{4, 4}, T(0.25), T(0.5)};
    static_cast<void>(friction.hold(grid, contact, stylus));
    contact.status = ContactStatus::descent_limit;
    contact.depth = contact.penetration.z = 0;
    contact.point.u = T(0.75);
    CHECK(friction.hold(grid, contact, stylus).penetration == vec3<T>{T(0)});
    CHECK(same(friction.state().anchor, contact.point));
}

TEMPLATE_TEST_CASE("Friction: on the way up a face that holds the stylus the anchor ends at its foot",
                   "[friction]", float, double) {
    using T = TestType;
    // A floor, and from x = 4 a face of 45 degrees. The stylus presses on the face, a little up from its foot; the floor
    // does not hold it, the face does all over.
    const auto ground = terrain<T>(9, 9, [](Index i, Index) { return double(std::max<Index>(i - 4, 0)); });
    const auto grid = ground.grid();
    const T half = std::sqrt(T(0.5));
    const vec3<T> normal{-half, T(0), half}, up{half, T(0), half};
    const vec3<T> foot{T(4), T(4.5), T(0)}, proxy = foot + T(0.04) * up, stylus = proxy - T(0.5) * normal;
    Contact<T> contact;
    contact.status = ContactStatus::contact;
    contact.side = Side::above;
    contact.depth = T(0.25);
    contact.penetration.z = T(0.25);
    contact.point = {{3, 4}, T(0.75), T(0.5)};
    Friction<T> friction{{T(0.25), T(0.25)}};
    static_cast<void>(friction.hold(grid, contact, {T(3.75), T(4.5), T(-0.25)}));
    contact.depth = T(0.5);
    contact.penetration = T(0.5) * normal;
    contact.point = {{4, 4}, T(0.04) * half, T(0.5)};
    contact.proxy = proxy;
    const auto held = friction.hold(grid, contact, stylus);
    CHECK(held.proxy.x == Approx(4).margin(16 * double(epsilon<T>)));
    CHECK(same(held.point, SurfacePoint<T>{{4, 4}, T(0), T(0.5)}));
    CHECK(glm::length(held.penetration - (foot - stylus)) <= 16 * epsilon<T>);
}

TEMPLATE_TEST_CASE(
    "Friction: on the way over a ridge the anchor stays on it while a normal between its faces holds",
    "[friction]", float, double) {
    using T = TestType;
    // A ridge along x = 4 with faces of 45 degrees. The stylus is under the far face, a quarter of a metre from the ridge
    // and half a metre deep: a normal of the ridge points straight from it.
    const auto ground = terrain<T>(9, 9, [](Index i, Index) { return -std::abs(double(i) - 4); });
    const auto grid = ground.grid();
    const T half = std::sqrt(T(0.5));
    const vec3<T> near{-half, T(0), half}, far{half, T(0), half};
    Contact<T> contact;
    contact.status = ContactStatus::contact;
    contact.side = Side::above;
    contact.depth = T(0.5);
    contact.penetration = T(0.5) * near;
    contact.point = {{3, 4}, T(0.75), T(0.5)};
    Friction<T> friction{{T(0.25), T(0.25)}};
    static_cast<void>(friction.hold(grid, contact, vec3<T>{T(3.75), T(4.5), T(-0.25)} - T(0.5) * near));
    contact.penetration = T(0.5) * far;
    contact.point = {{4, 4}, T(0.25) * half, T(0.5)};
    contact.proxy = {T(4) + T(0.25) * half, T(4.5), T(-0.25) * half};
    const auto held = friction.hold(grid, contact, contact.proxy - T(0.5) * far);
    CHECK(held.proxy.x == Approx(4).margin(16 * double(epsilon<T>)));
    CHECK(same(held.point, SurfacePoint<T>{{4, 4}, T(0), T(0.5)}));
}

TEMPLATE_TEST_CASE("Friction: coefficients that are none mean no friction", "[friction]", float, double) {
    using T = TestType;
    const T nan = std::numeric_limits<T>::quiet_NaN(), inf = std::numeric_limits<T>::infinity();
    const auto ground = tilted_plane<T>(9, 9, 0.5, 0.25);
    const auto grid = ground.grid();
    for (const auto& [at_rest, sliding] : {std::pair{nan, T(0.5)},
                                           {T(0.5), nan},
                                           {inf, T(0.5)},
                                           {T(0.5), inf},
                                           {T(-1), T(0.5)},
                                           {T(0.5), T(-1)},
                                           {-inf, T(0.5)},
                                           {T(0.5), -nan}}) {
        ProxyTracker tracker{grid};
        Friction<T> friction{{at_rest, sliding}};
        for (int n = 0; n < 100; ++n) {
            const vec3<T> at{T(2) + T(n) / 32, T(4), n == 0 ? T(20) : T(1.5)};
            const auto free = tracker.update(at);
            CHECK(friction.hold(grid, free, at).penetration == free.penetration);
        }
    }
    // A static coefficient below the dynamic one counts as equal to it.
    ProxyTracker tracker{grid};
    Friction<T> friction{{T(0), T(0.5)}};
    for (int n = 0; n < 4; ++n) {
        const vec3<T> at{T(2) + T(n) / 1024, T(4), n == 0 ? T(20) : T(1.5)};
        static_cast<void>(friction.hold(grid, tracker.update(at), at));
        if (n > 1) CHECK_FALSE(friction.state().slipping);
    }
}

namespace {

/// A hand that ploughs through rough ground, two cells deep, from one corner to the other and back: what it feels at each
/// place, with shading or without.
template <Real T, class Each>
void plough(const Terrain<T>& ground, SurfaceKind kind, bool shaded, Friction<T>& friction, Each each) {
    const auto grid = ground.grid();
    const Surface<T> surface{ground};
    ProxyTracker tracker{grid, {.surface = kind}};
    const glm::dvec2 low = ground.low(), way = ground.high() - low;
    const double cell = ground.frame.spacing.x;
    const int count = static_cast<int>(2 * glm::length(way) / cell);
    for (int n = -1; n < 2 * count; ++n) {
        const double s = 0.15 + 0.7 * std::abs(1 - std::max(n, 0) / static_cast<double>(count));
        const double x = low.x + way.x * s, y = low.y + way.y * s * s;
        const vec3<T> at{
            static_cast<T>(x), static_cast<T>(y),
            static_cast<T>(*surface.height(Wide(x), Wide(y)) + Wide(n < 0 ? 30 * cell : -2 * cell))};
        const auto free = tracker.update(at);
        const auto before = friction.state();
        each(grid, free, before, friction.hold(grid, shaded ? shade_force(grid, free) : free, at), at);
    }
}

} // namespace

TEMPLATE_TEST_CASE("Friction: a shaded contact is held inside the cone of the shaded normal",
                   "[friction][law]", float, double) {
    using T = TestType;
    constexpr T at_rest = T(0.5), sliding = T(0.375);
    int stuck = 0, slipped = 0, turned = 0;
    for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
        for (const auto& scene : scenes<T>()) {
            const Surface<T> surface{scene.terrain};
            Friction<T> friction{{at_rest, sliding}};
            plough(
                scene.terrain, kind, true, friction,
                [&](const auto& grid, const Contact<T>& free, const FrictionState<T>& before,
                    const Contact<T>& held, const vec3<T>& at) {
                    if (!held.touching() || !(free.depth > 0)) return;
                    const auto& after = friction.state();
                    REQUIRE(same(held.point, after.anchor));
                    const Point push = surface.position(wide(after.anchor)) - wide(at), n = wide(held.normal);
                    const Wide size = length(push), eps = static_cast<Wide>(epsilon<T>);
                    const auto patch = surface.patch(after.anchor.cell.i, after.anchor.cell.j);
                    const Wide slack = 64 * eps *
                                       (size + std::abs(wide(at).z) + std::abs(wide(at).x) +
                                        std::abs(wide(at).y) + patch->reach({}));
                    const Wide most = static_cast<Wide>(after.slipping ? sliding : at_rest);
                    const Point force = wide(held.penetration);
                    // Turned, at most; inside the cone; no pull along the normal; not into the face.
                    REQUIRE(std::abs(length(force) - size) <= slack);
                    REQUIRE(static_cast<Wide>(held.depth) == Approx(double(size)).margin(double(slack)));
                    REQUIRE(length(cross(force, n)) <= most * dot(force, n) + 4 * slack);
                    REQUIRE(dot(force, n) >= 0);
                    const bool inside =
                        after.anchor.u > 0 && after.anchor.u < 1 && after.anchor.v > 0 && after.anchor.v < 1;
                    const Point face = patch->normal(wide(after.anchor).u, wide(after.anchor).v);
                    const Wide side = after.side == Side::below ? Wide(-1) : Wide(1);
                    if (inside && side * dot(push, face) > slack) REQUIRE(side * dot(force, face) >= -slack);
                    const bool is_turned = length(force - push) > slack;
                    const auto slopes = *shaded_slopes(grid, held.point);
                    const Point mean = wide(glm::normalize(vec3<T>{-slopes, T(1)}));
                    if (inside && dot(mean, face) > 0)
                        REQUIRE(length(n - Point{side * mean.x, side * mean.y, side * mean.z}) <= 64 * eps);
                    turned += is_turned;
                    slipped += after.slipping;
                    if (!after.slipping && same(before.anchor, after.anchor)) {
                        ++stuck; // and what sticks is the anchor itself, its force that of the spring
                        REQUIRE_FALSE(is_turned);
                    }
                });
        }
    }
    CAPTURE(stuck, slipped, turned);
    CHECK(stuck > 300);
    CHECK(slipped > 500);
    CHECK(turned > 50);
}

TEMPLATE_TEST_CASE("Friction: the force is no less steady with shading than without", "[friction]", float,
                   double) {
    using T = TestType;
    // The mean step of the force, in metres of penetration.
    const auto unsteadiness = [](bool shaded) {
        Friction<T> friction{};
        double sum = 0;
        vec3<T> last{T(0)};
        const auto ground = rough_in_steps<T>(60, 60, 0.5, 77);
        plough(ground, SurfaceKind::solid, shaded, friction,
               [&](const auto&, const auto&, const auto&, const Contact<T>& held, const auto&) {
                   if (last != vec3<T>{T(0)})
                       sum += static_cast<double>(glm::length(held.penetration - last));
                   last = held.penetration;
               });
        return sum;
    };
    CHECK(unsteadiness(true) < 0.8 * unsteadiness(false));
}

TEST_CASE("Friction: its state is small and plain", "[friction]") {
    static_assert(std::is_trivially_copyable_v<FrictionState<double>> &&
                  std::is_trivially_copyable_v<Friction<float>>);
    static_assert(sizeof(FrictionState<double>) <= 40 && sizeof(FrictionState<float>) <= 32);
    using Grid = Terrain<double>::Grid;
    static_assert(noexcept(std::declval<Friction<double>&>().hold(std::declval<const Grid&>(),
                                                                  std::declval<const Contact<double>&>(),
                                                                  std::declval<const vec3<double>&>())));
    Friction<double> friction;
    FrictionState<double> state;
    state.side = Side::above;
    state.anchor.cell = {3, 4};
    friction.restore(state);
    CHECK(friction.state().anchor.cell == Cell{3, 4});
}
