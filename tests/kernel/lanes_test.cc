// Lanes: every width gives the same bits; a body does not depend on the bodies in other lanes.
#include "kernel/plan/lanes.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <set>
#include <vector>

#include "tests/support/random_model.h"
#include "tests/support/reference_models.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "unlatch/step.h"

namespace unlatch::test {
namespace {

std::vector<Lanes> find_widths() {
  std::vector<Lanes> widths;
  for (const Lanes lanes : {Lanes::kScalar, Lanes::kTwo, Lanes::kFour, Lanes::kEight})
    if (is_supported(lanes)) widths.push_back(lanes);
  return widths;
}

Simulation build(const Model& model, Lanes lanes) {
  PlanOptions options;
  options.lanes = lanes;
  return Simulation(model, options);
}

std::uint64_t get_bits(double number) {
  std::uint64_t bits;
  std::memcpy(&bits, &number, sizeof(bits));
  return bits;
}

TEST(Lanes, EveryWidthTakesTheBoostersThroughAllPhasesWithTheSameBits) {
  const Model model = build_soyuz(load_reference("soyuz_nominal"));
  Simulation scalar = build(model, Lanes::kScalar);
  std::vector<Simulation> others;
  for (const Lanes lanes : find_widths()) others.push_back(build(model, lanes));
  for (int tick = 0; tick < 850; ++tick) {
    ASSERT_EQ(scalar.advance().status, StepStatus::kOk);
    for (Simulation& other : others) {
      ASSERT_EQ(other.advance().status, StepStatus::kOk);
      ASSERT_EQ(calc_hash(other.state), calc_hash(scalar.state))
          << get_name(other.plan.options.lanes) << " tick " << tick;
    }
  }
}

TEST(Lanes, EveryWidthGivesRandomSystemsTheSameReactionsToTheLastBit) {
  constexpr std::uint64_t kFirstSeed = 4242;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 200; ++seed) {
    const Model model = build_random_model(seed);
    Simulation scalar = build(model, Lanes::kScalar);
    for (int tick = 0; tick < 3; ++tick) ASSERT_EQ(scalar.advance().status, StepStatus::kOk) << "seed " << seed;
    for (const Lanes lanes : find_widths()) {
      Simulation other = build(model, lanes);
      for (int tick = 0; tick < 3; ++tick) ASSERT_EQ(other.advance().status, StepStatus::kOk) << "seed " << seed;
      ASSERT_EQ(calc_hash(other.state), calc_hash(scalar.state)) << get_name(lanes) << " seed " << seed;
      for (std::size_t i = 0; i < other.workspace.multipliers.size(); ++i)
        ASSERT_EQ(get_bits(other.workspace.multipliers[i]), get_bits(scalar.workspace.multipliers[i]))
            << get_name(lanes) << " seed " << seed << " multiplier " << i;
    }
  }
}

// Samples as lanes: copies of one system in one model move as each of them does alone.
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
  for (const LaneGroup& group : together.plan.groups) EXPECT_EQ(group.width, 8);
}

TEST(Lanes, BodiesOfAChainLieEightSideBySideWhereverTheyAreInIt) {
  RandomModelOptions options;
  options.shape = RandomModelOptions::Shape::kChain;
  options.bodies = 64;
  options.grounded_chance = 0;
  const Simulation chain(build_random_model(11, options));
  ASSERT_EQ(chain.plan.octets.size(), 8u);
  for (const LaneOctet& octet : chain.plan.octets) EXPECT_EQ(octet.bodies, 0xff);
}

TEST(Lanes, EveryBodyHasALaneOfItsOwn) {
  constexpr std::uint64_t kFirstSeed = 5100;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 200; ++seed) {
    const Simulation s(build_random_model(seed));
    std::set<std::int32_t> places, shared, data;
    for (const LaneSlot& slot : s.plan.body_slots) {
      places.insert(slot.body);
      shared.insert(slot.shared);
      data.insert(slot.data);
      EXPECT_EQ(slot.body % kOctet, slot.shared % kOctet) << "seed " << seed;
    }
    for (const std::set<std::int32_t>& all : {places, shared, data})
      EXPECT_EQ(all.size(), s.plan.bodies.size()) << "seed " << seed;
    std::size_t bodies = 0;
    for (const LaneOctet& octet : s.plan.octets) {
      bodies += static_cast<std::size_t>(std::popcount(octet.bodies));
      EXPECT_EQ(octet.bodies & ~octet.lanes, 0) << "seed " << seed;
    }
    EXPECT_EQ(bodies, s.plan.bodies.size()) << "seed " << seed;
  }
}

TEST(Lanes, AWidthThatTheProcessorLacksIsRefused) {
  if (is_supported(Lanes::kEight)) GTEST_SKIP() << "this processor has every width";
  PlanOptions options;
  options.lanes = Lanes::kEight;
  const PlanResult result = compile_plan(build_random_model(1), options);
  ASSERT_FALSE(result.plan);
  EXPECT_NE(result.errors.front().what.find("avx512"), std::string::npos);
}

}  // namespace
}  // namespace unlatch::test
