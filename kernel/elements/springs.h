// Laws of springs between two bodies, each written once: forces.h applies them, energy.h accounts for them,
// unlatch/readings.h tells them, and declares their results. That of a joint's spring is calc_joint_spring() in
// unlatch/readings.h. World axes.
#pragma once

#include "kernel/joints/kinematics.h"
#include "kernel/plan/evaluation.h"
#include "unlatch/elementary.h"
#include "unlatch/readings.h"

namespace unlatch {

inline PointSpringForce calc_force(const PlanPointSpring& spring, const BodyFrame& base, const BodyFrame& follower,
                                   double scale) noexcept {
  PointSpringForce f{base.R * spring.point_base, follower.R * spring.point_follower};
  const Vec3 line = (follower.p + f.r_follower) - (base.p + f.r_base);
  f.length = norm(line);
  if (f.length == 0 || (spring.push_only && f.length >= spring.free_length)) return f;
  f.direction = (1.0 / f.length) * line;
  f.rate = dot(f.direction, (follower.v + cross(follower.w, f.r_follower)) - (base.v + cross(base.w, f.r_base)));
  f.size = -(spring.stiffness * (f.length - spring.free_length) + spring.damping * f.rate) * scale;
  f.elastic = -spring.stiffness * (f.length - spring.free_length) * scale;
  f.viscous = -spring.damping * f.rate * scale;
  if (spring.push_only && f.size < 0) {
    f.size = 0;
    f.viscous = -f.elastic;
  }
  f.acts = true;
  return f;
}

inline PlaneTorsionForce calc_force(const PlanPlaneTorsion& spring, const BodyFrame& base, const BodyFrame& follower,
                                    double scale) noexcept {
  PlaneTorsionForce f;
  const Vec3 normal = base.R * spring.normal_base, axis = follower.R * spring.axis_follower;
  const Vec3 across = cross(normal, axis);
  const double size = norm(across);
  f.angle = elementary::atan2(dot(normal, axis), size);
  if (size == 0) return f;
  f.axis = (1.0 / size) * across;
  f.rate = -dot(f.axis, follower.w - base.w);
  f.size = (spring.stiffness * f.angle + spring.damping * f.rate) * scale;
  f.acts = true;
  return f;
}

}  // namespace unlatch
