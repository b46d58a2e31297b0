// Reactions of redundant rows: shared by stiffness, against a dense pseudo-inverse and closed forms.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "kernel/dispatch/kernels.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/linkages.h"
#include "tests/support/malloc_guard.h"
#include "tests/support/random_model.h"
#include "tests/support/small_models.h"
#include "tests/support/solve_comparison.h"
#include "unlatch/redundancy.h"

namespace unlatch::test::redundant_test {
namespace {

constexpr double kRounding = 1e-12;      // relative
constexpr double kAgreement = 1e-9;      // relative to the largest multiplier, condition below kSingular
constexpr double kSingular = 1e3;        // condition of the rows; Λ has the square of it
constexpr double kContradiction = 1e-9;  // m/s², rad/s²

using Six = Eigen::Matrix<double, 6, 1>;

double get_multiplier(const Simulation& s, std::size_t joint, int row) {
  return s.workspace.multipliers[joint * kRows + static_cast<std::size_t>(row)];
}

void solve(Simulation& s) { ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk); }

// Multipliers of the independent rows alone, 0 for the others: as solved, without the split.
void solve_unsplit(Simulation& s) {
  const Inputs inputs{s.commands};
  update_forces({s.data(), inputs, s.state, s.get_time()}, s.evaluation());
  get_kernels(s.data()).solve(s.data(), s.evaluation(), {});
}

Load push(const std::string& name, int body, Load::Kind kind, const Eigen::Vector3d& direction) {
  Load load;
  load.name = name;
  load.body = body;
  load.kind = kind;
  load.frame = Load::Frame::kWorld;
  load.direction = direction;
  return load;
}

// --- Against a pseudo-inverse ---------------------------------------------------------------------------------------

Joint build_closed_joint(const Model& model, int base, int follower, RowSet rows, Random& random) {
  Joint joint = build_closing_joint(model, base, follower, random);
  joint.axes = Eigen::Quaterniond(1, random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1))
                   .normalized()
                   .toRotationMatrix();
  joint.modes = {{"closed", rows}};
  return joint;
}

// A random tree at rest, one to four loops, stiffnesses of all joints.
Model build_random_mesh(std::uint64_t seed, Random& random) {
  RandomModelOptions options;
  options.bodies = 2 + static_cast<int>(seed % 7);
  Model model = build_random_model(seed, options);
  for (Body& body : model.bodies) body.v_WB = body.w_WB_B = {0, 0, 0};
  const int count = static_cast<int>(model.bodies.size());
  for (int k = 1 + random.below(4); k > 0; --k) {
    const int base = random.below(count), follower = (base + 1 + random.below(count - 1)) % count;
    const RowSet kinds[] = {kPointRows, kRevoluteRows, kWeldRows, static_cast<RowSet>(1 + random.below(kWeldRows))};
    model.joints.push_back(build_closed_joint(model, base, follower, kinds[random.below(4)], random));
  }
  for (Joint& joint : model.joints) {
    joint.share = random.uniform(0.2, 5);
    joint.share_length = random.uniform(0.05, 2);
  }
  return model;
}

// Multipliers of least Σ λ² / k among all with the effect of `some`; by a rank-revealing factorisation of Gᵀ √k.
std::vector<Six> calc_least(const Model& model, const DenseKkt& kkt, const std::vector<Six>& some) {
  const Eigen::Index rows = kkt.rows.rows();
  Eigen::VectorXd scale(rows), lambda(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const DenseKkt::RowName& name = kkt.names[static_cast<std::size_t>(k)];
    const auto j = static_cast<std::size_t>(name.joint);
    const Joint& joint = model.joints[j];
    scale[k] = std::sqrt(joint.share) * (name.row < kRotX ? 1 : joint.share_length.value());
    lambda[k] = some[j][name.row];
  }
  const Eigen::MatrixXd G = kkt.rows.cast<double>();
  const Eigen::MatrixXd weighted = G.transpose() * scale.asDiagonal();
  const Eigen::VectorXd least = scale.asDiagonal() * solve_least_norm(weighted, G.transpose() * lambda);
  std::vector<Six> all(model.joints.size(), Six::Zero());
  for (Eigen::Index k = 0; k < rows; ++k) {
    const DenseKkt::RowName& name = kkt.names[static_cast<std::size_t>(k)];
    all[static_cast<std::size_t>(name.joint)][name.row] = least[k];
  }
  return all;
}

