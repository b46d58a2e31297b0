// Every kind of mistake that makes a model unphysical or inconsistent is found.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "unlatch/model.h"

namespace unlatch::test::validate_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Body body(const std::string& name, double x) {
  Body b;
  b.name = name;
  b.mass = 1;
  b.inertia = Eigen::Vector3d(1, 1.5, 2).asDiagonal();
  b.p_WB = {x, 0, 0};
  return b;
}

// A model of two bodies, a revolute joint about z, one of each element.
Model good_model() {
  Model m;
  m.bodies = {body("a", 0), body("b", 2)};
  Joint joint;
  joint.name = "pin";
  joint.base = 0;
  joint.follower = 1;
  joint.point_base = {1, 0, 0};
  joint.point_follower = {-1, 0, 0};
  joint.modes = {{"hinge", static_cast<RowSet>(kPointRows | row_bit(kRotX) | row_bit(kRotY))}, {"free", 0}};
  m.joints = {joint};
  m.channels = {{"c", 0, 0, 1, 0, "1"}};
  m.signals = {"s"};
  m.loads.push_back({.name = "load", .profile = {}, .channel = 0});
  m.point_springs.push_back({.name = "spring", .base = 0, .follower = 1});
  m.joint_springs.push_back({.name = "drive"});
  m.plane_torsions.push_back({.name = "torsion", .base = 0, .follower = 1});
  m.sensors.push_back({.name = "gyro"});
  Condition reaction;
  reaction.kind = Condition::Kind::kReaction;
  m.events.push_back({"release", "b", reaction, 0, {{Action::Kind::kSetMode, 0, 1, 0, 0}}, false});
  return m;
}

TEST(Validate, FindsNothingInAGoodModel) {
  for (const ModelError& e : validate(good_model())) ADD_FAILURE() << e.where << ": " << e.what;
}

struct Bad {
  const char* name;
  std::function<void(Model&)> spoil;
  const char* where;
  const char* what;
};
void PrintTo(const Bad& bad, std::ostream* stream) { *stream << bad.name; }
class ValidateMistakes : public ::testing::TestWithParam<Bad> {};

TEST_P(ValidateMistakes, AreFound) {
  Model model = good_model();
  GetParam().spoil(model);
  const std::vector<ModelError> errors = validate(model);
  ASSERT_EQ(errors.size(), 1u) << (errors.empty() ? "" : errors[1].what);
  EXPECT_EQ(errors[0].where, GetParam().where);
  EXPECT_NE(errors[0].what.find(GetParam().what), std::string::npos) << errors[0].what;
  EXPECT_FALSE(errors[0].mend.empty());
}

Profile table(std::vector<double> times, std::vector<double> values) {
  Profile p;
  p.kind = Profile::Kind::kTable;
  p.times = std::move(times);
  p.values = std::move(values);
  return p;
}

// The inertia of a plate as printed by a design program, I_z = I_x + I_y to three digits.
TEST(Validate, RoundedInertiasOfAPlateAreAccepted) {
  Model model = good_model();
  model.bodies[0].inertia = Eigen::Vector3d(1.001, 2.002, 3.005).asDiagonal();  // 6.7e-4 too much
  EXPECT_TRUE(validate(model).empty());
}

