// Output and end of a program by semihosting: the debugger or the emulator that runs it serves calls.
#pragma once

#include <cstdint>

#include "kernel/targets/port.h"

namespace unlatch::target {

// Of the port: the processor's instruction for such a call.
std::uintptr_t call_debugger(std::uintptr_t operation, const void* argument);

}  // namespace unlatch::target

extern "C" {
int main();
// Of the port, before anything else runs: the stack and the FPU are ready.
[[noreturn]] void target_run();
// Of exceptions: prints "fault" and ends the program with code 2.
[[noreturn]] void target_fault();
}
