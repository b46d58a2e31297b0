// The tree solver against a dense solve of the same equations.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernel/dispatch/kernels.h"
#include "kernel/integration/integrator.h"
#include "kernel/joints/kinematics.h"
#include "tests/support/random_model.h"
#include "tests/support/solve_comparison.h"

namespace unlatch::test::tree_solver_test {
namespace {

constexpr double kAgreement = 1e-10;          // relative to the largest of its kind, well-conditioned systems
constexpr double kErrorPerCondition = 1e-15;  // some ten roundings along a tree of at most eight bodies
constexpr std::uint64_t kFirstSeed = 20031;

// Number of bodies: mostly small, since a dense solve costs n³.
int get_body_count(std::uint64_t seed) {
  return seed % 40 == 0 ? 18 + static_cast<int>(seed / 40 % 43) : 1 + static_cast<int>(seed % 17);
}

// One system: its accelerations and multipliers in the initial modes; then, with every joint switched to any of its
// modes, the impulse that closes their rows, and the accelerations after it.
struct Systems {
  Disagreement start, impulse, after;
  int count = 0;
};

void update_worst(Disagreement& worst, const Disagreement& d, const char* what, std::uint64_t seed) {
  EXPECT_LT(d.accelerations, kAgreement) << what << ", seed " << seed;
  EXPECT_LT(d.multipliers, kAgreement) << what << ", seed " << seed;
  worst.accelerations = std::max(worst.accelerations, d.accelerations);
  worst.multipliers = std::max(worst.multipliers, d.multipliers);
}

void expect_to_agree(std::uint64_t seed, Systems& worst) {
  RandomModelOptions options;
  options.bodies = get_body_count(seed);
  Model model = build_random_model(seed, options);
  Random random(seed);
  const std::vector<Wrench> wrenches = add_random_loads(model, random);
  Simulation s(model);
  const auto solve = [&] { return update_outputs(s.plan, {s.commands}, s.state, s.workspace); };
  ASSERT_EQ(solve(), StepStatus::kOk) << "seed " << seed;
  update_worst(worst.start, compare(read_solution(s), solve_accelerations(model, read_state(s), wrenches)), "start",
               seed);

  // Any other mode: the velocity violates its rows.
  for (std::size_t j = 0; j < model.joints.size(); ++j)
    s.state.joints[j].mode = random.below(static_cast<int>(model.joints[j].modes.size()));
  const SystemState before = read_state(s);
  update_motion(s);
  ASSERT_EQ(apply_impulse(s.data(), Source::kNothing, s.state, s.evaluation()), kNone) << "seed " << seed;
  update_worst(worst.impulse, compare(read_solution(s), solve_plastic_impulse(model, before)), "impulse", seed);

  ASSERT_EQ(solve(), StepStatus::kOk) << "seed " << seed;
  update_worst(worst.after, compare(read_solution(s), solve_accelerations(model, read_state(s), wrenches)),
               "after the impulse", seed);
  ++worst.count;
}

double calc_mass_ratio(const Model& model) {
  double least = HUGE_VAL, most = 0;
  for (const Body& body : model.bodies) {
    least = std::min(least, body.mass);
    most = std::max(most, body.mass);
  }
  return most / least;
}

void print(const char* what, const Disagreement& worst) {
  std::printf("  %s: %.1e, multipliers %.1e\n", what, worst.accelerations, worst.multipliers);
}

TEST(TreeSolver, AgreesWithADenseSolveOnRandomSystems) {
  Systems worst;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 2000; ++seed) expect_to_agree(seed, worst);
  std::printf("%d random systems from seed %llu, worst disagreement\n", worst.count,
              static_cast<unsigned long long>(kFirstSeed));
  print("accelerations at the start", worst.start);
  print("impulses when every joint switches", worst.impulse);
  print("accelerations after that", worst.after);
}

// With masses of all orders a heavy body's block, reduced by its joint's degrees of freedom, leaves one of its
// roundings in the block of a light neighbour: a unit of roundoff for each unit of the ratio of masses. Besides, the
// exact solution itself changes with the last digit of an input; the oracle gives the amount.
TEST(TreeSolver, ErrsForMassRatiosToAHundredMillionNoMoreThanTheirConditionDoes) {
  double worst = 0, worst_error = 0, worst_condition = 0;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 400; ++seed) {
    RandomModelOptions options;
    options.bodies = 2 + static_cast<int>(seed % 7);
    options.mass_ratio = std::pow(10, 2 + static_cast<double>(seed % 4) * 2);  // 1e2 … 1e8
    Model model = build_random_model(seed, options);
    Random random(seed);
    const std::vector<Wrench> wrenches = add_random_loads(model, random);
    Simulation s(model);
    ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk) << "seed " << seed;
    const SystemState state = read_state(s);
    const double error = compare(read_solution(s), solve_accelerations(model, state, wrenches)).get_worst();
    const double condition = calc_condition(model, state, wrenches, random) * calc_mass_ratio(model);
    EXPECT_LT(error, kErrorPerCondition * condition) << "seed " << seed << ", condition " << condition;
    worst = std::max(worst, error / condition);
    worst_error = std::max(worst_error, error);
    worst_condition = std::max(worst_condition, condition);
  }
  std::printf(
      "mass ratios to 1e8, 400 systems from seed %llu: worst error %.1e, conditions to %.1e, error at most %.1e "
      "of the condition\n",
      static_cast<unsigned long long>(kFirstSeed), worst_error, worst_condition, worst);
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
  const std::span<const TreeNode> tree = plan.get_tree();
  std::vector<int> depth(tree.size(), 0);
  for (std::size_t k = 1; k < tree.size(); ++k)
    if (tree[k].parent != kNone) depth[k] = depth[static_cast<std::size_t>(tree[k].parent)] + 1;
  EXPECT_EQ(*std::max_element(depth.begin(), depth.end()), 4);
}

}  // namespace
}  // namespace unlatch::test::tree_solver_test
