#ifndef HFH_EXAMPLE_BOARD_HPP
#define HFH_EXAMPLE_BOARD_HPP

#include <cstdint>

// What the program asks of a board: a line out, and a clock that counts instructions. A board of your own has its UART and
// its cycle counter (DWT->CYCCNT) here.

namespace board {

void print(const char* text) noexcept;

/// Reads the clock. It runs down, from 2²⁴ − 1 to 0 and on from there.
[[nodiscard]] std::uint32_t clock() noexcept;

/// Instructions between two readings of the clock, `clock` itself counted; 0 where they cannot be told. Fewer than 600,000.
[[nodiscard]] std::uint32_t instructions_between(std::uint32_t earlier, std::uint32_t later) noexcept;

} // namespace board

#endif // HFH_EXAMPLE_BOARD_HPP
