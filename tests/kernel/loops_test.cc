// Closed loops: against a dense solve, and mechanisms whose rows are redundant.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernel/dynamics/balance.h"
#include "kernel/integration/integrator.h"
#include "kernel/joints/kinematics.h"
#include "kernel/joints/residuals.h"
#include "tests/support/linkages.h"
#include "tests/support/random_model.h"
#include "tests/support/small_models.h"
#include "tests/support/solve_comparison.h"

namespace unlatch::test::loops_test {
namespace {

constexpr double kAgreement = 1e-10;  // relative to the largest of its kind, well-conditioned systems
// The small matrix of the loops' rows has the square of their condition: number of roundings for each unit of it.
constexpr double kPerSquaredCondition = 1e-14;
constexpr double kSingular = 1e4;        // condition of the rows
constexpr double kContradiction = 1e-9;  // m/s², rad/s²: rounding error of rows that have a solution
constexpr double kEnergy = 1e-6;         // relative, ten seconds at 1 ms
constexpr double kLoopDrift = 1e-10;     // m, rad

// One to three loops over a random tree, all of them open at first, so that any velocities fit.
Model build_random_loops(std::uint64_t seed, Random& random) {
  RandomModelOptions options;
  options.bodies = 3 + static_cast<int>(seed % 10);
  Model model = build_random_model(seed, options);
  const int count = static_cast<int>(model.bodies.size());
  for (int k = 1 + random.below(3); k > 0; --k) {
    const int base = random.below(count), follower = (base + 1 + random.below(count - 1)) % count;
    const RowSet kinds[] = {kPointRows, kRevoluteRows, kWeldRows, row_bit(kX),
                            static_cast<RowSet>(random.next() & kWeldRows)};
    Joint joint = build_closing_joint(model, base, follower, random);
    joint.modes = {{"open", 0}, {"closed", kinds[random.below(5)]}};
    model.joints.push_back(joint);
  }
  return model;
}

struct LoopTally {
  int regular = 0, redundant = 0, singular = 0, contradictory = 0;
  Disagreement worst, worst_redundant;
};

// With redundant rows the dense solve splits the multipliers differently, with the same effect on the bodies.
// (RedundantReactions.* compare the split.)
void expect_to_agree(const KernelSolution& ours, const DenseSolution& dense, const Model& model,
                     const SystemState& state, std::uint64_t seed, LoopTally& tally) {
  if (dense.condition > kSingular) {
    ++tally.singular;  // positions that are nearly singular belong to another test
    return;
  }
  if (dense.residual > kContradiction) {
    ++tally.contradictory;  // contradictory rows have no solution to agree on
    return;
  }
  const bool redundant = dense.redundant > 0;
  const Disagreement d =
      redundant ? compare_row_forces(ours, dense, build_dense_kkt(model, state)) : compare(ours, dense);
  const double bound = std::max(kAgreement, kPerSquaredCondition * dense.condition * dense.condition);
  EXPECT_LT(d.get_worst(), bound) << "seed " << seed << ", condition " << dense.condition << ", redundant "
                                  << dense.redundant;
  ++(redundant ? tally.redundant : tally.regular);
  Disagreement& worst = redundant ? tally.worst_redundant : tally.worst;
  worst.accelerations = std::max(worst.accelerations, d.accelerations);
  worst.multipliers = std::max(worst.multipliers, d.multipliers);
}

void print(const char* what, const LoopTally& tally) {
  std::printf(
      "  %s: %d regular (%.1e, multipliers %.1e), %d redundant (%.1e, forces of the rows %.1e), left out: %d nearly "
      "singular, %d contradictory\n",
      what, tally.regular, tally.worst.accelerations, tally.worst.multipliers, tally.redundant,
      tally.worst_redundant.accelerations, tally.worst_redundant.multipliers, tally.singular, tally.contradictory);
}

// The loops close at the start, with an impulse; after it the velocities satisfy all rows, redundant ones too.
TEST(Loops, AgreeWithADenseSolveOnRandomSystems) {
  constexpr std::uint64_t kFirstSeed = 500, kSystems = 1000;
  LoopTally impulses, accelerations;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kSystems; ++seed) {
    Random random(seed);
    Model model = build_random_loops(seed, random);
    const std::vector<Wrench> wrenches = add_random_loads(model, random);
    Simulation s(model);
    for (std::size_t j = 0; j < model.joints.size(); ++j)
      if (model.joints[j].modes.back().name == "closed") s.state.joints[j].mode = 1;
    const SystemState before = read_state(s);
    update_motion(s);
    ASSERT_EQ(apply_impulse(s.data(), Source::kNothing, s.state, s.evaluation()), kNone) << "seed " << seed;
    expect_to_agree(read_solution(s), solve_plastic_impulse(model, before), model, before, seed, impulses);

    ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk) << "seed " << seed;
    const SystemState after = read_state(s);
    expect_to_agree(read_solution(s), solve_accelerations(model, after, wrenches), model, after, seed, accelerations);
  }
  std::printf("%d random systems with loops from seed %d, worst disagreement\n", static_cast<int>(kSystems),
              static_cast<int>(kFirstSeed));
  print("impulses", impulses);
  print("accelerations", accelerations);
  for (const LoopTally& tally : {impulses, accelerations}) {
    EXPECT_GT(tally.regular, 300);  // small trees with welds often leave no row for a loop; the others count
    EXPECT_GT(tally.redundant, 100);
    EXPECT_LT(tally.singular, 100);
  }
}

