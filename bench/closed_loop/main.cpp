#include "report.hpp"

#include <cstdlib>
#include <fstream>

// hfh_closed_loop SHARE [FILE]
//
// Is touch stable and does it give no energy away? A simulated device in a simulated hand, and hands that nothing moves
// from their path, touch every ground there is. SHARE of the full count, 1 for all of it; FILE takes the table. Exits
// with 1 if a goal is not met that the report does not know to be out of reach.

namespace {

using namespace closed_loop;

template <hfh::Real T>
[[nodiscard]] Findings findings(const Effort& effort, const Findings& walls) {
    Findings all = walls;
    for (const auto& ground : grounds<T>(1)) all.grounds.push_back(ground.name);
    wall<T>(effort, all);
    energy<T>(effort, all);
    rest<T>(effort, all);
    steps<T>(effort, all);
    all.rows.push_back({"lag: updates in which the proxy is not at a local minimum", "0",
                        text("%ld of %ld", all.lag.jammed, all.lag.contacts),
                        verdict(all.lag.jammed == 0 && all.lag.contacts > 0)});
    all.rows.push_back({"… updates in contact that the tracker did not finish (descent_limit)", "0",
                        text("%ld", all.lag.unfinished), verdict(all.lag.unfinished == 0)});
    all.rows.push_back({"… the same with `max_contact_patches` = 8, in the hand: the proxy is on its way", "",
                        text("%ld of %ld", all.gliding.unfinished, all.gliding.contacts)});
    return all;
}

[[nodiscard]] bool kept(const Findings& findings) {
    for (const Row& row : findings.rows) {
        if (row.verdict == Verdict::not_met) return false;
    }
    return true;
}

} // namespace

int main(int argc, char** argv) {
    const double share = argc > 1 ? std::atof(argv[1]) : 0;
    if (!(share > 0 && share <= 1) || argc > 3) {
        std::fputs("usage: hfh_closed_loop SHARE [FILE], 0 < SHARE <= 1\n", stderr);
        return EXIT_FAILURE;
    }
    const Effort effort{share};
    Findings walls;
    passivity(walls);
    grips_and_lags(effort, walls);
    const Findings in_double = findings<double>(effort, walls), in_float = findings<float>(effort, walls);
    const std::string table = markdown(in_double, in_float);
    std::fputs(table.c_str(), stdout);
    if (argc == 3) {
        std::ofstream out{argv[2], std::ios::binary};
        out << table;
        if (!out.flush()) {
            std::fprintf(stderr, "Cannot write %s.\n", argv[2]);
            return EXIT_FAILURE;
        }
    }
    return kept(in_double) && kept(in_float) ? EXIT_SUCCESS : EXIT_FAILURE;
}
