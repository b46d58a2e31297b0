// Cyclone's log. It reports what it cannot read there and nowhere else, a line for each packet, from the thread that
// receives: so the lines are counted, passed on to standard error only a few a second, and never waited for.
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace unlatch::bridge {

// Lines that may be passed on: a few in each second; the rest is counted and printed with the first line of a later
// second.
class LineLimit {
 public:
  static constexpr int kLinesPerSecond = 10;

  // The text to pass on for `line`, empty for nothing.
  [[nodiscard]] std::string pass(std::string_view line, std::chrono::nanoseconds now);

 private:
  std::optional<std::chrono::nanoseconds> second_began_;
  int lines_ = 0;                // in it
  std::int64_t suppressed_ = 0;  // since the last line that was passed on
};

// From now on Cyclone's log comes here, that of the trace too. A second call does nothing.
void take_dds_log();

// Packets and samples that Cyclone could not read, in this process so far.
[[nodiscard]] std::int64_t get_dds_unreadable() noexcept;

}  // namespace unlatch::bridge
