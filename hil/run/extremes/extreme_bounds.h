// The smallest and the greatest value of a quantity that is known at knots alone, and how far they may be wrong.
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
// At knots u is 0. Where u matters, and between two knots behind which nothing goes on smoothly, values between the two
// are asked for (FinerValues), and the extremes are those of these. If there are none, u stays; of two knots alone it
// is not known.
//
// Cost: some comparisons for each knot; the differences of six knots, where these come near an extreme; some thousand
// operations where the polynomial, as far as its terms reach from the chord between the interval's ends, may have one.
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
    // What it may be between two knots behind which nothing goes on smoothly, if it changes there once more by as much
    // as from one to the other.
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
  static constexpr std::size_t kPoints = 6;

  // The polynomial through the knots of a run, and its differences.
  struct Stencil;
  // One of the two extremes: the smallest value, or the greatest, of which all is the negative's.
  struct Side {
    double sign;
    Bound* bound;
  };
  void search(std::size_t interval, FinerValues* finer);
  void search(const Stencil& stencil, FinerValues* finer, Side side) const;
  void search_pair(FinerValues* finer, Side side) const;
  [[nodiscard]] Bound look(const Stencil& stencil, Side side) const;
  [[nodiscard]] bool is_known(const Bound& bound) const;
  bool refine(double from, double to, FinerValues* finer, Side side) const;
  [[nodiscard]] bool leaves_out(std::size_t interval) const;

  double times_[kPoints] = {}, values_[kPoints] = {};
  std::size_t count_ = 0;     // latest knots of this run
  std::size_t searched_ = 0;  // intervals between them, from the first on
  double size_ = 0;           // the largest value so far
  double from_ = -std::numeric_limits<double>::infinity(), to_ = std::numeric_limits<double>::infinity();
  Bound low_, high_;
};

}  // namespace unlatch::hil
