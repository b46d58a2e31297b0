#include "kernel/simd/instruction_set.h"

namespace unlatch {

bool is_supported(InstructionSet set) {
#if defined(__x86_64__) && !defined(UNLATCH_BASELINE_ONLY)
  if (set == InstructionSet::k256) return __builtin_cpu_supports("avx2");
  if (set == InstructionSet::k512)
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
#else
  if (set == InstructionSet::k256 || set == InstructionSet::k512) return false;
#endif
  return true;
}

InstructionSet resolve(InstructionSet set) {
  if (set != InstructionSet::kAuto) return set;
  if (is_supported(InstructionSet::k512)) return InstructionSet::k512;
  return is_supported(InstructionSet::k256) ? InstructionSet::k256 : InstructionSet::k128;
}

const char* get_name(InstructionSet set) {
  switch (resolve(set)) {
    case InstructionSet::kAuto:
      break;
    case InstructionSet::kScalar:
      return "scalar";
    case InstructionSet::k128:
#if defined(__x86_64__)
      return "sse2";
#else
      return "neon";
#endif
    case InstructionSet::k256:
      return "avx2";
    case InstructionSet::k512:
      return "avx512";
  }
  return "";
}

}  // namespace unlatch
