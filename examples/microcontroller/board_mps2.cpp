#include "board.hpp"

// Arm's MPS2 boards as QEMU emulates them, mps2-an386 with a Cortex-M4F and mps2-an500 with a Cortex-M7: start-up, output by
// semihosting, and SysTick for a clock.

// What the linker calls `main`. C++ forbids calling that by its name.
int run() asm("main");

extern "C" {
// From mps2.ld.
extern std::uint32_t stack_top, data_in_flash, data_begin, data_end, bss_begin, bss_end;
[[noreturn]] void reset() noexcept;
[[noreturn]] void fault() noexcept;
}

namespace {

volatile std::uint32_t& device_register(std::uintptr_t address) noexcept {
    return *reinterpret_cast<volatile std::uint32_t*>(address);
}

/// Asks the debugger, here QEMU, for a service.
std::uint32_t semihost(std::uint32_t service, const void* argument) noexcept {
    register std::uint32_t r0 asm("r0") = service;
    register const void* r1 asm("r1") = argument;
    asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

[[noreturn]] void exit_program(std::uint32_t code) noexcept {
    constexpr std::uint32_t exit_extended = 0x20, application_exit = 0x20026;
    const std::uint32_t how[] = {application_exit, code};
    semihost(exit_extended, how);
    for (;;) {
    }
}

struct VectorTable {
    std::uint32_t* stack;
    void (*handlers[15])() noexcept;
};
[[gnu::section(".vectors"), gnu::used]] const VectorTable vector_table{
    &stack_top,
    {reset, fault, fault, fault, fault, fault, nullptr, nullptr, nullptr, nullptr, fault, fault, nullptr,
     fault, fault}};

} // namespace

extern "C" void reset() noexcept {
    // The FPU first: access for all to coprocessors 10 and 11 (CPACR).
    device_register(0xe000ed88) = device_register(0xe000ed88) | 0xfu << 20;
    asm volatile("dsb\n\tisb");
    const std::uint32_t* from = &data_in_flash;
    for (std::uint32_t* to = &data_begin; to != &data_end;) *to++ = *from++;
    for (std::uint32_t* to = &bss_begin; to != &bss_end;) *to++ = 0;
    // SysTick: the longest round, by the processor's clock, without interrupts.
    device_register(0xe000e014) = 0xffffff;
    device_register(0xe000e018) = 0;
    device_register(0xe000e010) = 5;
    exit_program(static_cast<std::uint32_t>(run()));
}

extern "C" void fault() noexcept {
    board::print("fault\n");
    exit_program(3);
}

namespace board {

void print(const char* text) noexcept { semihost(0x04, text); }

std::uint32_t clock() noexcept { return device_register(0xe000e018); }

std::uint32_t instructions_between(std::uint32_t earlier, std::uint32_t later) noexcept {
    // With -icount shift=10 QEMU lets an instruction take 1024 ns, and SysTick counts 40 ns.
    const std::uint32_t ticks = (earlier - later) & 0xffffff;
    return (ticks * 40 + 512) / 1024;
}

} // namespace board
