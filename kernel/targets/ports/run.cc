#include "kernel/targets/ports/run.h"

#include "kernel/targets/port.h"

// From the linker script.
extern "C" std::uint32_t target_bss_begin[], target_bss_end[];

int main();

void target_run() {
  for (std::uint32_t* to = target_bss_begin; to < target_bss_end;) *to++ = 0;
  main();
  unlatch::target::finish(0);
}

void target_fault() {
  unlatch::target::write("fault\n");
  unlatch::target::finish(2);
}
