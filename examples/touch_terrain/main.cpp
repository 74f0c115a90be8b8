#include "bad_input.hpp"
#include "device_in_hand.hpp"
#include "gnuplot.hpp"
#include "ground.hpp"
#include "numbers.hpp"
#include "options.hpp"
#include "picture.hpp"
#include "progress.hpp"
#include "record.hpp"
#include "session.hpp"
#include "stroke.hpp"
#include "trace.hpp"

#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>

namespace demo {
namespace {

constexpr const char* bundled_terrain = TOUCH_TERRAIN_BUNDLED;
constexpr glm::dvec2 bundled_spacing{73.596, 92.491}; // examples/data/README.md

/// Metres from sample to sample, if anybody says.
std::optional<glm::dvec2> spacing_of(const Options& options, const Terrain& terrain) {
    if (options.spacing) return options.spacing;
    if (terrain.spacing) return terrain.spacing;
    std::error_code none;
    const bool bundled =
        !options.terrain || std::filesystem::equivalent(*options.terrain, bundled_terrain, none);
    return bundled ? std::optional{bundled_spacing} : std::nullopt;
}

std::string describe(const Terrain& terrain, const Ground& ground) {
    return std::visit(
        [&](const auto& heights) {
            return std::to_string(heights.columns()) + " x " + std::to_string(heights.rows()) +
                   " samples every " + rounded(ground.cell.x, 5) + " x " + rounded(ground.cell.y, 5) + " m";
        },
        terrain.heights);
}

double percent(std::uint64_t updates, const Summary& summary) {
    return summary.updates == 0 ? 0.0
                                : 100.0 * static_cast<double>(updates) / static_cast<double>(summary.updates);
}

/// What the stylus is held by: nothing, or a simulated device.
struct Setup {
    double stiffness = 0;         ///< N/m in the hand; without a device, of terrain
    double terrain_stiffness = 0; ///< N per metre of terrain
    std::string device;           ///< empty: none
};

std::string caption(const Summary& summary, const std::string& terrain, const Setup& setup) {
    std::string what = terrain;
    for (std::size_t at; (at = what.find(" x ")) != std::string::npos;) what.replace(at, 3, " × ");
    return what + "; " + grouped(summary.updates) + " updates, " +
           rounded(percent(summary.in_contact, summary), 3) + " % in contact" +
           (setup.device.empty() ? "" : "; simulated " + setup.device) + "; stiffness " +
           rounded(setup.stiffness) + " N/m, largest force " + rounded(summary.largest_force) + " N";
}

/// The limits of a guard and how often they acted, and how often which cause tripped it.
std::string describe(const hfh::ForceGuard& guard) {
    std::string trips;
    for (int k = 1; k < hfh::guard_trip_count; ++k) {
        const unsigned times = guard.counts().trips[k];
        if (times == 0) continue;
        trips += trips.empty() ? "trips: " : ", ";
        trips.append(to_string(static_cast<hfh::GuardTrip>(k))).append(" ").append(grouped(times));
    }
    return "clamped " + grouped(guard.counts().clamped) + " updates to " + rounded(guard.limits().max_force) +
           " N, slewed " + grouped(guard.counts().slewed) + " to " + rounded(guard.limits().max_slew) +
           " N/ms, held back " + grouped(guard.counts().held_back) + "; " +
           (trips.empty() ? "no trips" : trips + " (see hfh/force_guard.hpp)");
}

void print(const Summary& summary, const std::string& terrain, const Options& options, const Setup& setup,
           const std::optional<DeviceInHand>& device) {
    const auto row = [](const Distribution& d) {
        return grouped(d.quantile(0.5)) + " median, " + grouped(d.quantile(0.999)) + " at 99.9 %, " +
               grouped(d.worst()) + " worst";
    };
    std::printf("terrain         %s\n", terrain.c_str());
    if (device) {
        std::printf("device          %s, simulated, in a hand; 1 mm there is %s m of terrain\n",
                    setup.device.c_str(), rounded(1e-3 * device->workspace().frame().scale).c_str());
        std::printf("guard           %s\n", describe(device->guard()).c_str());
    }
    std::printf("updates         %s in %s\n", grouped(summary.updates).c_str(),
                options.in_float ? "float" : "double");
    std::printf("in contact      %.1f %%\n", percent(summary.in_contact, summary));
    if (summary.buried > 0) {
        std::printf("buried          %.1f %%, below the surface without having met it\n",
                    percent(summary.buried, summary));
    }
    std::printf("patches         %s, per update\n", row(summary.patches).c_str());
    std::printf("time (ns)       %s, per update\n", row(summary.nanoseconds).c_str());
    std::printf("largest force   %s N at %s N/m\n", rounded(summary.largest_force).c_str(),
                rounded(setup.stiffness).c_str());
    std::printf("bytes kept beside the heights: 0 (the tracker remembers %zu in all)\n", summary.state_bytes);
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
    const hfh::WorkspaceFrame frame = fit(model, ground, wanted, room);
    if (!file) wanted = built_in_stroke(ground, depth * frame.scale);
    device.emplace(model, frame, setup.stiffness, std::move(wanted));
    setup.terrain_stiffness = device->workspace().terrain_stiffness(setup.stiffness);
}

void run(const Options& options) {
    if (options.picture) require_gnuplot();
    const Terrain terrain = read_terrain(options.terrain.value_or(bundled_terrain));
    const auto spacing = spacing_of(options, terrain);
    const hfh::GridFrame frame{.spacing = spacing.value_or(glm::dvec2{1.0}),
                               .height_scale = options.height_scale};
    const Ground ground = ground_of(terrain, frame);

    std::optional<StylusPathFile> file;
    std::vector<StylusSample> stroke;
    std::size_t at = 0;
    std::optional<DeviceInHand> device;
    Setup setup;
    if (options.path) file.emplace(*options.path);
    if (options.device == DeviceChoice::none) {
        if (!file) stroke = built_in_stroke(ground, stroke_depth(ground));
        setup.stiffness = options.stiffness.value_or(default_stiffness(ground));
        setup.terrain_stiffness = setup.stiffness;
    } else {
        put_in_hand(options, ground, file, device, setup);
    }
    const StylusSource path = [&]() -> std::optional<StylusSample> {
        if (device) return device->next();
        if (file) return file->next();
        return at < stroke.size() ? std::optional{stroke[at++]} : std::nullopt;
    };
    // A stylus on rails is in nobody's hand: no force moves it, none can hurt, and its path may be of any speed.
    const ForceSink feel = [&](const glm::dvec3& newtons, bool buried) {
        return device ? device->feel(newtons, buried) : hfh::GuardedForce{newtons};
    };
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
        summary = session(terrain, frame, setup.terrain_stiffness, path, feel, on_touch);
    }

    const std::string description = describe(terrain, ground);
    if (record) record->finish();
    if (picture) {
        draw_picture(*picture, ground, trace, terrain.name, caption(summary, description, setup));
    }
    if (record) record->keep();
    if (picture) picture->keep();
    const char* assumed = spacing ? "" : ", which the file does not say (see --spacing)";
    print(summary, terrain.name + ", " + description + assumed, options, setup, device);
}

} // namespace
} // namespace demo

int main(int argc, char** argv) {
    constexpr int bad_input = 2;
    try {
        if (const auto options = demo::read_options(argc, argv)) demo::run(*options);
        return 0;
    } catch (const demo::BadInput& error) {
        std::fprintf(stderr, "touch_terrain: %s\n", error.what());
    } catch (const std::exception& error) { // out of memory, a broken file system
        std::fprintf(stderr, "touch_terrain: cannot go on: %s.\n", error.what());
    }
    return bad_input;
}
