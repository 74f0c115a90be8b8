#include "catch.hpp"
#include "support/skip.hpp"
#include "touch_terrain_files.hpp"

#include <bad_input.hpp>
#include <terrain.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

// What GDAL knows of a raster is used. The rasters are GDAL's virtual ones, text that says how raw samples are meant, and a
// netCDF file written here byte by byte.

#ifdef TOUCH_TERRAIN_HAS_GDAL

using namespace touch_terrain_tests;

namespace {

constexpr double hole = std::numeric_limits<double>::quiet_NaN();

/// All heights in metres, north row first; NaN in holes.
std::vector<double> heights_of(const demo::Terrain& terrain) {
    return std::visit(
        [&](const auto& heights) {
            std::vector<double> all;
            for (hfh::Index j = heights.rows(); j-- > 0;) {
                for (hfh::Index i = 0; i < heights.columns(); ++i) {
                    const auto sample = heights(i, j);
                    all.push_back(heights.missing(sample)
                                      ? hole
                                      : terrain.height_offset +
                                            terrain.height_scale * static_cast<double>(sample));
                }
            }
            return all;
        },
        terrain.heights);
}

void check_heights(const demo::Terrain& terrain, const std::vector<double>& wanted) {
    const auto got = heights_of(terrain);
    REQUIRE(got.size() == wanted.size());
    for (std::size_t k = 0; k < got.size(); ++k) {
        CAPTURE(k, got[k], wanted[k]);
        CHECK((std::isnan(wanted[k]) ? std::isnan(got[k]) : got[k] == Approx(wanted[k]).epsilon(1e-9)));
    }
}

bool says(const demo::Terrain& terrain, const std::string& words) {
    return std::ranges::any_of(terrain.assumed, [&](const std::string& sentence) {
        return sentence.find(words) != std::string::npos;
    });
}

std::string refusal(const fs::path& file, const demo::ReadOptions& options = {}) {
    try {
        (void)demo::read_terrain(file, options);
    } catch (const demo::BadInput& bad) {
        return bad.what();
    }
    return {};
}

bool contains(const std::string& text, const std::string& words) {
    return text.find(words) != std::string::npos;
}

template <class S>
std::string type_name() {
    if constexpr (std::is_same_v<S, float>)
        return "Float32";
    else if constexpr (std::is_same_v<S, double>)
        return "Float64";
    else if constexpr (sizeof(S) == 1)
        return "Byte";
    else
        return (std::is_signed_v<S> ? "Int" : "UInt") + std::to_string(8 * sizeof(S));
}

/// A band of 2 × 2 samples in a file of its own, `more` as a virtual raster has it.
template <class S>
std::string band(const Folder& folder, int number, const std::vector<S>& samples,
                 const std::string& more = "", const std::string& attributes = "") {
    const std::string file = "band" + std::to_string(number) + ".raw";
    folder.samples(file, samples);
    const std::string bytes = std::to_string(sizeof(S));
    return "<VRTRasterBand dataType=\"" + type_name<S>() + "\" band=\"" + std::to_string(number) +
           "\" subClass=\"VRTRawRasterBand\"" + attributes + ">" + more +
           "<SourceFilename relativetoVRT=\"1\">" + file +
           "</SourceFilename><ImageOffset>0</ImageOffset><PixelOffset>" + bytes +
           "</PixelOffset><LineOffset>" + std::to_string(2 * sizeof(S)) + "</LineOffset><ByteOrder>" +
           (std::endian::native == std::endian::little ? "LSB" : "MSB") + "</ByteOrder></VRTRasterBand>";
}

fs::path raster(const Folder& folder, const std::string& inside) {
    return folder.text("t.vrt",
                       "<VRTDataset rasterXSize=\"2\" rasterYSize=\"2\">" + inside + "</VRTDataset>");
}

std::string lies(const std::string& transform, const std::string& map = "") {
    return (map.empty() ? "" : "<SRS>" + map + "</SRS>") + "<GeoTransform>" + transform + "</GeoTransform>";
}

const std::vector<std::int16_t> four{150, 2, 3, 4};

/// A netCDF file of the classic format: variables of 2 × 2 shorts, the first row the southern one.
std::string netcdf(const std::vector<std::string>& names) {
    std::string out{"CDF\1", 4};
    const auto number = [&](std::uint32_t value) {
        for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift & 0xff);
    };
    const auto name = [&](const std::string& text) {
        number(static_cast<std::uint32_t>(text.size()));
        out += text + std::string((4 - text.size() % 4) % 4, '\0');
    };
    const auto none = [&] { number(0), number(0); };
    number(0); // records
    number(10), number(2);
    name("y"), number(2), name("x"), number(2);
    none(); // attributes of the file
    number(11), number(static_cast<std::uint32_t>(names.size()));
    const auto variables = [&](std::size_t data) {
        for (std::size_t k = 0; k < names.size(); ++k) {
            name(names[k]);
            number(2), number(0), number(1); // its dimensions
            number(12), number(1), name("scale_factor"), number(5), number(1), number(0x3f000000); // 0.5
            number(3), number(8), number(static_cast<std::uint32_t>(data + 8 * k)); // shorts, bytes, where
        }
    };
    const std::string before = out;
    variables(0);
    const std::size_t data = out.size();
    out = before;
    variables(data);
    for (std::size_t k = 0; k < names.size(); ++k) out += {0, 6, 0, 8, 0, 2, 0, 4};
    return out;
}

} // namespace

