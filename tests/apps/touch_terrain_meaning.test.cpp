#include "catch.hpp"
#include "touch_terrain_files.hpp"

#include <bad_input.hpp>
#include <map_units.hpp>
#include <terrain.hpp>
#include <units.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

// A terrain is read as its format means it, and where a file leaves a question open the program says what it assumed.

using namespace touch_terrain_tests;

namespace {

constexpr double hole = std::numeric_limits<double>::quiet_NaN();

/// Height in metres at column i from the west and row j from the south; NaN in holes.
double height(const demo::Terrain& terrain, hfh::Index i, hfh::Index j) {
    return std::visit(
        [&](const auto& heights) {
            const auto sample = heights(i, j);
            return heights.missing(sample)
                       ? hole
                       : terrain.height_offset + terrain.height_scale * static_cast<double>(sample);
        },
        terrain.heights);
}

/// All heights in metres, north row first.
std::vector<double> heights_of(const demo::Terrain& terrain) {
    const auto [columns, rows] = std::visit(
        [](const auto& heights) {
            return std::array{heights.columns(), heights.rows()};
        },
        terrain.heights);
    std::vector<double> all;
    for (hfh::Index j = rows; j-- > 0;) {
        for (hfh::Index i = 0; i < columns; ++i) all.push_back(height(terrain, i, j));
    }
    return all;
}

void check_heights(const demo::Terrain& terrain, const std::vector<double>& wanted) {
    const auto got = heights_of(terrain);
    REQUIRE(got.size() == wanted.size());
    for (std::size_t k = 0; k < got.size(); ++k) {
        CAPTURE(k, got[k], wanted[k]);
        CHECK((std::isnan(wanted[k]) ? std::isnan(got[k]) : got[k] == Approx(wanted[k]).epsilon(1e-12)));
    }
}

bool says(const demo::Terrain& terrain, const std::string& words) {
    return std::ranges::any_of(terrain.assumed, [&](const std::string& sentence) {
        return sentence.find(words) != std::string::npos;
    });
}

/// The sentence with which `read` is refused, or "" if it is not.
template <class Read>
std::string refusal(Read&& read) {
    try {
        (void)read();
    } catch (const demo::BadInput& bad) {
        return bad.what();
    }
    return {};
}

bool contains(const std::string& text, const std::string& words) {
    return text.find(words) != std::string::npos;
}

/// `samples` as bytes of the other order than this machine's.
template <class S>
std::vector<std::uint8_t> swapped(const std::vector<S>& samples) {
    std::vector<std::uint8_t> bytes;
    for (const S sample : samples) {
        auto one = std::bit_cast<std::array<std::uint8_t, sizeof(S)>>(sample);
        bytes.insert(bytes.end(), one.rbegin(), one.rend());
    }
    return bytes;
}

const char* const other_order = std::endian::native == std::endian::little ? "M" : "I";

const std::string wgs84 =
    R"(GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],)"
    R"(PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]])";

std::string state_plane(const std::string& unit) {
    return R"(PROJCS["x",)" + wgs84 +
           R"(,PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",5e5],UNIT[)" + unit + "]]";
}

/// Says that the ellipsoid of `map` is projected as a sphere, as GDAL does in the older form.
std::string with_extension(const std::string& map) {
    return map.substr(0, map.size() - 1) +
           R"(,EXTENSION["PROJ4","+proj=merc +a=6378137 +b=6378137 +lat_ts=0 +nadgrids=@null +wktext +no_defs"],)"
           R"(AUTHORITY["EPSG","3857"]])";
}

} // namespace

TEST_CASE("touch_terrain bil: without PIXELTYPE, a negative NODATA means a sign", "[touch_terrain]") {
    const Folder folder;
    SECTION("16 bits") {
        folder.samples<std::int16_t>("t.bil", {-9999, 10, -5, 32000});
        folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 16\nNODATA -9999\n");
        const auto terrain = demo::read_terrain(folder / "t.bil");
        check_heights(terrain, {hole, 10, -5, 32000});
        CHECK(says(terrain, "integers with a sign, for t.hdr has no PIXELTYPE, but a NODATA of -9999"));
    }
    SECTION("32 bits, and a value that no sample has") {
        folder.samples<std::int32_t>("t.bil", {-9999, 10, -5, 70000});
        folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 32\nNODATA -3.4e38\n");
        check_heights(demo::read_terrain(folder / "t.bil"), {-9999, 10, -5, 70000});
    }
    SECTION("8 bits, of which GDAL does not think so") {
        folder.samples<std::int8_t>("t.bil", {-1, 10, -128, 127});
        folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNODATA -1\n");
        const auto terrain = demo::read_terrain(folder / "t.bil");
        check_heights(terrain, {hole, 10, -128, 127});
        CHECK(says(terrain, "integers with a sign, for t.hdr has no PIXELTYPE, but a NODATA of -1"));
        folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 8\nPIXELTYPE SIGNEDINT\n");
        check_heights(demo::read_terrain(folder / "t.bil"), {-1, 10, -128, 127});
        CHECK_FALSE(says(demo::read_terrain(folder / "t.bil"), "sign"));
    }
    SECTION("none without it") {
        folder.samples<std::uint16_t>("t.bil", {65535, 10, 40000, 9});
        folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 16\nNODATA 9\n");
        const auto terrain = demo::read_terrain(folder / "t.bil");
        check_heights(terrain, {65535, 10, 40000, hole});
        CHECK(says(terrain, "without a sign, for t.hdr has no PIXELTYPE"));
        folder.samples<std::uint8_t>("t.bil", {255, 10, 128, 9});
        folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNODATA 9\n");
        check_heights(demo::read_terrain(folder / "t.bil"), {255, 10, 128, hole});
    }
    SECTION("what PIXELTYPE says goes before") {
        folder.samples<std::uint16_t>("t.bil", {65535, 10, 40000, 9});
        folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 16\nPIXELTYPE UNSIGNEDINT\nNODATA -9999\n");
        const auto terrain = demo::read_terrain(folder / "t.bil");
        check_heights(terrain, {65535, 10, 40000, 9});
        CHECK_FALSE(says(terrain, "PIXELTYPE"));
    }
}

