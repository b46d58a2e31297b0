// Bounds of the smallest and the greatest value of a quantity that is known at knots alone: how far the extremes of the
// polynomials through five knots (SampledCurve) may be wrong.
//
// Between two knots the quantity is taken to be the polynomial through six of them, as nearly three on each side as the
// smooth run of knots has, give or take u, the greatest of three:
// - the last term of Newton's form of the polynomial, the highest order's;
// - r times the one before: where the quantity is symmetric about the middle, every other term vanishes. r, at most 1,
//   is by what factor differences fall from one order to the next, the root of that over two orders; of a sine it is
//   about the angle of a step;
// - r⁴ times the distance to what goes on from one side, the nearer of the parabolas through three knots before and
//   three behind (beside the ends of a run, times the term of the second order). Where differences do not fall, at a
//   corner or a dip shorter than the steps, nothing better is known.
// At knots u is 0.
//
// Cost: some comparisons for each knot; some hundred operations where an interval may have an extreme.
#pragma once

#include <cstddef>
#include <limits>
#include <span>

namespace unlatch::hil {

// What of a quantity is smooth, and goes with it: itself; the square of a vector's size, which has a corner at zero; of
// an angle between 0 and half a turn, which has one at either end, 1 - cos of it.
enum class SmoothPart { kItself, kSquare, kOfAngle };
double to_smooth(SmoothPart part, double value);
double from_smooth(SmoothPart part, double smooth);

class ExtremeBounds {
 public:
  // Bounds of an extreme, and what they were found from.
  struct Bound {
    // The smallest value is between these; of the greatest both are its negative's. Infinite before the first knot.
    double least = std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
    double time = 0;     // s, of `least`
    double spacing = 0;  // s, of the knots there
    double ratio = 0;    // r there
  };

  // Adds a knot, in the order of time; `begins`: it does not continue the curve before smoothly.
  void add(double time, double value, bool begins);
  // Adds a single value that the quantity has.
  void take(double value);
  // Searches the latest intervals, behind which no knot will come. Before a knot that begins, add() does.
  void finish();

  [[nodiscard]] const Bound& get_low() const { return low_; }
  [[nodiscard]] const Bound& get_high() const { return high_; }  // of the negative

 private:
  static constexpr std::size_t kPoints = 6;

  // The polynomial through the knots of a run, and its differences.
  struct Stencil;
  void search(std::size_t interval);
  void look(const Stencil& stencil, double sign, Bound& bound) const;

  double times_[kPoints] = {}, values_[kPoints] = {};
  std::size_t count_ = 0;     // latest knots of this run
  std::size_t searched_ = 0;  // intervals between them, from the first on
  Bound low_, high_;
};

}  // namespace unlatch::hil
