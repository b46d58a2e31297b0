// The lower triangle of a symmetric matrix that is kept by rows in memory of another.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernel/math/spatial.h"

namespace unlatch {

struct LowerTriangle {
  double* entries;
  std::int32_t stride;  // from one row to the next

  UNLATCH_INLINE double* row(int r) const { return entries + static_cast<std::ptrdiff_t>(r) * stride; }
  UNLATCH_INLINE double& operator()(int r, int c) const { return row(r)[c]; }  // c ≤ r
};

}  // namespace unlatch
