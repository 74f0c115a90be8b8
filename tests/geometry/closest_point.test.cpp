#include "catch.hpp"
#include "support/reference.hpp"

#include <hfh/geometry/closest_point.hpp>

using namespace hfh;
using namespace hfh::test;

namespace {

template <Real T>
WidePatch wide(const BilinearPatch<T>& p) {
    return {static_cast<Wide>(p.p00), static_cast<Wide>(p.p10),       static_cast<Wide>(p.p01),
            static_cast<Wide>(p.p11), static_cast<Wide>(p.spacing.x), static_cast<Wide>(p.spacing.y)};
}
template <Real T>
Point wide(const BilinearPatch<T>& p, const CellPoint<T>& q) {
    return {static_cast<Wide>(q.u) * static_cast<Wide>(p.spacing.x),
            static_cast<Wide>(q.v) * static_cast<Wide>(p.spacing.y), static_cast<Wide>(q.z)};
}

template <Real T>
struct Case {
    BilinearPatch<T> patch;
    CellPoint<T> query;
    vec2<T> start;
};

template <Real T>
std::string describe(const Case<T>& c) {
    std::string text = "corners";
    for (const T x : {c.patch.p00, c.patch.p10, c.patch.p01, c.patch.p11}) text += ' ' + digits(double(x));
    text += ", spacing " + digits(double(c.patch.spacing.x)) + ' ' + digits(double(c.patch.spacing.y));
    text += ", query " + digits(double(c.query.u)) + ' ' + digits(double(c.query.v)) + ' ' +
            digits(double(c.query.z));
    return text + ", start " + digits(double(c.start.x)) + ' ' + digits(double(c.start.y));
}

double logarithmic(Random& random, double low, double high) {
    return low * std::pow(high / low, random.unit());
}

/// A start: anywhere, often on an edge or at a corner.
template <Real T>
T parameter(Random& random) {
    return random.one_in(4) ? T(random.whole(0, 1)) : static_cast<T>(random.unit());
}

/// Patches of all shapes, with a query at a given distance from a point of the patch's plane.
template <Real T>
Case<T> any_case(Random& random, double relief, double depth, double aspect) {
    Case<T> c;
    const double size = logarithmic(random, 1e-3, 1e3); // metres; relief and depth are in cells
    c.patch.spacing = {static_cast<T>(size), static_cast<T>(size * aspect)};
    const auto corner = [&] {
        return random.one_in(8) ? T(0) : static_cast<T>(size * random.between(0, relief));
    };
    c.patch.p00 = corner();
    c.patch.p10 = corner();
    c.patch.p01 = corner();
    c.patch.p11 = random.one_in(8) ? c.patch.p10 + c.patch.p01 - c.patch.p00 : corner();
    const T u = static_cast<T>(random.between(-0.25, 1.25)), v = static_cast<T>(random.between(-0.25, 1.25));
    const vec3<T> n = c.patch.normal(u, v);
    const T d = static_cast<T>(size * depth * (random.one_in(2) ? 1 : -1));
    c.query = {u + d * n.x / c.patch.spacing.x, v + d * n.y / c.patch.spacing.y,
               c.patch.height(u, v) + d * n.z};
    c.start = {parameter<T>(random), parameter<T>(random)};
    return c;
}

/// The three input families: trivial, tiny, random; the last up to 30 cells of relief, 20 cells of depth and cells
/// eight times as long as wide.
template <Real T>
Case<T> law_case(Random& random, int family) {
    if (family == 0) {
        Case<T> c;
        const auto small = [&] { return static_cast<T>(random.whole(-1, 1)); };
        c.patch = {small(), small(), small(), small(), vec2<T>{T(1)}};
        c.query = {small() / 2 + T(0.5), small() / 2 + T(0.5), small()};
        c.start = {small() / 2 + T(0.5), small() / 2 + T(0.5)};
        return c;
    }
    if (family == 1) return any_case<T>(random, 1e-6, logarithmic(random, 1e-9, 1e-6), 1);
    return any_case<T>(random, logarithmic(random, 1e-3, 30), logarithmic(random, 1e-6, 20),
                       logarithmic(random, 0.125, 8));
}

} // namespace

