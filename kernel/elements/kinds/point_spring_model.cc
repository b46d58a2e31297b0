#include <cmath>

#include "kernel/elements/kinds/point_spring.h"
#include "kernel/elements/start.h"

namespace unlatch {

void PointSpringKind::validate(const PointSpring& spring, const Check& check) {
  check.check_ends(spring.base, spring.follower);
  check.check_finite("point", spring.point_base.allFinite());
  check.check_finite("follower_point", spring.point_follower.allFinite());
  check.check_not_negative("stiffness", spring.stiffness);
  check.check_not_negative("damping", spring.damping);
  check.check_not_negative("free_length", spring.free_length);
}

PlanPointSpring PointSpringKind::compile(const PointSpring& s, ElementCompiler& compiler) {
  return {s.base,      s.follower, compiler.get_element(), s.push_only, to_vec(s.point_base), to_vec(s.point_follower),
          s.stiffness, s.damping,  s.free_length};
}

ElementStart PointSpringKind::start(const Model& model, const PointSpring& s) {
  const Effort effort = calc_start_effort<PointSpringKind>(model, s);
  ElementStart out{.kind = s.push_only ? "pusher" : "spring", .length = effort.length};
  const double stretch = out.length - s.free_length;
  if (s.push_only && stretch >= 0) return out;
  out.force = effort.size;
  out.energy = calc_stored(s.stiffness, stretch);
  out.stroke = std::abs(stretch);
  return out;
}

PointSpringForce calc_point_spring(const PointSpring& spring, const BodyState& base, const BodyState& follower,
                                   double scale) noexcept {
  const PlanPointSpring own{spring.base,
                            spring.follower,
                            kNone,
                            spring.push_only,
                            to_vec(spring.point_base),
                            to_vec(spring.point_follower),
                            spring.stiffness,
                            spring.damping,
                            spring.free_length};
  return PointSpringKind::calc_force(own, calc_body_frame(base), calc_body_frame(follower), scale);
}

}  // namespace unlatch
