// Four numbers at a time. Compiled with -mavx2.
#define UNLATCH_ISA avx2
#include "kernel/dispatch/build_kernels.h"

namespace unlatch::avx2 {

constinit const Kernels kKernels = build_kernels<4>();

}  // namespace unlatch::avx2