TEMPLATE_TEST_CASE("newton_closest_point: along a border it takes the step that it would take inside",
                   "[closest_point][eq:11]", float, double) {
    using T = TestType;
    // A plane that rises along one axis: one step is exact. One that ran on to the next border would need another.
    const T slope = T(0.5), q = T(1.25), gap = T(-0.25);
    const T foot = (q + slope * gap) / (T(1) + slope * slope);
    for (const T border : {T(0), T(1)}) {
        const BilinearPatch<T> along_u{T(0), slope, T(0), slope}, along_v{T(0), T(0), slope, slope};
        const auto a = newton_closest_point(along_u, CellPoint<T>{q, border, gap}, {T(0.125), border});
        CHECK(a.status == NewtonStatus::converged);
        CHECK(a.iterations == 1);
        CHECK(std::abs(a.u - foot) <= 4 * epsilon<T>);
        CHECK(a.v == border);
        const auto b = newton_closest_point(along_v, CellPoint<T>{border, q, gap}, {border, T(0.125)});
        CHECK(b.status == NewtonStatus::converged);
        CHECK(b.iterations == 1);
        CHECK(b.u == border);
        CHECK(std::abs(b.v - foot) <= 4 * epsilon<T>);
    }
}

TEMPLATE_TEST_CASE("DistanceFunction: its derivatives are those of half the squared distance",
                   "[closest_point][law][eq:8][eq:9][eq:10][eq:11]", float, double) {
    // ½ distance² is of degree 2 in u and in v, so central differences are exact for any step, up to rounding. Each
    // derivative is a sum of products of two of: cell size, query distance, heights; a dozen roundings at most.
    using T = TestType;
    Random random{11};
    for (int n = 0; n < 30000; ++n) {
        const auto c = law_case<T>(random, n % 3);
        const WidePatch p = wide(c.patch);
        const Point q = wide(c.patch, c.query);
        const Wide u = static_cast<Wide>(c.start.x), v = static_cast<Wide>(c.start.y), h = 0.25L;
        const auto f = [&](Wide a, Wide b) { return p.half_square(a, b, q); };
        const auto value = DistanceFunction<T>{c.patch, c.query}(c.start.x, c.start.y);
        const Wide tolerance = 12 * static_cast<Wide>(epsilon<T>);
        const Slopes s = slopes(p, u, v, q);
        const Wide fu = (f(u + h, v) - f(u - h, v)) / (2 * h), fv = (f(u, v + h) - f(u, v - h)) / (2 * h);
        const Wide fuu = (f(u + h, v) - 2 * f(u, v) + f(u - h, v)) / (h * h);
        const Wide fvv = (f(u, v + h) - 2 * f(u, v) + f(u, v - h)) / (h * h);
        const Wide fuv =
            (f(u + h, v + h) - f(u + h, v - h) - f(u - h, v + h) + f(u - h, v - h)) / (4 * h * h);
        INFO(describe(c));
        // The differences themselves lose epsilon of the largest f.
        const Wide rounding = 64 * std::numeric_limits<Wide>::epsilon() * p.reach(q) * p.reach(q) / (h * h);
        REQUIRE(std::abs(static_cast<Wide>(value.fu) - fu) <= tolerance * s.scale_u + rounding);
        REQUIRE(std::abs(static_cast<Wide>(value.fv) - fv) <= tolerance * s.scale_v + rounding);
        REQUIRE(std::abs(static_cast<Wide>(value.fuu) - fuu) <= tolerance * s.scale_u + rounding);
        REQUIRE(std::abs(static_cast<Wide>(value.fvv) - fvv) <= tolerance * s.scale_v + rounding);
        REQUIRE(std::abs(static_cast<Wide>(value.fuv) - fuv) <=
                tolerance * (s.scale_u + s.scale_v) + rounding);
        REQUIRE(std::abs(static_cast<Wide>(value.z) - (p.height(u, v) - q.z)) <=
                tolerance * static_cast<Wide>(std::max(
                                std::abs(c.query.z), c.patch.highest() - std::min(c.patch.lowest(), T(0)))));
    }
}

