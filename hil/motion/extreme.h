// The smallest value of a function of time that is known at knots, located inside the steps.
#pragma once

#include <functional>
#include <limits>

namespace unlatch::hil {

// Between knots the function is smooth but where a piece begins. A minimum lies where a knot is below its neighbours,
// or within the first or the last interval of a smooth run of knots; there the function itself is searched by golden
// section (J. Kiefer, 1953), to 1e-8 of the interval or to the rounding of times.
class Smallest {
 public:
  using Function = std::function<double(double time)>;

  // `resolution`: dips that are shallower are noise of the function, and not searched.
  explicit Smallest(double resolution = 0) : resolution_(resolution) {}

  // The next interval: values at its ends; `begins`: it does not continue the interval before smoothly (then call
  // finish() first). `function` gives values within this interval and, unless it begins, the one before.
  void add(double from, double at_from, double to, double at_to, bool begins, const Function& function);
  // A single value.
  void add(double time, double value);
  // Looks into the last interval.
  void finish(const Function& function);

  [[nodiscard]] bool has_value() const { return value_ < std::numeric_limits<double>::infinity(); }
  [[nodiscard]] double get_value() const { return value_; }
  [[nodiscard]] double get_time() const { return time_; }

 private:
  void take(double time, double value);
  void search(double from, double to, const Function& function);
  void search_edge(double from, double at_from, double to, double at_to, const Function& function);

  double resolution_;
  double value_ = std::numeric_limits<double>::infinity(), time_ = 0;
  double times_[3] = {}, values_[3] = {};  // of the latest knots of this run
  int count_ = 0;
};

}  // namespace unlatch::hil
