#include "hand.hpp"
#include "report.hpp"

#include <hfh/energy_tank.hpp>

// The energy that the rendered force gives to the hand, over presses and strokes that start and end in the air.

namespace closed_loop {
namespace {

constexpr double cell = 1e-3;     // m
constexpr double stiffness = 500; // N/m

/// The worst of many.
struct Worst {
    double value = -1e300;
    std::string where;
    void add(double candidate, const std::string& name) {
        if (candidate > value) value = candidate, where = name;
    }
};

/// What one path gave: without and with the passivity controller.
struct Given {
    double share = 0;      ///< of K·T·v·D
    double of_squares = 0; ///< of ½K·Σ|Δx|²
    double lowest = 0;     ///< J, with the controller: the least that the hand was ahead by at any time
};

/// A hand that nothing moves from its path, at `speed` and down to `depth`.
template <Real T>
[[nodiscard]] Given follow(Touching<T>& touching, const Path& path, double speed, double depth) {
    touching.reset();
    Energy energy, controlled;
    hfh::EnergyTank tank;
    for (const glm::dvec3& point : path) {
        const glm::dvec3 at{hfh::vec3<T>{point}}; // what the tracker is told is what counts
        const glm::dvec3 newtons = touching.update(at);
        energy.add(at, newtons);
        controlled.add(at, tank(at, newtons).newtons);
    }
    return {energy.given() / (stiffness * period * speed * depth),
            energy.squared_steps() > 0 ? energy.given() / (0.5 * stiffness * energy.squared_steps()) : 0,
            -controlled.most()};
}

/// As fast as the motors and a hand of the same strength can turn it, and two steps of the encoders.
[[nodiscard]] hfh::EnergyTankOptions options_for(const hfh::DeviceModel& model) {
    const double acceleration = 2 * model.capabilities.max_force / model.mass;
    return {.largest_turn =
                period * period * acceleration + 2 * std::sqrt(3.0) * model.capabilities.resolution};
}

/// The hand of a simulated device at its nominal stiffness, with the controller: the least that the hand was ahead by,
/// by the positions that the device tells and by those where it is.
struct Held {
    double told = 0, real = 0;       ///< J
    double of_squares = 0;           ///< without the controller: of ½K·Σ|Δx|²
    long updates = 0, shortened = 0; ///< with a force wanted; of these, with less given
    unsigned long long exceeded = 0; ///< motions beyond the controller's options
};
template <Real T>
[[nodiscard]] Held follow_in_hand(Touching<T>& touching, const hfh::DeviceModel& model, const Path& path,
                                  double allowance) {
    Held held;
    for (const bool controls : {false, true}) {
        touching.reset();
        Energy told, real;
        auto options = options_for(model);
        options.allowance = allowance;
        hfh::EnergyTank tank{options};
        hfh::SimulatedDevice device{model, {}, Along{&path}, 60};
        for (std::size_t k = 0; k < path.size(); ++k) {
            const auto sample = device.sample();
            const glm::dvec3 at{hfh::vec3<T>{sample.position}};
            glm::dvec3 newtons = touching.update(at);
            if (controls) {
                const auto shortened = tank(at, newtons);
                newtons = shortened.newtons;
                held.updates += touching.touching();
                held.shortened += shortened.shortened;
            }
            const glm::dvec3 is = device.position();
            device.step(newtons);
            told.add(at, device.held());
            real.add(is, device.held());
        }
        if (controls) {
            held.told = -told.most();
            held.real = -real.most();
            held.exceeded = tank.exceeded();
        } else if (told.squared_steps() > 0) {
            held.of_squares = told.given() / (0.5 * model.capabilities.max_stiffness * told.squared_steps());
        }
    }
    return held;
}

} // namespace

template <Real T>
void energy(const Effort& effort, Findings& findings) {
    Worst press, stroke, squares, rigid, touch, premium, touch_real, premium_real;
    Findings::Detail presses{"press: energy / K·T·v·D", {}}, strokes{"stroke: energy / K·T·v·D", {}},
        mean_stroke{"… mean", {}};
    long updates = 0, shortened = 0, generously_shortened = 0;
    double generous_lowest = 0;
    unsigned long long exceeded = 0;
    for (const auto& ground : grounds<T>(cell)) {
        Site<T> site{ground.terrain, 11};
        Touching<T> touching{ground.terrain, stiffness};
        Worst press_here, stroke_here;
        double sum = 0;
        int count = 0;
        for (const double depth : {0.5e-3, 2e-3}) {
            for (const double speed : {0.02, 0.1, 0.5}) {
                const double step = speed * period;
                for (int n = effort.counted(100); n > 0; --n) {
                    const auto given = follow(touching, site.press(depth, step), speed, depth);
                    press_here.add(given.share, ground.name);
                    squares.add(given.of_squares, ground.name);
                    rigid.add(-given.lowest, ground.name);
                }
                for (int n = effort.counted(40); n > 0; --n) {
                    const auto path = site.stroke(40 * cell, depth, step);
                    if (!path) continue;
                    const auto given = follow(touching, *path, speed, depth);
                    stroke_here.add(given.share, ground.name);
                    squares.add(given.of_squares, ground.name);
                    rigid.add(-given.lowest, ground.name);
                    sum += given.share;
                    ++count;
                }
            }
        }
        press.add(press_here.value, ground.name);
        stroke.add(stroke_here.value, ground.name);
        presses.by_ground.push_back(text("%.3f", press_here.value));
        strokes.by_ground.push_back(count > 0 ? text("%.3f", stroke_here.value) : "–");
        mean_stroke.by_ground.push_back(count > 0 ? text("%.2f", sum / count) : "–");
        findings.lag.add(touching);

        for (const bool is_touch : {true, false}) {
            const auto& model = is_touch ? hfh::simulated_touch : hfh::simulated_premium;
            Touching<T> in_hand{ground.terrain, model.capabilities.max_stiffness};
            for (int n = effort.counted(40); n > 0; --n) {
                const auto path = n % 2 == 0 ? std::optional{site.press(6e-3, 0.1e-3)}
                                             : site.stroke(40 * cell, 6e-3, 0.1e-3);
                if (!path) continue;
                const auto held = follow_in_hand(in_hand, model, *path, hfh::EnergyTankOptions{}.allowance);
                const auto generous = follow_in_hand(in_hand, model, *path, 1e-4);
                generously_shortened += generous.shortened;
                generous_lowest = std::min(generous_lowest, generous.told);
                (is_touch ? touch : premium).add(-held.told, ground.name);
                (is_touch ? touch_real : premium_real).add(-held.real, ground.name);
                squares.add(held.of_squares, ground.name);
                updates += held.updates;
                shortened += held.shortened;
                exceeded += held.exceeded;
            }
            findings.lag.add(in_hand);
        }
    }
    const auto share = [&](const char* what, const Worst& worst) {
        findings.rows.push_back({what, "≤ K·T·v·D + 1 %",
                                 text("%.4f of it (%s)", worst.value, worst.where.c_str()),
                                 verdict(worst.value <= 1.01)});
    };
    share("energy generated by a press, at most", press);
    share("energy generated by a stroke, at most", stroke);
    findings.rows.push_back({"… by either, also in the hand with the encoder's steps", "≤ ½K·ΣΔx² + 1 %",
                             text("%.4f of it (%s)", squares.value, squares.where.c_str()),
                             verdict(squares.value <= 1.01)});
    const auto lowest = [&](const char* what, const Worst& worst, bool has_goal) {
        findings.rows.push_back({what, has_goal ? "≥ −1·10⁻⁹ J" : "", text("%.2g J", -worst.value),
                                 has_goal ? verdict(-worst.value >= -1e-9) : Verdict::none});
    };
    lowest("with the passivity controller, the hand's balance at any time, at least: rigid hand", rigid,
           true);
    lowest("… hand on the Touch, 500 N/m", touch, true);
    lowest("… hand on the Premium 1.5, 3500 N/m", premium, true);
    lowest("… Touch, between the encoder's steps, which no controller sees", touch_real, false);
    lowest("… Premium 1.5, the same", premium_real, false);
    const auto percent = [&](long part) {
        return text("%.1f %%",
                    100.0 * static_cast<double>(part) / static_cast<double>(std::max(1L, updates)));
    };
    findings.rows.push_back({"… in hand, motions beyond what the controller counts with", "0",
                             text("%llu", exceeded), verdict(exceeded == 0)});
    findings.rows.push_back(
        {"… in hand, updates in contact with a shortened force", "", percent(shortened), Verdict::none});
    findings.rows.push_back({"… the same with an allowance of 0.1 mJ; and the balance", "",
                             text("%s; %.2g J", percent(generously_shortened).c_str(), generous_lowest),
                             Verdict::none});
    findings.details.push_back(presses);
    findings.details.push_back(strokes);
    findings.details.push_back(mean_stroke);
}

template void energy<float>(const Effort&, Findings&);
template void energy<double>(const Effort&, Findings&);

} // namespace closed_loop
