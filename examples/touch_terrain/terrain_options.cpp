#include "terrain_options.hpp"

#include "bad_input.hpp"
#include "command_options.hpp"
#include "numbers.hpp"
#include "units.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>

namespace demo {
namespace {

constexpr const char* bundled_terrain = TOUCH_TERRAIN_BUNDLED;
constexpr glm::dvec2 bundled_spacing{73.596, 92.491}; // examples/data/README.md

glm::dvec2 spacing_from(const std::string& text) {
    const std::size_t comma = text.find(',');
    const std::string_view whole = text;
    const auto dx = parse_finite(whole.substr(0, comma));
    const auto dy = comma == std::string::npos ? dx : parse_finite(whole.substr(comma + 1));
    // Far beyond any terrain, and products of the two still fit a float.
    const auto fits = [](const std::optional<double>& d) { return d && *d >= 1e-12 && *d <= 1e12; };
    if (!fits(dx) || !fits(dy)) {
        refuse("--spacing", text, "one length or two, DX or DX,DY, each from 1e-12 to 1e12 metres");
    }
    return {*dx, *dy};
}

double unit_from(const std::string& text) {
    const auto metres = metres_in(text);
    if (!metres)
        refuse("--unit", text, "a unit of length: m, km, dm, cm, mm, um, nm, ft, us-ft, in, yd or mi");
    return *metres;
}

Encoding encoding_from(const std::string& text) {
    if (text == "terrarium") return Encoding::terrarium;
    if (text == "mapbox") return Encoding::mapbox;
    refuse("--encoding", text, "terrarium or mapbox");
}

std::string channel_from(const std::string& text) {
    constexpr std::array<std::string_view, 5> names{"grey", "red", "green", "blue", "alpha"};
    const auto number = parse_number<int>(text);
    if ((number && *number >= 1) || std::ranges::find(names, text) != names.end()) return text;
    if (text == "gray") return "grey";
    refuse("--channel", text, "grey, red, green, blue, alpha or a number from 1");
}

} // namespace

TerrainCommandLine::TerrainCommandLine(CLI::App& app) : app_{&app} {
    app.add_option(
        "TERRAIN", terrain_,
        "Heights, north row first: .png (8 or 16 bit; the alpha channel if it has one that varies, else "
        "grey), .bil or .flt beside their .hdr"
#ifdef TOUCH_TERRAIN_HAS_GDAL
        ", or anything that GDAL opens, its names of subdatasets and /vsi paths included"
#endif
        ". Default: the Spanish Peaks");
    app.add_option("--spacing", spacing_,
                   "Metres from sample to sample, east and north. Default: what the file says (degrees and "
                   "Mercator in "
                   "metres on the ground at the middle latitude), else 1")
        ->type_name("DX[,DY]");
    app.add_option("--unit", unit_,
                   "Of the samples, and of the spacing in a file that names no map: m, km, dm, cm, mm, um, "
                   "nm, ft, us-ft, in, yd or mi. Default: what the file says, else m")
        ->type_name("UNIT");
    app.add_option("--channel", channel_,
                   "Where the heights are in a file of several channels or bands: grey, red, green, blue, "
                   "alpha or a number from 1")
        ->type_name("CHANNEL");
    app.add_option("--encoding", encoding_,
                   "Heights packed into red, green and blue: terrarium, or mapbox (Terrain-RGB)")
        ->type_name("ENCODING");
    app.add_option("--height-scale", height_scale_, "Multiplies the heights. Default: 1")->type_name("S");
}

TerrainOptions TerrainCommandLine::options() const {
    TerrainOptions options;
    options.terrain = file_from(*app_, "TERRAIN", terrain_);
    if (app_->count("--spacing") != 0) options.read.spacing = spacing_from(spacing_);
    if (app_->count("--unit") != 0) options.read.unit = unit_from(unit_);
    if (app_->count("--channel") != 0) options.read.channel = channel_from(channel_);
    if (app_->count("--encoding") != 0) options.read.encoding = encoding_from(encoding_);
    if (app_->count("--height-scale") != 0)
        options.height_scale = number_from("--height-scale", height_scale_, true);
    if (options.read.encoding != Encoding::none && !options.read.channel.empty())
        throw BadInput{
            "--channel and --encoding are both there, but heights are in one channel or packed into three."};
    return options;
}

std::filesystem::path terrain_file(const TerrainOptions& options) {
    return options.terrain.value_or(bundled_terrain);
}

Terrain open_terrain(const TerrainOptions& options) {
    std::error_code none;
    const std::filesystem::path file = terrain_file(options);
    ReadOptions read = options.read;
    if (!options.terrain || std::filesystem::equivalent(file, bundled_terrain, none)) {
        if (!read.spacing) read.spacing = bundled_spacing;
        if (!read.unit) read.unit = 1.0;
        if (read.channel.empty() && read.encoding == Encoding::none) read.channel = "alpha";
    }
    return read_terrain(file, read);
}

hfh::GridFrame frame_of(const Terrain& terrain, const TerrainOptions& options) {
    return {.spacing = terrain.spacing.value_or(glm::dvec2{options.read.unit.value_or(1.0)}),
            .height_scale = options.height_scale * terrain.height_scale,
            .height_offset = options.height_scale * terrain.height_offset};
}

} // namespace demo
