// Flexible bodies from modes: conditioning, invariants, selection.
#include "hil/scenario/flexible/flexible_body.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/hil/scenario/modes_support.h"

namespace unlatch::test::flexible_body_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kRoundOff = 1e-12;  // sums over some 30 points, relative
constexpr int kBays = 6, kModes = 7;

// Returns ∫ a × b dm from ∫ a bᵀ dm.
Vector3d calc_moment(const Matrix3d& m) { return {m(1, 2) - m(2, 1), m(2, 0) - m(0, 2), m(0, 1) - m(1, 0)}; }

hil::FlexibleStructure build(const hil::Modes& modes, const hil::ModeSelection& selection = {}) {
  hil::FlexibleReport report;
  return hil::build_flexible_body(modes, selection, report);
}

TEST(FlexibleBody, ModesThatAreRightStayAsTheyAre) {
  const hil::Modes modes = build_mast_modes(kBays, kModes, Support::kFree);
  hil::FlexibleReport report;
  const hil::FlexibleStructure body = hil::build_flexible_body(modes, {}, report);
  EXPECT_LT(report.found_gram, kRoundOff);
  EXPECT_LT(report.found_momentum, 1e-10);  // an eigensolver's
  for (int k = 0; k < kModes; ++k) {
    EXPECT_NEAR(body.flexible.frequencies[k] / (2 * std::numbers::pi * modes.frequencies_hz[k]), 1, kRoundOff);
    EXPECT_NEAR(report.modes[static_cast<std::size_t>(k)].overlap, 1, kRoundOff);
  }
  const Vector3d tip = modes.markers[1].position - body.centre;
  EXPECT_LT((body.markers[1].marker.position - tip).norm(), kRoundOff);
  EXPECT_LT((body.markers[1].marker.shape - modes.markers[1].shape).norm(), 1e-9 * modes.markers[1].shape.norm());
}

// Clamped modes carry momenta. Projected, they are Ritz vectors of the free structure: by Rayleigh's principle no
// frequency can be below the exact one.
TEST(FlexibleBody, MomentumIsTakenOutOfModesThatCarryIt) {
  const hil::Modes modes = build_mast_modes(kBays, kModes, Support::kClamped);
  hil::FlexibleReport report;
  const hil::FlexibleStructure body = hil::build_flexible_body(modes, {}, report);
  EXPECT_GT(report.found_momentum, 0.1);
  EXPECT_LT(report.momentum, kRoundOff);
  EXPECT_LT(report.gram, kRoundOff);
  EXPECT_LT(body.flexible.momentum.norm(), kRoundOff * std::sqrt(body.mass));
  for (const Matrix3d& first : body.flexible.first)
    EXPECT_LT(calc_moment(first).norm(), kRoundOff * std::sqrt(body.inertia.norm()));
  const ModalBody free = build_lattice_mast(kBays, kModes, Support::kFree);
  double effective = 0;
  for (int k = 0; k < kModes; ++k) {
    EXPECT_GE(body.flexible.frequencies[k], free.frequencies[k] * (1 - kRoundOff));
    effective += report.modes[static_cast<std::size_t>(k)].effective_mass.y();
  }
  EXPECT_LT(body.flexible.frequencies[0], 1.25 * free.frequencies[0]);  // the clamped bay cannot bend in any of them
  EXPECT_GT(effective, 0.5);
  EXPECT_LT(effective, 1);
}

