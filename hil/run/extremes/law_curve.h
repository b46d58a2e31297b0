// LawCurve: a quantity that is a law, between knots, from the quantities that the law reads.
//
// A law may have corners where what it reads has none: abs(x), max(x, y), a table. So it is not interpolated itself:
// what is smooth of what it reads (SmoothPart: of the size of a vector its square) follows the polynomial through the
// latest five knots (ValueStencil), and the law is evaluated there.
// Its smallest value is searched by bisection where the bounds of the law (LawCourses) admit a smaller one than is
// known, down to 1/64 of the interval, and from there by golden section.
//
// How far it may be wrong is what it changes by if each of what it reads is off by the uncertainty of its polynomial,
// one after the other, in the direction that counts; what dips within the interval, so that no polynomial shows it, or
// has a corner there, as the distance to the nearer of two shapes, may be as far off as the secants beside the interval
// allow. Of a polynomial through two knots nothing is
// known but how the quantity has changed elsewhere (UsualChange).
//
// Cost: three evaluations of the law with its bounds for each interval; some hundred where they admit a smaller value,
// and some dozen more where it may be wrong.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "hil/run/extremes/smooth_part.h"
#include "hil/run/extremes/straight_quantity.h"
#include "hil/run/extremes/usual_change.h"
#include "hil/run/extremes/value_stencil.h"
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
  // A smallest value, or of a greatest one all is the negative's.
  struct Found {
    Smallest value;
    // The smallest value is between these.
    double least = std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
    // As ExtremeBounds::Bound::unsearched.
    double unsearched = std::numeric_limits<double>::infinity();
    bool is_unknown = false;  // it is between two knots before which nothing was seen of what the law reads
    void take(double time, double own) {
      value.take(time, own);
      most = std::min(most, own);
    }
  };
  enum class Extreme { kLow, kHigh };
  // Takes the smallest value in the interval before the latest one, or the negative of the greatest: the knot behind
  // the interval makes its polynomial better. Nothing where a curve begins.
  void search(Extreme extreme, Found& found);
  // Likewise between the latest two knots, where the curve ends.
  void finish(Extreme extreme, Found& found);
  // How what it reads has changed so far, along another curve of this law. Then this curve is of steps that were taken
  // again, of which no finer ones are asked for.
  void follow(const LawCurve& other);
  void learn_from(const LawCurve& other);
  // Where search() and finish() look: two knots' times, s.
  struct Span {
    double from = 0, to = 0;
    [[nodiscard]] double get_middle() const { return 0.5 * (from + to); }
  };
  [[nodiscard]] Span get_span_before() const { return {before_.from, before_.to}; }
  [[nodiscard]] Span get_latest_span() const { return {latest_.from, latest_.to}; }
  // What a value matters by: this part of it, or of what is left of the largest one where it is small.
  [[nodiscard]] double calc_room(double value) const { return kFine * std::max(std::abs(value), kFloor * size_); }
  // Knots of this smooth curve, as far as they are counted: kCurvePoints are so many or more.
  [[nodiscard]] int count_knots() const { return knots_; }

 private:
  static constexpr double kFine = 3e-4, kFloor = 1e-3;
  struct Interval {
    double from = 0, to = 0;  // s
    std::vector<double> commands;
  };
  void search(const Interval& interval, std::size_t number, double sign, Found& found);
  void look(const Interval& interval, double from, double to, double sign, int depth, Smallest& found);
  void doubt(const Interval& interval, double sign, Found& found);
  struct Wide {
    Course course;
    bool is_off;
  };
  [[nodiscard]] Wide calc_wide(const Interval& interval);
  void update(const Interval& interval, double from, double to);
  [[nodiscard]] double calc(const Interval& interval, double time);

  struct Read {
    int quantity;
    bool is_angle;    // goes on at the other end of its range, of one turn; the curve counts turns
    SmoothPart part;  // that the curve, its stencil, what is usual and the bulge are of
    const QuantityTraits* traits = nullptr;
    SampledCurve curve{};
    UsualChange usual{};
    double latest = 0;                      // the value itself
    double turned = 0;                      // rad, of the curve beyond the range
    std::optional<double> middle{};         // of the range, rad, where it has come to its ends
    std::optional<ValueStencil> stencil{};  // of the interval that is searched
    // Where a stencil's differences do not fall, as at a corner of its own: the lines through the two knots before the
    // interval and through the two behind it, which a convex dip does not go below, nor a concave bulge above.
    struct Secants {
      double from, at_from, before, to, at_to, behind;
      [[nodiscard]] bool are_below() const { return before < behind; }
      // Where they meet, s.
      [[nodiscard]] double calc_meeting() const {
        return from + (at_to - at_from - behind * (to - from)) / (before - behind);
      }
      [[nodiscard]] double calc(double time) const {
        const double first = at_from + before * (time - from), last = at_to + behind * (time - to);
        return are_below() ? std::max(first, last) : std::min(first, last);
      }
    };
    std::optional<Secants> secants{};
    void draw_secants(std::size_t number);  // about the interval that begins at this knot
    double bulge = 0;                       // between two knots alone, how far it may be from the line between them
    // Whether it is a straight line between its knots.
    [[nodiscard]] bool is_exact() const { return is_straight(*traits) || traits->holds; }
    // Between these two times, if its smooth part is off by so many times its uncertainty.
    [[nodiscard]] Course calc_course(double from, double to, double off) const;
    // What is smooth of it, there.
    [[nodiscard]] Course calc_smooth_course(double from, double to, double off) const;
    [[nodiscard]] double calc_uncertainty(double time) const;
  };
  int law_;
  std::vector<int> behind_;
  std::vector<Read> read_;
  LawCourses courses_;
  std::vector<Course> quantities_;  // the model's
  Interval latest_, before_;
  int knots_ = 0;         // of this smooth curve, at most kCurvePoints
  bool follows_ = false;  // another curve, of longer steps
  double size_ = 0;       // the largest value of the law so far
  int left_ = 0;          // evaluations in this interval
};

}  // namespace unlatch::hil
