// The golden model of one-sided elements, of friction and of impulses.
#include "tests/golden/golden_models.h"
#include "tests/support/small_models.h"

namespace unlatch::test {
namespace {

OneSided between(const std::string& name, OneSided::Kind kind, double y, double z) {
  OneSided f;
  f.name = name;
  f.kind = kind;
  f.base = 0;
  f.follower = 1;
  f.point_base = {0.4, y, z};
  f.point_follower = {-0.4, y, z};
  return f;
}

std::vector<OneSided> build_forces() {
  OneSided spring = between("spring", OneSided::Kind::kPusher, 0.3, 0);
  spring.stroke = 0.05;
  spring.preload = 900;
  spring.stiffness = 8000;
  spring.damping = 20;
  spring.friction = 15;
  OneSided gas = between("gas", OneSided::Kind::kPusher, -0.3, 0.1);
  gas.stroke = 0.04;
  gas.preload = 1200;
  gas.law = OneSided::Law::kGas;
  gas.gas_length = 0.03;
  OneSided table = between("table", OneSided::Kind::kPusher, 0, 0.25);
  table.stroke = 0.06;
  table.law = OneSided::Law::kTable;
  table.travels = {0, 0.02, 0.05};
  table.forces = {300, 500, 100};
  table.guide = Eigen::Vector3d::UnitX();
  OneSided cord = between("cord", OneSided::Kind::kCord, 0, -0.3);
  cord.pulls = true;
  cord.limit = 0.7;
  cord.stiffness = 2000;
  cord.damping = 10;
  OneSided stop;
  stop.name = "stop";
  stop.joint = 0;
  stop.axis = kRotZ;
  stop.pulls = true;
  stop.limit = 0.3;
  stop.stiffness = 200;
  stop.damping = 1;
  return {spring, gas, table, cord, stop};
}

}  // namespace

Model build_pushers() {
  Model model;
  model.name = "pushers";
  model.bodies = {box("lower", 90, 12, 30, 29), box("upper", 40, 5, 9, 8), box("flap", 3, 0.05, 0.11, 0.1)};
  model.bodies[1].p_WB = {1, 0, 0};
  model.bodies[2].p_WB = {1, 0.8, 0};
  for (Body& body : model.bodies) body.v_WB = {0.1, -0.2, 0.05};
  model.gravity.uniform = {-0.3, 0.1, 0.2};
  Joint hinge;
  hinge.name = "hinge";
  hinge.base = 1;
  hinge.follower = 2;
  hinge.point_base = {0, 0.5, 0};
  hinge.point_follower = {0, -0.3, 0};
  hinge.modes = {{"hinge", kRevoluteRows}};
  Joint bolt;
  bolt.name = "bolt";
  bolt.base = 0;
  bolt.follower = 1;
  bolt.point_base = {0.5, 0, 0};
  bolt.point_follower = {-0.5, 0, 0};
  bolt.modes = {{"held", kWeldRows}, {"free", 0}};
  model.joints = {hinge, bolt};
  model.one_sided = build_forces();
  JointFriction pin;
  pin.name = "pin";
  pin.axis = kRotZ;
  pin.coefficient = 0.2;
  pin.radius = 0.02;
  pin.speed = 0.005;
  model.frictions = {pin};
  Impulse hit;
  hit.body = 2;
  hit.point = {0, 0.3, 0};
  hit.linear = {-1, 0.2, 0.1};
  hit.angular = {0, 0.01, -0.02};
  model.impulses = {hit};
  Action strike;
  strike.kind = Action::Kind::kImpulse;
  Action cut;
  cut.kind = Action::Kind::kSwitch;
  cut.subject = 3;
  const Condition load = when(Condition::Kind::kForceSize, 1, 0, 100),
                  taut = when(Condition::Kind::kOneSidedForce, 3, 0, 60);
  Condition late;
  late.kind = Condition::Kind::kAll;
  late.parts = {load, when_time(0.05)};
  model.events = {{"part", "bolt", late, 0, {act_set_mode(1, 1), strike}, false},
                  {"part", "cord", taut, 0, {cut}, false}};
  return model;
}

}  // namespace unlatch::test