TEST_CASE("touch_terrain gdal: scale, offset and unit of the heights", "[touch_terrain][gdal]") {
    const Folder folder;
    const std::string packed = "<Scale>0.1</Scale><Offset>1000</Offset>";
    check_heights(demo::read_terrain(raster(folder, band(folder, 1, four, packed))),
                  {1015, 1000.2, 1000.3, 1000.4});
    for (const auto& [unit, metres] : {std::pair<std::string, double>{"m", 1},
                                       {"metre", 1},
                                       {"ft", 0.3048},
                                       {"US survey foot", 1200.0 / 3937},
                                       {"km", 1000},
                                       {"cm", 0.01}}) {
        CAPTURE(unit);
        const auto terrain = demo::read_terrain(
            raster(folder, band(folder, 1, four, "<UnitType>" + unit + "</UnitType>" + packed)));
        check_heights(terrain, {1015 * metres, 1000.2 * metres, 1000.3 * metres, 1000.4 * metres});
        CHECK_FALSE(says(terrain, "heights"));
    }
    const auto file = raster(folder, band(folder, 1, four, "<UnitType>kelvin</UnitType>"));
    CHECK(says(demo::read_terrain(file), "'kelvin'"));
    check_heights(demo::read_terrain(file, {.unit = 0.01}), {1.5, 0.02, 0.03, 0.04});
    CHECK_FALSE(says(demo::read_terrain(file, {.unit = 0.01}), "heights"));
    CHECK(says(demo::read_terrain(raster(folder, band(folder, 1, four))), "heights are in metres"));
    CHECK(contains(refusal(raster(folder, band(folder, 1, four, "<Scale>0</Scale>"))), "factor"));
    // "No data" is said of the samples, not of the heights.
    check_heights(
        demo::read_terrain(raster(folder, band(folder, 1, four, "<NoDataValue>2</NoDataValue>" + packed))),
        {1015, hole, 1000.3, 1000.4});
}

