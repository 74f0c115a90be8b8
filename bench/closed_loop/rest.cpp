#include "hand.hpp"
#include "report.hpp"

#include <hfh/device/limit_cycle_filter.hpp>

// Does a hand that presses and then keeps still come to rest? And what does a hand feel that slides on flat ground?

namespace closed_loop {
namespace {

constexpr double cell = 1e-3; // m

/// The last half second of two, the hand being still for 1.7 s.
struct Tremor {
    double position = 0; ///< m, peak to peak
    double newtons = 0;  ///< N, peak to peak
    [[nodiscard]] bool moves() const { return position > 0 || newtons > 0; }
};

/// Presses from 2 mm above with up to 3 N, as far as the grip would bend, within 0.3 s.
template <Real T>
[[nodiscard]] Tremor hold(Touching<T>& touching, const hfh::DeviceModel& model, bool steadies,
                          Site<T>& site) {
    const hfh::HandGrip grip;
    const glm::dvec3 at = site.somewhere(5 * cell);
    auto& random = site.random();
    const glm::dvec3 from = at + glm::dvec3{0, 0, 2e-3},
                     to = at + glm::dvec3{random.between(-1, 1) * cell, random.between(-1, 1) * cell,
                                          -random.between(0.5, 3) / grip.stiffness};
    Path path;
    for (int k = 0; k <= 300; ++k) path.push_back(from + (to - from) * (k / 300.0));

    touching.reset();
    hfh::SimulatedDevice device{model, grip, Along{&path}, 2};
    glm::dvec3 low{1e300}, high{-1e300}, low_force{1e300}, high_force{-1e300};
    hfh::LimitCycleFilter steady{model.capabilities.resolution};
    auto sample = device.sample();
    for (int k = 0; k < 2000; ++k) {
        sample = device.step(touching.update(steadies ? steady(sample.position) : sample.position));
        if (k < 1500) continue;
        low = glm::min(low, device.position());
        high = glm::max(high, device.position());
        low_force = glm::min(low_force, device.held());
        high_force = glm::max(high_force, device.held());
    }
    return {glm::length(high - low), glm::length(high_force - low_force)};
}

struct Holds {
    int all = 0, moving = 0;
    double position = 0, newtons = 0; ///< the largest tremor
    void add(const Tremor& tremor) {
        ++all;
        moving += tremor.moves();
        position = std::max(position, tremor.position);
        newtons = std::max(newtons, tremor.newtons);
    }
};

/// On every ground; the figures by ground into `detail`.
template <Real T>
[[nodiscard]] Holds holds(const hfh::DeviceModel& model, double stiffness, bool steadies, int count,
                          Findings& findings, Findings::Detail& detail) {
    Holds all;
    for (const auto& ground : grounds<T>(cell)) {
        Site<T> site{ground.terrain, 12};
        Touching<T> touching{ground.terrain, stiffness};
        Holds here;
        for (int n = 0; n < count; ++n) {
            const auto tremor = hold(touching, model, steadies, site);
            here.add(tremor);
            all.add(tremor);
        }
        detail.by_ground.push_back(text("%d of %d", here.moving, here.all));
        findings.lag.add(touching);
    }
    return all;
}

template <Real T>
void flat(const hfh::DeviceModel& model, const char* name, const Effort& effort, Findings& findings) {
    const auto ground = resized(hfh::test::plane<T>(400, 400, 3), cell);
    // Where a grid line is, two cells know each to a rounding of the position.
    const double rounding =
        static_cast<double>(hfh::epsilon<T>) * ground.high().x * model.capabilities.max_stiffness;
    Site<T> site{ground, 13};
    Touching<T> touching{ground, model.capabilities.max_stiffness};
    long contacts = 0;
    double largest = 0;
    for (int n = effort.counted(100, 5); n > 0; --n) {
        const auto path =
            site.wander(1.5 / hfh::HandGrip{}.stiffness, site.random().between(0.02, 1) * 1e-3, cell, 1000);
        touching.reset();
        (void)touching.update(path.front() + glm::dvec3{0, 0, 0.1});
        hfh::SimulatedDevice device{model, {}, Along{&path}, 10};
        auto sample = device.sample();
        for (std::size_t k = 0; k < path.size(); ++k) {
            const glm::dvec3 newtons = touching.update(sample.position);
            contacts += touching.touching();
            largest = std::max(largest, std::hypot(newtons.x, newtons.y));
            sample = device.step(newtons);
        }
    }
    findings.lag.add(touching);
    findings.rows.push_back({text("flat ground, a hand slides on the %s: tangential force", name),
                             "0, but for a rounding of the position",
                             text("%.2g N in %ld updates", largest, contacts),
                             verdict(largest <= rounding && contacts > 0)});
}

} // namespace

template <Real T>
void rest(const Effort& effort, Findings& findings) {
    const auto& touch = hfh::simulated_touch;
    const auto& premium = hfh::simulated_premium;
    const int count = effort.counted(60, 4);
    const auto row = [&](const char* name, const hfh::DeviceModel& model, double stiffness, bool steadies,
                         bool expected) {
        const std::string what = text("limit cycles, %s, %.0f N/m%s", name, stiffness,
                                      steadies ? ", with `LimitCycleFilter`" : "");
        Findings::Detail detail{what, {}};
        const auto found = holds<T>(model, stiffness, steadies, count, findings, detail);
        findings.rows.push_back({what, "0",
                                 found.moving == 0 ? text("0 of %d", found.all)
                                                   : text("%d of %d, up to %.1f µm and %.2f N", found.moving,
                                                          found.all, 1e6 * found.position, found.newtons),
                                 found.moving == 0 ? Verdict::met
                                 : expected        ? Verdict::known
                                                   : Verdict::not_met});
        findings.details.push_back(detail);
    };
    row("Touch", touch, touch.capabilities.max_stiffness, false, false);
    row("Premium 1.5", premium, premium.capabilities.max_stiffness, false, false);
    // As stiff as its mechanism: no gain for a loop, but what its friction and encoder steps make of one.
    constexpr double mechanism = 3500;
    row("Premium 1.5", premium, mechanism, false, true);
    row("Premium 1.5", premium, mechanism, true, false);
    row("Premium 1.5", premium, 2 * premium.dry / premium.capabilities.resolution, false, false);
    flat<T>(touch, "Touch", effort, findings);
    flat<T>(premium, "Premium 1.5", effort, findings);
}

template void rest<float>(const Effort&, Findings&);
template void rest<double>(const Effort&, Findings&);

} // namespace closed_loop
