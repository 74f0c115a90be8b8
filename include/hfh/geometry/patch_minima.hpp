#ifndef HFH_GEOMETRY_PATCH_MINIMA_HPP
#define HFH_GEOMETRY_PATCH_MINIMA_HPP

#include <hfh/geometry/global_closest_point.hpp>

#include <cmath>
#include <initializer_list>

// The closest point of one patch where it matters only if it is nearer than what is known already, and all local closest
// points of one patch: what a search over many patches asks of each. In metres and in double, seen from the query.
//
// With the query as the origin, and x, y, z there, a stationary point of the distance to z = h + g·x + k·y + m·x·y is
//
//     x = −z (g + m y),  y = −z (k + m x)
//
// Let t = z m. If |t| ≤ 1 there, the point is the closest of the patch: (x² + y² + ζ²)/2 − z (ζ − h − g x − k y − m x y)
// is then a convex function of x, y and ζ, has its minimum over the cell there, and is half the squared distance on the
// surface. That holds on the border of the cell as well, where the distance only may not fall into the patch.
//
// Based on: Moré and Sorensen, Computing a Trust Region Step (1983), for the one-dimensional (secular) equation; Boyd and
// Vandenberghe, Convex Optimization (2004), §5.9, for the certificate.

namespace hfh::detail {

/// The squared distance of what was not found. A number, for under -ffast-math nothing is compared with infinity.
inline constexpr double not_found = std::numeric_limits<double>::max();

/// A patch seen from a query: the query is the origin, in metres.
struct RelativePatch {
    double x, y;               ///< of corner 00
    double dx, dy;             ///< spacing
    double z00, z10, z01, z11; ///< of the corners

    /// A point of a patch, seen from the query, and its squared distance.
    struct Foot {
        double u = 0, v = 0;
        glm::dvec3 offset{0.0};
        double squared = 0;
    };

    [[nodiscard]] double lowest() const noexcept { return glm::min(glm::min(z00, z10), glm::min(z01, z11)); }
    [[nodiscard]] double highest() const noexcept { return glm::max(glm::max(z00, z10), glm::max(z01, z11)); }
    [[nodiscard]] double twist() const noexcept { return (z11 - z01) - (z10 - z00); }
    /// Metres of height per cell along u and v.
    [[nodiscard]] double slope_u(double v) const noexcept { return (1 - v) * (z10 - z00) + v * (z11 - z01); }
    [[nodiscard]] double slope_v(double u) const noexcept { return (1 - u) * (z01 - z00) + u * (z11 - z10); }
    [[nodiscard]] Foot foot(double u, double v) const noexcept {
        const glm::dvec3 offset{x + u * dx, y + v * dy,
                                (1 - v) * ((1 - u) * z00 + u * z10) + v * ((1 - u) * z01 + u * z11)};
        return {u, v, offset, offset.x * offset.x + offset.y * offset.y + offset.z * offset.z};
    }

    /// Along the normal, up; of any length.
    [[nodiscard]] glm::dvec3 upward(double u, double v) const noexcept {
        return {-slope_u(v) * dy, -slope_v(u) * dx, dx * dy};
    }

    /// No point of the patch lies nearer than this, squared: the distance of the box that holds it.
    [[nodiscard]] double box_squared() const noexcept {
        const double off_x = glm::max(glm::max(x, -(x + dx)), 0.0),
                     off_y = glm::max(glm::max(y, -(y + dy)), 0.0),
                     off_z = glm::max(glm::max(lowest(), -highest()), 0.0);
        return off_x * off_x + off_y * off_y + off_z * off_z;
    }
    /// Whether the patch, which lies in the hull of its corners, lies beyond the plane that stands on `foot.offset` at its
    /// end. If it does no point of it is nearer than that.
    [[nodiscard]] bool is_beyond(const Foot& foot) const noexcept {
        return least_along(foot.offset) >= foot.squared;
    }

