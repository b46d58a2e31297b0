// What every processor of the family has: one number at a time, or two.
#define UNLATCH_ISA baseline
#include "kernel/solver/lane_solver.h"

namespace unlatch::baseline {

constinit const LaneKernels kScalarKernels = build_kernels<1>(Lanes::kScalar);
constinit const LaneKernels kKernels = build_kernels<2>(Lanes::kTwo);

}  // namespace unlatch::baseline