TEST_CASE("touch_terrain gdal: holes of every kind", "[touch_terrain][gdal]") {
    const Folder folder;
    const auto read = [&](const std::string& inside) { return demo::read_terrain(raster(folder, inside)); };
    const auto no_data = [](const std::string& value) { return "<NoDataValue>" + value + "</NoDataValue>"; };
    check_heights(read(band<std::uint8_t>(folder, 1, {255, 2, 3, 4}, no_data("255"))), {hole, 2, 3, 4});
    check_heights(read(band<std::uint8_t>(folder, 1, {241, 2, 3, 4}, no_data("-9999"))), {241, 2, 3, 4});
    check_heights(read(band<std::uint16_t>(folder, 1, {65535, 2, 3, 4}, no_data("65535"))), {hole, 2, 3, 4});
    check_heights(
        read(band<std::uint32_t>(folder, 1, {4294967295u, 2, 3, 4000000000u}, no_data("4294967295"))),
        {hole, 2, 3, 4e9});
    check_heights(
        read(band<std::int32_t>(folder, 1, {-2147483647 - 1, 2, 3, 16777217}, no_data("-2147483648"))),
        {hole, 2, 3, 16777217});
    const float lowest = std::numeric_limits<float>::lowest(), nan = std::numeric_limits<float>::quiet_NaN();
    check_heights(read(band<float>(folder, 1, {lowest, 2, 3, nan}, no_data("-3.4028234663852886e+38"))),
                  {hole, 2, 3, hole});
    check_heights(read(band<float>(folder, 1, {lowest, 2, 3, 4}, no_data("-3.40282347e+38"))),
                  {hole, 2, 3, 4});
    check_heights(read(band<float>(folder, 1, {0.1f, 2, 3, 4}, no_data("0.1"))), {hole, 2, 3, 4});
    check_heights(read(band<double>(folder, 1, {-1e300, 2, static_cast<double>(nan), 4}, no_data("nan"))),
                  {-1e300, 2, hole, 4});

    const std::string alpha = "<ColorInterp>Alpha</ColorInterp>", grey = "<ColorInterp>Gray</ColorInterp>";
    const auto with_alpha = read(band<std::uint8_t>(folder, 1, {1, 2, 3, 4}, grey) +
                                 band<std::uint8_t>(folder, 2, {255, 0, 1, 255}, alpha));
    check_heights(with_alpha, {1, hole, 3, 4});
    CHECK(says(with_alpha, "not alpha (see --channel)"));
    check_heights(demo::read_terrain(folder / "t.vrt", {.channel = "alpha"}), {255, 0, 1, 255});
    check_heights(demo::read_terrain(folder / "t.vrt", {.channel = "2"}), {255, 0, 1, 255});
    check_heights(demo::read_terrain(folder / "t.vrt", {.channel = "grey"}), {1, hole, 3, 4});

    // A mask of its own, and "no data" beside it.
    const std::string mask = band<std::uint8_t>(folder, 9, {255, 0, 255, 255});
    const std::string masked = "<MaskBand>" + mask.substr(0, mask.find(" band=\"9\"")) +
                               mask.substr(mask.find(" subClass")) + "</MaskBand>";
    check_heights(read(band<std::int16_t>(folder, 1, four) + masked), {150, hole, 3, 4});
    check_heights(read(band<std::int16_t>(folder, 1, four, no_data("3")) + masked), {150, hole, hole, 4});

    // Bytes with a sign, as GDAL before 3.7 has them.
    const std::string sign =
        "<Metadata domain=\"IMAGE_STRUCTURE\"><MDI key=\"PIXELTYPE\">SIGNEDBYTE</MDI></Metadata>";
    check_heights(read(band<std::uint8_t>(folder, 1, {255, 2, 3, 128}, sign + no_data("-128"))),
                  {-1, 2, 3, hole});
}

