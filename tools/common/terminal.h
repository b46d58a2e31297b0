// Terminal output: colours on a terminal only, a progress line that does not fill a file.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

namespace unlatch::tools {

enum class Colour { kBold, kGreen, kYellow, kRed, kDim };

bool is_terminal(std::FILE* stream);
// `stream` is a terminal and NO_COLOR is not set.
bool has_colours(std::FILE* stream);
// `text` in a colour, if there are any; else as it is.
std::string paint(bool colours, Colour colour, const std::string& text);
std::string paint(std::FILE* stream, Colour colour, const std::string& text);
// A heading: bold, after an empty line.
void print_heading(std::FILE* to, const std::string& text);

// Progress of a run and its remaining time, on standard error: on a terminal one line that is overwritten, elsewhere a
// line each quarter. Silent for runs that take less than a second.
class Progress {
 public:
  Progress(double dt, std::int64_t last_tick);
  void show(std::int64_t tick);
  void clear();  // before anything else is printed

 private:
  [[nodiscard]] std::string describe_rest(std::int64_t tick, std::chrono::steady_clock::time_point now) const;

  const double dt_;  // s
  const std::int64_t last_tick_;
  std::int64_t first_tick_ = -1;  // of the first look
  const bool terminal_;
  const std::chrono::steady_clock::time_point started_;
  std::optional<std::chrono::steady_clock::time_point> shown_;
  std::int64_t quarter_ = 0;
  bool line_open_ = false;
};

}  // namespace unlatch::tools