TEMPLATE_TEST_CASE("DistanceFunction: change is the difference of two values", "[closest_point][law][eq:8]",
                   float, double) {
    using T = TestType;
    Random random{12};
    for (int n = 0; n < 30000; ++n) {
        const auto c = law_case<T>(random, n % 3);
        const WidePatch p = wide(c.patch);
        const Point q = wide(c.patch, c.query);
        const DistanceFunction<T> distance{c.patch, c.query};
        const T du = static_cast<T>(random.between(-1, 1)), dv = static_cast<T>(random.between(-1, 1));
        const Wide u = static_cast<Wide>(c.start.x), v = static_cast<Wide>(c.start.y);
        const Wide expected =
            p.half_square(u + static_cast<Wide>(du), v + static_cast<Wide>(dv), q) - p.half_square(u, v, q);
        const Slopes s = slopes(p, u, v, q);
        INFO(describe(c) << " step " << digits(double(du)) << ' ' << digits(double(dv)));
        // Sixteen roundings of terms no larger than the scales of the derivatives, for steps of a cell at most.
        REQUIRE(
            std::abs(static_cast<Wide>(distance.change(distance(c.start.x, c.start.y), du, dv)) - expected) <=
            16 * static_cast<Wide>(epsilon<T>) * (s.scale_u + s.scale_v) +
                64 * std::numeric_limits<Wide>::epsilon() * p.reach(q) * p.reach(q));
    }
}

TEMPLATE_TEST_CASE("newton_closest_point: ends at a local minimum, no farther than the start",
                   "[closest_point][law][eq:10]", float, double) {
    using T = TestType;
    Random random{13};
    int most = 0, wrong = 0;
    Wide steepest = 0;
    for (int n = 0; n < 300000; ++n) {
        const auto c = law_case<T>(random, n % 3);
        const auto foot = newton_closest_point(c.patch, c.query, c.start);
        const WidePatch p = wide(c.patch);
        const Point q = wide(c.patch, c.query);
        most = std::max(most, foot.iterations);
        const Wide fall = fall_into<T>(p, static_cast<Wide>(foot.u), static_cast<Wide>(foot.v), q);
        steepest = std::max(steepest, fall);
        const Wide before = p.half_square(static_cast<Wide>(c.start.x), static_cast<Wide>(c.start.y), q);
        const Wide after = p.half_square(static_cast<Wide>(foot.u), static_cast<Wide>(foot.v), q);
        // A step is taken on the strength of a computed change, which is wrong by no more than the ulp-scale.
        const Slopes s = slopes(p, static_cast<Wide>(foot.u), static_cast<Wide>(foot.v), q);
        const Wide rounding = 16 * static_cast<Wide>(epsilon<T>) * (s.scale_u + s.scale_v);
        if (foot.status != NewtonStatus::converged ||
            !(foot.u >= 0 && foot.u <= 1 && foot.v >= 0 && foot.v <= 1) || fall > 64 ||
            after > before + rounding) {
            INFO(describe(c));
            INFO("foot " << digits(double(foot.u)) << ' ' << digits(double(foot.v)) << " after "
                         << foot.iterations << " iterations, fall " << double(fall) << " ulp-scales");
            CHECK(foot.status == NewtonStatus::converged);
            CHECK((foot.u >= 0 && foot.u <= 1 && foot.v >= 0 && foot.v <= 1));
            CHECK(fall <= 64);
            CHECK(after <= before + rounding);
            if (++wrong == 3) break;
        }
        if (foot.status == NewtonStatus::converged) {
            const Wide gap = p.height(static_cast<Wide>(foot.u), static_cast<Wide>(foot.v)) - q.z;
            REQUIRE(std::abs(static_cast<Wide>(foot.gap) - gap) <=
                    8 * static_cast<Wide>(epsilon<T>) * p.reach(q));
        }
    }
    CAPTURE(most, double(steepest));
    CHECK(most < NewtonOptions{}.max_iterations);
}

TEMPLATE_TEST_CASE(
    "newton_closest_point: with BorderRule::stop it returns where the descent leaves the patch",
    "[closest_point][law]", float, double) {
    using T = TestType;
    Random random{14};
    int at_border = 0, converged = 0;
    for (int n = 0; n < 100000; ++n) {
        const auto c = law_case<T>(random, n % 3);
        const auto foot = newton_closest_point(c.patch, c.query, c.start, {.border = BorderRule::stop});
        const WidePatch p = wide(c.patch);
        const Point q = wide(c.patch, c.query);
        const Wide u = static_cast<Wide>(foot.u), v = static_cast<Wide>(foot.v);
        const Slopes s = slopes(p, u, v, q);
        const Wide eps = static_cast<Wide>(epsilon<T>);
        // How strongly the descent leads out across the border the foot is on.
        const Wide out_u = foot.u <= 0 ? s.fu : foot.u >= 1 ? -s.fu : Wide(-1);
        const Wide out_v = foot.v <= 0 ? s.fv : foot.v >= 1 ? -s.fv : Wide(-1);
        INFO(describe(c));
        INFO("foot " << digits(double(foot.u)) << ' ' << digits(double(foot.v)));
        if (foot.status == NewtonStatus::at_border) {
            ++at_border;
            if (!(out_u > 0 || out_v > 0)) FAIL("does not lead out");
        } else {
            ++converged;
            if (foot.status != NewtonStatus::converged) FAIL("did not end");
            if (std::abs(s.fu) > 64 * eps * s.scale_u || std::abs(s.fv) > 64 * eps * s.scale_v) {
                FAIL("not stationary");
            }
        }
        const Wide before = p.half_square(static_cast<Wide>(c.start.x), static_cast<Wide>(c.start.y), q);
        if (p.half_square(u, v, q) > before + 16 * eps * (s.scale_u + s.scale_v)) FAIL("went up");
    }
    CHECK(at_border > 1000);
    CHECK(converged > 1000);
}

