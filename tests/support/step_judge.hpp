#ifndef HFH_TESTS_SUPPORT_STEP_JUDGE_HPP
#define HFH_TESTS_SUPPORT_STEP_JUDGE_HPP

#include "hard_patches.hpp"

#include <algorithm>
#include <cmath>
#include <string>

// Steps within one patch, judged by all of their way and not by its end alone.

namespace hfh::test {

/// A patch, a query and where the steps begin.
template <Real T>
struct StepCase {
    BilinearPatch<T> patch;
    CellPoint<T> query;
    vec2<T> start;
};

/// Half of them hard patches, half saddles of a few cells, on the ridges of which a step can lead over; from inside and from
/// borders. Nothing but what the scalar's squares and fourth powers can hold.
template <Real T>
[[nodiscard]] StepCase<T> step_case(Random& random) {
    const auto parameter = [&] {
        return random.one_in(4) ? static_cast<T>(random.whole(0, 1)) : static_cast<T>(random.unit());
    };
    for (;;) {
        StepCase<T> made;
        made.start = {parameter(), parameter()};
        if (random.one_in(2)) {
            const auto hard = hard_patch_case<T>(random);
            made.patch = hard.patch;
            made.query = hard.query;
        } else {
            const double relief = power(random, -1, 1.3),
                         crooked = random.one_in(2) ? 0.3 * random.unit() : 0;
            const auto height = [&](double h) {
                return static_cast<T>(relief * (h + crooked * random.between(-1, 1)));
            };
            const double low = random.one_in(2) ? 0 : 1;
            made.patch = {height(low), height(1 - low), height(1 - low), height(low), {1, 1}};
            const double u = random.between(-1, 2), v = random.between(-1, 2);
            made.query = {static_cast<T>(u), static_cast<T>(v),
                          static_cast<T>(static_cast<double>(made.patch.height(T(0.5), T(0.5))) -
                                         power(random, -2, 1) * (random.one_in(4) ? -1 : 1))};
        }
        const T size = std::max({made.patch.spacing.x, made.patch.spacing.y, std::abs(made.query.z),
                                 std::abs(made.patch.highest()), std::abs(made.patch.lowest())});
        const T small = std::min(made.patch.spacing.x, made.patch.spacing.y);
        // 1e±30 and denormal heights are of the closest point's certificate.
        if (size < T(1e6) && small > T(1e-6)) return made;
    }
}

/// What is wrong with the way of a step.
struct Rise {
    Wide height = 0; ///< the largest rise of F above its lowest value before, as a share of it there; 0: none
    bool ridge = false; ///< F falls again behind it, the step ends in another valley
};

/// Whether the distance rises on the way of a step from one point of a patch to another.
class StepJudge {
public:
    template <Real T>
    StepJudge(const BilinearPatch<T>& patch, const CellPoint<T>& query)
        : seen_{PatchCase<T>{patch, query}}, epsilon_{static_cast<Wide>(epsilon<T>)} {}

    /// The rise by more than roundings. A step is straight, or follows the floor of a bent valley: the way on which F rises
    /// least counts.
    template <Real T>
    [[nodiscard]] Rise rise(const vec2<T>& from, const vec2<T>& to) const {
        const Step step{static_cast<Wide>(from.x), static_cast<Wide>(from.y), static_cast<Wide>(to.x),
                        static_cast<Wide>(to.y)};
        // 64 times the rounding of F_u and F_v, over the step.
        const Slopes first = slopes(seen_.patch, step.u, step.v, seen_.query),
                     last = slopes(seen_.patch, step.to_u, step.to_v, seen_.query);
        const Wide rounding = 64 * epsilon_ *
                              (std::abs(step.to_u - step.u) * std::max(first.scale_u, last.scale_u) +
                               std::abs(step.to_v - step.v) * std::max(first.scale_v, last.scale_v));
        if (!(steepest_climb(step) > rounding)) return {};
        const auto straight = [&](Wide t) {
            return half_square(step.u + t * (step.to_u - step.u), step.v + t * (step.to_v - step.v));
        };
        const auto floor_along_v = [&](Wide t) {
            const Wide v = step.v + t * (step.to_v - step.v);
            return half_square(best_u(v), v);
        };
        const auto floor_along_u = [&](Wide t) {
            const Wide u = step.u + t * (step.to_u - step.u);
            return half_square(u, best_v(u));
        };
        const Wide end = half_square(step.to_u, step.to_v);
        Rise least = highest_rise(straight, end, Wide(0));
        for (const Rise& other :
             {highest_rise(floor_along_v, end, rounding), highest_rise(floor_along_u, end, rounding)}) {
            if (other.height < least.height) least = other;
        }
        // A rise of a few roundings of Wide is the judge's own.
        return least.height > 64 * std::numeric_limits<Wide>::epsilon() ? least : Rise{};
    }

private:
    struct Step {
        Wide u, v, to_u, to_v;
    };

