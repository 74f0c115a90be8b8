#include "options.hpp"

#include <bad_input.hpp>
#include <command_options.hpp>
#include <numbers.hpp>

#include <CLI/CLI.hpp>

#include <string>

namespace viewer {
namespace {

DeviceKind device_from(const std::string& text) {
    if (text == "touch") return DeviceKind::touch;
    if (text == "premium") return DeviceKind::premium;
    if (text == "none") return DeviceKind::none;
    if (text == "phantom") return DeviceKind::phantom;
    demo::refuse("--device", text, "touch, premium, phantom or none");
}

int pixels_from(std::string_view text, const std::string& whole) {
    const auto pixels = demo::parse_number<int>(text);
    if (!pixels || *pixels < 64 || *pixels > 16384)
        demo::refuse("--size", whole, "a width and a height, WxH, each from 64 to 16384 pixels");
    return *pixels;
}

glm::ivec2 size_from(const std::string& text) {
    const std::size_t by = text.find('x');
    const std::string_view whole = text;
    return {pixels_from(whole.substr(0, by), text),
            pixels_from(by == std::string::npos ? "" : whole.substr(by + 1), text)};
}

std::uint64_t frames_from(const std::string& text) {
    const auto frames = demo::parse_number<std::uint64_t>(text);
    if (!frames || *frames < 1 || *frames > 1'000'000'000)
        demo::refuse("--frames", text, "a whole number from 1 to 1000000000");
    return *frames;
}

} // namespace

std::optional<Options> read_options(int argc, const char* const* argv) {
    CLI::App app{"Shows a terrain, and lets a mouse touch it.", "hfh_viewer"};
    demo::TerrainCommandLine terrain{app};
    const demo::TipCommandLine tip{app};
    std::string device, stiffness, path, record, screenshot, frames, size;
    app.add_option("--device", device,
                   "touch or premium: a simulated device in the hand, which gives way to the force. none: "
                   "the stylus is "
                   "where the hand wants to be, whatever the force. phantom: your own, in place of the "
                   "mouse, where the "
                   "OpenHaptics SDK was found. Default: touch")
        ->type_name("DEVICE");
    app.add_option("--stiffness", stiffness,
                   "Newtons per metre of depth in the hand. Default: 0.8 of the device's")
        ->type_name("K");
    app.add_option(
           "--path", path,
           "Positions of the hand in place of the mouse's, header t,x,y,z, in seconds and metres from the "
           "south-west sample")
        ->type_name("FILE.csv");
    app.add_option("--record", record, "Writes one row per update of the hand, as touch_terrain does")
        ->type_name("FILE.csv");
    app.add_option("--size", size, "Of the window, pixels. Default: 1280x720")->type_name("WxH");
    app.add_option("--frames", frames, "Ends after so many frames")->type_name("N");
    app.add_option("--screenshot", screenshot,
                   "Draws without a window, a thirtieth of a second a frame, and writes the last frame. The "
                   "hand goes "
                   "along the path, or along a stroke across the terrain. Default of --frames is then 300")
        ->type_name("FILE.png");
    if (!demo::read_command_line(app, argc, argv)) return std::nullopt;

    Options options;
    static_cast<demo::TerrainOptions&>(options) = terrain.options();
    options.read.for_editing = true;
    options.path = demo::file_from(app, "--path", path);
    options.record = demo::file_from(app, "--record", record);
    options.screenshot = demo::file_from(app, "--screenshot", screenshot);
    if (app.count("--device") != 0) options.device = device_from(device);
    if (app.count("--stiffness") != 0) options.stiffness = demo::number_from("--stiffness", stiffness, false);
    options.tip = tip.tip();
    options.release_speed = tip.release_speed();
    if (app.count("--frames") != 0) options.frames = frames_from(frames);
    if (app.count("--size") != 0) options.size = size_from(size);
    if (options.device == DeviceKind::phantom && (options.path || options.screenshot))
        throw demo::BadInput{
            std::string{"--device phantom is moved by your hand in a window, and not with "} +
            (options.path ? "--path." : "--screenshot.")};
    demo::refuse_same_file("--record", options.record, "--screenshot", options.screenshot);
    demo::refuse_same_file("--path", options.path, "--record", options.record);
    demo::refuse_same_file("--path", options.path, "--screenshot", options.screenshot);
    demo::refuse_same_file("TERRAIN", options.terrain, "--record", options.record);
    demo::refuse_same_file("TERRAIN", options.terrain, "--screenshot", options.screenshot);
    return options;
}

} // namespace viewer