TEMPLATE_TEST_CASE("newton_closest_point: is the closest point in shallow contact", "[closest_point][eq:10]",
                   float, double) {
    // Depth up to 0.1 cell and relief up to 3 cells, from below the surface as in contact. Started where a warm start
    // is: within a quarter of a cell of the vertical projection.
    using T = TestType;
    Random random{15};
    for (int n = 0; n < 3000; ++n) {
        auto c = any_case<T>(random, 3 * random.unit(), 0.1 * random.unit(), 1);
        c.start = {std::clamp(c.query.u, T(0), T(1)), std::clamp(c.query.v, T(0), T(1))};
        const auto foot = newton_closest_point(c.patch, c.query, c.start);
        const WidePatch p = wide(c.patch);
        const Point q = wide(c.patch, c.query);
        const Foot closest = search_closest_point(p, q);
        const Wide distance =
            std::sqrt(2 * p.half_square(static_cast<Wide>(foot.u), static_cast<Wide>(foot.v), q));
        // The bound: worse than the oracle by more than 1e-12 (double) or 4e-6 (float) of the reach is wrong.
        const Wide tolerance = (std::is_same_v<T, float> ? 4e-6L : 1e-12L) * p.reach(q);
        INFO(describe(c));
        INFO("foot " << digits(double(foot.u)) << ' ' << digits(double(foot.v)) << ", closest "
                     << digits(double(closest.u)) << ' ' << digits(double(closest.v)));
        REQUIRE(distance <= closest.distance + tolerance);
        REQUIRE(distance >= closest.distance - tolerance);
    }
}

TEMPLATE_TEST_CASE("newton_closest_point: needs few iterations in shallow contact", "[closest_point]", float,
                   double) {
    using T = TestType;
    Random random{16};
    int most = 0, sum = 0;
    const int count = 100000;
    for (int n = 0; n < count; ++n) {
        auto c = any_case<T>(random, 3 * random.unit(), 0.1 * random.unit(), 1);
        c.start = {std::clamp(c.query.u, T(0), T(1)), std::clamp(c.query.v, T(0), T(1))};
        const int iterations = newton_closest_point(c.patch, c.query, c.start).iterations;
        most = std::max(most, iterations);
        sum += iterations;
    }
    const double mean = static_cast<double>(sum) / count;
    CAPTURE(most, mean);
    CHECK(mean < 6);
    CHECK(most <= 32);
}

TEMPLATE_TEST_CASE("newton_closest_point: on flat ground the foot is straight above the query",
                   "[closest_point][eq:10]", float, double) {
    using T = TestType;
    const BilinearPatch<T> flat{T(7), T(7), T(7), T(7), {T(10), T(2.5)}};
    Random random{17};
    for (int n = 0; n < 1000; ++n) {
        const CellPoint<T> q{static_cast<T>(random.between(-0.5, 1.5)),
                             static_cast<T>(random.between(-0.5, 1.5)),
                             static_cast<T>(random.between(-20, 20))};
        const auto foot = newton_closest_point(flat, q, {T(0.25), T(0.75)});
        // Not within rounding: to the bit.
        CHECK(foot.u == std::clamp(q.u, T(0), T(1)));
        CHECK(foot.v == std::clamp(q.v, T(0), T(1)));
        CHECK(std::abs(foot.gap - (T(7) - q.z)) <= 64 * epsilon<T>); // two roundings of 27 m
    }
}

