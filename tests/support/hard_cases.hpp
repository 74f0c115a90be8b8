#ifndef HFH_TESTS_SUPPORT_HARD_CASES_HPP
#define HFH_TESTS_SUPPORT_HARD_CASES_HPP

#include "terrains.hpp"

#include <hfh/contact/contact.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <type_traits>
#include <vector>

// The hard cases by name: a terrain, the way of a stylus over it and why it is hard. The digits are exact in binary or
// nine significant ones, as they were found. No case knows what the library says to it, but for the last update.

namespace hfh::test {

template <Real T>
struct HardCase {
    const char* name;
    const char* why;
    Terrain<T> terrain;
    std::vector<vec3<T>> path; ///< of the stylus; every waypoint twice, for a segment of zero length

    /// How the path ends on a solid, and the signs of the last penetration (0: not asked).
    ContactStatus end = ContactStatus::contact;
    std::array<int, 3> push{};

    /// The samples as integers and metres per unit, if the case is about those; `terrain` holds the heights.
    std::vector<std::uint8_t> bytes{};
    std::vector<std::int16_t> words{};
    double scale = 1;

    Cell focus{}; ///< a patch to be asked from everywhere
};

/// The void of a 16 bit raster.
inline constexpr std::int16_t no_data = -32768;

/// The way through the waypoints, `steps` updates from each to the next.
template <Real T>
[[nodiscard]] std::vector<vec3<T>> stylus_path(std::initializer_list<glm::dvec3> waypoints, int steps) {
    std::vector<vec3<T>> path;
    const auto add = [&](const glm::dvec3& p) {
        path.push_back({static_cast<T>(p.x), static_cast<T>(p.y), static_cast<T>(p.z)});
    };
    const glm::dvec3* from = nullptr;
    for (const auto& to : waypoints) {
        for (int k = 1; from != nullptr && k < steps; ++k)
            add(*from + static_cast<double>(k) / steps * (to - *from));
        add(to);
        add(to);
        from = &to;
    }
    return path;
}

/// Samples row by row, the south row first.
template <Real T>
[[nodiscard]] Terrain<T> samples(Index columns, std::initializer_list<double> heights,
                                 const GridFrame& frame = {}) {
    const auto* const first = heights.begin();
    return terrain<T>(
        columns, static_cast<Index>(heights.size()) / columns,
        [&](Index i, Index j) { return first[i + j * columns]; }, frame);
}

/// `scale` times the integer samples; `no_data` is a hole.
template <Real T, class S>
[[nodiscard]] Terrain<T> heights_of(const std::vector<S>& integers, Index columns, double scale) {
    return terrain<T>(columns, static_cast<Index>(integers.size()) / columns, [&](Index i, Index j) {
        const S sample = integers[static_cast<std::size_t>(i + j * columns)];
        const bool hole = std::is_same_v<S, std::int16_t> && sample == no_data;
        return hole ? std::numeric_limits<double>::quiet_NaN() : scale * double(sample);
    });
}

template <Real T>
[[nodiscard]] std::vector<HardCase<T>> hard_cases() {
    using Status = ContactStatus;
    std::vector<HardCase<T>> all;

    // Shapes.
    all.push_back(
        {"umbilic saddle, query on its axis",
         "gap × twist = ±dx·dy at 0.125 m: two feet part there, and no direction is better than another",
         samples<T>(4, {18, 6, -6, -18, 6, 2, -2, -6, -6, -2, 2, 6, -18, -6, 6, 18}),
         stylus_path<T>(
             {{1.5, 1.5, 4}, {1.5, 1.5, 0.125}, {1.5, 1.5, -0.125}, {1.5, 1.5, -1}, {1.5, 1.5, -3}}, 4)});
    all.push_back(
        {"indefinite Jacobian at the start",
         "three cells below a patch of twist 9 the determinant of Eq. (11) is negative almost everywhere",
         samples<T>(4, {0.25, 1.5, -0.75, 0.5, 1.125, 0.812345679, 3.17283946, 0.875, -1.25, 2.90123457,
                        -3.71604938, 1.75, 0.5, -0.25, 1.375, 0}),
         stylus_path<T>({{1.41234568, 1.58765432, 6}, {1.41234568, 1.58765432, -3}, {1.7, 1.3, -4}}, 7)});
    all.push_back(
        {"flat plateau",
         "no slope to follow on the top, a rim one cell wide",
         terrain<T>(9, 9, [](Index i, Index j) { return i > 2 && i < 6 && j > 2 && j < 6 ? 3.0 : 0.0; }),
         stylus_path<T>({{4, 4, 5}, {4.25, 4.5, 2.5}, {5.25, 4.5, 2}, {6.5, 4.5, -0.25}, {7.5, 7.25, -0.5}},
                        9),
         Status::contact,
         {0, 0, 1}});
    all.push_back({"all heights equal",
                   "every difference of heights is zero, and 7.1 is no binary number",
                   plane<T>(6, 6, 7.1),
                   stylus_path<T>({{2.5, 2.5, 9}, {2.5, 2.5, 6}, {0.5, 4, 7}, {5, 0, 5}}, 8),
                   Status::contact,
                   {0, 0, 1}});
    all.push_back({"single spike",
                   "one sample 50 cells high: four patches of slope 50 and saddles between",
                   peak<T>(7, 7, 50),
                   stylus_path<T>({{1.5, 3.25, 1}, {1.5, 3.25, -0.5}, {2.75, 3.0625, 8}, {2.9375, 3, 20}}, 9),
                   Status::contact,
                   {-1, 0, 0}});
    all.push_back(
        {"spike met from the top", "the point of the spike itself is the first crossing", peak<T>(7, 7, 50),
         stylus_path<T>({{3, 3, 60}, {3, 3, 49}, {3.015625, 2.984375, 40}, {3, 3, 60}}, 3), Status::free});
    all.push_back({"pit", "one sample 50 cells deep: the stylus goes down to the vertex and below",
                   pit<T>(7, 7, 50),
                   stylus_path<T>({{3, 3, 1}, {3, 3, -45}, {3, 3, -50}, {3.25, 2.875, -52}, {3, 3, -48}}, 5),
                   Status::free});
    all.push_back(
        {"steep pit whose averaged normal points sideways",
         "below its vertex the offset is up, and at right angles to the averaged normal or behind it",
         samples<T>(5, {16,    16, 16, 16, 16, 16, 16, 11.25, 16, 16, 16, 6, 2,
                        15.25, 16, 16, 16, 10, 16, 16, 16,    16, 16, 16, 16}),
         stylus_path<T>({{2, 2, 20},
                         {2, 2, 3},
                         {2, 2, 1.75},
                         {1.96875, 2, 1.75},
                         {1.875, 2, 1.96875},
                         {2, 2.0625, 1.5},
                         {2.03125, 1.96875, 1}},
                        6),
         Status::contact,
         {0, 0, 1}});
    all.push_back({"V valley", "the foot jumps from wall to wall across the crease", valley<T>(9, 7, 2),
                   stylus_path<T>({{4, 3.3, 3},
                                   {3.5, 3.3, 0.5},
                                   {4.5, 3.3, 0.5},
                                   {4, 3.3, -2},
                                   {4, 3, 1},
                                   {4, 3, 0},
                                   {4, 3, -0.25}},
                                  8)});
    all.push_back(
        {"start on a valley line",
         "the first stylus position is on the crease, where two patches say level and both fall away",
         valley<T>(9, 7, 1.5),
         stylus_path<T>({{4, 3.5, 0}, {4, 3.5, -0.5}, {3.75, 3, -0.5}, {4.25, 4, -0.75}}, 6),
         Status::contact,
         {0, 0, 1}});
    all.push_back({"knife ridge one cell wide",
                   "ten cells high; the far foot is nearer than the near face",
                   terrain<T>(9, 7, [](Index i, Index) { return i == 4 ? 10.0 : 0.0; }),
                   stylus_path<T>({{2, 3.3, 3}, {3, 3.3, 3}, {5.875, 3.3, 3}}, 40),
                   Status::contact,
                   {-1, 0, 1}});
    all.push_back(
        {"cast that starts on a ridge line",
         "the proxy left on the crest is on four faces; the way on leads down into the next ridge",
         terrain<T>(13, 7, [](Index i, Index) { return i % 4 == 0 ? 6.0 : 0.0; }),
         stylus_path<T>({{3.5, 3, 5}, {3.75, 3, 4}, {4, 3, 6.25}, {7.875, 3, 5}, {8, 3.5, 6}, {11.75, 3, 3}},
                        1),
         Status::contact,
         {-1, 0, 1}});
    all.push_back(
        {"Figure 8",
         "the closest patch is through the peak; the force must hold on the near side",
         terrain<T>(24, 24, [](Index i, Index j) { return i - j == 2 || i - j == -2 ? 10.0 : 0.0; }),
         stylus_path<T>({{14, 5.125, 2.25}, {10.125, 8.875, 2.25}, {9.125, 9.875, 2.25}}, 1),
         Status::contact,
         {1, -1, 0}});
    all.push_back(
        {"checkerboard of maximal twist", "each patch a saddle of 40 cells, its neighbours upside down",
         terrain<T>(9, 9, [](Index i, Index j) { return (i + j) % 2 == 0 ? 10.0 : -10.0; }),
         stylus_path<T>({{3.5, 4.5, 20}, {3.5, 4.5, -1}, {4, 4.5, -3}, {4.5, 5.0625, -5}, {5.5, 3.25, -1}},
                        16)});
    all.push_back({"cliff of 10,000 cells",
                   "slope 10,000 beside slope 0: the squares of F_uu are 10^16 apart",
                   terrain<T>(9, 7, [](Index i, Index) { return i < 4 ? 0.0 : 10000.0; }),
                   stylus_path<T>({{1.5, 3.3, 2}, {2.5, 3.3, -1}, {3.75, 3.3, 1}, {4.5, 3.3, 500}}, 12),
                   Status::contact,
                   {-1, 0, 1}});
    all.push_back(
        {"over the cliff's edge", "from the top down along the face, ten thousand cells in one update",
         terrain<T>(9, 7, [](Index i, Index) { return i < 4 ? 0.0 : 10000.0; }),
         stylus_path<T>({{6.5, 3.3, 10001}, {5.5, 3.3, 9999.5}, {3.5, 3.3, 9999}, {1.5, 3.3, -0.5}}, 1)});

    // Grids.
    all.push_back(
        {"2 × 2 samples", "one patch, a rim on every side", samples<T>(2, {0, 1, 0.5, -1}),
         stylus_path<T>({{0.5, 0.5, 3}, {0.5, 0.5, -1}, {0, 0, -1}, {1, 0.25, -2}, {1, 1, -2}}, 5)});
    all.push_back(
        {"2 columns × 200 rows", "one cell wide: a rim on both sides at every step",
         terrain<T>(2, 200, [](Index i, Index j) { return 0.5 * double(i) + 0.75 * double(j % 3); }),
         stylus_path<T>({{0.5, 3.5, 4}, {0.25, 9.5, -0.5}, {0.75, 180.25, -0.25}, {1, 199, -0.5}}, 60)});
    all.push_back(
        {"200 columns × 2 rows", "the same turned",
         terrain<T>(200, 2, [](Index i, Index j) { return 0.5 * double(j) + 0.75 * double(i % 3); }),
         stylus_path<T>({{3.5, 0.5, 4}, {9.5, 0.25, -0.5}, {180.25, 0.75, -0.25}, {199, 1, -0.5}}, 60)});
    all.push_back({"exactly over vertices", "four patches decide at once", rough_in_steps<T>(9, 9, 2, 201),
                   stylus_path<T>({{4, 4, 4}, {4, 4, -1}, {5, 5, -1}, {5, 4, -0.5}, {3, 4, 0}, {3, 3, 3}}, 2),
                   Status::free});
    all.push_back(
        {"exactly over edges", "two patches decide at once, along the whole way",
         rough_in_steps<T>(9, 9, 2, 202),
         stylus_path<T>({{4, 4.25, 4}, {4, 4.25, -1}, {4, 6.75, -1}, {4.5, 6, -0.5}, {1.5, 6, -0.5}}, 10)});
    all.push_back({"over the corner of the grid", "one patch and three that are not there",
                   rough_in_steps<T>(5, 5, 2, 203),
                   stylus_path<T>({{0, 0, 4},
                                   {0, 0, -0.5},
                                   {0.25, 0, -0.5},
                                   {0, 0.25, -0.5},
                                   {0, 0, -0.5},
                                   {-0.125, -0.125, -0.5}},
                                  1),
                   Status::off_surface});
    all.push_back({"along the rim and off it", "beyond one rim, but not the other, then beyond both",
                   hills<T>(7, 7, 1, 5),
                   stylus_path<T>({{6, 1, 2}, {6, 1, -1}, {6, 6, -1}, {3, 6, -1.5}, {3, 6.5, -1.5}}, 16),
                   Status::off_surface});
    all.push_back(
        {"sheet pinned at the rim", "the foot lies beyond the rim, the stylus does not: pinned, not off",
         tilted_plane<T>(9, 9, 2, 0),
         stylus_path<T>(
             {{6, 4, 8}, {6, 4, 15}, {7, 4, 17}, {7.5, 4, 18}, {8, 4, 19}, {8, 8, 19}, {8.0625, 8, 19}}, 4),
         Status::off_surface});
    all.push_back(
        {"spacing 49 m", "49 × (1/49) < 1: a point on a grid line is taken for one beside it",
         rough_in_steps<T>(9, 9, 64, 204, {.spacing = {49, 49}}),
         stylus_path<T>({{49, 49, 100}, {49, 49, -20}, {147, 49, -20}, {147, 196, -40}, {343, 392, -60}},
                        12)});
    all.push_back({"spacing of a third and a tenth", "no grid line but the first is a binary number",
                   rough_in_steps<T>(13, 13, 0.5, 205, {.origin = {-0.7, 0.3}, .spacing = {1.0 / 3, 0.1}}),
                   stylus_path<T>({{0.3, 0.5, 1},
                                   {0.3, 0.5, -0.25},
                                   {0.633333333, 0.6, -0.25},
                                   {-0.366666667, 0.7, -0.0625},
                                   {1.63333333, 1.1, -0.125}},
                                  14)});
    all.push_back(
        {"northing of 10,000 km", "a position is 10^7 m and its height above ground millimetres",
         rough_in_steps<T>(17, 17, 32, 206, {.origin = {500000, 10000000}, .spacing = {16, 16}}),
         stylus_path<T>(
             {{500100, 10000100, 40}, {500100, 10000100, -4}, {500196, 10000148, -8}, {500144, 10000208, -2}},
             16)});

    // Samples.
    {
        constexpr Index columns = 9, rows = 7;
        std::vector<std::uint8_t> bytes;
        for (Index j = 0; j < rows; ++j) {
            for (Index i = 0; i < columns; ++i)
                bytes.push_back(static_cast<std::uint8_t>((i + j / 2) / 3 * 85));
        }
        constexpr double scale = 0.0625;
        all.push_back(
            {"terraces of 8 bit samples",
             "level but for steps of a third of the range, which are walls; 255 is a height",
             heights_of<T>(bytes, columns, scale),
             stylus_path<T>({{0.5, 1.5, 4}, {1, 1.5, -0.5}, {3.5, 2.25, 3}, {2.75, 3.5, 5.5}, {7.5, 6, 15}},
                            20),
             Status::contact,
             {0, 0, 0},
             bytes,
             {},
             scale});
    }
    {
        constexpr Index columns = 10, rows = 8;
        Random random{207};
        std::vector<std::int16_t> words;
        for (Index n = 0; n < columns * rows; ++n)
            words.push_back(static_cast<std::int16_t>(random.whole(-2048, 2048)));
        words[4 + 3 * columns] = words[5 + 3 * columns] = no_data;
        words[0] = -32767; // the lowest height there is: a pit at the corner
        constexpr double scale = 0x1p-10;
        all.push_back({"voids of 16 bit samples",
                       "−32768 is no height 32 m down, and −32767 is one",
                       heights_of<T>(words, columns, scale),
                       stylus_path<T>({{2, 2, 3},
                                       {2, 2, -2},
                                       {3, 3, -2},
                                       {3.25, 3.25, -2},
                                       {4.5, 3.25, 1},
                                       {8, 5, 3},
                                       {7, 5, -2},
                                       {6.5, 4.25, -2},
                                       {1, 1, 3},
                                       {0.25, 0.25, -25}},
                                      7),
                       Status::contact,
                       {0, 0, 0},
                       {},
                       words,
                       scale});
    }

    // Found by fuzzing, on real terrains and against peers.
    all.push_back({"hops around a vertex",
                   "a mesa's rim: deep below a vertex each patch sends the point to the next",
                   samples<T>(4,
                              {3131, 3129, 3112, 3109, 3128, 3126, 3118, 3106, 3113, 3107, 3105, 3101, 3108,
                               3104, 3102, 3099},
                              {.spacing = {10, 10}}),
                   stylus_path<T>({{12, 12, 3140},
                                   {12, 12, 3100},
                                   {10, 10, 3060},
                                   {20, 10, 3020},
                                   {20, 20, 3000},
                                   {10.0000134, 19.9999866, 2950},
                                   {15, 15, 2900}},
                                  6)});
    all.push_back(
        {"nearly parabolic valley",
         "one corner 373 m above three level ones: the valley's floor bends, Newton creeps along it",
         terrain<T>(8, 8, [](Index i, Index j) { return i == 2 && j == 2 ? 956.0 : 583.0; },
                    {.spacing = {1.9, 1.9}}),
         stylus_path<T>({{6.3, 6.3, 1000},
                         {1.9 * 3.32474, 1.9 * 5.09333, 954.05}, // (u, v) 2.32474 4.09333 of the patch
                         {4.4, 4.4, 954.05},
                         {3.7, 3.6, 900},
                         {3.5, 3.5, 600},
                         {3.3, 3.2, 560}},
                        5),
         Status::contact,
         {},
         {},
         {},
         1,
         {1, 1}});
    return all;
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_HARD_CASES_HPP
