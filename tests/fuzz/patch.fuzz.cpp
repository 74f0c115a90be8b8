#include "bytes.hpp"

#include <hfh/geometry/global_closest_point.hpp>
#include <hfh/terrain/bilinear_grid.hpp>
#include <hfh/traversal/first_hit.hpp>

#include <array>

// One patch, one query: Newton's point, the global closest point, the first crossing.

namespace hfh::fuzz {
namespace {

using Wide = long double;

template <Real T>
constexpr Wide eps = static_cast<Wide>(epsilon<T>);
/// A few roundings among denormal numbers, which are absolute.
template <Real T>
constexpr Wide dust = 16 * static_cast<Wide>(std::numeric_limits<T>::denorm_min());

/// The patch as it was given, seen from the query: heights over it, metres from the cell's corner.
template <class R>
struct Seen {
    R p00, p10, p01, p11, dx, dy, qx, qy;

    [[nodiscard]] R gap(R u, R v) const {
        return (1 - v) * ((1 - u) * p00 + u * p10) + v * ((1 - u) * p01 + u * p11);
    }
    [[nodiscard]] R half_square(R u, R v) const {
        const R x = dx * u - qx, y = dy * v - qy, z = gap(u, v);
        return (x * x + y * y + z * z) / 2;
    }
    /// On the line v = const the surface is straight, so its nearest point is a projection; the same for u = const.
    [[nodiscard]] R nearest_u(R v) const {
        const R z = (1 - v) * p00 + v * p01, rise = (1 - v) * (p10 - p00) + v * (p11 - p01);
        return std::clamp((dx * qx - rise * z) / (dx * dx + rise * rise), R(0), R(1));
    }
    [[nodiscard]] R nearest_v(R u) const {
        const R z = (1 - u) * p00 + u * p10, rise = (1 - u) * (p01 - p00) + u * (p11 - p10);
        return std::clamp((dy * qy - rise * z) / (dy * dy + rise * rise), R(0), R(1));
    }
};

template <class R, Real T>
[[nodiscard]] Seen<R> seen(const BilinearPatch<T>& p, const CellPoint<T>& q) {
    const R z = static_cast<R>(q.z), dx = static_cast<R>(p.spacing.x), dy = static_cast<R>(p.spacing.y);
    return {static_cast<R>(p.p00) - z,
            static_cast<R>(p.p10) - z,
            static_cast<R>(p.p01) - z,
            static_cast<R>(p.p11) - z,
            dx,
            dy,
            static_cast<R>(q.u) * dx,
            static_cast<R>(q.v) * dy};
}

struct Foot {
    double u, v, half_square;
};

/// The nearest point that a search of lines finds: along each of 25 lines of both directions exactly, then between the
/// lines next to the first three that are nearer than their neighbours and not much farther than the nearest.
[[nodiscard]] Foot nearest_by_lines(const Seen<double>& p) {
    constexpr int lines = 24;
    Foot best{0, 0, std::numeric_limits<double>::max()};
    const auto search = [&](auto&& at) { // at(s): the nearest point of line s
        std::array<double, lines + 1> f{};
        for (int n = 0; n <= lines; ++n) f[static_cast<std::size_t>(n)] = at(n / double(lines)).half_square;
        const double lowest = *std::min_element(f.begin(), f.end());
        int searched = 0;
        for (int n = 0; n <= lines && searched < 3; ++n) {
            const double here = f[static_cast<std::size_t>(n)];
            const double before = n > 0 ? f[static_cast<std::size_t>(n - 1)] : here;
            const double after = n < lines ? f[static_cast<std::size_t>(n + 1)] : here;
            if (here > before || here > after || here > 2 * lowest) continue;
            ++searched;
            double low = std::max(n - 1, 0) / double(lines), high = std::min(n + 1, lines) / double(lines);
            for (int step = 0; step < 24; ++step) {
                const double third = (high - low) * 0.381966;
                if (at(low + third).half_square < at(high - third).half_square) {
                    high -= third;
                } else {
                    low += third;
                }
            }
            for (const Foot& foot : {at(n / double(lines)), at((low + high) / 2)}) {
                if (foot.half_square < best.half_square) best = foot;
            }
        }
    };
    search([&](double v) { return Foot{p.nearest_u(v), v, p.half_square(p.nearest_u(v), v)}; });
    search([&](double u) { return Foot{u, p.nearest_v(u), p.half_square(u, p.nearest_v(u))}; });
    return best;
}

template <Real T>
struct Case {
    BilinearPatch<T> patch;
    CellPoint<T> query;
    Seen<Wide> wide;
    Wide reach; ///< the largest of cell diagonal, relief and distance to the nearest corner

