// LawExtremes: the smallest and the greatest value of a quantity that is a law, over a run, and how far they may be
// wrong.
//
// Between knots the law is that of what it reads (LawCurve). An extreme between knots that is more than a thousandth
// beyond those that are known depends on how well the polynomials of what the law reads are: there the step is taken
// again (FinerSteps), and where the knots do not tell the law to a thousandth, and it may have its extreme.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>

#include "hil/run/extremes/finer_steps.h"
#include "hil/run/extremes/law_curve.h"
#include "hil/run/motion/extreme.h"
#include "hil/run/motion/sampled_curve.h"

namespace unlatch::hil {

class LawExtremes {
 public:
  // What is searched for.
  struct Sides {
    bool low, high;
  };
  // Of this quantity of the model, which is a law. Keeps references to both.
  LawExtremes(const Model& model, const Plan& plan, int quantity, Sides sides);

  // Adds the piece between two knots, with its commands; `begins`: it does not continue the piece before smoothly (then
  // call finish() first).
  void add(const MotionKnot& from, const MotionKnot& to, std::span<const double> commands, bool begins,
           const FinerSource& finer);
  // Adds a single value that the quantity has.
  void take(double time, double value);
  // Searches the latest interval, behind which no knot will come.
  void finish(const FinerSource& finer) { search(End::kEnds, finer); }

  // One of the two: the smallest value, or of the greatest all is the negative's.
  struct Side {
    Smallest found;
    double error = 0;                                             // how far it may be wrong
    double unsearched = std::numeric_limits<double>::infinity();  // as ExtremeBounds::Bound::unsearched
  };
  [[nodiscard]] const Side& get_low() const { return low_; }
  [[nodiscard]] const Side& get_high() const { return high_; }

 private:
  enum class End { kGoesOn, kEnds };
  void add_knot(const MotionKnot& knot, std::span<const double> commands, bool begins);
  void search(End end, const FinerSource& finer);
  bool refine(LawCurve::Span span, bool is_low, const FinerSource& finer, Smallest& found);

  const Model& model_;
  const Plan& plan_;
  int quantity_;
  Sides sides_;
  LawCurve curve_;
  std::optional<LawCurve> finer_curve_;  // of the knots of finer steps, once there are some
  Side low_, high_;
  // Of the law, at the latest knots, the last one last.
  std::array<double, kCurvePoints> times_{}, values_{};
};

}  // namespace unlatch::hil
