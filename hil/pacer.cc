#include "hil/pacer.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <ctime>

namespace unlatch::hil {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;
constexpr int kPriority = 80;  // of SCHED_FIFO: above the kernel's interrupt threads (50), below its watchdogs (99)

}  // namespace

std::int64_t get_monotonic_ns() noexcept {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kNsPerSecond + now.tv_nsec;
}

void sleep_until_ns(std::int64_t deadline_ns) noexcept {
  const timespec deadline{deadline_ns / kNsPerSecond, deadline_ns % kNsPerSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

std::vector<std::string> request_real_time() {
  std::vector<std::string> refused;
  if (mlockall(MCL_CURRENT) != 0) {
    refused.push_back(std::string("no locked memory: mlockall: ") + std::strerror(errno) +
                      "; page faults may delay a step (raise `ulimit -l`, or grant CAP_IPC_LOCK)");
  }
  sched_param parameters{};
  parameters.sched_priority = kPriority;
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters); error != 0) {
    refused.push_back(std::string("no SCHED_FIFO: ") + std::strerror(error) +
                      "; other processes may delay a step (raise `ulimit -r` to 80 or more, or grant CAP_SYS_NICE)");
  }
  return refused;
}

}  // namespace unlatch::hil
