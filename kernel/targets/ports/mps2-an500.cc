// Cortex-M7 with double-precision FPU: Arm's MPS2 board with the image AN500, or `qemu-system-arm -M mps2-an500`.
// Output by semihosting, so that a debugger shows it too. SysTick counts time; with `-icount shift=0` QEMU's clock goes
// on by 1 ns with each instruction, so that one count of SysTick, at 25 MHz, is 40 instructions. The serial port is
// UART0.
#include "kernel/targets/ports/run.h"
#include "kernel/targets/ports/semihosting.h"
#include "kernel/targets/serial.h"

extern "C" {
extern std::uint32_t target_data_from[], target_data_begin[], target_data_end[];
[[noreturn]] void target_start();
}

namespace unlatch::target {
namespace {

volatile std::uint32_t* get_register(std::uintptr_t address) {
  return reinterpret_cast<volatile std::uint32_t*>(address);
}
constexpr std::uintptr_t kCpacr = 0xE000ED88;  // who may use the FPU
constexpr std::uintptr_t kTickControl = 0xE000E010, kTickReload = 0xE000E014, kTickNow = 0xE000E018;
constexpr std::uint32_t kTickMost = 0x00FFFFFF, kTicksPerMicrosecond = 25;
constexpr std::uintptr_t kSerialData = 0x40004000, kSerialState = 0x40004004, kSerialControl = 0x40004008,
                         kSerialDivider = 0x40004010;
constexpr std::uint32_t kSerialFull = 1, kSerialHasByte = 2;  // of the state
constexpr std::uint32_t kSerialBaud = 921600;

std::uint64_t ticks_before = 0;
std::uint32_t last_count = kTickMost;

}  // namespace

const std::uint32_t kInstructionUnit = 40;

std::uintptr_t call_debugger(std::uintptr_t operation, const void* argument) {
  register std::uintptr_t r0 asm("r0") = operation;
  register const void* r1 asm("r1") = argument;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

// Counts down from kTickMost; called more often than every 2^24 counts.
std::uint64_t read_counter() {
  const std::uint32_t now = *get_register(kTickNow);
  ticks_before += (last_count - now) & kTickMost;
  last_count = now;
  return ticks_before;
}

std::uint64_t read_clock_us() { return read_counter() / kTicksPerMicrosecond; }

void open_serial() {
  *get_register(kSerialDivider) = kTicksPerMicrosecond * 1'000'000 / kSerialBaud;
  *get_register(kSerialControl) = 3;  // sends and receives
}

bool read_serial(std::uint8_t& byte) {
  if ((*get_register(kSerialState) & kSerialHasByte) == 0) return false;
  byte = static_cast<std::uint8_t>(*get_register(kSerialData));
  return true;
}

bool write_serial(std::uint8_t byte) {
  if ((*get_register(kSerialState) & kSerialFull) != 0) return false;
  *get_register(kSerialData) = byte;
  return true;
}

}  // namespace unlatch::target

extern "C" {

void target_start() {
  using namespace unlatch::target;
  *get_register(kCpacr) |= 0xFu << 20;
  asm volatile("dsb\n isb" ::: "memory");
  const std::uint32_t* from = target_data_from;
  for (std::uint32_t* to = target_data_begin; to < target_data_end;) *to++ = *from++;
  *get_register(kTickReload) = kTickMost;
  *get_register(kTickNow) = 0;
  *get_register(kTickControl) = 5;  // on, the processor's clock, no interrupt
  target_run();
}

// What the processor reads at its start: the initial stack pointer, then the handlers up to SysTick.
struct Vectors {
  void* stack;
  void (*start)();
  void (*faults[5])();  // NMI, hard, memory, bus, usage
  void (*none[4])();
  void (*others[5])();  // SVC, debug, none, PendSV, SysTick
};
__attribute__((section(".vectors"), used))
const Vectors target_vectors = {target_stack_end,
                                target_start,
                                {target_fault, target_fault, target_fault, target_fault, target_fault},
                                {},
                                {target_fault, target_fault, nullptr, target_fault, target_fault}};
}
