// Quantities against closed forms, against differences of each other, and as guards.
#include "unlatch/quantities.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::test::quantities_test {
namespace {

using Kind = Quantity::Kind;

constexpr double kRounding = 1e-10;
constexpr double kLocated = 1e-11;  // s, of an event
constexpr double kDt = 0.001;

Quantity quantity(Kind kind, int subject, int other = kGround, const Eigen::Vector3d& direction = {0, 0, 0}) {
  Quantity out;
  out.kind = kind;
  out.subject = subject;
  out.other = other;
  out.direction = direction;
  return out;
}

Quantity of_row(Kind kind, int joint, int row) {
  Quantity out = quantity(kind, joint);
  out.part = row;
  return out;
}

Model with(Model model, const std::vector<Quantity>& quantities) {
  for (Quantity q : quantities) {
    q.name = "q" + std::to_string(model.quantities.size());
    model.quantities.push_back(q);
  }
  return model;
}

// Bar of 1 kg about a hinge half a metre from its middle, 3 rad/s; and a body that drifts.
Model build_bar() {
  Model model = build_pendulum(true, 3);
  Body drifter = box("drifter", 2, 1, 1, 1);
  drifter.p_WB = {0, 0, 1};
  drifter.v_WB = {0, 0.25, 0};
  drifter.w_WB_B = {0, 0, 1};
  model.bodies.push_back(drifter);
  return model;
}

TEST(Quantities, OfATurningBarAreThoseOfCircularMotion) {
  Quantity tip = quantity(Kind::kAcceleration, 0);
  tip.point = {0.5, 0, 0};
  Quantity axes = quantity(Kind::kAxes, 0, kGround, {1, 0, 0});
  axes.other_direction = {1, 0, 0};
  const Model model = with(
      build_bar(), {quantity(Kind::kTime, 0), quantity(Kind::kPosition, 0, kGround, {0, 1, 0}),
                    quantity(Kind::kVelocity, 0), quantity(Kind::kRate, 0, kGround, {0, 0, 1}),
                    quantity(Kind::kAttitude, 0), axes, tip, of_row(Kind::kAngle, 0, kRotZ),
                    of_row(Kind::kSpeed, 0, kRotZ), of_row(Kind::kReaction, 0, kX), quantity(Kind::kReactionForce, 0)});
  Simulation s(model);
  for (int i = 0; i < 200; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  const double t = 200 * kDt, turn = 3 * t, force = 1 * 9 * 0.5;  // m ω² r
  const double expected[] = {t, 0.5 * std::sin(turn), 1.5, 3, turn, turn, 9.0, turn, 3, -force * std::cos(turn), force};
  ASSERT_EQ(s.workspace.quantities.size(), std::size(expected));
  for (std::size_t i = 0; i < std::size(expected); ++i)
    EXPECT_NEAR(s.workspace.quantities[i], expected[i], kRounding) << describe(model, model.quantities[i]);
}

TEST(Quantities, OfOneBodySeenFromAnotherAreInItsAxes) {
  const Model model =
      with(build_bar(),
           {quantity(Kind::kPosition, 0, 1, {1, 0, 0}), quantity(Kind::kVelocity, 0, 1, {0, 1, 0}),
            quantity(Kind::kRate, 0, 1, {0, 0, 1}), quantity(Kind::kAttitude, 0, 1), quantity(Kind::kPosition, 0, 1)});
  Simulation s(model);
  for (int i = 0; i < 200; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  const double t = 200 * kDt, bar = 3 * t, own = t;
  const Eigen::Vector3d p(0.5 * std::cos(bar), 0.5 * std::sin(bar) - 0.25 * t, -1),
      v(-1.5 * std::sin(bar), 1.5 * std::cos(bar) - 0.25, 0), x(std::cos(own), std::sin(own), 0),
      y(-std::sin(own), std::cos(own), 0);
  const double expected[] = {p.dot(x), v.dot(y), 2, bar - own, p.norm()};
  for (std::size_t i = 0; i < std::size(expected); ++i)
    EXPECT_NEAR(s.workspace.quantities[i], expected[i], kRounding) << describe(model, model.quantities[i]);
}

// A central difference of the one is the other: the error is that of the difference, h² f''' / 6.
TEST(Quantities, RatesAreDifferencesOfWhatTheyAreTheRateOf) {
  constexpr double kDifference = 2e-5;
  Model model = build_pendulum(false, 1);
  model.gravity.uniform = {1, -9, 2};
  model.joint_springs.push_back({.name = "spring", .joint = 0, .effort = 0.3, .stiffness = 2, .damping = 0.1});
  Quantity length = quantity(Kind::kLength, 0), rate = quantity(Kind::kLengthRate, 0);
  const std::vector<std::pair<Quantity, Quantity>> pairs{
      {quantity(Kind::kPosition, 1, kGround, {1, 0, 0}), quantity(Kind::kVelocity, 1, kGround, {1, 0, 0})},
      {of_row(Kind::kAngle, 0, kRotZ), of_row(Kind::kSpeed, 0, kRotZ)},
      {length, rate},
      {quantity(Kind::kRate, 1, kGround, {0, 0, 1}), quantity(Kind::kAngularAcceleration, 1, kGround, {0, 0, 1})}};
  for (const auto& [whole, its_rate] : pairs) model = with(model, {whole, its_rate});
  Simulation s(model);
  std::vector<std::vector<double>> rows;
  for (int i = 0; i < 60; ++i) {
    ASSERT_EQ(s.advance().status, StepStatus::kOk);
    rows.emplace_back(s.workspace.quantities.begin(), s.workspace.quantities.end());
  }
  for (std::size_t k = 0; k < pairs.size(); ++k)
    EXPECT_NEAR((rows[50][2 * k] - rows[48][2 * k]) / (2 * kDt), rows[49][2 * k + 1], kDifference)
        << describe(model, model.quantities[2 * k]);
}

TEST(Quantities, AGuardOnAComponentIsLocatedWhereItCrosses) {
  Model model = with(build_bar(), {quantity(Kind::kPosition, 0, kGround, {0, 1, 0}),
                                   quantity(Kind::kVelocity, 0, kGround, {1, 0, 0})});
  model.events.push_back({"high", "", when(Condition::Kind::kQuantity, 0, 0, 0.3), 0, {}, false});
  Condition back = when(Condition::Kind::kQuantity, 1, 0, -0.75);
  back.below = true;
  model.events.push_back({"back", "", back, 0, {}, false});
  Simulation s(model);
  std::vector<double> times(2, 0);
  for (int i = 0; i < 400; ++i)
    for (const FiredEvent& fired : s.advance().events) times[static_cast<std::size_t>(fired.event)] = fired.time;
  EXPECT_NEAR(times[0], std::asin(0.6) / 3, kLocated);
  EXPECT_NEAR(times[1], std::asin(0.5) / 3, kLocated);
}

TEST(Quantities, TheTimeSinceAnEventBeginsThere) {
  Model model = with(build_bar(), {quantity(Kind::kSince, 0)});
  model.events.push_back({"first", "", when(Condition::Kind::kAngle, 0, kRotZ, 0.2), 0.05, {}, false});
  model.events.push_back({"second", "", when(Condition::Kind::kQuantity, 0, 0, 0.1), 0, {}, false});
  Simulation s(model);
  std::vector<double> times(2, 0);
  for (int i = 0; i < 300; ++i) {
    for (const FiredEvent& fired : s.advance().events) times[static_cast<std::size_t>(fired.event)] = fired.time;
    if (times[0] == 0) {
      EXPECT_EQ(s.workspace.quantities[0], 0);
    }
  }
  EXPECT_NEAR(times[0], 0.2 / 3 + 0.05, kLocated);
  EXPECT_NEAR(times[1], times[0] + 0.1, kLocated);
  EXPECT_NEAR(s.workspace.quantities[0], 300 * kDt - times[0], kRounding);
}

// The time at the event is kept only where somebody reads it: states of other models keep their bits.
TEST(Quantities, EventsKeepTheirTimeOnlyIfAQuantityReadsIt) {
  Model model = build_bar();
  model.events.push_back({"first", "", when(Condition::Kind::kAngle, 0, kRotZ, 0.2), 0, {}, false});
  Simulation plain(model), timed(with(model, {quantity(Kind::kSince, 0)}));
  EXPECT_EQ(plain.state.events[0].due, 0);
  EXPECT_EQ(timed.state.events[0].due, -1);
  for (int i = 0; i < 100; ++i) {
    plain.advance();
    timed.advance();
  }
  EXPECT_EQ(plain.state.events[0].due, 0);
  EXPECT_NEAR(timed.state.events[0].due, 0.2 / 3, kLocated);
}

// Conditions with kinds of their own are quantities under another name.
TEST(Quantities, ConditionsOfOldKindsCompareTheSameBits) {
  Model model = build_pendulum(true, 3);
  model.gravity.uniform = {0, -9.81, 0};
  model = with(model, {quantity(Kind::kRate, 0), quantity(Kind::kReactionForce, 0)});
  const auto add = [&](Condition::Kind kind, int subject, double threshold, bool below) {
    Condition c = when(kind, subject, 0, threshold);
    c.below = below;
    model.events.push_back({"e" + std::to_string(model.events.size()), "", c, 0, {}, false});
  };
  add(Condition::Kind::kBodyRate, 0, 2, true);
  add(Condition::Kind::kQuantity, 0, 2, true);
  add(Condition::Kind::kForceSize, 0, 8, true);
  add(Condition::Kind::kQuantity, 1, 8, true);
  Simulation s(model);
  std::vector<double> times(4, -1);
  for (int i = 0; i < 1000; ++i)
    for (const FiredEvent& fired : s.advance().events) times[static_cast<std::size_t>(fired.event)] = fired.time;
  EXPECT_GT(times[0], 0);
  EXPECT_EQ(times[0], times[1]);
  EXPECT_EQ(times[2], times[3]);
}

TEST(Quantities, AModelsHashChangesOnlyIfItHasSome) {
  const Model plain = build_bar();
  EXPECT_NE(Simulation(plain).plan.get_hash(), Simulation(with(plain, {quantity(Kind::kRate, 0)})).plan.get_hash());
}

TEST(Quantities, MistakesAreReportedWithTheirPlace) {
  const auto check = [](Quantity q, const std::string& part) {
    const std::vector<ModelError> errors = validate(with(build_bar(), {q}));
    ASSERT_EQ(errors.size(), 1u) << part;
    EXPECT_EQ(errors[0].where, "quantity 'q0'");
    EXPECT_NE(errors[0].what.find(part), std::string::npos) << errors[0].what;
  };
  check(quantity(Kind::kVelocity, 7), "the body that it names does not exist");
  check(quantity(Kind::kVelocity, 0, 7), "the body that it names does not exist");
  check(quantity(Kind::kVelocity, 0, 0), "seen from itself");
  check(quantity(Kind::kAxes, 0), "an axis has the length 0");
  check(quantity(Kind::kBurnt, 0), "no mass law");
  check(of_row(Kind::kDisplacement, 0, kRotX), "an axis that this kind of quantity does not have");
  check(of_row(Kind::kReaction, 0, kRotZ + 1), "an axis that this kind of quantity does not have");
  check(of_row(Kind::kMode, 0, 9), "a mode that joint 'hinge' does not have");
  check(of_row(Kind::kVelocity, 0, Quantity::kAll), "all values of a vector");
  check(quantity(static_cast<Kind>(99), 0), "does not exist");
  check(quantity(Kind::kSince, 0), "the event that it names does not exist");
}

TEST(Quantities, TheTableHasARowForEachKindAndUniqueNames) {
  std::vector<std::string> names;
  for (int i = 0; i < count_quantity_kinds(); ++i) {
    const QuantityTraits& traits = get_traits(static_cast<Kind>(i));
    EXPECT_EQ(traits.kind, static_cast<Kind>(i));
    EXPECT_EQ(std::count(names.begin(), names.end(), traits.name), 0) << traits.name;
    names.emplace_back(traits.name);
  }
  EXPECT_EQ(count_quantity_kinds(), static_cast<int>(Kind::kOrbitVelocity) + 1);
}

TEST(Quantities, EachKindSaysWhatMotionDecidesItAndOneThatDoesNotDependsOnAll) {
  EXPECT_EQ(QuantityTraits{}.motion, QuantityMotion::kOfAll);
  for (int i = 0; i < count_quantity_kinds(); ++i) {
    const QuantityTraits& traits = get_traits(static_cast<Kind>(i));
    const std::string unit = traits.unit;
    EXPECT_NE(traits.motion, QuantityMotion::kOfAll) << traits.name;
    if (unit == "m/s" && traits.kind != Kind::kSpeedOfSound) {
      EXPECT_EQ(traits.motion, QuantityMotion::kSpeeds) << traits.name;
    }
  }
}

}  // namespace
}  // namespace unlatch::test::quantities_test
