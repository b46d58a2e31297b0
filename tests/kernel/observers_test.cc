// What observers ask of a state: readings of elements, modal rates, laws of one-sided forces, cords at their anchors,
// quantities. Against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "kernel/elements/kinds/one_sided/cord_path.h"
#include "tests/support/contact_models.h"
#include "tests/support/law_models.h"
#include "tests/support/modal_model.h"
#include "tests/support/simulation.h"
#include "unlatch/plan_image.h"
#include "unlatch/readings.h"

namespace unlatch::test::observers_test {
namespace {

constexpr double kRounding = 1e-14;  // relative

TEST(Readings, OfLoadsAreTheirProfileTimesCommandAndSwitch) {
  Model model;
  model.bodies = {box("body", 1, 1, 1, 1)};
  Channel channel;
  channel.name = "throttle";
  channel.initial = 0.5;
  model.channels = {channel};
  model.laws = {laws::law_of({laws::quantity(0), laws::constant(3), laws::step_of(LawStep::Kind::kMultiply)})};
  model.quantities = {laws::time_of()};
  const auto add = [&](const std::string& name, Profile::Kind kind) -> Load& {
    Load& load = model.loads.emplace_back();
    load.name = name;
    load.profile.kind = kind;
    return load;
  };
  add("constant", Profile::Kind::kConstant).profile.value = 7;
  Load& table = add("table", Profile::Kind::kTable);
  table.profile.times = {0, 0.01, 0.02};
  table.profile.values = {1, 5, 4};
  table.channel = 0;
  Load& exponential = add("exponential", Profile::Kind::kExponential);
  exponential.profile.initial = 2;
  exponential.profile.final = 1;
  exponential.profile.tau = 0.01;
  Load& harmonic = add("harmonic", Profile::Kind::kHarmonic);
  harmonic.profile.harmonics = {{3, 100, 0.5}, {1, 50, 0}};
  add("law", Profile::Kind::kLaw).profile.law = 0;
  add("off", Profile::Kind::kConstant).on = false;
  Simulation s(model);
  for (int tick = 0; tick < 30; ++tick) {
    ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
    const double t = s.get_time();
    const double of_table = t < 0.01 ? 1 + 400 * t : (t < 0.02 ? 5 - 100 * (t - 0.01) : 4);
    const double expected[] = {
        7, 0.5 * of_table, 1 + std::exp(-t / 0.01), 3 * std::sin(100 * t + 0.5) + std::sin(50 * t), 3 * t, 0};
    for (int load = 0; load < 6; ++load)
      EXPECT_NEAR(calc_load_size(s.plan, {s.commands}, s.state, s.workspace, load), expected[load], 1e-12)
          << model.loads[at(load)].name << " at " << t;
    EXPECT_NEAR(calc_element(s.plan, s.workspace, 0).force, 7, 0);
    EXPECT_EQ(calc_element(s.plan, s.workspace, 5).scale, 0);
    ASSERT_EQ(s.advance().status, StepStatus::kOk);
  }
}

TEST(Readings, OfTheAirAreTheForceThatDragGives) {
  for (const bool on : {true, false}) {
    Model model;
    model.bodies = {box("flyer", 12, 3, 5, 6)};
    model.environment = {.planet = Planet{.mu = 0, .j2 = 0}, .atmosphere = Atmosphere{}, .wind = {}, .launch = {}};
    Aerodynamics air{.name = "air", .body = 0, .area = 0.75, .terms = {}};
    air.terms = {{AeroTerm::Of::kDrag, kNone, 0.5, kNone}};
    air.on = on;
    model.aerodynamics = {air};
    Start start;
    start.altitude = 10e3;
    start.velocity = {300, 40, 0};
    start.origin = Start::Origin::kStart;
    Simulation s(place_start(model, start));
    ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
    const double drag = 0.5 * calc_air(Atmosphere{}, 10e3).density * (300 * 300 + 40 * 40) * 0.75 * 0.5;
    const ElementReading reading = calc_element(s.plan, s.workspace, 0);
    EXPECT_NEAR(reading.force, on ? drag : 0, 1e-8 * drag);
    EXPECT_EQ(reading.scale, on ? 1 : 0);
    EXPECT_NEAR(12 * norm(s.workspace.accelerations[0].lin), on ? drag : 0, 1e-8 * drag);
  }
}

TEST(Readings, ModalRatesAreTheRatesOfTheCoordinates) {
  constexpr int kModes = 4;
  const ModalBody lumped = build_lattice_mast(3, kModes, Support::kFree);
  Model model;
  model.bodies = {box("box", 2, 1, 1, 1), build_flexible_body("mast", lumped)};
  model.bodies[0].p_WB = {9, 0, 0};
  model.bodies[1].flexible->initial = Eigen::Vector4d(0.1, -0.2, 0.3, 0.05);
  model.bodies[1].flexible->initial_rate = Eigen::Vector4d(1, 2, -3, 0.5);
  constexpr double kStep = 1e-6;
  Simulation s(model, {.dt = kStep});
  EXPECT_TRUE(get_modal_coordinates(s.plan, s.state, 0).empty());
  EXPECT_TRUE(get_modal_rates(s.plan, s.state, 0).empty());
  std::vector<double> before;
  for (int k = 0; k < kModes; ++k) {
    EXPECT_EQ(get_modal_coordinates(s.plan, s.state, 1)[at(k)], model.bodies[1].flexible->initial[k]);
    EXPECT_EQ(get_modal_rates(s.plan, s.state, 1)[at(k)], model.bodies[1].flexible->initial_rate[k]);
  }
  ASSERT_EQ(s.advance().status, StepStatus::kOk);
  for (int k = 0; k < kModes; ++k) {
    const double rate = get_modal_rates(s.plan, s.state, 1)[at(k)], first = model.bodies[1].flexible->initial_rate[k];
    const double change = get_modal_coordinates(s.plan, s.state, 1)[at(k)] - model.bodies[1].flexible->initial[k];
    EXPECT_NEAR(change / kStep, 0.5 * (first + rate), 1e-6 * (1 + std::abs(rate))) << k;
  }
}

TEST(Readings, LoopsAreTheJointsThatCloseThem) {
  Model model;
  model.bodies = {box("a", 3, 1, 1, 1), box("b", 2, 1, 1, 1)};
  model.bodies[1].p_WB = {0.5, 0, 0};
  for (const double y : {0.25, 0.0, -0.25}) {
    Joint joint;
    joint.name = "bolt" + std::to_string(model.joints.size());
    joint.base = 0;
    joint.follower = 1;
    joint.point_base = {0.25, y, 0};
    joint.point_follower = {-0.25, y, 0};
    joint.modes = {{"held", kPointRows}};
    model.joints.push_back(joint);
  }
  Simulation s(model);
  ASSERT_EQ(s.plan.get_loops().size(), 2u);
  bool closes[3] = {};
  for (const std::int32_t joint : s.plan.get_loops()) closes[joint] = true;
  EXPECT_EQ(closes[0] + closes[1] + closes[2], 2) << "one of the three is in the tree";
}

// --- One-sided forces ------------------------------------------------------------------------------------------------

// Each law's force is the derivative of what it stores; beyond its reach it stores nothing.
TEST(OneSidedLaws, StoreTheWorkOfTheirForce) {
  OneSided linear, constant, table, gas;
  linear.stroke = constant.stroke = table.stroke = gas.stroke = 0.5;
  linear.preload = 100, linear.stiffness = 150;
  constant.preload = 80;
  table.law = OneSided::Law::kTable;
  table.travels = {0.1, 0.2, 0.45};
  table.forces = {50, 90, 20};
  gas.law = OneSided::Law::kGas;
  gas.preload = 200, gas.gas_length = 0.3;
  for (const OneSided* own : {&linear, &constant, &table, &gas})
    for (const double depth : {0.02, 0.07, 0.31, 0.45, 0.5}) {
      constexpr int kParts = 200000;
      double work = 0;
      for (int i = 0; i < kParts; ++i) work += calc_one_sided_force(*own, depth * (i + 0.5) / kParts, 0);
      EXPECT_NEAR(calc_one_sided_energy(*own, depth), work * depth / kParts, 1e-6) << depth;
      EXPECT_EQ(calc_one_sided_energy(*own, 0), 0);
      EXPECT_EQ(calc_one_sided_energy(*own, -depth), 0);
    }
}

// A mass that flies into a stop: a condition on the stop's engagement holds from the touch to the end of the rebound,
// and its reach is the lesser of depth, as a force, and force.
TEST(OneSidedLaws, AnEngagedStopIsAConditionAndItsReachAQuantity) {
  constexpr double kGap = 0.02, kSpeed = 2, kStiffness = 800, kMass = 2;
  Model model;
  model.bodies = {box("mass", kMass, 1, 1, 1)};
  model.bodies[0].v_WB = {kSpeed, 0, 0};
  OneSided stop;
  stop.name = "stop";
  stop.pulls = true;  // from above its limit
  stop.guide = Eigen::Vector3d(1, 0, 0);
  stop.limit = kGap;
  stop.stiffness = kStiffness;
  model.one_sided = {stop};
  for (const bool engaged : {true, false}) {
    Event event;
    event.name = engaged ? "touches" : "leaves";
    event.when.kind = Condition::Kind::kEngaged;
    if (!engaged) {
      Condition no;
      no.kind = Condition::Kind::kNot;
      no.parts = {event.when};
      event.when = {};
      event.when.kind = Condition::Kind::kAll;
      event.when.parts = {no, when(Condition::Kind::kSignal, 0, 0, 0.5)};
    }
    event.then = {act_raise(engaged ? 0 : 1)};
    model.events.push_back(event);
  }
  model.signals = {"touched", "left"};
  Quantity reach = laws::along_x(Quantity::Kind::kReach, "reach");
  reach.subject = 0;
  model.quantities = {reach};
  Simulation s(model);
  const Model whole = complete_events(model);
  double touched = 0, left = 0;
  const double omega = std::sqrt(kStiffness / kMass), duration = std::acos(-1.0) / omega;
  for (int i = 0; i < 200; ++i) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk);
    for (const FiredEvent& event : report.events) {
      const std::string& name = whole.events[at(event.event)].name;
      if (name == "touches") touched = event.time;
      if (name == "leaves") left = event.time;
    }
    const double depth = s.state.bodies[0].p.x - kGap;
    EXPECT_NEAR(s.workspace.quantities[0], kStiffness * depth, 1e-9 * kStiffness) << i;
  }
  EXPECT_NEAR(touched, kGap / kSpeed, 1e-8);
  EXPECT_NEAR(left, kGap / kSpeed + duration, 1e-7);
  EXPECT_NEAR(s.state.bodies[0].v.x, -kSpeed, 1e-6);
}

