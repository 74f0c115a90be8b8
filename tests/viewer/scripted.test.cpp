#include "catch.hpp"

#include "stage.hpp"

#include <haptic_thread.hpp>
#include <record.hpp>

#include <glm/geometric.hpp>

#include <filesystem>
#include <fstream>
#include <sstream>

// A scripted pointer does what a person would: touches, presses, zooms, digs.

using namespace viewer_tests;

namespace {

FrameInput zooming(FrameInput input, double doublings) {
    input.zoom = doublings;
    return input;
}

/// The middle of the pixels that have the proxy's colour, from the top left; and how many.
std::pair<glm::dvec2, int> find_proxy(const glm::ivec2& size) {
    const auto colours = viewer::read_colours(size);
    glm::dvec2 sum{0.0};
    int count = 0;
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
            const std::uint8_t* const rgb =
                &colours[3 * static_cast<std::size_t>((size.y - 1 - y) * size.x + x)];
            // Yellow, lit more or less: much more red and green than blue.
            if (rgb[0] > 130 && rgb[1] > 120 && rgb[2] < 0.42 * rgb[0])
                sum += glm::dvec2{x + 0.5, y + 0.5}, ++count;
        }
    }
    return {count > 0 ? sum / static_cast<double>(count) : sum, count};
}

} // namespace

TEST_CASE("a press touches, and its release lets go", "[scripted]") {
    const auto context = context_or_skip();
    if (!context) return;
    Stage stage{bundled_terrain(), bundled_frame, {320, 200}};
    (void)stage.frames(15, stage.pointing(0.5, 0.5));
    CHECK_FALSE(stage.hand().touching());
    CHECK(stage.hand().force == glm::dvec3{0.0});
    (void)stage.frames(40, stage.pointing(0.5, 0.5, true));
    CHECK(stage.hand().touching());
    const double early = glm::length(stage.hand().force);
    CHECK(early > 0.5);
    (void)stage.frames(60, stage.pointing(0.5, 0.5, true));
    CHECK(glm::length(stage.hand().force) > early); // more firmly the longer
    (void)stage.frames(15, stage.pointing(0.5, 0.5));
    CHECK_FALSE(stage.hand().touching());
    CHECK(stage.hand().force == glm::dvec3{0.0});
}

TEST_CASE("the stylus comes to rest under the pointer, wherever it points", "[scripted]") {
    const auto context = context_or_skip();
    if (!context) return;
    Stage stage{bundled_terrain(), bundled_frame, {640, 400}};
    for (const glm::dvec2& at : {glm::dvec2{0.5, 0.5}, {0.42, 0.7}, {0.6, 0.35}, {0.48, 0.45}}) {
        (void)stage.frames(40, stage.pointing(at.x, at.y));
        const viewer::HandState& hand = stage.hand();
        const glm::dvec3 seen = stage.shown.camera().pixel(hand.to_hand(hand.proxy), stage.target.size());
        CHECK(std::abs(seen.x - at.x * 640) < 4);
        CHECK(std::abs(seen.y - at.y * 400) < 4);
    }
}

TEST_CASE("zooming from the whole terrain into one cell and back loses no touch", "[scripted]") {
    const auto context = context_or_skip();
    if (!context) return;
    Stage stage{bundled_terrain(), bundled_frame, {320, 200}};
    (void)stage.frames(15, stage.pointing(0.5, 0.5));
    (void)stage.frames(60, stage.pointing(0.5, 0.5, true));
    REQUIRE(stage.hand().touching());
    int lost = 0;
    double largest_step = 0;
    glm::dvec3 force = stage.hand().force;
    const auto watch = [&](const viewer::HandState& hand) {
        lost += !hand.touching();
        largest_step = std::max(largest_step, glm::length(hand.force - force));
        force = hand.force;
    };
    const double before = stage.hand().scale;
    (void)stage.frames(110, zooming(stage.pointing(0.5, 0.5, true), 0.1), watch);
    CHECK(stage.hand().scale < before / 1500);
    CHECK(73.596 / stage.hand().scale > 0.2); // a cell is wider than the picture
    (void)stage.frames(110, zooming(stage.pointing(0.5, 0.5, true), -0.1), watch);
    CHECK(stage.hand().scale > before / 2);
    CHECK(lost == 0);
    INFO("largest step of the force " << largest_step << " N");
    // A step of the encoders along each axis, behind the virtual coupling: 0.055 mm at 1.75 · 400 N/m.
    CHECK(largest_step < std::sqrt(3.0) * 0.055e-3 * 1.75 * 400);
}

