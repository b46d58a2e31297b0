#include <algorithm>

#include "kernel/elements/kinds/friction.h"

namespace unlatch {

void FrictionKind::validate(const JointFriction& f, const Check& check) {
  check.check_not_negative("coefficient", f.coefficient);
  check.check_positive("speed", f.speed);
  if (!check.check_joint_axis(f.joint, f.axis)) return;
  if (f.axis >= kRotX) check.check_positive("radius", f.radius);
  const Joint& joint = check.model.joints[static_cast<std::size_t>(f.joint)];
  const bool holds = std::any_of(joint.modes.begin(), joint.modes.end(), [&](const JointMode& mode) {
    return !has_row(mode.rows, f.axis) && (mode.rows & kPointRows) != 0;
  });
  if (!holds)
    check.report("no mode of joint '" + joint.name + "' leaves " + kRowNames[f.axis] + " free and holds a point",
                 "an axis along which or about which the joint moves", "axis");
}

PlanFriction FrictionKind::compile(const JointFriction& f, ElementCompiler& compiler) {
  return {f.joint,
          f.axis,
          compiler.get_element(),
          compiler.find_coordinate(f.joint, f.axis),
          f.coefficient,
          f.axis >= kRotX ? f.radius : 1.0,
          f.speed};
}

}  // namespace unlatch
