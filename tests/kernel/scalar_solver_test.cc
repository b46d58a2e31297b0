// The scalar reference of the solver (tests/support/scalar_solver.h) against the kernel's sweeps and against a dense
// solve.
#include "tests/support/scalar_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "kernel/joints/kinematics.h"
#include "tests/support/random_model.h"
#include "tests/support/solve_comparison.h"

namespace unlatch::test::scalar_solver_test {
namespace {

constexpr double kAgreement = 1e-10;     // relative to the largest of its kind, well-conditioned systems
constexpr double kLoopAgreement = 1e-8;  // Λ of a loop has the square of its rows' condition
constexpr double kConditioned = 1e3;     // condition of the rows: others belong to Loops.*
constexpr std::uint64_t kFirstSeed = 424200;

// The scalar solution in the form of the dense one.
KernelSolution solve_scalar(Simulation& s) {
  const Inputs inputs{s.commands};
  update_forces({s.data(), inputs, s.state, s.get_time()}, s.evaluation());
  const ScalarSolution found = solve_one_by_one(s.data(), s.state, s.evaluation());
  KernelSolution out;
  for (std::size_t b = 0; b < found.accelerations.size(); ++b) {
    const Vector6& a = found.accelerations[b];
    const Mat3 R = read_kinematics(s.evaluation(), static_cast<int>(b)).R;
    const Vec3 ang = transpose_times(R, Vec3{a[3], a[4], a[5]});
    out.linear.push_back(a.head<3>());
    out.angular.emplace_back(ang.x, ang.y, ang.z);
  }
  out.multipliers = found.multipliers;
  return out;
}

// The kernel's solution in the form of the dense one.
DenseSolution read_as_dense(const Simulation& s) {
  const KernelSolution found = read_solution(s);
  DenseSolution out;
  out.linear = found.linear;
  out.angular = found.angular;
  out.multipliers = found.multipliers;
  return out;
}

void print(const char* what, int count, double from_sweeps, double from_dense) {
  std::printf("%d %s from seed %llu: largest difference from the sweeps %.1e, from the dense solve %.1e\n", count, what,
              static_cast<unsigned long long>(kFirstSeed), from_sweeps, from_dense);
}

TEST(ScalarSolver, AgreesWithTheSweepsAndADenseSolveOnRandomTreesInAnyMode) {
  double from_sweeps = 0, from_dense = 0;
  constexpr int kSystems = 300;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kSystems; ++seed) {
    RandomModelOptions options;
    options.bodies = 1 + static_cast<int>(seed % 15);
    options.first_mode_chance = 0.4;
    Model model = build_random_model(seed, options);
    Random random(seed);
    const std::vector<Wrench> wrenches = add_random_loads(model, random);
    Simulation s(model);
    ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk) << "seed " << seed;
    const DenseSolution sweeps = read_as_dense(s);
    const KernelSolution scalar = solve_scalar(s);
    const double difference = compare(scalar, sweeps).get_worst();
    const double from_oracle = compare(scalar, solve_accelerations(model, read_state(s), wrenches)).get_worst();
    EXPECT_LT(difference, kAgreement) << "seed " << seed;
    EXPECT_LT(from_oracle, kAgreement) << "seed " << seed;
    from_sweeps = std::max(from_sweeps, difference);
    from_dense = std::max(from_dense, from_oracle);
  }
  print("random trees", kSystems, from_sweeps, from_dense);
}

TEST(ScalarSolver, AgreesWithTheSweepsAndADenseSolveOnLoops) {
  double from_sweeps = 0, from_dense = 0;
  int count = 0;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 200; ++seed) {
    RandomModelOptions options;
    options.bodies = 4 + static_cast<int>(seed % 9);
    Model model = build_random_model(seed, options);
    Random random(seed);
    const int bodies = static_cast<int>(model.bodies.size());
    for (int k = 1 + random.below(2); k > 0; --k) {
      const int base = random.below(bodies), follower = (base + 1 + random.below(bodies - 1)) % bodies;
      Joint joint = build_closing_joint(model, base, follower, random);
      joint.modes = {{"open", 0}, {"closed", random.below(2) == 0 ? kPointRows : row_bit(kX)}};
      model.joints.push_back(joint);
    }
    const std::vector<Wrench> wrenches = add_random_loads(model, random);
    Simulation s(model);
    for (std::size_t j = 0; j < model.joints.size(); ++j)
      if (model.joints[j].modes.size() == 2 && model.joints[j].modes[1].name == "closed") s.state.joints[j].mode = 1;
    const DenseSolution dense = solve_accelerations(model, read_state(s), wrenches);
    if (dense.redundant > 0 || dense.condition > kConditioned) continue;
    ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk) << "seed " << seed;
    const DenseSolution sweeps = read_as_dense(s);
    const KernelSolution scalar = solve_scalar(s);
    const double difference = compare(scalar, sweeps).get_worst(), from_oracle = compare(scalar, dense).get_worst();
    EXPECT_LT(difference, kLoopAgreement) << "seed " << seed << ", condition " << dense.condition;
    EXPECT_LT(from_oracle, kLoopAgreement) << "seed " << seed << ", condition " << dense.condition;
    from_sweeps = std::max(from_sweeps, difference);
    from_dense = std::max(from_dense, from_oracle);
    ++count;
  }
  EXPECT_GE(count, 50);
  print("systems with loops", count, from_sweeps, from_dense);
}

}  // namespace
}  // namespace unlatch::test::scalar_solver_test
