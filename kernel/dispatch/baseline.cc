// One number at a time, or two: every processor of the family can.
#define UNLATCH_ISA baseline
#include "kernel/dispatch/build_kernels.h"

namespace unlatch::baseline {

constinit const Kernels kScalarKernels = build_kernels<1>();
constinit const Kernels kKernels = build_kernels<2>();

}  // namespace unlatch::baseline
