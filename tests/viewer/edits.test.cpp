#include "catch.hpp"

#include "stage.hpp"

#include <edits.hpp>
#include <save_terrain.hpp>

#include <filesystem>
#include <fstream>
#include <iterator>

using namespace viewer_tests;

namespace {

std::string contents(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
}

/// Paints a whole spot.
template <class S>
viewer::SampleRange paint(viewer::Edits<S>& edits, const viewer::Spot& spot) {
    viewer::SampleRange changed;
    hfh::Index row = 0;
    while (!edits.paint(spot, row, changed)) {
    }
    return changed;
}

} // namespace

TEST_CASE("a spot changes samples within its radius and no others", "[edits]") {
    std::vector<std::int16_t> samples(100 * 100, 500);
    samples[50 * 100 + 52] = -1; // a hole
    const demo::Heights<std::int16_t> heights{samples.data(), 100, 100,
                                              demo::NoData<std::int16_t>{std::int16_t{-1}}};
    viewer::Edits<std::int16_t> edits{heights, {.spacing = {2, 2}, .height_scale = 0.5}};
    edits.begin_stroke();
    const auto changed = paint(edits, {{100, 100}, 10, -20});
    CHECK(samples[50 * 100 + 50] == 460);
    CHECK(samples[50 * 100 + 52] == -1);
    for (hfh::Index j = 0; j < 100; ++j) {
        for (hfh::Index i = 0; i < 100; ++i) {
            const bool is_changed = samples[static_cast<std::size_t>(j * 100 + i)] != 500;
            if (is_changed && !(i == 52 && j == 50)) {
                CHECK(std::hypot(2 * i - 100, 2 * j - 100) < 10);
                CHECK(
                    (changed.begin.i <= i && i < changed.end.i && changed.begin.j <= j && j < changed.end.j));
            }
        }
    }
    CHECK(edits.undoable_strokes() == 1);
    viewer::SampleRange undone;
    while (!edits.undo(undone)) {
    }
    CHECK(samples[50 * 100 + 50] == 500);
    CHECK(edits.undoable_strokes() == 0);
}

TEST_CASE("integers stay in their range and never become holes", "[edits]") {
    std::vector<std::uint8_t> samples(16 * 16, 3);
    const demo::Heights<std::uint8_t> heights{samples.data(), 16, 16,
                                              demo::NoData<std::uint8_t>{std::uint8_t{0}}};
    viewer::Edits<std::uint8_t> edits{heights, {}};
    edits.begin_stroke();
    (void)paint(edits, {{8, 8}, 5, -1000}); // to 0, which is a hole: left alone
    CHECK(samples[8 * 16 + 8] == 3);
    (void)paint(edits, {{8, 8}, 5, 1000});
    CHECK(samples[8 * 16 + 8] == 255);
}

TEST_CASE("strokes are undone in order, and the oldest are forgotten when memory is full", "[edits]") {
    std::vector<float> samples(600 * 600, 0.0f);
    const demo::Heights<float> heights{samples.data(), 600, 600, demo::NoData<float>{}};
    viewer::Edits<float> edits{heights, {}};
    for (int k = 0; k < 8; ++k) {
        edits.begin_stroke();
        (void)paint(edits, {{300, 300}, 250, 1.0 + k});
    }
    CHECK(edits.undoable_strokes() == 5); // a million samples, of 196 thousand each
    const float highest = samples[300 * 600 + 300];
    viewer::SampleRange changed;
    while (!edits.undo(changed)) {
    }
    CHECK(samples[300 * 600 + 300] == Approx(static_cast<double>(highest) - 8));
}

TEST_CASE("a file that is opened for editing is never altered, and is saved as another", "[edits]") {
    const auto folder =
        std::filesystem::temp_directory_path() / ("hfh_viewer_edits_" + std::to_string(::getpid()));
    std::filesystem::create_directory(folder);
    const auto file = folder / "ground.flt", saved = folder / "edited.flt";
    std::vector<float> samples;
    for (int k = 0; k < 40 * 30; ++k) samples.push_back(static_cast<float>(k % 7));
    std::ofstream{file, std::ios::binary}.write(reinterpret_cast<const char*>(samples.data()),
                                                static_cast<std::streamsize>(samples.size() * sizeof(float)));
    std::ofstream{folder / "ground.hdr"}
        << "ncols 40\nnrows 30\nxdim 5\nydim 5\nbyteorder LSBFIRST\nnbits 32\npixeltype float\n";
    const std::string before = contents(file);
    demo::TerrainOptions options;
    options.terrain = file;
    options.read.for_editing = true;
    {
        demo::Terrain terrain = demo::open_terrain(options);
        const hfh::GridFrame frame = demo::frame_of(terrain, options);
        const auto& heights = std::get<demo::Heights<float>>(terrain.heights);
        viewer::Edits<float> edits{heights, frame};
        edits.begin_stroke();
        (void)paint(edits, {{100, 75}, 30, -50});
        CHECK(heights(20, 15) < -40);
        viewer::save_terrain(terrain, frame, saved);
        CHECK_THROWS_AS(viewer::save_terrain(terrain, frame, saved), demo::BadInput);
        CHECK_THROWS_AS(viewer::save_terrain(terrain, frame, folder / "edited.png"), demo::BadInput);
        const float dug = heights(20, 15);
        options.terrain = saved;
        const demo::Terrain again = demo::open_terrain(options);
        CHECK(std::get<demo::Heights<float>>(again.heights)(20, 15) == dug);
        CHECK(again.spacing == glm::dvec2{5, 5});
    }
    CHECK(contents(file) == before);
    std::filesystem::remove_all(folder);
}
