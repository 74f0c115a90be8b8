#ifndef HFH_GEOMETRY_CLOSEST_POINT_HPP
#define HFH_GEOMETRY_CLOSEST_POINT_HPP

#include <hfh/geometry/newton_step.hpp>
#include <hfh/geometry/safeguarded_step.hpp>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.3.2, Eq. (8)-(11), solved as a projected Newton method
// (Bertsekas, Projected Newton Methods for Optimization Problems with Simple Constraints, 1982).

namespace hfh {

enum class NewtonStatus : unsigned char {
    /// |F_u| and |F_v| are below their rounding error, or lead out of the patch at its border.
    converged,
    at_border,      ///< BorderRule::stop only: on the border, and the descent leads out of the patch
    iteration_limit ///< `max_iterations` steps were taken; the point is still no farther than the start
};

[[nodiscard]] constexpr const char* to_string(NewtonStatus status) noexcept {
    switch (status) {
    case NewtonStatus::converged: return "converged";
    case NewtonStatus::at_border: return "at_border";
    case NewtonStatus::iteration_limit: return "iteration_limit";
    }
    return "unknown";
}

/// What to do where the descent leads out of the patch.
enum class BorderRule : unsigned char {
    slide, ///< go on along the border: ends at the bounded closest point
    stop   ///< return after the step that led there, so that the caller can look at the neighbour
};

struct NewtonOptions {
    BorderRule border = BorderRule::slide;
    /// At least 0. The solver stops by itself and mostly long before this, so fewer save next to nothing. In shallow
    /// contact, up to 0.1 cells deep, 2 steps are exact on gentle ground and 3 on steep. In double 64 are enough for every
    /// query; in float the rounding of F_u and F_v can end the solver in a valley of a patch with relief above 100 cells.
    int max_iterations = 64;
};

template <Real T>
struct NewtonResult {
    T u{}, v{}; ///< the foot point, 0 ≤ u, v ≤ 1
    T gap{};    ///< z of σ = S(u, v) − query there, in metres
    NewtonStatus status = NewtonStatus::converged;
    int iterations = 0; ///< steps taken
};

/// The local closest point of §4.3.2 [P] on one closed patch, downhill from `start`, 0 ≤ u, v ≤ 1.
///
/// Newton's method on Eq. (10), kept in the patch. Where Eq. (11) is not safely positive definite, or a step lowers F by too
/// little, the point follows the floor of the valley that F has there, or goes to the minimum along u or v alone, which is
/// always possible. F never rises, so the point never gets farther from the query. The paper iterates plain Newton; for
/// depths near the radius of curvature that ends elsewhere or nowhere.
///
/// Does not throw and does not allocate.
template <Real T>
[[nodiscard]] NewtonResult<T> newton_closest_point(const BilinearPatch<T>& patch, const CellPoint<T>& query,
                                                   const vec2<T>& start,
                                                   const NewtonOptions& options = {}) noexcept {
    using enum detail::NewtonStep;
    const DistanceFunction<T> distance{patch, query};
    NewtonResult<T> foot{start.x, start.y};
    for (;; ++foot.iterations) {
        vec2<T> at{foot.u, foot.v};
        const auto f = distance(at.x, at.y);
        foot.gap = f.z;
        const detail::ActiveSet active{distance, f, at};
        const bool stops_at_border = options.border == BorderRule::stop && active.leads_out();
        if (stops_at_border && (foot.iterations > 0 || active.is_stationary())) {
            foot.status = NewtonStatus::at_border;
            return foot;
        }
        if (active.is_stationary()) return foot;
        if (foot.iterations == options.max_iterations) {
            foot.status = NewtonStatus::iteration_limit;
            return foot;
        }

        const auto step = active.is_empty() ? detail::newton_step(distance, f, at) : refused;
        if (step == refused || step == barely_to_border)
            at = detail::safeguarded_step(distance, {foot.u, foot.v});
        // Rarely needed, so not before three steps.
        if (foot.iterations >= 3) [[unlikely]]
            distance.snap_flat_axis(at);
        if (at.x == foot.u && at.y == foot.v) return foot; // below the resolution of u and v
        foot.u = at.x;
        foot.v = at.y;
    }
}

} // namespace hfh

#endif // HFH_GEOMETRY_CLOSEST_POINT_HPP
