#include "catch.hpp"
#include "touch_terrain_files.hpp"

#include <initializer_list>
#include <sstream>

// large_terrain and make_terrain as the user meets them.

using namespace touch_terrain_tests;

namespace {

/// The line of a table that begins with `title`: its last two words.
std::pair<std::string, std::string> line_of(const std::string& table, const std::string& title) {
    std::istringstream lines{table};
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with(title)) continue;
        std::istringstream words{line.substr(title.size())};
        std::pair<std::string, std::string> values;
        words >> values.first >> values.second;
        return values;
    }
    return {"no such line", title};
}

void refuses(const Folder& folder, const std::string& program, const std::string& arguments,
             std::initializer_list<std::string> says) {
    CAPTURE(program, arguments);
    const auto files = folder.listing();
    const Run run = folder.run_program(program, arguments);
    CAPTURE(run.out, run.err);
    CHECK(run.code == 2);
    CHECK(run.out.empty());
    CHECK(run.err.starts_with(fs::path{program}.filename().string() + ": "));
    CHECK(run.err.ends_with(".\n"));
    CHECK(run.err.find('\n') == run.err.size() - 1);
    for (const std::string& word : says) {
        CAPTURE(word);
        CHECK(run.err.find(word) != std::string::npos);
    }
    CHECK(folder.listing() == files);
}

} // namespace

TEST_CASE("large_terrain: touches a raster that make_terrain made, with the same answers either way",
          "[large_terrain]") {
    const Folder folder;
    const Run made = folder.run_program(HFH_MAKE_TERRAIN, "small.bil --columns 900 --rows 700 --seed 2");
    CAPTURE(made.err);
    REQUIRE(made.code == 0);
    CHECK(made.out.starts_with("small.bil: 900 x 700 samples, 1,260,000 bytes"));

    for (const char* options :
         {"--seconds 0.5", "--seconds 0.3 --speed 0.2 --single-pages --look-ahead 100"}) {
        const Run run = folder.run_program(HFH_LARGE_TERRAIN, "small.bil " + std::string{options});
        CAPTURE(run.out, run.err);
        REQUIRE(run.code == 0);
        CHECK(run.err.empty());
        CHECK(run.out.starts_with("small.bil, 900 x 700 samples, 1,260,000 bytes"));
        const auto updates = line_of(run.out, "updates");
        CHECK(updates == (options == std::string{"--seconds 0.5"}
                              ? std::pair<std::string, std::string>{"500", "500"}
                              : std::pair<std::string, std::string>{"300", "300"}));
        for (const char* title : {"updates of 1 ms and more", "page faults that read the disk"}) {
            const auto [without, with] = line_of(run.out, title);
            CHECK(without.find_first_not_of("0123456789,") == std::string::npos);
            CHECK(with.find_first_not_of("0123456789,") == std::string::npos);
        }
        const auto [without, with] = line_of(run.out, "answers");
        CHECK(without.size() == 16);
        CHECK(without == with);
        CHECK(run.out.find("helper: ") != std::string::npos);
    }
}

TEST_CASE("large_terrain: zooms in and out while touching, and the thread that feels reads no disk",
          "[large_terrain]") {
    const Folder folder;
    const Run made = folder.run_program(HFH_MAKE_TERRAIN, "small.bil --columns 8192 --rows 6144 --seed 2");
    REQUIRE(made.code == 0);
    const Run run = folder.run_program(HFH_LARGE_TERRAIN, "small.bil --zoom 2 --seconds 3");
    CAPTURE(run.out, run.err);
    REQUIRE(run.code == 0);
    CHECK(run.err.empty());
    CHECK(run.out.starts_with("small.bil, 8192 x 6144 samples, 100,663,296 bytes; "
                              "zooming from level 9 to level 0 and back, 2 times\n"));
    CHECK(line_of(run.out, "updates").second == "3,000");
    CHECK(line_of(run.out, "page faults that read the disk").second == "0");
    CHECK(line_of(run.out, "  between updates").second == "0");
    CHECK(line_of(run.out, "in contact") == std::pair<std::string, std::string>{"100", "%"});
    CHECK(run.out.find("contacts lost: 0 without helper, 0 with helper\n") != std::string::npos);
    CHECK(run.out.find("level: waited ") != std::string::npos);
}

