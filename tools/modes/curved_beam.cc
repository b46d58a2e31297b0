#include "tools/modes/curved_beam.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "hil/scenario/text/count.h"

namespace unlatch::tools {
namespace {

using Complex = std::complex<double>;
using Matrix3c = Eigen::Matrix3cd;
constexpr double kPi = std::numbers::pi;
constexpr int kRigidModes = 3;  // of the inextensional arc in its plane; the shallow model has none

// sinh(x)/x, also at 0.
Complex sinhc(Complex x) { return std::abs(x) < 1e-4 ? 1.0 + x * x / 6.0 : std::sinh(x) / x; }

// --- (3.4) ----------------------------------------------------------------------------------------------------------

// λ1², λ2² of (3.4), times R².
struct ShallowRoots {
  Complex hyperbolic, trigonometric;
};
ShallowRoots calc_shallow_roots(Complex lambda) {
  const Complex s = std::sqrt(0.25 + lambda);
  return {s - 0.5, s + 0.5};
}

// (3.4) over λ1 λ2, which is even in both and symmetric under their exchange, so entire in λ; and over 1/4 + λ, where
// the characteristic roots meet and it vanishes although there is no shape.
Complex calc_shallow_determinant(double angle, Complex lambda) {
  const ShallowRoots squares = calc_shallow_roots(lambda);
  const Complex l1 = std::sqrt(squares.hyperbolic), l2 = std::sqrt(squares.trigonometric), i(0, 1);
  const Complex value = 2.0 * (1.0 - std::cosh(l1 * angle) * std::cos(l2 * angle)) -
                        angle * angle * sinhc(l1 * angle) * sinhc(i * l2 * angle);
  return value / (0.25 + lambda) * std::exp(-angle * (std::abs(l1.real()) + std::abs(l2.imag())));
}

// From the end: λ1² cosh + λ2² cos, and the ratio of the second solution λ1 sinh + λ2 sin from the other end's moment.
std::vector<double> calc_shallow_shape(double angle, double lambda, int points) {
  const ShallowRoots squares = calc_shallow_roots(lambda);
  const double a = squares.hyperbolic.real(), b = squares.trigonometric.real(), l1 = std::sqrt(a), l2 = std::sqrt(b);
  const auto first = [&](double x) { return a * std::cosh(l1 * x) + b * std::cos(l2 * x); };
  const auto second = [&](double x) { return l1 * std::sinh(l1 * x) + l2 * std::sin(l2 * x); };
  // w'' + w of both at the end.
  const double first_moment = a * b * (std::cosh(l1 * angle) - std::cos(l2 * angle));
  const double second_moment = b * l1 * std::sinh(l1 * angle) - a * l2 * std::sin(l2 * angle);
  std::vector<double> w;
  for (int i = 0; i < points; ++i) {
    const double x = angle * i / (points - 1);
    w.push_back(first(x) - first_moment / second_moment * second(x));
  }
  return w;
}

// --- The inextensional arc ------------------------------------------------------------------------------------------

// r² of e^{rθ}: z³ + 2 z² + (1 − Ω²) z + Ω² = 0.
std::array<Complex, 3> calc_squares(Complex lambda) {
  Matrix3c companion = Matrix3c::Zero();
  companion(1, 0) = companion(2, 1) = 1;
  companion(0, 2) = -lambda;
  companion(1, 2) = lambda - 1.0;
  companion(2, 2) = -2;
  const Eigen::ComplexEigenSolver<Matrix3c> eigen(companion, false);
  std::array<Complex, 3> z{eigen.eigenvalues()[0], eigen.eigenvalues()[1], eigen.eigenvalues()[2]};
  for (Complex& root : z)  // an eigensolver's digits, and then all
    for (int i = 0; i < 2; ++i) {
      const Complex value = ((root + 2.0) * root + 1.0 - lambda) * root + lambda;
      const Complex slope = (3.0 * root + 4.0) * root + 1.0 - lambda;
      if (std::abs(slope) > 1e-6) root -= value / slope;
    }
  return z;
}

// u and w = u′ at θ of the even solutions cosh rθ, or of the odd ones sinh(rθ)/r: entire in z = r².
Complex calc_u(bool even, Complex z, double theta) {
  const Complex r = std::sqrt(z);
  return even ? std::cosh(r * theta) : theta * sinhc(r * theta);
}
Complex calc_w(bool even, Complex z, double theta) {
  const Complex r = std::sqrt(z);
  return even ? z * theta * sinhc(r * theta) : std::cosh(r * theta);
}

// κ, κ′, κ″ − Ω² u′ at α, a column for each root, over e^{α |Re r|}.
Matrix3c calc_end_conditions(bool even, double alpha, Complex lambda, const std::array<Complex, 3>& z) {
  Matrix3c m;
  for (int k = 0; k < 3; ++k) {
    const Complex root = z[static_cast<std::size_t>(k)];
    const double scale = std::exp(-alpha * std::abs(std::sqrt(root).real()));
    const Complex w = scale * calc_w(even, root, alpha), u = scale * calc_u(even, root, alpha);
    m.col(k) << (root + 1.0) * w, (root + 1.0) * root * u, ((root + 1.0) * root - lambda) * w;
  }
  return m;
}

// Both determinants change sign where two roots change places; over the product of the roots' differences they do not,
// and nothing vanishes where roots meet.
Complex calc_inextensional_determinant(bool even, double alpha, Complex lambda) {
  const std::array<Complex, 3> z = calc_squares(lambda);
  const Complex differences = (z[1] - z[0]) * (z[2] - z[0]) * (z[2] - z[1]);
  return calc_end_conditions(even, alpha, lambda, z).determinant() / differences;
}

void add_inextensional_shape(double alpha, int points, ArcMode& mode) {
  const Complex lambda = mode.omega * mode.omega;
  const std::array<Complex, 3> z = calc_squares(lambda);
  const bool u_even = !mode.even;
  const Eigen::JacobiSVD<Matrix3c> svd(calc_end_conditions(u_even, alpha, lambda, z), Eigen::ComputeFullV);
  const Eigen::Vector3cd a = svd.matrixV().col(2);
  std::vector<Complex> u, w;
  for (int i = 0; i < points; ++i) {
    const double theta = alpha * (2.0 * i / (points - 1) - 1);
    u.emplace_back(0);
    w.emplace_back(0);
    for (int k = 0; k < 3; ++k) {
      const Complex root = z[static_cast<std::size_t>(k)];
      const double scale = std::exp(-alpha * std::abs(std::sqrt(root).real()));
      u.back() += scale * a[k] * calc_u(u_even, root, theta);
      w.back() += scale * a[k] * calc_w(u_even, root, theta);
    }
  }
  // The null vector is that of a real shape, times any phase.
  const Complex largest =
      *std::max_element(w.begin(), w.end(), [](Complex x, Complex y) { return std::abs(x) < std::abs(y); });
  for (int i = 0; i < points; ++i) {
    mode.radial.push_back((w[static_cast<std::size_t>(i)] / largest).real());
    mode.tangential.push_back((-u[static_cast<std::size_t>(i)] / largest).real());
  }
}

// --- Roots ----------------------------------------------------------------------------------------------------------

// Sign changes of f(λ) on a grid whose step is a small part of the roots' distance: they are about π/angle apart in √Ω,
// or twice that in each symmetry. Each is then bisected to the last bit.
template <typename Function>
std::vector<double> find_roots(const Function& f, double spacing, int count) {
  constexpr int kSteps = 40;       // to the next root
  constexpr int kMost = 4;         // times as many steps as the roots need, and then there is something wrong
  constexpr double kFirst = 0.05;  // √Ω below which there is no elastic mode up to nearly a full circle
  std::vector<double> roots;
  const auto at = [&](double x) { return f(x * x * x * x).real(); };
  double x = kFirst, value = at(x);
  for (int i = 0; i < kMost * kSteps * (count + 2) && static_cast<int>(roots.size()) < count; ++i) {
    const double next = x + spacing / kSteps, next_value = at(next);
    if ((value < 0) != (next_value < 0)) {
      double low = x, high = next;
      while (true) {
        const double middle = 0.5 * (low + high);
        if (middle <= low || middle >= high) break;
        ((at(middle) < 0) == (value < 0) ? low : high) = middle;
      }
      roots.push_back(low * low);
    }
    x = next;
    value = next_value;
  }
  return roots;
}

void normalise(ArcMode& mode) {
  double largest = 0;
  for (const double w : mode.radial)
    if (std::abs(w) > std::abs(largest)) largest = w;
  for (double& w : mode.radial) w /= largest;
  for (double& u : mode.tangential) u /= largest;
}

}  // namespace

Complex calc_arc_determinant(ArcModel model, double half_angle, Complex lambda) {
  if (model == ArcModel::kShallow) return calc_shallow_determinant(2 * half_angle, lambda);
  return calc_inextensional_determinant(true, half_angle, lambda) *
         calc_inextensional_determinant(false, half_angle, lambda);
}

// The argument is followed along the circle in steps that halve until each turns it by less than a right angle's half.
int count_arc_roots(ArcModel model, double half_angle, double centre, double radius) {
  const auto at = [&](double t) {
    return calc_arc_determinant(model, half_angle, centre + std::polar(radius, 2 * kPi * t));
  };
  constexpr double kTurn = kPi / 4, kLeastStep = 1e-9;
  double turned = 0, t = 0, step = 1e-3;
  Complex value = at(0);
  while (t < 1) {
    const double next = std::min(t + step, 1.0);
    const Complex next_value = at(next);
    const double turn = std::arg(next_value / value);
    if (std::abs(turn) > kTurn && next - t > kLeastStep) {
      step = 0.5 * (next - t);
      continue;
    }
    turned += turn;
    t = next;
    value = next_value;
    step *= 1.5;
    step = std::min(step, 1e-2);
  }
  return static_cast<int>(std::lround(turned / (2 * kPi)));
}

std::vector<ArcMode> calc_arc_modes(ArcModel model, double angle, int count, int points) {
  std::vector<ArcMode> modes;
  // One root more than asked for: the circle of the count passes between it and the last.
  if (model == ArcModel::kShallow) {
    for (const double omega :
         find_roots([&](double lambda) { return calc_shallow_determinant(angle, lambda); }, kPi / angle, count + 1))
      modes.push_back({omega, modes.size() % 2 == 0, {}, {}});
  } else {
    for (const bool u_even : {false, true})
      for (const double omega :
           find_roots([&](double lambda) { return calc_inextensional_determinant(u_even, angle / 2, lambda); },
                      2 * kPi / angle, count / 2 + 2))
        modes.push_back({omega, !u_even, {}, {}});
    std::sort(modes.begin(), modes.end(), [](const ArcMode& a, const ArcMode& b) { return a.omega < b.omega; });
  }
  const auto wanted = static_cast<std::size_t>(count);
  if (modes.size() > wanted) {
    const double border = 0.5 * (std::pow(modes[wanted - 1].omega, 2) + std::pow(modes[wanted].omega, 2));
    const int rigid = model == ArcModel::kShallow ? 0 : kRigidModes;
    const int there = count_arc_roots(model, angle / 2, 0, border) - rigid;
    if (there != count)
      throw std::runtime_error("the frequency function has " + hil::count(there, "elastic root") + " where " +
                               std::to_string(count) + " were found");
    modes.resize(wanted);
  } else {
    throw std::runtime_error("fewer roots were found than asked for");
  }
  for (ArcMode& mode : modes) {
    if (model == ArcModel::kShallow)
      mode.radial = calc_shallow_shape(angle, mode.omega * mode.omega, points);
    else
      add_inextensional_shape(angle / 2, points, mode);
    normalise(mode);
  }
  return modes;
}

}  // namespace unlatch::tools
