#ifndef HFH_BENCH_ACCURACY_STILL_TO_GAIN_HPP
#define HFH_BENCH_ACCURACY_STILL_TO_GAIN_HPP

#include "oracle.hpp"

// Whether an answer is a minimum at all, or only on the way to one.

namespace accuracy {

/// How much nearer the query gets by going downhill from (u, v), in long double: first along u, then along the floor of
/// the valley that has u at its nearest, to its first minimum; or the same with u and v exchanged. In metres.
[[nodiscard]] inline Wide still_to_gain(const SeenPatch& patch, Wide u, Wide v) {
    const auto along_floor = [](const SeenPatch& p, Wide from) {
        const Wide down = p.fall_along_v(from) < 0 ? Wide(1) : Wide(-1);
        // Steps that double, until the floor rises or the patch ends; then bisection.
        Wide near = from, far = from;
        for (Wide step = 0x1p-50L; down * p.fall_along_v(far) < 0 && far >= 0 && far <= 1; step *= 2) {
            near = far;
            far = std::clamp(far + down * step, Wide(0), Wide(1));
            if (far == near) break;
        }
        for (int k = 0; k < 64; ++k) {
            const Wide middle = (near + far) / 2;
            (down * p.fall_along_v(middle) < 0 ? near : far) = middle;
        }
        return length(p.at(p.nearest_u(near), near));
    };
    return length(patch.at(u, v)) - std::min(along_floor(patch, v), along_floor(patch.mirrored(), u));
}

} // namespace accuracy

#endif // HFH_BENCH_ACCURACY_STILL_TO_GAIN_HPP