TEST(RedundantReactions, AreThoseOfLeastEnergyOnRandomSystems) {
  int compared = 0, by_shares = 0, singular = 0;
  double worst = 0, unsplit = 0;
  for (std::uint64_t seed = 0; seed < 1500; ++seed) {
    Random random(seed);
    Model model = build_random_mesh(seed, random);
    const std::vector<Wrench> wrenches = add_random_loads(model, random);
    Simulation s(model);
    solve(s);
    const SystemState state = read_state(s);
    const DenseSolution dense = solve_accelerations(model, state, wrenches);
    const int redundant = s.evaluation().loop_redundant;
    if (dense.redundant == 0) {
      EXPECT_EQ(redundant, 0) << "seed " << seed;
      continue;
    }
    if (dense.condition > kSingular || dense.residual > kContradiction) {
      ++singular;
      continue;
    }
    ASSERT_EQ(redundant, dense.redundant) << "seed " << seed;
    const DenseKkt kkt = build_dense_kkt(model, state);
    const std::vector<Six> least = calc_least(model, kkt, dense.multipliers);
    const std::vector<Six> ours = read_solution(s).multipliers;
    double largest = 1;
    for (const Six& six : least) largest = std::max(largest, six.cwiseAbs().maxCoeff());
    double difference = 0;
    for (std::size_t j = 0; j < least.size(); ++j)
      difference = std::max(difference, (ours[j] - least[j]).cwiseAbs().maxCoeff() / largest);
    EXPECT_LT(difference, kAgreement) << "seed " << seed << ", condition " << dense.condition << ", redundant "
                                      << redundant << " of " << kkt.rows.rows();
    worst = std::max(worst, difference);
    solve_unsplit(s);
    const std::vector<Six> basic = read_solution(s).multipliers;
    for (std::size_t j = 0; j < least.size(); ++j)
      unsplit = std::max(unsplit, (basic[j] - least[j]).cwiseAbs().maxCoeff() / largest);
    ++compared;
    by_shares += 2 * redundant <= s.evaluation().loop_count ? 1 : 0;
  }
  std::printf("%d systems with redundant rows: worst %.1e; without the split %.2g; left out %d nearly singular\n",
              compared, worst, unsplit, singular);
  EXPECT_GT(compared, 400);
  EXPECT_GT(by_shares, 50);
  EXPECT_GT(unsplit, 0.1);
}

// --- Bolts on a circle
// -------------------------------------------------------------------------------------------------

constexpr int kBolts = 8;
constexpr double kRadius = 0.4;  // m

// A plate in the plane z = 0, held to the ground, or to another plate of twice its mass, by bolts on a circle.
Model build_plate(RowSet rows, bool grounded) {
  Model model;
  model.bodies.push_back(box("plate", 10, 0.5, 0.6, 0.9));
  model.bodies[0].p_WB = {0, 0, 0.2};
  if (!grounded) {
    model.bodies.push_back(box("other", 20, 1.1, 0.9, 1.3));
    model.bodies[1].p_WB = {0.1, 0, -0.3};
  }
  for (int k = 0; k < kBolts; ++k) {
    Joint bolt;
    bolt.name = "bolt" + std::to_string(k);
    const double angle = 2 * M_PI * k / kBolts;
    const Eigen::Vector3d point(kRadius * std::cos(angle), kRadius * std::sin(angle), 0);
    bolt.base = grounded ? kGround : 1;
    bolt.follower = 0;
    bolt.point_base = point - (grounded ? Eigen::Vector3d(0, 0, 0) : model.bodies[1].p_WB);
    bolt.point_follower = point - model.bodies[0].p_WB;
    bolt.modes = {{"held", rows}, {"free", 0}};
    model.joints.push_back(bolt);
  }
  return model;
}

constexpr double kForce = -1000, kMoment = 120;  // N along z, N m about x

