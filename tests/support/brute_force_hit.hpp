#ifndef HFH_TESTS_SUPPORT_BRUTE_FORCE_HIT_HPP
#define HFH_TESTS_SUPPORT_BRUTE_FORCE_HIT_HPP

#include "terrains.hpp"

#include <hfh/geometry/surface_point.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

// Where a segment crosses a terrain, in long double, from the samples alone: every cell of the grid is asked, each has
// one quadratic in the time along the whole segment, and the pieces are sorted afterwards.

namespace hfh::test {

struct BruteForceHit {
    bool hit = false;
    long double t = 1;      ///< of the crossing
    Side side = Side::none; ///< hit: where it came from; else where it ended
};

/// z of the segment less z of the surface, c0 + c1 t + c2 t², over one cell.
struct HitPiece {
    long double t_in, t_out, c0, c1, c2;

    [[nodiscard]] long double at(long double t) const { return c0 + t * (c1 + t * c2); }

    /// The first t in [from, t_out] from which on sign·f is negative; at `from` only if `fresh`, not a root just found.
    [[nodiscard]] std::optional<long double> turns_negative(long double from, int sign, bool fresh) const {
        const long double a = sign * c2, b = sign * c1, c = sign * c0;
        if (fresh && c + from * (b + from * a) < 0) return from;
        long double root = -1;
        if (a == 0) {
            if (b < 0) root = -c / b;
        } else {
            const long double discriminant = b * b - 4 * a * c;
            if (discriminant <= 0) return std::nullopt;
            // Falling through the smaller root of an upright parabola, the larger of one upside down.
            const long double q = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
            root = q == 0 ? 0 : a > 0 ? std::min(q / a, c / q) : std::max(q / a, c / q);
        }
        if (root < from || root >= t_out || (root == from && !fresh)) return std::nullopt;
        return root;
    }
};

template <Real T>
[[nodiscard]] std::vector<HitPiece> hit_pieces(const Terrain<T>& terrain, const glm::dvec3& a,
                                               const glm::dvec3& b) {
    using Exact = long double;
    struct Vector {
        Exact x, y, z;
    };
    const auto exact = [](const glm::dvec3& p) { return Vector{Exact(p.x), Exact(p.y), Exact(p.z)}; };
    const Vector from = exact(a), to = exact(b), spacing = exact({terrain.frame.spacing, 0}),
                 origin = exact({terrain.frame.origin, 0});
    std::vector<HitPiece> pieces;
    for (Index j = 0; j + 1 < terrain.rows; ++j) {
        for (Index i = 0; i + 1 < terrain.columns; ++i) {
            // In cells from the corner: where the segment begins and how far it goes.
            const Exact u0 = (from.x - origin.x) / spacing.x - static_cast<Exact>(i);
            const Exact v0 = (from.y - origin.y) / spacing.y - static_cast<Exact>(j);
            const Exact du = (to.x - from.x) / spacing.x, dv = (to.y - from.y) / spacing.y;
            Exact t_in = 0, t_out = 1;
            const auto clip = [&](Exact w, Exact by) {
                if (by == 0) return w >= 0 && w <= 1;
                t_in = std::max(t_in, std::min(-w / by, (1 - w) / by));
                t_out = std::min(t_out, std::max(-w / by, (1 - w) / by));
                return true;
            };
            if (!clip(u0, du) || !clip(v0, dv) || t_in > t_out) continue;
            const auto height = [&](Index column, Index row) { return Exact(terrain.at(column, row)); };
            const Exact p00 = height(i, j), p10 = height(i + 1, j), p01 = height(i, j + 1),
                        p11 = height(i + 1, j + 1);
            if (!holds_number(terrain.at(i, j)) || !holds_number(terrain.at(i + 1, j)) ||
                !holds_number(terrain.at(i, j + 1)) || !holds_number(terrain.at(i + 1, j + 1))) {
                continue;
            }
            const Exact A = p11 - p10 - p01 + p00, B = p10 - p00, C = p01 - p00; // Eq. (2)-(5) [P]
            pieces.push_back({t_in, t_out, from.z - (u0 * v0 * A + u0 * B + v0 * C + p00),
                              to.z - from.z - ((u0 * dv + du * v0) * A + du * B + dv * C), -du * dv * A});
        }
    }
    std::sort(pieces.begin(), pieces.end(), [](const HitPiece& l, const HitPiece& r) {
        return l.t_in != r.t_in ? l.t_in < r.t_in : l.t_out < r.t_out;
    });
    return pieces;
}

/// The crossing that `first_hit` promises, with the segment lifted by `lift` metres.
[[nodiscard]] inline BruteForceHit brute_force_hit(std::vector<HitPiece> pieces, SurfaceKind kind,
                                                   Side side = Side::none, long double lift = 0) {
    constexpr long double gap = 1e-12L; // pieces join but for the rounding of their ends
    long double covered_to = 0;
    for (HitPiece& piece : pieces) {
        piece.c0 += lift;
        if (piece.t_in > covered_to + gap) side = Side::none;
        // Along a grid line two cells share a part of the segment; the second has nothing to add.
        long double t = std::max(piece.t_in, covered_to);
        bool fresh = true;
        covered_to = std::max(covered_to, piece.t_out);
        if (side == Side::none) side = piece.at(t) >= 0 ? Side::above : Side::below;
        while (const auto crossing = piece.turns_negative(t, side == Side::above ? 1 : -1, fresh)) {
            fresh = false;
            t = *crossing;
            if (side == Side::above || kind == SurfaceKind::sheet) return {true, t, side};
            side = Side::above; // out of the solid
        }
    }
    return {false, 1, covered_to + gap < 1 ? Side::none : side};
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_BRUTE_FORCE_HIT_HPP
