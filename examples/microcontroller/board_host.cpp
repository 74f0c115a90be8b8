#include "board.hpp"

#include <cstdio>

// The desktop: the same program, for the bits of its forces.

namespace board {

void print(const char* text) noexcept { std::fputs(text, stdout); }

std::uint32_t clock() noexcept { return 0; }

std::uint32_t instructions_between(std::uint32_t, std::uint32_t) noexcept { return 0; }

} // namespace board
