#include "allocations.hpp"

#include <cstddef>
#include <cstdlib>
#include <new>

// Every allocation of the test program is counted: those of new everywhere; those of malloc where the C library lets its
// own be called under another name, or where the address sanitizer tells. In a file of its own, for every program that
// counts.

namespace {

// Volatile, for compilers know that an allocation changes nothing that a program could see.
thread_local volatile std::size_t count = 0;

} // namespace

std::size_t hfh::test::allocations() noexcept { return count; }

#if defined(HFH_TEST_ADDRESS_SANITIZER)

extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*, std::size_t),
                                                         void (*on_free)(const volatile void*));
namespace {

const int hooks = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { count = count + 1; }, [](const volatile void*) {});

} // namespace

#elif defined(__GLIBC__)

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);

void* malloc(std::size_t size) noexcept {
    count = count + 1;
    return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) noexcept {
    count = count + 1;
    return __libc_calloc(n, size);
}
void* realloc(void* block, std::size_t size) noexcept {
    count = count + 1;
    return __libc_realloc(block, size);
}
}

#else

void* operator new(std::size_t size) {
    count = count + 1;
    if (void* block = std::malloc(size)) return block;
    throw std::bad_alloc{};
}
void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }

#endif
