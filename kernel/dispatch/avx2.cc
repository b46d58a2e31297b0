// Four numbers at a time. Compiled with -mavx2.
#define UNLATCH_ISA avx2
#include "kernel/solver/lane_solver.h"

namespace unlatch::avx2 {

constinit const LaneKernels kKernels = build_kernels<4>(Lanes::kFour);

}  // namespace unlatch::avx2
