#include "kernel/dispatch/kernels.h"

namespace unlatch {

constinit const Kernels* const kKernelTables[] = {
    &baseline::kScalarKernels,  // kAuto: a plan has chosen
    &baseline::kScalarKernels, &baseline::kKernels,
#if defined(__x86_64__) && !defined(UNLATCH_BASELINE_ONLY)
    &avx2::kKernels,           &avx512::kKernels,
#else
    &baseline::kKernels,       &baseline::kKernels,
#endif
};

}  // namespace unlatch
