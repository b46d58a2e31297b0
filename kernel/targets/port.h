// What flight.cc needs of a board. A port is one source file with these functions and the start of the program, and a
// linker script: ports/README.md.
#pragma once

#include <cstddef>
#include <cstdint>

namespace unlatch::target {

// Prints a text that ends with 0: a serial port, semihosting.
void write(const char* text);

// Ends the program: an emulator stops with this code, a board halts.
[[noreturn]] void finish(int code);

// Instructions executed so far, in any unit that is constant: kInstructionUnit of them each. 0 where nothing counts.
std::uint64_t read_counter();
extern const std::uint32_t kInstructionUnit;

}  // namespace unlatch::target

// From the linker script: the stack, which grows down from its end.
extern "C" std::byte target_stack_begin[], target_stack_end[];
