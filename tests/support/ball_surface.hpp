#ifndef HFH_TESTS_SUPPORT_BALL_SURFACE_HPP
#define HFH_TESTS_SUPPORT_BALL_SURFACE_HPP

#include "reference.hpp"

#include <array>
#include <vector>

// What a ball meets on a terrain, by brute force in long double: every local closest point of every patch whose box is in
// reach, half-spaces, and a push out of what it overlaps. Shares no code with the library.

namespace hfh::test {

[[nodiscard]] inline Point operator+(const Point& a, const Point& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[nodiscard]] inline Point operator*(Wide s, const Point& a) { return {s * a.x, s * a.y, s * a.z}; }
[[nodiscard]] inline Wide largest_coordinate(const Point& a) {
    return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
}
[[nodiscard]] inline Point cross_product(const Point& a, const Point& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Real roots of a polynomial of degree at most 5 within an interval, between the roots of its derivative.
class RealRoots {
public:
    static constexpr int highest = 5;
    using Coefficients = std::array<Wide, highest + 1>;

    /// The roots at which the polynomial rises through zero, into `roots`; returns how many. `exact(t)` is the polynomial
    /// in a form that loses less to rounding.
    template <class Exact>
    static int rising(const Coefficients& c, Wide low, Wide high, const Exact& exact,
                      std::array<Wide, highest>& roots) {
        int degree = highest;
        while (degree > 0 && c[static_cast<std::size_t>(degree)] == 0) --degree;
        std::array<Wide, highest + 2> ends{low};
        int count = 0;
        if (degree > 1) {
            count = between(derivative(c), degree - 1, low, high, ends.data() + 1);
        }
        ends[static_cast<std::size_t>(count) + 1] = high;
        const Coefficients slope = derivative(c);
        int found = 0;
        for (int n = 0; n <= count; ++n) {
            const Wide a = ends[static_cast<std::size_t>(n)], b = ends[static_cast<std::size_t>(n) + 1];
            if (!(a < b) || !(exact(a) < 0) || !(exact(b) > 0)) continue;
            roots[static_cast<std::size_t>(found++)] = root(
                exact, [&](Wide t) { return value(slope, degree - 1, t); }, a, b, true);
        }
        return found;
    }

private:
    [[nodiscard]] static Wide value(const Coefficients& c, int degree, Wide t) {
        Wide sum = 0;
        for (int n = degree; n >= 0; --n) sum = sum * t + c[static_cast<std::size_t>(n)];
        return sum;
    }
    [[nodiscard]] static Coefficients derivative(const Coefficients& c) {
        Coefficients d{};
        for (int n = 1; n <= highest; ++n)
            d[static_cast<std::size_t>(n) - 1] = static_cast<Wide>(n) * c[static_cast<std::size_t>(n)];
        return d;
    }
    /// All roots within (low, high), rising and falling, into `roots`, in order.
    static int between(const Coefficients& c, int degree, Wide low, Wide high, Wide* roots) {
        if (degree < 1) return 0;
        std::array<Wide, highest + 2> ends{low};
        const Coefficients slope = derivative(c);
        const int count = between(slope, degree - 1, low, high, ends.data() + 1);
        ends[static_cast<std::size_t>(count) + 1] = high;
        int found = 0;
        Wide at_a = value(c, degree, low);
        for (int n = 0; n <= count; ++n) {
            const Wide a = ends[static_cast<std::size_t>(n)], b = ends[static_cast<std::size_t>(n) + 1],
                       at_b = value(c, degree, b);
            const bool crosses = (at_a < 0 && at_b > 0) || (at_a > 0 && at_b < 0);
            if (a < b && crosses) {
                roots[found++] = root([&](Wide t) { return value(c, degree, t); },
                                      [&](Wide t) { return value(slope, degree - 1, t); }, a, b, at_b > 0);
            }
            at_a = at_b;
        }
        return found;
    }
    /// Newton's method where it stays within [a, b] and comes forward, else bisection. Ends when the interval does.
    template <class Value, class Slope>
    [[nodiscard]] static Wide root(const Value& f, const Slope& df, Wide a, Wide b, bool rises) {
        Wide t = (a + b) / 2, last = b - a;
        for (int n = 0; n < 200; ++n) {
            const Wide here = f(t);
            if (here == 0) return t;
            ((here < 0) == rises ? a : b) = t;
            const Wide slope = df(t), step = -here / slope;
            Wide to = t + step;
            if (!(a < to && to < b) || !(std::abs(step) < last / 2)) to = (a + b) / 2;
            last = std::abs(to - t);
            if (to == t || last < 1e-19L * std::abs(t)) return to;
            t = to;
        }
        return t;
    }
};

/// A local closest point of a patch: where it is as seen from the centre, and where on the patch.
struct BallFoot {
    Point offset; ///< from the centre
    Wide distance = 0;
    WideSurfacePoint at;

    /// Unit, to the centre.
    [[nodiscard]] Point normal() const { return (-1 / distance) * offset; }
};

/// Calls visit(x, y, z, distance) for every local closest point of a patch, in metres from the query: those inside, each a
/// root of degree five, and those on edges and at corners. `query` is in metres from the patch's corner.
///
/// For a y that is held, the patch is a straight line z = m + β x, with m and β linear in y. Its closest point is at
/// x = −m β / (1 + β²), and g(y) = y² + m² / (1 + β²) has its minima where those of the patch are.
template <class Visit>
void each_local_minimum(const WidePatch& p, const Point& query, Visit&& visit) {
    const Wide twist = (p.p11 - p.p10 - p.p01 + p.p00) / (p.dx * p.dy);
    const Wide bx = (p.p10 - p.p00) / p.dx, by = (p.p01 - p.p00) / p.dy;
    const Wide left = -query.x, right = p.dx - query.x, low = -query.y, high = p.dy - query.y;
    const Wide a = p.p00 - query.z + bx * query.x + by * query.y + twist * query.x * query.y,
               b = bx + twist * query.y, c = by + twist * query.x;
    const auto height = [&](Wide x, Wide y) { return a + b * x + c * y + twist * x * y; };
    const auto offer = [&](Wide x, Wide y, Wide z) { visit(x, y, z, std::sqrt(x * x + y * y + z * z)); };
    // Half the derivatives of the squared distance.
    const auto along_x = [&](Wide x, Wide y, Wide z) { return x + z * (b + twist * y); };
    const auto along_y = [&](Wide x, Wide y, Wide z) { return y + z * (c + twist * x); };
    const Wide unit = 1e-15L * (std::abs(left) + std::abs(right) + std::abs(low) + std::abs(high));
    const auto flat = [&](Wide z, Wide slope) {
        return unit * (1 + slope * slope) + 1e-15L * std::abs(z * slope);
    };

    // Inside.
    const Wide s0 = 1 + b * b, s1 = 2 * b * twist, s2 = twist * twist;
    const Wide q0 = s0 * s0, q1 = 2 * s0 * s1, q2 = s1 * s1 + 2 * s0 * s2, q3 = 2 * s1 * s2, q4 = s2 * s2;
    const RealRoots::Coefficients quintic{
        c * a * s0 - twist * a * a * b,
        q0 + c * (a * s1 + c * s0) - twist * (2 * a * c * b + a * a * twist),
        q1 + c * (a * s2 + c * s1) - twist * (c * c * b + 2 * a * c * twist),
        q2 + c * c * s2 - twist * c * c * twist,
        q3,
        q4};
    const auto exact = [&](Wide y) {
        const Wide m = a + c * y, beta = b + twist * y, s = 1 + beta * beta;
        return y * s * s + m * (c * s - m * beta * twist);
    };
    std::array<Wide, RealRoots::highest> roots{};
    const int count = RealRoots::rising(quintic, low, high, exact, roots);
    for (int n = 0; n < count; ++n) {
        const Wide y = roots[static_cast<std::size_t>(n)], m = a + c * y, beta = b + twist * y;
        const Wide x = -m * beta / (1 + beta * beta);
        if (left < x && x < right) offer(x, y, height(x, y));
    }
    // Edges with their ends; of a corner the two edges ask once.
    const auto foot = [](Wide m, Wide beta, Wide from, Wide to) {
        return std::clamp(-m * beta / (1 + beta * beta), from, to);
    };
    for (const bool far : {false, true}) {
        const Wide y = far ? high : low, beta = b + twist * y, x = foot(a + c * y, beta, left, right),
                   z = height(x, y), slope = c + twist * x;
        const Wide inward = far ? -along_y(x, y, z) : along_y(x, y, z);
        if (inward >= -flat(z, slope)) offer(x, y, z);
    }
    for (const bool far : {false, true}) {
        const Wide x = far ? right : left, beta = c + twist * x, m = a + b * x;
        const Wide y = foot(m, beta, low, high);
        if (y == low || y == high) continue;
        const Wide z = height(x, y), slope = b + twist * y;
        const Wide inward = far ? -along_x(x, y, z) : along_x(x, y, z);
        if (inward >= -flat(z, slope)) offer(x, y, z);
    }
}

/// Half-space {x : normal·x ≥ least}.
struct HalfSpace {
    Point normal;
    Wide least = 0;
};

/// The point of an intersection of half-spaces that is nearest to another point, and the half-spaces that keep it there:
/// at = from + Σ pulls·normals, pulls ≥ 0.
struct NearestIn {
    Point at;
    std::size_t count = 0;
    std::array<std::size_t, 3> held_by{}; ///< places in the list of half-spaces
    std::array<Wide, 3> pulls{};
};

namespace detail {

/// The point on the planes of some half-spaces that is nearest to `from`; nothing if one of them would have to pull towards
/// itself, or if they are too nearly parallel to tell.
[[nodiscard]] inline std::optional<NearestIn> on_planes(const std::vector<HalfSpace>& all, const Point& from,
                                                        const std::array<std::size_t, 3>& some,
                                                        std::size_t count) {
    std::array<std::array<Wide, 4>, 3> m{};
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j < count; ++j) m[i][j] = dot(all[some[i]].normal, all[some[j]].normal);
        m[i][3] = all[some[i]].least - dot(all[some[i]].normal, from);
    }
    for (std::size_t k = 0; k < count; ++k) {
        if (!(m[k][k] > 1e-16L)) return {};
        for (std::size_t i = 0; i < count; ++i) {
            if (i == k) continue;
            const Wide part = m[i][k] / m[k][k];
            for (std::size_t j = k; j < 4; ++j) m[i][j] -= part * m[k][j];
        }
    }
    NearestIn found{from, count, some, {}};
    for (std::size_t k = 0; k < count; ++k) {
        found.pulls[k] = m[k][3] / m[k][k];
        if (!(found.pulls[k] >= 0)) return {};
        found.at = found.at + found.pulls[k] * all[some[k]].normal;
    }
    return found;
}

/// With a half-space more that `now` violates: the nearest point of that and of those that hold `now`.
[[nodiscard]] inline std::optional<NearestIn> with_one_more(const std::vector<HalfSpace>& all,
                                                            const Point& from, const NearestIn& now,
                                                            std::size_t more, Wide slack) {
    std::optional<NearestIn> best;
    for (std::size_t bits = 0; bits < (std::size_t{1} << now.count); ++bits) {
        std::array<std::size_t, 3> some{more};
        std::size_t n = 1;
        for (std::size_t k = 0; k < now.count; ++k) {
            if (!(bits >> k & 1)) continue;
            if (n < 3) some[n] = now.held_by[k];
            ++n;
        }
        if (n > 3) continue;
        const auto point = on_planes(all, from, some, n);
        if (!point) continue;
        bool inside = true;
        for (std::size_t k = 0; k < now.count; ++k) {
            const HalfSpace& h = all[now.held_by[k]];
            inside = inside && dot(h.normal, point->at) >= h.least - slack;
        }
        if (inside && (!best || length(point->at - from) < length(best->at - from))) best = point;
    }
    return best;
}

} // namespace detail

