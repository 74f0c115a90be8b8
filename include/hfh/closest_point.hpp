#ifndef HFH_CLOSEST_POINT_HPP
#define HFH_CLOSEST_POINT_HPP

#include <hfh/bilinear_patch.hpp>
#include <hfh/lattice.hpp>

#include <algorithm>
#include <cmath>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.2, Eq. (8)-(11); the safeguard is that of
// projected Newton methods, Bertsekas, Projected Newton Methods for Optimization Problems with Simple
// Constraints (1982).

namespace hfh {

enum class NewtonStatus : unsigned char {
    converged, ///< |F_u| and |F_v| are below their rounding error, or push out of the patch at its border
    at_border, ///< BorderRule::stop only: on the border, and the descent leads out of the patch
    iteration_limit ///< `max_iterations` steps were taken; the point is still nearer than the start
};

/// What to do where the descent leads out of the patch.
enum class BorderRule : unsigned char {
    slide, ///< go on along the border: ends at the bounded closest point
    stop   ///< return at once, so that the caller can look at the neighbour
};

struct NewtonOptions {
    BorderRule border = BorderRule::slide;
    int max_iterations = 64;
};

template <Real T>
struct NewtonResult {
    T u{}, v{}; ///< the foot point, 0 ≤ u, v ≤ 1
    T gap{};    ///< z of σ = S(u, v) − query there, in metres
    NewtonStatus status = NewtonStatus::converged;
    int iterations = 0; ///< steps taken
};

/// The distance from a query to a patch as a function of (u, v), and its derivatives.
///
///     F(u, v) = ½ |σ|²,  σ = S(u, v) − query                                         Eq. (8)-(9) [P], halved
///     F_u = σ·S_u,  F_v = σ·S_v                                                      Eq. (10)
///     F_uu = S_u·S_u,  F_vv = S_v·S_v,  F_uv = S_u·S_v + σ·S_uv                      Eq. (11)
///
/// in m² per cell and m² per cell². `query` is given in the patch's parameters, z in metres.
template <Real T>
struct DistanceFunction {
    BilinearPatch<T> gap; ///< the patch seen from the query's height: corners − query.z
    T query_u, query_v;
    T noise_u, noise_v; ///< rounding error of F_u and F_v: no descent smaller than this is believed

    DistanceFunction(const BilinearPatch<T>& patch, const CellPoint<T>& query) noexcept
        : gap{patch.p00 - query.z, patch.p10 - query.z, patch.p01 - query.z, patch.p11 - query.z,
              patch.spacing},
          query_u{query.u}, query_v{query.v} {
        // F_u = dx²(u − u_q) + σ_z·z_u. The first term is exact to a relative rounding; σ_z is four roundings of
        // the largest corner and z_u of the larger of the two edge slopes it lies between.
        const T reach = std::max(std::abs(gap.highest()), std::abs(gap.lowest()));
        noise_u = 4 * epsilon<T> * reach * std::max(std::abs(gap.p10 - gap.p00), std::abs(gap.p11 - gap.p01));
        noise_v = 4 * epsilon<T> * reach * std::max(std::abs(gap.p01 - gap.p00), std::abs(gap.p11 - gap.p10));
    }

    /// Everything at one (u, v).
    struct Value {
        T z;             ///< σ_z
        T zu, zv;        ///< slopes, metres per cell
        T fu, fv;        ///< Eq. (10)
        T fuu, fvv, fuv; ///< Eq. (11)
    };
    [[nodiscard]] Value operator()(T u, T v) const noexcept {
        const T dx2 = gap.spacing.x * gap.spacing.x, dy2 = gap.spacing.y * gap.spacing.y;
        const T z = gap.height(u, v), zu = gap.slope_u(v), zv = gap.slope_v(u);
        return {z,
                zu,
                zv,
                dx2 * (u - query_u) + z * zu,
                dy2 * (v - query_v) + z * zv,
                dx2 + zu * zu,
                dy2 + zv * zv,
                zu * zv + z * gap.twist()};
    }

