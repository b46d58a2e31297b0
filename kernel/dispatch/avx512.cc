// Eight numbers at a time. Compiled with -mavx512f -mavx512dq -mavx512vl.
#define UNLATCH_ISA avx512
#include "kernel/dispatch/build_kernels.h"

namespace unlatch::avx512 {

constinit const Kernels kKernels = build_kernels<8>();

}  // namespace unlatch::avx512
