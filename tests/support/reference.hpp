#ifndef HFH_TESTS_SUPPORT_REFERENCE_HPP
#define HFH_TESTS_SUPPORT_REFERENCE_HPP

#include "terrains.hpp"

#include <hfh/geometry/surface_point.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>
#include <vector>

// What is true of a terrain, straight from the heights and in long double: the surface, the distance to it and its
// one-sided derivatives, the closest point by search, the way downhill by small steps. Shares no code with what it
// judges; of the library it uses the heights and the frame alone.

namespace hfh::test {

using Wide = long double;

/// A number so that it reads back as itself.
template <Real T>
[[nodiscard]] std::string digits(T x) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*g", std::numeric_limits<T>::max_digits10, static_cast<double>(x));
    return text;
}
template <Real T>
[[nodiscard]] std::string digits(const vec3<T>& p) {
    return digits(p.x) + ' ' + digits(p.y) + ' ' + digits(p.z);
}

struct Point {
    Wide x = 0, y = 0, z = 0;
};
[[nodiscard]] inline Point operator-(const Point& a, const Point& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[nodiscard]] inline Wide dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
[[nodiscard]] inline Wide length(const Point& a) { return std::sqrt(dot(a, a)); }
template <Real T>
[[nodiscard]] Point wide(const vec3<T>& p) {
    return {static_cast<Wide>(p.x), static_cast<Wide>(p.y), static_cast<Wide>(p.z)};
}

/// A patch and a query in metres from the patch's corner (z as the heights).
struct WidePatch {
    Wide p00 = 0, p10 = 0, p01 = 0, p11 = 0, dx = 1, dy = 1;

    [[nodiscard]] Wide height(Wide u, Wide v) const {
        return (1 - u) * (1 - v) * p00 + u * (1 - v) * p10 + (1 - u) * v * p01 + u * v * p11;
    }
    [[nodiscard]] Point position(Wide u, Wide v) const { return {u * dx, v * dy, height(u, v)}; }
    /// Half the squared distance to q.
    [[nodiscard]] Wide half_square(Wide u, Wide v, const Point& q) const {
        const Point sigma = position(u, v) - q;
        return dot(sigma, sigma) / 2;
    }
    [[nodiscard]] Wide along_u(Wide v) const { return (p10 - p00) * (1 - v) + (p11 - p01) * v; }
    [[nodiscard]] Wide along_v(Wide u) const { return (p01 - p00) * (1 - u) + (p11 - p10) * u; }
    [[nodiscard]] Wide lowest() const { return std::min(std::min(p00, p10), std::min(p01, p11)); }
    [[nodiscard]] Wide highest() const { return std::max(std::max(p00, p10), std::max(p01, p11)); }
    [[nodiscard]] Point normal(Wide u, Wide v) const {
        const Wide x = along_u(v) / dx, y = along_v(u) / dy, l = std::sqrt(1 + x * x + y * y);
        return {-x / l, -y / l, 1 / l};
    }
    /// The largest of cell diagonal, cell relief and distance to the query.
    [[nodiscard]] Wide reach(const Point& q) const {
        const Wide far_x = std::max(std::abs(q.x), std::abs(q.x - dx));
        const Wide far_y = std::max(std::abs(q.y), std::abs(q.y - dy));
        const Wide far_z = std::max(std::abs(q.z - lowest()), std::abs(q.z - highest()));
        return std::max(std::max(std::hypot(dx, dy), highest() - lowest()), std::hypot(far_x, far_y, far_z));
    }
};

/// The derivatives of ½ distance² at a point of a patch, along u and v, and by how much a rounding of the numbers
/// they are made of moves them. Multiply by the epsilon of a scalar to get its ulp-scale:
///
///     F_u = dx (x − x_q) + (z − z_q) z_u      F_uu = dx² + z_u²      F_uv = z_u z_v + (z − z_q) twist
///
/// One epsilon of u and of v moves F_u by F_uu and by |F_uv|, one epsilon of x_q by dx |x_q|, of the heights over
/// the query (R at most) and of the edge slopes (M at most) by R·M each.
struct Slopes {
    Wide fu, fv, scale_u, scale_v;
};
[[nodiscard]] inline Slopes slopes(const WidePatch& p, Wide u, Wide v, const Point& q) {
    const Wide zu = p.along_u(v), zv = p.along_v(u), gap = p.height(u, v) - q.z;
    const Wide r = std::max(std::abs(p.lowest() - q.z), std::abs(p.highest() - q.z));
    const Wide mu = std::max(std::abs(p.p10 - p.p00), std::abs(p.p11 - p.p01));
    const Wide mv = std::max(std::abs(p.p01 - p.p00), std::abs(p.p11 - p.p10));
    const Wide cross = mu * mv + r * std::abs(p.p11 - p.p10 - p.p01 + p.p00);
    return {p.dx * (u * p.dx - q.x) + gap * zu, p.dy * (v * p.dy - q.y) + gap * zv,
            p.dx * p.dx + p.dx * std::abs(q.x) + mu * mu + cross + 2 * r * mu,
            p.dy * p.dy + p.dy * std::abs(q.y) + mv * mv + cross + 2 * r * mv};
}