TEST_CASE("touch_terrain bil: a NODATA that no sample can be is not dropped silently", "[touch_terrain]") {
    const Folder folder;
    const auto said = [&](int bits, const std::string& type, const std::string& no_data) {
        folder.samples<std::uint8_t>("t.bil", std::vector<std::uint8_t>(static_cast<std::size_t>(bits) / 2));
        folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS " + std::to_string(bits) + "\nPIXELTYPE " + type +
                                 "\nNODATA " + no_data + "\n");
        const auto terrain = demo::read_terrain(folder / "t.bil");
        CHECK(std::isnan(height(terrain, 0, 0)) == (no_data == "0"));
        for (const std::string& sentence : terrain.assumed) {
            if (contains(sentence, "no data")) return sentence;
        }
        return std::string{};
    };
    CHECK(said(8, "UNSIGNEDINT", "-1") ==
          "no sample is \"no data\", for t.hdr says that it is -1, which no sample of type uint8 can be");
    CHECK(contains(said(8, "UNSIGNEDINT", "256"), "uint8"));
    CHECK(contains(said(8, "SIGNEDINT", "-9999"), "-9999, which no sample of type int8"));
    CHECK(contains(said(16, "UNSIGNEDINT", "-9999"), "uint16"));
    CHECK(contains(said(16, "SIGNEDINT", "65535"), "int16"));
    CHECK(contains(said(16, "SIGNEDINT", "2.5"), "int16"));
    CHECK(contains(said(32, "UNSIGNEDINT", "4294967296"), "uint32"));
    CHECK(contains(said(32, "SIGNEDINT", "-3.4e38"), "-3.4e38, which no sample of type int32"));
    CHECK(contains(said(32, "FLOAT", "-1e300"), "float32"));
    for (const std::string value : {"0", "200", "nan"}) {
        CHECK(said(32, "FLOAT", value).empty());
        CHECK(said(64, "FLOAT", value).empty());
        CHECK(said(8, "UNSIGNEDINT", value).empty() == (value != "nan"));
    }
    CHECK(said(64, "FLOAT", "-1e300").empty());
    CHECK(said(32, "FLOAT", "-3.402824e+38").empty()); // the lowest float in too few digits
    folder.samples<std::int8_t>("t.bil", {-1, 2, -3, 4});
    folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNODATA -9999\n"); // two sentences
    check_heights(demo::read_terrain(folder / "t.bil"), {-1, 2, -3, 4});
    CHECK(says(demo::read_terrain(folder / "t.bil"), "integers with a sign"));
    CHECK(says(demo::read_terrain(folder / "t.bil"), "which no sample of type int8 can be"));
}

TEST_CASE("touch_terrain bil: lines that begin with no known key are comments", "[touch_terrain]") {
    const Folder folder;
    folder.samples<std::int16_t>("t.bil", {1, 2, 3, 4});
    const std::string keys = "NROWS 2\nNCOLS 2\nNBITS 16\nPIXELTYPE SIGNEDINT\n";
    for (const std::string more :
         {"# made by hand\n# on a Monday\n", "STDV 1\nSTDV 2\n", "the end\nthe end\n"}) {
        CAPTURE(more);
        folder.text("t.hdr", more + keys);
        check_heights(demo::read_terrain(folder / "t.bil"), {1, 2, 3, 4});
        folder.text("t.hdr", keys + more);
        check_heights(demo::read_terrain(folder / "t.bil"), {1, 2, 3, 4});
    }
    std::string mac = keys;
    std::ranges::replace(mac, '\n', '\r');
    folder.text("t.hdr", mac);
    check_heights(demo::read_terrain(folder / "t.bil"), {1, 2, 3, 4});
    folder.text("t.hdr", "\xef\xbb\xbf" + keys);
    check_heights(demo::read_terrain(folder / "t.bil"), {1, 2, 3, 4});
    folder.text("t.hdr", "NROWS 2\r\n\r\nNCOLS 2\r\nNBITS x\r\n");
    CHECK(contains(refusal([&] { return demo::read_terrain(folder / "t.bil"); }), "t.hdr, line 4: NBITS"));
}

