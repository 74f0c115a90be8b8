// Step 1: heights in memory become a surface.

#include <hfh/hfh.hpp>

#include <cstdint>
#include <cstdio>
#include <vector>

int main() {
    const std::size_t columns = 4, rows = 3;
    const std::vector<std::int16_t> decimetres{0, 0,  0,  0, //
                                               0, 20, 30, 0, //
                                               0, 0,  0,  0};

    const hfh::HeightView heights{decimetres.data(), columns, rows};
    const hfh::BilinearGrid grid{heights, {.spacing = {10.0, 10.0}, .height_scale = 0.1}};
    std::printf("the grid is %s\n", hfh::to_string(grid.status()));

    const auto patch = grid.patch({1, 0}); // the cell between the samples (1, 0) and (2, 1)
    if (!patch) return 1;
    const double middle = patch->height(0.5, 0.5);
    std::printf("its height in the middle of cell (1, 0) is %g m\n", middle);
    return middle == 1.25 ? 0 : 1;
}
