// RISC-V with 64 bits and double-precision FPU: `qemu-system-riscv64 -M virt -bios none -semihosting`, machine mode.
// The register instret counts instructions (with `-icount shift=0`).
#include "kernel/targets/ports/run.h"
#include "kernel/targets/ports/semihosting.h"

namespace unlatch::target {

std::uintptr_t call_debugger(std::uintptr_t operation, const void* argument) {
  register std::uintptr_t a0 asm("a0") = operation;
  register const void* a1 asm("a1") = argument;
  // The three instructions, uncompressed and on one page, are the call.
  asm volatile(".balign 16\n .option push\n .option norvc\n slli x0, x0, 0x1f\n ebreak\n srai x0, x0, 7\n .option pop"
               : "+r"(a0)
               : "r"(a1)
               : "memory");
  return a0;
}

const std::uint32_t kInstructionUnit = 1;

std::uint64_t read_counter() {
  std::uint64_t now;
  asm volatile("csrr %0, minstret" : "=r"(now));
  return now;
}

}  // namespace unlatch::target

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
  j target_fault
)");
