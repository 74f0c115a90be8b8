#include "catch.hpp"
#include "support/skip.hpp"
#include "touch_terrain_files.hpp"

#include <terrain.hpp>

#include <array>
#include <bit>
#include <cmath>
#include <limits>

// Every kind of terrain file that the demo reads: the right samples, right way up, and spacing where the file says.

using namespace touch_terrain_tests;

namespace {

/// Height at column i from the west and row j from the south, as double; NaN if missing.
double at(const demo::Terrain& terrain, hfh::Index i, hfh::Index j) {
    return std::visit(
        [&](const auto& heights) {
            const auto sample = heights(i, j);
            return heights.missing(sample) ? std::numeric_limits<double>::quiet_NaN()
                                           : static_cast<double>(sample);
        },
        terrain.heights);
}

std::array<hfh::Index, 2> size(const demo::Terrain& terrain) {
    return std::visit(
        [](const auto& heights) {
            return std::array{heights.columns(), heights.rows()};
        },
        terrain.heights);
}

/// Files hold 1 2 3 in the north row and 4 5 6 in the south row.
void check_one_to_six(const demo::Terrain& terrain) {
    CHECK(size(terrain) == std::array<hfh::Index, 2>{3, 2});
    for (hfh::Index i = 0; i < 3; ++i) {
        CHECK(at(terrain, i, 0) == static_cast<double>(4 + i));
        CHECK(at(terrain, i, 1) == static_cast<double>(1 + i));
    }
}

const char* const byte_order = std::endian::native == std::endian::little ? "I" : "M";

template <class S>
constexpr const char* pixel_type = std::is_floating_point_v<S> ? "FLOAT"
                                   : std::is_signed_v<S>       ? "SIGNEDINT"
                                                               : "UNSIGNEDINT";

template <class S>
std::string bil_header(const std::string& more = "") {
    return "NROWS 2\nNCOLS 3\nNBANDS 1\nLAYOUT BIL\nNBITS " + std::to_string(8 * sizeof(S)) + "\nPIXELTYPE " +
           pixel_type<S> + "\nBYTEORDER " + byte_order + "\n" + more;
}

} // namespace

TEST_CASE("touch_terrain: reads png of 8 and 16 bits, grey or the alpha channel", "[touch_terrain]") {
    const Folder folder;
    const int bits = GENERATE(8, 16);
    const int interlace = GENERATE(PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7);
    const int top = bits == 8 ? 255 : 65535;
    CAPTURE(bits, interlace);

    write_png(folder / "t.PNG", 3, 2, bits, PNG_COLOR_TYPE_GRAY, {1, 2, 3, 4, 5, 6}, interlace);
    check_one_to_six(demo::read_terrain(folder / "t.PNG"));
    CHECK_FALSE(demo::read_terrain(folder / "t.PNG").spacing);

    write_png(folder / "ga.png", 3, 2, bits, PNG_COLOR_TYPE_GRAY_ALPHA, {9, 1, 9, 2, 9, 3, 9, 4, 9, 5, 9, 6},
              interlace);
    check_one_to_six(demo::read_terrain(folder / "ga.png"));

    write_png(folder / "rgba.png", 3, 2, bits, PNG_COLOR_TYPE_RGBA,
              {9, 8, 7, 1, 9, 8, 7, 2, 9, 8, 7, 3, 9, 8, 7, 4, 9, 8, 7, 5, 9, 8, 7, 6}, interlace);
    check_one_to_six(demo::read_terrain(folder / "rgba.png"));

    write_png(folder / "top.png", 2, 2, bits, PNG_COLOR_TYPE_GRAY, {top, 0, top - 1, 1}, interlace);
    CHECK(at(demo::read_terrain(folder / "top.png"), 0, 1) == top);
    CHECK(at(demo::read_terrain(folder / "top.png"), 0, 0) == top - 1);
}

TEMPLATE_TEST_CASE("touch_terrain: reads bil of every sample type", "[touch_terrain]", std::uint8_t,
                   std::uint16_t, std::int16_t, std::int32_t, float, double) {
    using S = TestType;
    const Folder folder;
    folder.samples<S>("t.bil", {1, 2, 3, 4, 5, 6});

    folder.text("t.hdr", bil_header<S>());
    const demo::Terrain terrain = demo::read_terrain(folder / "t.bil");
    check_one_to_six(terrain);
    CHECK(std::holds_alternative<demo::Heights<S>>(terrain.heights));
    CHECK_FALSE(terrain.spacing);

    SECTION("with a missing value") {
        folder.text("t.hdr", bil_header<S>("NODATA 2\n"));
        const auto holed = demo::read_terrain(folder / "t.bil");
        CHECK(std::isnan(at(holed, 1, 1)));
        CHECK(at(holed, 0, 1) == 1);
        CHECK(at(holed, 1, 0) == 5);
    }
    SECTION("with a missing value that the type cannot hold") {
        folder.text("t.hdr", bil_header<S>("NODATA -1e300\n"));
        check_one_to_six(demo::read_terrain(folder / "t.bil"));
    }
    SECTION("with its spacing, in keys of any case, CRLF and keys unknown") {
        folder.text("t.hdr", "nrows 2\r\nNcols\t3\r\n\r\nnbits " + std::to_string(8 * sizeof(S)) +
                                 "\r\npixeltype " + pixel_type<S> + "\r\nULXMAP 1.5\r\nXDIM 30\r\nyDim 25.5");
        const auto spaced = demo::read_terrain(folder / "t.bil");
        check_one_to_six(spaced);
        REQUIRE(spaced.spacing);
        CHECK(spaced.spacing->x == 30);
        CHECK(spaced.spacing->y == 25.5);
    }
    SECTION("with bytes to skip and padded rows") {
        folder.samples<S>("t.bil", {9, 1, 2, 3, 9, 9, 4, 5, 6, 9, 9});
        folder.text("t.hdr", bil_header<S>("SKIPBYTES " + std::to_string(sizeof(S)) + "\nBANDROWBYTES " +
                                           std::to_string(3 * sizeof(S)) + "\nTOTALROWBYTES " +
                                           std::to_string(5 * sizeof(S)) + "\n"));
        check_one_to_six(demo::read_terrain(folder / "t.bil"));
    }
}

