// The viewer's three threads without its drawing: a haptic thread that ticks, a loader that fills windows, and this one, which
// tells the hand what a person does and takes what comes back, as a display would. By its results alone, and under the thread
// sanitizer (see CMakeLists.txt; exit status 66 is the sanitizer's).

#include <haptic_thread.hpp>
#include <level_loader.hpp>
#include <save_terrain.hpp>
#include <touched_terrain.hpp>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <unistd.h>

namespace {

int failures = 0;
void expect(bool holds, const char* what) {
    if (holds) return;
    ++failures;
    std::printf("FAILED: %s\n", what);
}

demo::Terrain hills(hfh::Index side) {
    auto samples = std::make_shared<std::vector<float>>();
    for (hfh::Index j = 0; j < side; ++j)
        for (hfh::Index i = 0; i < side; ++i)
            samples->push_back(static_cast<float>(30 * std::sin(0.05 * static_cast<double>(i)) *
                                                  std::cos(0.07 * static_cast<double>(j))));
    return {.name = "made",
            .storage = samples,
            .heights = demo::Heights<float>{samples->data(), side, side, demo::NoData<float>{}},
            .spacing = std::nullopt,
            .assumed = {}};
}

/// A person who moves, presses and digs, zooms in and out, changes the feel, undoes and goes home.
void act(int frame, viewer::HandInput& told) {
    const double t = 0.02 * frame;
    told.has_pointer = true;
    told.pointer = {{0.02 * std::sin(2 * t), 0.02 * std::cos(3 * t), 0.2}, {0, 0, -1}};
    told.pressing = frame % 100 > 5;
    told.brush.kind = frame % 25 < 20 ? viewer::BrushKind::dig : viewer::BrushKind::none;
    told.zoom += frame % 120 < 60 ? 0.05 : -0.05;
    if (!told.pressing) told.pan += glm::dvec2{1e-4, -1e-4};
    told.feel.friction = frame % 80 < 40 ? 0.3 : 0.0;
    told.undos += frame % 50 == 3;
    told.resets += frame % 100 == 99;
}

void run(const std::filesystem::path& folder) {
    viewer::TouchedTerrain touched{hills(513), {.spacing = {10, 10}}, {}};
    viewer::LevelLoader loader{touched.displayed, 63, static_cast<int>(touched.ground->coarsest_level())};
    viewer::HapticThread haptic{[&] { touched.haptics.tick(); }};
    viewer::HandInput told;
    viewer::HandState hand;
    std::uint64_t rows = 0, touches = 0, edits = 0;
    double checksum = 0;
    for (int frame = 0; frame < 200; ++frame) {
        (void)touched.haptics.show(hand);
        touched.haptics.rows().drain([&](const demo::Touch& touch) { ++rows, touches += touch.contact; });
        act(frame, told);
        viewer::LevelRequest request{.place = glm::dvec2{hand.proxy} / touched.displayed.spacing,
                                     .finest = static_cast<int>(hand.wanted_level)};
        if (hand.edit != edits) request.changed = hand.edited;
        edits = request.edit = told.edits_seen = hand.edit;
        loader.ask(request);
        if (const auto levels = loader.newest()) {
            told.finest_loaded = levels->levels.front()->level;
            for (const viewer::LevelVertex& v : levels->levels.front()->vertices)
                checksum += static_cast<double>(v.height);
        }
        touched.haptics.tell(told);
        if (frame == 150) viewer::save_terrain(touched.terrain, touched.frame, folder / "saved.flt");
        std::this_thread::sleep_for(std::chrono::milliseconds{8});
    }
    loader.wait();
    haptic.stop();
    touched.haptics.end();
    (void)touched.haptics.show(hand);
    expect(hand.force == glm::dvec3{0.0}, "no force is left");
    expect(rows > 0 && touches > 0, "the hand touches");
    expect(hand.edit > 5, "the hand digs");
    expect(loader.newest() != nullptr && std::isfinite(checksum), "levels are loaded");
    expect(haptic.punctuality().ticks >= rows, "no row is told twice");
}

} // namespace

int main() {
    const auto folder =
        std::filesystem::temp_directory_path() / ("hfh_viewer_threads_" + std::to_string(::getpid()));
    std::filesystem::create_directory(folder);
    run(folder);
    std::error_code none;
    std::filesystem::remove_all(folder, none);
    return failures == 0 ? 0 : 1;
}
