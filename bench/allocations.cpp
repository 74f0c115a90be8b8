#include "run.hpp"

#include <cstdlib>
#include <new>

// Counts what is allocated. A file of its own: where a compiler sees the bodies, it takes malloc and delete for a mistake.

namespace {

std::size_t bytes_given = 0, calls = 0;

} // namespace

namespace hfh::bench {

std::size_t bytes_allocated() noexcept { return bytes_given; }
std::size_t allocations() noexcept { return calls; }

} // namespace hfh::bench

// Array and nothrow forms come here too.
void* operator new(std::size_t bytes) {
    bytes_given += bytes;
    ++calls;
    if (void* const memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
    throw std::bad_alloc{};
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
