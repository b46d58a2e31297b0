#include "kernel/dispatch/lane_kernels.h"

namespace unlatch {

bool is_supported(Lanes lanes) {
#if defined(__x86_64__)
  if (lanes == Lanes::kFour) return __builtin_cpu_supports("avx2");
  if (lanes == Lanes::kEight)
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
#else
  if (lanes == Lanes::kFour || lanes == Lanes::kEight) return false;
#endif
  return true;
}

const LaneKernels& get_kernels(Lanes lanes) {
  if (lanes == Lanes::kScalar) return baseline::kScalarKernels;
#if defined(__x86_64__)
  const bool any = lanes == Lanes::kAuto;
  if (lanes == Lanes::kEight || (any && is_supported(Lanes::kEight))) return avx512::kKernels;
  if (lanes == Lanes::kFour || (any && is_supported(Lanes::kFour))) return avx2::kKernels;
#endif
  return baseline::kKernels;
}

const char* get_name(Lanes lanes) {
  switch (lanes == Lanes::kAuto ? get_kernels(lanes).lanes : lanes) {
    case Lanes::kScalar:
      return "scalar";
#if defined(__x86_64__)
    case Lanes::kTwo:
      return "sse2";
#else
    case Lanes::kTwo:
      return "neon";
#endif
    case Lanes::kFour:
      return "avx2";
    case Lanes::kEight:
      return "avx512";
    case Lanes::kAuto:
      break;
  }
  return "";
}

}  // namespace unlatch
