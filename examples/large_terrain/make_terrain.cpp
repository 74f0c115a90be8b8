#include "command_line.hpp"
#include "raster_maker.hpp"

#include <chrono>
#include <cstdio>

// Makes a raster for large_terrain: a billion samples unless told otherwise.

namespace {

void run(int argc, char** argv) {
    CLI::App app{"Makes ground of any size as an ESRI raster: a .bil of 16 bit integers, and its .hdr.",
                 "make_terrain"};
    std::string file, columns_text, rows_text, seed_text;
    app.add_option("FILE.bil", file, "What to write; the .hdr goes beside it")->required();
    app.add_option("--columns", columns_text, "Samples from west to east. Default: 32768")->type_name("N");
    app.add_option("--rows", rows_text, "Samples from north to south. Default: as many as columns")
        ->type_name("N");
    app.add_option("--seed", seed_text, "Another number makes other ground. Default: 1")->type_name("N");
    if (!large_terrain::read_command_line(app, argc, argv)) return;

    const auto number = [](const char* option, const std::string& text, std::uint64_t least,
                           std::uint64_t otherwise) {
        constexpr std::uint64_t most = 0x7fff'ffff;
        return text.empty() ? otherwise : large_terrain::number_from(option, text, least, most);
    };
    const std::uint64_t columns = number("--columns", columns_text, 2, 32768);
    const std::uint64_t rows = number("--rows", rows_text, 2, columns);
    const std::uint64_t seed = number("--seed", seed_text, 0, 1);

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