TEST_CASE("touch_terrain gdal: right way up, however the rows run, and turned grids are refused",
          "[touch_terrain][gdal]") {
    const Folder folder;
    const std::string samples = band<std::int16_t>(folder, 1, {1, 2, 3, 4});
    const auto read = [&](const std::string& transform) {
        return demo::read_terrain(raster(folder, lies(transform) + samples));
    };
    check_heights(read("100, 10, 0, 200, 0, -20"), {1, 2, 3, 4});
    check_heights(read("100, 10, 0, 200, 0, 20"), {3, 4, 1, 2});
    check_heights(read("100, -10, 0, 200, 0, -20"), {2, 1, 4, 3});
    check_heights(read("100, -10, 0, 200, 0, 20"), {4, 3, 2, 1});
    CHECK(read("100, -10, 0, 200, 0, 20").spacing == glm::dvec2{10, 20});
    CHECK(says(read("100, 10, 0, 200, 0, -20"), "spacing is in metres"));
    check_heights(read("100, 10, 1e-9, 200, 0, -10"), {1, 2, 3, 4}); // a rounding
    for (const std::string turned :
         {"0, 7, 7, 0, 7, -7", "0, 0, 10, 0, 10, 0", "0, 10, 1, 0, 0, -10", "0, 0, 0, 0, 0, 0"}) {
        CAPTURE(turned);
        const std::string said = refusal(raster(folder, lies(turned) + samples));
        CHECK(contains(said, "t.vrt is turned on its map"));
        CHECK_FALSE(contains(said, ". "));
    }
    CHECK_FALSE(demo::read_terrain(raster(folder, samples)).spacing);
    // The packed three and the mask turn with it.
    const std::string rgb = band<std::uint8_t>(folder, 1, {128, 128, 0, 0}) +
                            band<std::uint8_t>(folder, 2, {1, 2, 0, 0}) +
                            band<std::uint8_t>(folder, 3, {0, 0, 0, 128});
    const auto file = raster(folder, lies("0, -1, 0, 0, 0, 1") + rgb);
    check_heights(demo::read_terrain(file, {.encoding = demo::Encoding::terrarium}),
                  {-32767.5, -32768, 2, 1});
    CHECK(contains(refusal(file), "3 bands"));
    CHECK(contains(refusal(file), "--channel"));
    CHECK(contains(refusal(file), "--encoding"));
}

TEST_CASE("touch_terrain gdal: degrees and feet become metres", "[touch_terrain][gdal]") {
    const Folder folder;
    const std::string samples = band<std::int16_t>(folder, 1, four);
    const auto read = [&](const std::string& map, const std::string& transform,
                          const demo::ReadOptions& options = {}) {
        return demo::read_terrain(raster(folder, lies(transform, map) + samples), options);
    };
    const auto degrees = read("EPSG:4326", "7, 0.001, 0, 45.001, 0, -0.001");
    CHECK(degrees.spacing->x == Approx(78.8468).epsilon(1e-6));
    CHECK(degrees.spacing->y == Approx(111.1318).epsilon(1e-6));
    CHECK(says(degrees, "middle latitude, 45 "));
    CHECK(read("EPSG:4326", "7, 0.001, 0, 45.001, 0, -0.001", {.spacing = glm::dvec2{3, 4}}).spacing ==
          glm::dvec2{3, 4});
    CHECK(contains(refusal(raster(folder, lies("7, 1, 0, 91, 0, -1", "EPSG:4326") + samples)), "--spacing"));
    CHECK(read("EPSG:32613", "5e5, 30, 0, 4e6, 0, -30").spacing == glm::dvec2{30, 30});
    CHECK(read("EPSG:2232", "5e5, 30, 0, 4e6, 0, -30").spacing->x ==
          Approx(30 * 1200.0 / 3937)); // US survey feet
    CHECK(read("EPSG:2232", "5e5, 30, 0, 4e6, 0, -30", {.unit = 1.0}).spacing->x ==
          Approx(30 * 1200.0 / 3937));
    CHECK(read("+proj=utm +zone=13 +datum=WGS84 +units=km", "5e2, 0.03, 0, 4e3, 0, -0.03").spacing->x ==
          Approx(30));
    // NAVD88 in feet: heights as well.
    const auto compound = read("EPSG:2232+6360", "5e5, 30, 0, 4e6, 0, -30");
    check_heights(compound, {150 * 1200.0 / 3937, 2 * 1200.0 / 3937, 3 * 1200.0 / 3937, 4 * 1200.0 / 3937});
    CHECK_FALSE(says(compound, "heights"));
}