INSTANTIATE_TEST_SUITE_P(
    Validate, ValidateMistakes,
    ::testing::Values(
        Bad{"ZeroMass", [](Model& m) { m.bodies[0].mass = 0; }, "body 'a'", "mass is 0"},
        Bad{"NanMass", [](Model& m) { m.bodies[0].mass = kNan; }, "body 'a'", "mass is nan"},
        Bad{"Asymmetric", [](Model& m) { m.bodies[0].inertia(0, 1) = 0.1; }, "body 'a'", "not symmetric"},
        Bad{"Negative", [](Model& m) { m.bodies[0].inertia(0, 0) = -1; }, "body 'a'", "not positive definite"},
        Bad{"TinyMass", [](Model& m) { m.bodies[0].mass = 1e-61; }, "body 'a'", "its mass is 1e-61 kg"},
        Bad{"HugeInertia", [](Model& m) { m.bodies[0].inertia *= 1e61; }, "body 'a'", "principal moments"},
        Bad{"Triangle", [](Model& m) { m.bodies[0].inertia(2, 2) = 2.51; }, "body 'a'", "triangle"},
        Bad{"InfiniteInertia", [](Model& m) { m.bodies[0].inertia(2, 2) = kInfinity; }, "body 'a'", "not finite"},
        Bad{"NoAttitude", [](Model& m) { m.bodies[0].q_WB = {0, 0, 0, 0}; }, "body 'a'", "quaternion"},
        Bad{"BodyTwice", [](Model& m) { m.bodies.push_back(m.bodies[0]); }, "body 'a'", "more than one"},
        Bad{"NoBody", [](Model& m) { m.joints[0].follower = 7; }, "joint 'pin'", "no body"},
        Bad{"Itself", [](Model& m) { m.joints[0].base = 1; }, "joint 'pin'", "with itself"},
        Bad{"NoModes", [](Model& m) { m.joints[0].modes.clear(); m.events.clear(); }, "joint 'pin'", "no modes"},
        Bad{"ModeTwice", [](Model& m) { m.joints[0].modes[1].name = "hinge"; }, "joint 'pin'", "two modes"},
        Bad{"NoMode", [](Model& m) { m.joints[0].mode = 2; }, "joint 'pin'", "initial mode"},
        Bad{"LeftHanded", [](Model& m) { m.joints[0].axes.col(0) *= -1; }, "joint 'pin'", "axes is not a frame"},
        Bad{"NotUnit", [](Model& m) { m.joints[0].rotation_axes = 2 * Eigen::Matrix3d::Identity(); }, "joint 'pin'",
            "rotation_axes is not a frame"},
        Bad{"NoShare", [](Model& m) { m.joints[0].share = 0; }, "joint 'pin'", "share is 0"},
        Bad{"NoShareLength", [](Model& m) { m.joints[0].share_length = -0.1; }, "joint 'pin'", "share_length is -0.1 m"},
        Bad{"Gap", [](Model& m) { m.joints[0].point_base.y() = 0.5; }, "joint 'pin'", "-0.5 m along y"},
        Bad{"Turned",
            [](Model& m) {
              m.joints[0].follower_axes = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()).toRotationMatrix();
            },
            "joint 'pin'", "rad along rot_x"},
        Bad{"Slip", [](Model& m) { m.bodies[1].v_WB.z() = 0.25; }, "joint 'pin'", "0.25 m/s along z"},
        Bad{"Spin", [](Model& m) { m.bodies[1].w_WB_B.x() = 0.5; }, "joint 'pin'", "0.5 rad/s along rot_x"},
        Bad{"Tau",
            [](Model& m) {
              m.loads[0].profile.kind = Profile::Kind::kExponential;
              m.loads[0].profile.tau = 0;
            },
            "element 'load'", "tau is 0"},
        Bad{"TableOrder", [](Model& m) { m.loads[0].profile = table({0, 1, 1}, {0, 0, 0}); }, "element 'load'",
            "do not increase"},
        Bad{"TableLength", [](Model& m) { m.loads[0].profile = table({0, 1}, {0}); }, "element 'load'", "times (2) and values (1)"},
        Bad{"TableNan", [](Model& m) { m.loads[0].profile = table({0, 1}, {0, kNan}); }, "element 'load'", "not finite"},
        Bad{"LoadBody", [](Model& m) { m.loads[0].body = -1; }, "element 'load'", "no body"},
        Bad{"LoadChannel", [](Model& m) { m.loads[0].channel = 1; }, "element 'load'", "channel does not exist"},
        Bad{"Stiffness", [](Model& m) { m.point_springs[0].stiffness = -1; }, "element 'spring'", "stiffness is -1"},
        Bad{"Damping", [](Model& m) { m.joint_springs[0].damping = kInfinity; }, "element 'drive'", "damping is inf"},
        Bad{"SpringJoint", [](Model& m) { m.joint_springs[0].joint = 1; }, "element 'drive'", "no joint"},
        Bad{"Normal", [](Model& m) { m.plane_torsions[0].normal_base.setZero(); }, "element 'torsion'", "normal"},
        Bad{"ElementTwice", [](Model& m) { m.joint_springs[0].name = "load"; }, "element 'load'", "more than one"},
        Bad{"ChannelRange", [](Model& m) { m.channels[0].minimum = 2; }, "channel 'c'", "range is [2, 1]"},
        Bad{"ChannelInitial", [](Model& m) { m.channels[0].initial = 2; }, "channel 'c'", "initial is 2"},
        Bad{"ChannelSafe", [](Model& m) { m.channels[0].safe = kNan; }, "channel 'c'", "safe is nan"},
        Bad{"SensorBody", [](Model& m) { m.sensors[0].subject = 2; }, "sensor 'gyro'", "the body that it names does not exist"},
        Bad{"SensorAxis",
            [](Model& m) {
              m.sensors[0].kind = Sensor::Kind::kDisplacement;
              m.sensors[0].axis = kRotX;
            },
            "sensor 'gyro'", "axis"},
        Bad{"Gravity", [](Model& m) { m.gravity.uniform.x() = kNan; }, "gravity", "not finite"},
        Bad{"NeverHolds", [](Model& m) { m.events[0].when.axis = kRotZ; }, "event 'release' of 'b'", "has the row rot_z"},
        Bad{"ConditionJoint", [](Model& m) { m.events[0].when.subject = 1; }, "event 'release' of 'b'", "the joint that"},
        Bad{"EmptyAll", [](Model& m) { m.events[0].when.kind = Condition::Kind::kAll; }, "event 'release' of 'b'",
            "without parts"},
        Bad{"Threshold", [](Model& m) { m.events[0].when.threshold = kNan; }, "event 'release' of 'b'", "not finite"},
        Bad{"Delay", [](Model& m) { m.events[0].delay = -1; }, "event 'release' of 'b'", "delay is -1"},
        Bad{"ActionMode", [](Model& m) { m.events[0].then[0].mode = 2; }, "event 'release' of 'b'", "sets a mode"},
        Bad{"ActionElement",
            [](Model& m) { m.events[0].then[0] = {Action::Kind::kSwitch, 4, 0, 1, 0}; }, "event 'release' of 'b'",
            "the element that"},
        Bad{"EventTwice", [](Model& m) { m.events.push_back(m.events[0]); }, "event 'release' of 'b'", "more than one"}),
    [](const auto& at) { return std::string(at.param.name); });

TEST(Validate, FindsAllMistakesAtOnce) {
  Model model = good_model();
  model.bodies[0].mass = 0;
  model.channels[0].safe = 5;
  model.events[0].delay = kNan;
  EXPECT_EQ(validate(model).size(), 3u);
}

TEST(Validate, SuggestsVelocitiesThatMatch) {
  Model model = good_model();
  model.bodies[0].w_WB_B = {0.3, 0.2, 0.5};
  const std::vector<ModelError> errors = validate(model);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_NE(errors[0].mend.find("velocity [0, 0.5, -0.4] m/s (inertial) and rate [0.3, 0.2, 0] rad/s"),
            std::string::npos)
      << errors[0].mend;
}

TEST(Validate, SurvivesIndicesThatAreNonsense) {
  Model model = good_model();
  model.joints[0].base = -7;
  model.joint_springs[0].axis = 99;
  model.sensors[0].kind = Sensor::Kind::kReaction;
  model.sensors[0].subject = 1 << 30;
  model.events[0].when.axis = -3;
  model.events[0].then[0].subject = -9;
  EXPECT_GE(validate(model).size(), 5u);
  EXPECT_EQ(validate(Model{}).size(), 1u);
}

}  // namespace
}  // namespace unlatch::test::validate_test
