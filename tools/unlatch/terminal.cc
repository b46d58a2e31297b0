#include "tools/unlatch/terminal.h"

#include <unistd.h>

#include <cstdlib>

namespace unlatch::tools {
namespace {

using namespace std::chrono_literals;

constexpr int kBarWidth = 30;

bool is_terminal(std::FILE* stream) { return isatty(fileno(stream)) == 1; }

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

std::string paint(std::FILE* stream, Colour colour, const std::string& text) {
  if (!is_terminal(stream) || std::getenv("NO_COLOR") != nullptr) return text;
  return get_code(colour) + text + "\033[0m";
}

Progress::Progress(double dt, std::int64_t last_tick)
    : dt_(dt), last_tick_(last_tick), terminal_(is_terminal(stderr)), started_(std::chrono::steady_clock::now()) {}

void Progress::show(std::int64_t tick) {
  const auto now = std::chrono::steady_clock::now();
  if (now - started_ < 1s || last_tick_ <= 0) return;
  const double share = static_cast<double>(tick) / static_cast<double>(last_tick_);
  const double time = static_cast<double>(tick) * dt_, end = static_cast<double>(last_tick_) * dt_;
  if (!terminal_) {
    const auto quarter = static_cast<std::int64_t>(4 * share);
    if (quarter > quarter_) std::fprintf(stderr, "  t = %.3f s of %g s (%.0f %%)\n", time, end, 100 * share);
    quarter_ = quarter;
    return;
  }
  if (now - shown_ < 100ms) return;
  shown_ = now;
  const auto filled = static_cast<std::size_t>(kBarWidth * share);
  const std::string bar = std::string(filled, '#') + std::string(kBarWidth - filled, '.');
  std::fprintf(stderr, "\r  [%s] t = %.3f s of %g s \033[K", bar.c_str(), time, end);
  std::fflush(stderr);
  line_open_ = true;
}

void Progress::clear() {
  if (line_open_) std::fputs("\r\033[K", stderr);
  line_open_ = false;
}

}  // namespace unlatch::tools
