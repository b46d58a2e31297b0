// Frequencies of a flexible body in free, steady spin: the effect of one step of the kernel on small motions about it,
// against the lumped masses' equations, differentiated numerically. In body axes a small motion is (w, η, η'); its
// place and attitude follow, and for modes without momentum the centre of mass moves in a straight line.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <complex>
#include <functional>
#include <iostream>
#include <vector>

#include "tests/support/linear_algebra.h"
#include "tests/support/modal_model.h"
#include "tests/support/simulation.h"

namespace unlatch::test::spinning_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr int kModes = 6;
constexpr Index kSize = 3 + 2 * kModes;
constexpr double kStep = 1e-4;   // s: RK4 turns a mode by (ω h)⁵/120 too little, 1.4e-8 of ω h for the fastest here
constexpr double kSmall = 1e-4;  // step of the differences: rounding over it and over the step is 1e-8 1/s
constexpr double kAgree = 1e-7;  // relative to the fastest frequency
constexpr double kSteady = 1e-9;  // relative to its square: residual of z'

// State in one attitude: the motion is the same in all, so the body's axes are those of W.
FlexibleState build_state(const VectorXd& z) {
  FlexibleState s;
  s.p_WB.setZero();
  s.v_WB.setZero();
  s.q_WB.setIdentity();
  s.w_WB_B = z.head<3>();
  s.eta = z.segment(3, kModes);
  s.eta_rate = z.tail(kModes);
  return s;
}

// Rates z' of the particles.
VectorXd calc_rate(const ModalBody& lumped, const VectorXd& z) {
  const FlexibleAcceleration a = calc_flexible_acceleration(lumped, build_state(z), {});
  VectorXd out(kSize);
  out << a.angular, z.tail(kModes), a.modal;
  return out;
}

MatrixXd differentiate(const std::function<VectorXd(const VectorXd&)>& f, const VectorXd& z) {
  MatrixXd out(kSize, kSize);
  for (Index k = 0; k < kSize; ++k) {
    const VectorXd d = kSmall * VectorXd::Unit(kSize, k);
    out.col(k) = (f(z + d) - f(z - d)) / (2 * kSmall);
  }
  return out;
}

// State with z' = 0 for all particles, for a spin of that magnitude, rad/s, near its direction: by Gauss and Newton.
VectorXd find_steady_spin(const ModalBody& lumped, const Vector3d& spin) {
  VectorXd z = VectorXd::Zero(kSize);
  z.head<3>() = spin;
  for (int iteration = 0; iteration < 20; ++iteration) {
    VectorXd residual(kSize + 1);
    residual << calc_rate(lumped, z), z.head<3>().norm() - spin.norm();
    MatrixXd slope(kSize + 1, kSize);
    slope << differentiate([&](const VectorXd& at) { return calc_rate(lumped, at); }, z),
        VectorXd::Zero(kSize).transpose();
    slope.bottomRows<1>().head<3>() = z.head<3>().normalized().transpose();
    z -= test::solve_least_squares(slope, residual);
  }
  return z;
}

// Makes one step of the kernel.
VectorXd advance(Simulation& s, const VectorXd& z) {
  init_state(s.plan, s.state);
  s.state.bodies[0].w = {z[0], z[1], z[2]};
  for (Index k = 0; k < 2 * kModes; ++k) s.state.auxiliary[static_cast<std::size_t>(k)] = z[3 + k];
  EXPECT_EQ(s.advance().status, StepStatus::kOk);
  const Vec3& w = s.state.bodies[0].w;
  VectorXd out(kSize);
  out.head<3>() << w.x, w.y, w.z;
  for (Index k = 0; k < 2 * kModes; ++k) out[3 + k] = s.state.auxiliary[static_cast<std::size_t>(k)];
  return out;
}

// Oscillations with positive frequency, slowest first, 1/s: real part growth, imaginary part frequency.
std::vector<std::complex<double>> pick_oscillations(const VectorXcd& all) {
  std::vector<std::complex<double>> out;
  for (const std::complex<double>& x : all)
    if (x.imag() > 1e-2) out.push_back(x);
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.imag() < b.imag(); });
  return out;
}

std::vector<std::complex<double>> calc_kernel_eigenvalues(const ModalBody& lumped, const VectorXd& z) {
  Model model;
  model.bodies.push_back(build_flexible_body("mast", lumped));
  Simulation s(model, {.dt = kStep});
  const VectorXcd map = test::calc_eigenvalues(differentiate([&](const VectorXd& at) { return advance(s, at); }, z));
  return pick_oscillations(map.array().log().matrix() / kStep);
}

std::vector<std::complex<double>> calc_particle_eigenvalues(const ModalBody& lumped, const VectorXd& z) {
  return pick_oscillations(
      test::calc_eigenvalues(differentiate([&](const VectorXd& at) { return calc_rate(lumped, at); }, z)));
}

const Vector3d kAlong = Vector3d::UnitX(), kAcross = Vector3d::UnitZ();  // of the mast

TEST(Spinning, SmallMotionsHaveTheFrequenciesAndDampingOfTheParticles) {
  const ModalBody lumped = build_lattice_mast(3, kModes, Support::kFree);
  const double fastest = lumped.frequencies.maxCoeff();
  double worst = 0;
  for (const Vector3d& axis : {kAlong, kAcross})
    for (const double spin : {0.0, 1.0, 10.0, 60.0}) {
      const VectorXd z = find_steady_spin(lumped, spin * axis);
      ASSERT_LT(calc_rate(lumped, z).norm(), kSteady * fastest * fastest) << "spin " << spin * axis.transpose();
      const auto found = calc_kernel_eigenvalues(lumped, z), expected = calc_particle_eigenvalues(lumped, z);
      ASSERT_EQ(found.size(), expected.size()) << "spin " << spin * axis.transpose();
      for (std::size_t k = 0; k < found.size(); ++k) {
        worst = std::max(worst, std::abs(found[k] - expected[k]) / fastest);
        EXPECT_LT(std::abs(found[k] - expected[k]), kAgree * fastest)
            << "spin " << spin * axis.transpose() << ", motion " << k + 1;
      }
    }
  std::cout << "largest difference of an eigenvalue, of the fastest frequency: " << worst << "\n";
}

// Sensitivity of the comparison to the spin's terms: two bending modes, equal to a thousandth at rest, differ by more
// than a twentieth.
TEST(Spinning, TheSpinSplitsAPairOfBendings) {
  const ModalBody lumped = build_lattice_mast(3, kModes, Support::kFree);
  const auto rest = calc_kernel_eigenvalues(lumped, find_steady_spin(lumped, Vector3d::Zero()));
  const auto spun = calc_kernel_eigenvalues(lumped, find_steady_spin(lumped, 10 * kAlong));
  ASSERT_EQ(rest.size() + 1, spun.size());  // and the axis nutates
  EXPECT_LT(rest[2].imag() - rest[1].imag(), 1e-3 * rest[1].imag());
  EXPECT_GT(spun[3].imag() - spun[2].imag(), 0.05 * rest[1].imag());
  EXPECT_GT(spun[3].imag() - spun[2].imag(), 1e4 * kAgree * lumped.frequencies.maxCoeff());
}

}  // namespace
}  // namespace unlatch::test::spinning_test
