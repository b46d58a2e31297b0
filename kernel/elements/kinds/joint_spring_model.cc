#include <cmath>

#include "kernel/elements/kinds/joint_spring.h"

namespace unlatch {

void JointSpringKind::validate(const JointSpring& spring, const Check& check) {
  check.check_joint_axis(spring.joint, spring.axis);
  check.check_finite("effort", std::isfinite(spring.effort));
  check.check_finite("rest", std::isfinite(spring.rest));
  check.check_not_negative("stiffness", spring.stiffness);
  check.check_not_negative("damping", spring.damping);
}

PlanJointSpring JointSpringKind::compile(const JointSpring& s, ElementCompiler& compiler) {
  const std::size_t number = compiler.plan.joint_springs.size();
  return {s.joint,
          s.axis,
          compiler.get_element(),
          compiler.find_coordinate(s.joint, s.axis),
          s.effort,
          s.stiffness,
          s.damping,
          s.rest,
          compiler.find_compliant(number)};
}

ElementStart JointSpringKind::start(const Model& model, const JointSpring& s) {
  const Joint& joint = model.joints[at(s.joint)];
  // Without axes of the follower the start is the zero of its angles.
  const double length = s.axis >= kRotX && !joint.follower_axes ? 0 : calc_start(model, joint, s.axis);
  return {.kind = "joint spring",
          .length = length,
          .force = calc_joint_spring(s, length, 0, 1),
          .energy = calc_stored(s.stiffness, length - s.rest),
          .stroke = s.stiffness > 0 ? std::abs(s.rest + s.effort / s.stiffness - length) : 0};
}

}  // namespace unlatch
