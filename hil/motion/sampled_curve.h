// A quantity that is known at knots alone: between them the polynomial through the latest five of a smooth run.
#pragma once

namespace unlatch::hil {

class SampledCurve {
 public:
  // Knots in the order of time; `begins`: what came before does not go on smoothly.
  void add(double time, double value, bool begins);
  // At a time near the latest knots.
  [[nodiscard]] double calc(double time) const;

 private:
  static constexpr int kPoints = 5;
  double times_[kPoints] = {}, values_[kPoints] = {};
  int count_ = 0;
};

}  // namespace unlatch::hil
