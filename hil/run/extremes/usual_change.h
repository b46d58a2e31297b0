// How fast a quantity has changed so far, and how much its rate has: what may be expected of it between two knots
// behind which nothing goes on smoothly.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace unlatch::hil {

class UsualChange {
 public:
  // Adds the latest knot of a smooth run of two or more.
  void add(std::span<const double> times, std::span<const double> values) {
    const std::size_t last = times.size() - 1;
    const double h = times[last] - times[last - 1], slope = (values[last] - values[last - 1]) / h;
    if (kShort * h > longest_) *this = {};  // all before were short beside this one
    longest_ = std::max(longest_, h);
    if (!(h >= kShort * longest_)) return;
    steepest_ = std::max(steepest_, std::abs(slope));
    ++intervals_;
    if (last < 2) return;
    const double before = times[last - 1] - times[last - 2];
    if (!(before >= kShort * longest_)) return;
    const double other = (values[last - 1] - values[last - 2]) / before;
    bend_ = std::max(bend_, std::abs(2 * (slope - other) / (h + before)));
    bends_ = true;
  }
  // False where no other interval has been seen but the present one.
  [[nodiscard]] bool is_known() const { return intervals_ > 1; }
  // What it may be beyond both of its values at knots that are so far apart, s: as much as it has changed in such a
  // time.
  [[nodiscard]] double calc_change(double from_value, double to_value, double h) const {
    return std::max(std::abs(to_value - from_value), steepest_ * h);
  }
  // Likewise how far it may be from the straight line between the two, as its rate has changed so far: twice what a
  // parabola is.
  [[nodiscard]] double calc_bulge(double from_value, double to_value, double h) const {
    return bends_ ? bend_ * h * h / 4 : calc_change(from_value, to_value, h);
  }

 private:
  static constexpr double kShort = 0.1;  // of the longest interval: shorter ones have rounding
  double longest_ = 0, steepest_ = 0, bend_ = 0;
  int intervals_ = 0;
  bool bends_ = false;
};

}  // namespace unlatch::hil
