#include "hand.hpp"
#include "report.hpp"

#include <hfh/force/energy_tank.hpp>
#include <hfh/force/passivity_observer.hpp>
#include <hfh/force/virtual_coupling.hpp>

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

/// What one path gave: without and with the energy tank.
struct Given {
    double share = 0;      ///< of K·T·v·D
    double of_squares = 0; ///< of ½K·Σ|Δx|²
    double lowest = 0;     ///< J, with the tank: the least that the hand was ahead by at any time
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

/// What stands between the spring and the hand of a simulated device.
enum class Link { none, coupling, tank };

/// The hand of a simulated device at its nominal stiffness: the least that it was ahead by, by the positions that the
/// device tells and by those where it is, and what else came of it.
struct Held {
    double told = 0, real = 0;       ///< J
    double observed_off = 0;         ///< J, by which `PassivityObserver` is off the real balance at the end
    double of_squares = 0;           ///< of ½K·Σ|Δx|²
    double deepest = 0;              ///< m
    double beyond = 0;               ///< N, by how much a force steps farther than the spring's does
    double own = 0;                  ///< N, the largest step of the spring's
    long updates = 0, shortened = 0; ///< with a force wanted; of these, with less given
    unsigned long long exceeded = 0; ///< motions beyond the tank's options
};
template <Real T>
[[nodiscard]] Held follow_in_hand(Touching<T>& touching, const hfh::DeviceModel& model, const Path& path,
                                  Link link) {
    touching.reset();
    const double hardness = model.capabilities.max_stiffness;
    Held held;
    Energy told, real;
    hfh::EnergyTank tank{options_for(model)};
    hfh::VirtualCoupling coupling{{.stiffness = hardness}};
    hfh::PassivityObserver observer{model.capabilities.resolution};
    hfh::SimulatedDevice device{model, {}, Along{&path}, 60};
    glm::dvec3 last_asked{0.0}, last{0.0};
    for (std::size_t k = 0; k < path.size(); ++k) {
        const auto sample = device.sample();
        const glm::dvec3 at{hfh::vec3<T>{sample.position}};
        const glm::dvec3 asked = touching.update(at);
        glm::dvec3 newtons = asked;
        if (link == Link::coupling) {
            newtons = coupling(at, asked).newtons;
        } else if (link == Link::tank) {
            const auto shortened = tank(at, asked);
            newtons = shortened.newtons;
            held.updates += touching.touching();
            held.shortened += shortened.shortened;
        }
        held.deepest = std::max(held.deepest, glm::length(asked) / hardness);
        held.beyond = std::max(held.beyond, glm::length(newtons - last) - glm::length(asked - last_asked));
        held.own = std::max(held.own, glm::length(asked - last_asked));
        last_asked = asked;
        last = newtons;
        const glm::dvec3 is = device.position();
        device.step(newtons);
        observer.update(sample.position, device.held());
        told.add(at, device.held());
        real.add(is, device.held());
    }
    held.told = -told.most();
    held.real = -real.most();
    held.observed_off = std::abs(observer.balance() + real.given());
    held.exceeded = tank.exceeded();
    if (told.squared_steps() > 0) held.of_squares = told.given() / (0.5 * hardness * told.squared_steps());
    return held;
}

/// A rigid hand's motions on all grounds.
struct Rigid {
    Worst press, stroke, squares, lowest;
    Findings::Detail presses{"press: energy / K·T·v·D", {}}, strokes{"stroke: energy / K·T·v·D", {}},
        mean_stroke{"… mean", {}};

    /// Motions of a kind on one ground.
    struct Here {
        Worst worst;
        double sum = 0;
        int count = 0;
    };

    template <Real T>
    void run(const Ground<T>& ground, Site<T>& site, Touching<T>& touching, const Effort& effort) {
        Here press_here, stroke_here;
        for (const double depth : {0.5e-3, 2e-3}) {
            for (const double speed : {0.02, 0.1, 0.5}) {
                const double step = speed * period;
                const auto add = [&](const Path& path, Here& here) {
                    const auto given = follow(touching, path, speed, depth);
                    here.worst.add(given.share, ground.name);
                    here.sum += given.share;
                    ++here.count;
                    squares.add(given.of_squares, ground.name);
                    lowest.add(-given.lowest, ground.name);
                };
                for (int n = effort.counted(100); n > 0; --n) add(site.press(depth, step), press_here);
                for (int n = effort.counted(40); n > 0; --n)
                    if (const auto path = site.stroke(40 * cell, depth, step)) add(*path, stroke_here);
            }
        }
        press.add(press_here.worst.value, ground.name);
        stroke.add(stroke_here.worst.value, ground.name);
        const auto& [worst, sum, count] = stroke_here;
        presses.by_ground.push_back(text("%.3f", press_here.worst.value));
        strokes.by_ground.push_back(count > 0 ? text("%.3f", worst.value) : "–");
        mean_stroke.by_ground.push_back(count > 0 ? text("%.2f", sum / count) : "–");
    }
};

/// One device in the hand on all grounds.
struct InHand {
    const hfh::DeviceModel& model;
    Worst tank{}, tank_real{}, coupled{}, alone{}, off{}, beyond{}, own{}, deeper{}, shallower{}, squares{};
    long updates = 0, shortened = 0;
    unsigned long long exceeded = 0;