/// The steepest descent from (u, v) into the closed patch, along u or along v (a patch's tangent cone is spanned by
/// these, so if neither falls nothing does), in units of `unit`. Not positive: none.
struct Unit {
    Wide u = 0, v = 0;
};
[[nodiscard]] inline Wide fall_into(const WidePatch& p, Wide u, Wide v, const Point& q, const Unit& unit) {
    const Slopes s = slopes(p, u, v, q);
    Wide fall = 0;
    if (u < 1) fall = std::max(fall, -s.fu / unit.u);
    if (u > 0) fall = std::max(fall, s.fu / unit.u);
    if (v < 1) fall = std::max(fall, -s.fv / unit.v);
    if (v > 0) fall = std::max(fall, s.fv / unit.v);
    return fall;
}
/// In ulp-scales of T.
template <Real T>
[[nodiscard]] Wide fall_into(const WidePatch& p, Wide u, Wide v, const Point& q) {
    const Slopes s = slopes(p, u, v, q);
    const Wide e = static_cast<Wide>(epsilon<T>);
    return fall_into(p, u, v, q, {e * s.scale_u, e * s.scale_v});
}

struct Foot {
    Wide u = 0, v = 0, distance = 0;
};

/// The closest point of a closed patch: every local minimum of a dense sampling is a window that is searched again,
/// ever smaller.
[[nodiscard]] inline Foot search_closest_point(const WidePatch& p, const Point& q, int samples = 48) {
    struct Window {
        Wide u, v, f;
    };
    const auto f = [&](Wide u, Wide v) { return p.half_square(u, v, q); };
    const Wide step = Wide(1) / samples;
    std::vector<Wide> table;
    const auto at = [&](int a, int b) -> Wide& {
        return table[static_cast<std::size_t>(a + b * (samples + 1))];
    };
    table.resize(static_cast<std::size_t>((samples + 1) * (samples + 1)));
    for (int b = 0; b <= samples; ++b) {
        for (int a = 0; a <= samples; ++a) at(a, b) = f(a * step, b * step);
    }
    std::vector<Window> windows;
    for (int b = 0; b <= samples; ++b) {
        for (int a = 0; a <= samples; ++a) {
            bool lowest = true;
            for (int n = std::max(b - 1, 0); n <= std::min(b + 1, samples); ++n) {
                for (int m = std::max(a - 1, 0); m <= std::min(a + 1, samples); ++m) {
                    lowest = lowest && at(m, n) >= at(a, b);
                }
            }
            if (lowest) windows.push_back({a * step, b * step, at(a, b)});
        }
    }
    std::sort(windows.begin(), windows.end(), [](const Window& a, const Window& b) { return a.f < b.f; });
    if (windows.size() > 8) windows.resize(8);
    Foot best{0, 0, std::numeric_limits<Wide>::max()};
    for (Window w : windows) {
        for (Wide half = step; half > Wide(1e-18L); half *= Wide(0.6L)) {
            const Window middle = w;
            for (int b = -2; b <= 2; ++b) {
                for (int a = -2; a <= 2; ++a) {
                    const Wide u = std::clamp(middle.u + a * half / 2, Wide(0), Wide(1));
                    const Wide v = std::clamp(middle.v + b * half / 2, Wide(0), Wide(1));
                    const Wide here = f(u, v);
                    if (here < w.f) w = {u, v, here};
                }
            }
        }
        const Wide distance = std::sqrt(2 * w.f);
        if (distance < best.distance) best = {w.u, w.v, distance};
    }
    return best;
}

/// A point of a terrain's surface: a cell and 0 ≤ u, v ≤ 1 in it.
struct WideSurfacePoint {
    Index i = 0, j = 0;
    Wide u = 0, v = 0;
};

/// The surface over a terrain's samples, computed from its definition. Looks at the samples, so it sees edits.
template <Real S>
class Surface {
public:
    explicit Surface(const Terrain<S>& terrain) : terrain_{&terrain} {}