TEST_CASE("a ball rests on the ground, keeps its size in the hand while zooming, and loses no touch",
          "[scripted]") {
    const auto context = context_or_skip();
    if (!context) return;
    viewer::HapticsSettings settings;
    settings.tip.at_hand = 5e-3;
    Stage stage{bundled_terrain(), bundled_frame, {640, 400}, settings};
    (void)stage.frames(15, stage.pointing(0.5, 0.5));
    (void)stage.frames(60, stage.pointing(0.5, 0.5, true));
    REQUIRE(stage.hand().touching());
    int lost = 0;
    double largest_step = 0, largest_misfit = 0;
    glm::dvec3 force = stage.hand().force;
    const auto watch = [&](const viewer::HandState& hand) {
        lost += !hand.touching();
        largest_step = std::max(largest_step, glm::length(hand.force - force));
        force = hand.force;
        largest_misfit = std::max(largest_misfit, std::abs(hand.tip / hand.scale - 5e-3));
    };
    const double before = stage.hand().scale;
    (void)stage.frames(70, zooming(stage.pointing(0.5, 0.5, true), 0.1), watch);
    CHECK(stage.hand().scale < before / 100);
    (void)stage.frames(70, zooming(stage.pointing(0.5, 0.5, true), -0.1), watch);
    CHECK(lost == 0);
    CHECK(largest_misfit < 1e-9);
    INFO("largest step of the force " << largest_step << " N");
    CHECK(largest_step < 0.5);

    // As large as it is felt, on the ground, and yellow.
    (void)stage.frames(30, stage.pointing(0.5, 0.5, true));
    const viewer::HandState& hand = stage.hand();
    const double ground = stage.touched.ground->height({hand.proxy.x, hand.proxy.y});
    CHECK(hand.proxy.z >= ground + hand.tip * (1 - 1e-6));
    CHECK(hand.proxy.z < ground + 2 * hand.tip);
    const double radius = 5e-3 / stage.shown.camera().pixel_size(stage.target.size()); // pixels
    const auto [seen, count] = find_proxy(stage.target.size());
    CHECK(radius > 8);
    CHECK(count > static_cast<int>(0.5 * radius * radius));

    // The panel's slider acts while it touches; without a radius it is a point again.
    stage.shown.settings().feel.tip = {.on_terrain = 200, .at_hand = 0};
    (void)stage.frames(2, stage.pointing(0.5, 0.5, true));
    CHECK(stage.hand().tip == 200);
    CHECK(stage.hand().touching());
    stage.shown.settings().feel.tip = {};
    (void)stage.frames(2, stage.pointing(0.5, 0.5, true));
    CHECK(stage.hand().tip == 0);
}

TEST_CASE("on a screen of another scale text and panel are as they would have been from the start",
          "[scripted]") {
    const auto context = context_or_skip();
    if (!context) return;
    const auto seen = [](bool changes) {
        viewer::TouchedTerrain touched{bundled_terrain(), bundled_frame, {}};
        const glm::ivec2 size{1280, 960};
        viewer::OffscreenFrame target{size};
        viewer::Viewer shown{touched, 127, changes ? 1.0f : 2.0f};
        shown.settings().shows_panel = shown.settings().shows_keys = true;
        for (int k = 0; k < 6; ++k) {
            if (k == 3) shown.layer().set_pixels(2);
            target.bind();
            shown.layer().begin_without_window(size, 0.02f);
            (void)shown.frame({}, size, 0.02, true);
        }
        return viewer::read_colours(size);
    };
    CHECK(seen(true) == seen(false));
}

