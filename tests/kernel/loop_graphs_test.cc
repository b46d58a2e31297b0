// Systems with many closed loops: graphs of bodies against the equations of motion, masts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "kernel/dynamics/balance.h"
#include "kernel/integration/integrator.h"
#include "tests/support/malloc_guard.h"
#include "tests/support/mast_model.h"
#include "tests/support/random_model.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "tests/support/solve_comparison.h"
#include "unlatch/energy.h"

namespace unlatch::test {
namespace {

constexpr double kAgreement = 1e-10;  // relative to the largest force, and to the largest acceleration

// A random tree with `loops` more joints that are open at first, so that any velocities fit.
Model build_graph(std::uint64_t seed, int bodies, int loops, Random& random) {
  RandomModelOptions options;
  options.bodies = bodies;
  Model model = build_random_model(seed, options);
  const int count = static_cast<int>(model.bodies.size());
  for (int k = 0; k < loops; ++k) {
    const int base = random.below(count), follower = (base + 1 + random.below(count - 1)) % count;
    const RowSet kinds[] = {kPointRows, kRevoluteRows, row_bit(kX), row_bit(kRotY)};
    Joint joint = build_closing_joint(model, base, follower, random);
    joint.modes = {{"open", 0}, {"closed", kinds[random.below(4)]}};
    model.joints.push_back(joint);
  }
  return model;
}

struct Residual {
  double forces = 0, rows = 0;  // of M a + w × J w − f − Gᵀ λ and of G a − c, relative to the largest of their terms
};

// The equations of motion with the kernel's accelerations and multipliers, by the matrices of the dense solver: what no
// order of elimination enters.
Residual calc_residual(const Model& model, const Simulation& s, const std::vector<Wrench>& wrenches) {
  const SystemState state = read_state(s);
  const DenseKkt kkt = build_dense_kkt(model, state);
  const KernelSolution ours = read_solution(s);
  const auto n = static_cast<Eigen::Index>(model.bodies.size());
  RealVector a(6 * n), f(6 * n), lambda(kkt.rows.rows());
  for (Eigen::Index b = 0; b < n; ++b) {
    const auto i = static_cast<std::size_t>(b);
    a.segment<3>(6 * b) = ours.linear[i].cast<Real>();
    a.segment<3>(6 * b + 3) = ours.angular[i].cast<Real>();
    const Eigen::Vector3d weight = model.bodies[i].mass * model.gravity.uniform;
    f.segment<3>(6 * b) = (wrenches[i].force + weight).cast<Real>();
    f.segment<3>(6 * b + 3) = (state.bodies[i].q_WB.conjugate() * wrenches[i].torque).cast<Real>();
  }
  for (Eigen::Index k = 0; k < lambda.size(); ++k) {
    const DenseKkt::RowName& name = kkt.names[static_cast<std::size_t>(k)];
    lambda[k] = ours.multipliers[static_cast<std::size_t>(name.joint)][name.row];
  }
  const RealVector inertial = kkt.mass * a, reaction = kkt.rows.transpose() * lambda, motion = kkt.rows * a;
  const RealVector forces = inertial - kkt.gyroscopic - f - reaction, rows = motion - kkt.bias;
  const Real force_scale = std::max<Real>(1, std::max(inertial.cwiseAbs().maxCoeff(), reaction.cwiseAbs().maxCoeff()));
  Residual out;
  out.forces = static_cast<double>(forces.cwiseAbs().maxCoeff() / force_scale);
  if (rows.size() > 0)
    out.rows = static_cast<double>(rows.cwiseAbs().maxCoeff() / std::max<Real>(1, a.cwiseAbs().maxCoeff()));
  return out;
}

TEST(LoopGraphs, SatisfyTheEquationsOfMotion) {
  Residual worst;
  int redundant = 0, most = 0;
  for (std::uint64_t seed = 900; seed < 960; ++seed) {
    Random random(seed);
    const int bodies = seed % 6 == 0 ? 100 + random.below(101) : 2 + random.below(40);
    const int loops = random.below(std::min(101, bodies));
    Model model = build_graph(seed, bodies, loops, random);
    const std::vector<Wrench> wrenches = add_random_loads(model, random);
    Simulation s(model);
    for (std::size_t j = 0; j < model.joints.size(); ++j)
      if (model.joints[j].modes.back().name == "closed") s.state.joints[j].mode = 1;
    update_motion(s);
    ASSERT_EQ(apply_impulse(s.data(), Source::kNothing, s.state, s.evaluation()), kNone) << "seed " << seed;
    ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk) << "seed " << seed;
    const Residual r = calc_residual(model, s, wrenches);
    EXPECT_LT(r.forces, kAgreement) << "seed " << seed << ", " << bodies << " bodies, " << loops << " loops";
    EXPECT_LT(r.rows, kAgreement) << "seed " << seed << ", " << bodies << " bodies, " << loops << " loops";
    worst = {std::max(worst.forces, r.forces), std::max(worst.rows, r.rows)};
    redundant += s.evaluation().loop_redundant > 0 ? 1 : 0;
    most = std::max(most, loops);
  }
  std::printf("60 graphs with up to %d loops, %d with redundant rows: forces to %.1e, rows to %.1e\n", most, redundant,
              worst.forces, worst.rows);
  EXPECT_GT(redundant, 10);
  EXPECT_GT(most, 60);
}

TEST(LoopGraphs, AMastHasThreeRedundantRowsALoopAndEqualSharesOnBothSides) {
  for (const int units : {2, 3, 8, 40}) {
    const Model model = build_mast(units);
    Simulation s(model);
    ASSERT_EQ(s.advance().redundant, 3 * (units - 1)) << units;
    const Residual r = calc_residual(model, s, std::vector<Wrench>(model.bodies.size()));
    EXPECT_LT(std::max(r.forces, r.rows), kAgreement) << units;
  }
}

TEST(LoopGraphs, AMastInFreeMotionKeepsItsEnergy) {
  constexpr int kUnits = 10;
  constexpr double kWeight = 0.05;  // m/s²: within ten seconds no bar comes to lie along the mast
  Model model = build_mast(kUnits, 0.9);
  model.gravity.uniform = {0, -kWeight, 0};
  Simulation s(model);
  const auto calc = [&] {
    const EnergyFlow flow = calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0});
    double height = 0;
    for (std::size_t b = 0; b < model.bodies.size(); ++b) height += s.state.bodies[b].p.y;
    return flow.kinetic + kWeight * height;  // masses of 1 kg
  };
  ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
  const double before = calc();
  double largest = 0, kinetic = 0;
  for (int i = 0; i < 10000; ++i) {
    ASSERT_EQ(s.advance().status, StepStatus::kOk) << i;
    if (i % 100 != 0) continue;
    largest = std::max(largest, std::abs(calc() - before));
    kinetic = std::max(kinetic, calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0}).kinetic);
  }
  std::printf("energy kept to %.1e of %.3g J over ten seconds\n", largest, kinetic);
  EXPECT_GT(kinetic, 0.5);
  EXPECT_LT(largest, 1e-6 * kinetic);
}