    [[nodiscard]] bool in_grid(Index i, Index j) const {
        return 0 <= i && i + 1 < terrain_->columns && 0 <= j && j + 1 < terrain_->rows;
    }
    [[nodiscard]] std::optional<WidePatch> patch(Index i, Index j) const {
        if (!in_grid(i, j)) return {};
        const WidePatch p{sample(i, j), sample(i + 1, j), sample(i, j + 1), sample(i + 1, j + 1), dx(), dy()};
        const bool heights =
            has_height(i, j) && has_height(i + 1, j) && has_height(i, j + 1) && has_height(i + 1, j + 1);
        return heights ? std::optional{p} : std::nullopt;
    }
    [[nodiscard]] Wide dx() const { return static_cast<Wide>(terrain_->frame.spacing.x); }
    [[nodiscard]] Wide dy() const { return static_cast<Wide>(terrain_->frame.spacing.y); }
    /// Whether there is a height at this sample, and what it is.
    [[nodiscard]] bool has_sample(Index i, Index j) const { return has_height(i, j); }
    [[nodiscard]] Wide sample_at(Index i, Index j) const { return sample(i, j); }
    /// World position in cells.
    [[nodiscard]] Wide column_of(Wide x) const {
        return (x - static_cast<Wide>(terrain_->frame.origin.x)) / dx();
    }
    [[nodiscard]] Wide row_of(Wide y) const {
        return (y - static_cast<Wide>(terrain_->frame.origin.y)) / dy();
    }
    /// p in metres from the corner of cell (i, j).
    [[nodiscard]] Point seen_from(const Point& p, Index i, Index j) const {
        return {p.x - static_cast<Wide>(terrain_->frame.origin.x) - static_cast<Wide>(i) * dx(),
                p.y - static_cast<Wide>(terrain_->frame.origin.y) - static_cast<Wide>(j) * dy(), p.z};
    }
    [[nodiscard]] Point position(const WideSurfacePoint& s) const {
        return {static_cast<Wide>(terrain_->frame.origin.x) + (static_cast<Wide>(s.i) + s.u) * dx(),
                static_cast<Wide>(terrain_->frame.origin.y) + (static_cast<Wide>(s.j) + s.v) * dy(),
                patch(s.i, s.j)->height(s.u, s.v)};
    }
    /// A cell with a patch over (x, y), and where in it. A point within `slack` cells of a line counts for both sides.
    [[nodiscard]] std::optional<WideSurfacePoint> under(Wide x, Wide y, Wide slack = 0) const {
        const Wide a = column_of(x), b = row_of(y);
        for (const Wide n : {std::floor(b - slack), std::floor(b + slack), std::ceil(b) - 1}) {
            for (const Wide m : {std::floor(a - slack), std::floor(a + slack), std::ceil(a) - 1}) {
                if (std::abs(m) > 1e9L || std::abs(n) > 1e9L) continue;
                const auto i = static_cast<Index>(m), j = static_cast<Index>(n);
                if (patch(i, j)) {
                    return WideSurfacePoint{i, j, std::clamp(a - m, Wide(0), Wide(1)),
                                            std::clamp(b - n, Wide(0), Wide(1))};
                }
            }
        }
        return {};
    }
    /// z of the surface over (x, y), if there is one.
    [[nodiscard]] std::optional<Wide> height(Wide x, Wide y) const {
        const auto at = under(x, y);
        return at ? std::optional{patch(at->i, at->j)->height(at->u, at->v)} : std::nullopt;
    }
    /// The height over (x, y) where there is one, else that of the nearest sample within the grid, else 0.
    [[nodiscard]] Wide height_or(Wide x, Wide y, Wide otherwise) const {
        return height(x, y).value_or(otherwise);
    }

    /// How uncertain a height over the point is, if computed in T from a world position in T: one rounding of
    /// everything that goes in, in metres. Multiply by a small number of roundings.
    [[nodiscard]] Wide blur(const WideSurfacePoint& s, const Point& p, Wide eps) const {
        const auto q = patch(s.i, s.j);
        const Wide mu = std::max(std::abs(q->p10 - q->p00), std::abs(q->p11 - q->p01));
        const Wide mv = std::max(std::abs(q->p01 - q->p00), std::abs(q->p11 - q->p10));
        const Wide top = std::max(std::abs(q->lowest()), std::abs(q->highest()));
        return eps *
               (std::abs(p.z) + top + mu * (1 + std::abs(p.x) / dx()) + mv * (1 + std::abs(p.y) / dy()));
    }

