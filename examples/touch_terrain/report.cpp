#include "report.hpp"

#include "numbers.hpp"

#include <cstdio>

namespace demo {
namespace {

double percent(std::uint64_t updates, const Summary& summary) {
    return summary.updates == 0 ? 0.0
                                : 100.0 * static_cast<double>(updates) / static_cast<double>(summary.updates);
}

/// The limits of a guard and how often they acted, and how often which cause tripped it.
std::string describe(const hfh::GuardCounts& counts, const hfh::GuardLimits& limits) {
    std::string trips;
    for (int k = 1; k < hfh::guard_trip_count; ++k) {
        const unsigned times = counts.trips[k];
        if (times == 0) continue;
        trips += trips.empty() ? "trips: " : ", ";
        trips.append(to_string(static_cast<hfh::GuardTrip>(k))).append(" ").append(grouped(times));
    }
    return "clamped " + grouped(counts.clamped) + " updates to " + rounded(limits.max_force) + " N, slewed " +
           grouped(counts.slewed) + " to " + rounded(limits.max_slew) + " N/ms, held back " +
           grouped(counts.held_back) + "; " +
           (trips.empty() ? "no trips" : trips + " (see hfh/device/force_guard.hpp)");
}

std::string describe(const Distribution& d) {
    return grouped(d.quantile(0.5)) + " median, " + grouped(d.quantile(0.999)) + " at 99.9 %, " +
           grouped(d.worst()) + " worst";
}

/// "name            text" and a new line.
std::string line(std::string name, const std::string& text) {
    name.resize(16, ' ');
    return name + text + "\n";
}

std::string one_decimal(double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.1f", value);
    return digits;
}

} // namespace

std::string describe(const Terrain& terrain, const Ground& ground) {
    return std::visit(
        [&](const auto& heights) {
            return std::to_string(heights.columns()) + " x " + std::to_string(heights.rows()) +
                   " samples every " + rounded(ground.cell.x, 5) + " x " + rounded(ground.cell.y, 5) + " m";
        },
        terrain.heights);
}

std::string caption(const Summary& summary, const std::string& terrain, const Setup& setup) {
    std::string what = terrain;
    for (std::size_t at; (at = what.find(" x ")) != std::string::npos;) what.replace(at, 3, " × ");
    return what + "; " + grouped(summary.updates) + " updates, " +
           rounded(percent(summary.in_contact, summary), 3) + " % in contact" +
           (setup.device.empty() ? "" : "; simulated " + setup.device) + "; stiffness " +
           rounded(setup.stiffness) + " N/m, largest force " + rounded(summary.largest_force) + " N";
}

std::string report(const Terrain& terrain, const Ground& ground) {
    const char* const open = terrain.spacing ? "" : ", which the file does not say (see --spacing)";
    std::string out = line("terrain", terrain.name + ", " + describe(terrain, ground) + open);
    for (const std::string& sentence : terrain.assumed) out += line("assumed", sentence);
    return out;
}

std::string report(const Summary& summary, const std::string& scalar, const Setup& setup,
                   const std::optional<DeviceInHand>& device) {
    std::string out;
    if (device) {
        out += line("device", setup.device + ", simulated, in a hand; 1 mm there is " +
                                  rounded(1e-3 * device->workspace().frame().scale) + " m of terrain");
        out += line("guard", describe(summary.guard, device->limits()));
    }
    out += line("updates", grouped(summary.updates) + " in " + scalar);
    out += line("in contact", one_decimal(percent(summary.in_contact, summary)) + " %");
    if (summary.buried > 0) {
        out += line("buried", one_decimal(percent(summary.buried, summary)) +
                                  " %, below the surface without having met it");
    }
    if (summary.refused > 0) {
        out +=
            line("refused", grouped(summary.refused) + (summary.refused == 1 ? " position" : " positions") +
                                " that the tracker cannot use, too far away to number the cell in " + scalar);
    }
    out += line("patches", describe(summary.patches) + ", per update");
    out += line("time (ns)", describe(summary.nanoseconds) + ", per update");
    out +=
        line("largest force", rounded(summary.largest_force) + " N at " + rounded(setup.stiffness) + " N/m");
    return out + "bytes kept beside the heights: 0 (the tracker remembers " +
           std::to_string(summary.state_bytes) + " in all)\n";
}

} // namespace demo