    Case(const BilinearPatch<T>& p, const CellPoint<T>& q) : patch{p}, query{q}, wide{seen<Wide>(p, q)} {
        const Wide relief = static_cast<Wide>(p.highest()) - static_cast<Wide>(p.lowest());
        const Wide nearest = std::min(std::min(distance(T(0), T(0)), distance(T(1), T(0))),
                                      std::min(distance(T(0), T(1)), distance(T(1), T(1))));
        reach = std::max(std::max(std::hypot(wide.dx, wide.dy), relief), nearest);
    }
    template <class R>
    [[nodiscard]] Wide distance(R u, R v) const {
        return std::sqrt(2 * wide.half_square(static_cast<Wide>(u), static_cast<Wide>(v)));
    }
    [[nodiscard]] Story story() const {
        Story s;
        s("p00", patch.p00)("p10", patch.p10)("p01", patch.p01)("p11", patch.p11);
        s("dx", patch.spacing.x)("dy", patch.spacing.y)("\nquery u", query.u)("v", query.v)("z", query.z);
        return s;
    }
};

/// Newton from `start`: in the patch, with a status that can be, and no farther than it began.
///
/// A step is taken if F falls as computed. The heights over the query carry a rounding each, and so does what is made
/// of them: seen from the query the surface is uncertain by some ε L at every step, so each may add that much to the
/// true distance and no more.
template <Real T>
NewtonResult<T> check_newton(const Case<T>& c, const vec2<T>& start, BorderRule border) {
    const auto foot = newton_closest_point(c.patch, c.query, start, {.border = border});
    const auto fail = [&](const char* rule) {
        broken(rule, c.story()("\nstart", start.x)("", start.y)("end", foot.u)("", foot.v)(
                          "\ndistance before", static_cast<double>(c.distance(start.x, start.y)))(
                          "after", static_cast<double>(c.distance(foot.u, foot.v)))(
                          "L", static_cast<double>(c.reach))("iterations", double(foot.iterations))
                         .told());
    };
    if (!(foot.u >= 0 && foot.u <= 1 && foot.v >= 0 && foot.v <= 1)) fail("Newton ends outside the patch");
    if (!is_finite(foot.gap)) fail("Newton's gap is not finite");
    if (foot.iterations < 0 || foot.iterations > NewtonOptions{}.max_iterations) fail("too many iterations");
    if (foot.status == NewtonStatus::at_border) {
        if (border != BorderRule::stop) fail("Newton stopped at the border though it should slide");
        if (foot.u > 0 && foot.u < 1 && foot.v > 0 && foot.v < 1) fail("Newton stopped at no border");
    } else if (foot.status == NewtonStatus::iteration_limit) {
        if (foot.iterations != NewtonOptions{}.max_iterations) fail("Newton gave up early");
    } else if (foot.status != NewtonStatus::converged) {
        fail("an unknown status");
    }
    const Wide tolerance = 4 * eps<T> * (1 + foot.iterations) * c.reach;
    if (c.distance(foot.u, foot.v) > c.distance(start.x, start.y) + tolerance) fail("Newton ends farther");
    const Wide gap = c.wide.gap(static_cast<Wide>(foot.u), static_cast<Wide>(foot.v));
    const Wide highest = std::max(std::max(std::abs(c.wide.p00), std::abs(c.wide.p10)),
                                  std::max(std::abs(c.wide.p01), std::abs(c.wide.p11)));
    if (std::abs(gap - static_cast<Wide>(foot.gap)) > 16 * eps<T> * highest + dust<T>)
        fail("Newton's gap is not that of its point");
    return foot;
}

template <Real T>
void check_closest(const Case<T>& c, const vec2<T>& start) {
    const Wide tolerance = (sizeof(T) == 8 ? 1e-12L : 4e-6L) * c.reach;
    const auto found = global_closest_point(c.patch, c.query);
    const auto fail = [&](const char* rule, double u, double v) {
        broken(rule, c.story()("\nfound", found.u)("", found.v)("better", u)("", v)(
                          "\ndistance", static_cast<double>(c.distance(found.u, found.v)))(
                          "better", static_cast<double>(c.distance(u, v)))("L", static_cast<double>(c.reach))(
                          found.status == GlobalStatus::certified  ? "certified"
                          : found.status == GlobalStatus::searched ? "searched"
                                                                   : "interval_limit")
                         .told());
    };
    if (!(found.u >= 0 && found.u <= 1 && found.v >= 0 && found.v <= 1)) fail("closest point outside", 0, 0);
    const Wide distance = c.distance(found.u, found.v);
    const auto offer = [&](const char* rule, double u, double v) {
        // On a cliff seen from where its valley is all but level, intervals may run out, and it says so.
        if (found.status == GlobalStatus::interval_limit && c.reach > 1e5L * std::min(c.wide.dx, c.wide.dy))
            return;
        if (distance > c.distance(u, v) + tolerance) fail(rule, u, v);
    };
    const vec2<T> starts[] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {T(0.5), T(0.5)}, start};
    for (const vec2<T>& from : starts) {
        const auto foot = check_newton(c, from, BorderRule::slide);
        offer("Newton found a closer point", static_cast<double>(foot.u), static_cast<double>(foot.v));
    }
    (void)check_newton(c, start, BorderRule::stop);
    const Foot foot = nearest_by_lines(seen<double>(c.patch, c.query));
    offer("a search found a closer point", foot.u, foot.v);
}

/// z of a segment less z of the surface over one cell: a quadratic in t, in long double from the ends as doubles.
class Gap {
public:
    template <Real T>
    Gap(const BilinearPatch<T>& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec2& origin)
        : Gap{{static_cast<Wide>(p.p00), static_cast<Wide>(p.p10), static_cast<Wide>(p.p01),
               static_cast<Wide>(p.p11)},
              glm::dvec2{p.spacing},
              a,
              b,
              origin} {}

