// Smallest value of a function of time that is known at knots, located inside the steps.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace unlatch::hil {

// Reference to a function of time; the caller keeps the function alive.
class TimeFunction {
 public:
  template <class Function>
  // NOLINTNEXTLINE(google-explicit-constructor): implicit, so that a call can pass any function
  TimeFunction(const Function& function)
      : function_(&function),
        call_([](const void* of, double time) -> double { return (*static_cast<const Function*>(of))(time); }) {}
  TimeFunction(const TimeFunction&) = default;

  double operator()(double time) const { return call_(function_, time); }

 private:
  const void* function_;
  double (*call_)(const void*, double);
};

// Smallest value so far. The function is smooth between knots, except where a run of knots begins. A minimum lies where
// a knot is below its neighbours, or within the first or the last interval of a smooth run of knots; there the function
// itself is searched by golden section (J. Kiefer, 1953), to 1e-8 of the interval or to the rounding of times. Dips
// shallower than `resolution` are numerical noise, and not searched.
class Least {
 public:
  // look_into() sees by the function so near to both ends, relative to the interval, whether it descends there.
  static constexpr double kNear = 1e-3;

  void take(double time, double value) {
    if (!(value < value_)) return;
    value_ = value;
    time_ = time;
  }
  // Searches about three successive knots where the function may be smaller near the middle one.
  void look_about(const double times[3], const double values[3], double resolution, const TimeFunction& function) {
    const double left = values[0] - values[1], right = values[2] - values[1];
    if (!(left >= 0 && right >= 0)) return;
    // The vertex of a parabola through the three is no deeper below the middle one than an eighth of this sum; twice
    // that.
    constexpr double kRounding = 1e-13;
    const double dip = 0.25 * (left + right);
    if (dip > std::max(resolution, kRounding * std::abs(values[1])) && values[1] - dip < value_)
      search(times[0], times[2], function);
  }
  // Searches an interval that has a neighbour on one side at most, if both ends descend into it.
  void look_into(double from, double at_from, double to, double at_to, double resolution, const TimeFunction& function);
  // Searches between two times.
  void search(double from, double to, const TimeFunction& function);

  [[nodiscard]] bool has_value() const { return value_ < std::numeric_limits<double>::infinity(); }
  [[nodiscard]] double get_value() const { return value_; }
  [[nodiscard]] double get_time() const { return time_; }

 private:
  double value_ = std::numeric_limits<double>::infinity(), time_ = 0;
};

// Smallest value of one function, with the knots that the search needs.
class Smallest {
 public:
  explicit Smallest(double resolution = 0) : resolution_(resolution) {}

  // Adds the next interval: values at its ends; `begins`: it does not continue the interval before smoothly (then call
  // finish() first). `function` gives values within this interval and, unless it begins, the one before.
  void add(double from, double at_from, double to, double at_to, bool begins, const TimeFunction& function);
  // Adds a single value, behind which the knots begin anew.
  void add(double time, double value);
  // Adds a value between knots.
  void take(double time, double value) { least_.take(time, value); }
  // Searches between two times, where the function has one minimum.
  void search(double from, double to, const TimeFunction& function) { least_.search(from, to, function); }
  // Searches the last interval.
  void finish(const TimeFunction& function);

  [[nodiscard]] bool has_value() const { return least_.has_value(); }
  [[nodiscard]] double get_value() const { return least_.get_value(); }
  [[nodiscard]] double get_time() const { return least_.get_time(); }
  // Value at the end of the interval that was added last.
  [[nodiscard]] double get_latest() const { return values_[count_ - 1]; }

 private:
  double resolution_;
  Least least_;
  double times_[3] = {}, values_[3] = {};  // latest knots of this run
  int count_ = 0;
};

}  // namespace unlatch::hil
