#include "controllers.hpp"
#include "hand.hpp"
#include "presses.hpp"
#include "report.hpp"

#include <hfh/force/energy_tank.hpp>
#include <hfh/force/virtual_coupling.hpp>

// The passivity controllers side by side: how deep does a hand come, what does it get, and how does the force step?

namespace closed_loop {
namespace {

constexpr double speeds[]{0.02, 0.1, 0.5}; // m/s
constexpr double aim = 0.01;               // m below the surface
constexpr int times = 5;

/// One controller at all speeds.
struct Run {
    std::string name;
    hfh::test::Pressed at[std::size(speeds)];
    long contacts = 0,
         empty = 0; ///< after two fast retreats: updates in contact, and of these without a force
};

/// Out of a depth of 19 mm at 1.5 m/s twice, then 16 s of gentle presses, on a hand that nothing moves.
template <class Control>
void retreat(Run& run, double stiffness, Control control) {
    for (int k = 0; k < 20000; ++k) {
        const double t = k * period, u = std::fmod(t, 2.0);
        double z = u < 0.5 ? 1e-3 - 0.04 * u : u < 0.515 ? -0.019 + 1.5 * (u - 0.5) : 3.5e-3;
        if (t > 4) z = 1e-3 - 4e-3 * std::sin(6.283185307179586 * t);
        const auto newtons = control({0, 0, z}, glm::dvec3{0, 0, z < 0 ? -stiffness * z : 0});
        if (!(t > 4 && z < 0)) continue;
        ++run.contacts;
        run.empty += newtons == glm::dvec3{0.0};
    }
}

/// `fresh()` gives the controller as at the start.
template <class Fresh>
[[nodiscard]] Run run(const hfh::DeviceModel& model, const char* name, Fresh fresh) {
    Run out{name, {}};
    const double stiffness = model.capabilities.max_stiffness;
    for (std::size_t k = 0; k < std::size(speeds); ++k) {
        auto control = fresh();
        out.at[k] = hfh::test::press_wall(
            model, {}, {.depth = aim, .speed = speeds[k]}, times, stiffness,
            [&](const glm::dvec3& at, const glm::dvec3& newtons) { return control(at, newtons); });
    }
    retreat(out, stiffness, fresh());
    return out;
}

[[nodiscard]] std::vector<Run> runs(const hfh::DeviceModel& model) {
    const double stiffness = model.capabilities.max_stiffness, viscous = model.viscous;
    const auto tank = [](const hfh::EnergyTankOptions& options) {
        return [options] {
            return
                [tank = hfh::EnergyTank{options}](const glm::dvec3& at, const glm::dvec3& newtons) mutable {
                    return tank(at, newtons).newtons;
                };
        };
    };
    // As fast as the motors and a hand of the same strength turn the device, and two steps of the encoders.
    const double turn = period * period * 2 * model.capabilities.max_force / model.mass +
                        2 * std::sqrt(3.0) * model.capabilities.resolution;
    std::vector<Run> all;
    all.push_back(run(model, "none",
                      [] { return [](const glm::dvec3&, const glm::dvec3& newtons) { return newtons; }; }));
    all.push_back(run(model, "`VirtualCoupling`", [&] {
        return [coupling = hfh::VirtualCoupling{{.stiffness = stiffness}}](
                   const glm::dvec3& at, const glm::dvec3& newtons) mutable {
            return coupling(at, newtons).newtons;
        };
    }));
    all.push_back(run(model, "time-domain passivity control, α ≤ 20 N·s/m", [] {
        return TimeDomainPassivity{20, period};
    }));
    all.push_back(run(model, "the same, α ≤ 1 N·s/m", [] { return TimeDomainPassivity{1, period}; }));
    all.push_back(run(model, "energy bounding, 2b/T of the device", [&] {
        return EnergyBounding{viscous, period};
    }));
    all.push_back(run(model, "virtual coupling by a spring alone, 2b/T", [&] {
        return SoftCoupling{viscous, period, stiffness};
    }));
    all.push_back(run(model, "`EnergyTank`, its defaults", tank({})));
    all.push_back(run(model, "`EnergyTank`, `largest_turn` of the device", tank({.largest_turn = turn})));
    all.push_back(run(model, "`EnergyTank`, allowance 0.1 mJ", tank({.allowance = 1e-4})));
    return all;
}

void compare(const hfh::DeviceModel& model, const char* name, Findings& findings) {
    const auto all = runs(model);
    const Run &plain = all[0], &coupled = all[1];
    Findings::Table table{
        text("Passivity controllers on the %s, %.0f N/m, a hand of 300 N/m that aims 10 mm "
             "deep %d times: depth over the spring's alone; the hand's real balance at any time, "
             "at least; largest step of the force, and beyond K·|Δx|",
             name, model.capabilities.max_stiffness, times),
        {"", "at 0.02 m/s", "at 0.1 m/s", "at 0.5 m/s", "no force after fast retreats"},
        {}};
    for (const Run& run : all) {
        std::vector<std::string> cells{run.name};
        for (std::size_t k = 0; k < std::size(speeds); ++k) {
            const auto& at = run.at[k];
            cells.push_back(text("%.2f; %.1g J; %.2f, %.2f N", at.depth / plain.at[k].depth, at.lowest,
                                 at.rise, std::max(0.0, at.beyond)));
        }
        cells.push_back(text("%ld of %ld", run.empty, run.contacts));
        table.rows.push_back(cells);
    }
    findings.tables.push_back(table);

    double shallowest = 1e300, deepest = 0, lowest = 0, step = 0, beyond = 0;
    for (std::size_t k = 0; k < std::size(speeds); ++k) {
        const double depth = coupled.at[k].depth / plain.at[k].depth;
        shallowest = std::min(shallowest, depth);
        deepest = std::max(deepest, depth);
        lowest = std::min(lowest, coupled.at[k].lowest);
        if (speeds[k] <= 0.1) step = std::max(step, coupled.at[k].rise);
        beyond = std::max(beyond, coupled.at[k].beyond);
    }
    const std::string with = text("with `VirtualCoupling` on the %s, a hand aims 10 mm deep", name);
    findings.rows.push_back({with + ": depth over the spring's alone", "1 ± 10 %",
                             text("%.3f to %.3f", shallowest, deepest),
                             verdict(0.9 <= shallowest && deepest <= 1.1)});
    findings.rows.push_back({"… the hand's real balance at any time", "≥ −10⁻⁴ J", text("%.2g J", lowest),
                             verdict(lowest >= -1e-4)});
    findings.rows.push_back(
        {"… steps of the force, up to 0.1 m/s", "≤ 0.1 N",
         text("%.3f N (without: %.3f)", step, std::max(plain.at[0].rise, plain.at[1].rise)),
         step <= 0.1              ? Verdict::met
         : plain.at[1].rise > 0.1 ? Verdict::known // the spring alone steps farther
                                  : Verdict::not_met});
    findings.rows.push_back({"… at 0.5 m/s beyond the spring's own step, K·|Δx|", "≤ ¾·K·v·T",
                             text("%.3f N; the spring's own: %.3f", beyond, plain.at[2].rise),
                             verdict(beyond <= 0.75 * model.capabilities.max_stiffness * 0.5 * period)});
}

} // namespace

void passivity(Findings& findings) {
    compare(hfh::simulated_touch, "Touch", findings);
    compare(hfh::simulated_premium, "Premium 1.5", findings);
}

} // namespace closed_loop
