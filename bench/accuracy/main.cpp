#include "oracle_check.hpp"
#include "plot.hpp"
#include "report.hpp"
#include "text.hpp"

#include "../gnuplot.hpp"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <string>

// hfh_accuracy DIRECTORY [QUERIES] [ROUNDS]
//
// Speed against error for the closest point of one patch; leaves accuracy.json, .md and .png in DIRECTORY.

namespace {

void write(const std::string& file, const std::string& text) {
    std::ofstream out{file, std::ios::binary};
    out << text;
    if (!out.flush()) throw std::runtime_error{accuracy::filled("Cannot write {}.", {file})};
}

int run(const std::string& directory, std::size_t queries, int rounds) {
    using namespace accuracy;
    if (!oracle_is_right()) return EXIT_FAILURE;
    std::puts("The oracle finds every closest point that is known in closed form.");

    Run run{queries, rounds, {}};
    const auto sets = query_sets(queries);
    if (sets.size() < 6)
        std::puts("The real terrains are not there; only the synthetic queries are measured.");
    for (const QuerySet& set : sets) {
        run.sets.push_back(measured<double>(set, rounds));
        run.sets.push_back(measured<float>(set, rounds));
    }
    std::fputs(table(run).c_str(), stdout);
    const std::string stem = directory + "/accuracy";
    write(stem + ".json", json(run));
    write(stem + ".md", markdown(run));
    if (!hfh::bench::run_gnuplot(plot_script(run, stem + ".png")))
        std::puts("No plot: gnuplot is missing or failed.");
    return EXIT_SUCCESS;
}

} // namespace

int main(int argc, char** argv) {
    const long queries = argc > 2 ? std::atol(argv[2]) : 50000, rounds = argc > 3 ? std::atol(argv[3]) : 25;
    if (argc < 2 || queries < 1 || rounds < 1) {
        std::fputs("usage: hfh_accuracy DIRECTORY [QUERIES] [ROUNDS]\n", stderr);
        return EXIT_FAILURE;
    }
    try {
        return run(argv[1], static_cast<std::size_t>(queries), static_cast<int>(rounds));
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return EXIT_FAILURE;
    }
}
