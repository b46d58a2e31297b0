// A quantity that is known at knots alone: between them the polynomial through the latest five of a smooth run.
#pragma once

#include <cstddef>
#include <span>

namespace unlatch::hil {

inline constexpr int kCurvePoints = 5;

// Polynomial through these points, at a time near them, by Neville's scheme. At most kCurvePoints.
double interpolate(std::span<const double> times, std::span<const double> values, double time);

class SampledCurve {
 public:
  // Adds a knot, in the order of time; `begins`: it does not continue the curve before smoothly.
  void add(double time, double value, bool begins);
  // Forgets the latest knot.
  void drop_latest() { --count_; }
  // Value at a time near the latest knots.
  [[nodiscard]] double calc(double time) const { return interpolate(get_times(), get_values(), time); }
  // The latest knots of this smooth run, at most kCurvePoints.
  [[nodiscard]] std::span<const double> get_times() const { return {times_, static_cast<std::size_t>(count_)}; }
  [[nodiscard]] std::span<const double> get_values() const { return {values_, static_cast<std::size_t>(count_)}; }

 private:
  double times_[kCurvePoints] = {}, values_[kCurvePoints] = {};
  int count_ = 0;
};

}  // namespace unlatch::hil
