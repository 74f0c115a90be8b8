#include "raster_maker.hpp"

#include <bad_input.hpp>
#include <numbers.hpp>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>

// Makes a raster for large_terrain: a billion samples unless told otherwise.

namespace {

void run(int argc, char** argv) {
    CLI::App app{"Makes ground of any size as an ESRI raster: a .bil of 16 bit integers, and its .hdr.",
                 "make_terrain"};
    std::string file;
    std::uint64_t columns = 32768, rows = 0, seed = 1;
    const CLI::Range side{std::uint64_t{2}, std::uint64_t{0x7fff'ffff}, "from 2 to 2147483647"};
    app.add_option("FILE.bil", file, "What to write; the .hdr goes beside it")->required();
    app.add_option("--columns", columns, "Samples from west to east. Default: 32768")
        ->type_name("N")
        ->check(side);
    app.add_option("--rows", rows, "Samples from north to south. Default: as many as columns")
        ->type_name("N")
        ->check(side);
    app.add_option("--seed", seed, "Another number makes other ground. Default: 1")->type_name("N");
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        std::fputs(app.help().c_str(), stdout);
        return;
    } catch (const CLI::ParseError& error) {
        std::string what = error.what();
        std::ranges::replace(what, '\n', ' ');
        throw demo::BadInput{"The command line cannot be read (see --help): " + what + "."};
    }
    if (rows == 0) rows = columns;

    const auto start = std::chrono::steady_clock::now();
    large_terrain::make_raster(file, columns, rows, seed);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    std::printf("%s: %s x %s samples, %s bytes, in %.1f s\n", file.c_str(), std::to_string(columns).c_str(),
                std::to_string(rows).c_str(), demo::grouped(columns * rows * 2).c_str(), took.count());
}

} // namespace

int main(int argc, char** argv) {
    try {
        run(argc, argv);
        return 0;
    } catch (const demo::BadInput& error) {
        std::fprintf(stderr, "make_terrain: %s\n", error.what());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "make_terrain: cannot go on: %s.\n", error.what());
    }
    return 2;
}