TEMPLATE_TEST_CASE("newton_closest_point: finds the foot on a tilted plane", "[closest_point][eq:10]", float,
                   double) {
    using T = TestType;
    // z = 3 + 2x − y over a cell of 4 m × 2 m; the foot of q is q − n (n·q − d) for the unit normal n.
    const BilinearPatch<T> plane{T(3), T(11), T(1), T(9), {T(4), T(2)}};
    for (const T depth : {T(-0.5), T(0), T(0.001), T(0.25), T(3)}) {
        for (const T u : {T(0.125), T(0.5), T(0.75)}) {
            const T v = T(0.625), l = std::sqrt(T(6));
            const T x = 4 * u + 2 * depth / l, y = 2 * v - depth / l, z = 3 + 8 * u - 2 * v - depth / l;
            const auto foot = newton_closest_point(plane, CellPoint<T>{x / 4, y / 2, z}, {T(0), T(0)});
            CAPTURE(depth, u);
            // The plane is linear: one Newton step, then rounding of coordinates up to 12 m over slopes of 2.
            CHECK(std::abs(foot.u - u) <= 16 * epsilon<T>);
            CHECK(std::abs(foot.v - v) <= 16 * epsilon<T>);
            CHECK(foot.iterations <= 4);
            CHECK(foot.status == NewtonStatus::converged);
        }
    }
}

TEMPLATE_TEST_CASE("newton_closest_point: ends on edges and at corners as on lines and points",
                   "[closest_point]", float, double) {
    using T = TestType;
    // z = 2x over 1 m × 1 m. Query beyond y = 1: on that edge the line (1, 2)/√5 in x and z decides.
    const BilinearPatch<T> plane{T(0), T(2), T(0), T(2), {T(1), T(1)}};
    const auto edge = newton_closest_point(plane, CellPoint<T>{T(0.5), T(3), T(0.25)}, {T(0.5), T(0.5)});
    CHECK(std::abs(edge.u - T(0.2)) <= 8 * epsilon<T>); // (0.5 + 2·0.25)/5
    CHECK(edge.v == 1);
    const auto corner = newton_closest_point(plane, CellPoint<T>{T(2), T(-1), T(5)}, {T(0.5), T(0.5)});
    CHECK(corner.u == 1);
    CHECK(corner.v == 0);
    CHECK(corner.gap == T(-3));
    CHECK(corner.status == NewtonStatus::converged);
}

TEMPLATE_TEST_CASE("newton_closest_point: on a saddle, either foot beyond the radius of curvature",
                   "[closest_point][hard][eq:11]", float, double) {
    using T = TestType;
    // z = m x y about the middle of a cell of 1 m, m = 4. Below the middle at depth d: the middle itself while
    // d ≤ 1/m; beyond that two equal feet at x = −y = ±√((d − 1/m)/m), at distance² 2x² + 1/m².
    const BilinearPatch<T> saddle{T(1), T(-1), T(-1), T(1), {T(1), T(1)}};
    const auto near = newton_closest_point(saddle, CellPoint<T>{T(0.5), T(0.5), T(-0.125)}, {T(0.1), T(0.7)});
    CHECK(std::abs(near.u - T(0.5)) <= 8 * epsilon<T>);
    CHECK(std::abs(near.v - T(0.5)) <= 8 * epsilon<T>);
    for (const T d : {T(0.3125), T(0.5), T(0.75)}) {
        const T x = std::sqrt((d - T(0.25)) / 4);
        for (const T start : {T(0.1), T(0.45), T(0.6), T(1)}) {
            const auto far = newton_closest_point(saddle, CellPoint<T>{T(0.5), T(0.5), -d}, {start, T(0.3)});
            CAPTURE(d, start, far.u, far.v);
            CHECK(std::abs(std::abs(far.u - T(0.5)) - x) <= 64 * epsilon<T>);
            CHECK(std::abs(far.u + far.v - 1) <= 64 * epsilon<T>);
        }
    }
}