TEST_CASE("touch_terrain bil: keys that are not ESRI's but matter are named", "[touch_terrain]") {
    const Folder folder;
    folder.samples<std::int16_t>("t.bil", {1, 2, 3, 4});
    const auto read = [&] { return demo::read_terrain(folder / "t.bil"); };
    folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 16\nDataType FLOAT\n");
    CHECK(contains(refusal(read), "t.hdr, line 4: DataType is 'FLOAT'"));
    CHECK(contains(refusal(read), "PIXELTYPE"));
    folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 16\nDATATYPE FLOAT\nPIXELTYPE SIGNEDINT\n");
    check_heights(read(), {1, 2, 3, 4});
    folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 64\n");
    CHECK(contains(refusal(read), "no PIXELTYPE"));
    folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 16\nPIXELTYPE SIGNEDINT\nnodatavalue 3\n");
    check_heights(read(), {1, 2, hole, 4});
    CHECK(says(read(), "nodatavalue in t.hdr is meant as NODATA"));
    folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 16\nPIXELTYPE SIGNEDINT\nnodatavalue 3\nNODATA 4\n");
    check_heights(read(), {1, 2, 3, hole});
}

TEMPLATE_TEST_CASE("touch_terrain bil: samples in the other byte order are turned round", "[touch_terrain]",
                   std::uint16_t, std::int16_t, std::uint32_t, std::int32_t, float, double) {
    using S = TestType;
    const Folder folder;
    const std::string type = std::is_floating_point_v<S> ? "FLOAT"
                             : std::is_signed_v<S>       ? "SIGNEDINT"
                                                         : "UNSIGNEDINT";
    const S top = std::is_floating_point_v<S> ? S(0.5) : std::numeric_limits<S>::max();
    const std::string header = "NROWS 2\nNCOLS 2\nNODATA 258\nNBITS " + std::to_string(8 * sizeof(S)) +
                               "\nPIXELTYPE " + type + "\nBYTEORDER ";
    const std::vector<double> wanted{1, hole, 3, static_cast<double>(top)};
    folder.samples("t.bil", swapped<S>({S(1), S(258), S(3), top}));
    folder.text("t.hdr", header + other_order + "\n");
    check_heights(demo::read_terrain(folder / "t.bil"), wanted);
    // With bytes to skip and padded rows.
    folder.samples("t.bil", swapped<S>({S(7), S(1), S(258), S(7), S(3), top, S(7)}));
    folder.text("t.hdr", header + other_order + "\nSKIPBYTES " + std::to_string(sizeof(S)) +
                             "\nTOTALROWBYTES " + std::to_string(3 * sizeof(S)) + "\n");
    check_heights(demo::read_terrain(folder / "t.bil"), wanted);
    folder.samples<S>("t.bil", {S(1), S(258), S(3), top});
    folder.text("t.hdr", header + (other_order[0] == 'M' ? "I" : "M") + "\n");
    check_heights(demo::read_terrain(folder / "t.bil"), wanted);
}

TEST_CASE("touch_terrain flt: samples in the other byte order are turned round", "[touch_terrain]") {
    const Folder folder;
    folder.samples("t.flt", swapped<float>({1.5f, -9999, -0.25f, 4}));
    folder.text("t.hdr", std::string{"ncols 2\nnrows 2\ncellsize 1\nNODATA_value -9999\nbyteorder "} +
                             (other_order[0] == 'M' ? "MSBFIRST" : "LSBFIRST") + "\n");
    check_heights(demo::read_terrain(folder / "t.flt"), {1.5, hole, -0.25, 4});
}

TEST_CASE("touch_terrain bil: the header may be called t.bil.hdr, ENVI's is read by GDAL or refused",
          "[touch_terrain]") {
    const Folder folder;
    folder.samples<std::int16_t>("t.bil", {1, 2, 3, 4});
    folder.text("t.bil.hdr", "NROWS 2\nNCOLS 2\nNBITS 16\nPIXELTYPE SIGNEDINT\n");
    check_heights(demo::read_terrain(folder / "t.bil"), {1, 2, 3, 4});
    fs::remove(folder / "t.bil.hdr");
    for (const std::string name : {"t.bil.hdr", "t.hdr"}) {
        folder.text(name, "ENVI\nsamples = 2\nlines = 2\nbands = 1\nheader offset = 0\ndata type = 2\n"
                          "interleave = bil\nbyte order = 0\n");
#ifdef TOUCH_TERRAIN_HAS_GDAL
        if (std::endian::native == std::endian::little)
            check_heights(demo::read_terrain(folder / "t.bil"), {1, 2, 3, 4});
#else
        CHECK(contains(refusal([&] { return demo::read_terrain(folder / "t.bil"); }), "ENVI"));
#endif
        fs::remove(folder / name);
    }
}

TEST_CASE("touch_terrain units: by every name that files give them", "[touch_terrain]") {
    CHECK(demo::metres_in("m") == 1);
    CHECK(demo::metres_in("Metres") == 1);
    CHECK(demo::metres_in("METERS") == 1);
    CHECK(demo::metres_in("mm") == 1e-3);
    CHECK(demo::metres_in("km") == 1e3);
    CHECK(demo::metres_in("µm") == 1e-6);
    CHECK(demo::metres_in("ft") == 0.3048);
    CHECK(demo::metres_in("feet") == 0.3048);
    CHECK(demo::metres_in("Foot (International)") == std::nullopt);
    CHECK(demo::metres_in("foot_intl") == 0.3048);
    CHECK(demo::metres_in("US survey foot") == 1200.0 / 3937);
    CHECK(demo::metres_in("us-ft") == 1200.0 / 3937);
    CHECK(demo::metres_in("Foot_US") == 1200.0 / 3937);
    CHECK(demo::metres_in("inches") == 0.0254);
    for (const std::string none : {"", "K", "degC", "s", "m2", "0.1 m", "m/s", "parsec"}) {
        CAPTURE(none);
        CHECK(demo::metres_in(none) == std::nullopt);
    }
}