void load_plate(Model& model) {
  model.loads.push_back(push("force", 0, Load::Kind::kForce, {0, 0, kForce}));
  model.loads.push_back(push("moment", 0, Load::Kind::kTorque, {kMoment, 0, 0}));
}

double get_height(const Model& model, std::size_t bolt) {  // y, the arm of its force about x
  return model.joints[bolt].point_follower.y();
}

// F = P / n + M y / Σ y²
TEST(RedundantReactions, OfEightBoltsUnderForceAndMomentAreThoseOfTheBoltCircle) {
  Model model = build_plate(row_bit(kZ), true);
  load_plate(model);
  Simulation s(model);
  solve(s);
  EXPECT_EQ(s.evaluation().loop_redundant, kBolts - 3);
  for (std::size_t k = 0; k < kBolts; ++k) {
    const double expected = -kForce / kBolts - kMoment * get_height(model, k) / (0.5 * kBolts * kRadius * kRadius);
    EXPECT_NEAR(get_multiplier(s, k, kZ), expected, kRounding * std::abs(kForce)) << k;
  }
}

// Bolts that also bear moments, by a tenth of the circle's radius: forces and moments share the load as R²/2 to L².
TEST(RedundantReactions, OfEightWeldedBoltsGiveMomentsTheirPartByTheLength) {
  Model model = build_plate(kWeldRows, true);
  load_plate(model);
  Simulation s(model);
  solve(s);
  EXPECT_EQ(s.evaluation().loop_redundant, 6 * kBolts - 6);
  const double length = 0.1 * kRadius, stiffness = kBolts * (0.5 * kRadius * kRadius + length * length);
  for (std::size_t k = 0; k < kBolts; ++k) {
    EXPECT_NEAR(get_multiplier(s, k, kZ), -kForce / kBolts - kMoment * get_height(model, k) / stiffness,
                kRounding * std::abs(kForce));
    EXPECT_NEAR(get_multiplier(s, k, kRotX), -kMoment * length * length / stiffness, kRounding * std::abs(kForce));
    for (const int none : {kX, kY, kRotY, kRotZ})
      EXPECT_NEAR(get_multiplier(s, k, none), 0, kRounding * std::abs(kForce));
  }
}

TEST(RedundantReactions, FollowTheStatedShares) {
  Model model = build_plate(row_bit(kZ), true);
  model.loads.push_back(push("force", 0, Load::Kind::kForce, {0, 0, kForce}));
  for (std::size_t k = 0; k < kBolts; k += 2) model.joints[k].share = 3;
  Simulation s(model);
  solve(s);
  for (std::size_t k = 0; k < kBolts; ++k)
    EXPECT_NEAR(get_multiplier(s, k, kZ), -kForce * (k % 2 == 0 ? 3 : 1) / (2.0 * kBolts),
                kRounding * std::abs(kForce));
}

// Four points of a rectangle, the load off its centre: the pseudo-inverse of three balances.
TEST(RedundantReactions, OfAPlateOnFourPointsAreThoseOfThePseudoInverse) {
  const Eigen::Vector2d points[] = {{0, 0}, {2, 0}, {1.7, 1.1}, {0, 1}};
  Model model;
  model.bodies.push_back(box("plate", 30, 2, 3, 4));
  model.bodies[0].p_WB = {0.6, 0.2, 0};
  model.gravity.uniform = {0, 0, -10};
  Eigen::Matrix<double, 3, 4> balance;
  for (int k = 0; k < 4; ++k) {
    Joint foot;
    foot.name = "foot" + std::to_string(k);
    foot.follower = 0;
    foot.point_base = {points[k].x(), points[k].y(), 0};
    foot.point_follower = foot.point_base - model.bodies[0].p_WB;
    foot.modes = {{"held", row_bit(kZ)}};
    model.joints.push_back(foot);
    balance.col(k) << 1, foot.point_follower.y(), -foot.point_follower.x();
  }
  Simulation s(model);
  solve(s);
  const Eigen::VectorXd expected = solve_least_norm(balance, Eigen::Vector3d(300, 0, 0));
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(get_multiplier(s, k, kZ), expected[static_cast<Eigen::Index>(k)], kRounding * 300);
}

