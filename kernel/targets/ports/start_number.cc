// draw_start_number() of serial.h by semihosting: of the debugger's clock, in seconds, and of the board's own.
#include "kernel/targets/ports/semihosting.h"
#include "kernel/targets/serial.h"

namespace unlatch::target {

std::uint32_t draw_start_number() {
  constexpr std::uintptr_t kTime = 0x11;  // SYS_TIME
  const auto seconds = static_cast<std::uint32_t>(call_debugger(kTime, nullptr));
  return seconds * 0x9E3779B1U ^ static_cast<std::uint32_t>(read_clock_us());
}

}  // namespace unlatch::target
