// What the operating system grants a hard-real-time thread. Each refusal is a sentence with its cost and its remedy;
// the run goes on without.
#pragma once

#include <string>
#include <vector>

namespace unlatch::hil {

struct RealTimeOptions {
  int priority = 80;  // of SCHED_FIFO, 1 to 99: above the kernel's interrupt threads (50), below its watchdogs (99)
  int cpu = -1;       // the only one to run on; -1: any
};

// For the calling thread: its CPU, its stack met before it is needed, all memory of the process locked, now and later,
// SCHED_FIFO. What is refused is said in the result and left as it was; empty when all was granted.
[[nodiscard]] std::vector<std::string> request_real_time(const RealTimeOptions& options = {});

// The same for a thread that only needs to come before others. Returns what was refused, or an empty text.
[[nodiscard]] std::string request_priority(int priority);

}  // namespace unlatch::hil
