#include "tools/common/terminal.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace unlatch::tools {
namespace {

using namespace std::chrono_literals;

constexpr int kBarWidth = 30;

const char* get_code(Colour colour) {
  switch (colour) {
    case Colour::kBold:
      return "\033[1m";
    case Colour::kGreen:
      return "\033[32m";
    case Colour::kYellow:
      return "\033[33m";
    case Colour::kRed:
      return "\033[31m";
    case Colour::kDim:
      return "\033[2m";
  }
  return "";
}

}  // namespace

bool is_terminal(std::FILE* stream) { return isatty(fileno(stream)) == 1; }

// https://no-color.org: set and not empty.
bool has_colours(std::FILE* stream) {
  const char* const refused = std::getenv("NO_COLOR");
  return is_terminal(stream) && (refused == nullptr || *refused == 0);
}

std::string paint(bool colours, Colour colour, const std::string& text) {
  return colours ? get_code(colour) + text + "\033[0m" : text;
}

std::string paint(std::FILE* stream, Colour colour, const std::string& text) {
  return paint(has_colours(stream), colour, text);
}

void print_heading(std::FILE* to, const std::string& text) {
  std::fprintf(to, "\n%s\n", paint(to, Colour::kBold, text).c_str());
}

Progress::Progress(double dt, std::int64_t last_tick)
    : dt_(dt), last_tick_(last_tick), terminal_(is_terminal(stderr)), started_(std::chrono::steady_clock::now()) {}

void Progress::show(std::int64_t tick) {
  if (first_tick_ < 0) first_tick_ = tick;
  const auto now = std::chrono::steady_clock::now();
  if (now - started_ < 1s || last_tick_ <= 0) return;
  const double share = std::min(1.0, static_cast<double>(tick) / static_cast<double>(last_tick_));
  const double time = static_cast<double>(tick) * dt_, end = static_cast<double>(last_tick_) * dt_;
  if (!terminal_) {
    const auto quarter = static_cast<std::int64_t>(4 * share);
    if (quarter > quarter_) std::fprintf(stderr, "  t = %.3f s of %g s (%.0f %%)\n", time, end, 100 * share);
    quarter_ = quarter;
    return;
  }
  if (shown_ && now - *shown_ < 100ms) return;
  shown_ = now;
  const auto filled = static_cast<std::size_t>(kBarWidth * share);
  const std::string bar = std::string(filled, '#') + std::string(kBarWidth - filled, '.');
  std::fprintf(stderr, "\r  [%s] t = %.3f s of %g s%s \033[K", bar.c_str(), time, end,
               describe_rest(tick, now).c_str());
  std::fflush(stderr);
  line_open_ = true;
}

// At the pace so far.
std::string Progress::describe_rest(std::int64_t tick, std::chrono::steady_clock::time_point now) const {
  if (tick <= first_tick_) return "";
  const double passed = std::chrono::duration<double>(now - started_).count();
  const double rest = passed * static_cast<double>(last_tick_ - tick) / static_cast<double>(tick - first_tick_);
  const auto seconds = static_cast<long long>(std::ceil(std::max(0.0, rest)));
  char text[48];
  if (seconds < 100) {
    std::snprintf(text, sizeof text, ", %lld s left", seconds);
  } else {
    std::snprintf(text, sizeof text, ", %lld min %02lld s left", seconds / 60, seconds % 60);
  }
  return text;
}

void Progress::clear() {
  if (line_open_) std::fputs("\r\033[K", stderr);
  line_open_ = false;
}

}  // namespace unlatch::tools