    template <Real T>
    void run(const Ground<T>& ground, Site<T>& site, const Effort& effort, Findings& findings) {
        Touching<T> touching{ground.terrain, model.capabilities.max_stiffness};
        for (int n = effort.counted(40); n > 0; --n) {
            const double step = n % 4 < 2 ? 0.1e-3 : 0.5e-3;
            const bool presses = n % 2 == 0;
            const auto path =
                presses ? std::optional{site.press(6e-3, step)} : site.stroke(40 * cell, 6e-3, step);
            if (path) follow_all(touching, *path, ground.name, presses, step < 0.2e-3);
        }
        findings.lag.add(touching);
    }

private:
    /// One path with each link; `slow`: at 0.1 m/s.
    template <Real T>
    void follow_all(Touching<T>& touching, const Path& path, const std::string& ground, bool presses,
                    bool slow) {
        const auto by_spring = follow_in_hand(touching, model, path, Link::none);
        const auto by_coupling = follow_in_hand(touching, model, path, Link::coupling);
        const auto by_tank = follow_in_hand(touching, model, path, Link::tank);
        squares.add(by_spring.of_squares, ground);
        alone.add(-by_spring.real, ground);
        coupled.add(-by_coupling.real, ground);
        if (slow) {
            beyond.add(by_coupling.beyond, ground);
            own.add(by_coupling.own, ground);
        }
        off.add(std::max(by_spring.observed_off, by_coupling.observed_off), ground);
        if (presses) {
            deeper.add(by_coupling.deepest / by_spring.deepest, ground);
            shallower.add(by_spring.deepest / by_coupling.deepest, ground);
        }
        tank.add(-by_tank.told, ground);
        tank_real.add(-by_tank.real, ground);
        updates += by_tank.updates;
        shortened += by_tank.shortened;
        exceeded += by_tank.exceeded;
    }
};

} // namespace

template <Real T>
void energy(const Effort& effort, Findings& findings) {
    Rigid of_rigid;
    InHand in_hands[2]{{hfh::simulated_touch}, {hfh::simulated_premium}};
    for (const auto& ground : grounds<T>(cell)) {
        Site<T> site{ground.terrain, 11};
        Touching<T> touching{ground.terrain, stiffness};
        of_rigid.run(ground, site, touching, effort);
        findings.lag.add(touching);
        for (InHand& of : in_hands) of.run(ground, site, effort, findings);
    }
    auto& [press, stroke, squares, rigid, presses, strokes, mean_stroke] = of_rigid;
    long updates = 0, shortened = 0;
    unsigned long long exceeded = 0;
    for (const InHand& of : in_hands) {
        squares.add(of.squares.value, of.squares.where);
        updates += of.updates;
        shortened += of.shortened;
        exceeded += of.exceeded;
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
    const auto lowest = [&](const std::string& what, const Worst& worst, double goal, const char* words) {
        findings.rows.push_back(
            {what, words, text("%.2g J (%s)", worst.value > 0 ? -worst.value : 0.0, worst.where.c_str()),
             goal < 0 ? verdict(-worst.value >= goal) : Verdict::none});
    };
    for (const InHand& of : in_hands) {
        const bool is_touch = &of == in_hands;
        const double hardness =
            (is_touch ? hfh::simulated_touch : hfh::simulated_premium).capabilities.max_stiffness;
        const char* name = is_touch ? "Touch" : "Premium 1.5";
        lowest(
            text("hand on the %s, %.0f N/m, on every ground, with `VirtualCoupling`: its real balance at any "
                 "time, at least",
                 name, hardness),
            of.coupled, -1e-4, "≥ −10⁻⁴ J");
        lowest("… without", of.alone, 0, "");
        findings.rows.push_back({"… how deep a press comes, over the spring's alone", "1 ± 10 %",
                                 text("%.3f to %.3f", 1 / of.shallower.value, of.deeper.value),
                                 verdict(of.deeper.value <= 1.1 && of.shallower.value <= 1 / 0.9)});
        findings.rows.push_back({"… steps of the force beyond the spring's own, at 0.1 m/s", "≤ 0.1 N",
                                 text("%.3f N (%s); the spring's own up to %.2f N", of.beyond.value,
                                      of.beyond.where.c_str(), of.own.value),
                                 of.beyond.value <= 0.1 ? Verdict::met : Verdict::known});
        findings.rows.push_back({"… `PassivityObserver`, off the real balance at the end of a way, at most",
                                 "", text("%.2g J (%s)", of.off.value, of.off.where.c_str())});
    }
    lowest("with `EnergyTank`, the hand's balance by the told positions at any time, at least: rigid hand",
           rigid, -1e-9, "≥ −10⁻⁹ J");
    lowest("… hand on the Touch", in_hands[0].tank, -1e-9, "≥ −10⁻⁹ J");
    lowest("… hand on the Premium 1.5", in_hands[1].tank, -1e-9, "≥ −10⁻⁹ J");
    lowest("… Touch, by the real positions", in_hands[0].tank_real, 0, "");
    lowest("… Premium 1.5, by the real positions", in_hands[1].tank_real, 0, "");
    findings.rows.push_back({"… in hand, motions beyond what the tank counts with", "0",
                             text("%llu", exceeded), verdict(exceeded == 0)});
    findings.rows.push_back(
        {"… in hand, updates in contact with a shortened force", "",
         text("%.1f %%", 100.0 * static_cast<double>(shortened) / static_cast<double>(std::max(1L, updates))),
         Verdict::none});
    findings.details.push_back(presses);
    findings.details.push_back(strokes);
    findings.details.push_back(mean_stroke);
}

template void energy<float>(const Effort&, Findings&);
template void energy<double>(const Effort&, Findings&);

} // namespace closed_loop
