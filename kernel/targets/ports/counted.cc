// A computer with Linux whose programs count their own instructions: tools/cost --natively puts counters into the
// assembly of the stepping part, and links this file.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "kernel/dispatch/kernels.h"
#include "kernel/targets/port.h"

// Of the counters.
extern "C" {
std::uint64_t target_counter = 0, target_saved = 0;
}

namespace unlatch {

// Those of a processor without AVX-512, which the tables are of.
constinit const Kernels* const kKernelTables[] = {&baseline::kScalarKernels, &baseline::kScalarKernels,
                                                  &baseline::kKernels, &avx2::kKernels, &avx2::kKernels};

namespace target {

const std::uint32_t kInstructionUnit = 1;

std::uint64_t read_counter() { return target_counter; }

void write(const char* text) { std::fputs(text, stdout); }

void finish(int code) {
  std::fflush(stdout);
  std::_Exit(code);
}

}  // namespace target
}  // namespace unlatch
