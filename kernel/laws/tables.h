// Tables: values over one to six axes, between whose knots they are interpolated (Table in unlatch/model/law.h).
//
// Cost: one bucket per axis finds the cell, whatever the number of knots; where knots lie unevenly, so that a bucket
// holds several, these are bisected. Then 2ⁿ values of a linear table, up to 4ⁿ coefficients of a smooth one.
#pragma once

#include "kernel/plan/evaluation.h"

namespace unlatch {

// The bucket of an axis that a coordinate is in; `first`: the axis's first knot. Those before it, and NaN, which is
// where the scale has overflowed, are in bucket 0, those beyond the axis in the last one.
inline std::int32_t find_bucket(const PlanTableAxis& axis, double first, double x) {
  const double part = (x - first) * axis.bucket_scale;  // may be any number
  if (!(part >= 1)) return 0;
  return part < axis.bucket_count ? static_cast<std::int32_t>(part) : axis.bucket_count - 1;
}

// Value at the coordinates `at`, one per axis, without scale and offset; NaN if one of them is. `exit`: the first axis
// that is left, unless it has one already.
double calc_table(const PlanLaws& plan, const PlanTable& table, const double* at, TableExit& exit) noexcept;

}  // namespace unlatch