TEST_CASE("touch_terrain gdal: Mercator metres become metres on the ground", "[touch_terrain][gdal]") {
    const Folder folder;
    const std::string samples = band<std::int16_t>(folder, 1, four);
    const auto read = [&](const std::string& map, double north, const demo::ReadOptions& options = {}) {
        const std::string transform = "1e6, 30, 0, " + std::to_string(north + 30) + ", 0, -30";
        return demo::read_terrain(raster(folder, lies(transform, map) + samples), options);
    };
    const double web = 8399737.88981836, world = 8362698.54850075; // 60°
    for (const std::string map :
         {"EPSG:3857", "EPSG:900913", "EPSG:3785", "ESRI:102100", "ESRI:102113", "+proj=webmerc +datum=WGS84",
          "+proj=merc +a=6378137 +b=6378137 +lat_ts=0 +k=1 +units=m +nadgrids=@null +no_defs"}) {
        CAPTURE(map);
        const auto terrain = read(map, web);
        CHECK(terrain.spacing->x == Approx(15).epsilon(1e-6));
        CHECK(terrain.spacing->y == Approx(15).epsilon(1e-6));
        CHECK(
            says(terrain, "Mercator metres are turned into those on the ground at the middle latitude, 60 "));
        CHECK(read(map, web, {.spacing = glm::dvec2{30, 30}}).spacing == glm::dvec2{30, 30});
    }
    CHECK(read("EPSG:3857+5703", web).spacing->x == Approx(15).epsilon(1e-6));
    CHECK(read("EPSG:3395", world).spacing->x == Approx(30 * 0.501260).epsilon(1e-5));
    CHECK(read("EPSG:4087", 6679169.4476).spacing->x == Approx(15).epsilon(1e-5));
    CHECK(read("EPSG:4087", 6679169.4476).spacing->y == 30);
    CHECK(read("EPSG:6933", 6351419.9973).spacing->x == Approx(30 * 55.800 / 96.4865).epsilon(0.012));
    for (const std::string map : {"EPSG:32613", "EPSG:3035", "EPSG:5070", "EPSG:3031"}) {
        CAPTURE(map);
        CHECK(read(map, 4e6).spacing == glm::dvec2{30, 30});
        CHECK_FALSE(says(read(map, 4e6), "ground"));
    }
}

TEST_CASE("touch_terrain gdal: depths of the vertical system lie below", "[touch_terrain][gdal]") {
    const Folder folder;
    const auto read = [&](const std::string& map) {
        const std::string samples =
            band<std::int16_t>(folder, 1, four, "<Scale>0.5</Scale><Offset>10</Offset>");
        return demo::read_terrain(raster(folder, lies("5e5, 30, 0, 4e6, 0, -30", map) + samples));
    };
    check_heights(read("EPSG:32613+5715"), {-85, -11, -11.5, -12}); // mean sea level, downwards
    CHECK(says(read("EPSG:32613+5715"), "samples are depths"));
    check_heights(read("EPSG:32613+5714"), {85, 11, 11.5, 12});
    CHECK_FALSE(says(read("EPSG:32613+5714"), "depths"));
}

TEST_CASE("touch_terrain gdal: one of several rasters is asked for by its name", "[touch_terrain][gdal]") {
    const Folder folder;
    folder.text("one.nc", netcdf({"depth"}));
    folder.text("two.nc", netcdf({"depth", "error"}));
    if (contains(refusal(folder / "one.nc"), "not recognized"))
        return hfh::test::skip("this GDAL does not read netCDF");
    check_heights(demo::read_terrain(folder / "one.nc"), {1, 2, 3, 4});
    const std::string depth = "NETCDF:\"" + (folder / "two.nc").string() + "\":depth";
    const std::string said = refusal(folder / "two.nc");
    CHECK(contains(said, "2 rasters"));
    CHECK(contains(said, depth));
    CHECK(contains(said, ":error"));
    const auto terrain = demo::read_terrain(depth);
    check_heights(terrain, {1, 2, 3, 4});
    CHECK(terrain.name == depth);
    CHECK(contains(refusal("NETCDF:\"" + (folder / "two.nc").string() + "\":none"), "none"));
    CHECK(contains(refusal("NETCDF:\"nowhere.nc\":depth"), "nowhere.nc"));

    // A path that only GDAL understands: from the first byte on, all of the file.
    folder.text("t.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n");
    check_heights(demo::read_terrain("/vsisubfile/0," + (folder / "t.asc").string()), {1, 2, 3, 4});
}