TEST_CASE("touch_terrain map: the units of a .prj in every form", "[touch_terrain]") {
    const auto units = [](const std::string& text) {
        const auto read = demo::read_map_units(text);
        REQUIRE(read);
        return *read;
    };
    CHECK(units(wgs84).angular);
    CHECK(units(wgs84).size == Approx(3.14159265358979 / 180));
    CHECK(units(wgs84).semi_major == 6378137);
    CHECK_FALSE(units(wgs84).height);
    CHECK_FALSE(units(state_plane("\"Meter\",1.0")).angular);
    CHECK(units(state_plane("\"Meter\",1.0")).size == 1);
    CHECK(units(state_plane("\"Foot_US\",0.3048006096012192")).size == Approx(1200.0 / 3937));
    CHECK(units(wgs84 + R"(,VERTCS["x",VDATUM["x"],PARAMETER["Vertical_Shift",0.0],UNIT["Foot",0.3048]])")
              .height == 0.3048);
    CHECK(units(R"(COMPD_CS["x",)" + state_plane("\"km\",1000") +
                R"(,VERT_CS["h",VERT_DATUM["h",2005],UNIT["m",1]]])")
              .size == 1000);
    CHECK(units(R"(GEOGCRS["WGS 84",DATUM["x",ELLIPSOID["y",6378137,298.25,LENGTHUNIT["metre",1]]],)"
                R"(CS[ellipsoidal,2],AXIS["lat",north,ORDER[1],ANGLEUNIT["degree",0.0174532925199433]],)"
                R"(AXIS["lon",east,ORDER[2],ANGLEUNIT["degree",0.0174532925199433]],ID["EPSG",4326]])")
              .angular);
    CHECK(units(R"(PROJCRS["x",BASEGEOGCRS["y",DATUM["x",ELLIPSOID["y",1,2]]],CONVERSION["z",METHOD["m"],)"
                R"(PARAMETER["Scale",0.9,SCALEUNIT["unity",1]]],CS[Cartesian,2],AXIS["e",east,ORDER[1]],)"
                R"(AXIS["n",north,ORDER[2]],LENGTHUNIT["US survey foot",0.304800609601219]])")
              .size == Approx(1200.0 / 3937));
    CHECK(units("Projection    GEOGRAPHIC\nDatum WGS84\nZunits METERS\nUnits DD\n").angular);
    CHECK(units("Projection    GEOGRAPHIC\r\nZunits FEET\r\nUnits DS\r\n").height == 0.3048);
    CHECK(units("Projection GEOGRAPHIC\nUnits DS\n").size == Approx(3.14159265358979 / 180 / 3600));
    CHECK_FALSE(units("Projection UTM\nZone 13\nUnits METERS\n").angular);
    for (const std::string none :
         {"", "EPSG:4326", "GEOGCS[", "PROJCS[\"x\"]", "PROJCS[\"x\",UNIT[\"m\"]]",
          "GEOGCS[\"x\",UNIT[\"Degree\",-1]]", "Projection UTM\n", "]", "a]b", "a[b]c"}) {
        CAPTURE(none);
        CHECK_FALSE(demo::read_map_units(none));
    }
    std::string deep;
    for (int k = 0; k < 100000; ++k) deep += "A[";
    CHECK_FALSE(demo::read_map_units(deep));
}

TEST_CASE("touch_terrain map: degrees become metres at the middle latitude", "[touch_terrain]") {
    // Lengths of a degree on WGS 84: at the equator 111,319.5 m east and 110,574.3 m north; at 45° 78,846.8 and 111,131.8;
    // at 60° 55,800.0 and 111,412.2.
    demo::MapUnits degrees;
    degrees.angular = true;
    degrees.size = std::numbers::pi / 180;
    const auto at = [&](double south, double north, std::vector<std::string>* assumed = nullptr) {
        std::vector<std::string> said;
        const auto metres = demo::spacing_on_map(degrees, {{1, 1}, south, north}, "t", said);
        REQUIRE(said.size() == 1);
        CHECK(contains(said[0], "--spacing"));
        if (assumed != nullptr) *assumed = said;
        return metres;
    };
    CHECK(at(0, 0).x == Approx(111319.5).epsilon(1e-6));
    CHECK(at(0, 0).y == Approx(110574.3).epsilon(1e-6));
    CHECK(at(44, 46).x == Approx(78846.8).epsilon(1e-6));
    CHECK(at(44, 46).y == Approx(111131.8).epsilon(1e-6));
    CHECK(at(-60, -60).x == Approx(55800.0).epsilon(1e-6));
    CHECK(at(-60, -60).y == Approx(111412.2).epsilon(1e-6));
    // The whole globe, and where it is wide and narrow.
    std::vector<std::string> assumed;
    CHECK(at(-90, 90, &assumed).x == Approx(111319.5).epsilon(1e-6));
    CHECK(contains(assumed[0], "north rim"));
    CHECK(at(45, 45.01, &assumed).x == Approx(78840).epsilon(1e-4));
    CHECK_FALSE(contains(assumed[0], "rim"));
    for (const auto& rims : {std::pair{89.0, 91.0}, {100.0, 110.0}, {-400.0, 400.0}, {-91.0, -89.0}}) {
        const double south = rims.first, north = rims.second;
        CAPTURE(south, north);
        CHECK(contains(refusal([&] { return at(south, north); }), "--spacing"));
    }
}