TEMPLATE_TEST_CASE("newton_closest_point: says so when it may not iterate", "[closest_point]", float,
                   double) {
    using T = TestType;
    const BilinearPatch<T> patch{T(0), T(1), T(3), T(-2), {T(1), T(1)}};
    const CellPoint<T> query{T(0.7), T(0.2), T(-1)};
    const WidePatch p = wide(patch);
    const Point q = wide(patch, query);
    Wide last = p.half_square(0.9L, 0.9L, q) * (1 + 1e-6L);
    NewtonStatus status = NewtonStatus::iteration_limit;
    for (int limit = 0; limit < 64; ++limit) {
        const auto foot = newton_closest_point(patch, query, {T(0.9), T(0.9)}, {.max_iterations = limit});
        const Wide now = p.half_square(static_cast<Wide>(foot.u), static_cast<Wide>(foot.v), q);
        REQUIRE(foot.iterations <= limit);
        REQUIRE(now <= last * (1 + 4 * static_cast<Wide>(epsilon<T>)));
        if (limit == 0) {
            CHECK(foot.u == T(0.9));
            CHECK(foot.v == T(0.9));
        }
        if (limit <= 1) CHECK(foot.status == NewtonStatus::iteration_limit);
        if (status == NewtonStatus::converged) CHECK(foot.status == NewtonStatus::converged);
        last = now;
        status = foot.status;
    }
    CHECK(status == NewtonStatus::converged);
}

TEMPLATE_TEST_CASE("newton_closest_point: stays put when started at its own answer", "[closest_point][law]",
                   float, double) {
    using T = TestType;
    Random random{18};
    int moved = 0;
    for (int n = 0; n < 100000; ++n) {
        auto c = law_case<T>(random, n % 3);
        const auto foot = newton_closest_point(c.patch, c.query, c.start);
        c.start = {foot.u, foot.v};
        const auto again = newton_closest_point(c.patch, c.query, c.start);
        if (again.u != foot.u || again.v != foot.v) {
            if (moved++ == 0) {
                INFO(describe(c));
                INFO("then " << digits(double(again.u)) << ' ' << digits(double(again.v)));
                CHECK(again.u == foot.u);
                CHECK(again.v == foot.v);
            }
        }
    }
    CHECK(moved == 0);
}

TEMPLATE_TEST_CASE("newton_closest_point: converges in shallow valleys that lie across the cell",
                   "[closest_point][hard][regression]", float, double) {
    // Nearly plane patches, tilted along both axes, with the query far out along one of them: the valley of F runs
    // across u and v and its floor is all but straight. Found by random search; each ran into the iteration limit.
    using T = TestType;
    const double found[][11] = {
        {0.0313292992, 0.0327577781, 0.00987266026, 0.0113011375, 0.620993853, 0.118483029, 0.529678941,
         -7.36854362, -5.24597406, 0.559770167, 0},
        {0.35583164009214557, 0.34310828415968847, 0.43782694640831504, 0.42510359047585794,
         3.5544708895360424, 0.44903026569458393, 0.30478617172975808, 8.7815988015456341,
         -20.342473748543419, 0.19500635225920271, 0.92094037304063869},
        {41.256762225556933, 39.228342676947889, 31.351114407154512, 29.712628666171661, 83.362401637216209,
         19.819328469669781, 0.69762566755259714, -2.8861936995648581, -82.787524159014097,
         0.56712703864645246, 0.44136334613817263},
        {4.3931023339335535, 4.7824900728689732, 15.717116181876548, 16.106503920811967, 89.662866910519924,
         14.1938276369614, 0.80475174476667422, -17.26416790459578, 320.03796423902827, 0.44282818683581548,
         0.66140066782816398},
        // Cells of 1:200 and 1:340, the query a hundred cells away.
        {0.0013894706498831511, 0.0027974897529929876, 0.0057328757829964161, 0.0034397142007946968,
         0.3955841064453125, 0.00056828890228644013, 0.70501410961151123, -287.077392578125,
         0.056230530142784119, 0.33516848087310791, 1},
        {0.0064627074516608691, 0, 0.0032227860831172696, 0.0079930047682464905, 6.1578408719711426,
         0.018160694527373612, 0.78761305974921636, 68.304006439636467, -3.988082250510113, 0, 0},
    };
    for (const auto& d : found) {
        Case<T> c;
        c.patch = {T(d[0]), T(d[1]), T(d[2]), T(d[3]), {T(d[4]), T(d[5])}};
        c.query = {T(d[6]), T(d[7]), T(d[8])};
        c.start = {T(d[9]), T(d[10])};
        const auto foot = newton_closest_point(c.patch, c.query, c.start);
        INFO(describe(c));
        CHECK(foot.status == NewtonStatus::converged);
        CHECK(fall_into<T>(wide(c.patch), static_cast<Wide>(foot.u), static_cast<Wide>(foot.v),
                           wide(c.patch, c.query)) <= 64);
    }
}

