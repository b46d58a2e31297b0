// Cortex-A53: `qemu-system-aarch64 -M virt -cpu cortex-a53 -semihosting`. Memory is used without translation, so that
// code must keep natural alignment (-mstrict-align). The virtual counter goes at 62.5 MHz; with `-icount shift=0` one
// count is 16 instructions. The serial port is the PL011.
#include "kernel/targets/ports/run.h"
#include "kernel/targets/ports/semihosting.h"
#include "kernel/targets/serial.h"

namespace unlatch::target {
namespace {

volatile std::uint32_t* get_register(std::uintptr_t address) {
  return reinterpret_cast<volatile std::uint32_t*>(address);
}
constexpr std::uintptr_t kSerialData = 0x09000000, kSerialFlags = 0x09000018, kSerialFormat = 0x0900002C,
                         kSerialControl = 0x09000030;
constexpr std::uint32_t kSerialIsEmpty = 1U << 4, kSerialIsFull = 1U << 5;  // of the flags
constexpr std::uint32_t kSerialEightBits = 0x70;                            // 16 bytes are kept
constexpr std::uint32_t kSerialOn = 0x301;                                  // sends and receives

}  // namespace

std::uintptr_t call_debugger(std::uintptr_t operation, const void* argument) {
  register std::uintptr_t x0 asm("x0") = operation;
  register const void* x1 asm("x1") = argument;
  asm volatile("hlt 0xF000" : "+r"(x0) : "r"(x1) : "memory");
  return x0;
}

const std::uint32_t kInstructionUnit = 16;

std::uint64_t read_counter() {
  std::uint64_t now;
  asm volatile("isb\n mrs %0, cntvct_el0" : "=r"(now));
  return now;
}

std::uint64_t read_clock_us() {
  std::uint64_t frequency;
  asm volatile("mrs %0, cntfrq_el0" : "=r"(frequency));
  return read_counter() * 1000 / (frequency / 1000);
}

void open_serial() {
  *get_register(kSerialFormat) = kSerialEightBits;
  *get_register(kSerialControl) = kSerialOn;
}

bool read_serial(std::uint8_t& byte) {
  if ((*get_register(kSerialFlags) & kSerialIsEmpty) != 0) return false;
  byte = static_cast<std::uint8_t>(*get_register(kSerialData));
  return true;
}

bool write_serial(std::uint8_t byte) {
  if ((*get_register(kSerialFlags) & kSerialIsFull) != 0) return false;
  *get_register(kSerialData) = byte;
  return true;
}

}  // namespace unlatch::target

// Stack, FPU on, exceptions end the program.
asm(R"(
  .section .start, "ax"
  .global target_start
target_start:
  adrp x0, target_stack_end
  add x0, x0, :lo12:target_stack_end
  mov sp, x0
  mov x0, #(3 << 20)
  msr cpacr_el1, x0
  isb
  adrp x0, target_exceptions
  add x0, x0, :lo12:target_exceptions
  msr vbar_el1, x0
  b target_run
  .balign 2048
target_exceptions:
  .rept 16
  b target_fault
  .balign 128
  .endr
)");