    [[nodiscard]] Wide half_square(Wide u, Wide v) const {
        return seen_.patch.half_square(u, v, seen_.query);
    }
    /// Where F is lowest along u at this v, along v at this u.
    [[nodiscard]] Wide best_u(Wide v) const {
        const WidePatch& p = seen_.patch;
        const Wide slope = p.along_u(v);
        return std::clamp((p.dx * seen_.query.x - (p.height(0, v) - seen_.query.z) * slope) /
                              (p.dx * p.dx + slope * slope),
                          Wide(0), Wide(1));
    }
    [[nodiscard]] Wide best_v(Wide u) const {
        const WidePatch& p = seen_.patch;
        const Wide slope = p.along_v(u);
        return std::clamp((p.dy * seen_.query.y - (p.height(u, 0) - seen_.query.z) * slope) /
                              (p.dy * p.dy + slope * slope),
                          Wide(0), Wide(1));
    }
    /// The largest slope of F on the straight way, 0 ≤ t ≤ 1. There σ = (x + a t, y + b t, z + c t + e t²), F = ½|σ|² is a
    /// quartic and F' = σ·σ' = d₀ + d₁ t + d₂ t² + d₃ t³.
    [[nodiscard]] Wide steepest_climb(const Step& s) const {
        const WidePatch& p = seen_.patch;
        const Wide du = s.to_u - s.u, dv = s.to_v - s.v;
        const Wide x = s.u * p.dx - seen_.query.x, y = s.v * p.dy - seen_.query.y,
                   z = p.height(s.u, s.v) - seen_.query.z;
        const Wide a = du * p.dx, b = dv * p.dy, c = du * p.along_u(s.v) + dv * p.along_v(s.u),
                   e = du * dv * (p.p11 - p.p10 - p.p01 + p.p00);
        const Wide d0 = x * a + y * b + z * c, d1 = a * a + b * b + c * c + 2 * z * e, d2 = 3 * c * e,
                   d3 = 2 * e * e;
        const auto slope = [&](Wide t) { return d0 + t * (d1 + t * (d2 + t * d3)); };
        // At an end, or where F'' = d₁ + 2 d₂ t + 3 d₃ t² = 0.
        Wide steepest = std::max(slope(0), slope(1));
        const Wide discriminant = d2 * d2 - 3 * d1 * d3;
        if (d3 > 0 && discriminant >= 0) {
            const Wide q = -(d2 + std::copysign(std::sqrt(discriminant), d2));
            for (const Wide t : {q / (3 * d3), q == 0 ? Wide(0) : d1 / q}) {
                if (t > 0 && t < 1) steepest = std::max(steepest, slope(t));
            }
        }
        return steepest;
    }
    /// On a way of which F is known, and from there to the step's end, by more than `rounding`.
    template <class Way>
    [[nodiscard]] Rise highest_rise(Way&& half_square_at, Wide end, Wide rounding) const {
        constexpr int parts = 256;
        Rise found;
        Wide lowest = half_square_at(Wide(0)), top = lowest;
        const auto look = [&](Wide here) {
            if (here > lowest + rounding) found.height = std::max(found.height, (here - lowest) / here);
            found.ridge = found.ridge || (found.height > 0 && here < top - rounding);
            top = std::max(top, here);
            if (here < lowest) lowest = top = here;
        };
        for (int k = 1; k <= parts; ++k) look(half_square_at(Wide(k) / parts));
        look(end);
        return found;
    }

    SeenPatch seen_;
    Wide epsilon_;
};

template <Real T>
[[nodiscard]] std::string describe(const BilinearPatch<T>& p, const CellPoint<T>& q, const vec2<T>& from,
                                   const vec2<T>& to) {
    return "patch " + digits(p.p00) + ' ' + digits(p.p10) + ' ' + digits(p.p01) + ' ' + digits(p.p11) +
           ", spacing " + digits(p.spacing.x) + ' ' + digits(p.spacing.y) + ", query " + digits(q.u) + ' ' +
           digits(q.v) + ' ' + digits(q.z) + ": " + digits(from.x) + ' ' + digits(from.y) + " -> " +
           digits(to.x) + ' ' + digits(to.y);
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_STEP_JUDGE_HPP
