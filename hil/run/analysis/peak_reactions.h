// Peaks of the joints' reactions over a run. Multipliers are known at the ends of sub-steps and at events: a peak
// between them is that of the polynomial through five of them within a smooth run.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hil/run/motion/extreme.h"
#include "hil/run/motion/sampled_curve.h"
#include "unlatch/motion.h"
#include "unlatch/workspace.h"

namespace unlatch::hil {

struct PeakReaction {
  double value = 0, time = 0;  // largest value so far, with its sign; N or N m, s
};

class PeakReactions {
 public:
  explicit PeakReactions(std::size_t joints);

  // Adds the reactions of the initial state.
  void begin(double time, const MultiplierView& multipliers);
  // Adds a piece of motion between two knots; `smooth`: it continues the piece before.
  void add(const MotionKnot& from, const MotionKnot& to, bool smooth);

  // Peak of one row of a joint.
  [[nodiscard]] PeakReaction get(std::size_t joint, std::size_t row) const;

 private:
  static constexpr std::int64_t kUnloaded = -1;
  struct Row {
    Least low, high;                 // `high`: minimum of the negative
    std::int64_t first = kUnloaded;  // number of the knot at which the smooth run of this row began
  };
  // The latest knots, common to all rows.
  struct Knots {
    double time = 0;
    std::vector<double> multipliers;
  };
  Knots& get_knot(std::int64_t number) { return knots_[static_cast<std::size_t>(number % kCurvePoints)]; }
  [[nodiscard]] const Knots& get_knot(std::int64_t number) const {
    return knots_[static_cast<std::size_t>(number % kCurvePoints)];
  }
  void push(const MotionKnot& knot);
  [[nodiscard]] double calc(std::size_t i, std::int64_t first, double time) const;
  // Searches the latest interval of row `i`, which has a neighbour on one side at most.
  void look_into_latest(std::size_t i, Row& row) const;

  std::vector<Row> rows_;
  std::array<Knots, kCurvePoints> knots_;
  std::int64_t count_ = 0;  // number of knots so far
};

}  // namespace unlatch::hil