// Checks the quantities in which a kernel uses the invariants against sums over the masses.
TEST(FlexibleBody, InvariantsAreTheSumsOverItsPoints) {
  hil::Modes modes = build_mast_modes(kBays, kModes, Support::kFree);
  for (hil::ModalPoint& point : modes.points)  // digits as a printed file has them, and momenta
    for (double& value : point.shape.reshaped()) value = std::round(value * 1e3) * 1e-3 + 0.01;
  hil::FlexibleReport report;
  const hil::Modes conditioned = hil::condition_modes(modes, report);
  const hil::FlexibleStructure body = hil::calc_invariants(conditioned, {0.01});
  const VectorXd eta = VectorXd::LinSpaced(kModes, -0.3, 0.4), rate = VectorXd::LinSpaced(kModes, 0.2, -0.7);

  double mass = 0, kinetic = 0;
  Vector3d first = Vector3d::Zero(), momentum = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
  for (const hil::ModalPoint& point : conditioned.points) {
    const Vector3d place = point.position + point.shape * eta, speed = point.shape * rate;
    mass += point.mass;
    first += point.mass * place;
    second += point.mass * place * place.transpose();
    momentum += point.mass * place.cross(speed);
    kinetic += point.mass * speed.squaredNorm() / 2;
  }

  Vector3d first_by = body.flexible.momentum * eta, momentum_by = Vector3d::Zero();
  Matrix3d second_by = body.inertia.trace() / 2 * Matrix3d::Identity() - body.inertia;  // ∫ r rᵀ dm of the undeformed
  double kinetic_by = 0;
  for (Eigen::Index k = 0; k < kModes; ++k) {
    const Matrix3d& a = body.flexible.first[static_cast<std::size_t>(k)];
    second_by += eta[k] * (a + a.transpose());
    momentum_by += rate[k] * calc_moment(a);
    for (Eigen::Index l = 0; l < kModes; ++l) {
      const Matrix3d& b = body.flexible.second[static_cast<std::size_t>(k * kModes + l)];
      second_by += eta[k] * eta[l] * b;
      kinetic_by += rate[k] * rate[l] * b.trace() / 2;
      momentum_by += eta[k] * rate[l] * calc_moment(b);
    }
  }
  EXPECT_NEAR(body.mass, mass, kRoundOff * mass);
  EXPECT_LT((first_by - first).norm(), kRoundOff * mass);
  EXPECT_LT((second_by - second).norm(), kRoundOff * second.norm());
  EXPECT_LT((momentum_by - momentum).norm(), kRoundOff * second.norm());
  EXPECT_NEAR(kinetic_by, kinetic, kRoundOff * kinetic);
  EXPECT_NEAR(kinetic, rate.squaredNorm() / 2, kRoundOff * kinetic);  // modal masses are 1
  EXPECT_EQ(body.flexible.damping, VectorXd::Constant(kModes, 0.01));
}

// A uniform beam: shapes and frequencies of the closed form on a ladder of points. With lumped masses they are
// orthonormal to about (bend per point)²; conditioning makes them so.
TEST(FlexibleBody, AFreeFreeBeamKeepsItsAnalyticFrequencies) {
  constexpr double kRoots[] = {4.730040744862704, 7.853204624095838, 10.995607838001671};  // cosh β cos β = 1
  constexpr int kPoints = 200;
  hil::Modes modes;
  modes.frequencies_hz.resize(3);
  for (int k = 0; k < 3; ++k) modes.frequencies_hz[k] = kRoots[k] * kRoots[k] / (2 * std::numbers::pi);
  for (int i = 0; i < kPoints; ++i)
    for (const double side : {-0.05, 0.05}) {
      const double x = (i + 0.5) / kPoints;
      hil::ModalPoint point{0.5 / kPoints, {x, side, 0}, Eigen::Matrix3Xd::Zero(3, 3)};
      for (int k = 0; k < 3; ++k) {
        const double b = kRoots[k], s = (std::cosh(b) - std::cos(b)) / (std::sinh(b) - std::sin(b));
        point.shape(2, k) = std::cosh(b * x) + std::cos(b * x) - s * (std::sinh(b * x) + std::sin(b * x));
      }
      modes.points.push_back(point);
    }
  hil::FlexibleReport report;
  const hil::FlexibleStructure body = hil::build_flexible_body(modes, {}, report);
  EXPECT_GT(report.found_gram, 1e-7);  // lumping shows
  EXPECT_LT(report.gram, kRoundOff);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(body.flexible.frequencies[k], kRoots[k] * kRoots[k], 1e-5 * body.flexible.frequencies[k]);
  EXPECT_NEAR(body.centre.x(), 0.5, kRoundOff);
  EXPECT_NEAR(body.inertia(1, 1), 1.0 / 12, 1e-5);
}