TEST(LoopGraphs, AnyJointOfAMastLocksAndLetsGoWithoutAllocation) {
  if (!kCountsAllocations) GTEST_SKIP() << "this build's sanitizer owns malloc";
  const Model model = build_mast(12);
  Simulation s(model);
  Random random(7);
  std::vector<int> changes;
  for (int i = 0; i < 200; ++i) changes.push_back(random.below(3 * static_cast<int>(model.joints.size() - 1)));
  const AllocationCount allocations;
  bool good = true;
  for (const int change : changes) {
    s.state.joints[1 + static_cast<std::size_t>(change / 3)].mode = change % 3;
    update_motion(s);
    good = good && apply_impulse(s.data(), Source::kNothing, s.state, s.evaluation()) == kNone;
    for (int k = 0; k < 3; ++k) good = good && s.advance().status == StepStatus::kOk;
  }
  EXPECT_EQ(allocations.get(), 0);
  EXPECT_TRUE(good);
  const Residual r = calc_residual(model, s, std::vector<Wrench>(model.bodies.size()));
  EXPECT_LT(std::max(r.forces, r.rows), kAgreement);
}

TEST(LoopGraphs, MemoryOfAMastGrowsWithItsLength) {
  const auto calc = [](int units) {
    const Model model = build_mast(units);
    const Plan plan = compile_or_throw(model, {});
    return static_cast<double>(plan.get_workspace_bytes()) / (2.0 * units);
  };
  const double few = calc(100), many = calc(5000);
  std::printf("workspace %.0f bytes a body with 100 units, %.0f with 5000\n", few, many);
  EXPECT_LT(many, 1.05 * few);
}

}  // namespace
}  // namespace unlatch::test
