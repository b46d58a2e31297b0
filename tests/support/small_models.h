// Models of a few lines each, for tests of single facts.
#pragma once

#include "unlatch/model.h"

namespace unlatch::test {

inline constexpr RowSet kRevoluteRows = kPointRows | row_bit(kRotX) | row_bit(kRotY);  // about z
inline constexpr RowSet kWeldRows = kPointRows | kRotationRows;

inline Body box(const std::string& name, double mass, double jx, double jy, double jz) {
  Body body;
  body.name = name;
  body.mass = mass;
  body.inertia = Eigen::Vector3d(jx, jy, jz).asDiagonal();
  return body;
}

// Builds a bar of 1 m, 1 kg, held at one end by a hinge about z to the ground, or to a body of 50 kg: `turning` rad/s
// about it.
inline Model build_pendulum(bool grounded, double turning) {
  Model model;
  model.name = "pendulum";
  Joint joint;
  joint.name = "hinge";
  joint.modes = {{"hinge", kRevoluteRows}, {"locked", kWeldRows}, {"free", 0}};
  joint.point_follower = {-0.5, 0, 0};
  if (!grounded) model.bodies.push_back(box("base", 50, 20, 21, 22));
  joint.base = grounded ? kGround : 0;
  joint.follower = grounded ? 0 : 1;
  Body bar = box("bar", 1, 0.01, 1.0 / 12, 1.0 / 12);
  bar.p_WB = {0.5, 0, 0};
  bar.w_WB_B = {0, 0, turning};
  bar.v_WB = {0, 0.5 * turning, 0};
  model.bodies.push_back(bar);
  model.joints.push_back(joint);
  return model;
}

inline Condition when_time(double t) {
  Condition c;
  c.kind = Condition::Kind::kTime;
  c.threshold = t;
  return c;
}

inline Condition when(Condition::Kind kind, int subject, int axis, double threshold) {
  Condition c;
  c.kind = kind;
  c.subject = subject;
  c.axis = axis;
  c.threshold = threshold;
  return c;
}

inline Action act_set_mode(int joint, int mode) {
  Action a;
  a.kind = Action::Kind::kSetMode;
  a.subject = joint;
  a.mode = mode;
  return a;
}

inline Action act_raise(int signal) {
  Action a;
  a.kind = Action::Kind::kRaise;
  a.subject = signal;
  a.value = 1;
  return a;
}

}  // namespace unlatch::test