TEST(FlexibleBody, RigidModesOfTheFileAreLeftOut) {
  hil::Modes modes = build_mast_modes(kBays, kModes, Support::kFree);
  const hil::FlexibleStructure alone = build(modes);
  const auto with_rigid = [](const Eigen::Matrix3Xd& shape, const Vector3d& at) {
    Eigen::Matrix3Xd wider(3, shape.cols() + 2);
    wider << Vector3d(0.3, 0, 0), Vector3d(0, 0, 0.2).cross(at) + Vector3d(0.1, 0, 0), shape;
    return wider;
  };
  for (hil::ModalPoint& point : modes.points) point.shape = with_rigid(point.shape, point.position);
  for (hil::ModalMarker& marker : modes.markers) {
    marker.shape = with_rigid(marker.shape, marker.position);
    marker.rotation = with_rigid(marker.rotation, Vector3d::Zero());
  }
  VectorXd frequencies(kModes + 2);
  frequencies << 0, 1e-4, modes.frequencies_hz;
  modes.frequencies_hz = frequencies;
  hil::FlexibleReport report;
  const hil::FlexibleStructure body = hil::build_flexible_body(modes, {}, report);
  EXPECT_THAT(report.rigid, ElementsAre(1, 2));
  EXPECT_LT((body.flexible.frequencies - alone.flexible.frequencies).norm(),
            kRoundOff * alone.flexible.frequencies.norm());
}

TEST(FlexibleBody, ASelectionKeepsItsModesAndSaysWhatIsLost) {
  const hil::Modes modes = build_mast_modes(kBays, kModes, Support::kFree);
  const hil::FlexibleStructure all = build(modes);
  hil::FlexibleReport report;
  const hil::FlexibleStructure some = hil::build_flexible_body(modes, {{5, 2}, {0.02, 0.01}}, report);
  ASSERT_EQ(some.flexible.frequencies.size(), 2);
  EXPECT_EQ(some.flexible.frequencies, Eigen::Vector2d(all.flexible.frequencies[4], all.flexible.frequencies[1]));
  EXPECT_EQ(some.flexible.damping, Eigen::Vector2d(0.02, 0.01));
  EXPECT_EQ(some.flexible.first[0], all.flexible.first[4]);
  EXPECT_EQ(some.flexible.second[1], all.flexible.second[4 * kModes + 1]);
  EXPECT_EQ(some.markers[1].marker.shape.col(1), all.markers[1].marker.shape.col(1));
  double kept = 0, whole = 0;
  for (const hil::ModeFinding& mode : report.modes) {
    EXPECT_EQ(mode.selected, mode.number == 5 || mode.number == 2);
    whole += mode.compliance.at(1);
    if (mode.selected) kept += mode.compliance.at(1);
  }
  EXPECT_NEAR(whole, 1, kRoundOff);
  EXPECT_GT(kept, 0);
  EXPECT_LT(kept, 1);
}

std::string get_refusal(const hil::Modes& modes, const hil::ModeSelection& selection = {}) {
  try {
    build(modes, selection);
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(FlexibleBody, WhatCannotBeIsRefused) {
  const hil::Modes good = build_mast_modes(kBays, kModes, Support::kFree);
  EXPECT_THAT(get_refusal(good, {{1, 99}, {0}}), HasSubstr("no elastic mode 99"));
  EXPECT_THAT(get_refusal(good, {{1, 1}, {0}}), HasSubstr("selected twice"));
  EXPECT_THAT(get_refusal(good, {{1, 2, 3}, {0, 0}}), HasSubstr("2 damping ratios for 3 modes"));
  EXPECT_THAT(get_refusal(good, {{1}, {-0.1}}), HasSubstr("at least 0"));
  hil::Modes same = good, still = good, line = good, timeless = good;
  for (hil::ModalPoint& point : same.points) point.shape.col(2) = 2 * point.shape.col(1);
  EXPECT_THAT(get_refusal(same), HasSubstr("not independent"));
  for (hil::ModalPoint& point : still.points) point.shape.col(2).setZero();
  EXPECT_THAT(get_refusal(still), HasSubstr("mode 3 moves no mass"));
  for (hil::ModalPoint& point : line.points) point.position.tail<2>().setZero();
  EXPECT_THAT(get_refusal(line), HasSubstr("on one line"));
  timeless.frequencies_hz[3] = 0;
  EXPECT_THAT(get_refusal(timeless), HasSubstr("mode 4 has no frequency"));
}

}  // namespace
}  // namespace unlatch::test::flexible_body_test