TEST_CASE("what is touched stays in the picture, from the whole terrain into one cell and out again",
          "[scripted]") {
    const auto context = context_or_skip();
    if (!context) return;
    Stage stage{bundled_terrain(), bundled_frame, {320, 200}};
    stage.shown.hide_text();
    // Far from the middle, so that the middle of the picture is in other cells than the hand.
    (void)stage.frames(15, stage.pointing(0.62, 0.6));
    (void)stage.frames(30, stage.pointing(0.62, 0.6, true));
    REQUIRE(stage.hand().touching());
    for (int k = 0; k < 26; ++k) {
        (void)stage.frames(8, zooming(stage.pointing(0.62, 0.6, true), k < 13 ? 0.1 : -0.1));
        const viewer::HandState& hand = stage.hand();
        const glm::dvec3 at = stage.shown.camera().pixel(hand.to_hand(hand.proxy), stage.target.size());
        INFO("a millimetre of hand is " << 1e-3 * hand.scale << " m; the proxy is at " << at.x << ", "
                                        << at.y);
        CHECK(std::abs(at.x - 0.62 * 320) < 60);
        CHECK(std::abs(at.y - 0.6 * 200) < 60);
        const auto [seen, count] = find_proxy(stage.target.size());
        CHECK(count > 10);
        CHECK(glm::length(seen - glm::dvec2{at}) < 6);
    }
}

TEST_CASE("the proxy's marker is on the ground and where the record says", "[scripted]") {
    const auto context = context_or_skip();
    if (!context) return;
    const auto file =
        std::filesystem::temp_directory_path() / ("hfh_viewer_record_" + std::to_string(::getpid()) + ".csv");
    Stage stage{bundled_terrain(), bundled_frame, {640, 400}};
    stage.shown.hide_text();
    {
        demo::Record record{file};
        stage.shown.record_to(&record);
        (void)stage.frames(15, stage.pointing(0.55, 0.55));
        (void)stage.frames(50, zooming(stage.pointing(0.55, 0.55, true), 0.05));
        record.finish();
        record.keep();
        stage.shown.record_to(nullptr);
    }
    std::ifstream in{file};
    std::string line, last;
    std::size_t rows = 0;
    while (std::getline(in, line)) last = line, ++rows;
    std::filesystem::remove(file);
    CHECK(rows == 1 + 65 * 20);
    std::istringstream fields{last};
    std::vector<double> values;
    for (std::string field; std::getline(fields, field, ',') && values.size() < 14;)
        values.push_back(std::stod(field));
    REQUIRE(values.size() == 14);
    const glm::dvec3 proxy{values[5], values[6], values[7]};
    CHECK(values[4] == 1);

    const double ground = stage.touched.ground->height({proxy.x, proxy.y});
    CHECK(proxy.z == Approx(ground).epsilon(1e-9));
    const viewer::HandState& hand = stage.hand();
    const glm::dvec3 expected = stage.shown.camera().pixel(hand.to_hand(proxy), stage.target.size());
    const auto [seen, count] = find_proxy(stage.target.size());
    CHECK(count > 20);
    INFO("expected at " << expected.x << ", " << expected.y << ", seen at " << seen.x << ", " << seen.y);
    CHECK(glm::length(seen - glm::dvec2{expected}) < 4);
}

TEST_CASE("a hole that is dug is seen at once, felt, and can be undone", "[scripted]") {
    const auto context = context_or_skip();
    if (!context) return;
    Stage stage{bundled_terrain(), bundled_frame, {320, 200}};
    const auto all_samples = [&] {
        double sum = 0;
        for (hfh::Index j = 0; j < 300; ++j)
            for (hfh::Index i = 0; i < 300; ++i)
                sum += static_cast<double>(i + 301 * j) * stage.touched.displayed.sample(i, j);
        return sum;
    };
    const double untouched = all_samples();
    (void)stage.frames(15, stage.pointing(0.5, 0.5));
    (void)stage.frames(40, zooming(stage.pointing(0.5, 0.5, true), 0.1));
    const double before = stage.hand().proxy.z;
    FrameInput digging = stage.pointing(0.5, 0.5, true);
    digging.brush = viewer::BrushKind::dig;
    (void)stage.frames(60, digging);
    CHECK(stage.hand().touching());
    CHECK(stage.hand().proxy.z < before - 5);
    CHECK(stage.hand().undoable == 1);
    CHECK(all_samples() != untouched);
    CHECK(stage.shown.levels()->edit == stage.hand().edit); // what is drawn is what was dug

    FrameInput lifting = stage.pointing(0.5, 0.5);
    (void)stage.frames(10, lifting);
    lifting.undoes = true;
    (void)stage.frames(20, lifting);
    CHECK(stage.hand().undoable == 0);
    CHECK(all_samples() == untouched);
}

