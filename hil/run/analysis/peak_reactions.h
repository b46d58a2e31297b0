// Peaks of the joints' reactions over a run. Multipliers are known at the ends of sub-steps and at events: a peak
// between them is that of the polynomial through six of them within a smooth run, with its bounds (extreme_bounds.h).
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "hil/run/extremes/extreme_bounds.h"
#include "unlatch/motion.h"
#include "unlatch/workspace.h"

namespace unlatch::hil {

struct PeakReaction {
  double value = 0, time = 0;  // largest value so far, with its sign; N or N m, s
  double uncertainty = 0;      // how far its size may be wrong, at most
  bool at_ticks = false;       // it is that of a tick or an event; between two of them it may be larger
  // Part of the value that its uncertainty may be without a word.
  static constexpr double kExact = 1e-3;
  [[nodiscard]] bool is_uncertain() const { return uncertainty > kExact * std::abs(value); }
};

class PeakReactions {
 public:
  explicit PeakReactions(std::size_t joints) : rows_(joints * kRows) {}

  // Adds the reactions of the initial state.
  void begin(double time, const MultiplierView& multipliers);
  // Adds a piece of motion between two knots; `smooth`: it continues the piece before, forces included.
  void add(const MotionKnot& from, const MotionKnot& to, bool smooth);

  // Peak of one row of a joint.
  [[nodiscard]] PeakReaction get(std::size_t joint, std::size_t row) const;

 private:
  struct Row {
    ExtremeBounds bounds;
    bool loaded = false;
    double latest = 0;
  };
  std::vector<Row> rows_;
};

}  // namespace unlatch::hil