// --- Steadiness
// ----------------------------------------------------------------------------------------------------------

// Two plates that tumble, one pushed by a harmonic force.
Model build_tumbling_plates() {
  Model model = build_plate(kPointRows, false);
  const Eigen::Vector3d w(0.7, -1.1, 0.9);
  for (Body& body : model.bodies) {
    body.w_WB_B = w;
    body.v_WB = w.cross(body.p_WB);
  }
  Load load = push("shake", 0, Load::Kind::kForce, {30, -20, 70});
  load.point = {0.1, 0.2, 0};
  load.profile.kind = Profile::Kind::kHarmonic;
  load.profile.harmonics = {{1, 6, 0.4}};
  model.loads.push_back(load);
  return model;
}

// Multipliers with the effect of the simulation's, of as few rows as possible: those that a factorisation with pivots
// takes for independent, which of equal bolts rounding decides.
std::vector<double> calc_basic(const Model& model, Simulation& s) {
  const DenseKkt kkt = build_dense_kkt(model, read_state(s));
  const Eigen::MatrixXd across = kkt.rows.cast<double>().transpose();
  Eigen::VectorXd lambda(across.cols());
  const auto place = [&](Eigen::Index k) {
    const DenseKkt::RowName& name = kkt.names[static_cast<std::size_t>(k)];
    return static_cast<std::size_t>(name.joint * kRows + name.row);
  };
  for (Eigen::Index k = 0; k < lambda.size(); ++k) lambda[k] = s.workspace.multipliers[place(k)];
  const Eigen::VectorXd basic = solve_least_squares(across, across * lambda);
  std::vector<double> all(model.joints.size() * kRows, 0);
  for (Eigen::Index k = 0; k < basic.size(); ++k) all[place(k)] = basic[k];
  return all;
}

// The force oscillates at 6 rad/s and the plates turn at ω, with ω² in their own load: no share changes faster than (6
// + 2 ω)² of the largest.
TEST(RedundantReactions, DoNotChatterAlongASmoothMotion) {
  const Model model = build_tumbling_plates();
  Simulation s(model);
  const double dt = s.plan.get_options().dt;
  double turning = 0;
  constexpr std::size_t kAll = kBolts * kRows;
  std::vector<double> before(kAll), last(kAll);
  double bend = 0, largest = 0, basic_bend = 0;
  std::vector<double> basic_before(kAll), basic_last(kAll);
  for (int i = 0; i < 2000; ++i) {
    ASSERT_EQ(s.advance().redundant, 3 * kBolts - 6);
    turning = std::max(turning, norm(s.state.bodies[0].w));
    std::vector<double> now(kAll), basic(kAll);
    for (std::size_t k = 0; k < kAll; ++k) now[k] = s.workspace.multipliers[k];
    basic = calc_basic(model, s);
    for (std::size_t k = 0; k < kAll && i >= 2; ++k) {
      largest = std::max(largest, std::abs(now[k]));
      bend = std::max(bend, std::abs(now[k] - 2 * last[k] + before[k]));
      basic_bend = std::max(basic_bend, std::abs(basic[k] - 2 * basic_last[k] + basic_before[k]));
    }
    before = last, last = now, basic_before = basic_last, basic_last = basic;
  }
  const double fastest = 6 + 2 * turning;
  std::printf("largest %.4g N, second difference %.2g N, of a basic solution %.2g N\n", largest, bend, basic_bend);
  EXPECT_LT(bend, fastest * fastest * dt * dt * largest);
  EXPECT_GT(basic_bend, 100 * bend);
}

// Another root and another order of the joints: other rows are found redundant.
TEST(RedundantReactions, DoNotDependOnWhichRowsAreFoundRedundant) {
  const Model model = build_tumbling_plates();
  Model turned = model;
  std::rotate(turned.joints.begin(), turned.joints.begin() + 3, turned.joints.end());
  Simulation s(model, {.root = 0}), t(turned, {.root = 1});
  double largest = 0, difference = 0;
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(s.advance().status, StepStatus::kOk);
    ASSERT_EQ(t.advance().status, StepStatus::kOk);
    for (std::size_t k = 0; k < kBolts; ++k)
      for (int r = 0; r < 3; ++r) {
        largest = std::max(largest, std::abs(get_multiplier(s, (k + 3) % kBolts, r)));
        difference = std::max(difference, std::abs(get_multiplier(s, (k + 3) % kBolts, r) - get_multiplier(t, k, r)));
      }
  }
  EXPECT_LT(difference, kAgreement * largest);
}

