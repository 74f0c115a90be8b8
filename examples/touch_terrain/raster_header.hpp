#ifndef TOUCH_TERRAIN_RASTER_HEADER_HPP
#define TOUCH_TERRAIN_RASTER_HEADER_HPP

#include <glm/ext/vector_double2.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

// The text file beside an ESRI raster. Based on: ESRI, "BIL, BIP, and BSQ raster files" and "Float to Raster".

namespace demo {

enum class SampleKind { unsigned_integer, signed_integer, floating };

/// What a .hdr file says, checked. One band; the north row first.
struct RasterHeader {
    std::filesystem::path file;
    std::uint64_t columns = 0; ///< NCOLS
    std::uint64_t rows = 0;    ///< NROWS
    unsigned bits = 0;         ///< NBITS: 8, 16, 32 or 64
    SampleKind kind{}; ///< PIXELTYPE; where it is missing, by NODATA: integers with a sign if it is negative
    bool swapped = false;           ///< BYTEORDER is not that of this machine
    std::uint64_t skip = 0;         ///< SKIPBYTES: bytes before the first sample
    std::uint64_t row_bytes = 0;    ///< TOTALROWBYTES: from row to row
    std::string no_data;            ///< NODATA or NODATA_VALUE as written; empty if not given
    std::optional<glm::dvec2> cell; ///< XDIM and YDIM, or CELLSIZE, in units of the map
    std::optional<double>
        north; ///< of the samples of the first row, in units of the map: ULYMAP, YLLCENTER or YLLCORNER
    std::vector<std::string> assumed; ///< what the file leaves open and was decided here

    [[nodiscard]] std::uint64_t sample_bytes() const noexcept { return bits / 8; }
};

/// The header beside `raster`: a.hdr or a.bil.hdr for a.bil, in either case. Throws BadInput where there is none.
[[nodiscard]] std::filesystem::path header_beside(const std::filesystem::path& raster);

/// True if the header is ENVI's, which is of another form.
[[nodiscard]] bool is_envi_header(const std::filesystem::path& header);

/// Reads the header of `raster`, a .bil (integers of 8 bits unless the header says otherwise) or a .flt (32 bit floats).
/// Keys in any case, one to a line; lines that begin with no key that means something here are comments. Throws BadInput.
[[nodiscard]] RasterHeader read_raster_header(const std::filesystem::path& raster);

} // namespace demo

#endif // TOUCH_TERRAIN_RASTER_HEADER_HPP