TEST_CASE("touch_terrain map: Mercator metres become metres on the ground", "[touch_terrain]") {
    // At 60° Web Mercator has y = 8,399,737.89 and lengths twice as long, World Mercator, of the ellipsoid, y = 8,362,698.55
    // and lengths 1/0.501260 times as long (PROJ).
    const std::string parameters =
        R"(PARAMETER["False_Easting",0.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",0.0])";
    const auto projected = [&](const std::string& projection, const std::string& unit = R"("Meter",1.0)") {
        return R"(PROJCS["x",)" + wgs84 + ",PROJECTION[\"" + projection + "\"]," + parameters + ",UNIT[" +
               unit + "]]";
    };
    const auto at = [&](const std::string& map, double y, std::vector<std::string>* assumed = nullptr) {
        const auto units = demo::read_map_units(map);
        REQUIRE(units);
        std::vector<std::string> said;
        const auto metres = demo::spacing_on_map(*units, {{10, 20}, y, y}, "t", said);
        if (assumed != nullptr) *assumed = said;
        return metres;
    };
    const double web = 8399737.88981836, world = 8362698.54850075;
    std::vector<std::string> assumed;
    for (
        const std::string& map :
        {projected("Mercator_Auxiliary_Sphere"), projected("Popular_Visualisation_Pseudo_Mercator"),
         with_extension(projected("Mercator_1SP")), with_extension(projected("Mercator_2SP")),
         std::string{
             R"(PROJCRS["WGS 84 / Pseudo-Mercator",BASEGEOGCRS["WGS 84",DATUM["W",ELLIPSOID["WGS 84",6378137,)"
             R"(298.257223563,LENGTHUNIT["metre",1]]]],CONVERSION["Popular Visualisation Pseudo-Mercator",)"
             R"(METHOD["Popular Visualisation Pseudo Mercator",ID["EPSG",1024]],PARAMETER["False northing",0,)"
             R"(LENGTHUNIT["metre",1],ID["EPSG",8807]]],CS[Cartesian,2],AXIS["E",east,ORDER[1],)"
             R"(LENGTHUNIT["metre",1]],AXIS["N",north,ORDER[2],LENGTHUNIT["metre",1]],ID["EPSG",3857]])"},
         // The sphere itself (ESRI's 102113).
         std::string{
             R"(PROJCS["WGS_1984_Web_Mercator",GEOGCS["GCS_Sphere",DATUM["D",SPHEROID["S",6378137.0,0.0]],)"
             R"(PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Mercator"],)"
             R"(PARAMETER["Standard_Parallel_1",0.0],UNIT["Meter",1.0]])"}}) {
        CAPTURE(map);
        CHECK(at(map, web, &assumed).x == Approx(5).epsilon(1e-9));
        CHECK(at(map, -web).y == Approx(10).epsilon(1e-9));
        REQUIRE(assumed.size() == 1);
        CHECK(contains(assumed[0], "Mercator metres"));
        CHECK(contains(assumed[0], "latitude, 60 "));
        CHECK(contains(assumed[0], "--spacing"));
        CHECK(at(map, 0).x == 10);
        CHECK(contains(refusal([&] { return at(map, 1e9); }), "--spacing"));
    }
    CHECK(at(projected("Mercator"), world, &assumed).x == Approx(5.01260).epsilon(1e-5));
    CHECK(contains(assumed[0], "latitude, 60 "));
    CHECK(at(projected("Mercator", R"("Foot_US",0.3048006096012192)"), world / 0.3048006096012192).y ==
          Approx(0.3048006096012192 * 10.0252).epsilon(1e-5));
    // True at 45° and shifted by 1000 m: PROJ has 60° at 5,924,242.27.
    const std::string shifted = R"(PROJCS["x",)" + wgs84 +
                                R"(,PROJECTION["Mercator_2SP"],PARAMETER["standard_parallel_1",45],)"
                                R"(PARAMETER["false_northing",1000],UNIT["metre",1]])";
    CHECK(at(shifted, 5924242.27047337, &assumed).x == Approx(10 * 55.8000 / 78.8468).epsilon(1e-5));
    CHECK(contains(assumed[0], "latitude, 60 "));
    // The other maps on which all parallels are as long as the equator; the sphere is right to 1 %.
    CHECK(at(projected("Plate_Carree"), 6679169.4476, &assumed).x == Approx(5).epsilon(1e-6));
    CHECK(contains(assumed[0], "equidistant cylindrical metres"));
    CHECK(at(projected("Plate_Carree"), 6679169.4476).y == 20);
    const auto equal_area =
        at(R"(PROJCS["x",)" + wgs84 +
               R"(,PROJECTION["Cylindrical_Equal_Area"],PARAMETER["standard_parallel_1",30],)"
               R"(UNIT["metre",1]])",
           6351419.9973);
    CHECK(equal_area.x == Approx(10 * 55.800 / 96.4865).epsilon(0.012));
    CHECK(equal_area.y == Approx(20 * 111.4122 / 64.4313).epsilon(0.012));
    // Transverse and conic maps are as long as the ground to a few in a thousand.
    CHECK(at(state_plane(R"("Meter",1.0)"), web, &assumed) == glm::dvec2{10, 20});
    CHECK(assumed.empty());
}