// Up to eighteen rows, so that columns fill packs of every width and leave some over.
TEST(Loops, EveryWidthOfLanesGivesTheSameBits) {
  constexpr std::uint64_t kFirstSeed = 900;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 200; ++seed) {
    Random random(seed);
    const Model model = build_random_loops(seed, random);
    const auto run = [&](InstructionSet set) {
      PlanOptions options;
      options.instruction_set = set;
      Simulation s(model, options);
      for (std::size_t j = 0; j < model.joints.size(); ++j)
        if (model.joints[j].modes.back().name == "closed") s.state.joints[j].mode = 1;
      update_motion(s);
      EXPECT_EQ(apply_impulse(s.data(), Source::kNothing, s.state, s.evaluation()), kNone) << "seed " << seed;
      for (int tick = 0; tick < 3; ++tick) s.advance();
      return calc_hash(s.state);
    };
    const std::uint64_t scalar = run(InstructionSet::kScalar);
    for (const InstructionSet set : {InstructionSet::k128, InstructionSet::k256, InstructionSet::k512}) {
      if (!is_supported(set)) continue;
      ASSERT_EQ(run(set), scalar) << get_name(set) << " seed " << seed;
    }
  }
}

// The loop closes a connection that the tree already holds: the remainder of its rows is rounding, which must not count
// as a row.
TEST(Loops, ThatCloseNothingAreRedundantAndChangeNothing) {
  constexpr double kRounding = 1e-12;
  Random random(3);
  Model model;
  model.gravity.uniform = {1, 2, -9.81};
  for (int k = 0; k < 3; ++k) {
    Body rod = box("rod" + std::to_string(k), 1 + k, 0.1, 0.2, 0.25);
    rod.p_WB = {0.7 * k, 0.1 * k, 0.3};
    rod.q_WB = Eigen::Quaterniond(1, random.uniform(), random.uniform(), random.uniform()).normalized();
    model.bodies.push_back(rod);
  }
  const auto weld = [&](int base, int follower) {
    Joint joint = build_closing_joint(model, base, follower, random);
    joint.modes = {{"closed", kWeldRows}};
    model.joints.push_back(joint);
  };
  weld(0, 1);
  weld(1, 2);
  const auto solve = [&](const Model& m) {
    Simulation s(m);
    EXPECT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
    EXPECT_EQ(s.evaluation().loop_redundant, m.joints.size() == 2 ? 0 : 6);
    return read_solution(s);
  };
  const KernelSolution open = solve(model);
  weld(2, 0);
  const KernelSolution closed = solve(model);
  for (std::size_t b = 0; b < 3; ++b) {
    EXPECT_LT((closed.linear[b] - open.linear[b]).norm(), kRounding);
    EXPECT_LT((closed.angular[b] - open.angular[b]).norm(), kRounding);
  }
  for (const auto& multipliers : closed.multipliers) EXPECT_GT(multipliers.norm(), 0);  // each weld has its share
}

