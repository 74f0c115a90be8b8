#include "options.hpp"

#include "bad_input.hpp"
#include "command_options.hpp"
#include "numbers.hpp"

#include <CLI/CLI.hpp>

#include <string>

namespace demo {
namespace {

DeviceChoice device_from(const std::string& text) {
    if (text == "touch") return DeviceChoice::touch;
    if (text == "premium") return DeviceChoice::premium;
    if (text == "none") return DeviceChoice::none;
    refuse("--device", text, "touch, premium or none");
}

hfh::Index width_from(const std::string& text) {
    const auto cells = parse_number<int>(text);
    if (!cells || *cells < 2 || *cells > 1000)
        refuse("--bridge", text, "a whole number of cells from 2 to 1000");
    return *cells;
}

} // namespace

std::optional<Options> read_options(int argc, const char* const* argv) {
    CLI::App app{"Touches a terrain along a path of the stylus, and says what is felt.", "touch_terrain"};
    Options options;
    TerrainCommandLine terrain{app};
    std::string path, device, stiffness, record, picture, bridge;
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
    const TipCommandLine tip{app};
    app.add_option("--record", record,
                   "Writes one row per update: where the stylus was, what was found there, and the force "
                   "that was felt")
        ->type_name("FILE.csv");
    app.add_option("--picture", picture,
                   "Draws the path on the terrain and the force over time (needs gnuplot)")
        ->type_name("FILE.png");
    app.add_option("--bridge", bridge,
                   "Spans holes up to so many cells wide from the heights around them, 2 to 1000")
        ->type_name("CELLS");
    app.add_flag("--float", options.in_float, "Computes in float instead of double");

    if (!read_command_line(app, argc, argv)) return std::nullopt;

    static_cast<TerrainOptions&>(options) = terrain.options();
    options.path = file_from(app, "--path", path);
    options.record = file_from(app, "--record", record);
    options.picture = file_from(app, "--picture", picture);
    if (app.count("--device") != 0) {
        options.device = device_from(device);
    } else if (options.path) {
        options.device = DeviceChoice::none;
    }
    if (app.count("--stiffness") != 0) options.stiffness = number_from("--stiffness", stiffness, false);

    options.tip = tip.tip();
    if (options.tip.at_hand > 0 && options.device == DeviceChoice::none)
        throw BadInput{
            "--tip-hand is in millimetres of a hand, but with --device none there is no hand; take "
            "--tip."};
    options.release_speed = tip.release_speed();
    if (options.release_speed > 0 && options.device == DeviceChoice::none)
        throw BadInput{"--release is in millimetres of a hand, but with --device none there is no hand."};
    if (app.count("--bridge") != 0) options.bridge = width_from(bridge);

    refuse_same_file("--record", options.record, "--picture", options.picture);
    refuse_same_file("--path", options.path, "--record", options.record);
    refuse_same_file("--path", options.path, "--picture", options.picture);
    refuse_same_file("TERRAIN", options.terrain, "--record", options.record);
    refuse_same_file("TERRAIN", options.terrain, "--picture", options.picture);
    return options;
}

} // namespace demo
