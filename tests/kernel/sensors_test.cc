// Sensor values, against statics and circular motion.
#include <gtest/gtest.h>

#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::test::sensors_test {
namespace {

constexpr double kRounding = 1e-10;

Sensor sensor(const char* name, Sensor::Kind kind, int subject, int axis = kX) {
  Sensor s;
  s.name = name;
  s.kind = kind;
  s.subject = subject;
  s.axis = axis;
  return s;
}

TEST(Sensors, AccelerometerOnATurningBarReadsTheCentripetalAcceleration) {
  Model model = build_pendulum(true, 3);
  Sensor tip = sensor("tip", Sensor::Kind::kAcceleration, 0);
  tip.point = {0.5, 0, 0};
  model.sensors = {tip, sensor("gyro", Sensor::Kind::kRate, 0)};
  Simulation s(model);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  EXPECT_NEAR(s.workspace.sensors[0], -9, kRounding);  // ω² · 1 m towards the hinge, along the bar's own x
  EXPECT_NEAR(s.workspace.sensors[1], 0, kRounding);
  EXPECT_NEAR(s.workspace.sensors[5], 3, kRounding);
}

TEST(Sensors, AccelerometerAtRestReadsWhatHoldsItUp) {
  Model model = build_pendulum(true, 0);
  model.gravity.uniform = {0, 0, -9.81};  // along the hinge, which bears it
  model.sensors = {sensor("imu", Sensor::Kind::kSpecificForce, 0), sensor("hinge", Sensor::Kind::kReaction, 0)};
  Simulation s(model);
  ASSERT_EQ(s.advance().status, StepStatus::kOk);
  EXPECT_NEAR(s.workspace.sensors[2], 9.81, kRounding);
  EXPECT_NEAR(s.workspace.sensors[3 + kZ], 9.81, kRounding);            // the ground on the bar, N
  EXPECT_NEAR(s.workspace.sensors[3 + kRotY], -0.5 * 9.81, kRounding);  // and against its weight's moment, N m
  EXPECT_EQ(s.workspace.sensors[3 + kRotZ], 0);                         // no row, no reaction
}

TEST(Sensors, AFreeBodysAccelerometerReadsNothing) {
  Model model;
  model.bodies.push_back(box("b", 1, 1, 1, 1));
  model.gravity.mu = 3;
  model.bodies[0].p_WB = {1, 2, 3};
  model.sensors = {sensor("imu", Sensor::Kind::kSpecificForce, 0)};
  Simulation s(model);
  ASSERT_EQ(s.advance().status, StepStatus::kOk);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(s.workspace.sensors[static_cast<std::size_t>(k)], 0, kRounding);
}

TEST(Sensors, ContactsReadTheirSignalAndGaugesTheirJoint) {
  Model model = build_pendulum(true, 2);
  model.signals = {"kr"};
  model.sensors = {sensor("contact", Sensor::Kind::kContact, 0), sensor("angle", Sensor::Kind::kAngle, 0, kRotZ),
                   sensor("speed", Sensor::Kind::kSpeed, 0, kRotZ), sensor("attitude", Sensor::Kind::kAttitude, 0)};
  model.events.push_back({"contact", "", when(Condition::Kind::kAngle, 0, kRotZ, 0.1), 0, {act_raise(0)}, false});
  Simulation s(model);
  for (int i = 0; i < 50; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);  // 0.1 rad at 0.05 s exactly
  const double before = s.workspace.sensors[0];
  for (int i = 0; i < 50; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  EXPECT_LE(before, 1);
  EXPECT_EQ(s.workspace.sensors[0], 1);
  EXPECT_NEAR(s.workspace.sensors[1], 0.2, kRounding);
  EXPECT_NEAR(s.workspace.sensors[2], 2, kRounding);
  EXPECT_NEAR(s.workspace.sensors[3], std::cos(0.1), kRounding);
  EXPECT_NEAR(s.workspace.sensors[6], std::sin(0.1), kRounding);
}

}  // namespace
}  // namespace unlatch::test::sensors_test
