#include "options.hpp"

#include "bad_input.hpp"
#include "numbers.hpp"
#include "standard_streams.hpp"
#include "terrain_files.hpp"
#include "units.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace demo {
namespace {

[[noreturn]] void refuse(const std::string& option, const std::string& value, const std::string& rule) {
    throw BadInput{option + " is " + shown(value) + ", but must be " + rule + "."};
}

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

double number_from(const std::string& option, const std::string& text, bool may_be_negative) {
    const auto value = parse_finite(text);
    const double size = value ? std::abs(*value) : 0.0;
    const bool fits = size >= 1e-12 && size <= 1e12 && (may_be_negative || *value > 0);
    if (!fits)
        refuse(option, text,
               std::string{"a number from 1e-12 to 1e12"} + (may_be_negative ? ", or its negative" : ""));
    return *value;
}

DeviceChoice device_from(const std::string& text) {
    if (text == "touch") return DeviceChoice::touch;
    if (text == "premium") return DeviceChoice::premium;
    if (text == "none") return DeviceChoice::none;
    refuse("--device", text, "touch, premium or none");
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

void refuse_same_file(const char* a, const std::optional<std::filesystem::path>& first, const char* b,
                      const std::optional<std::filesystem::path>& second) {
    if (!first || !second || !is_same_file(*first, *second)) return;
    throw BadInput{std::string{a} + " and " + b + " are both " + second->string() +
                   ", but each must be a file of its own."};
}

} // namespace

std::optional<Options> read_options(int argc, const char* const* argv) {
    CLI::App app{"Touches a terrain along a path of the stylus, and says what is felt.", "touch_terrain"};
    std::string terrain, spacing, unit, channel, encoding, height_scale, path, device, stiffness, record,
        picture;
    Options options;
    app.add_option(
        "TERRAIN", terrain,
        "Heights, north row first: .png (8 or 16 bit; the alpha channel if it has one that varies, else "
        "grey), .bil or .flt beside their .hdr"
#ifdef TOUCH_TERRAIN_HAS_GDAL
        ", or anything that GDAL opens, its names of subdatasets and /vsi paths included"
#endif
        ". Default: the Spanish Peaks");
    app.add_option("--spacing", spacing,
                   "Metres from sample to sample, east and north. Default: what the file says (degrees and "
                   "Mercator in "
                   "metres on the ground at the middle latitude), else 1")
        ->type_name("DX[,DY]");
    app.add_option("--unit", unit,
                   "Of the samples, and of the spacing in a file that names no map: m, km, dm, cm, mm, um, "
                   "nm, ft, us-ft, in, yd or mi. Default: what the file says, else m")
        ->type_name("UNIT");
    app.add_option("--channel", channel,
                   "Where the heights are in a file of several channels or bands: grey, red, green, blue, "
                   "alpha or a number from 1")
        ->type_name("CHANNEL");
    app.add_option("--encoding", encoding,
                   "Heights packed into red, green and blue: terrarium, or mapbox (Terrain-RGB)")
        ->type_name("ENCODING");
    app.add_option("--height-scale", height_scale, "Multiplies the heights. Default: 1")->type_name("S");
    app.add_option("--path", path,
                   "Positions of the stylus, header t,x,y,z, in seconds and metres from the south-west "
                   "sample. Default: a stroke across the terrain, 20 s at 1 kHz")
        ->type_name("FILE.csv");
    app.add_option(
           "--device", device,
           "touch or premium: a simulated device, in a hand that wants to go along the path and gives "
           "way to the force, which goes through a guard; below the surface it moves up until it is out. "
           "none: the stylus is on the path, whatever the force. Default: touch; with --path none")
        ->type_name("DEVICE");
    app.add_option(
           "--stiffness", stiffness,
           "Newtons per metre of depth: in the hand, by default the device's; without a device in the "
           "terrain, by default 2 N at a quarter of a cell")
        ->type_name("K");
    app.add_option("--record", record,
                   "Writes one row per update: where the stylus was, what was found there, and the force "
                   "that was felt")
        ->type_name("FILE.csv");
    app.add_option("--picture", picture,
                   "Draws the path on the terrain and the force over time (needs gnuplot)")
        ->type_name("FILE.png");
    app.add_flag("--float", options.in_float, "Computes in float instead of double");

    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        print(app.help());
        return std::nullopt;
    } catch (const CLI::ParseError& error) {
        std::string what = error.what();
        std::ranges::replace(what, '\n', ' ');
        throw BadInput{"The command line cannot be read (see --help): " + what +
                       (what.ends_with('.') ? "" : ".")};
    }

    const auto file = [&](const char* option,
                          const std::string& name) -> std::optional<std::filesystem::path> {
        if (app.count(option) == 0) return std::nullopt;
        if (name.empty()) refuse(option, name, "the name of a file");
        return name;
    };
    options.terrain = file("TERRAIN", terrain);
    options.path = file("--path", path);
    options.record = file("--record", record);
    options.picture = file("--picture", picture);
    if (app.count("--spacing") != 0) options.read.spacing = spacing_from(spacing);
    if (app.count("--unit") != 0) options.read.unit = unit_from(unit);
    if (app.count("--channel") != 0) options.read.channel = channel_from(channel);
    if (app.count("--encoding") != 0) options.read.encoding = encoding_from(encoding);
    if (app.count("--height-scale") != 0)
        options.height_scale = number_from("--height-scale", height_scale, true);
    if (options.read.encoding != Encoding::none && !options.read.channel.empty())
        throw BadInput{
            "--channel and --encoding are both there, but heights are in one channel or packed into three."};
    if (app.count("--device") != 0) {
        options.device = device_from(device);
    } else if (options.path) {
        options.device = DeviceChoice::none;
    }
    if (app.count("--stiffness") != 0) options.stiffness = number_from("--stiffness", stiffness, false);

    refuse_same_file("--record", options.record, "--picture", options.picture);
    refuse_same_file("--path", options.path, "--record", options.record);
    refuse_same_file("--path", options.path, "--picture", options.picture);
    refuse_same_file("TERRAIN", options.terrain, "--record", options.record);
    refuse_same_file("TERRAIN", options.terrain, "--picture", options.picture);
    return options;
}

} // namespace demo
