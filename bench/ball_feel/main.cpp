#include "report.hpp"

#include "../gnuplot.hpp"

#include <cstdlib>
#include <exception>
#include <fstream>
#include <stdexcept>

// hfh_ball_feel SHARE [DIRECTORY]
//
// What a ball feels like beside a point: steps of the force on rough ground, and roughness over cones. SHARE of the full count,
// 1 for all of it; DIRECTORY takes ball.md, ball_steps.png and ball_roughness.png. Exits with 1 if a goal is not met.

namespace {

using namespace ball_feel;

void plot(const std::string& file, const char* size, const Section& section) {
    const std::string terminal =
        std::string{"set terminal pngcairo size "} + size +
        " font 'sans,12' background rgb 'white'\nset output '" + file +
        "'\nset encoding utf8\nset grid lc rgb '#dddddd' lw 1 dt 1\nset tics scale 0.5\n";
    if (!hfh::bench::run_gnuplot(terminal + section.plot))
        std::printf("No %s: gnuplot is missing or failed.\n", file.c_str());
}

int run(const Effort& effort, const char* directory) {
    const Section steps = force_steps(effort), rough = roughness(effort);
    const std::string page = steps.markdown + "\n" + rough.markdown;
    std::fputs(page.c_str(), stdout);
    if (directory) {
        const std::string stem = std::string{directory} + "/ball";
        std::ofstream out{stem + ".md", std::ios::binary};
        out << page;
        if (!out.flush()) throw std::runtime_error{"Cannot write " + stem + ".md."};
        plot(stem + "_steps.png", "1200,760", steps);
        plot(stem + "_roughness.png", "1000,640", rough);
    }
    return steps.is_met && rough.is_met ? EXIT_SUCCESS : EXIT_FAILURE;
}

} // namespace

int main(int argc, char** argv) {
    const double share = argc > 1 ? std::atof(argv[1]) : 0;
    if (!(share > 0 && share <= 1) || argc > 3) {
        std::fputs("usage: hfh_ball_feel SHARE [DIRECTORY], 0 < SHARE <= 1\n", stderr);
        return EXIT_FAILURE;
    }
    try {
        return run(Effort{share}, argc == 3 ? argv[2] : nullptr);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return EXIT_FAILURE;
    }
}
