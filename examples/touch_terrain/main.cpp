#include "bad_input.hpp"
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

hfh::GridFrame frame_for(const Options& options, const Terrain& terrain) {
    std::error_code none;
    const bool bundled =
        !options.terrain || std::filesystem::equivalent(*options.terrain, bundled_terrain, none);
    const glm::dvec2 otherwise = bundled ? bundled_spacing : glm::dvec2{1.0};
    return {.spacing = options.spacing.value_or(terrain.spacing.value_or(otherwise)),
            .height_scale = options.height_scale};
}

std::string describe(const Terrain& terrain, const Ground& ground) {
    return std::visit(
        [&](const auto& heights) {
            return std::to_string(heights.columns()) + " x " + std::to_string(heights.rows()) +
                   " samples every " + rounded(ground.cell.x, 5) + " x " + rounded(ground.cell.y, 5) + " m";
        },
        terrain.heights);
}

double percent(const Summary& summary) {
    return summary.updates == 0
               ? 0.0
               : 100.0 * static_cast<double>(summary.in_contact) / static_cast<double>(summary.updates);
}

std::string caption(const Summary& summary, const std::string& terrain, double stiffness) {
    std::string what = terrain;
    for (std::size_t at; (at = what.find(" x ")) != std::string::npos;) what.replace(at, 3, " × ");
    return what + "; " + grouped(summary.updates) + " updates, " + rounded(percent(summary), 3) +
           " % in contact; stiffness " + rounded(stiffness) + " N/m, largest force " +
           rounded(summary.largest_force) + " N";
}

void print(const Summary& summary, const std::string& terrain, const Options& options, double stiffness) {
    const auto row = [](const Distribution& d) {
        return grouped(d.quantile(0.5)) + " median, " + grouped(d.quantile(0.999)) + " at 99.9 %, " +
               grouped(d.worst()) + " worst";
    };
    std::printf("terrain         %s\n", terrain.c_str());
    std::printf("updates         %s in %s\n", grouped(summary.updates).c_str(),
                options.in_float ? "float" : "double");
    std::printf("in contact      %.1f %%\n", percent(summary));
    std::printf("patches         %s, per update\n", row(summary.patches).c_str());
    std::printf("time (ns)       %s, per update\n", row(summary.nanoseconds).c_str());
    std::printf("largest force   %s N at %s N/m\n", rounded(summary.largest_force).c_str(),
                rounded(stiffness).c_str());
    std::printf("bytes kept beside the heights: 0 (the tracker remembers %zu in all)\n", summary.state_bytes);
}

void run(const Options& options) {
    if (options.picture) require_gnuplot();
    const Terrain terrain = read_terrain(options.terrain.value_or(bundled_terrain));
    const hfh::GridFrame frame = frame_for(options, terrain);
    const Ground ground = ground_of(terrain, frame);
    const double stiffness = options.stiffness.value_or(default_stiffness(ground));

    std::optional<StylusPathFile> file;
    std::vector<StylusSample> stroke;
    std::size_t at = 0;
    if (options.path) {
        file.emplace(*options.path);
    } else {
        stroke = built_in_stroke(ground);
    }
    const StylusSource path = [&]() -> std::optional<StylusSample> {
        if (file) return file->next();
        return at < stroke.size() ? std::optional{stroke[at++]} : std::nullopt;
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
            progress.show(++updates, file ? file->progress()
                                          : static_cast<double>(at) / static_cast<double>(stroke.size()));
        };
        summary = options.in_float ? touch_terrain<float>(terrain, frame, stiffness, path, on_touch)
                                   : touch_terrain<double>(terrain, frame, stiffness, path, on_touch);
    }

    const std::string description = describe(terrain, ground);
    if (record) record->finish();
    if (picture) {
        draw_picture(*picture, ground, trace, terrain.name, caption(summary, description, stiffness));
    }
    if (record) record->keep();
    if (picture) picture->keep();
    print(summary, terrain.name + ", " + description, options, stiffness);
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