// --- In the step
// -------------------------------------------------------------------------------------------------------

// A force that grows by 1 kN/s on eight bolts, each of which breaks at a load of 100 N: all at 0.8 s.
Model build_breaking_bolts() {
  Model model = build_plate(kPointRows, true);
  Load load = push("pull", 0, Load::Kind::kForce, {0, 0, -1});
  load.profile.kind = Profile::Kind::kTable;
  load.profile.times = {0, 10};
  load.profile.values = {0, 10000};
  model.loads.push_back(load);
  for (int k = 0; k < kBolts; ++k) {
    Event breaks{"break" + std::to_string(k), "", when(Condition::Kind::kReaction, k, kZ, 100), 0, {}, false};
    breaks.then = {act_set_mode(k, 1)};
    model.events.push_back(breaks);
  }
  return model;
}

TEST(RedundantReactions, BreakEqualBoltsAtOnce) {
  Simulation s(build_breaking_bolts());
  std::vector<double> times;
  for (int i = 0; i < 1000; ++i)
    for (const FiredEvent& fired : s.advance().events) times.push_back(fired.time);
  ASSERT_EQ(times.size(), static_cast<std::size_t>(kBolts));
  for (const double time : times) EXPECT_NEAR(time, 0.8, 1e-6);
}

TEST(RedundantReactions, HaveTheSameBitsInEveryWidthOfLanes) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(seed);
    Model model = build_random_mesh(seed, random);
    add_random_loads(model, random);
    const auto run = [&](InstructionSet set) {
      PlanOptions options;
      options.instruction_set = set;
      Simulation s(model, options);
      solve(s);
      std::vector<double> all;
      for (std::size_t i = 0; i < s.workspace.multipliers.size(); ++i) all.push_back(s.workspace.multipliers[i]);
      return all;
    };
    const std::vector<double> scalar = run(InstructionSet::kScalar);
    for (const InstructionSet set : {InstructionSet::k128, InstructionSet::k256, InstructionSet::k512}) {
      if (!is_supported(set)) continue;
      ASSERT_EQ(run(set), scalar) << get_name(set) << " seed " << seed;
    }
  }
}

