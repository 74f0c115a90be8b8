#ifndef LARGE_TERRAIN_RASTER_MAKER_HPP
#define LARGE_TERRAIN_RASTER_MAKER_HPP

#include <cstdint>
#include <filesystem>
#include <vector>

namespace large_terrain {

/// Ground of any size, row by row: bumps of 4096 cells down to 2, each octave a little less than half as high as the one
/// before. In whole numbers only, so that the same arguments give the same samples on every machine.
class GroundRows {
public:
    GroundRows(std::uint64_t columns, std::uint64_t seed);

    /// Row j, counted from the north: metres, for cells of 10 m. A row costs the same wherever it is.
    void row(std::uint64_t j, std::vector<std::int16_t>& samples);

private:
    std::uint64_t columns_, seed_;
    std::vector<std::int32_t> sums_, knots_;
};

/// Writes `file`, a .bil of 16 bit integers, and its .hdr beside it. Both are there whole or not at all, and on the disk
/// itself. Throws demo::BadInput where the name does not end in .bil, and where there is no room.
void make_raster(const std::filesystem::path& file, std::uint64_t columns, std::uint64_t rows,
                 std::uint64_t seed);

} // namespace large_terrain

#endif // LARGE_TERRAIN_RASTER_MAKER_HPP