    /// The least n·p of a point p of the patch, which lies in the hull of its corners.
    [[nodiscard]] double least_along(const glm::dvec3& n) const noexcept {
        const double at_x0 = n.x * x, at_x1 = n.x * (x + dx), at_y0 = n.y * y, at_y1 = n.y * (y + dy);
        return glm::min(glm::min(at_x0 + at_y0 + n.z * z00, at_x1 + at_y0 + n.z * z10),
                        glm::min(at_x0 + at_y1 + n.z * z01, at_x1 + at_y1 + n.z * z11));
    }
    /// A point amid the patch.
    [[nodiscard]] glm::dvec3 middle() const noexcept {
        return {x + dx / 2, y + dy / 2, ((z00 + z11) + (z10 + z01)) / 4};
    }

    /// The same with the library's words for one patch and a query.
    [[nodiscard]] BilinearPatch<double> patch() const noexcept { return {z00, z10, z01, z11, {dx, dy}}; }
    [[nodiscard]] CellPoint<double> query() const noexcept { return {-x / dx, -y / dy, 0}; }
};

/// Where distances are equal but for roundings, a point inside is the minimum rather than one of an edge, and one of an edge
/// rather than a corner: a distance is level about its minimum, and does not tell its place better than to half the digits.
inline constexpr double nearly_equal = 1 + 8 * epsilon<double>;

/// The closest point of an edge, which is straight: along u at v = 0 or 1 (the upper one), or along v at u = 0 or 1.
template <Real T = double>
[[nodiscard, HFH_ALWAYS_INLINED]] inline RelativePatch::Foot
closest_on_edge(const RelativePatch& p, bool along_u, bool upper) noexcept {
    const double begin = along_u ? (upper ? p.z01 : p.z00) : (upper ? p.z10 : p.z00),
                 end = along_u ? (upper ? p.z11 : p.z10) : (upper ? p.z11 : p.z01);
    const double start = along_u ? p.x : p.y, rise = along_u ? p.dx : p.dy, climb = end - begin;
    const double w = glm::clamp(-(start * rise + begin * climb) / (rise * rise + climb * climb), 0.0, 1.0);
    const double along = start + w * rise, z = (1 - w) * begin + w * end;
    const double across = along_u ? (upper ? p.y + p.dy : p.y) : (upper ? p.x + p.dx : p.x);
    const double side = upper ? 1 : 0, squared = along * along + across * across + z * z;
    return along_u ? RelativePatch::Foot{w, side, {along, across, z}, squared}
                   : RelativePatch::Foot{side, w, {across, along, z}, squared};
}

/// The closest point of the four edges.
template <Real T = double>
[[nodiscard]] RelativePatch::Foot closest_on_edges(const RelativePatch& p) noexcept {
    RelativePatch::Foot best{.squared = not_found};
    double smallest = best.squared;
    for (const bool along_u : {true, false}) {
        for (const bool upper : {false, true}) {
            const auto foot = closest_on_edge(p, along_u, upper);
            const double w = along_u ? foot.u : foot.v;
            const bool corner = w == 0 || w == 1;
            const double squared = corner ? foot.squared * nearly_equal : foot.squared;
            if (squared < smallest) smallest = squared, best = foot;
        }
    }
    return best;
}

/// The stationary point with |t| < 1 of the unbounded patch, which is the closest point of that, if it is in the cell. There
/// is one at most, and none where the query lies on the medial axis; it is not found very near to that either (|t| from 0.999
/// on). Where none is found the result's `squared` is `not_found`. With q = S_y and
/// p = S_x there, and g, k, z₀ the slopes and the height over (0, 0):
///
///     p = (g − t k)/(1 − t²),  q = (k − t g)/(1 − t²),  x = −z p,  y = −z q
///     ψ(z) = z₀ − z (1 + g p + k q − t p q) = 0,  ψ' = −1 − (p² − 2 t p q + q²)/(1 − t²) < 0
///
/// Newton's method from the foot on the tangent plane under the query, kept between 0 and z₀. At most 40 steps.
[[nodiscard]] inline RelativePatch::Foot secular_foot(const RelativePatch& patch) noexcept {
    const double per_x = 1 / patch.dx, per_y = 1 / patch.dy;
    const double uq = -patch.x * per_x, vq = -patch.y * per_y;
    const double g = patch.slope_u(vq) * per_x, k = patch.slope_v(uq) * per_y;
    const double m = patch.twist() * per_x * per_y;
    const double z0 =
        (1 - vq) * ((1 - uq) * patch.z00 + uq * patch.z10) + vq * ((1 - uq) * patch.z01 + uq * patch.z11);
    RelativePatch::Foot none{.squared = not_found};
    double low = 0, high = z0; // ψ has the sign of z₀ at low, and not at high
    if (std::abs(z0 * m) >= 1) high = std::copysign(1 / std::abs(m), z0);
    double z = z0 / (1 + g * g + k * k);
    for (int step = 0; step < 40; ++step) {
        if (!(std::abs(z * m) < 1)) z = (low + high) / 2;
        const double t = z * m, r = 1 / (1 - t * t), p = (g - t * k) * r, q = (k - t * g) * r;
        const double psi = z0 - z * (1 + g * p + k * q - t * p * q);
        const double fall = 1 + (p * p - 2 * t * p * q + q * q) * r;
        (psi * z0 > 0 ? low : high) = z;
        const double change = psi / fall;
        double next = z + change;
        if (std::abs(change) <= 1e-8 * std::abs(z)) {
            // Newton's method doubles the digits, but where ψ' grows without end.
            const double s = next * m, w = 1 / (1 - s * s);
            if (!(std::abs(s) < 0.999)) return none;
            const double u = uq - next * (g - s * k) * w * per_x, v = vq - next * (k - s * g) * w * per_y;
            if (!(0 <= u && u <= 1 && 0 <= v && v <= 1)) return none;
            return patch.foot(u, v);
        }
        if (!(glm::min(low, high) < next && next < glm::max(low, high))) next = (low + high) / 2;
        z = next;
    }
    return none;
}

/// What the closest point of a patch may be, by how far the heights turn under the query.
class PatchShape {
public:
    explicit PatchShape(const RelativePatch& p) noexcept : dx_{p.dx}, dy_{p.dy}, twist_{std::abs(p.twist())} {
        rise_u_ = glm::max(std::abs(p.z10 - p.z00), std::abs(p.z11 - p.z01));
        rise_v_ = glm::max(std::abs(p.z01 - p.z00), std::abs(p.z11 - p.z10));
        const double low = p.lowest(), high = p.highest();
        least_z_ = glm::max(glm::max(low, -high), 0.0);
        most_z_ = glm::max(-low, high);
        const double reach = most_z_ + rise_u_ + rise_v_;
        const bool is_resolved = rise_u_ * reach < 1e8 * dx_ * dx_ && rise_v_ * reach < 1e8 * dy_ * dy_;
        most_ = is_resolved ? 0.999 * dx_ * dy_ : 0;
    }

