#include "hil/motion/extreme.h"

#include <algorithm>
#include <cmath>

namespace unlatch::hil {

void Smallest::take(double time, double value) {
  if (!(value < value_)) return;
  value_ = value;
  time_ = time;
}

void Smallest::add(double time, double value) {
  take(time, value);
  count_ = 0;
}

void Smallest::search(double from, double to, const Function& function) {
  constexpr double kGolden = 0.6180339887498949;
  constexpr double kInstants = 4;  // roundings of a time: nothing between them can be told apart
  const double rounding = std::numeric_limits<double>::epsilon() * std::max(std::abs(from), std::abs(to));
  const double stop = std::max(1e-8 * (to - from), kInstants * rounding);
  double a = from, b = to, x = b - kGolden * (b - a), y = a + kGolden * (b - a);
  double at_x = function(x), at_y = function(y);
  while (b - a > stop) {
    if (at_x <= at_y) {
      b = y, y = x, at_y = at_x;
      x = b - kGolden * (b - a), at_x = function(x);
    } else {
      a = x, x = y, at_x = at_y;
      y = a + kGolden * (b - a), at_y = function(y);
    }
  }
  take(at_x <= at_y ? x : y, std::min(at_x, at_y));
}

// Within an interval that has a neighbour on one side at most: both ends must descend into it.
void Smallest::search_edge(double from, double at_from, double to, double at_to, const Function& function) {
  constexpr double kNear = 1e-3;  // of the interval
  const double step = kNear * (to - from);
  if (!(step > 0) || !(function(from + step) < at_from - resolution_) || !(function(to - step) < at_to - resolution_))
    return;
  search(from, to, function);
}

void Smallest::add(double from, double at_from, double to, double at_to, bool begins, const Function& function) {
  if (begins || count_ == 0) {
    count_ = 1;
    times_[0] = from, values_[0] = at_from;
    take(from, at_from);
  }
  if (count_ == 3) {
    std::copy(times_ + 1, times_ + 3, times_);
    std::copy(values_ + 1, values_ + 3, values_);
    count_ = 2;
  }
  times_[count_] = to, values_[count_] = at_to;
  ++count_;
  take(to, at_to);
  if (count_ == 2) search_edge(from, at_from, to, at_to, function);
  if (count_ < 3) return;
  const double left = values_[0] - values_[1], right = values_[2] - values_[1];
  // The vertex of a parabola through the three is no deeper below the middle one than an eighth of this sum; twice
  // that.
  constexpr double kRounding = 1e-13;
  const double dip = 0.25 * (left + right);
  if (left >= 0 && right >= 0 && dip > std::max(resolution_, kRounding * std::abs(values_[1])) &&
      values_[1] - dip < value_)
    search(times_[0], times_[2], function);
}

void Smallest::finish(const Function& function) {
  if (count_ >= 2)
    search_edge(times_[count_ - 2], values_[count_ - 2], times_[count_ - 1], values_[count_ - 1], function);
}

}  // namespace unlatch::hil