TEST_CASE("touch_terrain bil: depths of the vertical system lie below", "[touch_terrain]") {
    const Folder folder;
    folder.samples<std::int16_t>("t.bil", {1, 2, 3, 4});
    folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 16\nPIXELTYPE SIGNEDINT\nXDIM 1\nYDIM 1\n");
    const std::string metre = R"(UNIT["Meter",1.0])", map = state_plane(R"("Meter",1.0)");
    for (const std::string& vertical :
         {R"(,VERTCS["MSL_Depth",VDATUM["x"],PARAMETER["Vertical_Shift",0.0],PARAMETER["Direction",-1.0],)" +
              metre + "]",
          R"(,VERT_CS["x",VERT_DATUM["x",2005],)" + metre + R"(,AXIS["Depth",DOWN]])"}) {
        CAPTURE(vertical);
        folder.text("t.prj", map + vertical);
        const auto terrain = demo::read_terrain(folder / "t.bil");
        check_heights(terrain, {-1, -2, -3, -4});
        CHECK(says(terrain, "samples are depths"));
        check_heights(demo::read_terrain(folder / "t.bil", {.unit = 0.5}), {-0.5, -1, -1.5, -2});
    }
    folder.text("t.prj", map + R"(,VERTCS["x",VDATUM["x"],PARAMETER["Direction",1.0],)" + metre + "]");
    check_heights(demo::read_terrain(folder / "t.bil"), {1, 2, 3, 4});
    folder.text("t.prj", map + R"(,VERT_CS["x",VERT_DATUM["x",2005],)" + metre + R"(,AXIS["Up",UP]])");
    check_heights(demo::read_terrain(folder / "t.bil"), {1, 2, 3, 4});
}

TEST_CASE("touch_terrain bil: a .prj says what the spacing is in", "[touch_terrain]") {
    const Folder folder;
    folder.samples<std::int16_t>("t.bil", {1, 2, 3, 4, 5, 6, 7, 8, 9});
    const std::string header = "NROWS 3\nNCOLS 3\nNBITS 16\nPIXELTYPE SIGNEDINT\n";
    const auto read = [&](const demo::ReadOptions& options = {}) {
        return demo::read_terrain(folder / "t.bil", options);
    };
    folder.text("t.hdr", header + "XDIM 0.001\nYDIM 0.001\nULXMAP 7\nULYMAP 45.001\n");
    SECTION("none: metres, and it says so") {
        CHECK(read().spacing == glm::dvec2{0.001});
        CHECK(says(read(), "spacing in t.hdr is in metres"));
        CHECK(read({.unit = 1e3}).spacing == glm::dvec2{1.0});
        CHECK_FALSE(says(read({.unit = 1e3}), "metres"));
    }
    SECTION("degrees, whatever the header's way of saying where it lies") {
        folder.text(GENERATE("t.prj", "t.PRJ"), wgs84 + "\r\n");
        for (const std::string place :
             {"XDIM 0.001\nYDIM 0.001\nULYMAP 45.001\n", "CELLSIZE 0.001\nYLLCORNER 44.9985\n",
              "cellsize 0.001\nyllcenter 44.999\n"}) {
            CAPTURE(place);
            folder.text("t.hdr", header + place);
            const auto terrain = read();
            REQUIRE(terrain.spacing);
            CHECK(terrain.spacing->x == Approx(78.8468).epsilon(1e-6));
            CHECK(terrain.spacing->y == Approx(111.1318).epsilon(1e-6));
            CHECK(says(terrain, "middle latitude, 45 "));
            CHECK(says(terrain, "heights are in metres"));
        }
        CHECK(read({.spacing = glm::dvec2{7, 8}}).spacing == glm::dvec2{7, 8});
        CHECK_FALSE(says(read({.spacing = glm::dvec2{7, 8}}), "latitude"));
        folder.text("t.hdr", header + "CELLSIZE 0.001\n");
        CHECK(contains(refusal(read), "--spacing"));
        CHECK(contains(refusal(read), "ULYMAP"));
        CHECK(read({.spacing = glm::dvec2{7, 8}}).spacing == glm::dvec2{7, 8});
    }
    SECTION("feet; --unit is for the heights alone then") {
        folder.text("t.prj", state_plane("\"Foot_US\",0.3048006096012192"));
        CHECK(read().spacing->x == Approx(0.001 * 1200 / 3937));
        CHECK(read({.unit = 0.3048}).spacing->x == Approx(0.001 * 1200 / 3937));
        check_heights(read({.unit = 0.5}), {0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5});
    }
    SECTION("heights as well") {
        folder.text("t.prj", "Projection GEOGRAPHIC\nZunits FEET\nUnits DD\n");
        CHECK(height(read(), 0, 2) == 0.3048);
        CHECK_FALSE(says(read(), "heights"));
        CHECK(height(read({.unit = 1.0}), 0, 2) == 1);
    }
    SECTION("Web Mercator, whose metres are not those of the ground") {
        const std::string mercator = R"(PROJCS["WGS_1984_Web_Mercator_Auxiliary_Sphere",)" + wgs84 +
                                     R"(,PROJECTION["Mercator_Auxiliary_Sphere"],UNIT["Meter",1.0]])";
        folder.text("t.prj", mercator);
        folder.text("t.hdr", header + "XDIM 30\nYDIM 30\nULYMAP 8399767.88981836\n");
        CHECK(read().spacing->x == Approx(15).epsilon(1e-9));
        CHECK(read().spacing->y == Approx(15).epsilon(1e-9));
        CHECK(
            says(read(), "Mercator metres are turned into those on the ground at the middle latitude, 60 "));
        CHECK(read({.spacing = glm::dvec2{7, 8}}).spacing == glm::dvec2{7, 8});
        CHECK_FALSE(says(read({.spacing = glm::dvec2{7, 8}}), "Mercator"));
        folder.text("t.hdr", header + "CELLSIZE 30\n");
        CHECK(contains(refusal(read), "--spacing"));
        CHECK(contains(refusal(read), "ULYMAP"));
        folder.text("t.prj", "Projection MERCATOR\nUnits METERS\nParameters\n");
        CHECK(contains(refusal(read), "--spacing"));
    }
    SECTION("something that is not understood: refused, unless --spacing says it") {
        folder.text("t.prj", "EPSG:4326");
        CHECK(contains(refusal(read), "--spacing"));
        CHECK(contains(refusal(read), "EPSG:4326"));
        CHECK(read({.spacing = glm::dvec2{7, 8}}).spacing == glm::dvec2{7, 8});
    }
    SECTION("an empty one: as none") {
        folder.text("t.prj", "\r\n \n");
        CHECK(read().spacing == glm::dvec2{0.001});
    }
}

