#include "catch.hpp"
#include "touch_terrain_files.hpp"

#include <initializer_list>
#include <limits>

// Bad input: exit code 2, one sentence on stderr that names file, place, value and rule, and nothing left behind.

using namespace touch_terrain_tests;

namespace {

const std::string good_header =
    "NROWS 3\nNCOLS 4\nNBITS 16\nPIXELTYPE SIGNEDINT\nBYTEORDER I\nXDIM 2\nYDIM 3\n";

/// A folder with a terrain and a path that are good, so that only what a test adds is bad.
class GoodFolder : public Folder {
public:
    GoodFolder() {
        samples<std::int16_t>("good.bil", std::vector<std::int16_t>(12, 5));
        text("good.hdr", good_header);
        text("good.csv", "t,x,y,z\n0,1,1,9\n0.001,1,1,4\n");
        text("out.csv", "what was there before\n");
    }

    void refuses(const std::string& arguments, std::initializer_list<std::string> says,
                 const std::string& before = "") const {
        CAPTURE(arguments);
        const auto files = listing();
        const Run run = this->run(arguments + " --record out.csv", before);
        CAPTURE(run.err);
        CHECK(run.code == 2);
        CHECK(run.out.empty());
        CHECK(run.err.starts_with("touch_terrain: "));
        CHECK(run.err.ends_with(".\n"));
        CHECK(run.err.find('\n') == run.err.size() - 1);
        CHECK(run.err.find(". ") == std::string::npos); // one sentence
        for (const std::string& word : says) {
            CAPTURE(word);
            CHECK(run.err.find(word) != std::string::npos);
        }
        CHECK(listing() == files);
    }

    /// good.bil under another header.
    void refuses_header(const std::string& header, std::initializer_list<std::string> says) const {
        CAPTURE(header);
        samples<std::int16_t>("t.bil", std::vector<std::int16_t>(12, 5));
        text("t.hdr", header);
        refuses("t.bil", says);
    }

    void refuses_path(const std::string& rows, std::initializer_list<std::string> says) const {
        CAPTURE(rows);
        text("p.csv", rows);
        refuses("good.bil --path p.csv", says);
    }
};

std::string with(std::string text, const std::string& what, const std::string& by) {
    return text.replace(text.find(what), what.size(), by);
}

} // namespace

TEST_CASE("touch_terrain: the input that the refusals vary is accepted as it stands", "[touch_terrain]") {
    const GoodFolder folder;
    const Run run = folder.run("good.bil --path good.csv --record out.csv");
    CAPTURE(run.err);
    CHECK(run.code == 0);
    CHECK(run.err.empty());
    CHECK(contents(folder / "out.csv").find("contact") != std::string::npos);
}

TEST_CASE("touch_terrain: refuses a terrain that is missing, unreadable or of no known kind",
          "[touch_terrain]") {
    const GoodFolder folder;
    folder.refuses("nowhere.png", {"nowhere.png", "not exist"});
    folder.refuses("nowhere.bil", {"nowhere.bil", "not exist"});
    folder.text("notes.txt", "hello");
    folder.refuses("notes.txt", {"notes.txt"});
    fs::create_directory(folder / "d.png");
    folder.refuses("d.png", {"d.png is a directory"});
    if (::geteuid() != 0) { // root reads everything
        folder.text("secret.png", "");
        fs::permissions(folder / "secret.png", fs::perms::none);
        const Run run = folder.run("secret.png");
        CHECK(run.code == 2);
        CHECK(run.err.find("Permission denied") != std::string::npos);
        fs::permissions(folder / "secret.png", fs::perms::owner_all);
    }
}