/// A half-space that is violated most comes in, and of those that held the point before some go out; the point moves
/// farther away every time, so this ends. Nothing if the half-spaces have no point in common, or if normals are too nearly
/// parallel to tell.
[[nodiscard]] inline std::optional<NearestIn> nearest_in(const std::vector<HalfSpace>& all,
                                                         const Point& from) {
    Wide size = length(from);
    for (const HalfSpace& h : all) size = std::max(size, std::abs(h.least));
    const Wide slack = 1e-17L * size;
    NearestIn now{from, 0, {}, {}};
    for (int round = 0; round < 200; ++round) {
        std::optional<std::size_t> worst;
        Wide most = slack;
        for (std::size_t n = 0; n < all.size(); ++n) {
            const Wide below = all[n].least - dot(all[n].normal, now.at);
            if (below > most) most = below, worst = n;
        }
        if (!worst) return now;
        const auto next = detail::with_one_more(all, from, now, *worst, 8 * slack);
        if (!next) return {};
        now = *next;
    }
    return {};
}

/// The surface of a terrain as a ball meets it.
template <Real T>
class BallSurface {
public:
    explicit BallSurface(const Terrain<T>& terrain) : terrain_{&terrain}, surface_{terrain} {}

    [[nodiscard]] const Surface<T>& surface() const { return surface_; }
    [[nodiscard]] const Terrain<T>& terrain() const { return *terrain_; }
    [[nodiscard]] Wide cell() const { return std::min(surface_.dx(), surface_.dy()); }

