#include "bytes.hpp"

#include "bad_input.hpp"
#include "stylus_path.hpp"
#include "terrain.hpp"

#include <hfh/terrain/bilinear_grid.hpp>

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <cstdlib>
#include <unistd.h>

// The demo's readers on files that nobody wrote: a terrain or a path that can be used, or BadInput; nothing else.

namespace hfh::fuzz {
namespace {

/// What fuzzing has found and is not mended yet: not reported again while true.
struct Open {
    bool any_spacing = false; ///< a header's spacing may be so small or so large that no grid can be made
};
constexpr Open open;

/// A directory in memory, if there is one, that goes away with the process.
class Directory {
public:
    Directory() {
        std::error_code error;
        const auto memory = std::filesystem::path{"/dev/shm"};
        const auto parent =
            std::filesystem::is_directory(memory, error) ? memory : std::filesystem::temp_directory_path();
        std::string name = (parent / "hfh-fuzz-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr) broken("no temporary directory", name);
        path_ = name;
    }
    ~Directory() {
        std::error_code error;
        std::filesystem::remove_all(path_, error);
    }
    Directory(const Directory&) = delete;
    Directory& operator=(const Directory&) = delete;

    std::filesystem::path write(const char* name, std::string_view content) const {
        auto file = path_ / name;
        std::FILE* const out = std::fopen(file.c_str(), "wb");
        if (out == nullptr) broken("no temporary file", file.string());
        std::fwrite(content.data(), 1, content.size(), out);
        std::fclose(out);
        return file;
    }

private:
    std::filesystem::path path_;
};

const Directory& directory() {
    static const Directory made;
    return made;
}

/// BadInput says file and rule in one sentence on one line.
template <class Read>
void guarded(Read&& read) {
    try {
        read();
    } catch (const demo::BadInput& bad) {
        const std::string_view what = bad.what();
        if (what.size() < 10 || what.back() != '.' || what.find('\n') != std::string_view::npos) {
            broken("BadInput without a sentence", std::string{what});
        }
    }
}

/// Every sample can be read, and every patch of the grid that the demo makes of it.
void use(const demo::Terrain& terrain) {
    if (terrain.name.empty()) broken("a terrain without a name", "");
    if (terrain.spacing && !(terrain.spacing->x > 0 && terrain.spacing->y > 0 &&
                             is_finite(terrain.spacing->x) && is_finite(terrain.spacing->y))) {
        broken("a spacing that is none", "");
    }
    std::visit(
        [&](const auto& heights) {
            if (heights.columns() < 2 || heights.rows() < 2) broken("too few samples", "");
            const BilinearGrid<double, std::remove_cvref_t<decltype(heights)>> grid{
                heights,
                {.spacing = terrain.spacing.value_or(glm::dvec2{1.0}),
                 .height_scale = terrain.height_scale,
                 .height_offset = terrain.height_offset}};
            if (!open.any_spacing && grid.status() != GridStatus::ok)
                broken("a terrain that makes no grid", std::to_string(static_cast<int>(grid.status())));
            const CellRange cells = grid.cells();
            for (Index j = cells.begin.j; j < cells.end.j; ++j) {
                for (Index i = cells.begin.i; i < cells.end.i; ++i) {
                    const auto patch = grid.patch({i, j});
                    if (patch && !is_finite(vec3<double>{patch->p00, patch->p10 + patch->p01, patch->p11}))
                        broken("a height that is none", "");
                }
            }
        },
        terrain.heights);
}

// A PNG that is right as far as its bytes allow: mutated bytes alone would never get past a checksum.

void append_big_endian(std::string& out, std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift & 0xff);
}

[[nodiscard]] std::uint32_t crc32(std::string_view bytes) {
    static const auto table = [] {
        std::array<std::uint32_t, 256> made{};
        for (std::uint32_t n = 0; n < 256; ++n) {
            made[n] = n;
            for (int bit = 0; bit < 8; ++bit)
                made[n] = (made[n] & 1) != 0 ? 0xedb88320u ^ made[n] >> 1 : made[n] >> 1;
        }
        return made;
    }();
    std::uint32_t crc = ~0u;
    for (const char c : bytes) crc = table[(crc ^ static_cast<std::uint8_t>(c)) & 0xff] ^ crc >> 8;
    return ~crc;
}

void append_chunk(std::string& out, std::string_view type, std::string_view data) {
    append_big_endian(out, static_cast<std::uint32_t>(data.size()));
    std::string body{type};
    body += data;
    out += body;
    append_big_endian(out, crc32(body));
}

/// zlib's frame around bytes that are not compressed.
[[nodiscard]] std::string stored(std::string_view bytes) {
    std::string out = "\x78\x01";
    std::uint32_t a = 1, b = 0;
    for (const char c : bytes) a = (a + static_cast<std::uint8_t>(c)) % 65521, b = (b + a) % 65521;
    do {
        const std::string_view block = bytes.substr(0, 65535);
        bytes.remove_prefix(block.size());
        out += bytes.empty() ? '\1' : '\0';
        const auto size = static_cast<std::uint32_t>(block.size());
        for (const std::uint32_t n : {size, size >> 8, ~size, ~size >> 8}) out += static_cast<char>(n & 0xff);
        out += block;
    } while (!bytes.empty());
    append_big_endian(out, b << 16 | a);
    return out;
}

[[nodiscard]] std::string_view text(const Bytes& bytes) {
    return {reinterpret_cast<const char*>(bytes.rest()), bytes.left()};
}

[[nodiscard]] std::string png(Bytes& bytes) {
    std::string out = "\x89PNG\r\n\x1a\n";
    std::string header;
    const bool any = bytes.byte() % 8 == 0;
    append_big_endian(header, any ? bytes.raw<std::uint32_t>() : bytes.byte() % 20u);
    append_big_endian(header, any ? bytes.raw<std::uint32_t>() : bytes.byte() % 20u);
    constexpr std::array<char, 6> depths{8, 16, 8, 16, 4, 1};
    constexpr std::array<char, 8> colours{0, 4, 6, 0, 4, 6, 2, 3};
    header += any ? static_cast<char>(bytes.byte()) : depths[bytes.byte() % depths.size()];
    header += any ? static_cast<char>(bytes.byte()) : colours[bytes.byte() % colours.size()];
    header += '\0';
    header += '\0';
    header += static_cast<char>(bytes.byte() % (any ? 3 : 2)); // interlaced
    append_chunk(out, "IHDR", header);
    // Chunks between: a type out of the common ones, and some of the bytes.
    constexpr std::array<std::string_view, 8> types{"gAMA", "tRNS", "PLTE", "sBIT",
                                                    "iCCP", "tEXt", "bKGD", "IDAT"};
    for (int n = bytes.byte() % 4; n > 0; --n) {
        const auto type = types[bytes.byte() % types.size()];
        const std::string_view data = text(bytes).substr(0, bytes.byte());
        append_chunk(out, type, std::string{data});
    }
    const std::uint8_t how = bytes.byte();
    const bool packed = how % 8 == 1; // the bytes are what zlib has to make sense of
    std::string pixels{text(bytes)};
    if (how % 4 == 0) pixels.resize(20 * (20 * 8 + 1), '\0'); // enough for any size above
    append_chunk(out, "IDAT", packed ? pixels : stored(pixels));
    if (how % 16 != 3) append_chunk(out, "IEND", "");
    return out;
}

/// A header whose keys are right, with values that may be.
[[nodiscard]] std::string raster_header(Bytes& bytes) {
    constexpr std::array<std::string_view, 22> keys{
        "NROWS",       "NCOLS",     "NBITS",        "PIXELTYPE",     "NBANDS", "LAYOUT",
        "BYTEORDER",   "SKIPBYTES", "BANDROWBYTES", "TOTALROWBYTES", "NODATA", "NODATA_VALUE",
        "NODATAVALUE", "DATATYPE",  "CELLSIZE",     "XDIM",          "YDIM",   "ULXMAP",
        "ULYMAP",      "YLLCORNER", "YLLCENTER",    "# a comment"};
    constexpr std::array<std::string_view, 24> values{
        "8",     "16",     "32",    "64",         "UNSIGNEDINT", "SIGNEDINT",
        "FLOAT", "BIL",    "I",     "M",          "LSBFIRST",    "1",
        "0",     "-9999",  "1e30",  "nan",        "inf",         "-3.4028234663852886e+38",
        "10.5",  "1e-320", "1e200", "2147483647", "-1",          "4294967296"};
    std::string out =
        "NROWS " + std::to_string(bytes.byte() % 8) + "\nNCOLS " + std::to_string(bytes.byte() % 8) + "\n";
    for (int n = bytes.byte() % 8; n > 0; --n) {
        out += keys[2 + bytes.byte() % (keys.size() - 2)];
        out += ' ';
        const std::uint8_t value = bytes.byte();
        out += value < 192 ? std::string{values[value % values.size()]} : std::to_string(value - 192);
        out += value % 2 == 0 ? "\n" : "\r\n";
    }
    return out;
}

/// A map in one of its forms, with numbers and words that may be.
[[nodiscard]] std::string map_text(Bytes& bytes) {
    constexpr std::array<std::string_view, 12> maps{
        "GEOGCS[\"a\",DATUM[\"b\",SPHEROID[\"c\",6378137,298.25]],UNIT[\"Degree\",0.0174532925199433]]",
        "PROJCS[\"a\",GEOGCS[\"b\",UNIT[\"Degree\",0.01]],UNIT[\"Foot_US\",0.3048006096012192]]",
        "COMPD_CS[\"a\",LOCAL_CS[\"b\",UNIT[\"m\",1]],VERT_CS[\"c\",UNIT[\"ft\",0.3048]]]",
        "GEOGCRS[\"a\",CS[ellipsoidal,2],AXIS[\"x\",east,ANGLEUNIT[\"degree\",0.01745]]],VERTCS[\"b\",UNIT["
        "\"m\",-1]]",
        "GEOGCS[\"a\",SPHEROID[\"c\",1e308,0],UNIT[\"Degree\",1e300]]",
        "PROJCS(\"a\",UNIT(\"m\",1e-300))",
        "Projection GEOGRAPHIC\nUnits DD\nZunits FEET\n",
        "Projection UTM\nUnits METERS\n",
        "[",
        "",
        "GEOGCS[UNIT[0.0174532925199433],SPHEROID[6378137,1e-300]]",
        "GEOGCS[UNIT[1],SPHEROID[1,1.5]]"};
    const std::uint8_t which = bytes.byte();
    return which < 224 ? std::string{maps[which % maps.size()]}
                       : std::string{text(bytes).substr(0, bytes.byte())};
}

void read_rasters(Bytes& bytes, bool flt) {
    (void)directory().write("raster.prj", bytes.byte() % 3 == 0 ? "" : map_text(bytes));
    std::string header, samples;
    if (bytes.flag()) {
        header = raster_header(bytes);
        samples = text(bytes);
        const unsigned size = bytes.byte(); // as many samples as the header may want
        if (size % 4 != 0) samples.resize(2 * size, '\x40');
    } else { // any text, a zero, any samples
        const std::string_view both = text(bytes);
        const auto end = both.find('\0');
        header = both.substr(0, end);
        if (end != std::string_view::npos) samples = both.substr(end + 1);
    }
    directory().write("raster.hdr", header);
    const auto file = directory().write(flt ? "raster.flt" : "raster.bil", samples);
    const demo::ReadOptions options{.unit = bytes.flag() ? std::optional{1e-3} : std::nullopt};
    guarded([&] { use(demo::read_terrain(file, options)); });
}

/// A channel or an encoding that somebody may ask for.
[[nodiscard]] demo::ReadOptions image_options(Bytes& bytes) {
    constexpr std::array<const char*, 8> channels{"", "", "", "grey", "red", "alpha", "2", "4"};
    demo::ReadOptions options;
    options.encoding = static_cast<demo::Encoding>(bytes.byte() % 8 < 3 ? bytes.byte() % 3 : 0);
    options.channel = channels[bytes.byte() % channels.size()];
    return options;
}

void read_path(const std::filesystem::path& file) {
    guarded([&] {
        demo::StylusPathFile path{file};
        double last = -std::numeric_limits<double>::infinity();
        while (const auto sample = path.next()) {
            if (!std::isfinite(sample->t) || !is_finite(sample->position) || sample->t < last)
                broken("a row that should have been refused", "");
            if (!(path.progress() >= 0 && path.progress() <= 1)) broken("progress beyond its end", "");
            last = sample->t;
        }
    });
}

} // namespace
} // namespace hfh::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace hfh::fuzz;
    Bytes bytes{data, size};
    switch (bytes.byte() % 6) {
    case 0: {
        const demo::ReadOptions options = image_options(bytes);
        const auto file = directory().write("terrain.png", png(bytes));
        guarded([&] { use(demo::read_terrain(file, options)); });
        break;
    }
    case 1: {
        const auto file = directory().write("terrain.png", text(bytes));
        guarded([&] { use(demo::read_terrain(file)); });
        break;
    }
    case 2: read_rasters(bytes, false); break;
    case 3: read_rasters(bytes, true); break;
    case 4: read_path(directory().write("path.csv", text(bytes))); break;
    default: read_path(directory().write("path.csv", "t,x,y,z\n" + std::string{text(bytes)}));
    }
    return 0;
}