TEST_CASE("touch_terrain: refuses a png that is none, damaged or without heights", "[touch_terrain]") {
    const GoodFolder folder;
    const std::vector<int> twelve(12, 0);
    folder.text("t.png", "GIF89a, which is no PNG");
    folder.refuses("t.png", {"t.png", "not a PNG image"});
    folder.text("t.png", "");
    folder.refuses("t.png", {"t.png", "not a PNG image"});
    folder.text("t.png", "\x89PNG\r\n\x1a\n");
    folder.refuses("t.png", {"t.png", "libpng"});

    write_png(folder / "t.png", 4, 3, 8, PNG_COLOR_TYPE_PALETTE, twelve);
    folder.refuses("t.png", {"t.png", "palette"});
    write_png(folder / "t.png", 2, 2, 8, PNG_COLOR_TYPE_RGB, twelve);
    folder.refuses("t.png", {"t.png", "RGB", "without alpha"});
    write_png(folder / "t.png", 8, 2, 4, PNG_COLOR_TYPE_GRAY, std::vector<int>(8, 0));
    folder.refuses("t.png", {"t.png", "4 bits", "8 or 16"});
    write_png(folder / "t.png", 1, 12, 8, PNG_COLOR_TYPE_GRAY, twelve);
    folder.refuses("t.png", {"t.png", "1 x 12", "at least 2 x 2"});
    write_png(folder / "t.png", 12, 1, 16, PNG_COLOR_TYPE_GRAY, twelve);
    folder.refuses("t.png", {"t.png", "12 x 1", "at least 2 x 2"});

    std::vector<int> noise(64 * 64);
    for (std::size_t k = 0; k < noise.size(); ++k)
        noise[k] = static_cast<int>(k * k * 2654435761u >> 7 & 0xffff);
    write_png(folder / "t.png", 64, 64, 16, PNG_COLOR_TYPE_GRAY, noise);
    const std::string whole = contents(folder / "t.png");
    for (const std::size_t length : {std::size_t{20}, std::size_t{33}, whole.size() / 2, whole.size() - 12}) {
        folder.text("t.png", whole.substr(0, length));
        folder.refuses("t.png", {"t.png", "libpng"});
    }
    std::string flipped = whole;
    flipped[whole.size() / 2] = static_cast<char>(flipped[whole.size() / 2] ^ 0x10);
    folder.text("t.png", flipped);
    folder.refuses("t.png", {"t.png", "libpng"});
}

TEST_CASE("touch_terrain: refuses a png that claims more pixels than its bytes can hold", "[touch_terrain]") {
    const GoodFolder folder;
    write_png(folder / "t.png", 4, 3, 16, PNG_COLOR_TYPE_GRAY, std::vector<int>(12, 0));
    std::string bytes = contents(folder / "t.png");
    // IHDR: width and height at 16 and 20, checksum of the 17 bytes from 12 at 29.
    bytes.replace(16, 8, std::string{"\x00\x00\xff\xff\x00\x00\xff\xff", 8});
    std::uint32_t crc = 0xffffffffu;
    for (std::size_t k = 12; k < 29; ++k) {
        crc ^= static_cast<std::uint8_t>(bytes[k]);
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0u);
    }
    crc = ~crc;
    for (std::size_t k = 0; k < 4; ++k) bytes[29 + k] = static_cast<char>(crc >> (24 - 8 * k) & 0xff);
    folder.text("t.png", bytes);
    folder.refuses("t.png", {"t.png", "65535 x 65535"});
}

TEST_CASE("touch_terrain: refuses a raster without a header, or cut short, or too long", "[touch_terrain]") {
    const GoodFolder folder;
    folder.samples<std::int16_t>("t.bil", std::vector<std::int16_t>(12, 5));
    folder.refuses("t.bil", {"t.hdr", "not exist"});
    folder.text("t.hdr", good_header);
    folder.samples<std::int16_t>("t.bil", std::vector<std::int16_t>(11, 5));
    folder.refuses("t.bil", {"t.bil", "cut short", "22 bytes", "24"});
    folder.samples<std::int16_t>("t.bil", std::vector<std::int16_t>(13, 5));
    folder.refuses("t.bil", {"t.bil", "26 bytes", "24"});
    folder.samples<std::int16_t>("t.bil", {});
    folder.refuses("t.bil", {"t.bil", "0 bytes", "24"});
    folder.text("t.hdr", std::string(70000, 'x'));
    folder.refuses("t.bil", {"t.hdr", "70000 bytes"});
    fs::remove(folder / "t.hdr");
    fs::create_directory(folder / "t.hdr");
    folder.refuses("t.bil", {"t.hdr"});
}