    /// Calls visit(patch, u, v, i, j) for every patch that meets at s: one inside, two at an edge, four at a vertex.
    template <class Visit>
    void each_patch_at(const WideSurfacePoint& s, Visit&& visit) const {
        for (Index dj = -1; dj <= 1; ++dj) {
            for (Index di = -1; di <= 1; ++di) {
                if ((di < 0 && s.u > 0) || (di > 0 && s.u < 1) || (dj < 0 && s.v > 0) || (dj > 0 && s.v < 1))
                    continue;
                const Wide u = di < 0 ? Wide(1) : di > 0 ? Wide(0) : s.u;
                const Wide v = dj < 0 ? Wide(1) : dj > 0 ? Wide(0) : s.v;
                if (const auto p = patch(s.i + di, s.j + dj)) visit(*p, u, v, s.i + di, s.j + dj);
            }
        }
    }
    /// How many of the cells that meet at s have no patch.
    [[nodiscard]] int missing_at(const WideSurfacePoint& s) const {
        int there = 0;
        each_patch_at(s, [&](auto&&...) { ++there; });
        const int cells = (s.u <= 0 || s.u >= 1 ? 2 : 1) * (s.v <= 0 || s.v >= 1 ? 2 : 1);
        return cells - there;
    }
    /// The steepest descent towards q from s into any patch that meets there, in ulp-scales of T: of all the patches
    /// that meet there together, for each sees the same edge; and a position is told from its grid line in double,
    /// where one rounding of its distance from the origin counts.
    template <Real T>
    [[nodiscard]] Wide fall(const WideSurfacePoint& s, const Point& q) const {
        const Wide e = static_cast<Wide>(epsilon<T>), e_double = static_cast<Wide>(epsilon<double>);
        Unit unit;
        each_patch_at(s, [&](const WidePatch& p, Wide u, Wide v, Index i, Index j) {
            const Slopes k = slopes(p, u, v, seen_from(q, i, j));
            unit.u =
                std::max(unit.u, e * k.scale_u + e_double * dx() * dx() * std::abs(static_cast<Wide>(i)));
            unit.v =
                std::max(unit.v, e * k.scale_v + e_double * dy() * dy() * std::abs(static_cast<Wide>(j)));
        });
        Wide steepest = 0;
        each_patch_at(s, [&](const WidePatch& p, Wide u, Wide v, Index i, Index j) {
            steepest = std::max(steepest, fall_into(p, u, v, seen_from(q, i, j), unit));
        });
        return steepest;
    }
    /// The normalised sum of the unit normals of the patches that meet at s.
    [[nodiscard]] Point normal(const WideSurfacePoint& s) const {
        Point sum;
        each_patch_at(s, [&](const WidePatch& p, Wide u, Wide v, Index, Index) {
            const Point n = p.normal(u, v);
            sum = {sum.x + n.x, sum.y + n.y, sum.z + n.z};
        });
        const Wide l = length(sum);
        return {sum.x / l, sum.y / l, sum.z / l};
    }
    [[nodiscard]] Wide half_square(const WideSurfacePoint& s, const Point& q) const {
        return patch(s.i, s.j)->half_square(s.u, s.v, seen_from(q, s.i, s.j));
    }

    /// The end of the way downhill from s towards q in small steps: the gradient flow of ½ distance² on the surface.
    /// Each step goes down most steeply (by the metric of the surface) into one of the patches that meet there, or
    /// along one of their edges; it is at most `stride` cells long, ends on every border it meets, and is halved
    /// until the distance falls.
    [[nodiscard]] WideSurfacePoint flow(WideSurfacePoint s, const Point& q, Wide stride = Wide(1) / 64,
                                        int max_steps = 100000) const {
        Wide tau = 0.5L;
        for (int step = 0; step < max_steps; ++step) {
            const Downhill way = steepest_way(s, q);
            if (!(way.rate > 0)) break;
            const Wide before = half_square(s, q);
            bool moved = false;
            for (; !moved && tau > 1e-14L; tau /= 2) {
                const Wide longest = std::max(std::abs(tau * way.du), std::abs(tau * way.dv));
                if (longest < 1e-13L) break;
                const WideSurfacePoint to = moved_by(way, tau, stride);
                if (half_square(to, q) < before) s = to, moved = true;
            }
            if (!moved) break;
            tau = std::min(tau * 4, Wide(0.5L));
        }
        return s;
    }

