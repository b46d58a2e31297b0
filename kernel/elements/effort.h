// Effort: what an element between two bodies does at one instant, whatever its kind. Kinds compute it by `calc`;
// forces, energies, readings and frequencies are generic code over it.
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/joints/coordinates.h"
#include "kernel/joints/kinematics.h"
#include "kernel/plan/evaluation.h"
#include "unlatch/readings.h"

namespace unlatch {

// A force along a line, or a torque about an axis: on the follower, and its opposite on the base.
struct Effort {
  std::int32_t base = kGround, follower = kGround;  // bodies
  bool turns = false;                               // a torque about `direction`; otherwise a force along it
  bool acts = false;                                // it is applied; false where there is no direction, for example
  Vec3 direction{0, 0, 0};                          // W, unit; of a torque about a joint's axis, its angle's gradient
  Vec3 r_base{0, 0, 0}, r_follower{0, 0, 0};        // from the bodies' origins to where a force acts, W, m
  double size = 0;                                  // on the follower along `direction`, N or N m, at its switch scale
  double length = 0, rate = 0;                      // the element's coordinate, m or rad, and its rate
  double stroke = 0;                                // that is left, m or rad, of kinds that have one
  double wound = 0, on_drum = 0;                    // of a cord: angle on its drum, rad, and length there, m
};

// Energy of an element and what becomes of it.
struct ElementEnergy {
  double potential = 0;            // stored at switch scale 1, J
  double motors = 0, dampers = 0;  // powers at the present scale, W
};

// A linear spring near the present state, for frequencies; at switch scale 1.
struct LinearSpring {
  double stiffness = 0, damping = 0;  // N/m and N s/m, or N m/rad and N m s/rad
  bool implicit = false;              // it is integrated implicitly
};

// Direction and arms of a joint's axis; of an axis of rotation the gradient of its angle (calc_angle_gradient()).
struct JointLine {
  Vec3 direction{0, 0, 0}, r_base{0, 0, 0}, r_follower{0, 0, 0};
};

// The motion that `calc` reads at a stage, a try or an instant: that of the evaluation.
struct StageMotion {
  const Instant& now;
  const Evaluation& ev;

  const PlanData& plan() const { return now.plan; }
  const State& state() const { return now.state; }
  double time() const { return now.t; }
  BodyFrame get_frame(int body) const { return get_body_frame(ev, body); }
  JointLine get_line(const PlanCoordinate& c) const {
    if (c.row >= kRotX) return {calc_angle_gradient(now.plan, now.state, ev, c)};
    const JointView view(now.plan, ev, c.joint);
    return {view.get_axis(c.row), view.get_arm(false), view.get_arm(true)};
  }
  const Implicit& implicit() const { return now.implicit; }
};

// The same at the end of a step, for readings: bodies' frames from the state, coordinates and sizes from the
// evaluation. Lines of joints are not known.
struct FinalMotion {
  const PlanData& data;
  const FinalEvaluation& kept;
  const Evaluation& ev = kept.evaluation;

  const PlanData& plan() const { return data; }
  const State& state() const { return kept.state; }
  double time() const { return data.get_time(state().header->tick); }
  BodyFrame get_frame(int body) const { return calc_body_frame(state(), body); }
  JointLine get_line(const PlanCoordinate&) const { return {}; }
  Implicit implicit() const { return {}; }
};

// Traits of an element that acts along or about an axis of a joint.
inline ElementTraits describe_in_joint(const char* kind, const Model& model, int joint, int axis) {
  ElementTraits traits{.kind = kind, .axis = axis, .angular = axis >= kRotX};
  if (joint < 0 || at(joint) >= model.joints.size()) return traits;
  traits.joint = joint;
  traits.base = model.joints[at(joint)].base;
  traits.follower = model.joints[at(joint)].follower;
  return traits;
}

// Effort along or about an axis of a joint; its size is left at 0. `x`, `rate`: the joint's coordinate and its rate.
inline Effort calc_in_joint(const auto& motion, const PlanCoordinate& coordinate, double x, double rate) {
  const PlanJoint& own = motion.plan().joints[at(coordinate.joint)];
  const JointLine line = motion.get_line(coordinate);
  return {.base = own.base,
          .follower = own.follower,
          .turns = coordinate.row >= kRotX,
          .acts = true,
          .direction = line.direction,
          .r_base = line.r_base,
          .r_follower = line.r_follower,
          .length = x,
          .rate = rate};
}

// The line to a point at `between` from another one. Points that coincide have no direction: it is 0.
struct PointLine {
  double length;
  Vec3 direction;
};
inline PointLine calc_line(const Vec3& between) {
  const double length = norm(between);
  return {length, length > 0 ? (1.0 / length) * between : Vec3{0, 0, 0}};
}

// ½ k x²
inline double calc_stored(double stiffness, double x) { return 0.5 * stiffness * x * x; }

}  // namespace unlatch