TEST_CASE("touch_terrain: refuses a header without a needed key, or with a value it may not have",
          "[touch_terrain]") {
    const GoodFolder folder;
    folder.refuses_header("", {"t.hdr", "NROWS"});
    folder.refuses_header(with(good_header, "NROWS 3\n", ""), {"t.hdr", "no NROWS"});
    folder.refuses_header(with(good_header, "NCOLS 4\n", ""), {"t.hdr", "no NCOLS"});
    folder.refuses_header(with(good_header, "NCOLS 4", "NCOLS four"), {"t.hdr, line 2", "NCOLS", "'four'"});
    folder.refuses_header(with(good_header, "NCOLS 4", "NCOLS"), {"t.hdr, line 2", "NCOLS", "''"});
    folder.refuses_header(with(good_header, "NCOLS 4", "NCOLS -4"), {"t.hdr, line 2", "'-4'"});
    folder.refuses_header(with(good_header, "NROWS 3", "NROWS 0"), {"t.hdr, line 1", "NROWS", "'0'"});
    folder.refuses_header(with(good_header, "NROWS 3", "NROWS 3.5"), {"t.hdr, line 1", "'3.5'"});
    folder.refuses_header(with(good_header, "NROWS 3", "NROWS 99999999999999999999"),
                          {"t.hdr, line 1", "9999"});
    folder.refuses_header(with(good_header, "NROWS 3", "NROWS 2147483647"), {"t.bil", "cut short"});
    folder.refuses_header(with(good_header, "NROWS 3", "NROWS 1"), {"t.hdr", "4 x 1", "at least 2 x 2"});
    folder.refuses_header(with(good_header, "NROWS 3", "NROWS 4"), {"t.bil", "24 bytes", "32"});
    folder.refuses_header(with(good_header, "NBITS 16", "NBITS 12"), {"t.hdr, line 3", "NBITS", "'12'"});
    folder.refuses_header(with(with(good_header, "NBITS 16", "NBITS 8"), "SIGNEDINT", "FLOAT"),
                          {"t.hdr, line 4", "PIXELTYPE", "int16"});
    folder.refuses_header(with(good_header, "NBITS 16", "NBITS 64"), {"t.hdr, line 4", "PIXELTYPE", "int16"});
    folder.refuses_header(with(good_header, "SIGNEDINT", "COMPLEX"), {"t.hdr, line 4", "'COMPLEX'", "FLOAT"});
    folder.refuses_header(with(good_header, "SIGNEDINT", "FLOAT"), {"t.hdr, line 4", "'FLOAT'", "float32"});
    folder.refuses_header(good_header + "NROWS 3\n", {"t.hdr, line 8", "NROWS", "second time"});
    folder.refuses_header(good_header + "NBANDS 3\n", {"t.hdr, line 8", "NBANDS", "'3'"});
    folder.refuses_header(good_header + "LAYOUT TILED\n", {"t.hdr, line 8", "LAYOUT", "'TILED'"});
    folder.refuses_header(good_header + "SKIPBYTES 1\n", {"t.hdr, line 8", "SKIPBYTES", "'1'"});
    folder.refuses_header(good_header + "SKIPBYTES 2\n", {"t.bil", "24 bytes", "26"});
    folder.refuses_header(good_header + "BANDROWBYTES 10\n", {"t.hdr, line 8", "BANDROWBYTES", "'10'"});
    folder.refuses_header(good_header + "TOTALROWBYTES 6\n", {"t.hdr, line 8", "TOTALROWBYTES", "'6'"});
    folder.refuses_header(good_header + "TOTALROWBYTES 9\n", {"t.hdr, line 8", "TOTALROWBYTES", "'9'"});
    folder.refuses_header(good_header + "NODATA none\n", {"t.hdr, line 8", "NODATA", "'none'"});
    folder.refuses_header(with(good_header, "XDIM 2", "XDIM 0"), {"t.hdr, line 6", "XDIM", "'0'"});
    folder.refuses_header(with(good_header, "YDIM 3", "YDIM -3"), {"t.hdr, line 7", "YDIM", "'-3'"});
    folder.refuses_header(with(good_header, "YDIM 3", "YDIM inf"), {"t.hdr, line 7", "YDIM", "'inf'"});
    folder.refuses_header(with(good_header, "YDIM 3\n", ""), {"t.hdr, line 6", "XDIM", "YDIM"});
}