    /// Whether two points lie in one basin of the distance to q: they are less than a thousandth of a cell apart, or
    /// the distance does not rise above the farther one on the straight way between them.
    [[nodiscard]] bool same_basin(const WideSurfacePoint& a, const WideSurfacePoint& b,
                                  const Point& q) const {
        const Wide ua = static_cast<Wide>(a.i) + a.u, va = static_cast<Wide>(a.j) + a.v;
        const Wide ub = static_cast<Wide>(b.i) + b.u, vb = static_cast<Wide>(b.j) + b.v;
        if (std::hypot(ub - ua, vb - va) < 1e-3L) return true;
        const Wide top = std::max(half_square(a, q), half_square(b, q)) * (1 + 1e-9L);
        for (int k = 1; k < 256; ++k) {
            const Wide t = Wide(k) / 256;
            const auto there =
                under(static_cast<Wide>(terrain_->frame.origin.x) + (ua + t * (ub - ua)) * dx(),
                      static_cast<Wide>(terrain_->frame.origin.y) + (va + t * (vb - va)) * dy());
            if (!there || half_square(*there, q) > top) return false;
        }
        return true;
    }

private:
    /// A way downhill into a patch, from a point in its coordinates.
    struct Downhill {
        WideSurfacePoint from;
        Wide du = 0, dv = 0;
        Wide rate = 0; ///< by which ½ distance² falls a metre; 0: nothing leads down
    };
    /// The steepest way downhill from s towards q, into any patch that meets there.
    [[nodiscard]] Downhill steepest_way(const WideSurfacePoint& s, const Point& q) const {
        Downhill best{s};
        each_patch_at(s, [&](const WidePatch& p, Wide u, Wide v, Index i, Index j) {
            const Point local = seen_from(q, i, j);
            const Wide zu = p.along_u(v), zv = p.along_v(u), gap = p.height(u, v) - local.z;
            const Wide fu = p.dx * (u * p.dx - local.x) + gap * zu,
                       fv = p.dy * (v * p.dy - local.y) + gap * zv;
            const Wide guu = p.dx * p.dx + zu * zu, gvv = p.dy * p.dy + zv * zv, guv = zu * zv;
            const auto offer = [&](Wide a, Wide b) {
                if ((u <= 0 && a < 0) || (u >= 1 && a > 0) || (v <= 0 && b < 0) || (v >= 1 && b > 0)) return;
                const Wide rate = -(fu * a + fv * b) / std::sqrt(a * a * guu + 2 * a * b * guv + b * b * gvv);
                if (rate > best.rate) best = {{i, j, u, v}, a, b, rate};
            };
            const Wide det = guu * gvv - guv * guv;
            offer((guv * fv - gvv * fu) / det, (guv * fu - guu * fv) / det);
            offer(-fu / guu, 0);
            offer(0, -fv / gvv);
        });
        return best;
    }
    /// tau times the way, but at most `stride` cells and to the first border.
    [[nodiscard]] static WideSurfacePoint moved_by(const Downhill& way, Wide tau, Wide stride) {
        Wide a = tau * way.du, b = tau * way.dv;
        const Wide longest = std::max(std::abs(a), std::abs(b));
        if (longest > stride) a *= stride / longest, b *= stride / longest;
        const WideSurfacePoint& from = way.from;
        const auto room = [](Wide at, Wide by) {
            return by > 0 ? (1 - at) / by : by < 0 ? -at / by : Wide(2);
        };
        const Wide room_a = room(from.u, a), room_b = room(from.v, b);
        const Wide part = std::min(std::min(room_a, room_b), Wide(1));
        const auto moved = [part](Wide at, Wide by, Wide room_by) {
            if (part == room_by) return by > 0 ? Wide(1) : Wide(0);
            return std::clamp(at + part * by, Wide(0), Wide(1));
        };
        WideSurfacePoint to = from;
        to.u = moved(from.u, a, room_a);
        to.v = moved(from.v, b, room_b);
        return to;
    }
    [[nodiscard]] bool has_height(Index i, Index j) const {
        return holds_number(terrain_->at(i, j)) &&
               std::abs(sample(i, j)) < static_cast<Wide>(no_height_from<S>);
    }
    [[nodiscard]] Wide sample(Index i, Index j) const {
        return static_cast<Wide>(terrain_->frame.height_offset) +
               static_cast<Wide>(terrain_->frame.height_scale) * static_cast<Wide>(terrain_->at(i, j));
    }
    const Terrain<S>* terrain_;
};

template <Real T>
[[nodiscard]] WideSurfacePoint wide(const SurfacePoint<T>& s) {
    return {s.cell.i, s.cell.j, static_cast<Wide>(s.u), static_cast<Wide>(s.v)};
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_REFERENCE_HPP
