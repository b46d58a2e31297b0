#include "kernel/targets/ports/semihosting.h"

namespace unlatch::target {
namespace {

constexpr std::uintptr_t kWriteText = 0x04, kExit = 0x20;  // SYS_WRITE0, SYS_EXIT_EXTENDED
constexpr std::uintptr_t kStopped = 0x20026;               // ADP_Stopped_ApplicationExit

}  // namespace

void write(const char* text) { call_debugger(kWriteText, text); }

void finish(int code) {
  const std::uintptr_t block[2] = {kStopped, static_cast<std::uintptr_t>(code)};
  call_debugger(kExit, block);
  for (;;) {
  }
}

}  // namespace unlatch::target
