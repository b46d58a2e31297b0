// The tree solver against a dense solve of the same equations that knows nothing of trees.
#include "kernel/tree_solver.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "kernel/integrator.h"
#include "kernel/kinematics.h"
#include "kernel/rows.h"
#include "tests/support/dense_kkt.h"
#include "tests/support/random.h"
#include "tests/support/random_model.h"
#include "tests/support/simulation.h"

namespace unlatch::test {
namespace {

constexpr double kAgreement = 1e-10;       // relative to the largest of its kind, well-conditioned systems
constexpr double kPerMassRatio = 2.2e-16;  // per unit of the ratio of masses: one rounding in the heaviest body's row
constexpr int kSystems = 1500;
constexpr std::uint64_t kFirstSeed = 20031;

std::vector<Wrench> add_random_loads(Model& model, Random& random) {
  std::vector<Wrench> wrenches(model.bodies.size());
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    for (int k = 0; k < 3; ++k) {
      wrenches[b].force[k] = random.uniform(-30, 30);
      wrenches[b].torque[k] = random.uniform(-30, 30);
    }
    for (const bool torque : {false, true}) {
      Load load;
      load.name = (torque ? "torque" : "force") + std::to_string(b);
      load.body = static_cast<int>(b);
      load.kind = torque ? Load::Kind::kTorque : Load::Kind::kForce;
      load.frame = Load::Frame::kWorld;
      load.direction = torque ? wrenches[b].torque : wrenches[b].force;
      model.loads.push_back(load);
    }
  }
  return wrenches;
}

// Largest difference of any acceleration and of any multiplier, each relative to the largest of its kind, or to one
// unit where all are smaller, such as in a system that is welded to the ground.
double calc_disagreement(const Simulation& s, const DenseSolution& dense) {
  double a_error = 0, a_size = 1, l_error = 0, l_size = 1;
  for (std::size_t b = 0; b < dense.linear.size(); ++b) {
    const Spatial& a = s.workspace.accelerations[b];
    const Vec3 w = transpose_times(s.workspace.kinematics[b].R, a.ang);
    const double ours[6] = {a.lin.x, a.lin.y, a.lin.z, w.x, w.y, w.z};
    for (int k = 0; k < 6; ++k) {
      const double theirs = k < 3 ? dense.linear[b][k] : dense.angular[b][k - 3];
      a_error = std::max(a_error, std::abs(ours[k] - theirs));
      a_size = std::max(a_size, std::abs(theirs));
    }
  }
  for (std::size_t j = 0; j < dense.multipliers.size(); ++j)
    for (std::size_t r = 0; r < 6; ++r) {
      const double theirs = dense.multipliers[j][static_cast<int>(r)];
      l_error = std::max(l_error, std::abs(s.workspace.multipliers[6 * j + r] - theirs));
      l_size = std::max(l_size, std::abs(theirs));
    }
  return std::max(a_error / a_size, l_error / l_size);
}

TEST(TreeSolver, AgreesWithADenseSolveOnRandomSystems) {
  double worst = 0;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kSystems; ++seed) {
    RandomModelOptions options;
    options.bodies = seed % 10 == 0 ? 0 : 1 + static_cast<int>(seed % 17);  // mostly small: a dense solve costs n³
    Model model = build_random_model(seed, options);
    Random random(seed);
    const std::vector<Wrench> wrenches = add_random_loads(model, random);
    Simulation simulation(model);
    ASSERT_EQ(update_outputs(simulation.plan, {simulation.commands}, simulation.state, simulation.workspace),
              StepStatus::kOk)
        << "seed " << seed;
    const double error =
        calc_disagreement(simulation, solve_accelerations(model, build_initial_state(model), wrenches));
    EXPECT_LT(error, kAgreement) << "seed " << seed << ", " << model.bodies.size() << " bodies";
    worst = std::max(worst, error);
  }
  std::printf("%d random systems from seed %llu: worst disagreement %.2e\n", kSystems,
              static_cast<unsigned long long>(kFirstSeed), worst);
}