    /// F(u + du, v + dv) − F(u, v): a quartic along the step, written so that nothing cancels.
    [[nodiscard]] T change(const Value& at, T du, T dv) const noexcept {
        const T x = gap.spacing.x * du, y = gap.spacing.y * dv;
        const T z1 = at.zu * du + at.zv * dv, z2 = gap.twist() * du * dv, dz = z1 + z2;
        return at.fu * du + at.fv * dv + at.z * z2 + (x * x + y * y + dz * dz) / 2;
    }
};

/// The local closest point of §4.3.2 on one closed patch, downhill from `start`.
///
/// Newton's method on Eq. (10), kept in 0 ≤ u, v ≤ 1, with a safeguard: on each iteration the Newton step (with
/// the Gauss-Newton matrix, which drops σ·S_uv, where Eq. (11) is not safely positive definite) is taken only
/// if it lowers F at least half as much as the better of the two exact minimisations along u or v alone; else
/// that one is. F never rises, so the point never gets farther from the query, and steps are bounded. The paper
/// iterates plain Newton; for depths near the radius of curvature that ends elsewhere or nowhere.
///
/// Finds a local minimum, the one below `start`. start: 0 ≤ u, v ≤ 1. Does not allocate.
template <Real T>
[[nodiscard]] NewtonResult<T> newton_closest_point(const BilinearPatch<T>& patch, const CellPoint<T>& query,
                                                   const vec2<T>& start,
                                                   const NewtonOptions& options = {}) noexcept {
    const DistanceFunction<T> distance{patch, query};
    NewtonResult<T> foot{start.x, start.y};
    NewtonResult<T> last = foot;
    T last_residual = std::numeric_limits<T>::max();
    bool at_resolution = false; // the last step was an ulp or two of u and v
    for (;; ++foot.iterations) {
        const auto f = distance(foot.u, foot.v);
        foot.gap = f.z;

        // A component may move if its derivative is more than noise and does not push across the border.
        const bool pulls_u = std::abs(f.fu) > distance.noise_u, pulls_v = std::abs(f.fv) > distance.noise_v;
        const bool held_u = f.fu > 0 ? foot.u <= 0 : foot.u >= 1,
                   held_v = f.fv > 0 ? foot.v <= 0 : foot.v >= 1;
        if (options.border == BorderRule::stop && ((pulls_u && held_u) || (pulls_v && held_v))) {
            foot.status = NewtonStatus::at_border;
            return foot;
        }
        const bool free_u = pulls_u && !held_u, free_v = pulls_v && !held_v;
        if (!free_u && !free_v) return foot;

        // Steps of the last bits are kept only while they still help, so that they cannot go round in circles
        // and a stylus that rests leaves the proxy at rest.
        const T residual = (free_u ? f.fu * f.fu / f.fuu : T(0)) + (free_v ? f.fv * f.fv / f.fvv : T(0));
        if (at_resolution && residual >= last_residual) return last;
        if (foot.iterations == options.max_iterations) {
            foot.status = NewtonStatus::iteration_limit;
            return foot;
        }
        last = foot;
        last_residual = residual;

        // Exact minimisation along one parameter: F is a parabola along u and along v.
        const T along_u = free_u ? std::clamp(foot.u - f.fu / f.fuu, T(0), T(1)) : foot.u;
        const T along_v = free_v ? std::clamp(foot.v - f.fv / f.fvv, T(0), T(1)) : foot.v;
        const T gain_u = distance.change(f, along_u - foot.u, T(0));
        const T gain_v = distance.change(f, T(0), along_v - foot.v);
        T u = gain_u <= gain_v ? along_u : foot.u;
        T v = gain_u <= gain_v ? foot.v : along_v;

        if (!held_u && !held_v) {
            // det of Eq. (11), from the Gauss-Newton determinant dx²dy² + dx²z_v² + dy²z_u² so that it does not
            // cancel on steep ground.
            const T dx2 = patch.spacing.x * patch.spacing.x, dy2 = patch.spacing.y * patch.spacing.y;
            const T slopes = f.zu * f.zv, bend = f.fuv - slopes;
            const T gauss_newton = dx2 * f.fvv + dy2 * f.zu * f.zu;
            const T newton = gauss_newton - bend * (2 * slopes + bend);
            const bool definite = newton > gauss_newton / 16;
            const T determinant = definite ? newton : gauss_newton, cross = definite ? f.fuv : slopes;
            T du = (cross * f.fv - f.fvv * f.fu) / determinant,
              dv = (cross * f.fu - f.fuu * f.fv) / determinant;

            // As much of the step as stays in the patch.
            const T room_u = du > 0 ? 1 - foot.u : foot.u, room_v = dv > 0 ? 1 - foot.v : foot.v;
            const T part_u = std::abs(du) > room_u ? room_u / std::abs(du) : T(1);
            const T part_v = std::abs(dv) > room_v ? room_v / std::abs(dv) : T(1);
            const T part = std::min(part_u, part_v);
            du *= part, dv *= part;
            if (distance.change(f, du, dv) <= std::min(gain_u, gain_v) / 2) {
                // A component that met the border is on it, not a rounding away.
                u = part == part_u && part < 1 ? (du > 0 ? T(1) : T(0)) : std::clamp(foot.u + du, T(0), T(1));
                v = part == part_v && part < 1 ? (dv > 0 ? T(1) : T(0)) : std::clamp(foot.v + dv, T(0), T(1));
            }
        }
        if (u == foot.u && v == foot.v) return foot; // the step is below the resolution of u and v
        at_resolution = std::max(std::abs(u - foot.u), std::abs(v - foot.v)) <= 4 * epsilon<T>;
        foot.u = u;
        foot.v = v;
    }
}

} // namespace hfh

#endif // HFH_CLOSEST_POINT_HPP
