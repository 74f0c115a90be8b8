#include "bad_input.hpp"
#include "device_in_hand.hpp"
#include "gnuplot.hpp"
#include "ground.hpp"
#include "options.hpp"
#include "picture.hpp"
#include "progress.hpp"
#include "record.hpp"
#include "report.hpp"
#include "session.hpp"
#include "standard_streams.hpp"
#include "stroke.hpp"
#include "terrain_files.hpp"
#include "trace.hpp"

#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>

namespace demo {
namespace {

/// The terrain that `options` name. Refused if an output would take its place.
Terrain terrain_of(const Options& options) {
    Terrain terrain = open_terrain(options);
    const std::filesystem::path file = terrain_file(options);
    if (options.record) refuse_to_replace_terrain(file, "--record", *options.record);
    if (options.picture) refuse_to_replace_terrain(file, "--picture", *options.picture);
    return terrain;
}

/// The device of `options`, in a hand that wants to go along the path of `file` or along the built-in stroke.
void put_in_hand(const Options& options, const Ground& ground, std::optional<StylusPathFile>& file,
                 std::optional<DeviceInHand>& device, Setup& setup) {
    const bool premium = options.device == DeviceChoice::premium;
    const hfh::DeviceModel& model = premium ? hfh::simulated_premium : hfh::simulated_touch;
    setup.device = premium ? "Premium 1.5" : "Touch";
    setup.stiffness = options.stiffness.value_or(model.capabilities.max_stiffness);

    std::vector<StylusSample> wanted;
    const double depth = aim_depth(setup.stiffness);
    double room = 0;
    if (file) {
        while (const auto sample = file->next()) wanted.push_back(*sample);
    } else {
        wanted = built_in_stroke(ground, stroke_depth(ground));
        room = std::min(3 * depth, 0.4 * model.capabilities.workspace.z);
    }
    hfh::WorkspaceFrame frame = fit(model, ground, wanted, room);
    setup.tip = options.tip.radius(frame.scale);
    if (!file) {
        wanted = built_in_stroke(ground, depth * frame.scale, setup.tip);
        frame.offset.z += setup.tip;
    }
    device.emplace(model, frame, setup.stiffness, std::move(wanted));
}

void run(const Options& options) {
    if (options.picture) require_gnuplot();
    const Terrain terrain = terrain_of(options);
    const hfh::GridFrame frame = frame_of(terrain, options);
    const Ground ground = ground_of(terrain, frame, options.bridge);

    std::optional<StylusPathFile> file;
    std::vector<StylusSample> stroke;
    std::size_t at = 0;
    std::optional<DeviceInHand> device;
    Setup setup;
    if (options.path) file.emplace(*options.path);
    if (options.device == DeviceChoice::none) {
        setup.tip = options.tip.on_terrain;
        if (!file) stroke = built_in_stroke(ground, stroke_depth(ground), setup.tip);
        setup.stiffness = options.stiffness.value_or(default_stiffness(ground));
    } else {
        put_in_hand(options, ground, file, device, setup);
    }
    const auto next_on_rails = [&]() -> std::optional<StylusSample> {
        if (file) return file->next();
        return at < stroke.size() ? std::optional{stroke[at++]} : std::nullopt;
    };
    const StepSource path = [&]() -> std::optional<StylusStep> {
        if (device) return device->next();
        const auto sample = next_on_rails();
        if (!sample) return std::nullopt;
        return StylusStep{sample->t, {.time = sample->t, .position = sample->position}};
    };
    const ForceSink feel = [&](const glm::dvec3& newtons, bool buried) {
        if (device) device->feel(newtons, buried);
    };
    Feeling feeling{.loop = {.material = {.stiffness = setup.stiffness}, .tracker = {}, .lag = 0},
                    .guarded = false};
    if (device) feeling = {device->loop(), true};
    if (options.release_speed > 0) feeling.loop.release_speed = options.release_speed;
    feeling.tip = setup.tip;
    feeling.bridge = options.bridge;
    const auto done = [&] {
        return device ? device->progress()
               : file ? file->progress()
                      : static_cast<double>(at) / static_cast<double>(stroke.size());
    };

    std::optional<Record> record;
    if (options.record) record.emplace(*options.record);
    std::optional<OutputFile> picture;
    if (options.picture) picture.emplace(*options.picture);
    Trace trace;

    Summary summary;
    {
        Progress progress;
        unsigned long long updates = 0;
        const auto on_touch = [&](const Touch& touch) {
            if (record) record->add(touch);
            if (picture) trace.add(touch);
            progress.show(++updates, done());
        };
        const auto session = options.in_float ? touch_terrain<float> : touch_terrain<double>;
        summary = session(terrain, frame, feeling, path, feel, on_touch);
    }

    if (record) record->finish();
    if (picture) {
        draw_picture(*picture, ground, trace, terrain.name,
                     caption(summary, describe(terrain, ground), setup));
    }
    // Files come to stand under their names only once everything else has gone well, the report included.
    print(report(terrain, ground) + report(summary, options.in_float ? "float" : "double", setup, device));
    if (record) record->keep();
    if (picture) picture->keep();
}

} // namespace
} // namespace demo

int main(int argc, char** argv) {
    constexpr int bad_input = 2;
    try {
        demo::set_up_standard_streams();
        if (const auto options = demo::read_options(argc, argv)) demo::run(*options);
        return 0;
    } catch (const demo::BadInput& error) {
        std::fprintf(stderr, "touch_terrain: %s\n", error.what());
    } catch (const std::exception& error) { // out of memory, a broken file system
        std::fprintf(stderr, "touch_terrain: cannot go on: %s.\n", error.what());
    }
    return bad_input;
}
