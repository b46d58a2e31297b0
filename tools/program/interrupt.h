// SIGINT and SIGTERM end a tool in an orderly way; nothing that hangs keeps it from ending.
#pragma once

#include <atomic>

namespace unlatch::tools {

// From now on both signals set the flag that this returns, for as long as the process lives. After SIGTERM the process
// ends within a second although something hangs, with exit code 1. A report that the main thread is computing is
// finished first; the rule is in interrupt.cc. Called by the main thread.
const std::atomic<bool>& catch_interrupts();

// The same, but nothing ends a process that hangs: for programs whose starter does, such as mpirun.
const std::atomic<bool>& catch_interrupts_patiently();

// From now on writing to standard error never waits for a reader: what a full pipe does not take is lost. Other
// programs that write to the same pipe are not affected. Files and terminals stay as they are.
void never_wait_for_stderr();

}  // namespace unlatch::tools
