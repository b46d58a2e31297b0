// LawExtremes: the smallest and the greatest value of a quantity that is a law, over a run, and how far they may be
// wrong.
//
// Between knots the law is that of what it reads (LawCurve). Where an extreme may be beyond those that are known by
// more than it matters, the step is taken again (FinerSteps), and the extreme is that of the shorter steps.
#pragma once

#include <optional>
#include <span>

#include "hil/run/extremes/finer_steps.h"
#include "hil/run/extremes/law_curve.h"

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

  [[nodiscard]] const LawCurve::Found& get_low() const { return low_; }
  [[nodiscard]] const LawCurve::Found& get_high() const { return high_; }

 private:
  enum class End { kGoesOn, kEnds };
  void add_knot(const MotionKnot& knot, std::span<const double> commands, bool begins);
  void search(End end, const FinerSource& finer);
  void refine(LawCurve::Span span, LawCurve::Extreme extreme, const FinerSource& finer, const Smallest& known,
              LawCurve::Found& found);

  const Model& model_;
  const Plan& plan_;
  int quantity_;
  Sides sides_;
  LawCurve curve_;
  std::optional<LawCurve> finer_curve_;  // of the knots of finer steps, once there are some
  LawCurve::Found low_, high_;
};

}  // namespace unlatch::hil