TEST(Cords, AtItsAnchorAPathHasNoLengthAndAboveItNoneOnTheDrum) {
  const CordDrum drum{{0, 0, 0}, kIdentity3, 0.25, 0};
  const CordPath nothing = calc_cord_path(drum, kIdentity3, {0.25, 0, 0}, 0);
  EXPECT_EQ(nothing.length, 0);
  EXPECT_EQ(norm(nothing.direction), 0);
  EXPECT_EQ(nothing.on_drum, 0);
  // On the axis the arc is what is left of it: none, and the cord runs up along the drum.
  const CordPath up = calc_cord_path(drum, kIdentity3, {0, 0, 2}, 0);
  EXPECT_EQ(up.length, 2);
  EXPECT_EQ(up.direction.z, 1);
  EXPECT_EQ(up.on_drum, 0);
  // Beside its anchor it is straight.
  const CordPath out = calc_cord_path(drum, kIdentity3, {1.25, 0, 0}, 0);
  EXPECT_NEAR(out.length, 1, kRounding);
  EXPECT_LT(out.winding, 0);
}

// --- Quantities ------------------------------------------------------------------------------------------------------

TEST(Observers, LeastAndGreatestOfWhatIsNoNumberAreNone) {
  for (const LawStep::Kind kind : {LawStep::Kind::kMin, LawStep::Kind::kMax})
    for (const bool first : {true, false}) {
      Model model;
      model.bodies = {box("body", 1, 1, 1, 1)};
      using laws::constant;
      using laws::step_of;
      std::vector<LawStep> steps{constant(-1), step_of(LawStep::Kind::kSqrt), constant(3), step_of(kind)};
      if (!first) steps = {constant(3), constant(-1), step_of(LawStep::Kind::kSqrt), step_of(kind)};
      model.laws = {laws::law_of(steps)};
      Simulation s(model);
      (void)update_outputs(s.plan, {s.commands}, s.state, s.workspace);
      EXPECT_TRUE(std::isnan(s.workspace.laws[0])) << first;
    }
}

