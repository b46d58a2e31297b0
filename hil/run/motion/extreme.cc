#include "hil/run/motion/extreme.h"

#include <algorithm>

namespace unlatch::hil {

void Least::search(double from, double to, const TimeFunction& function) {
  constexpr double kGolden = 0.6180339887498949;
  constexpr double kInstants = 4;  // roundings of a time: instants nearer to each other are not distinguished
  const double rounding = std::numeric_limits<double>::epsilon() * std::max(std::abs(from), std::abs(to));
  const double stop = std::max(1e-8 * (to - from), kInstants * rounding);
  double a = from, b = to, x = b - kGolden * (b - a), y = a + kGolden * (b - a);
  double at_x = function(x), at_y = function(y);
  while (b - a > stop) {
    if (at_x <= at_y) {
      b = y;
      y = x;
      at_y = at_x;
      x = b - kGolden * (b - a);
      at_x = function(x);
    } else {
      a = x;
      x = y;
      at_x = at_y;
      y = a + kGolden * (b - a);
      at_y = function(y);
    }
  }
  take(at_x <= at_y ? x : y, std::min(at_x, at_y));
}

void Least::look_into(double from, double at_from, double to, double at_to, double resolution,
                      const TimeFunction& function) {
  const double step = kNear * (to - from);
  if (!(step > 0)) return;
  // The lower end first: there it is the likelier one that does not descend, and the other need not be asked.
  const auto descends_at_from = [&] { return function(from + step) < at_from - resolution; };
  const auto descends_at_to = [&] { return function(to - step) < at_to - resolution; };
  if (at_to < at_from ? descends_at_to() && descends_at_from() : descends_at_from() && descends_at_to())
    search(from, to, function);
}

void Smallest::add(double time, double value) {
  least_.take(time, value);
  count_ = 0;
}

void Smallest::add(double from, double at_from, double to, double at_to, bool begins, const TimeFunction& function) {
  if (begins || count_ == 0) {
    count_ = 1;
    times_[0] = from;
    values_[0] = at_from;
    least_.take(from, at_from);
  }
  if (count_ == 3) {
    std::copy(times_ + 1, times_ + 3, times_);
    std::copy(values_ + 1, values_ + 3, values_);
    count_ = 2;
  }
  times_[count_] = to;
  values_[count_] = at_to;
  ++count_;
  least_.take(to, at_to);
  if (count_ == 2) least_.look_into(from, at_from, to, at_to, resolution_, function);
  if (count_ == 3) least_.look_about(times_, values_, resolution_, function);
}

void Smallest::finish(const TimeFunction& function) {
  if (count_ >= 2)
    least_.look_into(times_[count_ - 2], values_[count_ - 2], times_[count_ - 1], values_[count_ - 1], resolution_,
                     function);
}

}  // namespace unlatch::hil
