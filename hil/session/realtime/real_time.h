// Requests of a hard-real-time thread to the operating system. Each refusal is a sentence with its cost and its remedy;
// the run goes on without.
#pragma once

#include <string>
#include <vector>

namespace unlatch::hil {

struct RealTimeOptions {
  int priority =
      80;        // priority of SCHED_FIFO, 1 to 99: above the kernel's interrupt threads (50), below its watchdogs (99)
  int cpu = -1;  // only CPU to run on; -1: any
};

// Requests for the calling thread: its CPU, its stack touched in advance, all memory of the process locked, now and
// later, SCHED_FIFO. The result lists refused requests, whose settings stay as they were; empty when all was granted.
[[nodiscard]] std::vector<std::string> request_real_time(const RealTimeOptions& options = {});

// Request that no CPU of this machine idles more deeply than by polling, so that wake-ups are short: 0 us asked for
// through /dev/cpu_dma_latency. It ends with the object, or with the process.
class ShallowIdle {
 public:
  ShallowIdle();
  ~ShallowIdle();
  ShallowIdle(const ShallowIdle&) = delete;
  ShallowIdle& operator=(const ShallowIdle&) = delete;

  // Refusal; empty if there was none.
  [[nodiscard]] const std::string& get_refusal() const noexcept { return refusal_; }

 private:
  int request_ = -1;
  std::string refusal_;
};

// SCHED_FIFO for a thread that only needs to come before others. Returns the refusal, empty if there was none.
[[nodiscard]] std::string request_priority(int priority);

}  // namespace unlatch::hil