TEST_CASE("touch_terrain: refuses a byte order that is none", "[touch_terrain]") {
    const GoodFolder folder;
    folder.refuses_header(with(good_header, "BYTEORDER I", "BYTEORDER X"),
                          {"t.hdr, line 5", "BYTEORDER", "'X'", "little-endian", "big-endian"});
}

TEST_CASE("touch_terrain: refuses a flt that is not 32 bit floats", "[touch_terrain]") {
    const GoodFolder folder;
    folder.samples<double>("t.flt", std::vector<double>(4, 1.0));
    folder.text("t.hdr", "ncols 2\nnrows 2\nnbits 64\n");
    folder.refuses("t.flt", {"t.hdr, line 3", "NBITS", "'64'", "32"});
    folder.text("t.hdr", "ncols 2\nnrows 2\ncellsize 0\n");
    folder.refuses("t.flt", {"t.hdr, line 3", "CELLSIZE", "'0'"});
}

TEST_CASE("touch_terrain: refuses option values out of range", "[touch_terrain]") {
    const GoodFolder folder;
    for (const std::string bad : {"0", "-1", "nan", "inf", "1,0", "0,1", "1,-1", "1,nan", "1,2,3", "1,", ",1",
                                  "''", "wide", "1e-300", "1e300"}) {
        folder.refuses("good.bil --spacing " + bad, {"--spacing", bad == "''" ? bad : "'" + bad + "'"});
    }
    for (const std::string bad : {"0", "-1", "nan", "inf", "hard", "1e300", "1e-300", "''"}) {
        folder.refuses("good.bil --stiffness " + bad, {"--stiffness", bad == "''" ? bad : "'" + bad + "'"});
    }
    for (const std::string bad : {"0", "nan", "-inf", "tall", "1e300", "''"}) {
        folder.refuses("good.bil --height-scale " + bad,
                       {"--height-scale", bad == "''" ? bad : "'" + bad + "'"});
    }
    folder.refuses("good.bil --depth 3", {"--depth"});
    folder.refuses("good.bil another.bil", {"another.bil"});
    folder.refuses("good.bil --stiffness 1 --stiffness 2", {"--stiffness"});
    for (const std::string bad : {"1", "0", "-3", "2.5", "1001", "x", "''"})
        folder.refuses("good.bil --bridge " + bad, {"--bridge", "2 to 1000"});
    for (const std::string bad : {"-1", "nan", "inf", "1e10", "wide", "''"}) {
        folder.refuses("good.bil --tip " + bad, {"--tip", "from 0 to 1e9 metres"});
        folder.refuses("good.bil --tip-hand " + bad, {"--tip-hand", "from 0 to 1e9 millimetres"});
    }
    folder.refuses("good.bil --tip 1 --tip-hand 1", {"--tip and --tip-hand", "one radius"});
    folder.refuses("good.bil --tip-hand 1 --device none", {"--tip-hand", "--device none", "no hand"});
    for (const std::string bad : {"0", "-1", "nan", "fast", "''"})
        folder.refuses("good.bil --release " + bad, {"--release", "from 1e-12 to 1e12"});
    folder.refuses("good.bil --release 0.5 --device none", {"--release", "--device none", "no hand"});
    folder.refuses("good.bil --device omni", {"--device is 'omni'", "touch, premium or none"});
    const Run without_value = folder.run("good.bil --path");
    CHECK(without_value.code == 2);
    CHECK(without_value.err.find("--path") != std::string::npos);
}

