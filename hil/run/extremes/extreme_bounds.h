// The smallest and the greatest value of a quantity that is known at knots alone, and how far they may be wrong.
//
// Between two knots the quantity is taken to be the polynomial through six of them, as nearly three on each side as the
// smooth run of knots has, give or take its uncertainty u (ValueStencil). Where u matters, where a smooth run has few
// knots, and between two knots behind which nothing goes on smoothly, values between the two are asked for
// (FinerValues), and the extremes are those of these. If there are none, u stays; of two knots alone it is not known.
// Where even these do not tell it, as of the distance of two points that pass each other within one of the shorter
// steps, the quantity is taken to go on no farther than the secants before and behind meet.
//
// Cost: some comparisons for each knot; the differences of six knots, where these come near an extreme; some thousand
// operations where the polynomial, as far as its terms reach from the chord between the interval's ends, may have one.
#pragma once

#include <cstddef>
#include <limits>
#include <span>

#include "hil/run/extremes/usual_change.h"
#include "hil/run/extremes/value_stencil.h"

namespace unlatch::hil {

// A knot; `begins`: it does not continue the curve before smoothly.
struct ValueKnot {
  double time = 0, value = 0;
  bool begins = false;
};

// More knots of a quantity than a run has.
class FinerValues {
 public:
  FinerValues() = default;
  FinerValues(const FinerValues&) = delete;
  FinerValues& operator=(const FinerValues&) = delete;
  virtual ~FinerValues() = default;
  // Knots from before one time, or from it on, to after another, or up to it; none: not known.
  virtual std::span<const ValueKnot> list(double from, double to) = 0;
};

class ExtremeBounds {
 public:
  // An extreme, its bounds, and what they were found from.
  struct Bound {
    // The smallest value is between these; of the greatest both are its negative's. Infinite before the first knot.
    double least = std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
    double time = 0;     // s, of `least`
    double spacing = 0;  // s, of the knots there
    double ratio = 0;    // r there
    // The smallest value that was found, likewise, and its time, s.
    double value = std::numeric_limits<double>::infinity(), found = 0;
    // What it may be between two knots behind which nothing goes on smoothly, if it changes there as it has elsewhere.
    double unsearched = std::numeric_limits<double>::infinity();
  };

  // Adds a knot, in the order of time. `finer`: values between knots; null: there are none.
  void add(const ValueKnot& knot, FinerValues* finer = nullptr);
  // Adds a single value that the quantity has.
  void take(double time, double value);
  // Searches the latest intervals, behind which no knot will come. Before a knot that begins, add() does.
  void finish(FinerValues* finer = nullptr);

  [[nodiscard]] const Bound& get_low() const { return low_; }
  [[nodiscard]] const Bound& get_high() const { return high_; }  // of the negative

 private:
  static constexpr std::size_t kPoints = ValueStencil::kMost;

  // One of the two extremes: the smallest value, or the greatest, of which all is the negative's.
  struct Side {
    double sign;
    Bound* bound;
  };
  void take(const ValueKnot& knot);
  void search(std::size_t interval, FinerValues* finer);
  void search(const ValueStencil& stencil, FinerValues* finer, Side side) const;
  void search_pair(FinerValues* finer, Side side) const;
  [[nodiscard]] Bound look(const ValueStencil& stencil, Side side) const;
  [[nodiscard]] bool may_matter(double end, double change, Side side) const;
  [[nodiscard]] bool is_known(const Bound& bound) const;
  [[nodiscard]] double calc_least_by_secants(double from, Side side) const;
  bool refine(double from, double to, FinerValues* finer, Side side) const;
  [[nodiscard]] bool leaves_out(std::size_t interval) const;
  [[nodiscard]] bool is_here(double time) const { return time >= from_ && time <= to_; }

  double times_[kPoints] = {}, values_[kPoints] = {};
  std::size_t count_ = 0;     // latest knots of this run
  std::size_t searched_ = 0;  // intervals between them, from the first on
  double size_ = 0;           // the largest value so far
  bool is_within_ = false;    // of the knots of a step that was taken again: those between two times count
  double from_ = -std::numeric_limits<double>::infinity(), to_ = std::numeric_limits<double>::infinity();
  ValueKnot latest_;
  UsualChange usual_;
  Bound low_, high_;
};

}  // namespace unlatch::hil
