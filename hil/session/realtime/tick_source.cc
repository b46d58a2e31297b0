#include "hil/session/realtime/tick_source.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <utility>

#include "hil/session/realtime/clock.h"

namespace unlatch::hil {
namespace {

constexpr std::int64_t kStopLook_ns = 100'000'000;  // interval of looks for a stop, at a silent descriptor

void relax() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// timerfd and eventfd are of no file type that stat knows.
bool gives_counts(int descriptor) {
  struct stat status {};
  return fstat(descriptor, &status) == 0 && (status.st_mode & S_IFMT) == 0;
}

}  // namespace

std::int64_t MonotonicTicks::doze() noexcept {
  const std::int64_t next_ns = get_next_due_ns();
  if (spin_ns_ == 0 || clock_.get_ns() >= next_ns) return 0;
  if (clock_.get_ns() < next_ns - spin_ns_) clock_.sleep_until_ns(next_ns - spin_ns_);
  dozed_ = true;
  return std::max<std::int64_t>(next_ns - clock_.get_ns(), 0);
}

bool MonotonicTicks::wait(const std::atomic<bool>& stop) noexcept {
  due_ns_ += period_ns_;
  awake_ns_ = clock_.get_ns();
  const bool dozed = std::exchange(dozed_, false);
  backlogged_ = awake_ns_ >= due_ns_ && !dozed;
  if (awake_ns_ < due_ns_) {
    if (awake_ns_ < due_ns_ - spin_ns_) clock_.sleep_until_ns(due_ns_ - spin_ns_);
    while ((awake_ns_ = clock_.get_ns()) < due_ns_) relax();
  }
  latency_ns_ = awake_ns_ - due_ns_;
  return !stop.load(std::memory_order_relaxed);
}

std::int64_t MonotonicTicks::slip(std::int64_t now_ns) noexcept {
  const std::int64_t lost_ns = now_ns - due_ns_;
  due_ns_ = now_ns;
  return lost_ns;
}

std::int64_t MonotonicTicks::calc_behind(std::int64_t now_ns) const noexcept {
  return std::max<std::int64_t>(now_ns - due_ns_, 0) / period_ns_;
}

DescriptorTicks::DescriptorTicks(int descriptor, std::int64_t period_ns, std::int64_t patience_ns)
    : TickSource(period_ns), descriptor_(descriptor), counts_(gives_counts(descriptor)), patience_ns_(patience_ns) {
  const int flags = fcntl(descriptor, F_GETFL);
  if (flags < 0 || fcntl(descriptor, F_SETFL, flags | O_NONBLOCK) < 0) failure_ = "it is no open descriptor";
}

void DescriptorTicks::restart(std::int64_t now_ns) noexcept {
  const char* const failure = failure_;
  (void)read_ticks();  // those of the time before are gone; a FIFO may have no writer yet
  failure_ = failure;
  pending_ = 0;
  due_ns_ = now_ns;
}

std::int64_t DescriptorTicks::slip(std::int64_t now_ns) noexcept {
  const std::int64_t lost_ns = pending_ * period_ns_;
  pending_ = 0;
  due_ns_ = std::max(due_ns_, now_ns - period_ns_);
  return lost_ns;
}

std::int64_t DescriptorTicks::read_ticks() noexcept {
  unsigned char bytes[64];
  const ssize_t length = read(descriptor_, bytes, counts_ ? sizeof(std::uint64_t) : sizeof bytes);
  if (length < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
  if (length <= 0) {
    failure_ = length == 0 ? "its other end was closed" : "it cannot be read";
    return -1;
  }
  if (!counts_) return length;
  std::uint64_t count = 0;
  std::copy_n(bytes, sizeof count, reinterpret_cast<unsigned char*>(&count));
  return static_cast<std::int64_t>(std::min<std::uint64_t>(count, 1'000'000'000));
}

bool DescriptorTicks::wait_for_ticks(const std::atomic<bool>& stop) noexcept {
  const std::int64_t give_up_ns = get_monotonic_ns() + patience_ns_;
  while (!stop.load(std::memory_order_relaxed)) {
    pollfd waiting{descriptor_, POLLIN, 0};
    const timespec look{0, kStopLook_ns};
    if (ppoll(&waiting, 1, &look, nullptr) > 0) {
      pending_ = read_ticks();
      if (pending_ != 0) return pending_ > 0;
    }
    if (get_monotonic_ns() > give_up_ns) {
      failure_ = "it is silent";
      return false;
    }
  }
  return false;
}

bool DescriptorTicks::wait(const std::atomic<bool>& stop) noexcept {
  if (*failure_ != '\0') return false;
  const std::int64_t expected_ns = get_next_due_ns();
  backlogged_ = pending_ > 0;
  if (backlogged_) {
    due_ns_ = expected_ns;
    awake_ns_ = get_monotonic_ns();
    latency_ns_ = std::max<std::int64_t>(awake_ns_ - due_ns_, 0);
  } else {
    if (!wait_for_ticks(stop)) return false;
    awake_ns_ = get_monotonic_ns();
    due_ns_ = awake_ns_ - (pending_ - 1) * period_ns_;
    latency_ns_ = std::max<std::int64_t>(awake_ns_ - std::min(due_ns_, expected_ns), 0);
  }
  --pending_;
  return true;
}

}  // namespace unlatch::hil
