#include "bridge/dds/dds_log.h"

#include <dds/ddsrt/log.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <climits>

#include "hil/scenario/text/count.h"

namespace unlatch::bridge {
namespace {

std::atomic<std::int64_t> g_unreadable{0};
std::mutex g_mutex;
LineLimit g_limit;

// A pipe that can be written to takes PIPE_BUF bytes at once.
void write_if_possible(const std::string& text) {
  pollfd out{.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
  if (poll(&out, 1, 0) != 1 || (out.revents & POLLOUT) == 0) return;
  (void)!write(STDERR_FILENO, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF));
}

void take_line(const dds_log_data_t& line) {
  const std::string_view text(line.message, line.size);
  // A packet or a sample that cannot be read has one line.
  if (text.find("malformed packet") != std::string_view::npos ||
      text.find(": deserialization unlatch") != std::string_view::npos) {
    g_unreadable.fetch_add(1, std::memory_order_relaxed);
  }
  const std::lock_guard lock(g_mutex);
  const std::string passed = g_limit.pass(text, std::chrono::steady_clock::now().time_since_epoch());
  if (!passed.empty()) write_if_possible(passed);
}

void take_log(void*, const dds_log_data_t* line) { take_line(*line); }

// A line that is in the log as well is taken from there.
void take_trace(void*, const dds_log_data_t* line) {
  if ((line->priority & DDS_LOG_MASK) == 0) take_line(*line);
}

}  // namespace

std::string LineLimit::pass(std::string_view line, std::chrono::nanoseconds now) {
  if (!second_began_ || now - *second_began_ >= std::chrono::seconds(1)) {
    second_began_ = now;
    lines_ = 0;
  }
  if (++lines_ > kLinesPerSecond) {
    ++suppressed_;
    return {};
  }
  std::string text;
  if (suppressed_ > 0) text = "Cyclone DDS: " + hil::count(suppressed_, "more line") + ", not shown\n";
  suppressed_ = 0;
  while (!line.empty() && line.back() == '\n') line.remove_suffix(1);
  return text + "Cyclone DDS: " + std::string(line) + "\n";
}

void take_dds_log() {
  static std::once_flag once;
  std::call_once(once, [] {
    dds_set_log_sink(take_log, nullptr);
    dds_set_trace_sink(take_trace, nullptr);
  });
}

std::int64_t get_dds_unreadable() noexcept { return g_unreadable.load(std::memory_order_relaxed); }

}  // namespace unlatch::bridge
