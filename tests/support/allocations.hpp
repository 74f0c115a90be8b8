#ifndef HFH_TESTS_SUPPORT_ALLOCATIONS_HPP
#define HFH_TESTS_SUPPORT_ALLOCATIONS_HPP

#include <cstddef>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define HFH_TEST_ADDRESS_SANITIZER
#endif
#endif
#if defined(__SANITIZE_ADDRESS__)
#define HFH_TEST_ADDRESS_SANITIZER
#endif

namespace hfh::test {

/// How many blocks this thread has asked of the heap so far, through new or malloc. Defined in allocations.cpp,
/// which a program that calls it is built with.
[[nodiscard]] std::size_t allocations() noexcept;

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_ALLOCATIONS_HPP
