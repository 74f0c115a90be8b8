#ifndef HFH_TESTS_SUPPORT_ALLOCATIONS_HPP
#define HFH_TESTS_SUPPORT_ALLOCATIONS_HPP

#include <cstddef>

namespace hfh::test {

/// How many blocks this thread has asked of the heap so far, through new or malloc. Defined in realtime.test.cpp.
[[nodiscard]] std::size_t allocations() noexcept;

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_ALLOCATIONS_HPP
