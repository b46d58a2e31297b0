// LawCurve: a quantity that is a law, between knots, from the quantities that the law reads.
//
// A law may have corners where what it reads has none: abs(x), max(x, y), a table. So it is not interpolated itself:
// what it reads follows the polynomial through the latest five knots (SampledCurve), and the law is evaluated there.
// Its smallest value is searched by bisection where the bounds of the law (LawCourses) admit a smaller one than is
// known, down to 1/64 of the interval, and from there by golden section.
//
// Cost: three evaluations of the law with its bounds for each interval; some hundred where they admit a smaller value.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hil/run/motion/extreme.h"
#include "hil/run/motion/sampled_curve.h"
#include "unlatch/model/law_courses.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {

class LawCurve {
 public:
  // Of this law of the model. Keeps references to both.
  LawCurve(const Model& model, const Plan& plan, int law);

  // True if the curve cannot go on smoothly through the latest knot, which is at the instant of an event: the
  // quantities there after the event, and those of the next knot. Then call finish(), and add the latest knot as it is
  // now.
  [[nodiscard]] bool begins_anew(std::span<const double> now, double next_time, std::span<const double> next) const;
  // Adds a knot, in the order of time: the model's quantities there, and the commands since the knot before; `begins`:
  // it does not continue the curve before smoothly.
  void add(double time, std::span<const double> quantities, std::span<const double> commands, bool begins);
  // Takes the smallest value in the interval before the latest one into `low`, and that of the negative into `high`:
  // the knot behind the interval makes its polynomial better. Nothing where a curve begins.
  void search(Smallest* low, Smallest* high);
  // Likewise between the latest two knots, where the curve ends.
  void finish(Smallest* low, Smallest* high);
  // Where search() and finish() look: two knots' times, s.
  struct Span {
    double from = 0, to = 0;
    [[nodiscard]] double get_middle() const { return 0.5 * (from + to); }
  };
  [[nodiscard]] Span get_span_before() const { return {before_.from, before_.to}; }
  [[nodiscard]] Span get_latest_span() const { return {latest_.from, latest_.to}; }
  // Knots of this smooth curve, as far as they are counted: kCurvePoints are so many or more.
  [[nodiscard]] int count_knots() const { return knots_; }

 private:
  struct Interval {
    double from = 0, to = 0;  // s
    std::vector<double> commands;
  };
  void search(const Interval& interval, double sign, Smallest& found);
  void look(const Interval& interval, double from, double to, double sign, int depth, Smallest& found);
  void update(const Interval& interval, double from, double to);
  [[nodiscard]] double calc(const Interval& interval, double time);

  struct Read {
    int quantity;
    SampledCurve curve;
    double latest = 0;
    bool is_angle;  // goes on at the other end of its range, of one turn; the curve counts turns
    const QuantityTraits* traits = nullptr;
    double turned = 0;             // rad, of the curve beyond the range
    std::optional<double> middle;  // of the range, rad, where it has come to its ends
    [[nodiscard]] Course calc_course(double from, double to) const;
  };
  int law_;
  std::vector<int> behind_;
  std::vector<Read> read_;
  LawCourses courses_;
  std::vector<Course> quantities_;  // the model's
  Interval latest_, before_;
  int knots_ = 0;  // of this smooth curve, at most kCurvePoints
  int left_ = 0;   // evaluations in this interval
};

}  // namespace unlatch::hil