    /// All stationary points within the distance have |t| < 1: there is one local closest point at most, that of the patch.
    [[nodiscard]] bool has_one_minimum(double reach_squared) const noexcept {
        return certifies(most_z_) || twist_ * twist_ * reach_squared < most_ * most_;
    }
    /// Each local closest point lies on an edge.
    [[nodiscard]] bool has_minima_on_edges_only() const noexcept {
        // Eq. (11) is positive definite where (1 + S_x²)(1 + S_y²) > (S_x S_y + t)²; both sides times dx² dy².
        const double convex =
            rise_u_ * rise_v_ + std::sqrt((dx_ * dx_ + rise_u_ * rise_u_) * (dy_ * dy_ + rise_v_ * rise_v_));
        return twist_ * least_z_ > 1.001 * convex;
    }
    /// The patch is not so steep that rounding hides where the distance is level.
    [[nodiscard]] bool resolved() const noexcept { return most_ > 0; }
    /// Whether a stationary point at this height is the closest of the patch. A little below 1, so that what rounding hides
    /// of a descent at the point leads down by no more than roundings.
    [[nodiscard]] bool certifies(double z) const noexcept { return twist_ * std::abs(z) < most_; }

private:
    double dx_, dy_, twist_;
    double rise_u_, rise_v_;  ///< of the steeper edge, metres per cell
    double least_z_, most_z_; ///< between these the sizes of its heights are
    double most_;             ///< of twist·|z| for a certificate; 0 if the patch is not resolved
};

/// Whether the distance falls from a point of the border into the patch.
[[nodiscard]] inline bool leads_inward(const RelativePatch& p, const RelativePatch::Foot& at) noexcept {
    const double fu = p.dx * at.offset.x + at.offset.z * p.slope_u(at.v),
                 fv = p.dy * at.offset.y + at.offset.z * p.slope_v(at.u);
    return (at.u <= 0 && fu < 0) || (at.u >= 1 && fu > 0) || (at.v <= 0 && fv < 0) || (at.v >= 1 && fv > 0);
}

/// The closest point of a closed patch, wherever it is. Seldom more than the four edges; where no certificate holds, the search
/// of `global_closest_point`. A template, so that who does not call it compiles nothing of that search.
template <Real T = double>
[[nodiscard, gnu::noinline]] RelativePatch::Foot search_patch(const RelativePatch& p,
                                                              const PatchShape& shape) noexcept {
    const auto edge = closest_on_edges(p);
    if (shape.certifies(edge.offset.z) && !leads_inward(p, edge)) return edge;
    if (shape.has_minima_on_edges_only()) return edge;
    if (shape.resolved()) {
        const auto inside = secular_foot(p);
        if (inside.squared < not_found) return inside;
    }
    const auto found = global_closest_point(p.patch(), p.query());
    const auto foot = p.foot(found.u, found.v);
    return foot.squared <= edge.squared * nearly_equal ? foot : edge;
}

/// The closest point of a closed patch. Mostly a certificate holds at once: on an edge that faces the query in plan, or inside the
/// patch under the query.
template <Real T = double>
[[nodiscard]] RelativePatch::Foot closest_of_patch(const RelativePatch& p, const PatchShape& shape) noexcept {
    const double off_x = glm::max(p.x, -(p.x + p.dx)), off_y = glm::max(p.y, -(p.y + p.dy));
    RelativePatch::Foot foot;
    // Along an edge its closest point is a minimum; across it the distance must not fall into the patch.
    const auto is_on_edge_along_u = [&] {
        foot = closest_on_edge(p, true, p.y < 0);
        const double rises = p.dy * foot.offset.y + foot.offset.z * p.slope_v(foot.u);
        return shape.certifies(foot.offset.z) && (p.y < 0 ? rises <= 0 : rises >= 0);
    };
    const auto is_on_edge_along_v = [&] {
        foot = closest_on_edge(p, false, p.x < 0);
        const double rises = p.dx * foot.offset.x + foot.offset.z * p.slope_u(foot.v);
        return shape.certifies(foot.offset.z) && (p.x < 0 ? rises <= 0 : rises >= 0);
    };
    const auto is_inside = [&] {
        foot = secular_foot(p);
        const auto amid = [](double w) { return w > 1e-6 && w < 1 - 1e-6; };
        return foot.squared < not_found && amid(foot.u) && amid(foot.v);
    };
    if (off_x <= 0 && off_y <= 0) {
        if (shape.resolved() && is_inside()) return foot;
    } else if (off_x > off_y) {
        if (is_on_edge_along_v() || (off_y > 0 && is_on_edge_along_u())) return foot;
    } else {
        if (is_on_edge_along_u() || (off_x > 0 && is_on_edge_along_v())) return foot;
    }
    foot = search_patch(p, shape);
    return foot;
}
template <Real T = double>
[[nodiscard]] RelativePatch::Foot closest_of_patch(const RelativePatch& p) noexcept {
    return closest_of_patch(p, PatchShape{p});
}

/// Collects local closest points of one patch, each once.
template <class Visitor>
class MinimaOfPatch {
public:
    MinimaOfPatch(const RelativePatch& patch, double reach_squared, Visitor& visit) noexcept
        : patch_{patch}, reach_squared_{reach_squared}, visit_{visit} {}

