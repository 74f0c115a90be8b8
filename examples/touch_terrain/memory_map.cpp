#include "memory_map.hpp"

#include "bad_input.hpp"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace demo {

MemoryMap::MemoryMap(const std::filesystem::path& file, MapAccess access) {
    const auto refuse = [&](const std::string& why) {
        return BadInput{file.string() + " cannot be read: " + why + "."};
    };

    const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0) throw refuse(std::strerror(errno));
    struct Closer {
        int descriptor;
        ~Closer() { ::close(descriptor); }
    } const closer{descriptor};

    struct stat about {};
    if (::fstat(descriptor, &about) != 0) throw refuse(std::strerror(errno));
    if (!S_ISREG(about.st_mode)) throw refuse("it is not a regular file");
    size_ = static_cast<std::size_t>(about.st_size);
    if (size_ == 0) return; // an empty file cannot be mapped, and need not be

    // No room is reserved for copies: only the pages that are written to take any.
    const bool writes = access == MapAccess::copy_on_write;
    void* const data = ::mmap(nullptr, size_, writes ? PROT_READ | PROT_WRITE : PROT_READ,
                              writes ? MAP_PRIVATE | MAP_NORESERVE : MAP_PRIVATE, descriptor, 0);
    if (data == MAP_FAILED) throw refuse(std::strerror(errno));
    data_ = static_cast<const std::byte*>(data);
}

MemoryMap::~MemoryMap() {
    if (data_ != nullptr) ::munmap(const_cast<std::byte*>(data_), size_);
}

} // namespace demo
