// The polynomial through the knots of a smooth run about one interval between two of them, and by how much it may be
// off.
//
// That is u, the greatest of three:
// - the last term of Newton's form of the polynomial, the highest order's (of three knots r times it);
// - r times the one before: where the quantity is symmetric about the middle, every other term vanishes. r, at most 1,
//   is by what factor differences fall from one order to the next, the root of that over two orders; of a sine it is
//   about the angle of a step;
// - r⁴ times the distance to what goes on from one side, the nearer of the parabolas through three knots before and
//   three behind (beside the ends of a run, times the term of the second order). Where differences do not fall, at a
//   corner or a dip shorter than the steps, nothing better is known.
// From fewer than six knots r is badly known. Of these u is at least the term of the next order, as if its difference
// were as large as the greatest of the two orders before. At knots u is 0. Of two knots alone it is not known, and 0
// here.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace unlatch::hil {

// The polynomial alone.
class ValueTerms {
 public:
  static constexpr std::size_t kMost = 6;
  static constexpr double kOneKnot = 1e-6;  // of an interval: of knots that are nearer to each other one counts

  // Of two to kMost knots of rising times, and of the interval behind the knot of this number.
  ValueTerms(std::span<const double> times, std::span<const double> values, std::size_t interval);
  // How far the polynomial, give or take u, is at most from the chord between the interval's ends: by its terms and its
  // parabolas, whatever r is, and beyond the rounding of ValueStencil::calc(). Of kMost knots alone. It costs a tenth
  // of looking for an extreme.
  [[nodiscard]] double calc_most_departure() const;

  [[nodiscard]] double get_from() const { return from_; }
  [[nodiscard]] double get_to() const { return to_; }
  [[nodiscard]] double get_at_from() const { return at_from_; }
  [[nodiscard]] double get_at_to() const { return at_to_; }
  [[nodiscard]] double get_spacing() const { return spacing_; }  // s, of the knots

 protected:
  // A parabola through three knots on one side of the interval, from the nearest outwards.
  struct Side {
    double nearest, next, terms[3];
    [[nodiscard]] double calc(double time) const {
      return terms[0] + (time - nearest) * (terms[1] + (time - next) * terms[2]);
    }
  };

  std::size_t count_;
  double from_, to_, at_from_, at_to_;
  double order_[kMost] = {}, terms_[kMost] = {};  // Newton's form, its knots taken from the interval outwards
  double spacing_ = 0;
  double differences_[kMost][kMost] = {};  // divided: of order k from knot i on
  std::optional<Side> before_, behind_;
};

// With u.
class ValueStencil : public ValueTerms {
 public:
  explicit ValueStencil(const ValueTerms& terms);
  ValueStencil(std::span<const double> times, std::span<const double> values, std::size_t interval)
      : ValueStencil(ValueTerms(times, values, interval)) {}
  // The polynomial at a time in the interval, and u.
  struct Value {
    double value, uncertainty;
  };
  [[nodiscard]] Value calc(double time) const;
  [[nodiscard]] double get_ratio() const { return ratio_; }  // r

 private:
  double ratio_ = 0, doubt_ = 0;
  double next_ = 0;  // of fewer than kMost knots: the next term's coefficient
};

}  // namespace unlatch::hil
