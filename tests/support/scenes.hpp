#ifndef HFH_TESTS_SUPPORT_SCENES_HPP
#define HFH_TESTS_SUPPORT_SCENES_HPP

#include "terrains.hpp"

#include <cmath>
#include <vector>

namespace hfh::test {

template <Real T>
struct Scene {
    const char* name;
    Terrain<T> terrain;
};

/// One small terrain of each kind, without holes.
template <Real T>
std::vector<Scene<T>> scenes() {
    const GridFrame wide_cells{.origin = {-100, 50}, .spacing = {2, 0.75}};
    std::vector<Scene<T>> all;
    all.push_back({"plane", plane<T>(24, 20, 3, wide_cells)});
    all.push_back({"tilted plane", tilted_plane<T>(24, 20, 0.5, -0.25, 0, wide_cells)});
    all.push_back({"steep plane", tilted_plane<T>(24, 20, 4, 3)});
    all.push_back({"saddle", saddle<T>(24, 20, 0.25)});
    all.push_back({"valley", valley<T>(24, 20, 1.5)});
    all.push_back({"ridge", ridge<T>(24, 20, 1.5)});
    all.push_back({"gentle hills", hills<T>(24, 20, 2, 8)});
    all.push_back({"steep hills", hills<T>(24, 20, 8, 6)});
    all.push_back({"pit", pit<T>(24, 20, 3)});
    all.push_back({"peak", peak<T>(24, 20, 3)});
    all.push_back({"checkerboard", terrain<T>(24, 20, [](Index i, Index j) { return double((i + j) % 2); })});
    all.push_back(
        {"terraces", terrain<T>(24, 20, [](Index i, Index j) { return std::floor(double(i + j) / 3); })});
    all.push_back({"cone valley", terrain<T>(24, 20, [](Index i, Index j) {
                       return std::abs(double(i) - 12) + 0.5 * std::abs(double(j) - 9);
                   })});
    all.push_back({"rough", rough_in_steps<T>(24, 20, 1, 5)});
    all.push_back({"rougher", rough_in_steps<T>(24, 20, 4, 6, wide_cells)});
    all.push_back({"roughest", rough_in_steps<T>(24, 20, 16, 7)});
    return all;
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_SCENES_HPP