    Wide t_in = 0, t_out = 1; ///< over the cell, as far as it is
    bool over = false;        ///< it is over the cell at all
    Wide blur = 0;            ///< metres, by which the library may be wrong
    Wide slack = 0;           ///< of t

    [[nodiscard]] Wide operator()(Wide t) const {
        const Wide u = u0_ + t * (u1_ - u0_), v = v0_ + t * (v1_ - v0_);
        return (1 - t) * za_ + t * zb_ -
               ((1 - v) * ((1 - u) * p00_ + u * p10_) + v * ((1 - u) * p01_ + u * p11_));
    }
    /// At the ends over the cell and at the turn between them, in order: from one to the next it rises or falls.
    [[nodiscard]] std::array<Wide, 3> turns() const {
        const Wide bend = -(u1_ - u0_) * (v1_ - v0_) * (p11_ - p10_ - p01_ + p00_);
        const Wide slope_0 = (*this)(1) - (*this)(0) - bend;
        return {t_in, bend != 0 ? std::clamp(-slope_0 / (2 * bend), t_in, t_out) : t_out, t_out};
    }
    /// Both ends are over the cell and not on its edge.
    [[nodiscard]] bool inside() const {
        const auto strictly = [](Wide x) { return x > 0 && x < 1; };
        return t_in == 0 && t_out == 1 && strictly(u0_) && strictly(v0_) && strictly(u1_) && strictly(v1_);
    }

private:
    Gap(const std::array<Wide, 4>& heights, const glm::dvec2& spacing, const glm::dvec3& a,
        const glm::dvec3& b, const glm::dvec2& origin)
        : p00_{heights[0]}, p10_{heights[1]}, p01_{heights[2]}, p11_{heights[3]} {
        const Wide dx = static_cast<Wide>(spacing.x), dy = static_cast<Wide>(spacing.y);
        const auto cells = [](double x, double from, Wide d) {
            return (static_cast<Wide>(x) - static_cast<Wide>(from)) / d;
        };
        u0_ = cells(a.x, origin.x, dx), u1_ = cells(b.x, origin.x, dx);
        v0_ = cells(a.y, origin.y, dy), v1_ = cells(b.y, origin.y, dy);
        za_ = static_cast<Wide>(a.z), zb_ = static_cast<Wide>(b.z);
        const auto place = [](Wide from, Wide to, double x, double y, Wide d) {
            return 1 + std::abs(from) + std::abs(to) +
                   (std::abs(static_cast<Wide>(x)) + std::abs(static_cast<Wide>(y))) / d;
        };
        measure(place(u0_, u1_, a.x, b.x, dx), place(v0_, v1_, a.y, b.y, dy));
        over = clip(u0_, u1_ - u0_) && clip(v0_, v1_ - v0_);
    }