TEST_CASE("touch_terrain gdal: a band of a bil of several", "[touch_terrain][gdal]") {
    const Folder folder;
    folder.samples<std::uint8_t>("t.bil", {1, 2, 5, 6, 3, 4, 7, 8});
    folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBANDS 2\nNBITS 8\nLAYOUT BIL\n");
    CHECK(contains(refusal(folder / "t.bil"), "NBANDS"));
    check_heights(demo::read_terrain(folder / "t.bil", {.channel = "1"}), {1, 2, 3, 4});
    check_heights(demo::read_terrain(folder / "t.bil", {.channel = "2"}), {5, 6, 7, 8});
    CHECK(contains(refusal(folder / "t.bil", {.channel = "3"}), "has the bands 1, 2"));
}

TEST_CASE("touch_terrain gdal: bytes of a bil have a sign where its NODATA is negative",
          "[touch_terrain][gdal]") {
    const Folder folder;
    folder.samples<std::int8_t>("t.bil", {-1, 10, -128, 127});
    const std::string header = "NROWS 2\nNCOLS 2\nNBITS 8\nNODATA -1\n";
    folder.text("t.hdr", header);
    const auto terrain = demo::read_terrain(folder / "t.bil", {.channel = "1"});
    check_heights(terrain, {hole, 10, -128, 127});
    CHECK(says(terrain, "integers with a sign, for t.hdr has no PIXELTYPE, but a NODATA of -1"));
    folder.text("t.hdr", header + "pixeltype UNSIGNEDINT\n");
    const auto unsigned_bytes = demo::read_terrain(folder / "t.bil", {.channel = "1"});
    check_heights(unsigned_bytes, {255, 10, 128, 127});
    CHECK(says(unsigned_bytes, "which no sample of type Byte can be"));
    folder.text("t.hdr", header + "PIXELTYPE SIGNEDINT\n");
    check_heights(demo::read_terrain(folder / "t.bil", {.channel = "1"}), {hole, 10, -128, 127});
}

TEST_CASE("touch_terrain gdal: a \"no data\" value that no sample can be is not dropped silently",
          "[touch_terrain][gdal]") {
    const Folder folder;
    const auto said = [&]<class S>(S /*type*/, const std::string& no_data) {
        const auto terrain =
            demo::read_terrain(raster(folder, band<S>(folder, 1, {S(1), S(2), S(3), S(4)},
                                                      "<NoDataValue>" + no_data + "</NoDataValue>")));
        check_heights(terrain, {1, no_data == "2" ? hole : 2, 3, 4});
        for (const std::string& sentence : terrain.assumed) {
            if (contains(sentence, "no data")) return sentence.substr(sentence.find("that it is"));
        }
        return std::string{};
    };
    CHECK(said(std::uint8_t{}, "-9999") == "that it is -9999, which no sample of type Byte can be");
    CHECK(said(std::uint8_t{}, "nan") == "that it is nan, which no sample of type Byte can be");
    CHECK(said(std::uint16_t{}, "-1") == "that it is -1, which no sample of type UInt16 can be");
    CHECK(said(std::int16_t{}, "2.5") == "that it is 2.5, which no sample of type Int16 can be");
    CHECK(said(std::int32_t{}, "-3.4e38") == "that it is -3.4e+38, which no sample of type Int32 can be");
    CHECK(said(std::uint32_t{}, "4294967296") ==
          "that it is 4294967296, which no sample of type UInt32 can be");
    CHECK(said(float{}, "-1e300") == "that it is -1e+300, which no sample of type Float32 can be");
    CHECK(said(double{}, "-1e300").empty());
    CHECK(said(std::uint8_t{}, "2").empty());
    CHECK(said(std::int16_t{}, "2").empty());
    CHECK(said(std::int32_t{}, "2").empty());
    CHECK(said(float{}, "2").empty());
    CHECK(said(float{}, "nan").empty());
}