    /// Calls visit(BallFoot) for every local closest point of every patch, nearer than `reach` to `centre`.
    template <class Visit>
    void each_foot(const Point& centre, Wide reach, Visit&& visit) const {
        each_patch(centre, reach, [&](const WidePatch& p, const Point& local, Index i, Index j) {
            each_local_minimum(p, local, [&](Wide x, Wide y, Wide z, Wide distance) {
                if (!(distance < reach)) return;
                visit(BallFoot{{x, y, z},
                               distance,
                               {i, j, std::clamp((local.x + x) / p.dx, Wide(0), Wide(1)),
                                std::clamp((local.y + y) / p.dy, Wide(0), Wide(1))}});
            });
        });
    }
    /// The same, one for each point of the surface.
    [[nodiscard]] std::vector<BallFoot> feet(const Point& centre, Wide reach) const {
        std::vector<BallFoot> found;
        each_foot(centre, reach, [&](const BallFoot& foot) {
            for (BallFoot& other : found) {
                if (length(other.offset - foot.offset) > 1e-12L * reach) continue;
                if (foot.distance < other.distance) other = foot;
                return;
            }
            found.push_back(foot);
        });
        return found;
    }
    /// The nearest point of the surface, if it is nearer than `reach`.
    [[nodiscard]] std::optional<BallFoot> nearest(const Point& centre, Wide reach) const {
        std::optional<BallFoot> best;
        Wide within = reach;
        each_patch_within(centre, within, [&](const WidePatch& p, const Point& local, Index i, Index j) {
            each_local_minimum(p, local, [&](Wide x, Wide y, Wide z, Wide distance) {
                if (!(distance < within)) return;
                within = distance;
                best = BallFoot{{x, y, z},
                                distance,
                                {i, j, std::clamp((local.x + x) / p.dx, Wide(0), Wide(1)),
                                 std::clamp((local.y + y) / p.dy, Wide(0), Wide(1))}};
            });
        });
        return best;
    }
    /// The distance to the surface, or `reach` if it is farther.
    [[nodiscard]] Wide distance(const Point& centre, Wide reach) const {
        const auto foot = nearest(centre, reach);
        return foot ? foot->distance : reach;
    }

