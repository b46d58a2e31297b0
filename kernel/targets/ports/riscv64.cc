// RISC-V with 64 bits and double-precision FPU: `qemu-system-riscv64 -M virt -bios none -semihosting`, machine mode.
// The register instret counts instructions (with `-icount shift=0`).
#include "kernel/targets/port.h"

extern "C" {
extern std::uint64_t target_bss_begin[], target_bss_end[];
int main();
[[noreturn]] void target_run();
}

namespace unlatch::target {
namespace {

std::uint64_t call_debugger(std::uint64_t operation, const void* argument) {
  register std::uint64_t a0 asm("a0") = operation;
  register const void* a1 asm("a1") = argument;
  // The three instructions, uncompressed and on one page, are the call.
  asm volatile(".balign 16\n .option push\n .option norvc\n slli x0, x0, 0x1f\n ebreak\n srai x0, x0, 7\n .option pop"
               : "+r"(a0)
               : "r"(a1)
               : "memory");
  return a0;
}

}  // namespace

const std::uint32_t kInstructionUnit = 1;

void write(const char* text) { call_debugger(0x04, text); }  // SYS_WRITE0

void finish(int code) {
  const std::uint64_t block[2] = {0x20026, static_cast<std::uint64_t>(code)};  // ADP_Stopped_ApplicationExit
  call_debugger(0x20, block);                                                  // SYS_EXIT_EXTENDED
  for (;;) {
  }
}

std::uint64_t read_counter() {
  std::uint64_t now;
  asm volatile("csrr %0, minstret" : "=r"(now));
  return now;
}

}  // namespace unlatch::target

extern "C" void target_run() {
  for (std::uint64_t* to = target_bss_begin; to < target_bss_end;) *to++ = 0;
  main();
  unlatch::target::finish(0);
}

// Stack, FPU on, exceptions end the program.
asm(R"(
  .section .start, "ax"
  .global target_start
target_start:
  la sp, target_stack_end
  li t0, 1 << 13
  csrs mstatus, t0
  la t0, target_trap
  csrw mtvec, t0
  j target_run
  .balign 4
target_trap:
  li a0, 2
  j target_finish
)");
extern "C" [[noreturn]] void target_finish(int code) {
  unlatch::target::write("fault\n");
  unlatch::target::finish(code);
}
