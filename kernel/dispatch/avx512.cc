// Eight numbers at a time. Compiled with -mavx512f and its companions.
#define UNLATCH_ISA avx512
#include "kernel/solver/lane_solver.h"

namespace unlatch::avx512 {

constinit const LaneKernels kKernels = build_kernels<8>(Lanes::kEight);

}  // namespace unlatch::avx512