TEST(RedundantReactions, TakeNothingFromTheHeap) {
  if (!kCountsAllocations) GTEST_SKIP() << "this build's sanitizer owns malloc";
  Simulation s(build_breaking_bolts());
  const AllocationCount count;
  for (int i = 0; i < 900; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  EXPECT_EQ(count.get(), 0);
}

TEST(RedundantReactions, AreListedByTheJointsThatShareThem) {
  Model model = build_plate(row_bit(kZ), true);
  Body arm = box("arm", 1, 1, 1, 1);
  arm.p_WB = {0, 0, 1.2};
  model.bodies.push_back(arm);
  Joint hinge;  // not part of a loop
  hinge.name = "hinge";
  hinge.base = 0;
  hinge.follower = 1;
  hinge.point_base = {0, 0, 0.5};
  hinge.point_follower = {0, 0, -0.5};
  hinge.modes = {{"hinge", kRevoluteRows}};
  model.joints.push_back(hinge);
  model.joints[2].mode = 1;  // free
  Simulation s(model);
  solve(s);
  const std::vector<RedundantRows> listed = list_redundant_rows(s.plan, s.state, s.workspace);
  ASSERT_EQ(listed.size(), 1u);
  EXPECT_EQ(listed[0].joints, (std::vector<std::int32_t>{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(listed[0].rows, 7);
  EXPECT_EQ(listed[0].redundant, 4);
  for (const std::size_t k : {0u, 1u, 3u, 4u}) s.state.joints[k].mode = 1;
  solve(s);
  EXPECT_TRUE(list_redundant_rows(s.plan, s.state, s.workspace).empty());
}

// --- Through a flexible body
// ---------------------------------------------------------------------------------------------

// A beam of two modes welded to a bus at both its ends: two of six rows bend it, the others are redundant. The part
// that the split adds to the multipliers causes no motion: applied to the free bodies, it leaves all at rest.
TEST(RedundantReactions, PassThroughFlexibleBodiesInBalance) {
  Model model;
  model.bodies.push_back(box("bus", 50, 4, 5, 6));
  Body beam = box("beam", 3, 0.2, 0.9, 0.9);
  beam.p_WB = {0, 0, 1};
  FlexibleBody flexible;
  flexible.frequencies = Eigen::Vector2d(20, 31);
  flexible.damping = Eigen::Vector2d(0.01, 0.01);
  flexible.momentum = Eigen::Matrix3Xd::Zero(3, 2);
  flexible.first = {Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
  flexible.second.assign(4, Eigen::Matrix3d::Zero());
  flexible.second[0](2, 2) = flexible.second[3](1, 1) = 1;
  beam.flexible = flexible;
  model.bodies.push_back(beam);
  for (const double x : {-1.0, 1.0}) {
    Body end;
    end.name = x < 0 ? "left" : "right";
    Marker marker{1, {x, 0, 0}, Eigen::Matrix3Xd(3, 2), Eigen::Matrix3Xd(3, 2)};
    marker.shape << 0, 0, 0, 0.3 * x, 0.4 * x * x, 0;
    marker.turn << 0, 0, -0.5 * x, 0.1, 0.2, 0.35;
    end.marker = marker;
    model.bodies.push_back(end);
    Joint weld;
    weld.name = "weld " + end.name;
    weld.base = x < 0 ? 0 : static_cast<int>(model.bodies.size()) - 1;
    weld.follower = x < 0 ? static_cast<int>(model.bodies.size()) - 1 : 0;
    (x < 0 ? weld.point_base : weld.point_follower) = {x, 0, 1};
    weld.modes = {{"held", kWeldRows}, {"free", 0}};
    model.joints.push_back(weld);
  }
  model.loads.push_back(push("push", 0, Load::Kind::kForce, {30, -20, 70}));
  model.loads.push_back(push("turn", 0, Load::Kind::kTorque, {11, 7, -5}));
  Simulation s(model);
  solve(s);
  ASSERT_EQ(s.evaluation().loop_redundant, 4);
  std::vector<Six> split(2), basic(2);
  const auto read_multipliers = [&](std::vector<Six>& to) {
    for (std::size_t j = 0; j < 2; ++j)
      for (int r = 0; r < kRows; ++r) to[j][r] = get_multiplier(s, j, r);
  };
  read_multipliers(split);
  solve_unsplit(s);
  read_multipliers(basic);
  EXPECT_GT((split[0] - basic[0]).norm(), 1);

  Model loose = model;
  loose.loads.clear();
  for (std::size_t j = 0; j < 2; ++j) {
    Joint& joint = loose.joints[j];
    joint.mode = 1;
    const Six added = split[j] - basic[j];
    for (const bool on_follower : {true, false}) {
      const int body = on_follower ? joint.follower : joint.base;
      const double side = on_follower ? 1 : -1;
      Load force = push("force" + std::to_string(loose.loads.size()), body, Load::Kind::kForce, side * added.head<3>());
      force.point = on_follower ? joint.point_follower : joint.point_base;
      loose.loads.push_back(force);
      loose.loads.push_back(
          push("torque" + std::to_string(loose.loads.size()), body, Load::Kind::kTorque, side * added.tail<3>()));
    }
  }
  Simulation t(loose);
  solve(t);
  const double scale = (split[0] - basic[0]).norm();
  for (std::size_t b = 0; b < loose.bodies.size(); ++b) {
    const Spatial a = t.workspace.accelerations[b];
    EXPECT_LT(norm(a.lin), kRounding * scale) << b;
    EXPECT_LT(norm(a.ang), kRounding * scale) << b;
  }
}

}  // namespace
}  // namespace unlatch::test::redundant_test