    /// The library computes in double: what goes in are heights and z (R at most) and a place in cells good to ε of the
    /// farther end, times the slopes.
    void measure(Wide place_u, Wide place_v) {
        const Wide e = eps<double>;
        const Wide high =
            std::max(std::max(std::abs(p00_), std::abs(p10_)), std::max(std::abs(p01_), std::abs(p11_)));
        const Wide mu = std::max(std::abs(p10_ - p00_), std::abs(p11_ - p01_)),
                   mv = std::max(std::abs(p01_ - p00_), std::abs(p11_ - p10_));
        // A time is good to ε · place / |Δu|, at which the height of the segment has changed by |Δz| times that.
        const Wide climb = std::abs(zb_ - za_);
        const Wide du = std::abs(u1_ - u0_), dv = std::abs(v1_ - v0_);
        Wide when = 1;
        if (du > 0) when = std::max(when, place_u / du);
        if (dv > 0) when = std::max(when, place_v / dv);
        when = std::min(when, 1 / e);
        slack = 16 * e * when;
        const Wide square_root_of_least =
            0x1p-500L; // a quadratic of heights smaller than this has no discriminant
        blur = square_root_of_least +
               16 * e * (std::abs(za_) + std::abs(zb_) + high + mu * place_u + mv * place_v + climb * when);
    }

    /// Cuts the times to those over one axis of the cell; whether some are left.
    bool clip(Wide from, Wide by) {
        if (by == 0) return from >= 0 && from <= 1;
        t_in = std::max(t_in, std::min(-from / by, (1 - from) / by));
        t_out = std::min(t_out, std::max(-from / by, (1 - from) / by));
        return t_in <= t_out;
    }

