// Curved beam of the paper, (3.4), and the exact inextensional arc: roots, completeness of the roots, shapes that
// satisfy the equations.
#include "tools/modes/curved_beam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tools/modes/shell_beams.h"

namespace unlatch::tools {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kBisected = 1e-14;  // relative: the function's own round-off around its root
constexpr double kPrinted = 1e-11;   // the exact arc's roots are given with twelve digits

std::vector<double> read_roots(const char* file, const char* key) {
  std::ifstream stream(std::string(UNLATCH_TEST_DATA) + "/" + file);
  std::vector<double> roots;
  const nlohmann::json all = nlohmann::json::parse(stream);
  for (const auto& text : all.at(key)) roots.push_back(std::stod(text.get<std::string>()));
  return roots;
}

void expect_roots(ArcModel model, double angle, const std::vector<double>& roots, double tolerance) {
  const auto modes = calc_arc_modes(model, angle, static_cast<int>(roots.size()), 5);
  ASSERT_EQ(modes.size(), roots.size());
  for (std::size_t k = 0; k < roots.size(); ++k) EXPECT_NEAR(modes[k].omega, roots[k], tolerance * roots[k]) << k;
}

TEST(CurvedBeam, RootsOfThePapersEquationAreTheReferences) {
  expect_roots(ArcModel::kShallow, kPi, read_roots("fairing_34_roots.json", "s0=pi R"), kBisected);
  expect_roots(ArcModel::kShallow, kPi / 2, read_roots("fairing_34_roots.json", "s0=pi R/2"), kBisected);
}

TEST(CurvedBeam, RootsOfTheExactArcAreTheReferences) {
  expect_roots(
      ArcModel::kInextensional, kPi,
      read_roots("fairing_exact_arc.json", "Omega=omega R^2 sqrt(m/EJ), exact inextensional free-free semicircle"),
      kPrinted);
}

// 5.06, 15.06, 30.39 Hz by (3.4); the paper's 5, 14, 30 Hz are the exact arc's with the plate's modulus.
TEST(CurvedBeam, FrequenciesOfTheFairingAreThoseOfBothModels) {
  constexpr double kHz = 6e-5;  // printed accuracy
  const double shallow[] = {5.0619, 15.0574, 30.3934}, exact[] = {4.9463, 14.2928, 29.9255};
  const auto a = calc_arc_modes(ArcModel::kShallow, kPi, 3, 5), b = calc_arc_modes(ArcModel::kInextensional, kPi, 3, 5);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(calc_arc_hz(a[k].omega, 2, 0.01, 2e12, 4000, 0.3, false), shallow[k], kHz);
    EXPECT_NEAR(calc_arc_hz(b[k].omega, 2, 0.01, 2e12, 4000, 0.3, true), exact[k], kHz);
  }
}

// A short arc is a straight beam: Ω angle² approaches the squares of 4.730, 7.853, ….
TEST(CurvedBeam, AFlatArcIsAStraightBeam) {
  constexpr double kRoots[] = {4.730040744862704, 7.853204624095838, 10.995607838001671};
  constexpr double kAngle = 0.1;
  for (const ArcModel model : {ArcModel::kShallow, ArcModel::kInextensional}) {
    const auto modes = calc_arc_modes(model, kAngle, 3, 5);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(modes[k].omega * kAngle * kAngle, kRoots[k] * kRoots[k], kAngle * kAngle * kRoots[k] * kRoots[k]);
  }
}

// The count is independent of the search for roots, and finds the rigid motions too: two translations and a rotation.
TEST(CurvedBeam, TheArgumentCountsEveryRoot) {
  for (const double angle : {0.7, kPi / 2, kPi, 5.0, 6.2}) {
    const auto shallow = calc_arc_modes(ArcModel::kShallow, angle, 12, 3);
    const auto exact = calc_arc_modes(ArcModel::kInextensional, angle, 12, 3);
    for (const std::size_t n : {std::size_t{1}, std::size_t{4}, std::size_t{11}}) {
      const auto between = [n](const std::vector<ArcMode>& modes) {
        return 0.5 * (std::pow(modes[n - 1].omega, 2) + std::pow(modes[n].omega, 2));
      };
      const int there = static_cast<int>(n);
      EXPECT_EQ(count_arc_roots(ArcModel::kShallow, angle / 2, 0, between(shallow)), there);
      EXPECT_EQ(count_arc_roots(ArcModel::kInextensional, angle / 2, 0, between(exact)), there + 3);
    }
  }
}

// Derivatives by the angle, central differences of fourth order inside.
class Differences {
 public:
  Differences(const std::vector<double>& f, double angle) : f_(f), h_(angle / static_cast<double>(f.size() - 1)) {}
  double second(std::size_t i) const {
    return (-f_[i - 2] + 16 * f_[i - 1] - 30 * f_[i] + 16 * f_[i + 1] - f_[i + 2]) / (12 * h_ * h_);
  }
  double fourth(std::size_t i) const {
    return (f_[i - 2] - 4 * f_[i - 1] + 6 * f_[i] - 4 * f_[i + 1] + f_[i + 2]) / (h_ * h_ * h_ * h_);
  }
  double first(std::size_t i) const { return (f_[i - 2] - 8 * f_[i - 1] + 8 * f_[i + 1] - f_[i + 2]) / (12 * h_); }

 private:
  const std::vector<double>& f_;
  double h_;
};

constexpr int kPoints = 401;
constexpr double kDifferences = 1e-3;  // relative error of finite differences at that many points

TEST(CurvedBeam, ShapesSatisfyThePapersEquation) {
  for (const ArcMode& mode : calc_arc_modes(ArcModel::kShallow, kPi, 3, kPoints)) {
    const Differences w(mode.radial, kPi);
    const double scale = mode.omega * mode.omega;
    for (std::size_t i = 20; i + 20 < mode.radial.size(); i += 20)
      EXPECT_NEAR(w.fourth(i) + w.second(i), scale * mode.radial[i], kDifferences * scale);
    // w'' + w is 0 at the end, and grows only with the square of the distance: so is its slope.
    EXPECT_NEAR(w.second(2) + mode.radial[2], 0, kDifferences * scale);
  }
}

// Rayleigh: the energies of the shape give its frequency; and the arc does not stretch.
TEST(CurvedBeam, ShapesOfTheExactArcHaveTheirFrequencies) {
  for (const ArcMode& mode : calc_arc_modes(ArcModel::kInextensional, kPi, 3, kPoints)) {
    const Differences w(mode.radial, kPi), u(mode.tangential, kPi);
    double bending = 0, motion = 0;
    for (std::size_t i = 0; i < mode.radial.size(); ++i) {
      const bool inside = i >= 2 && i + 2 < mode.radial.size(), end = i == 0 || i + 1 == mode.radial.size();
      motion += (end ? 0.5 : 1) * (mode.radial[i] * mode.radial[i] + mode.tangential[i] * mode.tangential[i]);
      if (!inside) continue;  // no bending at the ends
      const double curvature = w.second(i) + mode.radial[i];
      bending += curvature * curvature;
      EXPECT_NEAR(u.first(i), -mode.radial[i], kDifferences);
    }
    EXPECT_NEAR(bending / motion, mode.omega * mode.omega, kDifferences * mode.omega * mode.omega);
    const double mirrored = mode.radial.front() * mode.radial.back();
    EXPECT_NEAR(mirrored, mode.even ? 1 : -1, 1e-9);
  }
}

}  // namespace
}  // namespace unlatch::tools