TEST_CASE("touch_terrain gdal: a world file says how far apart an image's pixels are",
          "[touch_terrain][gdal]") {
    const Folder folder;
    write_png(folder / "t.png", 2, 2, 8, PNG_COLOR_TYPE_GRAY, {1, 2, 3, 4});
    folder.text("t.pgw", "5\n0\n0\n-6\n100\n200\n");
    CHECK(demo::read_terrain(folder / "t.png").spacing == glm::dvec2{5, 6});
    check_heights(demo::read_terrain(folder / "t.png"), {1, 2, 3, 4});
    CHECK(demo::read_terrain(folder / "t.png", {.spacing = glm::dvec2{1, 2}}).spacing == glm::dvec2{1, 2});
    folder.text("t.pgw", "5\n0\n0\n6\n100\n200\n");
    check_heights(demo::read_terrain(folder / "t.png"), {3, 4, 1, 2});
    folder.text("t.pgw", "5\n1\n1\n-6\n100\n200\n");
    CHECK(contains(refusal(folder / "t.png"), "turned"));
}

TEST_CASE("touch_terrain gdal: what it has written beside a file that cannot hold it",
          "[touch_terrain][gdal]") {
    const Folder folder;
    const std::string more =
        "<PAMDataset><SRS>EPSG:4326</SRS><PAMRasterBand band=\"1\"><Offset>1000</Offset><Scale>0.5</Scale>"
        "<UnitType>ft</UnitType></PAMRasterBand></PAMDataset>";
    const std::vector<double> wanted{1000.5 * 0.3048, 1001 * 0.3048, 1001.5 * 0.3048, 1002 * 0.3048};
    folder.samples<std::int16_t>("t.bil", {1, 2, 3, 4});
    folder.text("t.hdr", "NROWS 2\nNCOLS 2\nNBITS 16\nPIXELTYPE SIGNEDINT\nXDIM 0.001\nYDIM 0.001\n"
                         "ULXMAP 7\nULYMAP 45.0005\n");
    folder.text("t.bil.aux.xml", more);
    const auto terrain = demo::read_terrain(folder / "t.bil");
    check_heights(terrain, wanted);
    CHECK(terrain.spacing->x == Approx(78.8468).epsilon(1e-6));
    CHECK_FALSE(says(terrain, "heights"));
    write_png(folder / "t.png", 2, 2, 8, PNG_COLOR_TYPE_GRAY, {1, 2, 3, 4});
    folder.text("t.png.aux.xml", more);
    check_heights(demo::read_terrain(folder / "t.png"), wanted);
    check_heights(demo::read_terrain(folder / "t.png", {.unit = 1.0}), {1000.5, 1001, 1001.5, 1002});
    // Statistics alone change nothing.
    folder.text("t.bil.aux.xml", "<PAMDataset><PAMRasterBand band=\"1\"/></PAMDataset>");
    check_heights(demo::read_terrain(folder / "t.bil"), {1, 2, 3, 4});
    CHECK(demo::read_terrain(folder / "t.bil").spacing == glm::dvec2{0.001});
}

#else

TEST_CASE("touch_terrain gdal: what GDAL knows of a raster is used", "[touch_terrain][gdal]") {
    hfh::test::skip("GDAL was not there when this was configured");
}

#endif // TOUCH_TERRAIN_HAS_GDAL