// Rods in a zigzag from the origin, each on a hinge about another axis, the first on the ground; the tip is held to the
// ground by a weld, first of the joints, that may or may not be released.
Model build_held_chain(int rods, bool may_let_go) {
  Model model;
  model.gravity.uniform = {0, 0, -9.81};
  Random random(7);
  Eigen::Vector3d tip(0, 0, 0);
  for (int k = 0; k < rods; ++k) {
    Body rod = box("rod" + std::to_string(k), 1, 0.01, 0.1, 0.1);
    rod.q_WB = Eigen::AngleAxisd(k % 2 == 0 ? 0.9 : -0.9, Eigen::Vector3d::UnitY());
    const Eigen::Vector3d half = rod.q_WB * Eigen::Vector3d(0.5, 0, 0);
    rod.p_WB = tip + half;
    tip += 2 * half;
    model.bodies.push_back(rod);
  }
  Joint weld;
  weld.name = "weld";
  weld.follower = rods - 1;
  weld.point_base = tip;
  weld.point_follower = {0.5, 0, 0};
  if (may_let_go)
    weld.modes = {{"held", kWeldRows}, {"free", 0}};
  else
    weld.modes = {{"held", kWeldRows}};
  model.joints.push_back(weld);
  for (int k = 0; k < rods; ++k) {
    Joint hinge;
    hinge.name = "hinge" + std::to_string(k);
    hinge.base = k == 0 ? kGround : k - 1;
    hinge.follower = k;
    hinge.point_base = {k == 0 ? 0 : 0.5, 0, 0};
    hinge.point_follower = {-0.5, 0, 0};
    const Eigen::Quaterniond turn(1, random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    hinge.axes = turn.normalized().toRotationMatrix();
    hinge.modes = {{"hinged", kRevoluteRows}};
    model.joints.push_back(hinge);
  }
  return model;
}

TEST(Loops, AreCutWhereTheWaysFromTheGroundMeet) {
  const Simulation s(build_held_chain(64, false));
  ASSERT_EQ(s.data().loops.size(), 1u);
  const PlanJoint& cut = s.data().joints[static_cast<std::size_t>(s.data().loops[0])];
  EXPECT_EQ(cut.base, 31);  // the weld and the 32 hinges next to it hold the one tree, the others the other
  EXPECT_EQ(cut.follower, 32);
  const auto roots = std::count_if(s.data().nodes.begin(), s.data().nodes.end(),
                                   [](const TreeNode& node) { return node.parent == kNone; });
  EXPECT_EQ(roots, 2);
}

TEST(Loops, AreCutAtAJointThatMayLetGo) {
  const Simulation s(build_held_chain(64, true));
  EXPECT_EQ(s.list_loops(), std::vector<std::int32_t>{0});
}

// A ring that hangs from the ground. The weld's rows hold at the end of the step, not at its beginning.
TEST(Loops, AWeldThatClosesOneDoesNotDrift) {
  Model model = build_held_chain(12, true);
  const Body& first = model.bodies[0];
  model.joints[0].base = 0;
  model.joints[0].point_base = first.q_WB.conjugate() * (model.joints[0].point_base - first.p_WB);
  Simulation s(model, {.dt = 0.01});
  double drift = 0, fastest = 0;
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(s.advance().status, StepStatus::kOk) << "tick " << i;
    update_motion(s);
    drift = std::max(drift, calc_drift(s.data(), s.state, s.evaluation()));
    for (const BodyState& b : s.state.bodies) fastest = std::max(fastest, norm(b.w));
  }
  std::printf("loop closed to %.1e, fastest %.2g rad/s\n", drift, fastest);
  EXPECT_GT(fastest, 1);
  EXPECT_LT(drift, 5e-9);  // 9.8e-9 with the attitudes of the step's beginning
}