    Wide p00_, p10_, p01_, p11_;
    Wide u0_ = 0, u1_ = 0, v0_ = 0, v1_ = 0, za_ = 0, zb_ = 0;
};

/// `fail(rule, t)`.
template <Real T, class Fail>
void judge_hit(const FirstHit<T>& hit, const Gap& f, SurfaceKind kind, Fail&& fail) {
    const Wide t = static_cast<Wide>(hit.t);
    if (!(hit.point.u >= 0 && hit.point.u <= 1 && hit.point.v >= 0 && hit.point.v <= 1))
        fail("hit outside the cell", hit.t);
    if (t < f.t_in - f.slack || t > f.t_out + f.slack) fail("hit when not over the cell", hit.t);
    if (std::abs(f(t)) > f.blur) fail("hit off the surface", hit.t);
    if (kind == SurfaceKind::solid && hit.side != Side::above) fail("a solid hit from below", hit.t);
    const Wide sign = hit.side == Side::above ? 1 : -1;
    // Before it there is nothing but the side it came from; a solid may have been left first.
    bool seen_side = kind == SurfaceKind::sheet;
    for (int n = 0; n <= 16; ++n) {
        const Wide s = f.t_in + (t - f.t_in) * n / 16;
        if (sign * f(s) > f.blur) seen_side = true;
        if (seen_side && sign * f(s) < -f.blur)
            fail("an earlier crossing was passed over", static_cast<double>(s));
    }
}
template <Real T, class Fail>
void judge_miss(const FirstHit<T>& hit, const Gap& f, SurfaceKind kind, Fail&& fail) {
    Side side = Side::none;
    for (const Wide t : f.turns()) {
        const Wide here = f(t);
        if (std::abs(here) <= f.blur) continue;
        const Side now = here > 0 ? Side::above : Side::below;
        const bool crossed = side != Side::none && now != side;
        if (crossed && (kind == SurfaceKind::sheet || now == Side::below))
            fail("a crossing was missed", static_cast<double>(t));
        side = now;
    }
    if (f.inside() && std::abs(f(1)) > f.blur && hit.side != (f(1) > 0 ? Side::above : Side::below))
        fail("on the wrong side at the end", 1);
}

/// A segment over one cell. Both ends are given in cells, and may lie beyond it.
template <Real T>
void check_hit(const BilinearPatch<T>& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec2& origin,
               SurfaceKind kind) {
    const std::array<T, 4> samples{p.p00, p.p10, p.p01, p.p11};
    const glm::dvec2 spacing{p.spacing};
    const BilinearGrid<T, HeightView<T>> grid{HeightView<T>{samples.data(), 2, 2},
                                              {.origin = origin, .spacing = spacing}};
    const auto hit = first_hit(grid, a, b, {.surface = kind});
    const auto fail = [&](const char* rule, double at) {
        Story s;
        s(kind == SurfaceKind::solid ? "solid " : "sheet ")("p00", p.p00)("p10", p.p10)("p01", p.p01)("p11",
                                                                                                      p.p11);
        s("\norigin", origin.x)("", origin.y)("spacing", spacing.x)("", spacing.y);
        s("\na", a.x)("", a.y)("", a.z)("b", b.x)("", b.y)("", b.z);
        s(hit.status == HitStatus::hit ? "\nhit at" : "\nmiss", hit.t)("in cell", double(hit.point.u))(
            "", double(hit.point.v))(hit.side == Side::above   ? "above "
                                     : hit.side == Side::below ? "below "
                                                               : "none ")("judged at", at);
        broken(rule, s.told());
    };
    if (!(hit.t >= 0 && hit.t <= 1)) fail("t outside the segment", hit.t);
    if (hit.status == HitStatus::cell_limit) fail("no limit was set", hit.t);
    if (hit.cells > 1) fail("more cells than there are", hit.t);

    const Gap gap{p, a, b, origin};
    if (!gap.over) {
        if (hit.status == HitStatus::hit && !(gap.t_in <= gap.t_out + gap.slack))
            fail("hit beside the cell", hit.t);
    } else if (hit.status == HitStatus::hit) {
        judge_hit(hit, gap, kind, fail);
    } else {
        judge_miss(hit, gap, kind, fail);
    }
}

template <Real T>
void check(Bytes& bytes) {
    // The products of the solver are of the sixth degree in metres; these stay clear of overflow in either scalar.
    const bool extreme = sizeof(T) == 8 && bytes.flag();
    Numbers<T> height{bytes, extreme ? T(1e30) : T(1e5)};
    BilinearPatch<T> p;
    p.spacing = {static_cast<T>(std::pow(10.0, bytes.whole(-12, 12) / 8.0)),
                 static_cast<T>(std::pow(10.0, bytes.whole(-12, 12) / 8.0))};
    if (bytes.flag()) p.spacing = vec2<T>{static_cast<T>(bytes.whole(1, 64))};
    p.p00 = height(), p.p10 = height(), p.p01 = height(), p.p11 = height();

    const auto parameter = [&] {
        return bytes.flag() ? static_cast<T>(bytes.share()) : Numbers<T>{bytes, T(1e6)}();
    };
    CellPoint<T> query{parameter(), parameter(), T(0)};
    switch (bytes.byte() % 3) {
    case 0: query.z = height(); break;
    case 1: query.z = p.height(std::clamp(query.u, T(0), T(1)), std::clamp(query.v, T(0), T(1))); break;
    default: // near the surface, for its size
        query.z = p.height(T(0.5), T(0.5)) +
                  static_cast<T>(bytes.small() * std::pow(10.0, bytes.whole(-6, 3))) * p.spacing.x;
    }
    const vec2<T> start{static_cast<T>(bytes.share()), static_cast<T>(bytes.share())};
    check_closest(Case<T>{p, query}, start);

    // The segment between two points in cells, in the world.
    const glm::dvec2 origin{bytes.flag() ? bytes.small() * 1e5 : 0, bytes.flag() ? bytes.small() * 1e5 : 0};
    const auto end = [&] {
        const double u = bytes.flag() ? bytes.share() : bytes.small() / 16,
                     v = bytes.flag() ? bytes.share() : bytes.small() / 16;
        const double z = bytes.flag()
                             ? static_cast<double>(height())
                             : static_cast<double>(p.height(std::clamp(static_cast<T>(u), T(0), T(1)),
                                                            std::clamp(static_cast<T>(v), T(0), T(1)))) +
                                   bytes.small();
        return glm::dvec3{origin.x + u * static_cast<double>(p.spacing.x),
                          origin.y + v * static_cast<double>(p.spacing.y), z};
    };
    const glm::dvec3 a = end();
    glm::dvec3 b = end();
    if (bytes.flag()) b.x = a.x;
    if (bytes.flag()) b.y = a.y;
    check_hit(p, a, b, origin, bytes.flag() ? SurfaceKind::sheet : SurfaceKind::solid);
}

} // namespace
} // namespace hfh::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    hfh::fuzz::Bytes bytes{data, size};
    if (bytes.flag()) {
        hfh::fuzz::check<double>(bytes);
    } else {
        hfh::fuzz::check<float>(bytes);
    }
    return 0;
}
