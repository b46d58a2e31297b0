// Peaks of the joints' reactions over a run. Multipliers are known at the ends of sub-steps and at events: a peak
// between them is that of the polynomial through five of them within a smooth run.
#pragma once

#include <cstddef>
#include <vector>

#include "hil/motion/extreme.h"
#include "hil/motion/sampled_curve.h"
#include "unlatch/motion.h"
#include "unlatch/workspace.h"

namespace unlatch::hil {

struct PeakReaction {
  double value = 0, time = 0;  // signed, of the largest size so far; N or N m, s
};

class PeakReactions {
 public:
  explicit PeakReactions(std::size_t joints) : rows_(joints * kRows) {}

  // The reactions of the initial state.
  void begin(double time, const MultiplierView& multipliers);
  // A piece of motion between two knots; `smooth`: it continues the piece before.
  void add(const MotionKnot& from, const MotionKnot& to, bool smooth);

  // Of one row of a joint.
  [[nodiscard]] PeakReaction get(std::size_t joint, std::size_t row) const;

 private:
  struct Row {
    SampledCurve curve;
    Smallest low, high;  // `high`: of the negative
    bool loaded = false;
  };
  static void finish(Row& row);

  std::vector<Row> rows_;
};

}  // namespace unlatch::hil