TEST_CASE("touch_terrain: a bil header may leave out what ESRI gives defaults", "[touch_terrain]") {
    const Folder folder;
    folder.samples<std::uint8_t>("t.bil", {1, 2, 3, 4, 5, 6});
    folder.text("t.HDR", "NROWS 2\nNCOLS 3\n");
    const auto terrain = demo::read_terrain(folder / "t.bil");
    check_one_to_six(terrain);
    CHECK(std::holds_alternative<demo::Heights<std::uint8_t>>(terrain.heights));
}

TEST_CASE("touch_terrain: reads flt with its missing value and cell size", "[touch_terrain]") {
    const Folder folder;
    const float lowest = std::numeric_limits<float>::lowest();
    folder.samples<float>("t.flt", {1, 2, lowest, 4, 5, std::numeric_limits<float>::infinity()});
    folder.text("t.hdr", std::string{"ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 12.5\n"
                                     "NODATA_value -3.4028234663852886e+38\nbyteorder "} +
                             (byte_order[0] == 'I' ? "LSBFIRST" : "MSBFIRST") + "\n");
    const auto terrain = demo::read_terrain(folder / "t.flt");
    CHECK(at(terrain, 0, 1) == 1);
    CHECK(at(terrain, 1, 0) == 5);
    CHECK(std::isnan(at(terrain, 2, 1)));
    CHECK(std::isnan(at(terrain, 2, 0)));
    REQUIRE(terrain.spacing);
    CHECK(terrain.spacing->x == 12.5);
    CHECK(terrain.spacing->y == 12.5);
}

TEST_CASE("touch_terrain: a bil far larger than memory is opened without reading it", "[touch_terrain]") {
    const Folder folder;
    folder.text("t.bil", "");
    std::error_code sparse;
    fs::resize_file(folder / "t.bil", std::uintmax_t{200'000} * 100'000 * 8, sparse); // 160 GB of hole
    if (sparse) return hfh::test::skip("this file system has no files with holes: " + sparse.message());
    folder.text("t.hdr", "NROWS 100000\nNCOLS 200000\nNBITS 64\nPIXELTYPE FLOAT\n");
    const auto terrain = demo::read_terrain(folder / "t.bil");
    CHECK(at(terrain, 199'999, 0) == 0);
    CHECK(at(terrain, 0, 99'999) == 0);
}

TEST_CASE("touch_terrain: the bundled terrain is the Spanish Peaks", "[touch_terrain]") {
    const auto terrain = demo::read_terrain(HFH_SOURCE_DIR "/examples/data/spanish_peaks.png");
    CHECK(size(terrain) == std::array<hfh::Index, 2>{300, 300});
    CHECK(at(terrain, 146, 151) == 4116); // West Spanish Peak
}

TEST_CASE("touch_terrain: the bundled terrain has the heights of the raster that it was made from",
          "[touch_terrain][real]") {
    const auto bil = hfh::test::shared_file_or_skip("spanish_peaks.bil");
    if (!bil) return;
    const auto terrain = demo::read_terrain(HFH_SOURCE_DIR "/examples/data/spanish_peaks.png");
    const auto raster = demo::read_terrain(*bil);
    bool same = true;
    for (hfh::Index j = 0; j < 300; ++j) {
        for (hfh::Index i = 0; i < 300; ++i) same = same && at(terrain, i, j) == at(raster, i, j);
    }
    CHECK(same);
}

#ifdef TOUCH_TERRAIN_HAS_GDAL
TEST_CASE("touch_terrain: reads what GDAL opens", "[touch_terrain]") {
    const Folder folder;
    folder.text("t.asc", "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 7.5\nNODATA_value -9999\n"
                         "1 -9999 3\n4 5 6\n");
    const auto terrain = demo::read_terrain(folder / "t.asc");
    CHECK(size(terrain) == std::array<hfh::Index, 2>{3, 2});
    CHECK(at(terrain, 0, 1) == 1);
    CHECK(std::isnan(at(terrain, 1, 1)));
    CHECK(at(terrain, 2, 0) == 6);
    REQUIRE(terrain.spacing);
    CHECK(terrain.spacing->x == 7.5);
    CHECK(terrain.spacing->y == 7.5);
}
#else
TEST_CASE("touch_terrain: reads what GDAL opens", "[touch_terrain]") {
    hfh::test::skip("GDAL was not there when this was configured");
}
#endif
