// What a port calls once it has a stack and an FPU: the program, and the end of it at an exception.
#pragma once

extern "C" {
// Clears static memory, and runs the program.
[[noreturn]] void target_run();
// Of exceptions: prints "fault" and ends the program with code 2.
[[noreturn]] void target_fault();
}
