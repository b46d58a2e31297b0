// Reactions of many more redundant rows than others, in a system with a loop through a body that bends: there loops are
// solved by one dense matrix, and the split of reactions by how far the independent rows yield.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/modal_model.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::test::welded_plate_test {
namespace {

constexpr int kBolts = 8;
constexpr double kRadius = 0.4, kForce = -1000, kMoment = 120;  // m; N along z, N m about x
constexpr double kRounding = 1e-11;                             // relative to the force

// A plate that eight bolts hold to the ground on a circle, each in all six directions, under a force and a moment; far
// from it a mast that two ball joints hold at its ends.
Model build_plate_and_mast() {
  constexpr int kModes = 3;
  const ModalBody lumped = build_lattice_mast(3, kModes, Support::kFree);
  Model model;
  model.bodies = {box("plate", 10, 0.5, 0.6, 0.9), build_flexible_body("mast", lumped)};
  model.bodies[0].p_WB = {0, 0, 0.2};
  model.bodies[1].p_WB = {50, 0, 0};
  for (int k = 0; k < kBolts; ++k) {
    Joint& bolt = model.joints.emplace_back();
    bolt.name = "bolt" + std::to_string(k);
    const double angle = 2 * M_PI * k / kBolts;
    bolt.point_base = {kRadius * std::cos(angle), kRadius * std::sin(angle), 0};
    bolt.point_follower = bolt.point_base - model.bodies[0].p_WB;
    bolt.modes = {{"held", kWeldRows}};
  }
  for (const std::size_t particle : {std::size_t{0}, std::size_t{15}}) {
    model.bodies.push_back(
        build_marker("at" + std::to_string(particle), 1, lumped, particle, Eigen::Matrix3Xd::Zero(3, kModes)));
    Joint& ball = model.joints.emplace_back();
    ball.name = "ball" + std::to_string(particle);
    ball.follower = static_cast<int>(model.bodies.size()) - 1;
    ball.point_base = model.bodies[1].p_WB + lumped.positions[particle];
    ball.modes = {{"ball", kPointRows}};
  }
  for (const bool moment : {false, true}) {
    Load& load = model.loads.emplace_back();
    load.name = moment ? "moment" : "force";
    load.kind = moment ? Load::Kind::kTorque : Load::Kind::kForce;
    load.direction = moment ? Eigen::Vector3d(kMoment, 0, 0) : Eigen::Vector3d(0, 0, kForce);
  }
  return model;
}

// Forces and moments share the load as R²/2 to L², with L a tenth of the circle's radius, as without the mast.
TEST(WeldedPlate, BesideAMastInALoopItsBoltsShareForceAndMomentAsInTheClosedForm) {
  const Model model = build_plate_and_mast();
  Simulation s(model);
  ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
  ASSERT_TRUE(s.data().closures.empty()) << "one dense matrix";
  EXPECT_EQ(s.evaluation().loop_redundant, 6 * kBolts - 6);
  const double length = 0.1 * kRadius, stiffness = kBolts * (0.5 * kRadius * kRadius + length * length);
  const auto get = [&](std::size_t bolt, int row) { return s.workspace.multipliers[bolt * kRows + at(row)]; };
  for (std::size_t k = 0; k < kBolts; ++k) {
    const double y = model.joints[k].point_follower.y();
    EXPECT_NEAR(get(k, kZ), -kForce / kBolts - kMoment * y / stiffness, kRounding * std::abs(kForce)) << k;
    EXPECT_NEAR(get(k, kRotX), -kMoment * length * length / stiffness, kRounding * std::abs(kForce)) << k;
    for (const int none : {kX, kY, kRotY, kRotZ}) EXPECT_NEAR(get(k, none), 0, kRounding * std::abs(kForce)) << k;
  }
}

}  // namespace
}  // namespace unlatch::test::welded_plate_test