    /// False if the visitor wants no more.
    [[nodiscard]] bool offer(double u, double v, double apart) noexcept {
        const auto foot = patch_.foot(u, v);
        if (!(foot.squared <= reach_squared_)) return true;
        for (int k = 0; k < count_; ++k) {
            if (std::abs(known_[k].x - u) <= apart && std::abs(known_[k].y - v) <= apart) return true;
        }
        if (count_ < most) known_[count_++] = {u, v};
        return visit_(foot);
    }

private:
    /// Four corners, four edges and three minima inside; more only where they are one to the last bits.
    static constexpr int most = 16;

    const RelativePatch& patch_;
    double reach_squared_;
    Visitor& visit_;
    glm::dvec2 known_[most];
    int count_ = 0;
};

/// How a visit of the minima of a patch ended.
enum class MinimaEnd : unsigned char { complete, stopped, cut_short };

/// Offers the local closest points inside the patch: where φ of `ReducedDistance` has its minima, found by bisection.
template <class Visitor>
[[nodiscard]] MinimaEnd offer_inner_minima(const DistanceFunction<double>& distance, double reach_squared,
                                           MinimaOfPatch<Visitor>& minima) noexcept {
    const ReducedDistance reduced{distance};
    const auto offer = [&](double v, double apart) {
        const double s = distance.slope_u(v);
        const double u =
            (distance.dx2 * distance.query_u - distance.gap(0.0, v) * s) / (distance.dx2 + s * s);
        return !(0 < u && u < 1 && 0 < v && v < 1) || minima.offer(u, v, apart);
    };
    constexpr int deepest = 40;
    Interval pieces[deepest + 2];
    pieces[0] = {0, 1};
    int intervals = 0;
    for (int count = 1; count > 0;) {
        if (++intervals > GlobalClosestPoint<double>::max_intervals) return MinimaEnd::cut_short;
        const Interval piece = pieces[--count];
        const auto bounds = reduced.bounds(piece);
        if (2 * bounds.lowest > reach_squared || !bounds.first.contains(0) || bounds.second.high < 0)
            continue;
        const double width = piece.high - piece.low, middle = (piece.low + piece.high) / 2;
        if (bounds.second.low > 0) {
            // The bounds may hold a zero that φ' has not; neighbouring pieces compute φ' alike at their common end.
            const bool has_root = reduced.slope(piece.low).first <= 0 && reduced.slope(piece.high).first >= 0;
            if (has_root && !offer(reduced.root(piece), 1e-7)) return MinimaEnd::stopped;
            continue;
        }
        // Over a piece this short, or this level, F is the same to the last bits.
        const double fall = width * glm::max(-bounds.first.low, bounds.first.high);
        if (width < 0x1p-40 || fall < 1e-15 * bounds.lowest) {
            if (!offer(middle, glm::max(4 * width, 1e-7))) return MinimaEnd::stopped;
            continue;
        }
        pieces[count++] = {piece.low, middle};
        pieces[count++] = {middle, piece.high};
    }
    return MinimaEnd::complete;
}

/// Calls visit(foot) for every local closest point of the closed patch within the distance, until it returns false: at the
/// corners, on the edges and inside, in this order, each once. A point of the border counts unless the distance falls into
/// the patch by more than the rounding of its derivative, so none is left out, and one may be too many that is level to
/// first order. `cut_short`: the search for those inside took too many intervals, and the list may lack some.
template <class Visitor>
[[nodiscard]] MinimaEnd visit_minima(const RelativePatch& patch, double reach_squared,
                                     Visitor&& visit) noexcept {
    const PatchShape shape{patch};
    if (shape.has_one_minimum(reach_squared)) {
        const auto foot = closest_of_patch(patch, shape);
        return !(foot.squared <= reach_squared) || visit(foot) ? MinimaEnd::complete : MinimaEnd::stopped;
    }
    MinimaOfPatch minima{patch, reach_squared, visit};
    const DistanceFunction<double> distance{patch.patch(), patch.query()};
    const auto offer_on_border = [&](double u, double v) {
        const auto f = distance(u, v);
        const double eu = distance.gradient_error_u, ev = distance.gradient_error_v;
        const bool falls = (u <= 0 && f.fu < -eu) || (u >= 1 && f.fu > eu) || (v <= 0 && f.fv < -ev) ||
                           (v >= 1 && f.fv > ev);
        return falls || minima.offer(u, v, 0);
    };
    for (const double side : {0.0, 1.0}) {
        if (!offer_on_border(side, 0) || !offer_on_border(side, 1)) return MinimaEnd::stopped;
    }
    for (const double side : {0.0, 1.0}) {
        if (!offer_on_border(distance.best_u(side), side) || !offer_on_border(side, distance.best_v(side)))
            return MinimaEnd::stopped;
    }
    if (shape.has_minima_on_edges_only()) return MinimaEnd::complete;
    return offer_inner_minima(distance, reach_squared, minima);
}

} // namespace hfh::detail

#endif // HFH_GEOMETRY_PATCH_MINIMA_HPP
