#include "hil/session/realtime/real_time.h"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace unlatch::hil {
namespace {

constexpr std::size_t kStackBytes = 256 * 1024;  // many times the use of the cyclic thread, as observed
constexpr std::size_t kPageBytes = 4096;

// Array on the stack below all later calls of the caller, hence not inlined.
[[gnu::noinline]] void touch_stack() noexcept {
  std::byte stack[kStackBytes];
  for (std::size_t i = 0; i < kStackBytes; i += kPageBytes) *const_cast<volatile std::byte*>(stack + i) = std::byte{0};
}

std::string describe_errno(const char* what, int error, const char* cost) {
  return std::string(what) + std::strerror(error) + cost;
}

std::string request_cpu(int cpu) {
  cpu_set_t only;
  CPU_ZERO(&only);
  const bool exists = cpu < CPU_SETSIZE;
  if (exists) CPU_SET(static_cast<std::size_t>(cpu), &only);
  const int error = exists ? pthread_setaffinity_np(pthread_self(), sizeof only, &only) : EINVAL;
  if (error == 0) return {};
  return describe_errno(("the cyclic thread is not bound to CPU " + std::to_string(cpu) + ": ").c_str(), error,
                        "; moving between CPUs costs cache misses (name a CPU that exists and is in the process's "
                        "cpuset: `taskset -pc $$`)");
}

}  // namespace

ShallowIdle::ShallowIdle() : request_(open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC)) {
  constexpr std::int32_t kLongest_us = 0;
  if (request_ >= 0 && write(request_, &kLongest_us, sizeof kLongest_us) == sizeof kLongest_us) return;
  refusal_ =
      describe_errno("idle states as deep as the kernel likes: /dev/cpu_dma_latency: ", errno,
                     "; waking from them delays a tick, on some machines by 100 us and more (grant writing it, or "
                     "busy-wait: timing.spin)");
}

ShallowIdle::~ShallowIdle() {
  if (request_ >= 0) close(request_);
}

std::string request_priority(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  if (error == 0) return {};
  return describe_errno("no SCHED_FIFO: ", error,
                        "; other processes may delay a step (raise `ulimit -r` to 81 or more, or grant CAP_SYS_NICE)");
}

std::vector<std::string> request_real_time(const RealTimeOptions& options) {
  std::vector<std::string> refused;
  const auto note = [&refused](std::string text) {
    if (!text.empty()) refused.push_back(std::move(text));
  };
  if (options.cpu >= 0) note(request_cpu(options.cpu));
  touch_stack();
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    note(describe_errno("no locked memory: mlockall: ", errno,
                        "; page faults may delay a step (raise `ulimit -l`, or grant CAP_IPC_LOCK)"));
  }
  note(request_priority(options.priority));
  return refused;
}

}  // namespace unlatch::hil
