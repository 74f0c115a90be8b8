#include "report.hpp"

#include <algorithm>

namespace closed_loop {
namespace {

[[nodiscard]] const char* word(Verdict a, Verdict b) {
    if (a == Verdict::none) return "";
    return a == Verdict::met && b == Verdict::met ? "met" : "not met";
}

[[nodiscard]] std::string by_ground(const Findings& findings) {
    std::string out = "| |", rule = "\n|---|";
    for (const auto& name : findings.grounds) {
        out += " " + name + " |";
        rule += "--:|";
    }
    out += rule;
    for (const auto& detail : findings.details) {
        out += "\n| " + detail.kind + " |";
        for (const auto& cell : detail.by_ground) out += " " + cell + " |";
    }
    return out + "\n";
}

[[nodiscard]] std::string line(const std::vector<std::string>& cells) {
    std::string out = "|";
    for (const auto& cell : cells) out += " " + cell + " |";
    return out + "\n";
}

[[nodiscard]] std::string as_markdown(const Findings::Table& table) {
    std::string out = table.title + ":\n\n" + line(table.head) + "|";
    for (std::size_t k = 0; k < table.head.size(); ++k) out += k == 0 ? "---|" : "--:|";
    out += "\n";
    for (const auto& row : table.rows) out += line(row);
    return out + "\n";
}

constexpr const char* setting =
    R"(The loop closed, by simulation: deterministic, in SI units, one update a millisecond (T). `SimulatedDevice` is solved exactly between updates; it holds each force for one update, rounds its position to its encoder's steps and has friction, each axis for itself. The hand holds it by a spring of 300 N/m and a damper of 4 N·s/m. A *rigid hand* keeps to its path whatever the force, and tells exact positions. Surfaces without friction and without shading; K is 500 N/m where nothing else is said. Every ground, the real ones too, is so small that a cell measures 1 mm in the hand (0.2 mm where the Touch goes 5 cells an update, at 1 m/s). Ridge and valley have slopes of 27°. The worst of all grounds counts.

)";

constexpr const char* notes =
    R"(
- *Critical stiffness*: a mass of 45 g leans on flat ground with 0.5 N and is nudged; above it the swing grows, below it fades. Found by halving to 10⁻⁴.
- *Presses* go 0.5 and 2 mm deep and back, *strokes* 40 mm on at that depth, at 0.02, 0.1 and 0.5 m/s. The proxy never gets farther from the stylus by sliding, so that an update gives away no more than ½K·Δx² beyond what ½K·depth² falls by, whatever the ground; over a press that sums up to K·T·v·D. That strokes stay below it too is measured. Where a proxy loses its hold and slides to a nearer place energy is lost: over most real terrains the mean stroke takes from the hand.
- *Balance*: the work of the motors' force, −Σ F·Δx, in the hand's favour; the friction of the device is left out, and would add to it (0.26 N along every way on the Touch). The *real* balance goes by where the device is, also between encoder steps; *told* is by the positions it tells.
- *`VirtualCoupling`*, before the guard, is the damper of a virtual coupling, 1.5·lag·ΔF: what a late force gives away is taken back in the same update. It has no account and no bound for any motion whatever; none of these needs one. `EnergyTank`, the last link before the device, has a bound, gives nothing that was not taken before, and so erases the ground; time-domain passivity control makes up for what is lost in one blow; energy bounding and a soft coupling go by the device's own viscous friction (0.005 N·s/m: 2b/T = 10 N/m), and leave a wall of 10 N/m. In the hand, on every ground: presses and strokes at 0.1 and 0.5 m/s, 6 mm deep; the tank with a `largest_turn` of the motors and a hand of the same strength. Where rough ground turns the force about from update to update, the damper turns with it, and its steps pass 0.1 N.
- Steps of 0.1 N an update, the spring's depth and a balance of −0.1 mJ: the Touch has all three up to 0.1 m/s. At 0.5 m/s no controller can have them: the spring's own force steps by K·v·T = 0.25 N, and held to 0.1 N on the way out it would still push with more than half of its force where the ground ends, and give the hand that. There the coupling keeps depth and balance, and steps by no more than ¾·K·v·T beyond the spring. On the Premium at 800 N/m the spring alone passes 0.1 N at 0.1 m/s.
- *Stable stiffness*, in the table of grips: a wall that never lets go, leant on with 0.5 N and nudged by 0.1 mm/s, found by halving to 10⁻³. `VirtualCoupling` is told the delay and the lag. The linkage has half of the mass at either end, the 3.5 N/mm of the Premium's maker and 0.3 N·s/m (assumed), the encoders at the motors.
- *Limit cycles*: the hand presses with up to 3 N within 0.3 s and keeps still. At rest means that in the last half second of two nothing moves, to the bit. 800 N/m is what CHAI3D renders on a Premium 1.5 (its block "Premium 1.5 6DOF"); its maker's 3500 N/m is the stiffness of the mechanism and no gain of a loop. One step of its encoder (0.03 mm) is 0.105 N at 3500 N/m, more than its friction of 0.04 N holds to both sides, and where the hand's push falls between the two forces there is no rest for any force that is a function of the position: K ≤ 2·f_c/Δ = 2667 N/m (Abbott, Okamura 2005). What is left is a tremor of a micrometre; `LimitCycleFilter` takes the middle of two steps that the device trembles between, and ends it. A swing over many steps, as in a light grip whose damping the stiffness exceeds, K > (b + d)/(T/2 + delay·T + τ), it lets pass: that takes less stiffness, or the damper of `VirtualCoupling`. The damper for its part sees the encoder's steps, and so a tremor begins earlier with it, at 1.75·K·Δ > 2·f_c: 1524 N/m on the Premium, 5400 N/m on the Touch. In the joints of the arm (0.2 m and 0.2 m, the same step at full reach) counts are finer nearer by, and no coordinate comes back to where it was while two of them tremble.
- *Force steps*: only updates count that are in contact or were so before. The rigid hand follows the ground straight below it, up and down every cliff; on the Touch (3.3 N at most) it pushes 3 mm deep, 15 cells, and its own path counts as its motion. CHAI3D's figures on comparable terrain are 1.5, 9 and 126. On the Touch 9 at 99 % is passed in one place, the Swiss Alps at 0.5 cells an update: 15 cells deep under alpine ground the proxy jumps from face to face, and that a force steps there by many times k·Δhand is in the ground. A proxy that glides from face to face (`max_contact_patches`) stays below it everywhere.
- *Friction and shading*: coefficients 0.5 and 0.4; the rigid hand, cells of 1 mm. Friction that slips by the normals of the patches, and a force that is turned by the shaded normal somewhere else, step each for itself: that was 1.2 on the Alps and 1.8 on the Kinect's depth image. Held by the shaded normals both are steadier than either alone is on most ground.
- *A proxy that glides* (`ProxyGlide`, `HapticLoopOptions::release_speed`): cells of 0.2 mm, so 0.5 mm are 2.5 cells an update, and the way of the stylus besides. Steps count where there is contact before and after; at the rim of a hole the force ends with the contact. The largest steps that are left are jumps to a face that lies behind air.
- *Lag* is judged in long double from the heights, the position and the answer: 64 ulp-scales of the derivative of the distance are taken for rounding. All updates of this page.

)";

} // namespace

std::string markdown(const Findings& in_double, const Findings& in_float) {
    std::string out = setting;
    if (in_double.grounds.size() == shapes) out += "**The real terrains were not there: shapes alone.**\n\n";
    out += "| | goal | measured, double | measured, float | |\n|---|---|---|---|---|\n";
    for (std::size_t k = 0; k < in_double.rows.size(); ++k) {
        const Row &a = in_double.rows[k], &b = in_float.rows[k];
        out += "| " + a.what + " | " + a.goal + " | " + a.measured + " | " + b.measured + " | " +
               word(a.verdict, b.verdict) + " |\n";
    }
    out += notes;
    for (const auto& table : in_double.tables) out += as_markdown(table);
    return out + "By ground, in double:\n\n" + by_ground(in_double);
}

} // namespace closed_loop
