// RISC-V with 64 bits and double-precision FPU: `qemu-system-riscv64 -M virt -bios none -semihosting`, machine mode.
// The register instret counts instructions (with `-icount shift=0`). The serial port is the 16550; the timer goes at 10
// MHz.
#include "kernel/targets/ports/run.h"
#include "kernel/targets/ports/semihosting.h"
#include "kernel/targets/serial.h"

namespace unlatch::target {
namespace {

volatile std::uint8_t* get_register(std::uintptr_t address) {
  return reinterpret_cast<volatile std::uint8_t*>(address);
}
constexpr std::uintptr_t kSerialData = 0x10000000, kSerialBuffers = 0x10000002, kSerialState = 0x10000005;
constexpr std::uint8_t kSerialHasByte = 1, kSerialHasPlace = 1U << 5;  // of the state
constexpr std::uint64_t kTicksPerMicrosecond = 10;

}  // namespace

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

std::uint64_t read_clock_us() {
  std::uint64_t now;
  asm volatile("csrr %0, time" : "=r"(now));
  return now / kTicksPerMicrosecond;
}

void open_serial() { *get_register(kSerialBuffers) = 0xC1; }  // 16 bytes are kept

bool read_serial(std::uint8_t& byte) {
  if ((*get_register(kSerialState) & kSerialHasByte) == 0) return false;
  byte = *get_register(kSerialData);
  return true;
}

bool write_serial(std::uint8_t byte) {
  if ((*get_register(kSerialState) & kSerialHasPlace) == 0) return false;
  *get_register(kSerialData) = byte;
  return true;
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
