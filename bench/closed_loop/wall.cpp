#include "hand.hpp"
#include "report.hpp"

#include <hfh/simulation/driven_axis.hpp>

#include <cmath>

// The critical stiffness of a wall: a mass leans on flat ground with a constant force, and is nudged. What it swings
// by grows above the critical stiffness and fades below.

namespace closed_loop {
namespace {

struct Still {
    [[nodiscard]] glm::dvec3 operator()(double) const { return glm::dvec3{0.0}; }
};

struct Wall {
    double mass = hfh::simulated_touch.mass; ///< kg
    double viscous = 0;                      ///< N·s/m
    int delay = 0;                           ///< updates
    double lag = 0;                          ///< s
};

/// By what factor the swing of the last second exceeds that of the first.
template <Real T, class Axis>
[[nodiscard]] double growth(const Axis& axis, int delay, double stiffness, double seconds, Lag& lag) {
    constexpr double weight = 0.5, nudge = 1e-3; // N, m/s: the swing never leaves the ground
    const auto ground = hfh::test::plane<T>(16, 16, 0, {.origin = {-8, -8}});
    Touching<T> touching{ground, stiffness};
    hfh::SimulatedDevice device{hfh::DeviceCapabilities{.rate = 1 / period, .delay = delay},
                                hfh::SameAxes<Axis>{axis}, hfh::AxisEncoders{}, Still{}, seconds};
    const double rest = -weight / stiffness;
    (void)touching.update({0, 0, 1}); // comes from outside
    device.place({0, 0, rest}, {0, 0, nudge});
    const auto updates = std::lround(seconds / period), window = std::lround(1 / period);
    double first = 0, last = 0;
    auto sample = device.sample();
    for (long k = 0; k < updates; ++k) {
        const double swing = std::abs(sample.position.z - rest);
        if (k < window) first = std::max(first, swing);
        if (k >= updates - window) last = std::max(last, swing);
        sample = device.step(touching.update(sample.position) + glm::dvec3{0, 0, -weight});
    }
    lag.add(touching);
    return last / first;
}

template <Real T>
[[nodiscard]] double growth(const Wall& wall, double stiffness, double seconds, Lag& lag) {
    if (!(wall.lag > 0))
        return growth<T>(hfh::StickSlipMass{.mass = wall.mass, .viscous = wall.viscous}, wall.delay,
                         stiffness, seconds, lag);
    return growth<T>(hfh::DrivenAxis{.mass = wall.mass, .viscous = wall.viscous, .lag = wall.lag}, wall.delay,
                     stiffness, seconds, lag);
}

/// N/m, by halving, to 10⁻⁴ of `about`.
template <Real T>
[[nodiscard]] double critical_stiffness(const Wall& wall, double about, double seconds, Lag& lag) {
    double stable = 0.5 * about, unstable = 2 * about;
    while (unstable - stable > 1e-4 * about) {
        const double middle = 0.5 * (stable + unstable);
        (growth<T>(wall, middle, seconds, lag) > 1 ? unstable : stable) = middle;
    }
    return stable;
}

} // namespace

template <Real T>
void wall(const Effort& effort, Findings& findings) {
    const double seconds = effort.share < 1 ? 5 : 20;
    for (const double viscous : {0.05, 0.2, 0.5}) {
        const double limit = 2 * viscous / period;
        const double plain = critical_stiffness<T>({.viscous = viscous}, limit, seconds, findings.lag);
        const double delayed =
            critical_stiffness<T>({.viscous = viscous, .delay = 1}, limit / 3, seconds, findings.lag);
        findings.rows.push_back({text("critical stiffness of a wall, b = %g N·s/m", viscous),
                                 text("2b/T = %.0f N/m, ± 5 %%", limit), text("%.1f N/m", plain),
                                 verdict(std::abs(plain / limit - 1) <= 0.05)});
        findings.rows.push_back({"… with one update of delay", "⅓ of that, ± 5 %",
                                 text("%.1f N/m, %.3f", delayed, delayed / plain),
                                 verdict(std::abs(3 * delayed / plain - 1) <= 0.05)});
        constexpr double lag = 0.5e-3;
        const double by_lag = viscous / (period / 2 + lag);
        const double lagging =
            critical_stiffness<T>({.viscous = viscous, .lag = lag}, by_lag, seconds, findings.lag);
        findings.rows.push_back({"… with an amplifier lag of 0.5 ms",
                                 text("b/(T/2 + τ) = %.0f N/m, ± 5 %%", by_lag), text("%.1f N/m", lagging),
                                 verdict(std::abs(lagging / by_lag - 1) <= 0.05)});
    }
}

template void wall<float>(const Effort&, Findings&);
template void wall<double>(const Effort&, Findings&);

} // namespace closed_loop
