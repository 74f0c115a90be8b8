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

constexpr const char* setting =
    R"(The loop closed, by simulation: deterministic, in SI units, one update a millisecond (T). `SimulatedDevice` is solved exactly between updates; it holds each force for one update, rounds its position to its encoder's steps and has friction, each axis for itself. The hand holds it by a spring of 300 N/m and a damper of 4 N·s/m. A *rigid hand* keeps to its path whatever the force, and tells exact positions. Surfaces without friction and without shading; K is 500 N/m where nothing else is said. Every ground, the real ones too, is so small that a cell measures 1 mm in the hand (0.2 mm where the Touch goes 5 cells an update, at 1 m/s). Ridge and valley have slopes of 27°. The worst of all grounds counts.

)";

constexpr const char* notes =
    R"(
- *Critical stiffness*: a mass of 45 g leans on flat ground with 0.5 N and is nudged; above it the swing grows, below it fades. Found by halving to 10⁻⁴.
- *Presses* go 0.5 and 2 mm deep and back, *strokes* 40 mm on at that depth, at 0.02, 0.1 and 0.5 m/s. The proxy never gets farther from the stylus by sliding, so that an update gives away no more than ½K·Δx² beyond what ½K·depth² falls by, whatever the ground; over a press that sums up to K·T·v·D. That strokes stay below it too is measured. Where a proxy loses its hold and slides to a nearer place energy is lost: over most real terrains the mean stroke takes from the hand.
- *Passivity controller*: `EnergyTank`, the last link before the device. It gives nothing that was not taken before, so with an allowance of 10⁻⁹ J it shortens nearly every force of a light press; what 0.1 mJ changes is in the table. It counts by the positions that the device tells; what the hand gets between two steps of the encoder has no goal and is left to the friction of the device.
- *Limit cycles*: the hand presses with up to 3 N within 0.3 s and keeps still. At rest means that in the last half second of two nothing moves, to the bit. The Premium's maker gives 3500 N/m, 0.03 mm and 0.04 N of friction. One step of its encoder is then 0.105 N, more than friction holds to both sides, and where the hand's push falls between the two forces there is no rest for any force that is a function of the position: K ≤ 2·f_c/Δ = 2667 N/m (Abbott, Okamura 2005). What is left is a tremor of a micrometre; `SteadyPosition` takes the middle of two steps that the device trembles between, and ends it.
- *Force steps*: only updates count that are in contact or were so before. The rigid hand follows the ground straight below it, up and down every cliff; on the Touch (3.3 N at most) it pushes 3 mm deep, 15 cells, and its own path counts as its motion. CHAI3D's figures on comparable terrain are 1.5, 9 and 126. On the Touch 9 at 99 % is passed in one place, the Swiss Alps at 0.5 cells an update: 15 cells deep under alpine ground the proxy jumps from face to face, and that a force steps there by many times k·Δhand is in the ground. A proxy that glides from face to face (`max_slide`) stays below it everywhere.
- *Lag* is judged in long double from the heights, the position and the answer: 64 ulp-scales of the derivative of the distance are taken for rounding. All updates of this page.

By ground, in double:

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
    return out + notes + by_ground(in_double);
}

} // namespace closed_loop
