// Whether a requirement's value, an extreme of what is known at knots alone, is known well enough for a verdict.
#pragma once

#include "hil/run/analysis/requirements.h"
#include "hil/run/extremes/extreme_bounds.h"
#include "hil/run/extremes/smooth_part.h"

namespace unlatch::hil {

// Part of the value by which an extreme may be wrong, or of kLimitPart of its limit if that is larger.
inline constexpr double kKnown = 0.01, kLimitPart = 0.1;

// The smallest and the greatest value that were found, and their bounds.
struct FoundExtremes {
  double low = 0, high = 0;
  const ExtremeBounds::Bound &least, &most;  // of the negative
  SmoothPart part;                           // that the bounds are of
};

// Sets the verdict's uncertainty. The verdict is unresolved if that is more than kKnown allows, or if the limit is
// within what the value may be; of a value that is known from two knots alone, as between commands that change at each
// tick, what it may be if it changes between them as it has elsewhere. `dt`: the step of the run, s.
void judge_extreme(const Requirement& requirement, const FoundExtremes& found, double dt, Verdict& verdict);

}  // namespace unlatch::hil