void expect_to_swing_freely(const Model& model, int redundant) {
  Simulation s(model);
  const auto energy = [&] {
    update_motion(s);
    double potential = 0;
    for (const BodyState& b : s.state.bodies) potential -= dot(s.data().gravity.uniform, b.p);
    return calc_balance(s.data(), s.state, s.evaluation()).kinetic + potential;
  };
  const double before = energy();
  double highest_kinetic = 0, drift = 0, loss = 0;
  for (int i = 0; i < 10000; ++i) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk) << "tick " << i;
    ASSERT_EQ(report.redundant, redundant) << "tick " << i;
    drift = std::max(drift, calc_drift(s.data(), s.state, s.evaluation()));
    loss = std::max(loss, std::abs(energy() - before));
    highest_kinetic = std::max(highest_kinetic, calc_balance(s.data(), s.state, s.evaluation()).kinetic);
  }
  EXPECT_GT(highest_kinetic, 1);
  EXPECT_LT(loss, kEnergy * highest_kinetic);
  EXPECT_LT(drift, kLoopDrift);
  std::printf("energy kept to %.1e of %.3g J, loop closed to %.1e\n", loss / highest_kinetic, highest_kinetic, drift);
}

// A crank and rocker: the crank makes full turns, without a flat position in which the linkage could branch.
TEST(Loops, APlanarFourBarInSpaceHasThreeRedundantRows) {
  const Eigen::Vector3d z(0, 0, 1);
  expect_to_swing_freely(
      build_linkage({{0, 0, 0}, {0.2, 0.7, 0}, {1.9, 1.5, 0}, {2, 0, 0}}, {z, z, z, z}, {0, -9.81, 0}), 3);
}

// Six hinges on the edges of a cube (problem A03 of the IFToMM benchmark library is this linkage): mobile, though
// Grübler's count says it is not.
TEST(Loops, ABricardLinkageMovesAndKeepsItsEnergy) {
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  expect_to_swing_freely(build_linkage({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1}, {0, 0, 1}},
                                       {y, z, x, y, z, x}, {0, -9.81, 0}),
                         1);
}

// Four hinges whose axes neither meet nor are parallel, but which move (Bennett 1903): opposite rods are equal, and
// their lengths have the ratio of the sines of the twists between their hinges. The angle of the first hinge determines
// that of the second: tan(θ1/2) tan(θ2/2) = sin((β + α)/2) / sin((β − α)/2); the others are the same with opposite
// signs.
TEST(Loops, ABennettLinkageIsASpatialFourBarWithThreeRedundantRows) {
  const double alpha = 0.7, beta = 1.4, length = 1, other = std::sin(beta) / std::sin(alpha);
  const double first = 1.2;
  const double second =
      2 * std::atan(std::sin((beta + alpha) / 2) / std::sin((beta - alpha) / 2) / std::tan(first / 2));
  const double angles[] = {first, second, -first, -second};
  std::vector<Eigen::Vector3d> points, axes;
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  for (int k = 0; k < 4; ++k) {
    points.push_back(frame.translation());
    axes.push_back(frame.linear().col(2));
    frame = frame * Eigen::AngleAxisd(angles[k], Eigen::Vector3d::UnitZ()) *
            Eigen::Translation3d(k % 2 == 0 ? length : other, 0, 0) *
            Eigen::AngleAxisd(k % 2 == 0 ? alpha : beta, Eigen::Vector3d::UnitX());
  }
  ASSERT_TRUE(frame.isApprox(Eigen::Isometry3d::Identity(), 1e-12));
  expect_to_swing_freely(build_linkage(points, axes, {3, -9.81, 2}), 3);
}

}  // namespace
}  // namespace unlatch::test::loops_test
