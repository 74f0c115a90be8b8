#include "cold_cache.hpp"

#include <bad_input.hpp>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace large_terrain {

void make_cold(const std::filesystem::path& file, std::span<const std::byte> bytes) {
    // The mapping first: a page that is mapped stays.
    ::madvise(const_cast<std::byte*>(bytes.data()), bytes.size(), MADV_DONTNEED);
    const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0)
        throw demo::BadInput{file.string() + " cannot be read: " + std::strerror(errno) + "."};
    ::fdatasync(descriptor);
    ::posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED);
    ::close(descriptor);
}

void read_single_pages(std::span<const std::byte> bytes) noexcept {
    ::madvise(const_cast<std::byte*>(bytes.data()), bytes.size(), MADV_RANDOM);
}

Pages pages_resident(std::span<const std::byte> bytes) {
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    std::vector<unsigned char> in_memory((bytes.size() + page - 1) / page);
    if (::mincore(const_cast<std::byte*>(bytes.data()), bytes.size(), in_memory.data()) != 0) {
        throw demo::BadInput{std::string{"mincore does not tell what is in memory: "} + std::strerror(errno) +
                             "."};
    }
    const auto resident = std::ranges::count_if(in_memory, [](unsigned char p) { return (p & 1) != 0; });
    return {static_cast<std::size_t>(resident), in_memory.size()};
}

} // namespace large_terrain