TEST_CASE("touch_terrain: refuses a path file that is missing or has a bad row", "[touch_terrain]") {
    const GoodFolder folder;
    folder.refuses("good.bil --path nowhere.csv", {"nowhere.csv"});
    fs::create_directory(folder / "d.csv");
    folder.refuses("good.bil --path d.csv", {"d.csv is a directory"});
    folder.refuses("good.bil --path ''", {"--path", "''"});
    folder.refuses_path("", {"p.csv, line 1", "header", "'t,x,y,z'"});
    folder.refuses_path("x,y,z\n0,0,0\n", {"p.csv, line 1", "'x,y,z'", "'t,x,y,z'"});
    folder.refuses_path("0,0,0,0\n", {"p.csv, line 1", "'0,0,0,0'"});
    folder.refuses_path("t,x,y,z\n", {"p.csv", "no row"});
    folder.refuses_path("t,x,y,z\n0,1,1,9\n1,1,1\n", {"p.csv, line 3", "'1,1,1'", "3 values"});
    folder.refuses_path("t,x,y,z\n0,1,1,9\n\n1,1,1,1\n", {"p.csv, line 3", "''"});
    folder.refuses_path("t,x,y,z\n0,1,1,9,7\n", {"p.csv, line 2", "5 values"});
    folder.refuses_path("t,x,y,z\n0,1,high,9\n", {"p.csv, line 2", "y is 'high'"});
    folder.refuses_path("t,x,y,z\n0,1,,9\n", {"p.csv, line 2", "y is ''"});
    folder.refuses_path("t,x,y,z\n0,1,1,9m\n", {"p.csv, line 2", "z is '9m'"});
    folder.refuses_path("t,x,y,z\n0,nan,1,9\n", {"p.csv, line 2", "x is 'nan'"});
    folder.refuses_path("t,x,y,z\n0,1,1,-inf\n", {"p.csv, line 2", "z is '-inf'"});
    folder.refuses_path("t,x,y,z\n0,1,1,1e999\n", {"p.csv, line 2", "z is '1e999'"});
    folder.refuses_path("t,x,y,z\n0,1,1,9\n2,1,1,9\n1.5,1,1,9\n",
                        {"p.csv, line 4", "'1.5'", "backwards from 2"});
    folder.refuses_path("t,x,y,z\n0,1,1,9\n" + std::string(5000, '1') + "\n", {"p.csv, line 3", "longer"});
}

TEST_CASE("touch_terrain: refuses outputs it cannot write or that would overwrite an input",
          "[touch_terrain]") {
    const GoodFolder folder;
    const auto files = folder.listing();
    for (const std::string bad :
         {"--record nowhere/out.csv", "--record .", "--record ''", "--record /dev/null",
          "--path good.csv --record ./good.csv", "--record good.bil", "--record good.hdr"}) {
        const Run run = folder.run("good.bil " + bad);
        CAPTURE(bad, run.err);
        CHECK(run.code == 2);
        CHECK(run.err.find("touch_terrain: ") == 0);
        CHECK(run.err.find('\n') == run.err.size() - 1);
    }
    folder.refuses("good.bil --picture out.csv", {"--picture", "--record"});
    CHECK(folder.listing() == files);
}

TEST_CASE("touch_terrain: says that a picture needs gnuplot, before it starts", "[touch_terrain]") {
    const GoodFolder folder;
    folder.refuses("good.bil --path good.csv --picture out.png", {"--picture", "gnuplot"}, "PATH=/nowhere");
    const Run without = folder.run("good.bil --path good.csv", "PATH=/nowhere");
    CHECK(without.code == 0);
}

TEST_CASE("touch_terrain: a gnuplot that fails leaves nothing behind", "[touch_terrain]") {
    const GoodFolder folder;
    folder.text("gnuplot", "#!/bin/sh\n[ \"$1\" = --version ] && exit 0\nexit 1\n");
    fs::permissions(folder / "gnuplot", fs::perms::owner_all);
    folder.refuses("good.bil --path good.csv --picture out.png", {"--picture", "gnuplot"}, "PATH=.:/bin");
}
