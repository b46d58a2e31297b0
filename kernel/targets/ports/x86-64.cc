// x86-64 without operating system: `qemu-system-x86_64 -kernel`, by the PVH note, which starts in 32-bit mode with
// paging off. Text goes to QEMU's debug port. With `-icount shift=0` the time stamp counter counts instructions. AVX is
// on, so that the kernels of the computer's own library run here too (cost.cmake).
#include <cstddef>
#include <cstdint>

#include "kernel/targets/port.h"
#include "kernel/targets/ports/run.h"

namespace unlatch::target {
namespace {

constexpr std::uint16_t kDebugPort = 0xE9, kPowerPort = 0x604, kExitPort = 0xF4;
constexpr std::uint16_t kPowerOff = 0x2000;

template <class T>
void put(std::uint16_t port, T value) {
  if constexpr (sizeof(T) == 1)
    asm volatile("outb %0, %1" : : "a"(value), "Nd"(port));
  else
    asm volatile("outw %0, %1" : : "a"(value), "Nd"(port));
}

}  // namespace

const std::uint32_t kInstructionUnit = 1;

std::uint64_t read_counter() {
  std::uint32_t low = 0, high = 0;
  asm volatile("rdtsc" : "=a"(low), "=d"(high));
  return std::uint64_t{high} << 32 | low;
}

void write(const char* text) {
  while (*text != 0) put(kDebugPort, *text++);
}

void finish(int code) {
  if (code == 0) put(kPowerPort, kPowerOff);
  for (;;) put(kExitPort, static_cast<std::uint8_t>(code));
}

}  // namespace unlatch::target

// Pages of 2 MiB for the first GiB, long mode, SSE and AVX on.
asm(R"(
  .section .note.start, "a", @note
  .balign 4
  .long 4, 4, 18
  .asciz "Xen"
  .long target_start
  .section .pages, "aw", @nobits
  .balign 4096
target_pages: .skip 3 * 4096
  .section .start, "ax"
  .code32
  .global target_start
target_start:
  cli
  mov $target_stack_end, %esp
  mov $target_pages, %edi
  xor %eax, %eax
  mov $3 * 1024, %ecx
  cld
  rep stosl
  movl $target_pages + 4096 + 3, target_pages
  movl $target_pages + 8192 + 3, target_pages + 4096
  mov $0x83, %eax
  xor %ecx, %ecx
1:
  mov %eax, target_pages + 8192(, %ecx, 8)
  add $0x200000, %eax
  inc %ecx
  cmp $512, %ecx
  jne 1b
  mov $target_pages, %eax
  mov %eax, %cr3
  mov %cr4, %eax
  or $(1 << 5 | 1 << 9 | 1 << 10 | 1 << 18), %eax
  mov %eax, %cr4
  mov $0xC0000080, %ecx
  rdmsr
  or $0x100, %eax
  wrmsr
  mov %cr0, %eax
  and $~4, %eax
  or $0x80000002, %eax
  mov %eax, %cr0
  lgdt target_table_at
  ljmp $8, $target_long
  .balign 8
target_table:
  .quad 0, 0x00AF9A000000FFFF, 0x00CF92000000FFFF
target_table_at:
  .word 23
  .long target_table
  .code64
target_long:
  mov $16, %eax
  mov %eax, %ds
  mov %eax, %es
  mov %eax, %ss
  xor %ecx, %ecx
  xgetbv
  or $7, %eax
  xsetbv
  and $-16, %rsp
  sub $8, %rsp
  jmp target_run
)");
