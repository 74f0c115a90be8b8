#include "haptic_thread.hpp"
#include "offscreen.hpp"
#include "options.hpp"
#include "real_device.hpp"
#include "screenshot.hpp"
#include "viewer.hpp"
#include "window.hpp"

#include <bad_input.hpp>
#include <numbers.hpp>
#include <record.hpp>
#include <report.hpp>
#include <standard_streams.hpp>
#include <stroke.hpp>
#include <terrain_files.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>

namespace viewer {
namespace {

using Clock = std::chrono::steady_clock;

std::vector<demo::StylusSample> path_from(const std::filesystem::path& file) {
    demo::StylusPathFile rows{file};
    std::vector<demo::StylusSample> path;
    while (const auto sample = rows.next()) path.push_back(*sample);
    return path;
}

/// The stroke of touch_terrain, for a hand that presses with 1 N.
std::vector<demo::StylusSample> stroke_across(const demo::Terrain& terrain, const hfh::GridFrame& frame,
                                              const Options& options) {
    const demo::Ground ground = demo::ground_of(terrain, frame);
    const double at_hand = demo::aim_depth(options.stiffness.value_or(400));
    const double scale = whole_terrain_scale(options.device, ground.size);
    return demo::built_in_stroke(ground, at_hand * scale, options.tip.radius(scale));
}

/// A terrain as the options want it, and what is written about it. Refused if an output would take the terrain's place.
struct Program {
    explicit Program(const Options& asked);

    Options options;
    std::unique_ptr<RealDevice> device;
    std::optional<TouchedTerrain> touched;
    std::optional<demo::Record> record;
    std::optional<demo::OutputFile> screenshot;
};

Program::Program(const Options& asked) : options{asked} {
    demo::Terrain terrain = demo::open_terrain(options);
    const std::filesystem::path file = demo::terrain_file(options);
    if (options.record) demo::refuse_to_replace_terrain(file, "--record", *options.record);
    if (options.screenshot) demo::refuse_to_replace_terrain(file, "--screenshot", *options.screenshot);
    HapticsSettings settings;
    settings.device = options.device;
    settings.stiffness = options.stiffness;
    settings.tip = options.tip;
    settings.release_speed = options.release_speed;
    const hfh::GridFrame frame = demo::frame_of(terrain, options);
    if (options.device == DeviceKind::phantom) {
        device = open_phantom();
        settings.real_device = device->capabilities();
    }
    if (options.path)
        settings.path = path_from(*options.path);
    else if (options.screenshot)
        settings.path = stroke_across(terrain, frame, options);
    touched.emplace(std::move(terrain), frame, std::move(settings));
    if (options.record) record.emplace(*options.record);
    if (options.screenshot) screenshot.emplace(*options.screenshot);
}

/// Vertices along a side of a window: what the renderer draws at a good rate.
int window_size() { return is_software_renderer() ? 127 : 255; }

/// Draws without a window and without the clock: a frame is a thirtieth of a second of the hand's time.
void draw_screenshot(Program& program) {
    const OffscreenContext context;
    const glm::ivec2 size = program.options.size;
    const OffscreenFrame target{size, 4}, picture{size};
    // Text as large as in a window of an ordinary screen, however large the picture is.
    Viewer viewer{*program.touched, window_size(), std::max(1.0f, static_cast<float>(size.y) / 900)};
    if (program.record) viewer.record_to(&*program.record);
    constexpr double seconds = 1.0 / 30;
    const std::uint64_t frames = program.options.frames.value_or(300);
    for (std::uint64_t k = 0; k < frames; ++k) {
        for (double t = 0; t < seconds; t += Haptics::period()) program.touched->haptics.tick();
        target.bind();
        viewer.layer().begin_without_window(size, static_cast<float>(seconds));
        (void)viewer.frame({}, size, seconds, true);
    }
    target.resolve_into(picture);
    write_png(*program.screenshot, read_colours(size), size);
}

/// What calls the updates of the hand: a clock, or the driver of a real device.
class Loop {
public:
    explicit Loop(Program& program) : program_{&program} {}
    ~Loop() { stop(); }
    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;

