#ifndef HFH_GEOMETRY_GLOBAL_CLOSEST_POINT_HPP
#define HFH_GEOMETRY_GLOBAL_CLOSEST_POINT_HPP

#include <hfh/geometry/closest_point.hpp>

// The closest point of one closed patch, whichever valley it lies in. The tracker does not use it (a proxy must slide,
// not jump); distance queries and tests do.
//
// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], Eq. (8)-(10). The certificate is the optimality condition
// of trust-region subproblems (Moré and Sorensen, Computing a Trust Region Step, 1983); the search is interval bisection
// (Moore, Interval Analysis, 1966) on the one parameter that is left when the other is at its best.

namespace hfh {

enum class GlobalStatus : unsigned char {
    certified, ///< a stationary point inside with |σ_z A| ≤ dx dy: the closest of the whole unbounded patch
    searched,  ///< the best of the edges and of every stationary point inside
    interval_limit ///< the search was cut short after `GlobalClosestPoint::max_intervals`; the best found so far
};

[[nodiscard]] constexpr const char* to_string(GlobalStatus status) noexcept {
    switch (status) {
    case GlobalStatus::certified: return "certified";
    case GlobalStatus::searched: return "searched";
    case GlobalStatus::interval_limit: return "interval_limit";
    }
    return "unknown";
}

template <Real T>
struct GlobalClosestPoint {
    static constexpr int max_intervals = 1000;

    T u{}, v{}; ///< 0 ≤ u, v ≤ 1
    T gap{};    ///< z of S(u, v) − query there, in metres
    GlobalStatus status = GlobalStatus::certified;
    int intervals = 0; ///< intervals looked at by the search
};

namespace detail {

/// A closed interval. Its arithmetic bounds, but for rounding, what the numbers in it may come to.
struct Interval {
    double low, high;

    [[nodiscard]] static Interval spanned(double a, double b) noexcept {
        return {glm::min(a, b), glm::max(a, b)};
    }
    [[nodiscard]] constexpr bool contains(double x) const noexcept { return low <= x && x <= high; }
    [[nodiscard]] Interval squared() const noexcept {
        const Interval s = spanned(low * low, high * high);
        return contains(0) ? Interval{0, s.high} : s;
    }
    friend constexpr Interval operator+(Interval a, Interval b) noexcept {
        return {a.low + b.low, a.high + b.high};
    }
    friend Interval operator*(Interval a, Interval b) noexcept {
        const Interval p = spanned(a.low * b.low, a.low * b.high),
                       q = spanned(a.high * b.low, a.high * b.high);
        return {glm::min(p.low, q.low), glm::max(p.high, q.high)};
    }
    friend Interval operator*(double k, Interval a) noexcept { return spanned(k * a.low, k * a.high); }
    /// a / b for b > 0.
    friend constexpr Interval operator/(Interval a, Interval b) noexcept {
        return {a.low / (a.low > 0 ? b.high : b.low), a.high / (a.high > 0 ? b.low : b.high)};
    }
};

/// F of Eq. (8) with u at its best for each v, left unclamped:
///
///     φ(v) = ½ [dy² (v − v_q)² + dx² h² / (dx² + s²)],   h = height of the gap over (u_q, v),  s = z_u at v
///     φ'(v) = dy² (v − v_q) + dx² h k / (dx² + s²)²,     k = h' dx² + c s
///
/// h, s and k are linear in v and c = q₁₀ q₀₁ − q₀₀ q₁₁ of the corner gaps, written z_u z_v − q₀₀ A at corner 00. The
/// stationary points of the patch are the roots of φ'; there are at most five.
class ReducedDistance {
public:
    ReducedDistance(const DistanceFunction<double>& f) noexcept
        : dx2_{f.dx2}, dy2_{f.dy2}, query_v_{f.query_v}, h0_{f.gap(f.query_u, 0.0)},
          h1_{f.slope_v(f.query_u)}, s0_{f.rise_u}, s1_{f.twist}, c_{f.rise_u * f.rise_v -
                                                                     f.gap00 * f.twist} {}

    /// φ' at v, and φ''.
    struct Slope {
        double first, second;
    };
    [[nodiscard]] Slope slope(double v) const noexcept {
        const double h = h0_ + h1_ * v, s = s0_ + s1_ * v, k = h1_ * dx2_ + c_ * s, d = dx2_ + s * s;
        return {dy2_ * (v - query_v_) + dx2_ * h * k / (d * d),
                dy2_ + dx2_ * (h1_ * k + h * c_ * s1_) / (d * d) - 4 * dx2_ * h * k * s * s1_ / (d * d * d)};
    }

    /// Bounds over an interval of v: of φ from below, of φ' and of φ''.
    struct Bounds {
        double lowest;
        Interval first, second;
    };
    [[nodiscard]] Bounds bounds(Interval v) const noexcept {
        const auto linear = [v](double at_0, double per_v) {
            return Interval::spanned(at_0 + per_v * v.low, at_0 + per_v * v.high);
        };
        const Interval h = linear(h0_, h1_), s = linear(s0_, s1_),
                       k = linear(h1_ * dx2_ + c_ * s0_, c_ * s1_);
        const Interval s2 = s.squared(), d{dx2_ + s2.low, dx2_ + s2.high}, d2{d.low * d.low, d.high * d.high};
        const Interval apart = linear(-query_v_, 1), hk = h * k;
        const Interval bend = linear(h1_ * (h1_ * dx2_ + c_ * s0_) + h0_ * c_ * s1_, 2 * h1_ * c_ * s1_);
        const Interval first = dy2_ * apart + dx2_ * (hk / d2),
                       second = Interval{dy2_, dy2_} + dx2_ * (bend / d2) +
                                (-4 * dx2_ * s1_) * (hk * s / Interval{d2.low * d.low, d2.high * d.high});
        // φ' also from its value in the middle and from φ'', which is tighter for short intervals.
        const double middle = (v.low + v.high) / 2, slope_there = slope(middle).first;
        const Interval around =
            Interval{slope_there, slope_there} + second * Interval{v.low - middle, v.high - middle};
        return {(dy2_ * apart.squared().low + dx2_ * h.squared().low / d.high) / 2,
                {glm::max(first.low, around.low), glm::min(first.high, around.high)},
                second};
    }

