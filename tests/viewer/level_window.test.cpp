#include "catch.hpp"

#include "stage.hpp"

#include <level_window.hpp>

#include <random>

using namespace viewer_tests;

namespace {

viewer::DisplayedTerrain formula(hfh::Index columns, hfh::Index rows) {
    return {columns, rows, {10, 10}, 0, [](hfh::Index i, hfh::Index j) {
                return hills(static_cast<double>(i), static_cast<double>(j));
            }};
}

} // namespace

TEST_CASE("a window that moves holds what one that was filled there holds, and reads only what is new",
          "[levels]") {
    const viewer::DisplayedTerrain terrain = formula(500, 400);
    std::mt19937 random{3};
    for (const int level : {0, 2}) {
        viewer::LevelWindow moving{terrain, level, 31};
        glm::dvec2 place{100, 100};
        moving.move_to(place);
        const std::uint64_t whole = moving.samples_read();
        for (int k = 0; k < 40; ++k) {
            place += glm::dvec2{std::uniform_real_distribution{-9.0, 9.0}(random),
                                std::uniform_real_distribution{-9.0, 9.0}(random)};
            const std::uint64_t before = moving.samples_read();
            moving.move_to(place);
            CHECK(moving.samples_read() - before < whole);
            viewer::LevelWindow filled{terrain, level, 31};
            filled.move_to(place);
            REQUIRE(moving.origin() == filled.origin());
            const auto a = moving.vertices(), b = filled.vertices();
            for (std::size_t v = 0; v < a.size(); ++v) {
                REQUIRE(a[v].height == b[v].height);
                REQUIRE(a[v].coarse_height == b[v].coarse_height);
            }
        }
    }
}

TEST_CASE("windows of neighbouring levels fit into each other", "[levels]") {
    std::mt19937 random{5};
    std::uniform_real_distribution<double> anywhere{-1000, 5000};
    for (int k = 0; k < 1000; ++k) {
        const glm::dvec2 place{anywhere(random), anywhere(random)};
        for (int level = 0; level < 8; ++level) {
            const hfh::Cell fine = viewer::LevelWindow::origin_for(place, level, 127),
                            coarse = viewer::LevelWindow::origin_for(place, level + 1, 127);
            CHECK(fine.i % 2 == 0);
            const hfh::Index i = fine.i / 2 - coarse.i, j = fine.j / 2 - coarse.j;
            CHECK((i == 31 || i == 32));
            CHECK((j == 31 || j == 32));
        }
    }
}

TEST_CASE("the coarse height at a vertex is that of the coarser level there", "[levels]") {
    const viewer::DisplayedTerrain terrain = formula(257, 257);
    viewer::LevelWindow window{terrain, 1, 63};
    window.move_to({120, 130});
    const auto vertices = window.vertices();
    for (int b = 0; b < 63; ++b) {
        for (int a = 0; a < 63; ++a) {
            const hfh::Index i = window.origin().i + a, j = window.origin().j + b, di = i & 1, dj = j & 1;
            const auto at = [&](hfh::Index x, hfh::Index y) { return terrain.sample(2 * x, 2 * y); };
            const double coarse =
                (at(i - di, j - dj) + at(i + di, j - dj) + at(i - di, j + dj) + at(i + di, j + dj)) / 4;
            CHECK(static_cast<double>(vertices[static_cast<std::size_t>(b * 63 + a)].coarse_height) ==
                  Approx(coarse).margin(1e-4));
        }
    }
}

TEST_CASE("edited samples are read again, and only they", "[levels]") {
    double raised = 0;
    viewer::DisplayedTerrain terrain{
        100, 100, {1, 1}, 0, [&](hfh::Index i, hfh::Index j) { return i == 40 && j == 44 ? raised : 1.0; }};
    viewer::LevelWindow window{terrain, 2, 31};
    window.move_to({50, 50});
    const std::uint64_t version = window.version(), read = window.samples_read();
    raised = 9;
    window.read_again({{41, 44}, {43, 45}}); // no vertex of level 2
    CHECK(window.version() == version);
    window.read_again({{40, 44}, {41, 45}});
    CHECK(window.version() > version);
    CHECK(window.samples_read() == read + 1);
}