TEST_CASE("an edit is drawn within two frames", "[scripted]") {
    const auto context = context_or_skip();
    if (!context) return;
    Stage stage{bundled_terrain(), bundled_frame, {320, 200}};
    (void)stage.frames(15, stage.pointing(0.5, 0.5));
    FrameInput digging = stage.pointing(0.5, 0.5, true);
    digging.brush = viewer::BrushKind::dig;
    digging.zoom = 0.1;
    (void)stage.frames(30, digging);
    digging.zoom = 0;
    for (int k = 0; k < 20; ++k) {
        const std::uint64_t edit = stage.hand().edit;
        (void)stage.frame(digging);
        (void)stage.frame(digging);
        CHECK(stage.shown.levels()->edit >= edit);
    }
}

TEST_CASE("digging tells the display in millimetres of hand what the record tells in metres", "[scripted]") {
    const auto context = context_or_skip();
    if (!context) return;
    Stage stage{bundled_terrain(), bundled_frame, {320, 200}};
    (void)stage.frames(60, stage.pointing(0.5, 0.5, true));
    const viewer::HandState& hand = stage.hand();
    const glm::dvec3 at_hand = hand.to_hand(hand.stylus);
    CHECK(glm::length(at_hand - hand.hand) < 1e-9);
}

TEST_CASE("moving the terrain keeps the ground under the hand", "[scripted]") {
    const auto context = context_or_skip();
    if (!context) return;
    Stage stage{bundled_terrain(), bundled_frame, {320, 200}};
    (void)stage.frames(20, stage.pointing(0.5, 0.5));
    const glm::dvec3 before = stage.hand().proxy;
    FrameInput moving = stage.pointing(0.5, 0.5);
    moving.pan = {2, 1};
    (void)stage.frames(20, moving);
    (void)stage.frames(20, stage.pointing(0.5, 0.5));
    const viewer::HandState& hand = stage.hand();
    CHECK(hand.proxy.x < before.x - 1000);
    CHECK(std::abs(hand.to_hand(hand.proxy).z) < 0.03);
    CHECK(hand.over_ground);
}

TEST_CASE("a haptic thread that ends in mid-press leaves no force", "[scripted]") {
    const auto context = context_or_skip();
    if (!context) return;
    Stage stage{bundled_terrain(), bundled_frame, {160, 120}};
    viewer::HapticThread haptic{[&] { stage.touched.haptics.tick(); }};
    for (int k = 0; k < 25; ++k) {
        stage.target.bind();
        stage.shown.layer().begin_without_window(stage.target.size(), 0.02f);
        (void)stage.shown.frame(stage.pointing(0.5, 0.5, true), stage.target.size(), 0.02, false);
        std::this_thread::sleep_for(std::chrono::milliseconds{20});
    }
    CHECK(glm::length(stage.hand().force) > 0);
    haptic.stop();
    stage.touched.haptics.end();
    viewer::HandState state;
    (void)stage.touched.haptics.show(state);
    CHECK(state.force == glm::dvec3{0.0});
    const viewer::Punctuality& punctuality = haptic.punctuality();
    CHECK(punctuality.ticks > 200);
    std::uint64_t counted = 0;
    for (const std::uint64_t ticks : punctuality.lateness) counted += ticks;
    CHECK(counted == punctuality.ticks);
    CHECK_FALSE(report(punctuality).empty());
}
