#include "hil/study/sampling/distribution.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hil/scenario/base/normal.h"
#include "unlatch/elementary.h"

namespace unlatch::hil {
namespace {

double calc_triangular(double a, double b, double c, double p) {
  const double rise = (c - a) / (b - a);
  if (p < rise) return a + std::sqrt(p * (b - a) * (c - a));
  return b - std::sqrt((1 - p) * (b - a) * (b - c));
}

// Linear interpolation of order statistics: the k-th of n sorted values (from 0) has the probability k / (n − 1).
double interpolate(const std::vector<double>& sorted, double p) {
  const double at = p * static_cast<double>(sorted.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(at), sorted.size() - 1);
  if (k + 1 == sorted.size()) return sorted[k];
  return sorted[k] + (at - static_cast<double>(k)) * (sorted[k + 1] - sorted[k]);
}

}  // namespace

double Distribution::calc_quantile(double p) const {
  p = low + p * (high - low);
  switch (kind) {
    case Kind::kUniform:
      return a + p * (b - a);
    case Kind::kNormal:
      return b > 0 ? a + b * calc_normal_quantile(p) : a;
    case Kind::kLognormal:
      return elementary::exp(b > 0 ? a + b * calc_normal_quantile(p) : a);
    case Kind::kTriangular:
      return calc_triangular(a, b, c, p);
    case Kind::kDiscrete: {
      const auto at = std::upper_bound(cumulative.begin(), cumulative.end() - 1, p);
      return values[static_cast<std::size_t>(at - cumulative.begin())];
    }
    case Kind::kEmpirical:
      return interpolate(values, p);
    case Kind::kCone: {  // 1 − cos is uniform; 2 sin²(angle/2)
      const double sine = elementary::sin(0.5 * b), half = std::sqrt(p) * sine;
      return 2 * elementary::atan2(half, std::sqrt(1 - half * half));
    }
    case Kind::kNormalCone:
      return a * std::sqrt(-2 * calc_log(1 - p));
  }
  return 0;
}

double Distribution::calc_cdf(double x) const {
  if (kind == Kind::kLognormal) return x > 0 ? calc_normal_cdf((calc_log(x) - a) / b) : 0;
  return calc_normal_cdf((x - a) / b);
}

void Distribution::cut(double least, double most) {
  low = std::max(low, calc_cdf(least));
  high = std::min(high, calc_cdf(most));
}

std::array<double, 3> tilt(const std::array<double, 3>& direction, double angle, double turn) {
  const auto& d = direction;
  const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  const std::array<double, 3> u{d[0] / length, d[1] / length, d[2] / length};
  // Perpendicular vector: from the axis along which the direction is smallest, the first of equal ones.
  std::size_t k = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (std::abs(u[i]) < std::abs(u[k])) k = i;
  std::array<double, 3> v{-u[k] * u[0], -u[k] * u[1], -u[k] * u[2]};
  v[k] += 1;
  const double across = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  for (double& x : v) x /= across;
  const std::array<double, 3> w{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const double cosine = elementary::cos(angle), sine = elementary::sin(angle);
  const double about = 2 * std::numbers::pi * turn, c = elementary::cos(about), s = elementary::sin(about);
  std::array<double, 3> tilted{};
  for (std::size_t i = 0; i < 3; ++i) tilted[i] = cosine * u[i] + sine * (c * v[i] + s * w[i]);
  return tilted;
}

}  // namespace unlatch::hil