TEST_CASE("touch_terrain png: alpha that says nothing leaves the heights to grey", "[touch_terrain]") {
    const Folder folder;
    const int bits = GENERATE(8, 16);
    const int top = bits == 8 ? 255 : 65535;
    const auto read = [&](const std::string& channel = "") {
        return demo::read_terrain(folder / "t.png", {.channel = channel});
    };
    const auto grey_alpha = [&](const std::vector<int>& values) {
        write_png(folder / "t.png", 2, 2, bits, PNG_COLOR_TYPE_GRAY_ALPHA, values);
    };
    const auto rgba = [&](const std::vector<int>& values) {
        write_png(folder / "t.png", 2, 2, bits, PNG_COLOR_TYPE_RGBA, values);
    };
    grey_alpha({1, top, 2, top, 3, top, 4, top});
    check_heights(read(), {1, 2, 3, 4});
    CHECK(says(read(), "grey channel, for alpha is " + std::to_string(top) + " everywhere (see --channel)"));
    check_heights(read("alpha"), std::vector<double>(4, top));
    check_heights(read("2"), std::vector<double>(4, top));
    check_heights(read("grey"), {1, 2, 3, 4});
    CHECK_FALSE(says(read("grey"), "channel"));
    CHECK(contains(refusal([&] { return read("red"); }), "has grey and alpha"));
    CHECK(contains(refusal([&] { return read("3"); }), "has grey and alpha"));

    grey_alpha({1, 0, 2, 0, 3, 0, 4, 0}); // all of it transparent: as good as all opaque
    check_heights(read(), {1, 2, 3, 4});
    grey_alpha({1, 7, 2, 8, 3, 9, 4, 10});
    check_heights(read(), {7, 8, 9, 10});
    CHECK(says(read(), "alpha channel (see --channel)"));
    grey_alpha({1, top, 2, 0, 3, top, 4, top}); // a mask
    check_heights(read(), {1, hole, 3, 4});
    CHECK(says(read(), "marks holes"));
    check_heights(read("alpha"), {1.0 * top, 0, 1.0 * top, 1.0 * top});

    rgba({1, 1, 1, 9, 2, 2, 2, 9, 3, 3, 3, 9, 4, 4, 4, 9});
    check_heights(read(), {1, 2, 3, 4});
    rgba({1, 1, 1, 0, 2, 2, 2, top, 3, 3, 3, top, 4, 4, 4, top});
    check_heights(read(), {hole, 2, 3, 4});
    rgba({1, 5, 1, 9, 2, 2, 2, 9, 3, 3, 3, 9, 4, 4, 4, 9});
    CHECK(contains(refusal([&] { return read(); }), "--channel"));
    CHECK(contains(refusal([&] { return read(); }), "--encoding"));
    check_heights(read("green"), {5, 2, 3, 4});
    check_heights(read("1"), {1, 2, 3, 4});
}

TEST_CASE("touch_terrain png: what tRNS makes transparent is a hole", "[touch_terrain]") {
    const Folder folder;
    for (const int bits : {8, 16}) {
        CAPTURE(bits);
        write_png(folder / "t.png", 2, 2, bits, PNG_COLOR_TYPE_GRAY, {1, 50, 3, 200});
        insert_chunk(folder / "t.png", "tRNS", std::string{"\0\x32", 2});
        check_heights(demo::read_terrain(folder / "t.png"), {1, hole, 3, 200});
        write_png(folder / "rgb.png", 2, 2, bits, PNG_COLOR_TYPE_RGB, {1, 2, 3, 4, 5, 6, 1, 2, 9, 4, 5, 7});
        insert_chunk(folder / "rgb.png", "tRNS", std::string{"\0\x04\0\x05\0\x06", 6});
        check_heights(demo::read_terrain(folder / "rgb.png", {.channel = "red"}), {1, hole, 1, 4});
    }
}