TEST_CASE("large_terrain: takes floats, holes and the smallest raster there is", "[large_terrain]") {
    const Folder folder;
    std::vector<float> floats;
    std::vector<std::int16_t> integers;
    for (int k = 0; k < 300 * 200; ++k) {
        floats.push_back(0.25F * static_cast<float>(k % 300 % 17));
        integers.push_back(static_cast<std::int16_t>(k % 97 == 0 ? -9999 : k % 300 / 10));
    }
    folder.samples("floats.flt", floats);
    folder.text("floats.hdr", "NCOLS 300\nNROWS 200\nCELLSIZE 5\nBYTEORDER LSBFIRST\n");
    folder.samples("holes.bil", integers);
    folder.text("holes.hdr", "NCOLS 300\nNROWS 200\nNBITS 16\nPIXELTYPE SIGNEDINT\nNODATA -9999\n");
    folder.samples("least.BIL", std::vector<std::int16_t>{1, 2, 3, 4});
    folder.text("least.hdr", "NCOLS 2\nNROWS 2\nNBITS 16\nPIXELTYPE SIGNEDINT\n");
    for (const char* file : {"floats.flt", "holes.bil", "least.BIL"}) {
        const Run run = folder.run_program(HFH_LARGE_TERRAIN, std::string{file} + " --seconds 0.4");
        CAPTURE(file, run.out, run.err);
        CHECK(run.code == 0);
        CHECK(line_of(run.out, "updates") == std::pair<std::string, std::string>{"400", "400"});
        const Run zooms =
            folder.run_program(HFH_LARGE_TERRAIN, std::string{file} + " --zoom 2 --seconds 0.4");
        CAPTURE(zooms.out, zooms.err);
        CHECK(zooms.code == 0);
        CHECK(line_of(zooms.out, "updates") == std::pair<std::string, std::string>{"400", "400"});
    }
}

TEST_CASE("large_terrain: refuses bad input in one sentence with file, value and rule", "[large_terrain]") {
    const Folder folder;
    folder.samples("good.bil", std::vector<std::int16_t>(12, 5));
    folder.text("good.hdr", "NROWS 3\nNCOLS 4\nNBITS 16\nPIXELTYPE SIGNEDINT\n");
    folder.samples("short.bil", std::vector<std::int16_t>(11, 5));
    folder.text("short.hdr", "NROWS 3\nNCOLS 4\nNBITS 16\nPIXELTYPE SIGNEDINT\n");
    folder.samples("bare.bil", std::vector<std::int16_t>(12, 5));
    folder.samples("bits.bil", std::vector<std::int16_t>(12, 5));
    folder.text("bits.hdr", "NROWS 3\nNCOLS 4\nNBITS 12\n");
    folder.samples("line.bil", std::vector<std::int16_t>(3, 5));
    folder.text("line.hdr", "NROWS 3\nNCOLS 1\nNBITS 16\n");
    const auto refused = [&](const std::string& arguments, std::initializer_list<std::string> says) {
        refuses(folder, HFH_LARGE_TERRAIN, arguments, says);
    };
    refused("", {"TERRAIN", "required"});
    refused("none.bil", {"none.bil", "does not exist"});
    refused("picture.png", {"picture.png", "'.png'", "only .bil and .flt"});
    refused("bare.bil", {"bare.hdr"});
    refused("short.bil", {"short.bil", "cut short", "22 bytes", "short.hdr", "24"});
    refused("bits.bil", {"bits.hdr, line 3", "NBITS", "'12'"});
    refused("line.bil", {"line.hdr", "1 x 3", "at least 2 x 2"});
    refused("good.bil --seconds 0", {"--seconds", "0", "from 0.01 to 3600"});
    refused("good.bil --seconds soon", {"--seconds", "soon"});
    refused("good.bil --speed -1", {"--speed", "-1", "from 0 to 10"});
    refused("good.bil --speed nan", {"--speed", "nan", "from 0 to 10"});
    refused("good.bil --look-ahead 1e9", {"--look-ahead", "from 0 to 10000"});
    refused("good.bil --zoom 0", {"--zoom", "0", "from 1 to 1000"});
    refused("good.bil --zoom 2 --speed 1", {"--zoom", "--speed"});
    refused("good.bil more.bil", {"more.bil"});
}

TEST_CASE("make_terrain: refuses bad input, and leaves nothing behind", "[large_terrain]") {
    const Folder folder;
    const auto refused = [&](const std::string& arguments, std::initializer_list<std::string> says) {
        refuses(folder, HFH_MAKE_TERRAIN, arguments, says);
    };
    refused("", {"FILE.bil", "required"});
    refused("new.tif --columns 10", {"new.tif", "must end in .bil"});
    refused("new.bil --columns 1", {"--columns", "1", "from 2 to 2147483647"});
    refused("new.bil --rows 2147483648", {"--rows", "from 2 to 2147483647"});
    refused("new.bil --columns -5", {"--columns", "-5"});
    refused("new.bil --columns many", {"--columns", "many"});
    refused("new.bil --rows 1e3", {"--rows", "'1e3'"});
    refused("new.bil --seed x", {"--seed", "x"});
    refused("no/such/folder/new.bil --columns 10", {"no/such/folder/new.bil"});
    refused("new.bil --columns 2147483647",
            {"new.bil", "9,223,372,028,264,841,218 bytes"}); // no disk is that large
}
