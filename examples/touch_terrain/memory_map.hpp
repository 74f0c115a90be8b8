#ifndef TOUCH_TERRAIN_MEMORY_MAP_HPP
#define TOUCH_TERRAIN_MEMORY_MAP_HPP

#include <cstddef>
#include <filesystem>
#include <span>

namespace demo {

enum class MapAccess : unsigned char {
    read_only,
    copy_on_write ///< the bytes may be written to: in memory, never in the file
};

/// A file seen as memory. The system brings in the pages that are touched, and no others.
class MemoryMap {
public:
    /// Throws BadInput if the file is missing, unreadable or not a regular file.
    explicit MemoryMap(const std::filesystem::path& file, MapAccess access = MapAccess::read_only);
    ~MemoryMap();
    MemoryMap(const MemoryMap&) = delete;
    MemoryMap& operator=(const MemoryMap&) = delete;

    [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return {data_, size_}; }

private:
    const std::byte* data_ = nullptr;
    std::size_t size_ = 0;
};

} // namespace demo

#endif // TOUCH_TERRAIN_MEMORY_MAP_HPP
