#include "hand.hpp"
#include "report.hpp"

#include <hfh/device/limit_cycle_filter.hpp>
#include <hfh/force/virtual_coupling.hpp>
#include <hfh/simulation/driven_axis.hpp>

// From a light grip to a firm one, with a delay, an amplifier that lags and a linkage that gives: how stiff may a wall be?

namespace closed_loop {
namespace {

struct Still {
    [[nodiscard]] glm::dvec3 operator()(double) const { return glm::dvec3{0.0}; }
};

constexpr hfh::HandGrip grips[]{{100, 0.5}, {300, 4}, {500, 6}, {1000, 10}};

/// A Touch without dry friction and encoder steps, in a hand.
struct Setting {
    hfh::HandGrip grip;
    int delay = 0;      ///< updates
    double lag = 0;     ///< s
    bool gives = false; ///< half of its mass at the tip, on a spring of 3500 N/m
    bool coupled = false;

    [[nodiscard]] hfh::DrivenAxis axis() const {
        const auto& touch = hfh::simulated_touch;
        hfh::DrivenAxis axis{.mass = touch.mass,
                             .viscous = touch.viscous,
                             .spring = grip.stiffness,
                             .damper = grip.damping,
                             .lag = lag};
        if (gives) {
            axis.mass = axis.tip_mass = touch.mass / 2;
            axis.structure = 3500;
            axis.structure_damper = 0.3;
        }
        return axis;
    }
    [[nodiscard]] hfh::VirtualCouplingOptions coupling(double stiffness) const {
        return {.stiffness = coupled ? stiffness : 0, .lag = 0.5 + delay + lag / period};
    }
};

/// By what factor the swing of the last quarter exceeds that of the first: leant on by 0.5 N and nudged, so little that it
/// never leaves the wall.
[[nodiscard]] double growth(const Setting& setting, double stiffness, double seconds) {
    constexpr double weight = 0.5;
    // At rest the hand pulls as well: it wants the end effector at 0.
    const double rest = -weight / (stiffness + setting.grip.stiffness);
    hfh::SimulatedDevice device{hfh::DeviceCapabilities{.rate = 1 / period, .delay = setting.delay},
                                hfh::SameAxes<hfh::DrivenAxis>{setting.axis()}, hfh::AxisEncoders{}, Still{},
                                seconds};
    hfh::VirtualCoupling coupling{setting.coupling(stiffness)};
    device.place({0, 0, rest}, {0, 0, 1e-4});
    const auto updates = std::lround(seconds / period);
    double first = 0, last = 0;
    for (long k = 0; k < updates; ++k) {
        const double z = device.sample().position.z, swing = std::abs(z - rest);
        if (4 * k < updates) first = std::max(first, swing);
        if (4 * k >= 3 * updates) last = std::max(last, swing);
        if (swing > 1) return 1e300;
        device.step(coupling({0, 0, z}, {0, 0, -stiffness * z}).newtons - glm::dvec3{0, 0, weight});
    }
    return last / first;
}

/// N/m, by halving, to 10⁻³ of it; without an end up to 10⁶.
[[nodiscard]] double stable_stiffness(const Setting& setting, double seconds) {
    double stable = 1, unstable = 1e6;
    while (unstable / stable > 1.001) {
        const double middle = std::sqrt(stable * unstable);
        (growth(setting, middle, seconds) > 1 ? unstable : stable) = middle;
    }
    return stable;
}

/// Without delay, lag and linkage the loop is a matrix of 2 × 2 (the mass solved over one update, the force held), and
/// stable while its determinant is below 1 and 1 + trace + determinant above 0 (Jury): linear in K, so the critical K is
/// known.
[[nodiscard]] double exact_stiffness(const hfh::HandGrip& grip) {
    const double m = hfh::simulated_touch.mass, b = hfh::simulated_touch.viscous + grip.damping;
    const double decay = b / (2 * m), squared = grip.stiffness / m - decay * decay;
    const double w = std::sqrt(std::abs(squared)), e = std::exp(-decay * period);
    const double c = squared > 0 ? std::cos(w * period) : std::cosh(w * period);
    const double s = (squared > 0 ? std::sin(w * period) : std::sinh(w * period)) / w;
    const double f11 = e * (c + decay * s), f12 = e * s, f22 = e * (c - decay * s);
    const double f21 = -e * s * grip.stiffness / m;
    const double g1 = (1 - f11) / grip.stiffness, g2 = -f21 / grip.stiffness; // by a constant force
    const double determinant = f11 * f22 - f12 * f21, slope = g1 * f22 - f12 * g2;
    const double by_determinant = (determinant - 1) / slope;
    const double by_trace = (1 + f11 + f22 + determinant) / (g1 + slope);
    return std::min(by_determinant > 0 ? by_determinant : 1e300, by_trace > 0 ? by_trace : 1e300);
}

/// Presses of a wall by a still hand, on a device of `model`; what still moves in the last half second of two.
struct Tremor {
    int all = 0, moving = 0;
    double largest = 0; ///< m, peak to peak
    [[nodiscard]] std::string words() const {
        if (moving == 0) return text("0 of %d", all);
        return largest < 1e-4 ? text("%d of %d, %.1f µm", moving, all, 1e6 * largest)
                              : text("%d of %d, %.1f mm", moving, all, 1e3 * largest);
    }
};
struct Links {
    bool steadies = false, coupled = false, joints = false;
};
/// From 2 mm above, with 0.5 to 3 N of the grip's bending, within 0.3 s.
struct Press {
    double depth;
    [[nodiscard]] glm::dvec3 operator()(double t) const {
        return {0.01, 0.005, 2e-3 - (2e-3 + depth) * std::min(1.0, t / 0.3)};
    }
};
template <class Axis, class Encoders>
[[nodiscard]] Tremor tremor(const hfh::DeviceModel& model, const Axis& axis, double lag, double stiffness,
                            const Encoders& encoders, const Links& links, int count) {
    Tremor out;
    const auto& able = model.capabilities;
    for (int n = 0; n < count; ++n) {
        const Press press{(0.5 + 2.5 * (n + 0.5) / count) / axis.spring};
        hfh::SimulatedDevice device{able, hfh::SameAxes<Axis>{axis}, encoders, press, 2};
        hfh::LimitCycleFilter steady{links.steadies ? able.resolution : 0};
        hfh::VirtualCoupling coupling{
            {.stiffness = links.coupled ? stiffness : 0, .lag = 0.5 + able.delay + lag / period}};
        double low = 1e300, high = -1e300;
        for (int k = 0; k < 2000; ++k) {
            const glm::dvec3 at = steady(device.sample().position);
            device.step(coupling(at, {0, 0, at.z < 0 ? -stiffness * at.z : 0}).newtons);
            if (k < 1500) continue;
            low = std::min(low, device.position().z);
            high = std::max(high, device.position().z);
        }
        ++out.all;
        out.moving += high > low;
        out.largest = std::max(out.largest, high - low);
    }
    return out;
}

[[nodiscard]] hfh::DrivenAxis lagging(const hfh::DeviceModel& model, const hfh::HandGrip& grip, double lag) {
    return {.mass = model.mass,
            .viscous = model.viscous,
            .dry = model.dry,
            .spring = grip.stiffness,
            .damper = grip.damping,
            .lag = lag};
}

void matrix(const Effort& effort, Findings& findings) {
    Findings::Table table{
        "Stable stiffness of a wall, N/m: the Touch without its dry friction and encoder steps, by "
        "simulation. Then the "
        "Touch as it is, at 500 N/m: of how many presses it does not come to rest, and by how much it swings",
        {"grip, N/m and N·s/m", "delay", "lag, ms", "stable", "(b + d)/(T/2 + delay·T + τ)", "exactly",
         "with `VirtualCoupling`", "with a linkage of 3500 N/m", "and `VirtualCoupling`", "Touch, 500 N/m",
         "and `VirtualCoupling`"},
        {}};
    const double seconds = effort.share < 1 ? 1 : 4;
    const int count = effort.counted(40, 4);
    double worst = 0;
    for (const auto& grip : grips) {
        for (const int delay : {0, 1}) {
            for (const double lag : {0.0, 0.5e-3}) {
                if (effort.share < 1 && (delay > 0) != (lag > 0)) continue; // a test looks at the corners
                Setting setting{grip, delay, lag};
                const double plain = stable_stiffness(setting, seconds);
                const double formula =
                    (hfh::simulated_touch.viscous + grip.damping) / (period / 2 + delay * period + lag);
                setting.coupled = true;
                const double coupled = stable_stiffness(setting, seconds);
                setting.gives = true;
                const double both = stable_stiffness(setting, seconds);
                setting.coupled = false;
                const double gives = stable_stiffness(setting, seconds);
                const bool is_exact = delay == 0 && lag == 0;
                const double exact = is_exact ? exact_stiffness(grip) : 0;
                if (is_exact) worst = std::max(worst, std::abs(plain / exact - 1));
                hfh::DeviceModel touch = hfh::simulated_touch;
                touch.capabilities.delay = delay;
                const hfh::AxisEncoders encoders{touch.capabilities.resolution};
                const auto still = tremor(touch, lagging(touch, grip, lag), lag, 500, encoders, {}, count);
                const auto damped =
                    tremor(touch, lagging(touch, grip, lag), lag, 500, encoders, {.coupled = true}, count);
                table.rows.push_back({text("%.0f, %.1f", grip.stiffness, grip.damping), text("%d", delay),
                                      text("%.1f", 1e3 * lag), text("%.0f", plain), text("%.0f", formula),
                                      is_exact ? text("%.0f", exact) : "", text("%.0f", coupled),
                                      text("%.0f", gives), text("%.0f", both), still.words(),
                                      damped.words()});
            }
        }
    }
    findings.tables.push_back(table);
    findings.rows.push_back({"stable stiffness in four grips, without delay and lag: off the exact one by",
                             "≤ 5 %", text("%.2f %%", 100 * worst), verdict(worst <= 0.05)});
}

void steadied(const Effort& effort, Findings& findings) {
    Findings::Table table{
        "What `LimitCycleFilter` cures: presses of flat ground on the Premium 1.5 that do not come to "
        "rest, and by how much they swing. 3500 and 2667 N/m are more than its loop bears in a light "
        "grip",
        {"grip, N/m and N·s/m", "N/m", "encoders", "as told", "`LimitCycleFilter`", "`VirtualCoupling`",
         "both"},
        {}};
    const auto& premium = hfh::simulated_premium;
    const double step = premium.capabilities.resolution;
    // As a Phantom's arm: behind the workspace, with steps of the resolution at its full reach.
    const hfh::JointEncoders arm{.upper = 0.2, .lower = 0.2, .shoulder = {0, 0.25, 0.05}, .step = step / 0.4};
    const int count = effort.counted(60, 4);
    for (const auto& grip : {grips[1], grips[0]}) {
        for (const double stiffness : {3500.0, 2 * premium.dry / step, premium.capabilities.max_stiffness}) {
            for (const bool joints : {false, true}) {
                const hfh::StickSlipMass axis{premium.mass, premium.viscous, premium.dry, grip.stiffness,
                                              grip.damping};
                const auto found = [&](const Links& links) {
                    return (joints
                                ? tremor(premium, axis, 0, stiffness, arm, links, count)
                                : tremor(premium, axis, 0, stiffness, hfh::AxisEncoders{step}, links, count))
                        .words();
                };
                table.rows.push_back({text("%.0f, %.1f", grip.stiffness, grip.damping),
                                      text("%.0f", stiffness), joints ? "in the joints" : "along x, y, z",
                                      found({}), found({.steadies = true}), found({.coupled = true}),
                                      found({.steadies = true, .coupled = true})});
            }
        }
    }
    findings.tables.push_back(table);
}

} // namespace

void grips_and_lags(const Effort& effort, Findings& findings) {
    matrix(effort, findings);
    steadied(effort, findings);
}

} // namespace closed_loop
