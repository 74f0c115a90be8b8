#ifndef LARGE_TERRAIN_COLD_CACHE_HPP
#define LARGE_TERRAIN_COLD_CACHE_HPP

#include <cstddef>
#include <filesystem>
#include <span>

// A file that has been used before lies in memory, and a measurement of what the disk costs would find nothing.

namespace large_terrain {

/// Asks the kernel to drop `file` and its mapping `bytes` from memory. What another program has mapped, or what has not
/// been written to the disk yet, stays: ask `pages_resident`.
void make_cold(const std::filesystem::path& file, std::span<const std::byte> bytes);

/// From now on a page of the mapping that is missing is read alone. Without this the kernel reads what lies around it as
/// well, 128 KiB or many times that, as the disk is set up.
void read_single_pages(std::span<const std::byte> bytes) noexcept;

struct Pages {
    std::size_t resident = 0; ///< in memory, whoever brought them there
    std::size_t all = 0;
};

/// Counts the pages of a mapping (mincore).
[[nodiscard]] Pages pages_resident(std::span<const std::byte> bytes);

} // namespace large_terrain

#endif // LARGE_TERRAIN_COLD_CACHE_HPP