    void start() {
        if (is_on_) return;
        is_on_ = true;
        Haptics& hand = program_->touched->haptics;
        if (program_->device)
            program_->device->start([&](const hfh::DeviceSample& sample) { return hand.update(sample); });
        else
            clock_.emplace([&] { hand.tick(); });
    }
    void tell(Viewer& viewer) const {
        if (clock_) viewer.set_real_time(clock_->is_real_time());
        if (!is_on_ || !program_->device) return;
        if (const std::string trouble = program_->device->trouble(); !trouble.empty()) viewer.say(trouble);
    }
    /// No force any more.
    void stop() {
        if (clock_) clock_->stop();
        if (program_->device) program_->device->stop();
        program_->touched->haptics.end();
    }
    /// After `stop`.
    [[nodiscard]] std::string report() const {
        if (program_->device) return program_->device->report();
        return clock_ ? viewer::report(clock_->punctuality()) : "";
    }

private:
    Program* program_;
    bool is_on_ = false;
    std::optional<HapticThread> clock_;
};

void run_in_window(Program& program) {
    Window window{program.touched->terrain.name + " - hfh viewer", program.options.size};
    Viewer viewer{*program.touched, window_size(), window.pixels()};
    if (program.record) viewer.record_to(&*program.record);
    const Window::LayerInput layer_input{window};
    Loop loop{program};
    std::uint64_t frames = 0;
    const auto start = Clock::now();
    auto last = start;
    while (window.is_open() && frames < program.options.frames.value_or(~std::uint64_t{0})) {
        viewer.layer().set_pixels(window.pixels());
        const FrameInput input = window.begin_frame(viewer);
        const auto now = Clock::now();
        const double seconds = std::chrono::duration<double>(now - last).count();
        last = now;
        // The hand begins once there is ground in memory under it.
        if (viewer.levels()) loop.start();
        loop.tell(viewer);
        const glm::ivec2 size = window.size();
        (void)viewer.frame(input, glm::max(size, 1), seconds, false);
        if (size.x > 0 && size.y > 0)
            window.show();
        else
            window.wait();
        ++frames;
    }
    loop.stop();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    demo::print(loop.report() + "frames          " + demo::grouped(frames) + ", " +
                demo::rounded(static_cast<double>(frames) / seconds) + " a second\n");
}

std::string guard_line(const hfh::GuardCounts& counts) {
    std::string trips;
    for (int k = 1; k < hfh::guard_trip_count; ++k)
        if (counts.trips[k] > 0)
            trips += (trips.empty() ? "" : ", ") + std::string{to_string(static_cast<hfh::GuardTrip>(k))} +
                     " " + demo::grouped(counts.trips[k]);
    return "guard trips     " + (trips.empty() ? "none" : trips) + "\n";
}

void run(const Options& options) {
    Program program{options};
    demo::print(demo::report(program.touched->terrain,
                             demo::ground_of(program.touched->terrain, program.touched->frame)));
    if (options.screenshot)
        draw_screenshot(program);
    else
        run_in_window(program);
    if (const std::uint64_t dropped = program.touched->haptics.rows().dropped();
        dropped > 0 && program.record)
        demo::print("record          " + demo::grouped(dropped) +
                    " updates are missing: the display was too slow\n");
    demo::print(guard_line(program.touched->haptics.guard_counts()));
    if (program.record) {
        program.record->finish();
        program.record->keep();
    }
    if (program.screenshot) program.screenshot->keep();
}

} // namespace
} // namespace viewer

int main(int argc, char** argv) {
    constexpr int bad_input = 2;
    try {
        demo::set_up_standard_streams();
        if (const auto options = viewer::read_options(argc, argv)) viewer::run(*options);
        return 0;
    } catch (const demo::BadInput& error) {
        std::fprintf(stderr, "hfh_viewer: %s\n", error.what());
    } catch (const std::exception& error) { // out of memory, a broken file system
        std::fprintf(stderr, "hfh_viewer: cannot go on: %s.\n", error.what());
    }
    return bad_input;
}