    /// Whether the point of the surface lies on a rim, of a hole or of the grid.
    [[nodiscard]] bool on_rim(const WideSurfacePoint& at) const { return surface_.missing_at(at) > 0; }

    /// The centre moved out of what a ball there overlaps, to the nearest place by half-spaces. Nothing if that does not come
    /// to an end, as between walls.
    [[nodiscard]] std::optional<Point> pushed_clear(Point centre, Wide radius) const {
        std::vector<HalfSpace> spaces;
        for (int n = 0; n < 60; ++n) {
            spaces.clear();
            Wide nearest = radius;
            each_foot(centre, 1.02L * radius, [&](const BallFoot& foot) {
                nearest = std::min(nearest, foot.distance);
                spaces.push_back({foot.normal(), radius - foot.distance});
            });
            if (!(nearest < radius * (1 - 1e-14L))) return centre;
            const auto step = nearest_in(spaces, {});
            if (!step) return {};
            centre = centre + step->at;
        }
        return {};
    }

private:
    template <class Visit>
    void each_patch(const Point& centre, Wide reach, Visit&& visit) const {
        each_patch_within(centre, reach, visit);
    }
    /// Every patch whose box is within `within`, which may become less on the way.
    template <class Visit>
    void each_patch_within(const Point& centre, const Wide& within, Visit&& visit) const {
        const auto range = [&](Wide from, Wide to, Index count, Index& begin, Index& end) {
            begin = static_cast<Index>(std::clamp(std::floor(from), Wide(0), static_cast<Wide>(count)));
            end = static_cast<Index>(std::clamp(std::floor(to) + 1, Wide(0), static_cast<Wide>(count)));
        };
        Index i0, i1, j0, j1;
        range(surface_.column_of(centre.x - within) - 1e-9L, surface_.column_of(centre.x + within) + 1e-9L,
              terrain_->columns - 1, i0, i1);
        range(surface_.row_of(centre.y - within) - 1e-9L, surface_.row_of(centre.y + within) + 1e-9L,
              terrain_->rows - 1, j0, j1);
        for (Index j = j0; j < j1; ++j) {
            for (Index i = i0; i < i1; ++i) {
                const Point local = surface_.seen_from(centre, i, j);
                const Wide x = std::max({-local.x, local.x - surface_.dx(), Wide(0)}),
                           y = std::max({-local.y, local.y - surface_.dy(), Wide(0)});
                const Wide plan = x * x + y * y, all = within * within;
                if (plan >= all) continue;
                const auto p = surface_.patch(i, j);
                if (!p) continue;
                const Wide z = std::max({p->lowest() - centre.z, centre.z - p->highest(), Wide(0)});
                if (plan + z * z < all) visit(*p, local, i, j);
            }
        }
    }

    const Terrain<T>* terrain_;
    Surface<T> surface_;
};

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_BALL_SURFACE_HPP