TEST(Observers, ABranchThatWhatIsNoNumberDecidesIsNone) {
  for (const bool first : {true, false}) {
    using laws::constant;
    using laws::step_of;
    Model model;
    model.bodies = {box("body", 1, 1, 1, 1)};
    std::vector<LawStep> steps{constant(3)};
    steps.insert(first ? steps.begin() : steps.end(), {constant(-1), step_of(LawStep::Kind::kSqrt)});
    steps.insert(steps.end(), {constant(1), constant(2), step_of(LawStep::Kind::kIfLess)});
    model.laws = {laws::law_of(steps)};
    Simulation s(model);
    (void)update_outputs(s.plan, {s.commands}, s.state, s.workspace);
    EXPECT_TRUE(std::isnan(s.workspace.laws[0])) << first;
  }
}

TEST(Observers, ValuesThatNoEnumerationHasAreNamedAsSuch) {
  EXPECT_STREQ(get_status_text(static_cast<StepStatus>(999)), "unknown");
  EXPECT_STREQ(get_status_text(static_cast<ImageStatus>(999)), "unknown status");
  EXPECT_STREQ(get_name(static_cast<InstructionSet>(99)), "");
}

TEST(Observers, AContactIsClosedFromItsTouchOn) {
  constexpr double kHeight = 0.0125;
  Model model = build_dropped_ball(kHeight);
  Quantity closed;
  closed.name = "closed";
  closed.kind = Quantity::Kind::kClosed;
  model.quantities = {closed};
  Simulation s(model);
  ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
  EXPECT_EQ(s.workspace.quantities[0], 0);
  const double touch = std::sqrt(2 * kHeight / kGravity);
  for (int i = 0; i < 52; ++i) {
    ASSERT_EQ(s.advance().status, StepStatus::kOk);
    EXPECT_EQ(s.workspace.quantities[0], s.get_time() > touch ? 1 : 0) << s.get_time();
  }
}

// The weight is the same wherever W's origin is, and however it moves.
TEST(Observers, GravityIsThatOfThePlaceHoweverTheOriginMoves) {
  Model model;
  model.bodies = {box("body", 1, 1, 1, 1)};
  model.environment.planet = Planet{.flattening = 0, .j2 = 0};
  Quantity gravity;
  gravity.name = "gravity";
  gravity.kind = Quantity::Kind::kGravity;
  model.quantities = {gravity};
  Start start;
  start.body = 0;
  start.altitude = 400e3;
  start.velocity = {7000, 0, 0};
  const double r = 6378137 + 400e3, expected = 3.986004418e14 / (r * r);
  for (const Start::Origin origin : {Start::Origin::kKept, Start::Origin::kStart, Start::Origin::kFalling}) {
    start.origin = origin;
    Simulation s(place_start(model, start));
    for (int i = 0; i < 3; ++i) {
      ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
      EXPECT_NEAR(s.workspace.quantities[0], expected, 1e-6 * expected);
      ASSERT_EQ(s.advance().status, StepStatus::kOk);
    }
  }
}

}  // namespace
}  // namespace unlatch::test::observers_test
