// write() and finish() of port.h by semihosting: the debugger or the emulator that runs the program serves calls.
#pragma once

#include <cstdint>

#include "kernel/targets/port.h"

namespace unlatch::target {

// Of the port: the processor's instruction for such a call.
std::uintptr_t call_debugger(std::uintptr_t operation, const void* argument);

}  // namespace unlatch::target