    /// The root of φ' in an interval on which φ'' > 0 and φ' changes sign: Newton's method, kept by bisection.
    [[nodiscard]] double root(Interval v) const noexcept {
        double at = (v.low + v.high) / 2;
        for (int step = 0; step < 100; ++step) {
            const Slope f = slope(at);
            (f.first > 0 ? v.high : v.low) = at;
            double next = at - f.first / f.second;
            if (!(next > v.low && next < v.high)) next = (v.low + v.high) / 2;
            if (next == at || next == v.low || next == v.high) break;
            at = next;
        }
        return at;
    }

private:
    double dx2_, dy2_, query_v_, h0_, h1_, s0_, s1_, c_;
};

} // namespace detail

/// The closest point of a closed patch to a query: no point of the patch is nearer.
///
/// First Newton from below the query. If that ends inside with |σ_z A| ≤ dx dy, and the patch is not so steep that it may
/// have stopped early, it is the answer, certified. Else the four edges, which are straight, and every stationary point
/// inside: u is eliminated, and bisection of v = 0…1 keeps what bounds on F and its derivatives do not rule out, until
/// each piece holds one minimum. Of two equally near points (the medial axis) either. Computes in double for either
/// scalar. Query: z and corners up to 1e±30 metres.
///
/// Does not throw and does not allocate. At most max_intervals intervals are looked at.
template <Real T>
[[nodiscard]] GlobalClosestPoint<T> global_closest_point(const BilinearPatch<T>& patch,
                                                         const CellPoint<T>& query) noexcept {
    using detail::Interval;
    const BilinearPatch<double> wide_patch = widen(patch);
    const CellPoint<double> wide_query{widen(query.u), widen(query.v), widen(query.z)};
    const DistanceFunction<double> distance{wide_patch, wide_query};
    const double dx = wide_patch.spacing.x, dy = wide_patch.spacing.y;

    const auto foot = newton_closest_point(
        wide_patch, wide_query, {glm::clamp(wide_query.u, 0.0, 1.0), glm::clamp(wide_query.v, 0.0, 1.0)});
    GlobalClosestPoint<T> result;
    double u = foot.u, v = foot.v;
    const auto value = [&](double at_u, double at_v) {
        const double x = dx * (at_u - wide_query.u), y = dy * (at_v - wide_query.v),
                     z = distance.gap(at_u, at_v);
        return (x * x + y * y + z * z) / 2;
    };
    double nearest = value(u, v);
    const auto offer = [&](double at_u, double at_v) {
        const double f = value(at_u, at_v);
        if (f < nearest) nearest = f, u = at_u, v = at_v;
    };
    const detail::ReducedDistance reduced{distance};
    const auto offer_best_u = [&](double at_v) { offer(distance.best_u(at_v), at_v); };

    const bool inside = 0 < u && u < 1 && 0 < v && v < 1 && foot.status == NewtonStatus::converged;
    // On a cliff of some thousand cells Newton may stop far from where F is level: a valley is so narrow there that the
    // rounding of F_u and F_v leaves the point some way along it.
    const bool resolved = glm::max(distance.gradient_error_u, distance.gradient_error_v) <
                          1e-7 * glm::min(distance.dx2, distance.dy2);
    if (!inside || !resolved || std::abs(foot.gap * wide_patch.twist()) > dx * dy) {
        result.status = GlobalStatus::searched;
        offer(0, distance.best_v(0));
        offer(1, distance.best_v(1));
        offer(distance.best_u(0), 0);
        offer(distance.best_u(1), 1);

        constexpr int deepest = 40;
        Interval pieces[deepest + 2] = {{0, 1}};
        for (int count = 1; count > 0;) {
            if (result.intervals == GlobalClosestPoint<T>::max_intervals) {
                result.status = GlobalStatus::interval_limit;
                break;
            }
            ++result.intervals;
            const Interval piece = pieces[--count];
            const auto bounds = reduced.bounds(piece);
            if (!(bounds.lowest < nearest) || !bounds.first.contains(0) || bounds.second.high <= 0) continue;
            const double width = piece.high - piece.low, middle = (piece.low + piece.high) / 2;
            if (bounds.second.low > 0) {
                offer_best_u(reduced.root(piece));
                continue;
            }
            offer_best_u(middle);
            // Over a piece this short, or this level, F is the same to the last bits.
            if (width < 0x1p-40 || width * glm::max(-bounds.first.low, bounds.first.high) < 1e-15 * nearest)
                continue;
            pieces[count++] = {piece.low, middle};
            pieces[count++] = {middle, piece.high};
        }
    }
    result.u = static_cast<T>(u);
    result.v = static_cast<T>(v);
    result.gap = static_cast<T>(distance.gap(u, v));
    return result;
}

} // namespace hfh

#endif // HFH_GEOMETRY_GLOBAL_CLOSEST_POINT_HPP
