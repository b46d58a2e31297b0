// The targets that are measured. Written by tools/cost.
#include <array>

#include "kernel/cost/measured.h"

namespace unlatch::cost {

extern const Measured kX8664, kCortexM7, kCortexA53, kRiscv64;

std::span<const Measured* const> list_measured() noexcept {
  static constexpr std::array kAll = {&kX8664, &kCortexM7, &kCortexA53, &kRiscv64};
  return kAll;
}

}  // namespace unlatch::cost
