// Lanes: every width gives the same bits; a body does not depend on the bodies in other lanes.
#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "kernel/plan/plan_data.h"
#include "tests/support/random_model.h"
#include "tests/support/reference_models.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "unlatch/step.h"

namespace unlatch::test::lanes_test {
namespace {

std::vector<InstructionSet> find_widths() {
  std::vector<InstructionSet> widths;
  for (const InstructionSet set :
       {InstructionSet::kScalar, InstructionSet::k128, InstructionSet::k256, InstructionSet::k512})
    if (is_supported(set)) widths.push_back(set);
  return widths;
}

Simulation build(const Model& model, InstructionSet set) {
  PlanOptions options;
  options.instruction_set = set;
  return Simulation(model, options);
}

std::uint64_t get_bits(double number) {
  std::uint64_t bits;
  std::memcpy(&bits, &number, sizeof(bits));
  return bits;
}

TEST(Lanes, EveryWidthTakesTheBoostersThroughAllPhasesWithTheSameBits) {
  const Model model = build_soyuz(load_reference("soyuz_nominal"));
  Simulation scalar = build(model, InstructionSet::kScalar);
  std::vector<Simulation> others;
  for (const InstructionSet set : find_widths()) others.push_back(build(model, set));
  for (int tick = 0; tick < 850; ++tick) {
    ASSERT_EQ(scalar.advance().status, StepStatus::kOk);
    for (Simulation& other : others) {
      ASSERT_EQ(other.advance().status, StepStatus::kOk);
      ASSERT_EQ(calc_hash(other.state), calc_hash(scalar.state))
          << get_name(other.plan.get_options().instruction_set) << " tick " << tick;
    }
  }
}

TEST(Lanes, EveryWidthGivesRandomSystemsTheSameReactionsToTheLastBit) {
  constexpr std::uint64_t kFirstSeed = 4242;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 200; ++seed) {
    const Model model = build_random_model(seed);
    Simulation scalar = build(model, InstructionSet::kScalar);
    for (int tick = 0; tick < 3; ++tick) ASSERT_EQ(scalar.advance().status, StepStatus::kOk) << "seed " << seed;
    for (const InstructionSet set : find_widths()) {
      Simulation other = build(model, set);
      for (int tick = 0; tick < 3; ++tick) ASSERT_EQ(other.advance().status, StepStatus::kOk) << "seed " << seed;
      ASSERT_EQ(calc_hash(other.state), calc_hash(scalar.state)) << get_name(set) << " seed " << seed;
      for (std::size_t i = 0; i < other.workspace.multipliers.size(); ++i)
        ASSERT_EQ(get_bits(other.workspace.multipliers[i]), get_bits(scalar.workspace.multipliers[i]))
            << get_name(set) << " seed " << seed << " multiplier " << i;
    }
  }
}

// Equal arms fill a part of a group of four or eight; its empty lanes are beside their parents'.
TEST(Lanes, EveryWidthGivesThreeToSevenArmsOfTwoLinksTheSameBits) {
  for (int arms = 3; arms < 8; ++arms) {
    Model model;
    model.bodies = {box("hub", 50, 4, 5, 6)};
    model.bodies[0].w_WB_B = {0.1, 0.2, -0.3};
    for (int arm = 0; arm < arms; ++arm)
      for (int link = 0; link < 2; ++link) {
        const std::string name = std::to_string(arm) + "." + std::to_string(link);
        const int number = static_cast<int>(model.bodies.size());
        Body body = box(name, 3 + arm, 0.2, 0.3, 0.4);
        body.p_WB = {link + 1.0, 0.5 * arm, 0};
        body.v_WB = model.bodies[0].w_WB_B.cross(body.p_WB);
        body.w_WB_B = model.bodies[0].w_WB_B;
        model.bodies.push_back(body);
        Joint joint;
        joint.name = name;
        joint.base = link == 0 ? 0 : number - 1;
        joint.follower = number;
        joint.point_base = link == 0 ? Eigen::Vector3d(0.5, 0.5 * arm, 0) : Eigen::Vector3d(0.5, 0, 0);
        joint.point_follower = {-0.5, 0, 0};
        joint.modes = {{"hinge", kRevoluteRows}};
        model.joints.push_back(joint);
      }
    const Simulation widest = [&] {
      Simulation s = build(model, InstructionSet::kAuto);
      for (int tick = 0; tick < 20; ++tick) EXPECT_EQ(s.advance().status, StepStatus::kOk) << arms;
      return s;
    }();
    for (const InstructionSet set : find_widths()) {
      Simulation other = build(model, set);
      for (int tick = 0; tick < 20; ++tick) EXPECT_EQ(other.advance().status, StepStatus::kOk) << arms << get_name(set);
      EXPECT_EQ(calc_hash(other.state), calc_hash(widest.state)) << arms << " " << get_name(set);
    }
  }
}

// Samples as lanes: copies of one system in one model move like a single one.
TEST(Lanes, EightCopiesOfAChainMoveAsOneDoes) {
  RandomModelOptions options;
  options.shape = RandomModelOptions::Shape::kChain;
  options.bodies = 6;
  options.grounded_chance = 0;
  const Model one = build_random_model(7, options);
  Model eight;
  for (int copy = 0; copy < 8; ++copy) {
    const int offset = copy * static_cast<int>(one.bodies.size());
    for (Body body : one.bodies) {
      body.name += "." + std::to_string(copy);
      eight.bodies.push_back(body);
    }
    for (Joint joint : one.joints) {
      joint.name += "." + std::to_string(copy);
      if (joint.base != kGround) joint.base += offset;
      joint.follower += offset;
      eight.joints.push_back(joint);
    }
  }
  eight.gravity = one.gravity;
  Simulation alone(one), together(eight);
  for (int tick = 0; tick < 100; ++tick) {
    ASSERT_EQ(alone.advance().status, StepStatus::kOk);
    ASSERT_EQ(together.advance().status, StepStatus::kOk);
  }
  for (std::size_t b = 0; b < together.state.bodies.size(); ++b) {
    const BodyState &theirs = together.state.bodies[b], &ours = alone.state.bodies[b % one.bodies.size()];
    EXPECT_EQ(theirs.p.x, ours.p.x) << b;
    EXPECT_EQ(theirs.q.w, ours.q.w) << b;
    EXPECT_EQ(theirs.v.z, ours.v.z) << b;
    EXPECT_EQ(theirs.w.y, ours.w.y) << b;
  }
  for (const Group& group : together.data().groups) EXPECT_EQ(group.width, 8);
}

TEST(Lanes, BodiesOfAChainLieEightSideBySideWhereverTheyAreInIt) {
  RandomModelOptions options;
  options.shape = RandomModelOptions::Shape::kChain;
  options.bodies = 64;
  options.grounded_chance = 0;
  const Simulation chain(build_random_model(11, options));
  ASSERT_EQ(chain.data().eights.size(), 8u);
  for (const BodyEight& eight : chain.data().eights) EXPECT_EQ(eight.filled, 0xff);
}

TEST(Lanes, EveryBodyHasALaneOfItsOwn) {
  constexpr std::uint64_t kFirstSeed = 5100;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 200; ++seed) {
    const Simulation s(build_random_model(seed));
    std::set<std::int32_t> bodies, shared, solver;
    for (const Place& place : s.data().places) {
      bodies.insert(place.body);
      shared.insert(place.shared);
      solver.insert(place.solver);
      EXPECT_EQ(place.body % kEight, place.shared % kEight) << "seed " << seed;
    }
    for (const std::set<std::int32_t>& all : {bodies, shared, solver})
      EXPECT_EQ(all.size(), s.data().bodies.size()) << "seed " << seed;
    std::size_t filled = 0;
    for (const BodyEight& eight : s.data().eights) {
      filled += static_cast<std::size_t>(std::popcount(eight.filled));
      EXPECT_EQ(eight.filled & ~eight.used, 0) << "seed " << seed;
    }
    EXPECT_EQ(filled, s.data().bodies.size()) << "seed " << seed;
  }
}

TEST(Lanes, AWidthThatTheProcessorLacksIsRefused) {
  if (is_supported(InstructionSet::k512)) GTEST_SKIP() << "this processor has every width";
  PlanOptions options;
  options.instruction_set = InstructionSet::k512;
  const PlanResult result = compile_plan(build_random_model(1), options);
  ASSERT_FALSE(result.plan);
  EXPECT_NE(result.errors.front().what.find("avx512"), std::string::npos);
}

}  // namespace
}  // namespace unlatch::test::lanes_test