TEST_CASE("touch_terrain png: heights packed into red, green and blue", "[touch_terrain]") {
    const Folder folder;
    // Terrarium: 128·256 + 0 + 0/256 − 32768 = 0. Terrain-RGB: (1·65536 + 134·256 + 160)/10 − 10000 = 0.
    const auto read = [&](demo::Encoding encoding) {
        return demo::read_terrain(folder / "t.png", {.encoding = encoding});
    };
    write_png(folder / "t.png", 2, 2, 8, PNG_COLOR_TYPE_RGB,
              {128, 0, 0, 0, 0, 0, 144, 30, 128, 255, 255, 255});
    check_heights(read(demo::Encoding::terrarium), {0, -32768, 4126.5, 32768 - 1.0 / 256});
    CHECK_FALSE(says(read(demo::Encoding::terrarium), "heights"));
    write_png(folder / "t.png", 2, 2, 8, PNG_COLOR_TYPE_RGB, {1, 134, 160, 0, 0, 0, 2, 9, 50, 255, 255, 255});
    check_heights(read(demo::Encoding::mapbox), {0, -10000, 3342.6, 1667721.5});
    write_png(folder / "t.png", 2, 2, 8, PNG_COLOR_TYPE_RGBA,
              {128, 0, 0, 255, 0, 0, 0, 0, 144, 30, 128, 255, 128, 1, 0, 255});
    check_heights(read(demo::Encoding::terrarium), {0, hole, 4126.5, 1});
    write_png(folder / "t.png", 2, 2, 8, PNG_COLOR_TYPE_PALETTE, {0, 0, 0, 0}); // its colour is 10, 20, 30
    check_heights(read(demo::Encoding::terrarium), std::vector<double>(4, 2560 + 20 + 30 / 256.0 - 32768));
    write_png(folder / "t.png", 2, 2, 16, PNG_COLOR_TYPE_RGB, std::vector<int>(12, 0));
    CHECK(contains(refusal([&] { return read(demo::Encoding::mapbox); }), "--encoding"));
    write_png(folder / "t.png", 2, 2, 8, PNG_COLOR_TYPE_GRAY, std::vector<int>(4, 0));
    CHECK(contains(refusal([&] { return read(demo::Encoding::mapbox); }), "--encoding"));
}

TEST_CASE("touch_terrain: --unit, --channel and --encoding say what a file does not", "[touch_terrain]") {
    const Folder folder;
    folder.samples<std::int16_t>("t.bil", {0, 100, 200, 0, 100, 200, 0, 100, 200});
    folder.text("t.hdr", "NROWS 3\nNCOLS 3\nNBITS 16\nPIXELTYPE SIGNEDINT\nXDIM 1.9\nYDIM 1.9\n");
    const Run as_metres = folder.run("t.bil"), as_mm = folder.run("t.bil --unit mm");
    CHECK(contains(as_metres.out, "every 1.9 x 1.9 m"));
    CHECK(contains(as_metres.out, "\nassumed         heights are in metres (see --unit)\n"));
    CHECK(contains(as_mm.out, "every 0.0019 x 0.0019 m"));
    CHECK_FALSE(contains(as_mm.out, "assumed"));
    // Felt as such: 100 mm above the middle.
    folder.text("p.csv", "t,x,y,z\n0,0.0019,0.0019,0.2\n1,0.0019,0.0019,0.0999\n");
    CHECK(contains(folder.run("t.bil --unit mm --path p.csv").out, "in contact      50.0 %"));
    CHECK(contains(folder.run("t.bil --unit mm --spacing 5 --path p.csv").out, "every 5 x 5 m"));
    write_png(folder / "t.png", 2, 2, 8, PNG_COLOR_TYPE_GRAY, {0, 0, 0, 0});
    CHECK(contains(folder.run("t.png --unit cm").out, "every 0.01 x 0.01 m, which the file does not say"));
    write_png(folder / "t.png", 2, 2, 8, PNG_COLOR_TYPE_RGB, std::vector<int>(12, 100));
    CHECK(folder.run("t.png --encoding terrarium").code == 0);
    CHECK(folder.run("t.png --channel blue").code == 0);
    for (const auto& [arguments, word] :
         {std::pair<std::string, std::string>{"t.bil --unit parsec", "--unit is 'parsec'"},
          {"t.bil --unit ''", "--unit is ''"},
          {"t.png --channel cyan", "--channel is 'cyan'"},
          {"t.png --channel 0", "--channel is '0'"},
          {"t.png --encoding rgb", "--encoding is 'rgb'"},
          {"t.png --encoding mapbox --channel red", "--channel and --encoding"},
          {"t.bil --channel 2", "--channel"},
          {"t.bil --encoding mapbox", "--encoding"}}) {
        CAPTURE(arguments);
        const Run run = folder.run(arguments);
        CHECK(run.code == 2);
        CHECK(contains(run.err, word));
    }
}

TEST_CASE("touch_terrain: nothing is open about the bundled terrain", "[touch_terrain]") {
    const Folder folder;
    CHECK_FALSE(contains(folder.run("").out, "assumed"));
}
