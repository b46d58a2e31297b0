// The kernels for one body at a time alone: half of the code of dispatch/baseline.cc. The bits are the same.
#define UNLATCH_ISA baseline
#include "kernel/dispatch/build_kernels.h"

namespace unlatch {
namespace baseline {
constinit const Kernels kScalarKernels = build_kernels<1>();
}

constinit const Kernels* const kKernelTables[] = {&baseline::kScalarKernels, &baseline::kScalarKernels,
                                                  &baseline::kScalarKernels, &baseline::kScalarKernels,
                                                  &baseline::kScalarKernels};

}  // namespace unlatch
