#include "../machine.hpp"
#include "record.hpp"

#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>

// The goals, each beside its reference: hfh_goals [--quick] [--only PART] [--record DIRECTORY].
//
// Ends with 1 if an answer is wrong, an update took 1 ms, or a number that DIRECTORY/goals.json says was met is missed
// by more than a tenth in each of three attempts. Else writes goals.json and goals.md there. Without --record, and where
// a row was not measured, they go to the working directory.

namespace {

using namespace hfh::bench;

struct Part {
    const char* name;
    Findings (*measure)(const Settings&);
};
constexpr Part parts[] = {
    {"sliding", sliding}, {"closest", closest_peers}, {"crossing", crossing},
    {"bounds", bounds},   {"worst", worst_updates},   {"vast", vast},
    {"scalars", scalars}, {"beside", beside_heights}, {"compile", compile_time},
};

constexpr double slack = 0.1;
constexpr int attempts = 3;

/// The numbers that were met and are missed by more than the slack.
std::set<FigureName> lost(const std::vector<Row>& rows, const std::set<FigureName>& was_met) {
    std::set<FigureName> missing;
    for (const auto& row : rows) {
        for (const auto& f : row.figures) {
            if (f.measured && !f.met_within(slack) && was_met.count({row.name, f.what}) > 0) {
                missing.insert({row.name, f.what});
            }
        }
    }
    return missing;
}

std::string today() {
    const std::time_t now = std::time(nullptr);
    char date[20];
    std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
    return date;
}

} // namespace

int main(int argc, char** argv) {
    Settings settings{.scratch = HFH_SCRATCH_DIR,
                      .compiler = HFH_COMPILER,
                      .include = HFH_SOURCE_DIR "/include",
                      .glm_include = HFH_GLM_INCLUDE};
    std::string into, only;
    for (int k = 1; k < argc; ++k) {
        if (std::strcmp(argv[k], "--quick") == 0) {
            settings.quick = true;
        } else if (std::strcmp(argv[k], "--record") == 0 && k + 1 < argc) {
            into = argv[++k];
        } else if (std::strcmp(argv[k], "--only") == 0 && k + 1 < argc) {
            only = argv[++k];
        } else {
            std::fputs("hfh_goals [--quick] [--only PART] [--record DIRECTORY]\n", stderr);
            return 2;
        }
    }
    const auto was_met = into.empty() ? std::set<FigureName>{} : met_at_last_recording(into + "/goals.json");

    Findings all;
    std::set<FigureName> gone;
    bool whole = only.empty();
    try {
        for (const auto& part : parts) {
            if (!only.empty() && only != part.name) continue;
            const std::time_t begin = std::time(nullptr);
            Findings found = part.measure(settings);
            auto missing = lost(found.rows, was_met);
            for (int attempt = 1; attempt < attempts && !missing.empty(); ++attempt) {
                const Findings again = part.measure(settings);
                std::set<FigureName> still;
                for (const auto& name : lost(again.rows, was_met)) {
                    if (missing.count(name) > 0) still.insert(name);
                }
                missing = std::move(still);
                for (std::size_t r = 0; r < found.rows.size(); ++r) {
                    if (again.rows[r].quality() > found.rows[r].quality()) found.rows[r] = again.rows[r];
                }
            }
            gone.merge(missing);
            for (auto& row : found.rows) {
                whole = whole && row.measured();
                print(row);
                all.rows.push_back(std::move(row));
            }
            for (auto& w : found.workloads) all.workloads.push_back(std::move(w));
            std::printf("  (%s: %ld s)\n", part.name, static_cast<long>(std::time(nullptr) - begin));
        }
    } catch (const std::exception& fault) {
        std::fprintf(stderr, "%s\n", fault.what());
        return 1;
    }
    if (all.rows.empty()) {
        std::fputs("there is no such part\n", stderr);
        return 2;
    }

    const Machine machine{cpu_name(), compiler_name, HFH_BENCH_FLAGS, today()};
    for (const auto& [row, figure] : gone) {
        std::fprintf(stderr, "no longer met: %s%s%s\n", row.c_str(), figure.empty() ? "" : ", ",
                     figure.c_str());
    }
    const std::string directory = !into.empty() && whole && gone.empty() ? into + "/" : "";
    std::ofstream json{directory + "goals.json"}, table{directory + "goals.md"};
    write_json(json, machine, all);
    write_markdown(table, machine, all);
    table.close();
    json.close();
    std::ifstream written{directory + "goals.md"};
    std::printf("\n%s\n", std::string{std::istreambuf_iterator<char>{written}, {}}.c_str());
    if (!json || !table) {
        std::fputs("cannot write goals.json and goals.md\n", stderr);
        return 1;
    }
    return gone.empty() ? 0 : 1;
}