TEST(TreeSolver, AgreesForMassRatiosOfAHundredMillion) {
  double worst = 0;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 200; ++seed) {
    RandomModelOptions options;
    options.bodies = 2 + static_cast<int>(seed % 7);
    options.mass_ratio = 1e8;
    Model model = build_random_model(seed, options);
    Random random(seed);
    const std::vector<Wrench> wrenches = add_random_loads(model, random);
    Simulation simulation(model);
    ASSERT_EQ(update_outputs(simulation.plan, {simulation.commands}, simulation.state, simulation.workspace),
              StepStatus::kOk)
        << "seed " << seed;
    const double error =
        calc_disagreement(simulation, solve_accelerations(model, build_initial_state(model), wrenches));
    EXPECT_LT(error, std::max(kAgreement, kPerMassRatio * options.mass_ratio)) << "seed " << seed;
    worst = std::max(worst, error);
  }
  std::printf("mass ratios to 1e8: worst disagreement %.2e\n", worst);
}

TEST(TreeSolver, PlasticImpulsesAgreeWithADenseSolve) {
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 300; ++seed) {
    RandomModelOptions options;
    options.bodies = 1 + static_cast<int>(seed % 12);
    const Model model = build_random_model(seed, options);
    Simulation simulation(model);
    SystemState dense_state = build_initial_state(model);
    Random random(seed);
    for (std::size_t j = 0; j < model.joints.size();
         ++j) {  // any other mode: its rows meet a velocity they do not allow
      const int mode = random.below(static_cast<int>(model.joints[j].modes.size()));
      simulation.state.joints[j].mode = mode;
      dense_state.modes[j] = mode;
    }
    update_motion(simulation);
    ASSERT_EQ(apply_impulse(simulation.plan, simulation.state, simulation.workspace), kNone);
    EXPECT_LT(calc_disagreement(simulation, solve_plastic_impulse(model, dense_state)), kAgreement) << "seed " << seed;
  }
}

TEST(TreeSolver, TheChoiceOfRootDoesNotChangeTheSolution) {
  constexpr double kRounding = 1e-11;  // the same sums in another order
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    RandomModelOptions options;
    options.bodies = 12;
    options.grounded_chance = 0;
    options.first_mode_chance = 1;
    Model model = build_random_model(seed, options);
    Random random(seed);
    add_random_loads(model, random);
    Simulation first(model);
    ASSERT_EQ(update_outputs(first.plan, {first.commands}, first.state, first.workspace), StepStatus::kOk);
    for (int root = 0; root < 12; ++root) {
      PlanOptions plan_options;
      plan_options.root = root;
      Simulation other(model, plan_options);
      ASSERT_EQ(update_outputs(other.plan, {other.commands}, other.state, other.workspace), StepStatus::kOk);
      for (std::size_t b = 0; b < 12; ++b)
        EXPECT_LT(norm(other.workspace.accelerations[b].lin - first.workspace.accelerations[b].lin),
                  kRounding * (1 + norm(first.workspace.accelerations[b].lin)));
    }
  }
}

TEST(TreeSolver, PutsTheRootOfAChainInItsMiddle) {
  RandomModelOptions options;
  options.shape = RandomModelOptions::Shape::kChain;
  options.bodies = 9;
  options.grounded_chance = 0;
  const Plan plan = compile_or_throw(build_random_model(7, options), {});
  std::vector<int> depth(plan.nodes.size(), 0);
  for (std::size_t k = 1; k < plan.nodes.size(); ++k)
    if (plan.nodes[k].parent != kNone) depth[k] = depth[static_cast<std::size_t>(plan.nodes[k].parent)] + 1;
  EXPECT_EQ(*std::max_element(depth.begin(), depth.end()), 4);
}

}  // namespace
}  // namespace unlatch::test