TEMPLATE_TEST_CASE("newton_closest_point: does not take a badly rounded step for an arrival",
                   "[closest_point][hard][regression]", float, double) {
    // Nearly plane and steep (12 to 45 per cell): Newton's equations are ill-conditioned, and the rounding of their
    // solution leaves more of F_u and F_v than what the step leaves in theory. Each once ended a step too early, a
    // hundred ulp-scales off or where a second call moved on.
    using T = TestType;
    const double found[][11] = {
        {1225.4008739082897, 262.80407676711604, 1291.2254519426215, 328.62865480144774, 77.034429600615823,
         14.516478819700884, -0.059813058362843577, 0.71020057902405143, 1251.3911596032201,
         0.87524877290965419, 0.8259073670253122},
        {0.058129398352298405, 0.47879869637200084, 0.10448365165553176, 0.52515294967523429,
         0.073833440538977654, 0.0096280723329862129, 0.10413840988258932, 0.98768844438661829,
         0.1477231503678719, 0.70213151745940316, 0.35573916708375264},
        {3.8182641886416793, 0.23634729843338198, 1.3118002755937883, -2.2701166146145089,
         0.16187704750695867, 0.022307358044505281, 0.66464415035535396, 0.37235193422853202,
         0.51140351544704588, 0, 0.018779320690398671},
    };
    for (const auto& d : found) {
        Case<T> c;
        c.patch = {T(d[0]), T(d[1]), T(d[2]), T(d[3]), {T(d[4]), T(d[5])}};
        c.query = {T(d[6]), T(d[7]), T(d[8])};
        c.start = {T(d[9]), T(d[10])};
        const auto foot = newton_closest_point(c.patch, c.query, c.start);
        INFO(describe(c));
        CHECK(foot.status == NewtonStatus::converged);
        CHECK(fall_into<T>(wide(c.patch), static_cast<Wide>(foot.u), static_cast<Wide>(foot.v),
                           wide(c.patch, c.query)) <= 64);
        const auto again = newton_closest_point(c.patch, c.query, {foot.u, foot.v});
        CHECK(again.u == foot.u);
        CHECK(again.v == foot.v);
    }
}

TEMPLATE_TEST_CASE(
    "newton_closest_point: on patches level along one parameter a step from their border goes to the foot",
    "[closest_point][law]", float, double) {
    // What is level is met by the query's own parameter; along the other the patch is a straight line. From every border
    // and corner, to queries over borders and corners and beyond them, where differences and slopes are exactly zero.
    using T = TestType;
    constexpr T parameters[]{0, T(0.25), 1}, queries[]{-2, 0, T(0.25), T(0.5), 1, 3};
    // From every start. The patch rises by `rise` along one parameter; `over` is the foot's other one.
    const auto check = [&](const BilinearPatch<T>& patch, const CellPoint<T>& query, bool level_u, T over,
                           T foot, T along) {
        for (const T u : parameters) {
            for (const T v : parameters) {
                CAPTURE(u, v);
                const auto end = newton_closest_point(patch, query, {u, v});
                REQUIRE(end.status == NewtonStatus::converged);
                REQUIRE((level_u ? end.u : end.v) == over);
                REQUIRE(std::abs((level_u ? end.v : end.u) - foot) <=
                        16 * epsilon<T> * (1 + std::abs(along)));
                REQUIRE(end.iterations <= 3);
            }
        }
    };
    for (const T rise : {T(0), T(0.5), T(-2), T(100)}) {
        for (const bool level_u : {true, false}) {
            const auto patch = level_u ? BilinearPatch<T>{0, 0, rise, rise, {1, 1}}
                                       : BilinearPatch<T>{0, rise, 0, rise, {1, 1}};
            for (const T level : queries) {
                for (const T along : queries) {
                    // Right below, where nothing along the slope is to be done; and a metre below.
                    for (const T deep : {T(0), T(1)}) {
                        const T z = along * rise - deep;
                        const CellPoint<T> query =
                            level_u ? CellPoint<T>{level, along, z} : CellPoint<T>{along, level, z};
                        const T foot = std::clamp((along + z * rise) / (1 + rise * rise), T(0), T(1)),
                                over = std::clamp(level, T(0), T(1));
                        CAPTURE(rise, level_u, level, along, deep);
                        check(patch, query, level_u, over, foot, along);
                    }
                }
            }
        }
    }
}
